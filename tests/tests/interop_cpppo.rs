//! An unmodified cpppo: every type and shape of tag, moves, refusals. The script says what is expected.

#[test]
fn cpppo_works_unmodified() {
    arcline_tests::interop::python("cpppo", "cpppo_all.py");
}
