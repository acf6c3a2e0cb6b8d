//! The pages of the user guide that show a client in Python.

use arcline_system_tests::guide::run;
use arcline_system_tests::not_run;
use arcline_system_tests::python::Python;

#[test]
fn an_hmi_by_tags() {
    with_python("guide/pycomm3.md");
}

#[test]
fn a_test_fixture() {
    with_python("guide/fixture.md");
}

fn with_python(page: &str) {
    match Python::with("pycomm3") {
        Ok(python) => run(page, Some(&python)),
        Err(why) => not_run(page, &why),
    }
}
