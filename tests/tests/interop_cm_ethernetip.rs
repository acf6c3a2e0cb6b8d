//! An unmodified cm-ethernetip: every type and shape of tag, moves, refusals. The script says what is expected.

#[test]
fn cm_ethernetip_works_unmodified() {
    arcline_tests::interop::python("cm_ethernetip", "cm_ethernetip_all.py");
}

#[test]
fn its_scanner_works_unmodified() {
    arcline_tests::interop::python_io("cm_ethernetip", "cm_ethernetip_io.py");
}
