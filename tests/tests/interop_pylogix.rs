//! An unmodified pylogix: browse, read, write, move, be refused. The script says what is expected.

#[test]
fn pylogix_works_unmodified() {
    arcline_tests::interop::run("pylogix_move.py");
}
