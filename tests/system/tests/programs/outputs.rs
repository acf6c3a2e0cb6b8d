//! An output cam over the network: a client makes its tags, arms it, and sees its bits go with the axis.

use std::time::Duration;

use arcline_system_tests::command_line::{arcline, read_numbers};
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

/// Far more than the axis takes.
const SOON: Duration = Duration::from_secs(20);
/// The travel of the axis while a bit of an update waits for the next one, and more, units.
const NEAR: f64 = 1.0;

#[test]
fn a_client_arms_an_output_cam_and_sees_its_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("machine.toml");
    let own = arcline_config::DEFAULT.replacen("name = \"A\"\n", "name = \"A\"\noutput_cam_execution_targets = 2\n", 1);
    std::fs::write(&file, own).expect("a file");
    let server = Server::start_on(&file);
    let at = server.address();
    for (name, data_type) in [("Out", "DINT"), ("In", "DINT"), ("Cam", "OUTPUT_CAM[2]")] {
        let _ = arcline(at, &["tags", "create", name, data_type]).expect(0);
    }
    // Bit 3 between two positions, bit 4 there while bit 7 of the input is on.
    for (element, members) in [
        (
            0,
            [
                ("OutputBit", "3"),
                ("LatchType", "1"),
                ("UnlatchType", "1"),
                ("EnableBit", "0"),
            ],
        ),
        (
            1,
            [
                ("OutputBit", "4"),
                ("LatchType", "3"),
                ("UnlatchType", "4"),
                ("EnableBit", "7"),
            ],
        ),
    ] {
        for (member, value) in members.into_iter().chain([("Left", "5.0"), ("Right", "15.0")]) {
            let _ = arcline(at, &["write", &format!("Cam[{element}].{member}"), value]).expect(0);
        }
    }
    let arm = "MAOC(A, 1, Arm, Out, In, Cam, 0, 100, 0, Persistent, Immediate, 0, 0, Command)";
    let _ = arcline(at, &["exec", "--no-wait", arm]).expect(0);
    eventually("the cam is armed", SOON, || {
        let shown = read_numbers(at, &["A.OutputCamStatus", "A.OutputCamLockStatus", "Out"]);
        (shown == [2.0, 2.0, 0.0]).then_some(())
    });

    // On the way, a bit belongs to one of the positions before and behind it.
    let _ = arcline(at, &["move-axis", "A", "20", "--speed", "10", "--no-wait"]).expect(0);
    let mut seen = Vec::new();
    eventually("the axis is behind the range", SOON, || {
        let shown = read_numbers(at, &["A.CommandPosition", "Out", "A.CommandPosition"]);
        let [before, out, behind] = shown[..] else {
            panic!("three tags: {shown:?}")
        };
        let (before, behind) = (before - NEAR, behind + NEAR);
        let legal = if out == 8.0 {
            before < 15.0 && behind > 5.0
        } else {
            out == 0.0 && (before < 5.0 || behind > 15.0)
        };
        assert!(legal, "{out} between {before} and {behind}");
        if seen.last() != Some(&out) {
            seen.push(out);
        }
        (before > 15.0).then_some(())
    });
    assert!(seen.ends_with(&[8.0, 0.0]), "on and off again: {seen:?}");

    // Back into the range, and the input.
    eventually("the axis stands", SOON, || {
        (read_numbers(at, &["A.CommandPosition"]) == [20.0]).then_some(())
    });
    let _ = arcline(at, &["move-axis", "A", "10"]).expect(0);
    let out_is = |value: f64| {
        eventually("the bits", SOON, || {
            (read_numbers(at, &["Out"]) == [value]).then_some(())
        });
    };
    out_is(8.0);
    let _ = arcline(at, &["write", "In", "128"]).expect(0);
    out_is(24.0);
    // Bits that no element sets are the client's.
    let _ = arcline(at, &["write", "Out", "1"]).expect(0);
    let _ = arcline(at, &["write", "In", "0"]).expect(0);
    out_is(9.0);
    let _ = arcline(at, &["exec", "MDOC(A, 1, Off, All)"]).expect(0);
    let _ = arcline(at, &["move-axis", "A", "30"]).expect(0);
    assert_eq!(
        read_numbers(at, &["Out", "A.OutputCamStatus"]),
        [9.0, 0.0],
        "disarmed: nobody changes it"
    );
    // The refusal of the instruction is that of a controller.
    let refused = arcline(at, &["exec", &arm.replace("(A, 1,", "(A, 2,")]).expect(1);
    assert!(refused.stderr.contains("ERR 35"), "{refused:?}");
}
