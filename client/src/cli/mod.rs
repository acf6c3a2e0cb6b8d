//! Commands of `arcline` (spec/contract.md §1): arguments in, library calls, results out.
//!
//! Exit codes: 0 done; 1 an instruction erred or the server refused; 2 the command makes no sense (arguments, names,
//! programs that do not parse); 3 no connection, or it was lost; 130 interrupted with Ctrl-C.

mod args;
mod diff;
mod fault;
mod feed_override;
mod gcode;
mod identify;
mod inhibit;
mod margin;
mod mode;
mod moves;
mod operands;
mod output;
mod plot;
mod programs;
mod rests;
mod server;
mod shell;
mod status;
mod sweep;
mod tags;
mod tools;
mod trace;
mod wait;
mod watch;

use std::path::Path;
use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgMatches, FromArgMatches};

use arcline_client::{Client, ClientError, Ended, Identification, Mnemonic, ProgramError};

use args::{Arguments, Command, FaultCommand, LocalCommand, MachineCommand};
use output::Output;
use server::Server;

/// The reason for which a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Client(#[from] ClientError),
    #[error(transparent)]
    Program(#[from] ProgramError),
    #[error("{path}: {source}")]
    File { path: String, source: std::io::Error },
    #[error("{path}: {source}")]
    Gcode {
        path: String,
        source: arcline_gcode::GcodeError,
    },
    /// A move of a G-code program was refused.
    #[error("{path}: line {line}: {source}")]
    Move {
        path: String,
        line: usize,
        source: ProgramError,
    },
    #[error("{path}: {source}")]
    Plot {
        path: String,
        source: arcline_plot::PlotError,
    },
    /// Two traces are not the same.
    #[error("{what}; {differences} numbers differ, by {greatest} at most")]
    Differs {
        what: String,
        differences: usize,
        greatest: f64,
    },
    /// `arcline-server simulate` failed, with its message.
    #[error("{said}")]
    Simulate { said: String, code: u8 },
    #[error("there is no ERR {err}; docs/ERRORS.md lists them")]
    NoSuchError { err: i16 },
    #[error("the terminal: {0}")]
    Terminal(std::io::Error),
    /// The shell has reported it.
    #[error("a line of the shell failed")]
    Reported { code: u8 },
    /// The message of clap about the arguments of a line of the shell.
    #[error("{0}")]
    Usage(String),
    /// A tag of another type than the command is about.
    #[error("{name} has the type {type_name}, expected {expected}")]
    WrongType {
        name: String,
        type_name: String,
        expected: &'static str,
    },
    /// An error of one of several instructions.
    #[error("{target}: {source}")]
    On { target: String, source: ClientError },
    /// An error of a request, with a hint.
    #[error("{source}: {hint}")]
    Hint { source: ClientError, hint: String },
    /// A motion without an end of its own, such as a jog, was not ended by an instruction.
    #[error("{mnemonic} {target}: {ended}")]
    Ended {
        mnemonic: Mnemonic,
        target: String,
        ended: Box<Ended>,
    },
    #[error("{axis} cannot have the fault {fault}: it has no drive")]
    NoSuchFault { axis: String, fault: &'static str },
    /// Reported already, with the stop.
    #[error("interrupted")]
    Interrupted,
    /// Reported already, one by one.
    #[error("{count} of the instructions erred")]
    Several { count: usize },
}

impl Failure {
    /// A file that cannot be read or written.
    pub(crate) fn at(path: &Path, source: std::io::Error) -> Self {
        Self::File {
            path: path.display().to_string(),
            source,
        }
    }

    fn code(&self) -> u8 {
        match self {
            Self::Client(error) | Self::Hint { source: error, .. } | Self::On { source: error, .. } => {
                client_code(error)
            }
            Self::Program(ProgramError::Client { source: error, .. }) => run_code(error),
            Self::Program(ProgramError::Syntax(_)) | Self::File { .. } | Self::NoSuchFault { .. } => 2,
            Self::Move {
                source: ProgramError::Client { source, .. },
                ..
            } => run_code(source),
            Self::Move {
                source: ProgramError::Runtime(_) | ProgramError::Hopeless(_),
                ..
            } => 1,
            Self::Gcode { .. } | Self::Move { .. } | Self::Plot { .. } => 2,
            Self::Simulate { code, .. } => *code,
            Self::NoSuchError { .. } | Self::Terminal(_) | Self::Usage(_) | Self::WrongType { .. } => 2,
            Self::Program(ProgramError::Runtime(_) | ProgramError::Hopeless(_)) | Self::Several { .. } => 1,
            Self::Ended { .. } | Self::Differs { .. } => 1,
            Self::Interrupted => 130,
            Self::Reported { code } => *code,
        }
    }

    /// The cause that ended the motion, where the server says so.
    pub(crate) fn ended(&self) -> Option<&Ended> {
        match (self, self.client()) {
            (Self::Ended { ended, .. }, _) => Some(ended),
            (_, Some(ClientError::Ended { ended, .. })) => ended.as_deref(),
            _ => None,
        }
    }

    /// The error of the client, if it is one.
    pub(crate) fn client(&self) -> Option<&ClientError> {
        match self {
            Self::Client(error)
            | Self::Hint { source: error, .. }
            | Self::On { source: error, .. }
            | Self::Program(ProgramError::Client { source: error, .. }) => Some(error),
            Self::Move {
                source: ProgramError::Client { source: error, .. },
                ..
            } => Some(error),
            _ => None,
        }
    }
}

/// The code of an error that ends a program which runs: 2 would say that nothing of it was executed.
fn run_code(error: &ClientError) -> u8 {
    match client_code(error) {
        2 => 1,
        code => code,
    }
}

fn client_code(error: &ClientError) -> u8 {
    match error {
        error if error.is_connection() => 3,
        ClientError::Motion { .. }
        | ClientError::MissingOperand { .. }
        | ClientError::Refused { .. }
        | ClientError::Ended { .. } => 1,
        ClientError::Deadline { .. } | ClientError::TooLarge { .. } => 1,
        _ => 2,
    }
}

/// Parses the arguments, runs the command and reports the outcome, in print and as the exit code.
pub fn main() -> ExitCode {
    let matches = args::command().get_matches();
    let mut arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    arguments.server = server(&matches, arguments.server);
    let output = Output::new(arguments.json);
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => {
            output.failure(&Failure::Client(ClientError::Connect {
                address: arguments.server,
                source: error,
            }));
            return ExitCode::from(3);
        }
    };
    match runtime.block_on(run(arguments, &output)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output.failure(&failure);
            ExitCode::from(failure.code())
        }
    }
}

