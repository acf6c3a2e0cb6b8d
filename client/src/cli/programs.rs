//! `exec` and `run`: Structured Text against a live server.

use indicatif::ProgressBar;
use serde_json::json;

use arcline_client::{Client, Ended, Event, OnError, Runner};
use arcline_instruction_set::Ending;

use super::args::{Exec, Run};
use super::output::counted;
use super::wait::{self, StopCommand};
use super::{Failure, Output, moves};

/// `exec`: executes, waits for moves and stops, prints how the instruction stands.
pub(crate) async fn exec(client: &Client, command: &Exec, output: &Output) -> Result<(), Failure> {
    let mut runner = Runner::call(client, &command.call).await?;
    runner.run(&mut |_| {}).await.map_err(without_line)?;
    let Some((_, execution)) = runner.executions().next() else {
        return Ok(());
    };
    let completed = if command.waiting.no_wait || !moves::is_waited_for(execution) {
        execution.control.into()
    } else {
        wait::complete(client, execution, None, output).await?
    };
    output.completed(execution, &completed);
    Ok(())
}

/// The error of one call, without the number of its only line.
fn without_line(error: arcline_client::ProgramError) -> Failure {
    match error {
        arcline_client::ProgramError::Client { source, .. } => Failure::Client(source),
        other => Failure::Program(other),
    }
}

/// `run`.
pub(crate) async fn run(client: &Client, command: &Run, output: &Output) -> Result<(), Failure> {
    let text = std::fs::read_to_string(&command.file).map_err(|source| Failure::File {
        path: command.file.clone(),
        source,
    })?;
    let on_error = if command.keep_going {
        OnError::KeepGoing
    } else {
        OnError::Stop
    };
    let runner = Runner::program(client, &text).await?;
    let runner = runner.queue_full(command.queue_full.into()).on_error(on_error);
    let how = How {
        keep_going: command.keep_going,
        no_wait: command.waiting.no_wait,
        lines: text.lines().count(),
    };
    to_its_end(client, runner, &command.file, how, output).await
}

/// A piece of a program, as a line of the shell: run until all it began has ended.
pub(crate) async fn text(client: &Client, text: &str, output: &Output) -> Result<(), Failure> {
    let runner = Runner::program(client, text).await?;
    to_its_end(client, runner, "line", How::default(), output).await
}

fn is_fault(ended: &Ended) -> bool {
    matches!(ended.ending, Ending::Fault { .. })
}

/// Conditions that end a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct How {
    /// Errors do not.
    pub(crate) keep_going: bool,
    /// The end of the text, not of the motion.
    pub(crate) no_wait: bool,
    /// Lines of the program, for the progress of a long one.
    pub(crate) lines: usize,
}

impl How {
    /// The progress by lines: on a terminal, for a program whose instructions are too many to be shown one by one.
    fn progress(&self, output: &Output) -> ProgressBar {
        if self.lines <= MOST_NOTED_LINES {
            return ProgressBar::hidden();
        }
        output.bar(
            self.lines as u64,
            "{bar:30} {percent} %  line {human_pos} of {human_len}  {elapsed}",
        )
    }
}

/// Runs the program `name`, reports its instructions, and stops its motion on Ctrl-C.
pub(crate) async fn to_its_end(
    client: &Client,
    mut runner: Runner<'_>,
    name: &str,
    how: How,
    output: &Output,
) -> Result<(), Failure> {
    let (mut executed, mut erred) = (0, 0);
    let progress = how.progress(output);
    let note = |text: &str| progress.suspend(|| output.note(text));
    let mut on_event = |event: Event<'_>| match event {
        Event::Executed { line, execution } => {
            executed += 1;
            if output.is_json() {
                output.result("", || {
                    json!({
                        "line": line, "instruction": execution.mnemonic.name(), "target": execution.target,
                        "instance": execution.instance, "ERR": 0, "EXERR": 0,
                    })
                });
            } else if progress.is_hidden() && output.is_watched() {
                output.note(&format!("line {line}: {} {}", execution.mnemonic, execution.target));
            }
        }
        // A move is executed up to a whole queue before it moves.
        Event::Completed { line } => progress.set_position(line as u64),
        // A fault also ends the program, whose end reports it.
        Event::Ended { line, execution, ended } if how.keep_going || !is_fault(ended) => {
            let (mnemonic, target) = (execution.mnemonic, &execution.target);
            note(&format!("line {line}: {mnemonic} {target} was {ended}"));
        }
        Event::Ended { .. } => {}
        Event::Erred {
            line,
            mnemonic,
            target,
            error,
        } => {
            erred += 1;
            // The end of the program reports the error that ended it.
            if how.keep_going {
                let (err, exerr) = error.motion().unwrap_or_default();
                note(&format!("line {line}: {mnemonic} {target}: {error}"));
                if output.is_json() {
                    output.result("", || {
                        json!({
                            "line": line, "instruction": mnemonic.name(), "target": target,
                            "error": error.to_string(), "ERR": err, "EXERR": exerr,
                        })
                    });
                }
            }
        }
    };
    let result = tokio::select! {
        result = async {
            runner.run(&mut on_event).await?;
            if how.no_wait { Ok(()) } else { runner.finish(&mut on_event).await }
        } => Some(result),
        () = wait::interrupted() => None,
    };
    progress.finish_and_clear();
    match result {
        Some(result) => result?,
        None => {
            let targets = runner.targets().into_iter();
            let stops = targets.filter_map(|(object, target)| StopCommand::all(object, target));
            return Err(wait::interrupt(client, stops, output).await);
        }
    }
    output.result(
        format!("{name}: {} executed, {erred} erred", counted(executed, "instruction")),
        || json!({"program": name, "executed": executed, "erred": erred}),
    );
    if erred > 0 {
        Err(Failure::Several { count: erred })
    } else {
        Ok(())
    }
}

/// Lines of a program up to which each instruction is shown on a terminal.
const MOST_NOTED_LINES: usize = 200;
