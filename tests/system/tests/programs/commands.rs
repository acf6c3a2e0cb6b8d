//! `docs/COMMANDS.md`: every command of both programs with its arguments and options, from their own help. `UPDATE_EXPECT=1` writes the page.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use arcline_system_tests::programs;

const HEAD: &str = "# Commands

<!-- A test writes this page from the help of the programs (tests/system/tests/programs/commands.rs). -->

The output of `-h` for each command. `--help` instead of `-h` explains some options at more length. The options for the connection to a server are the same
for every command of `arcline`; they stand once.
";

/// The help of a command.
fn help(program: &Path, command: &[String]) -> String {
    let mut process = Command::new(program);
    // The text depends on nothing of this computer.
    process.env_clear().args(command).arg("-h");
    let output = process.output().expect("it was just built");
    assert!(output.status.success(), "{command:?}: {output:?}");
    String::from_utf8(output.stdout).expect("text")
}

/// The names of the commands in a help.
fn commands(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    lines
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .filter(|name| !name.is_empty() && *name != "help")
        .map(str::to_owned)
        .collect()
}

/// Writes a command and those below it.
fn describe(page: &mut String, program: &Path, command: &mut Vec<String>) {
    let help = help(program, command);
    let name = program.file_name().and_then(|name| name.to_str()).expect("a name");
    let depth = "#".repeat(2 + command.len());
    let title = [name].into_iter().chain(command.iter().map(String::as_str));
    let title = title.collect::<Vec<_>>().join(" ");
    // The options of the connection are those of the program.
    let parts = help.trim_end().split("\n\n");
    let shown = parts.filter(|part| command.is_empty() || !part.starts_with("Connection:"));
    let shown = shown.collect::<Vec<_>>().join("\n\n");
    let _ = write!(page, "\n{depth} {title}\n\n```text\n{shown}\n```\n");
    for name in commands(&help) {
        command.push(name);
        describe(page, program, command);
        command.pop();
    }
}

#[test]
fn the_page_of_the_commands_is_that_of_the_programs() {
    let mut page = HEAD.to_owned();
    for program in [programs::arcline(), programs::arcline_server()] {
        describe(&mut page, program, &mut Vec::new());
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/COMMANDS.md");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&file, page).expect("the page can be written");
        return;
    }
    let written = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        written == page,
        "docs/COMMANDS.md is old: run the test with UPDATE_EXPECT=1"
    );
}
