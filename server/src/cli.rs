//! The command line of `arcline-server` (spec/contract.md §1). The modules `run` and `simulate`, and `arcline-config`, carry out the
//! commands.

use std::io::IsTerminal as _;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;

use arcline_config::Project;
use arcline_realtime::Clock;
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use serde_json::json;

use crate::audit::verify::{self, AuditCommand};
use crate::doctor::DoctorArgs;
use crate::health::HealthArgs;
use crate::simulate::SimulateArgs;
use crate::tls::certs::{self, CertsCommand};
use crate::users::command::{TokensCommand, UsersCommand, run_tokens, run_users};
use crate::{doctor, health, l5x, run, simulate};

/// A coordinated-motion server that looks like a Logix controller on EtherNet/IP.
#[derive(Parser, Debug)]
#[command(name = "arcline-server", version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Run the server (the default), and the program of a project beside its motion.
    Run(RunProgram),
    /// Validate a configuration and print the objects that it creates.
    Check {
        /// The configuration file.
        #[arg(long, value_name = "FILE")]
        config: PathBuf,
        /// Print the result as one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Print data for editors of configurations.
    Config {
        #[command(subcommand)]
        command: ConfigCommand,
    },
    /// Run a Structured Text program or the tasks of a project on a virtual clock, as fast as the computer can.
    Simulate(SimulateArgs),
    /// Print the embedded default configuration.
    DefaultConfig,
    /// Turn an L5X export of Studio 5000 into a configuration.
    Import(ImportArgs),
    /// Make, revoke and show the certificates of TLS.
    Certs {
        #[command(subcommand)]
        command: CertsCommand,
    },
    /// Add, change and list the users of the web page.
    Users {
        #[command(subcommand)]
        command: UsersCommand,
    },
    /// Add, remove and list the tokens by which scripts use the web page.
    Tokens {
        #[command(subcommand)]
        command: TokensCommand,
    },
    /// Check the ports, rights and real-time settings of this computer, and name each defect and its remedy.
    Doctor(DoctorArgs),
    /// Ask a server on this computer for its identity, and fail when none answers: the health check of a container.
    Health(HealthArgs),
    /// Print the completions of a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write a page for each command.
    Man {
        /// Write a page for each command into this folder and create it; by default print the first page.
        #[arg(short, long, value_name = "FOLDER")]
        output: Option<PathBuf>,
    },
    /// Check the audit.
    Audit {
        #[command(subcommand)]
        command: AuditCommand,
    },
    /// Write a configuration as L5X, which imports as the same project.
    Export(ExportArgs),
}

#[derive(Subcommand, Debug)]
enum ConfigCommand {
    /// Print the JSON Schema (draft 7) of configurations, by which editors complete and check them.
    Schema,
}

/// Flags of `run`.
#[derive(Args, Debug)]
pub(crate) struct RunArgs {
    /// Configuration file; without it the embedded default is used, and for a project its own machine.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// The address of EtherNet/IP, TCP and UDP; port 0 picks a free port. Repeat it for several addresses.
    #[arg(long, value_name = "ADDR:PORT")]
    pub(crate) listen: Vec<SocketAddr>,
    /// The address of the web page.
    #[arg(long, value_name = "ADDR:PORT|off")]
    pub(crate) hmi: Option<OrOff<SocketAddr>>,
    /// The file for positions and plain tags between runs; without it a restart loses them.
    #[arg(long, value_name = "FILE|off")]
    pub(crate) state: Option<OrOff<PathBuf>>,
    /// The folder of the audit; by default that of --state with `.audit` behind its name, where the configuration has `[security]`.
    #[arg(long, value_name = "FOLDER|off")]
    pub(crate) audit: Option<OrOff<PathBuf>>,
    /// Listen beyond this computer though the configuration has no `[security]`: clients elsewhere may look and stop.
    #[arg(long)]
    pub(crate) open_to_network: bool,
    /// The clock of the ticks: real time, steps of clients, or a multiple of real time. For tests; time-outs of the network stay real.
    #[arg(long, value_name = "real|step|fast[:N]", default_value = "real", value_parser = clock)]
    pub(crate) clock: Clock,
    /// Stop as by SIGTERM when standard input closes: a program that holds the other end takes the server along, however it ends.
    #[arg(long)]
    pub(crate) end_with_stdin: bool,
}

