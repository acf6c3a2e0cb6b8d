//! A million lines of G-code.

use arcline_system_tests::gcode::simulated;

#[test]
fn a_million_lines_take_no_more_memory_than_ten_thousand() {
    let folder = tempfile::tempdir().expect("a folder");
    let (short, long) = (simulated(folder.path(), 10_000), simulated(folder.path(), 1_000_000));
    println!("{short:?}, {long:?}");
    assert_eq!(long.moves, 999_999);
    assert!(long.peak < short.peak + (16 << 20), "{short:?}, {long:?}");
    // As many moves, as much time, but for the first and the last one.
    let (per_short, per_long) = (short.seconds / short.moves as f64, long.seconds / long.moves as f64);
    assert!(
        (per_long / per_short - 1.0).abs() < 0.01,
        "{per_short} s and {per_long} s a move"
    );
}
