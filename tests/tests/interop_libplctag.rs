//! An unmodified libplctag: every type and shape of tag, moves, refusals. The program in `tests/libplctag` says what is expected.

#[test]
fn libplctag_works_unmodified() {
    arcline_tests::interop::libplctag();
}