/// The server: the argument, else the variable. As an argument's `env`, the variable would put `--server` into the usage of
/// every error.
fn server(matches: &ArgMatches, given: String) -> String {
    match std::env::var("ARCLINE_SERVER") {
        Ok(server) if matches.value_source("server") == Some(ValueSource::DefaultValue) => server,
        _ => given,
    }
}

async fn run(arguments: Arguments, output: &Output) -> Result<(), Failure> {
    let server = Server::new(arguments.server, &arguments.tls)?;
    let command = match arguments.command {
        Command::Shell(command) => return shell::shell(&server, &command, output).await,
        Command::Local(command) => return local(&server, &command, output).await,
        Command::Machine(command) => command,
    };
    if let Some(done) = without_server(&command, output).await {
        return done;
    }
    let client = connect(&server, command.program()).await?;
    let result = on_machine(&client, command, output).await;
    client.close().await;
    result
}

/// A client that has sent the server the product, the user and the program, which it shows beside all motion that this client begins.
async fn connect(server: &Server, program: Option<&str>) -> Result<Client, ClientError> {
    let client = server.connect().await?;
    let user = ["USER", "LOGNAME", "USERNAME"].map(std::env::var);
    let identification = Identification {
        product: concat!("arcline ", env!("CARGO_PKG_VERSION")).to_owned(),
        user: user.into_iter().flatten().next().unwrap_or_default(),
        program: program.unwrap_or_default().to_owned(),
    };
    client.introduce(&identification).await?;
    Ok(client)
}

