//! The user guide, run as it is: this module writes its files, runs its commands, and compares their output with the pages.
//!
//! In a page a block ```` ```LANGUAGE FILE ```` is a file; in a block of `console` a line `$ COMMAND` is run in the folder of these files,
//! and the lines below it are its output, in which `…` stands for any text. `arcline-server … &` is a server for the commands after
//! it.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::programs;
use crate::python::Python;
use crate::server::{Server, said};

/// Writes the files of a page and gives its commands. A page of commands of the project's own programs needs no Python.
///
/// # Panics
/// When a command prints other text than the page shows.
pub fn run(page: &str, python: Option<&Python>) {
    let text = std::fs::read_to_string(crate::workspace().join("docs").join(page)).expect("pages can be read");
    let folder = tempfile::tempdir().expect("a folder");
    let mut server: Option<Server> = None;
    let mut count = 0;
    for (info, block) in blocks(&text) {
        if let Some((_, name)) = info.split_once(' ') {
            std::fs::write(folder.path().join(name), block).expect("the folder is writable");
            continue;
        }
        if info != "console" {
            continue;
        }
        for part in block.split("$ ").skip(1) {
            let (line, shown) = part.split_once('\n').expect("a command ends its line");
            let words = shlex::split(line).expect("quotes end");
            let (program, arguments) = words.split_first().expect("a command has a word");
            if program == "arcline-server" && words.last().is_some_and(|last| last == "&") {
                server = Some(start(arguments, folder.path()));
                continue;
            }
            let mut command = match program.as_str() {
                "arcline" => Command::new(programs::arcline()),
                "arcline-server" => Command::new(programs::arcline_server()),
                "python3" => python.unwrap_or_else(|| panic!("{page} needs Python")).command(),
                other => panic!("{page} starts {other}"),
            };
            command.args(arguments).current_dir(folder.path()).stdin(Stdio::null());
            command.env("ARCLINE_SERVER_PROGRAM", programs::arcline_server());
            if let Some(server) = &server {
                command.env("ARCLINE_SERVER", server.address().to_string());
            }
            let output = command
                .output()
                .unwrap_or_else(|error| panic!("{page}: {line}: {error}"));
            let printed = [output.stdout, output.stderr].concat();
            let printed = said(&String::from_utf8_lossy(&printed));
            assert!(
                is_like(&printed, shown),
                "{page}: {line}\nprinted:\n{printed}\nshown:\n{shown}"
            );
            count += 1;
        }
    }
    assert!(count > 0, "{page} has commands");
}

/// The server of a page, on a free port; a configuration is a file of the page.
fn start(arguments: &[String], folder: &Path) -> Server {
    match arguments.iter().position(|argument| argument == "--config") {
        Some(place) => Server::start_on(&folder.join(&arguments[place + 1])),
        None => Server::start(),
    }
}

/// The text of every block of the README in that language.
///
/// # Panics
/// When the README cannot be read.
#[must_use]
pub fn readme_blocks(language: &str) -> Vec<String> {
    let text = std::fs::read_to_string(crate::workspace().join("README.md")).expect("the README can be read");
    let blocks = blocks(&text).into_iter().filter(|(info, _)| *info == language);
    blocks.map(|(_, block)| block.to_owned()).collect()
}

/// Info strings and contents of the fenced blocks.
fn blocks(text: &str) -> Vec<(&str, &str)> {
    let mut blocks = Vec::new();
    let mut rest = text;
    while let Some((_, from)) = rest.split_once("\n```") {
        let (info, body) = from.split_once('\n').expect("a fence ends its line");
        let (block, after) = body.split_once("\n```").expect("blocks end");
        blocks.push((info, &body[..=block.len()]));
        rest = after;
    }
    blocks
}

/// Whether a text matches the displayed one, in which `…` stands for any text.
fn is_like(text: &str, shown: &str) -> bool {
    let (text, shown) = (text.trim_end(), shown.trim_end());
    let mut pieces = shown.split('…');
    let Some(mut rest) = pieces.next().and_then(|first| text.strip_prefix(first)) else {
        return false;
    };
    let mut is_open = false;
    for piece in pieces {
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
        is_open = piece.is_empty();
    }
    rest.is_empty() || is_open
}

#[cfg(test)]
mod tests {
    use super::is_like;

    #[test]
    fn shown_texts_match_the_printed_output() {
        for (text, shown, expected) in [
            ("a\n", "a\n", true),
            ("a b", "a c", false),
            ("a 12 b\n", "a … b\n", true),
            ("a 12 b", "a …", true),
            ("x Gantry y", "…Gantry…", true),
            ("a b c", "a … b", false),
            ("", "", true),
            ("more", "", false),
        ] {
            assert_eq!(is_like(text, shown), expected, "{text:?} {shown:?}");
        }
    }
}
