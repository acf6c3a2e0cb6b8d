//! `explain`, `doctor`, `completions` and `man`.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::json;

use arcline_client::{Client, ClientError, Mnemonic, Object, nearest};
use arcline_instruction_set::{ERRORS, Extended, FAULTS, explain as explain_error};

use super::args::{self, Completions, Doctor, Explain, Man, Subject};
use super::output::counted;
use super::{Failure, Output, Server};

/// `explain`: connects only when the subject is a tag of the server.
pub(crate) async fn explain(server: &Server, command: &Explain, output: &Output) -> Result<(), Failure> {
    match &command.what {
        Subject::Codes(err, exerr) => codes(*err, *exerr, command.instruction, output),
        Subject::Fault(kind) => {
            let fault = kind.fault();
            let text = format!(
                "{}\ncause   {}\nremedy  Remove the cause, then `arcline fault clear AXIS` and `arcline servo on AXIS`.\n        \
                 Default action: {}; see docs/FAULTS.md.",
                fault.word,
                fault.meaning,
                fault.default.word()
            );
            output.result(
                text,
                || json!({"fault": fault.word, "cause": fault.meaning, "action": fault.default.word()}),
            );
            Ok(())
        }
        Subject::Tag(tag) => {
            let client = server.connect().await.map_err(|error| needs_server(error, tag))?;
            let told = of_tag(&client, tag, command.instruction).await;
            client.close().await;
            let (err, exerr, mnemonic) = told.map_err(|error| or_a_fault(error, tag))?;
            if err == 0 {
                output.result(format!("{tag}: no error"), || json!({"tag": tag, "ERR": 0, "EXERR": 0}));
                return Ok(());
            }
            codes(err, Some(exerr), mnemonic, output)
        }
    }
}

/// Why a server is needed: the subject is neither a code nor the word of a fault.
fn needs_server(error: ClientError, tag: &str) -> Failure {
    match error {
        source @ ClientError::Connect { .. } => {
            let near = nearest(tag, FAULTS.iter().map(|fault| fault.word));
            let near = near.map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
            let hint = format!("{tag} is neither an error nor a fault{near}, and tags are read from the server");
            Failure::Hint { source, hint }
        }
        error => error.into(),
    }
}

/// An unknown tag may be the slip of a fault's word.
fn or_a_fault(error: Failure, tag: &str) -> Failure {
    match error {
        Failure::Client(ClientError::UnknownTag { name, suggestion }) => {
            let words = FAULTS.iter().map(|fault| fault.word);
            let suggestion = nearest(tag, words.chain(suggestion.as_deref()));
            ClientError::UnknownTag { name, suggestion }.into()
        }
        error => error,
    }
}

/// The contents of a control tag: ERR, EXERR, and the instruction, which is the type of an instruction tag.
async fn of_tag(client: &Client, tag: &str, given: Option<Mnemonic>) -> Result<(i16, i8, Option<Mnemonic>), Failure> {
    let reading = client.read(tag).await?;
    let control = reading.member("MotionControl").unwrap_or(&reading);
    let number = |name| control.member(name).and_then(|member| member.as_f64());
    let (Some(err), Some(exerr)) = (number("ERR"), number("EXERR")) else {
        let name = tag.to_owned();
        let (type_name, expected) = match client.tag(tag).await {
            Ok(known) if known.object() == Some(Object::Axis) => (
                known.type_name(),
                "a tag of an instruction; `arcline fault list` shows the faults of axes",
            ),
            Ok(known) => (known.type_name(), "a tag of an instruction"),
            Err(error) => return Err(error.into()),
        };
        return Err(Failure::WrongType {
            name,
            type_name,
            expected,
        });
    };
    let tags = client.browse().await?;
    let known = tags.iter().find(|one| one.name.eq_ignore_ascii_case(tag));
    let of_type = known.and_then(|one| one.type_name().parse().ok());
    // Both were read from an INT and a SINT.
    Ok((err as i16, exerr as i8, given.or(of_type)))
}

