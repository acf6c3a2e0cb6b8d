//! The README's examples, run as they stand: what it shows is what happens.

use std::time::Duration;

use arcline_instruction_set::Mnemonic;
use arcline_tests::command_line::arcline;
use arcline_tests::eventually;
use arcline_tests::programs;
use arcline_tests::python::Python;
use arcline_tests::server::Server;

fn readme() -> String {
    std::fs::read_to_string(arcline_tests::workspace().join("README.md")).expect("the README can be read")
}

/// The text of the first block of that language.
fn block(language: &str) -> String {
    let found = blocks(language).into_iter().next();
    found.unwrap_or_else(|| panic!("a block of {language}"))
}

/// The text of every block of that language.
fn blocks(language: &str) -> Vec<String> {
    let text = readme();
    let begin = format!("```{language}\n");
    text.split(&begin)
        .skip(1)
        .map(|rest| rest.split_once("```").expect("blocks end").0.to_owned())
        .collect()
}

#[test]
fn the_tour_with_pycomm3() {
    let python = match Python::with("pycomm3") {
        Ok(python) => python,
        Err(why) => return arcline_tests::not_run("the README's tour with pycomm3", &why),
    };
    let server = Server::start();
    let program = block("python").replace("\"127.0.0.1\"", &format!("\"{}\"", server.address()));
    let file = programs::target_directory().join(format!("readme-{}.py", std::process::id()));
    std::fs::write(&file, program).expect("the target folder is writable");
    let printed = python.run(file.to_str().expect("the target folder's name is UTF-8"), &[]);
    let shown = block("text");
    // Positions on the way depend on the moment; the first line and the last two do not.
    let (printed, shown): (Vec<&str>, Vec<&str>) = (printed.lines().collect(), shown.lines().collect());
    assert_eq!(printed[0], shown[0]);
    assert_eq!(printed[printed.len() - 2..], shown[shown.len() - 2..]);
}

#[test]
fn the_tour_with_the_command_line() {
    let server = Server::start();
    let mut code = None;
    let text: String = blocks("console").concat();
    for part in text.split("$ ").skip(1) {
        let (line, shown) = part.split_once('\n').expect("a command ends its line");
        let arguments = words(line);
        match arguments[0].as_str() {
            "arcline" => {
                let arguments: Vec<&str> = arguments[1..].iter().map(String::as_str).collect();
                // A servo settles a moment after its command.
                code = eventually(line, Duration::from_secs(20), || {
                    let outcome = arcline(server.address(), &arguments);
                    let printed = format!("{}{}", outcome.stdout, outcome.stderr);
                    let settling = arguments.contains(&"status") && printed != shown;
                    assert!(
                        settling || printed == shown,
                        "{line}\nprinted:\n{printed}\nthe README shows:\n{shown}"
                    );
                    (!settling).then_some(outcome.code)
                });
            }
            "echo" => assert_eq!(code.map(|code| format!("{code}\n")).as_deref(), Some(shown)),
            other => panic!("the README starts {other}"),
        }
    }
}

/// The table of groups names every instruction of the catalogue once.
#[test]
fn every_instruction_is_in_the_table_of_groups() {
    let text = readme();
    let (_, table) = text
        .split_once("| group | instructions | status |")
        .expect("the table is there");
    let (table, _) = table.split_once("\n\n").expect("the table ends");
    let cells: Vec<&str> = table.lines().filter_map(|row| row.split('|').nth(2)).collect();
    let mut named: Vec<&str> = cells.iter().flat_map(|cell| cell.split(',')).map(str::trim).collect();
    named.retain(|name| name.starts_with('M'));
    let mut known: Vec<&str> = Mnemonic::ALL.iter().map(|mnemonic| mnemonic.name()).collect();
    named.sort_unstable();
    known.sort_unstable();
    assert_eq!(named, known);
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
