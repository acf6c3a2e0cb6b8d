//! A tag table that changes while a real server runs: `arcline tags create` and `delete`, and SIGHUP.

use std::fs;
use std::time::Duration;

use arcline_system_tests::command_line::{arcline, read_numbers};
use arcline_system_tests::eventually;
use arcline_system_tests::server::Server;

/// Far more than a reload takes.
const SOON: Duration = Duration::from_secs(20);

/// The default machine and these tags.
fn configuration(tags: &str) -> String {
    format!("{}\n{tags}", arcline_config::DEFAULT)
}

#[test]
fn tags_are_created_and_deleted_by_the_command_line() {
    let server = Server::start();
    let at = server.address();
    let created = arcline(at, &["tags", "create", "Batch", "DINT[4]"]).expect(0);
    assert_eq!(created.stdout, "Batch created\n");
    let _ = arcline(at, &["tags", "create", "Level", "REAL", "--program", "Tank"]).expect(0);
    let _ = arcline(at, &["write", "Batch[2]", "7"]).expect(0);
    let _ = arcline(at, &["write", "Program:Tank.Level", "1.5"]).expect(0);
    assert_eq!(read_numbers(at, &["Batch[2]", "Program:Tank.Level"]), [7.0, 1.5]);
    let list = arcline(at, &["tags", "*a*"]).expect(0).stdout;
    assert!(list.contains("Batch") && list.contains("Program:Tank.Level"), "{list}");

    let _ = arcline(at, &["tags", "create", "Limit", "DINT", "--access", "read_only"]).expect(0);
    assert_eq!(arcline(at, &["write", "Limit", "1"]).code, Some(1), "not for writing");
    // A name that is taken, a type that there is not, an axis.
    for (refused, code) in [
        (&["tags", "create", "batch", "REAL"][..], 1),
        (&["tags", "create", "Other", "NOTHING"], 2),
        (&["tags", "delete", "X"], 1),
    ] {
        assert_eq!(arcline(at, refused).code, Some(code), "{refused:?}");
    }
    for name in ["Batch", "Limit", "Program:Tank.Level"] {
        let _ = arcline(at, &["tags", "delete", name]).expect(0);
        assert_eq!(arcline(at, &["read", name]).code, Some(2), "{name} is gone");
    }
    assert_eq!(arcline(at, &["tags", "delete", "Batch"]).code, Some(2), "twice");
}

#[test]
fn sighup_takes_over_the_tags_of_the_file_or_says_why_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("machine.toml");
    let write = |tags: &str| fs::write(&file, configuration(tags)).expect("a file");
    write("[[tag]]\nname = \"Old\"\ntype = \"DINT\"\n[[tag]]\nname = \"Kept\"\ntype = \"DINT\"\n");
    let server = Server::start_on(&file);
    let at = server.address();
    let _ = arcline(at, &["write", "Kept", "5"]).expect(0);
    let _ = arcline(at, &["tags", "create", "Mine", "DINT"]).expect(0);

    write("[[tag]]\nname = \"Kept\"\ntype = \"DINT\"\n[[tag]]\nname = \"New\"\ntype = \"REAL\"\nvalue = 2.5\n");
    server.hang_up();
    eventually("the new tag", SOON, || {
        (arcline(at, &["read", "New"]).code == Some(0)).then_some(())
    });
    assert_eq!(read_numbers(at, &["New", "Kept", "Mine"]), [2.5, 5.0, 0.0]);
    assert_eq!(arcline(at, &["read", "Old"]).code, Some(2));

    // A file that is wrong and one that needs a restart change nothing; the next good one is taken.
    let slow = configuration("").replacen("max_speed = 1000.0", "max_speed = 999.0", 1);
    for (wrong, told) in [
        (
            configuration("[[tag]]\nname = \"New\"\ntype = \"NOTHING\"\n"),
            "NOTHING",
        ),
        (slow, "axis X changed, which needs a restart"),
    ] {
        fs::write(&file, wrong).expect("a file");
        server.hang_up();
        eventually(told, SOON, || {
            let log = server.log();
            log.lines()
                .any(|line| line.contains("Reload refused") && line.contains(told))
                .then_some(())
        });
        assert_eq!(read_numbers(at, &["New", "Kept"]), [2.5, 5.0]);
    }
    write("[[tag]]\nname = \"Last\"\ntype = \"DINT\"\n");
    server.hang_up();
    eventually("the last tag", SOON, || {
        (arcline(at, &["read", "Last"]).code == Some(0)).then_some(())
    });
    assert_eq!(arcline(at, &["read", "New"]).code, Some(2));
    assert!(server.terminate().0.success());
}
