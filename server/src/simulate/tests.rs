//! How numbers are printed.

use super::output::number;

#[test]
fn numbers_are_short_and_read_back() {
    #[rustfmt::skip]
    let cases = [
        (0.0, "0"), (-0.0, "-0"), (1.0, "1"), (100.0, "100"), (0.1, "0.1"), (-2.5, "-2.5"), (1.0 / 3.0, "0.3333333333333333"),
        (0.001, "0.001"), (3600.0, "3600"), (1e-9, "1e-9"),
    ];
    for (value, expected) in cases {
        let mut text = Vec::new();
        number(&mut text, value);
        let text = String::from_utf8(text).expect("ASCII");
        assert_eq!(text, expected);
        assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
    }
}
