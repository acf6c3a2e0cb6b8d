//! The user guide, run as it stands: its files are written, its commands given, and what they print is what it shows.
//!
//! In a page a block ```` ```LANGUAGE FILE ```` is a file; in a block of `console` a line `$ COMMAND` is run in the folder of these files,
//! and the lines below it are what it prints, `…` standing for anything. `arcline-server … &` is a server that the commands after
//! it talk to.

use std::path::Path;
use std::process::{Command, Stdio};

use arcline_tests::programs;
use arcline_tests::python::Python;
use arcline_tests::server::{Server, said};

#[test]
fn the_first_move() {
    run("guide/first-move.md");
}

#[test]
fn an_hmi_by_tags() {
    run("guide/pycomm3.md");
}

#[test]
fn a_test_fixture() {
    run("guide/fixture.md");
}

#[test]
fn virtual_commissioning() {
    run("guide/pick-and-place.md");
}

#[test]
fn glue_on_a_conveyor() {
    run("guide/glue.md");
}

#[test]
fn structured_text() {
    run("STRUCTURED_TEXT.md");
}

/// The page of clients names the versions that the tests fetch.
#[test]
fn clients_have_the_versions_of_their_tests() {
    let page = read("docs/CLIENTS.md");
    let mut wrong = Vec::new();
    let mut row = |client: &str, version: &str| {
        let link = format!("| [{client}](");
        let row = page.lines().find(|line| line.starts_with(&link));
        if !row.is_some_and(|row| row.split('|').nth(2).is_some_and(|cell| cell.contains(version))) {
            wrong.push(format!("{client} {version}"));
        }
    };
    for client in ["pycomm3", "pylogix", "cpppo", "cm_ethernetip", "ethernetip"] {
        let requirements = read(&format!("tests/python/requirements/{client}.txt"));
        let name = client.replace('_', "-");
        let version = requirements
            .lines()
            .find_map(|line| line.strip_prefix(&format!("{name}==")));
        row(
            &name,
            version
                .and_then(|rest| rest.split(' ').next())
                .expect("a pinned version"),
        );
    }
    let packages: serde_json::Value = serde_json::from_str(&read("tests/node/package.json")).expect("JSON");
    for (name, version) in packages["dependencies"].as_object().expect("dependencies") {
        row(name, version.as_str().expect("a pinned version"));
    }
    let manifest = read("tests/libplctag/Cargo.toml");
    let (_, version) = manifest
        .split_once("plctag-core = { version = \"=")
        .expect("a pinned version");
    row("libplctag", version.split('"').next().expect("a version ends"));
    assert!(wrong.is_empty(), "docs/CLIENTS.md lacks {wrong:?}");
}

fn read(path: &str) -> String {
    std::fs::read_to_string(arcline_tests::workspace().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn every_page_is_in_the_book_and_every_link_leads_somewhere() {
    let docs = arcline_tests::workspace().join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).expect("the summary can be read");
    let linked: Vec<&str> = summary
        .lines()
        .filter_map(|line| line.split_once("](")?.1.strip_suffix(')'))
        .collect();
    for page in &linked {
        assert!(docs.join(page).is_file(), "{page} is in the summary and not there");
        let text = std::fs::read_to_string(docs.join(page)).expect("pages can be read");
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let target = link.split('#').next().unwrap_or_default();
            let is_file = !target.is_empty() && !target.contains(':') && !target.contains(char::is_whitespace);
            let beside = docs.join(page).with_file_name(target);
            assert!(
                !is_file || beside.exists(),
                "{page} links to {target}, which is not there"
            );
        }
    }
    for folder in ["", "guide/", "spec/"] {
        for file in std::fs::read_dir(docs.join(folder)).expect("the folder can be read") {
            let name = file.expect("an entry").file_name().into_string().expect("UTF-8");
            let page = format!("{folder}{name}");
            assert!(
                !page.ends_with(".md") || page == "SUMMARY.md" || linked.contains(&page.as_str()),
                "{page} is not in SUMMARY.md"
            );
        }
    }
}

/// Writes the files of a page and gives its commands.
fn run(page: &str) {
    let path = arcline_tests::workspace().join("docs").join(page);
    let text = std::fs::read_to_string(path).expect("pages can be read");
    let python = match Python::with("pycomm3") {
        Ok(python) => Some(python),
        Err(why) if text.contains("\n$ python3 ") => return arcline_tests::not_run(page, &why),
        Err(_) => None,
    };
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
            let words = words(line);
            let (program, arguments) = words.split_first().expect("a command has a word");
            if program == "arcline-server" && words.last().is_some_and(|last| last == "&") {
                server = Some(start(arguments, folder.path()));
                continue;
            }
            let mut command = match program.as_str() {
                "arcline" => Command::new(programs::arcline()),
                "arcline-server" => Command::new(programs::arcline_server()),
                "python3" => python.as_ref().expect("the page was found to need Python").command(),
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

/// A line of shell, taken apart at blanks outside single quotes.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for character in line.chars() {
        match character {
            '\'' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            other => words.last_mut().expect("there is always one").push(other),
        }
    }
    words
}

/// Whether a text is the one that is shown, in which `…` stands for anything.
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

#[test]
fn shown_texts_stand_for_what_is_printed() {
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