/// The clock of a word; `fast` is ten times real time.
fn clock(text: &str) -> Result<Clock, String> {
    let expected = || {
        format!(
            "expected real, step, fast or fast:N with a number N from {} to {}",
            FAST.start(),
            FAST.end()
        )
    };
    match text.split_once(':') {
        None if text == "real" => Ok(Clock::Real),
        None if text == "step" => Ok(Clock::Step),
        None if text == "fast" => Ok(Clock::Fast(10.0)),
        Some(("fast", times)) => match times.parse() {
            Ok(times) if FAST.contains(&times) => Ok(Clock::Fast(times)),
            _ => Err(expected()),
        },
        _ => Err(expected()),
    }
}

/// Times real time.
const FAST: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// `run`: flags, and the program of the controller.
#[derive(Args, Debug)]
pub(crate) struct RunProgram {
    /// The project of a controller whose tasks run beside the motion. Without --config the machine is the project's.
    #[arg(value_name = "PROJECT.L5X")]
    program: Option<PathBuf>,
    /// Run a project of which parts are missing or not supported: they are named and passed over.
    #[arg(long, requires = "program")]
    allow_missing: bool,
    #[command(flatten)]
    run: RunArgs,
}

/// Flags of `import`.
#[derive(Args, Debug)]
pub(crate) struct ImportArgs {
    /// The export.
    #[arg(value_name = "FILE.L5X")]
    pub(crate) file: PathBuf,
    /// The configuration to write; by default standard output.
    #[arg(short, long, value_name = "OUT.toml")]
    pub(crate) output: Option<PathBuf>,
    /// Exit with 1 when an element of the file was left out or changed.
    #[arg(long)]
    pub(crate) strict: bool,
    /// List the parts of the project's program that would not run, and write no configuration.
    #[arg(long, conflicts_with_all = ["output", "strict"])]
    pub(crate) report: bool,
    /// List it as JSON lines.
    #[arg(long, requires = "report")]
    pub(crate) json: bool,
}

/// Flags of `export`.
#[derive(Args, Debug)]
pub(crate) struct ExportArgs {
    /// Configuration file; without it the embedded default is used.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// The L5X to write; by default standard output.
    #[arg(short, long, value_name = "OUT.L5X")]
    pub(crate) output: Option<PathBuf>,
}

/// A value, or `off`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum OrOff<T> {
    Off,
    On(T),
}

impl<T: FromStr> FromStr for OrOff<T> {
    type Err = T::Err;

    fn from_str(text: &str) -> Result<Self, T::Err> {
        if text.eq_ignore_ascii_case("off") {
            Ok(OrOff::Off)
        } else {
            text.parse().map(OrOff::On)
        }
    }
}

/// An error that ends the program: one message and the exit code.
#[derive(Debug)]
pub(crate) struct Failure {
    code: u8,
    message: String,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl Failure {
    pub(crate) fn new(code: u8, message: impl Into<String>) -> Self {
        Failure {
            code,
            message: message.into(),
        }
    }

    /// An error that the user must put right first.
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Failure::new(WRONG, message)
    }
}

/// Executes the command of the command line. The exit codes are those of spec/contract.md §1.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    log();
    let result = match cli.command {
        None => run::run(&cli.run, None),
        Some(Command::Run(RunProgram {
            program,
            allow_missing,
            run,
        })) => run::run(&run, program.map(|file| (file, allow_missing))),
        Some(Command::Check { config, json: false }) => check(&config),
        Some(Command::Check { config, json: true }) => check_as_json(&config),
        Some(Command::Config {
            command: ConfigCommand::Schema,
        }) => print(&arcline_config::schema()),
        Some(Command::Simulate(args)) => simulate::simulate(&args),
        Some(Command::DefaultConfig) => print(arcline_config::DEFAULT),
        Some(Command::Import(args)) => l5x::import(&args),
        Some(Command::Export(args)) => l5x::export(&args),
        Some(Command::Certs { command }) => certs::run(&command),
        Some(Command::Users { command }) => run_users(&command),
        Some(Command::Tokens { command }) => run_tokens(&command),
        Some(Command::Doctor(args)) => doctor::run(&args),
        Some(Command::Health(args)) => health::run(&args),
        Some(Command::Completions { shell }) => completions(shell),
        Some(Command::Man { output }) => man(output.as_deref()),
        Some(Command::Audit { command }) => verify::run(&command),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("arcline-server: {}", failure.message);
            ExitCode::from(failure.code)
        }
    }
}

