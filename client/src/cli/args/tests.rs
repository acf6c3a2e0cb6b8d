//! The accepted and refused command lines, and the help.

use arcline_client::{Mnemonic, WriteValue};

use super::help::instructions;
use super::*;

fn parse(line: &str) -> Result<Command, clap::Error> {
    let words = line.split_whitespace();
    let matches = command().try_get_matches_from(std::iter::once("arcline").chain(words))?;
    <Arguments as clap::FromArgMatches>::from_arg_matches(&matches).map(|arguments| arguments.command)
}

/// The examples of a command's help: the lines from `Example:` on, without their indentation.
fn examples(command: &clap::Command) -> Vec<String> {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let Some((_, examples)) = help.split_once("Example: ") else {
        return Vec::new();
    };
    examples.lines().map(|line| line.trim().to_owned()).collect()
}

#[test]
fn the_command_is_consistent() {
    command().debug_assert();
}

#[test]
fn every_help_has_examples_that_parse_as_that_command() {
    let mut whole = command();
    whole.build();
    let mut todo: Vec<(String, clap::Command)> = vec![("arcline".to_owned(), whole)];
    let mut count = 0;
    while let Some((name, one)) = todo.pop() {
        let found = examples(&one);
        assert!(!found.is_empty(), "{name} has no example");
        for example in found {
            let words = shlex::split(&example).unwrap_or_else(|| panic!("{name}: {example}"));
            // The rest of the line belongs to the shell.
            let words: Vec<String> = words
                .into_iter()
                .take_while(|word| word != ">" && word != "|")
                .collect();
            let parsed = command().try_get_matches_from(&words);
            assert!(
                parsed.is_ok(),
                "{name}: {example}: {}",
                parsed.err().map_or_else(String::new, |e| e.to_string())
            );
            assert!(example.starts_with(&name), "{example} is no example of {name}");
            count += 1;
        }
        let children = one.get_subcommands().filter(|child| child.get_name() != "help");
        todo.extend(children.map(|child| (format!("{name} {}", child.get_name()), child.clone())));
    }
    assert!(count > 30, "{count} examples");
}

#[test]
fn slips_are_answered_with_the_nearest_name() {
    #[rustfmt::skip]
    let cases = [
        ("a command",        "mvoe CS1 1,2",                           "'move'"),
        ("an option",        "move CS1 1,2 --spede 5",                 "'--speed'"),
        ("an instruction",   "explain 13/4 MCLN",                      "did you mean MCLM?"),
        ("a word",           "move CS1 1,2 --termination NoSetle",     "did you mean NoSettle?"),
        ("a fault",          "fault inject X overcurent",              "'overcurrent'"),
    ];
    for (why, line, expected) in cases {
        let error = parse(line).expect_err(why).to_string();
        assert!(error.contains(expected), "{why}: {line}: {error}");
    }
}

#[test]
fn explained_words_are_told_apart() {
    use arcline_client::FaultKind;
    for (text, expected) in [
        ("13/4", Ok(Subject::Codes(13, Some(4)))),
        ("54/-1", Ok(Subject::Codes(54, Some(-1)))),
        ("43", Ok(Subject::Codes(43, None))),
        ("overcurrent", Ok(Subject::Fault(FaultKind::Overcurrent))),
        ("Move1", Ok(Subject::Tag("Move1".to_owned()))),
        ("13/x", Err(())),
        ("13/200", Err(())),
        ("%", Err(())),
    ] {
        assert_eq!(text.parse::<Subject>().map_err(drop), expected, "{text}");
    }
}

#[test]
fn moves_parse() {
    #[rustfmt::skip]
    let cases = [
        // why,                        arguments,                           position,                speed
        ("a plain move",               "move CS1 100,50,0",                 vec![100.0, 50.0, 0.0],  None),
        ("negative first",             "move CS1 -10,0,-5 --relative",      vec![-10.0, 0.0, -5.0],  None),
        ("flags in front",             "move CS1 --relative -10,0",         vec![-10.0, 0.0],        None),
        ("free of flags behind --",    "move --speed 50% -- CS1 -1,-2",     vec![-1.0, -2.0],        Some(Rate::Percent(50.0))),
        ("units",                      "move CS1 1,2 --speed 12.5",         vec![1.0, 2.0],          Some(Rate::Units(12.5))),
        ("a speed that will err",      "move CS1 1,2 --speed -5",           vec![1.0, 2.0],          Some(Rate::Units(-5.0))),
        ("one axis",                   "move L 7",                          vec![7.0],               None),
        ("brackets",                   "move L [7,8]",                      vec![7.0, 8.0],          None),
    ];
    for (why, line, position, speed) in cases {
        let Ok(Command::Machine(MachineCommand::Move(command))) = parse(line) else {
            panic!("{why}: {line}: {:?}", parse(line))
        };
        assert_eq!(
            (command.position.0, command.dynamics.speed.speed),
            (position, speed),
            "{why}: {line}"
        );
    }
}

