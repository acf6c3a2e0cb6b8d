//! An unmodified pycomm3: browse, read, write, move, be refused. The scripts say what is expected.

#[test]
fn pycomm3_works_unmodified() {
    arcline_tests::interop::python("pycomm3", "pycomm3_move.py");
}

#[test]
fn pycomm3_reads_and_writes_every_type_and_shape() {
    arcline_tests::interop::python("pycomm3", "pycomm3_tags.py");
}
