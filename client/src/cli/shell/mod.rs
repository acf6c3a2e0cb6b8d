//! `shell`: the commands of the program, one a line, over one connection, with history and completion; a line that is
//! Structured Text is executed or run.
//!
//! `complete` finds completions, `line` reads the terminal.

mod complete;
mod line;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::FromArgMatches;

use arcline_client::{Client, ClientError, Mnemonic, Tag};

use super::args::{self, Arguments, Command, Exec, Shell, Waiting};
use super::output::printable;
use super::{Failure, Output, Server, connect, local, on_machine, programs, wait, without_server};
use complete::{Known, OWN};
use line::{Lines, Read};

/// Longest silence towards the server while a line is written.
const SILENCE: Duration = Duration::from_secs(30);

/// `shell`.
pub(crate) async fn shell(server: &Server, command: &Shell, output: &Output) -> Result<(), Failure> {
    let mut client = connect(server, None).await?;
    let is_interactive = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    let known = known(&client).await?;
    let history = history(command.history.as_deref()).filter(|_| is_interactive);
    let mut lines = Lines::new(known, history.as_deref(), is_interactive).map_err(Failure::Terminal)?;
    if is_interactive {
        let (address, identity) = client.identify().await?;
        output.note(&format!(
            "{} at {address}. Tab completes, `help` lists the commands, `exit` ends.",
            identity.name()
        ));
    }
    loop {
        let (text, back) = next(&client, lines).await?;
        lines = back;
        let text = match text {
            Read::Line(text) => text,
            Read::Again => continue,
            Read::End => break,
        };
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') || text.starts_with("//") {
            continue;
        }
        if text == OWN[0] || text == "quit" {
            break;
        }
        if let Err(failure) = run(&client, server, text, output).await {
            output.failure(&failure);
            if !is_interactive {
                client.close().await;
                return Err(Failure::Reported { code: failure.code() });
            }
            if failure.client().is_some_and(ClientError::is_connection) {
                match connect(server, None).await {
                    Ok(again) => {
                        output.note("connected again");
                        client = again;
                    }
                    Err(error) => output.failure(&error.into()),
                }
            }
        }
        // Tags that the line created can be completed.
        if is_interactive && let Ok(tags) = client.browse().await {
            lines.set_tags(completable(tags));
        }
    }
    client.close().await;
    Ok(())
}

/// The next line. Meanwhile a request now and then shows the server that this client is alive.
async fn next(client: &Client, lines: Lines) -> Result<(Read, Lines), Failure> {
    let mut reading = tokio::task::spawn_blocking(move || lines.next());
    loop {
        tokio::select! {
            read = &mut reading => {
                let (read, lines) = read.map_err(|error| Failure::Terminal(std::io::Error::other(error)))?;
                return Ok((read.map_err(Failure::Terminal)?, lines));
            }
            // The next command reports a lost server.
            () = tokio::time::sleep(SILENCE) => drop(client.identify().await),
            () = wait::interrupted() => return Err(Failure::Interrupted),
        }
    }
}

async fn known(client: &Client) -> Result<Known, Failure> {
    let mut command = args::command();
    command.build();
    let tags = completable(client.browse().await?);
    Ok(Known { command, tags })
}

/// The tags whose names control no terminal.
fn completable(mut tags: Vec<Tag>) -> Vec<Tag> {
    tags.retain(|tag| printable(&tag.name) == tag.name);
    tags
}

/// One line: a command, a call, or a piece of a program.
async fn run(client: &Client, server: &Server, text: &str, output: &Output) -> Result<(), Failure> {
    match kind(text) {
        Kind::Call => {
            let exec = Exec {
                call: text.to_owned(),
                waiting: Waiting::default(),
            };
            return programs::exec(client, &exec, output).await;
        }
        Kind::Program => return programs::text(client, text, output).await,
        Kind::Command => {}
    }
    let words = shlex::split(text).ok_or_else(|| Failure::Usage("a quote has no end".to_owned()))?;
    let matches = args::command().try_get_matches_from(std::iter::once("arcline".to_owned()).chain(words));
    let parsed = matches.and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        // Requested help is no failure.
        Err(told) if !told.use_stderr() => {
            let _ = told.print();
            return Ok(());
        }
        Err(error) => return Err(Failure::Usage(error.to_string().trim_end().to_owned())),
    };
    let output = Output::new(output.is_json() || arguments.json);
    let command = match arguments.command {
        Command::Shell(_) => return Err(Failure::Usage("the shell is this one".to_owned())),
        Command::Local(command) => return local(server, &command, &output).await,
        Command::Machine(command) => command,
    };
    match without_server(&command, &output).await {
        Some(done) => done,
        None => on_machine(client, command, &output).await,
    }
}

/// The kind of a line.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Command,
    Call,
    Program,
}

fn kind(text: &str) -> Kind {
    let end = text
        .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
        .unwrap_or(text.len());
    let (word, rest) = text.split_at(end);
    let is_called = rest.trim_start().starts_with('(');
    let statements = text.trim_end().trim_end_matches(';').contains(';');
    if is_called && word.parse::<Mnemonic>().is_ok() && !statements {
        Kind::Call
    } else if is_called || text.contains(":=") || statements {
        Kind::Program
    } else {
        Kind::Command
    }
}

/// The file of the history; `None`: no file.
fn history(given: Option<&str>) -> Option<PathBuf> {
    match given {
        Some(off) if off.eq_ignore_ascii_case("off") => None,
        Some(file) => Some(PathBuf::from(file)),
        None => {
            let absolute = |name| {
                std::env::var_os(name)
                    .map(PathBuf::from)
                    .filter(|path| path.is_absolute())
            };
            let state = absolute("XDG_STATE_HOME").or_else(|| Some(absolute("HOME")?.join(".local/state")))?;
            Some(state.join(Path::new("arcline/history")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_told_apart() {
        for (text, expected) in [
            ("move CS1 1,2", Kind::Command),
            ("exec 'MSO(X, M1)'", Kind::Command),
            ("MSO(X, M1)", Kind::Call),
            ("mso (X, M1);", Kind::Call),
            ("MSO(X, M1); WAIT(M1.DN);", Kind::Program),
            ("WAIT(X.MoveStatus = 0);", Kind::Program),
            ("Speed := 5;", Kind::Program),
            ("MCLN(CS1)", Kind::Program),
            ("write Label 'a'", Kind::Command),
        ] {
            assert_eq!(kind(text), expected, "{text}");
        }
    }
}
