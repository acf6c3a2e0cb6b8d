//! Each check with a system that is well and one that is not.

use std::fs;
use std::net::TcpListener;
use std::path::Path;

use arcline_realtime::Report;

use super::network::{Kind, port};
use super::real_time::{lateness, memory, scheduling};
use super::system::{System, state};
use super::{Finding, Grade, text};

/// A system with these files.
fn system(files: &[(&str, &str)]) -> (tempfile::TempDir, System) {
    let root = tempfile::tempdir().expect("a folder");
    for (path, content) in files {
        let file = root.path().join(path);
        fs::create_dir_all(file.parent().expect("a folder")).expect("writable");
        fs::write(file, format!("{content}\n")).expect("writable");
    }
    let system = System::at(root.path());
    (root, system)
}

type Check = fn(&System) -> Finding;

/// A check of a file that has this content.
fn checked(path: &str, content: &str, check: Check) -> Finding {
    let (_root, system) = system(&[(path, content), ("proc/sys/kernel/sched_rt_period_us", "1000000")]);
    check(&system)
}

#[test]
fn settings_of_the_system_are_judged() {
    let clock = "sys/devices/system/clocksource/clocksource0/current_clocksource";
    let governor = "sys/devices/system/cpu/cpu1/cpufreq/scaling_governor";
    let share = "proc/sys/kernel/sched_rt_runtime_us";
    #[rustfmt::skip]
    let cases: [(&str, &str, Check, Grade, &str); 10] = [
        (clock,    "tsc",         System::clock_source,    Grade::Ok,      "tsc"),
        (clock,    "hpet",        System::clock_source,    Grade::Warning, "hpet"),
        ("other",  "",            System::clock_source,    Grade::Ok,      "not told"),
        (governor, "performance", System::governor,        Grade::Ok,      "performance"),
        (governor, "powersave",   System::governor,        Grade::Warning, "powersave"),
        (share,    "950000",      System::real_time_share, Grade::Ok,      "950000 of 1000000 us"),
        (share,    "-1",          System::real_time_share, Grade::Ok,      "all"),
        (share,    "100000",      System::real_time_share, Grade::Warning, "100000"),
        ("sys/kernel/realtime", "1", System::kernel,       Grade::Ok,      ", PREEMPT_RT"),
        ("proc/swaps", "Filename Type\n/swap file", System::swap, Grade::Ok, "1 in use"),
    ];
    for (path, content, check, grade, found) in cases {
        let finding = checked(path, content, check);
        assert!(
            finding.grade == grade && finding.found.contains(found),
            "{path} {content}: {finding:?}"
        );
        assert_eq!(
            finding.remedy.is_empty(),
            grade == Grade::Ok,
            "{path} {content}: {finding:?}"
        );
    }
}

#[test]
fn a_port_that_is_taken_is_told() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let at = taken.local_addr().expect("its address");
    let finding = port("page", at, &[Kind::Tcp]);
    assert!(
        finding.grade == Grade::Failed && finding.remedy.contains("ss -lntup"),
        "{finding:?}"
    );
    drop(taken);
    assert_eq!(port("page", at, &[Kind::Tcp]).grade, Grade::Ok);
    let elsewhere = "203.0.113.1:0".parse().expect("an address");
    assert_eq!(port("page", elsewhere, &[Kind::Udp]).grade, Grade::Failed);
}

#[test]
fn priority_and_locked_memory_are_judged() {
    let good = Report {
        fifo: true,
        memory_locked: true,
        ..Report::default()
    };
    assert_eq!((scheduling(&good).grade, memory(&good).grade), (Grade::Ok, Grade::Ok));
    let none = Report::default();
    assert_eq!(
        (scheduling(&none).grade, memory(&none).grade),
        (Grade::Warning, Grade::Warning)
    );
    for (max, ticks, overruns, grade) in [
        (400.0, 1000, 0, Grade::Ok),
        (600.0, 1000, 0, Grade::Warning),
        (1.0, 1000, 1, Grade::Warning),
        (0.0, 0, 0, Grade::Warning),
    ] {
        assert_eq!(
            lateness(1000.0, max, 1.0, ticks, overruns).grade,
            grade,
            "{max} {ticks} {overruns}"
        );
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(state(&folder.path().join("state")).grade, Grade::Ok);
    assert_eq!(
        fs::read_dir(folder.path()).expect("readable").count(),
        0,
        "nothing stays"
    );
    assert_eq!(state(Path::new("/no/such/folder/state")).grade, Grade::Failed);
}

#[test]
fn the_worst_is_the_last_line() {
    let ok = Finding::ok("a", "fine");
    let warning = Finding::new("b", Grade::Warning, "slow", "Do this.");
    let failed = Finding::new("c", Grade::Failed, "taken", "Do that.");
    assert!(text(std::slice::from_ref(&ok)).ends_with("Nothing is amiss.\n"));
    let told = text(&[ok.clone(), warning.clone()]);
    assert!(
        told.contains("-> Do this.") && told.ends_with("A server starts here; 1 warnings.\n"),
        "{told}"
    );
    let told = text(&[ok, warning, failed]);
    assert!(
        told.ends_with("A server does not start here: 1 failed, 1 warnings.\n"),
        "{told}"
    );
}
