//! An unmodified pylogix: browse, read, write, move, be refused. The scripts say what is expected.

#[test]
fn pylogix_works_unmodified() {
    arcline_tests::interop::python("pylogix", "pylogix_move.py");
}

#[test]
fn pylogix_reads_and_writes_every_type_and_shape() {
    arcline_tests::interop::python("pylogix", "pylogix_tags.py");
}