/// Without EXERR the text does not name an operand or axis.
fn codes(err: i16, exerr: Option<i8>, mnemonic: Option<Mnemonic>, output: &Output) -> Result<(), Failure> {
    let mut told = explain_error(err, exerr.unwrap_or_default(), mnemonic).ok_or(Failure::NoSuchError { err })?;
    let row = ERRORS.iter().find(|row| row.err == err);
    if let Some(row) = row.filter(|_| exerr.is_none()) {
        told.headline = format!("ERR {err} {}", row.name);
        told.concerns = match row.extended {
            Extended::Unused => None,
            _ => Some(format!("EXERR gives the detail: `arcline explain {err}/EXERR`.")),
        };
    }
    let mut text = format!("{}\ncause   {}", told.headline, told.cause);
    if let Some(concerns) = &told.concerns {
        text.push_str(&format!("\n        {concerns}"));
    }
    text.push_str(&format!("\nremedy  {}", told.remedy));
    output.result(text, || {
        json!({
            "ERR": err, "EXERR": exerr, "instruction": mnemonic.map(Mnemonic::name), "error": told.headline,
            "cause": told.cause, "concerns": told.concerns, "remedy": told.remedy,
        })
    });
    Ok(())
}

/// `doctor`: runs the command of the server, which knows its own needs.
pub(crate) fn doctor(command: &Doctor, output: &Output) -> Result<(), Failure> {
    let program = server_program();
    let mut doctor = Command::new(&program);
    doctor.arg("doctor");
    for (flag, file) in [("--config", &command.config), ("--state", &command.state)] {
        doctor.args(file.iter().flat_map(|file| [OsStr::new(flag), file.as_os_str()]));
    }
    if let Some(seconds) = command.measure {
        doctor.args(["--measure", &seconds.to_string()]);
    }
    if output.is_json() {
        doctor.arg("--json");
    }
    let ended = doctor.status().map_err(|source| Failure::at(&program, source))?;
    match ended.code() {
        Some(0) => Ok(()),
        // A signal ended it.
        code => Err(Failure::Reported {
            code: code.and_then(|code| u8::try_from(code).ok()).unwrap_or(1),
        }),
    }
}

/// `arcline-server` beside this program, or wherever the system finds it.
pub(crate) fn server_program() -> PathBuf {
    let name = format!("arcline-server{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()
        .ok()
        .map(|program| program.with_file_name(&name));
    beside
        .filter(|path| path.is_file())
        .unwrap_or_else(|| PathBuf::from(name))
}

/// `completions`: a script for a shell, on standard output.
pub(crate) fn completions(command: &Completions) {
    let mut script = Vec::new();
    clap_complete::generate(command.shell, &mut args::command(), "arcline", &mut script);
    // A reader that has gone away is no error of ours.
    let _ = std::io::stdout().write_all(&script);
}

/// `man`: the first page on standard output, or all of them into a folder.
pub(crate) fn man(command: &Man, output: &Output) -> Result<(), Failure> {
    let Some(folder) = &command.output else {
        let page = page(args::command()).map_err(|source| Failure::at(Path::new("arcline.1"), source))?;
        let _ = std::io::stdout().write_all(&page);
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|source| Failure::at(folder, source))?;
    let mut count = 0;
    let mut todo = vec![args::command()];
    while let Some(mut next) = todo.pop() {
        next.build();
        let name = next.get_display_name().unwrap_or(next.get_name()).to_owned();
        let children = next.get_subcommands().filter(|child| child.get_name() != "help");
        todo.extend(children.map(|child| {
            let whole = format!("{name}-{}", child.get_name());
            child.clone().display_name(whole)
        }));
        let path = folder.join(format!("{name}.1"));
        let written = page(next).and_then(|page| std::fs::write(&path, page));
        written.map_err(|source| Failure::at(&path, source))?;
        count += 1;
    }
    let shown = folder.display().to_string();
    output.result(
        format!("{shown}: {}", counted(count, "page")),
        || json!({"folder": shown, "pages": count}),
    );
    Ok(())
}

fn page(command: clap::Command) -> std::io::Result<Vec<u8>> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}
