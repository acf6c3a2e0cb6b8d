//! The README's tour of the command line, run as it is: the results are those in the text.

use std::time::Duration;

use arcline_system_tests::command_line::arcline;
use arcline_system_tests::eventually;
use arcline_system_tests::guide::readme_blocks;
use arcline_system_tests::server::Server;

#[test]
fn the_tour_with_the_command_line() {
    let server = Server::start();
    let mut code = None;
    let text: String = readme_blocks("console").concat();
    for part in text.split("$ ").skip(1) {
        let (line, shown) = part.split_once('\n').expect("a command ends its line");
        let arguments = shlex::split(line).expect("quotes end");
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