impl MachineCommand {
    /// The name of the program that it runs.
    fn program(&self) -> Option<&str> {
        let file = match self {
            Self::Run(run) => Path::new(&run.file),
            Self::Gcode(gcode) => Path::new(&gcode.file),
            _ => return None,
        };
        file.file_name()?.to_str()
    }
}

/// The commands that need no server.
async fn local(server: &Server, command: &LocalCommand, output: &Output) -> Result<(), Failure> {
    match command {
        LocalCommand::Explain(command) => return tools::explain(server, command, output).await,
        LocalCommand::Doctor(command) => return tools::doctor(command, output),
        LocalCommand::Completions(command) => tools::completions(command),
        LocalCommand::Man(command) => return tools::man(command, output),
        LocalCommand::Plot(command) => return plot::plot(command, output),
        LocalCommand::Diff(command) => return diff::diff(command, output),
        LocalCommand::Margin(command) => margin::print(command, output),
    }
    Ok(())
}

/// The forms of a command that need no connection: a broadcast, and a G-code program that is simulated or written down. `None` for
/// all others.
async fn without_server(command: &MachineCommand, output: &Output) -> Option<Result<(), Failure>> {
    match command {
        MachineCommand::Identify(command) if command.broadcast.is_some() => {
            Some(identify::run(None, command, output).await)
        }
        MachineCommand::Gcode(command) if !command.needs_server() => Some(gcode::without_server(command, output)),
        _ => None,
    }
}

/// The commands that ask one server over one connection.
async fn on_machine(client: &Client, command: MachineCommand, output: &Output) -> Result<(), Failure> {
    match command {
        MachineCommand::Exec(exec) => programs::exec(client, &exec, output).await,
        MachineCommand::Run(run) => programs::run(client, &run, output).await,
        MachineCommand::Move(command) => moves::line(client, command, output).await,
        MachineCommand::Arc(command) => moves::arc(client, command, output).await,
        MachineCommand::MoveAxis(command) => moves::axis(client, command, output).await,
        MachineCommand::Jog(command) => moves::jog(client, command, output).await,
        MachineCommand::Change(command) => moves::change(client, command, output).await,
        MachineCommand::Override(command) => feed_override::set(client, &command, output).await,
        MachineCommand::Hold(command) => feed_override::hold(client, &command, output).await,
        MachineCommand::Resume(command) => feed_override::resume(client, &command, output).await,
        MachineCommand::Fault(FaultCommand::Inject(command)) => fault::inject(client, &command, output).await,
        MachineCommand::Fault(FaultCommand::Clear(command)) => fault::clear(client, &command, output).await,
        MachineCommand::Fault(FaultCommand::List(command)) => fault::list(client, &command, output).await,
        MachineCommand::Stop(command) if command.hold => inhibit::inhibit(client, output).await,
        MachineCommand::Stop(command) => moves::stop(client, command, output).await,
        MachineCommand::Release => inhibit::release(client, output).await,
        MachineCommand::Mode(command) => mode::mode(client, &command, output).await,
        MachineCommand::Home(command) => moves::home(client, command, output).await,
        MachineCommand::Servo(command) => moves::servo(client, command, output).await,
        MachineCommand::Status(command) => status::status(client, &command.of.names, output).await,
        MachineCommand::Watch(command) => watch::watch(client, &command, output).await,
        MachineCommand::Tags(command) => tags::tags(client, &command, output).await,
        MachineCommand::Read(command) => tags::read(client, &command.tags, output).await,
        MachineCommand::Write(command) => tags::write(client, &command, output).await,
        MachineCommand::Trace(command) => trace::trace(client, &command, output).await,
        MachineCommand::Gcode(command) => gcode::run(client, &command, output).await,
        MachineCommand::Identify(command) => identify::run(Some(client), &command, output).await,
    }
}
