//! An unmodified pycomm3: browse, read, write, move, be refused. The script says what is expected.

#[test]
fn pycomm3_works_unmodified() {
    arcline_tests::interop::run("pycomm3_move.py");
}
