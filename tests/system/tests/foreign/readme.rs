//! The README's tour with pycomm3, run as it is: the results are those in the text.

use arcline_system_tests::guide::readme_blocks;
use arcline_system_tests::python::Python;
use arcline_system_tests::server::Server;
use arcline_system_tests::{not_run, programs};

/// The text of the first block of that language.
fn block(language: &str) -> String {
    let found = readme_blocks(language).into_iter().next();
    found.unwrap_or_else(|| panic!("a block of {language}"))
}

#[test]
fn the_tour_with_pycomm3() {
    let python = match Python::with("pycomm3") {
        Ok(python) => python,
        Err(why) => return not_run("the README's tour with pycomm3", &why),
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
