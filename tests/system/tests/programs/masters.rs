//! A master that a client writes over the network, and its slaves.

use std::time::Duration;

use arcline_system_tests::command_line::{arcline, read_numbers};
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

/// Far more than the slave takes.
const SOON: Duration = Duration::from_secs(20);

#[test]
fn an_encoder_that_a_client_writes_leads_a_coordinated_move() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("machine.toml");
    let encoder = "[[axis]]\nname = \"E\"\ntype = \"feedback\"\nmax_speed = 1000.0\nmax_acceleration = 5000.0\n\
                   feed = { tag = \"Encoder\", interval_ms = 20.0, timeout_ms = 60000.0 }\n\
                   [[tag]]\nname = \"Encoder\"\ntype = \"LREAL\"\n[[tag]]\nname = \"Whole\"\ntype = \"REAL[1]\"\n";
    std::fs::write(&file, format!("{}\n{encoder}", arcline_config::DEFAULT)).expect("a file");
    let server = Server::start_on(&file);
    let at = server.address();
    let _ = arcline(at, &["write", "Encoder", "200"]).expect(0);
    let _ = arcline(at, &["exec", "MDCC(CS1, E, Link, Actual, 0)"]).expect(0);
    // 52 units of the master for 100 of the slave (spec/coordinated-instructions.md §27.8); the result is there before the move.
    let line = "MCLM(CS1, Line, Absolute, [100, 0, 0], 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, \
                Trapezoidal, 100, 100, %ofTimeMasterDriven, 1, Disabled, Programmed, 0, 0, ImmediateForwardOnly, [0], Whole)";
    let _ = arcline(at, &["exec", "--no-wait", line]).expect(0);
    eventually("what it takes", SOON, || {
        (read_numbers(at, &["Whole[0]"]) == [52.0]).then_some(())
    });
    for (written, expected) in [(202.0, 2.0), (190.0, 2.0), (226.0, 50.0), (250.0, 98.0), (253.0, 100.0)] {
        let _ = arcline(at, &["write", "Encoder", &written.to_string()]).expect(0);
        eventually("the slave has followed", SOON, || {
            let [master, slave] = read_numbers(at, &["E.ActualPosition", "X.CommandPosition"])[..] else {
                panic!("two tags")
            };
            (master == written && (slave - expected).abs() < 1e-6).then_some(())
        });
    }
    // The move is complete, and its link is there for the next one.
    let told = arcline(at, &["status", "CS1"]).expect(0).stdout;
    assert!(told.contains("at rest"), "{told}");
}
