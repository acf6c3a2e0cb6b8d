//! Each check with a system that is well and one that is not.

use std::fs;
use std::net::TcpListener;
use std::path::Path;

use arcline_config::{IoListen, ServerConfig};
use arcline_realtime::Report;

use super::files::{audit, security, state};
use super::network::{Kind, Ports, ports};
use super::real_time::{lateness, memory, scheduling};
use super::system::System;
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
    let finding = Ports::default().open("page", at, &[Kind::Tcp]);
    assert!(
        finding.grade == Grade::Failed && finding.remedy.contains("ss -lntup"),
        "{finding:?}"
    );
    drop(taken);
    assert_eq!(Ports::default().open("page", at, &[Kind::Tcp]).grade, Grade::Ok);
    let elsewhere = "203.0.113.1:0".parse().expect("an address");
    assert_eq!(
        Ports::default().open("page", elsewhere, &[Kind::Udp]).grade,
        Grade::Failed
    );
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

/// The configuration of a server with these keys of `[security]`.
fn configured(keys: &str) -> ServerConfig {
    let text = format!("[server]\nlisten = \"127.0.0.1:0\"\nhmi = \"off\"\nio = \"off\"\n[security]\n{keys}\n");
    arcline_config::load(&text, "test")
        .expect("a valid configuration")
        .server
}

#[test]
fn the_addresses_of_tls_are_opened_too_and_all_at_once() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let at = taken.local_addr().expect("its address");
    for (key, check) in [("tls", "EtherNet/IP over TLS"), ("hmi_tls", "page over TLS")] {
        let server = configured(&format!("{key} = \"{at}\""));
        let findings = ports(&server);
        let failed: Vec<_> = findings.iter().filter(|finding| finding.grade != Grade::Ok).collect();
        assert!(
            matches!(failed[..], [one] if one.check == check && one.grade == Grade::Failed),
            "{findings:?}"
        );
    }
    // Both of one configuration.
    drop(taken);
    let server = configured(&format!("tls = \"{at}\"\nhmi_tls = \"{at}\""));
    let findings = ports(&server);
    let failed = findings.iter().find(|finding| finding.grade == Grade::Failed);
    assert!(
        failed.is_some_and(|failed| failed.remedy.contains("twice")),
        "{findings:?}"
    );
    // Without a table [security] the server needs a flag.
    let mut open = ServerConfig {
        listen: "0.0.0.0:0".parse().expect("an address"),
        hmi: None,
        io: IoListen::Off,
        ..ServerConfig::default()
    };
    let network = |server: &ServerConfig| ports(server).into_iter().find(|finding| finding.check == "network");
    assert!(network(&open).is_some_and(|finding| finding.grade == Grade::Warning));
    open.security.is_given = true;
    assert_eq!(network(&open), None);
}

#[test]
fn missing_files_of_security_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let found = |keys: &str| security(&configured(keys).security, folder.path());
    assert_eq!(found(""), []);
    for (keys, check, file) in [
        ("tls = \"127.0.0.1:0\"", "certificates", "server.key"),
        ("hmi_tls = \"127.0.0.1:0\"", "certificates", "server.key"),
        ("users = \"users.toml\"", "users", "users.toml"),
    ] {
        let findings = found(keys);
        let is_found = matches!(&findings[..], [one]
            if one.check == check && one.grade == Grade::Failed && one.found.contains(file) && one.remedy.contains("arcline-server"));
        assert!(is_found, "{keys}: {findings:?}");
    }
}

#[test]
fn a_state_that_a_server_cannot_keep_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state");
    let names = || {
        let entries = fs::read_dir(folder.path()).expect("readable");
        let mut names: Vec<_> = entries.map(|entry| entry.expect("readable").file_name()).collect();
        names.sort();
        names
    };
    assert_eq!(state(&file).grade, Grade::Ok);
    assert_eq!(names(), [] as [&str; 0], "nothing stays");
    assert_eq!(state(Path::new("/no/such/folder/state")).grade, Grade::Failed);
    let remedy = |file: &Path, expected: &str| {
        let finding = state(file);
        assert!(
            finding.grade == Grade::Failed && finding.remedy.contains(expected),
            "{}: {finding:?}",
            file.display()
        );
    };
    remedy(folder.path(), "Name a file");
    let locked = arcline_state::LockedFile::lock(&file).expect("it is free");
    remedy(&file, "Stop that server");
    drop(locked);
    assert_eq!(state(&file).grade, Grade::Ok);
    // The kernel's folder takes no files, not even of root.
    remedy(Path::new("/proc/state"), "give it to the user");
    // A link with the name of the probe is not followed.
    let probe = folder.path().join(format!(".arcline-doctor-{}-0", std::process::id()));
    let target = folder.path().join("target");
    std::os::unix::fs::symlink(&target, &probe).expect("writable");
    assert_eq!(state(&file).grade, Grade::Ok);
    assert!(!target.exists() && probe.is_symlink());
    // The folder of the audit.
    assert_eq!(audit(&file), None, "the server makes it");
    fs::write(folder.path().join("state.audit"), "").expect("writable");
    assert!(audit(&file).is_some_and(|finding| finding.grade == Grade::Failed));
}

#[test]
fn a_measurement_lasts_a_day_at_most() {
    assert_eq!(super::measured("0.5"), Ok(0.5));
    for text in ["1e300", "86401", "-1", "NaN"] {
        assert!(super::measured(text).is_err(), "{text}");
    }
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
