//! Attributes of axes and coordinate systems in programs (GSV, SSV): `arcline run` sets them on a live server.

use arcline_system_tests::command_line::{arcline, read_numbers};
use arcline_system_tests::server::Server;

const BITS: &str = "GSV(CoordinateSystem, CS1, DynamicsConfigurationBits, Before);
SSV(CoordinateSystem, CS1, DynamicsConfigurationBits, Before - 4);
GSV(CoordinateSystem, CS1, DynamicsConfigurationBits, After);
SSV(Axis, S, DynamicsConfigurationBits, 1);
GSV(Axis, S, DynamicsConfigurationBits, OfAxis);
GSV(Axis, X, DynamicsConfigurationBits, OfOther);
";

#[test]
fn a_program_sets_attributes() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("bits.st");
    let file = file.to_str().expect("UTF-8");
    let server = Server::start();
    let at = server.address();
    let tags = ["Before", "After", "OfAxis", "OfOther"];
    for tag in tags {
        let _ = arcline(at, &["tags", "create", tag, "DINT"]).expect(0);
    }
    std::fs::write(file, BITS).expect("the folder is writable");
    let _ = arcline(at, &["run", file]).expect(0);
    assert_eq!(read_numbers(at, &tags), [7.0, 3.0, 1.0, 7.0]);

    // The server keeps the value for programs that come later, and other attributes of the object are as before.
    std::fs::write(
        file,
        "GSV(CoordinateSystem, CS1, DynamicsConfigurationBits, Before);\nGSV(CoordinateSystem, CS1, MaximumSpeed, After);\n",
    )
    .expect("the folder is writable");
    let _ = arcline(at, &["run", file]).expect(0);
    let [bits, speed] = read_numbers(at, &tags[..2])[..] else {
        panic!("two numbers")
    };
    assert_eq!(bits, 3.0);
    assert!(speed > 3.0, "the maximum speed is not the bits: {speed}");

    // So does a tolerance, which the next move has.
    let tolerance = "GSV(CoordinateSystem, CS1, CommandPositionTolerance, Before);
SSV(CoordinateSystem, CS1, CommandPositionTolerance, Before + 2.5);
GSV(CoordinateSystem, CS1, CommandPositionTolerance, After);\n";
    std::fs::write(
        file,
        tolerance
            .replace("Before", "Tolerance[0]")
            .replace("After", "Tolerance[1]"),
    )
    .expect("the folder is writable");
    let _ = arcline(at, &["tags", "create", "Tolerance", "LREAL[2]"]).expect(0);
    let _ = arcline(at, &["run", file]).expect(0);
    let [before, after] = read_numbers(at, &["Tolerance[0]", "Tolerance[1]"])[..] else {
        panic!("two numbers")
    };
    assert_eq!(after, before + 2.5);
    std::fs::write(file, "SSV(CoordinateSystem, CS1, MaximumDeceleration, 0);\n").expect("the folder is writable");
    let refused = arcline(at, &["run", file]).expect(1);
    assert_eq!(
        refused.stderr,
        "line 1: MaximumDeceleration cannot be 0, expected a number above 0\n"
    );

    // A value that the attribute cannot have is refused in words, and nothing changes.
    for value in ["64", "-1", "1.5"] {
        std::fs::write(
            file,
            format!("n := 0;\nSSV(CoordinateSystem, CS1, DynamicsConfigurationBits, {value});\n"),
        )
        .expect("the folder is writable");
        let refused = arcline(at, &["run", file]).expect(1);
        assert_eq!(
            refused.stderr,
            format!("line 2: DynamicsConfigurationBits cannot be {value}, expected a whole number from 0 to 7\n"),
            "{value}"
        );
    }
    std::fs::write(file, "GSV(CoordinateSystem, CS1, DynamicsConfigurationBits, After);\n").expect("it is writable");
    let _ = arcline(at, &["run", file]).expect(0);
    assert_eq!(read_numbers(at, &["After"]), [3.0]);
}
