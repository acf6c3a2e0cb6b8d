//! Commands of `arcline` (spec/contract.md §1): arguments in, library calls, results out.
//!
//! Exit codes: 0 done; 1 an instruction erred or the server refused; 2 the command makes no sense (arguments, names,
//! programs that do not parse); 3 no connection, or it was lost; 130 interrupted with Ctrl-C.

mod args;
mod fault;
mod feed_override;
mod margin;
mod moves;
mod operands;
mod output;
mod programs;
mod status;
mod sweep;
mod tags;
mod wait;

use std::process::ExitCode;

use clap::FromArgMatches;

use arcline_client::{Client, ClientError, ProgramError};

use args::{Arguments, Command, FaultCommand};
use output::Output;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Client(#[from] ClientError),
    #[error(transparent)]
    Program(#[from] ProgramError),
    #[error("{path}: {source}")]
    File { path: String, source: std::io::Error },
    #[error("{axis} cannot have the fault {fault}: it has no drive")]
    NoSuchFault { axis: String, fault: &'static str },
    /// What has been done about it has been told already.
    #[error("interrupted")]
    Interrupted,
    /// Told already, one by one.
    #[error("{count} of the instructions erred")]
    Several { count: usize },
}

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::Client(error) | Self::Program(ProgramError::Client { source: error, .. }) => client_code(error),
            Self::Program(ProgramError::Syntax(_)) | Self::File { .. } | Self::NoSuchFault { .. } => 2,
            Self::Program(ProgramError::Runtime(_)) | Self::Several { .. } => 1,
            Self::Interrupted => 130,
        }
    }

    /// The error of the client, if it is one.
    pub(crate) fn client(&self) -> Option<&ClientError> {
        match self {
            Self::Client(error) | Self::Program(ProgramError::Client { source: error, .. }) => Some(error),
            _ => None,
        }
    }
}

fn client_code(error: &ClientError) -> u8 {
    match error {
        error if error.is_connection() => 3,
        ClientError::Motion { .. } | ClientError::Refused { .. } | ClientError::Ended { .. } => 1,
        ClientError::Deadline { .. } | ClientError::TooLarge { .. } => 1,
        _ => 2,
    }
}

/// Parses, runs, tells the outcome.
pub(crate) fn main() -> ExitCode {
    let matches = args::command().get_matches();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
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

async fn run(arguments: Arguments, output: &Output) -> Result<(), Failure> {
    if let Command::Identify(identify) = &arguments.command
        && let Some(address) = &identify.broadcast
    {
        return status::discover(address, identify.wait, output).await;
    }
    if let Command::Margin(command) = &arguments.command {
        margin::tell(command, output);
        return Ok(());
    }
    let client = Client::connect(&arguments.server).await?;
    let result = match arguments.command {
        Command::Exec(exec) => programs::exec(&client, &exec, output).await,
        Command::Run(run) => programs::run(&client, &run, output).await,
        Command::Move(command) => moves::line(&client, command, output).await,
        Command::Arc(command) => moves::arc(&client, command, output).await,
        Command::MoveAxis(command) => moves::axis(&client, command, output).await,
        Command::Jog(command) => moves::jog(&client, command, output).await,
        Command::Change(command) => moves::change(&client, command, output).await,
        Command::Override(command) => feed_override::set(&client, &command, output).await,
        Command::Hold(command) => feed_override::hold(&client, &command, output).await,
        Command::Resume(command) => feed_override::resume(&client, &command, output).await,
        Command::Fault(FaultCommand::Inject(command)) => fault::inject(&client, &command, output).await,
        Command::Fault(FaultCommand::Clear(command)) => fault::clear(&client, &command, output).await,
        Command::Fault(FaultCommand::List(command)) => fault::list(&client, &command, output).await,
        Command::Stop(command) => moves::stop(&client, command, output).await,
        Command::Home(command) => moves::home(&client, command, output).await,
        Command::Servo(command) => moves::servo(&client, command, output).await,
        Command::Status(command) => status::status(&client, &command.names, output).await,
        Command::Tags(command) => tags::tags(&client, &command, output).await,
        Command::Read(command) => tags::read(&client, &command.tags, output).await,
        Command::Write(command) => tags::write(&client, &command, output).await,
        Command::Identify(_) => status::identify(&client, output).await,
        Command::Margin(command) => {
            margin::tell(&command, output);
            Ok(())
        }
    };
    client.close().await;
    result
}