#[test]
fn words_or_numbers_for_termination_and_merge() {
    for (line, termination, merge) in [
        ("move CS1 1,2 --termination NoSettle", Some(1), None),
        (
            "move CS1 1,2 --termination no-settle --merge allmotion",
            Some(1),
            Some(2),
        ),
        ("move CS1 1,2 --termination 6 --merge 1", Some(6), Some(1)),
    ] {
        let Ok(Command::Machine(MachineCommand::Move(command))) = parse(line) else {
            panic!("{line}")
        };
        assert_eq!(
            (command.dynamics.termination, command.dynamics.merge),
            (termination, merge),
            "{line}"
        );
    }
}

#[test]
fn invalid_arguments_are_refused() {
    #[rustfmt::skip]
    let cases = [
        ("no position",           "move CS1"),
        ("not a number",          "move CS1 a,b"),
        ("not finite",            "move CS1 inf,0"),
        ("an unknown word",       "move CS1 1,2 --termination Smooth"),
        ("no such number",        "move CS1 1,2 --termination 9"),
        ("an unknown flag",       "move CS1 1,2 --fast"),
        ("an arc without circle", "arc XY 1,2"),
        ("two circles",           "arc XY 1,2 --via 1,1 --radius 3"),
        ("two directions",        "arc XY 1,2 --radius 3 --cw --ccw"),
        ("nothing to change",     "change CS1"),
        ("no axis",               "servo on"),
        ("axes and all",          "servo on X --all"),
        ("neither on nor off",    "servo X"),
        ("nothing to read",       "read"),
        ("no speed",              "jog X"),
        ("two ways",              "move-axis R 10 --shortest --positive"),
        ("a way and relative",    "move-axis R 10 --negative --relative"),
        ("no position",           "move-axis X"),
        ("no command",            ""),
    ];
    for (why, line) in cases {
        let error = parse(line).expect_err(why);
        assert_eq!(error.exit_code(), 2, "{why}: {line}");
    }
}

#[test]
fn the_others_parse() {
    for line in [
        "exec MSO(X,M1)",
        "exec --no-wait MSO(X,M1)",
        "run a.st --queue-full error --keep-going",
        "arc XY 100,0 --center -50,0 --ccw --full",
        "arc CS1 1,2,3 --via -1,-2,-3 --longest",
        "arc XY 1,0 --radius -5",
        "arc XY 0,0 --center-offset 5,0",
        "change CS1 --speed 20% --pending",
        "move-axis X 10 --speed 50% --accel 100 --trapezoid --merge",
        "move-axis X -10.5 --relative --no-wait",
        "move-axis R 90 --shortest --tag M1",
        "jog X 5",
        "jog X -10% --decel 50% --no-wait",
        "stop",
        "stop CS1 --type move",
        "servo on X Y",
        "servo off --all",
        "status",
        "status X CS1 --json",
        "tags",
        "tags Move*",
        "read A B[1]",
        "write A -5",
        "write A [1,-2]",
        "identify",
        "identify --broadcast 10.0.0.255",
        "--server h:1 status",
        "explain 13/4 MCLM",
        "explain 54/-1",
        "watch",
        "watch X --interval 0.1 --for 1",
        "shell",
        "completions zsh",
        "man -o pages",
    ] {
        assert!(parse(line).is_ok(), "{line}: {:?}", parse(line).err());
    }
}

#[test]
fn values_to_write_are_read_by_their_form() {
    for (line, expected) in [
        ("write A -5", WriteValue::Integer(-5)),
        ("write A 1.5", WriteValue::Number(1.5)),
        ("write A [1,2]", vec![1_i64, 2].into()),
        ("write A true", WriteValue::Bool(true)),
        ("write A CS1", "CS1".into()),
    ] {
        let Ok(Command::Machine(MachineCommand::Write(command))) = parse(line) else {
            panic!("{line}")
        };
        assert_eq!(command.value, expected, "{line}");
    }
}

#[test]
fn the_help_of_exec_comes_from_the_catalogue() {
    let text = instructions();
    for mnemonic in Mnemonic::ALL {
        assert!(text.contains(&format!("  {mnemonic}(")), "{mnemonic}");
    }
    assert!(
        text.contains("TerminationType: ActualTolerance (0), NoSettle (1)"),
        "{text}"
    );
}