/// The completions of a shell, on standard output.
fn completions(shell: clap_complete::Shell) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "arcline-server", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// The manual page on standard output, or one of the program and of each command, `arcline-server-COMMAND.1`, in a folder.
fn man(folder: Option<&Path>) -> Result<ExitCode, Failure> {
    let Some(folder) = folder else {
        let mut page = Vec::new();
        let made = clap_mangen::Man::new(Cli::command()).render(&mut page);
        made.map_err(|error| Failure::new(1, error.to_string()))?;
        return print(&String::from_utf8_lossy(&page));
    };
    let written = std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(Cli::command(), folder));
    match written {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(error) => Err(Failure::new(
            WRONG,
            format!("{}: cannot be written: {error}", folder.display()),
        )),
    }
}

/// Sends the log to standard error: warnings and worse, unless `RUST_LOG` sets another level.
fn log() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .init();
}

/// Prints the objects that a configuration creates, or all its errors, one a line.
fn check(config: &Path) -> Result<ExitCode, Failure> {
    let (text, file) = read(Some(config))?;
    match arcline_config::load_all(&text, &file) {
        Ok(project) => {
            for warning in warnings(&project, config) {
                eprintln!("arcline-server: warning: {warning}");
            }
            print(&arcline_config::describe(&project))
        }
        Err(errors) => {
            for error in &errors {
                eprintln!("arcline-server: {error}");
            }
            Ok(ExitCode::from(WRONG))
        }
    }
}

/// The files of `[security]` that a server could not use. They are no errors of the configuration: the keys of a server need not be on the computer
/// that checks it.
fn warnings(project: &Project, config: &Path) -> Vec<String> {
    let folder = config.parent().unwrap_or(Path::new(""));
    doctor::defects_of_security(&project.server.security, folder)
        .map(|defect| format!("{}: {}", defect.check, defect.found))
        .collect()
}

/// Prints the objects that a configuration creates, or all its errors, as one JSON object.
fn check_as_json(config: &Path) -> Result<ExitCode, Failure> {
    let (text, file) = read(Some(config))?;
    let loaded = arcline_config::load_all(&text, &file);
    let errors = loaded.as_ref().err().into_iter().flatten();
    let errors: Vec<serde_json::Value> = errors
        .map(|error| {
            json!({
                "line": error.line,
                "column": error.column,
                "key": error.key,
                "message": error.problem.to_string(),
                "expected": error.problem.expected(),
            })
        })
        .collect();
    let creates = loaded.as_ref().ok().map(|project| {
        json!({
            "axes": project.machine.axes.len(),
            "coordinate_systems": project.machine.systems.len(),
            "transforms": project.machine.transforms.len(),
            "instruction_tags": project.instruction_tags.len(),
            "tags": project.tags.len(),
        })
    });
    let warnings = loaded
        .as_ref()
        .map_or_else(|_| Vec::new(), |project| warnings(project, config));
    print(&format!(
        "{}\n",
        json!({"file": file, "valid": loaded.is_ok(), "errors": errors, "warnings": warnings, "creates": creates})
    ))?;
    Ok(ExitCode::from(if loaded.is_ok() { 0 } else { WRONG }))
}

/// The exit code for an error that the user must correct first.
pub(crate) const WRONG: u8 = 2;

pub(crate) fn print(text: &str) -> Result<ExitCode, Failure> {
    use std::io::Write as _;
    // A reader that closed the pipe needs no more of the text.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(ExitCode::SUCCESS)
}

/// The text of a configuration file, or of the embedded default, and its name in messages.
pub(crate) fn read(config: Option<&Path>) -> Result<(String, String), Failure> {
    Ok(match config {
        None => (arcline_config::DEFAULT.to_owned(), "default configuration".to_owned()),
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .map_err(|error| Failure::usage(format!("{}: cannot be read: {error}", path.display())))?;
            (text, path.display().to_string())
        }
    })
}

/// The project of a configuration file, or of the embedded default.
pub(crate) fn project(config: Option<&Path>) -> Result<Project, Failure> {
    let (text, file) = read(config)?;
    arcline_config::load(&text, &file).map_err(|error| Failure::usage(error.to_string()))
}

pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if seconds.is_finite() && seconds >= 0.0 {
        Ok(seconds)
    } else {
        Err("expected 0 or more seconds".to_owned())
    }
}
