//! The audit on a real folder.

use std::fs;

use super::file::{Files, numbered};
use super::verify::{Broken, verify};
use super::*;

fn event(number: u64, is_plain_write: bool) -> Event {
    Event {
        at: SystemTime::UNIX_EPOCH + Duration::from_micros(1_795_301_281_123_456 + number),
        kind: if is_plain_write {
            EventKind::Write
        } else {
            EventKind::Motion
        },
        door: "eip",
        from: "10.1.2.3:51122 cn:line3-hmi".into(),
        role: "operator",
        object: "Count\u{1b}[2J".to_owned(),
        values: Some((number.to_string(), (number + 1).to_string())),
        result: "done",
        is_plain_write,
    }
}

/// A folder with an audit of this number of lines behind its first one.
fn folder(lines: u64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut files = Files::open(folder.path()).expect("a writable folder");
    for number in 0..lines {
        files.append(&event(number, false), 1).expect("it is written");
    }
    folder
}

#[test]
fn every_change_of_a_line_is_found() {
    let folder = folder(200);
    let file = folder.path().join("000001.jsonl");
    let text = fs::read_to_string(&file).expect("it is there");
    let whole = verify(folder.path(), None).expect("it holds");
    assert_eq!((whole.lines, whole.first, whole.last), (201, 1, 201));
    assert!(
        text.chars().all(|c| c == '\n' || !c.is_control()),
        "controls are escaped"
    );
    assert!(
        text.contains("\"t\":\"2026-11-21T22:48:01.123456Z\""),
        "{}",
        text.lines().nth(1).unwrap_or_default()
    );
    let lines: Vec<&str> = text.lines().collect();
    for at in 0..lines.len() - 1 {
        let flipped = lines[at].replacen("\"done\"", "\"gone\"", 1);
        let mut cases = vec![
            ("flipped", lines.clone()),
            ("dropped", lines.clone()),
            ("swapped", lines.clone()),
            ("twice", lines.clone()),
        ];
        cases[0].1[at] = &flipped;
        cases[1].1.remove(at);
        cases[2].1.swap(at, at + 1);
        cases[3].1.insert(at, lines[at]);
        for (why, changed) in cases {
            // Only its number chains the first line to earlier lines.
            if why == "dropped" && at == 0 {
                continue;
            }
            fs::write(&file, changed.join("\n")).expect("a writable folder");
            match verify(folder.path(), None) {
                Err(Broken::Line { n, .. }) => assert!(
                    n.abs_diff(at as u64 + 1) <= 1 + u64::from(at == 0),
                    "{why} {at}: n = {n}"
                ),
                other => panic!("{why} {at}: {other:?}"),
            }
        }
    }
    // Lines can be cut off at the end: only a hash that is stored elsewhere shows it.
    fs::write(&file, lines[..150].join("\n")).expect("a writable folder");
    assert!(verify(folder.path(), None).is_ok());
    assert!(matches!(
        verify(folder.path(), Some(&whole.head)),
        Err(Broken::Head { .. })
    ));
}

#[test]
fn a_cut_line_is_repaired_and_the_chain_goes_on() {
    for cut in [1, 20, 200] {
        let folder = folder(5);
        let file = folder.path().join("000001.jsonl");
        let bytes = fs::read(&file).expect("it is there");
        fs::write(&file, &bytes[..bytes.len() - cut]).expect("a writable folder");
        let mut files = Files::open(folder.path()).expect("it is repaired");
        files.append(&event(9, false), 1).expect("it is written");
        drop(files);
        let verified = verify(folder.path(), None).expect("it holds");
        assert_eq!(verified.lines, 7, "five of six, the repair, and one more");
        let text = fs::read_to_string(&file).expect("it is there");
        assert!(text.contains("repaired: "), "{text}");
    }
}

#[test]
fn files_have_an_end_and_the_oldest_goes() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().expect("a folder");
    let mut files = Files::open(folder.path()).expect("a writable folder");
    files.set_longest(2_000);
    for number in 0..1_000 {
        files.append(&event(number, false), 1).expect("it is written");
    }
    let all = numbered(folder.path()).expect("a folder");
    assert_eq!(all.len(), 16);
    let mode = fs::metadata(&all[0].1).expect("it is there").permissions().mode();
    assert_eq!(mode & 0o137, 0, "no others: {mode:o}");
    let verified = verify(folder.path(), None).expect("the rest holds");
    assert!(verified.first > 1 && verified.last > 1_000, "{verified:?}");
}

#[test]
fn plain_writes_are_merged_and_nothing_else_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let audit = Audit::open(folder.path()).expect("a writable folder");
    for number in 0..10_000 {
        audit.record(event(number, true));
    }
    audit.record(event(0, false));
    audit.record(event(1, false));
    audit.close();
    verify(folder.path(), None).expect("it holds");
    let text = fs::read_to_string(folder.path().join("000001.jsonl")).expect("it is there");
    let lines: Vec<serde_json::Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let writes: Vec<_> = lines.iter().filter(|line| line["what"] == "write").collect();
    let count: u64 = writes.iter().filter_map(|line| line["count"].as_u64()).sum();
    assert_eq!(count, 10_000);
    assert!(writes.len() < 100, "{} lines", writes.len());
    assert_eq!(
        (&writes[0]["old"], &writes[writes.len() - 1]["new"]),
        (&"0".into(), &"10000".into()),
        "first and last"
    );
    assert_eq!(lines.iter().filter(|line| line["what"] == "motion").count(), 2);
    assert_eq!(
        lines.last().map(|line| &line["what"]),
        Some(&"motion".into()),
        "behind the writes"
    );
}

/// A full disk costs lines and delays no answer.
#[test]
fn a_disk_that_is_full_costs_lines_only() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let folder = folder(1);
    let mut files = Files::open(folder.path()).expect("a writable folder");
    files.set_file("/dev/full");
    assert!(files.append(&event(0, false), 1).is_err());
    let audit = Audit::open(folder.path()).expect("a writable folder");
    let began = Instant::now();
    for number in 0..200_000 {
        audit.record(event(number, false));
    }
    assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
    audit.close();
    let all = numbered(folder.path()).expect("a folder");
    let text: String = all
        .iter()
        .map(|(_, file)| fs::read_to_string(file).expect("it is there"))
        .collect();
    assert!(verify(folder.path(), None).is_ok());
    let lost = text.lines().filter(|line| line.contains("audit-lost")).count();
    let kept = text.lines().filter(|line| line.contains("\"motion\"")).count();
    assert!(
        kept >= 60_000 && (lost > 0 || kept > 200_000),
        "{kept} lines, {lost} that tell a loss"
    );
    let events = |line: &str| line.split_once(" events")?.0.rsplit('"').next()?.parse::<u64>().ok();
    let told: u64 = text.lines().filter_map(events).sum();
    assert_eq!(told, audit.lost(), "every loss is told once");
}

/// A crash between a new file and its first line leaves it empty, or with a part of that line.
#[test]
fn the_chain_goes_on_behind_a_file_without_lines() {
    for begun in ["", "{\"n\":7,\"t\""] {
        let folder = folder(5);
        fs::write(folder.path().join("000002.jsonl"), begun).expect("a writable folder");
        let mut files = Files::open(folder.path()).expect("it is repaired");
        files.append(&event(9, false), 1).expect("it is written");
        drop(files);
        let verified = verify(folder.path(), None).expect("it holds");
        assert_eq!((verified.lines, verified.first, verified.last), (8, 1, 8), "{begun:?}");
    }
}

/// A written line reaches the disk within a second, even if no line follows it; at the end, it reaches the disk at once.
#[test]
fn lines_are_synchronised_without_further_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut files = Files::open(folder.path()).expect("a writable folder");
    let told = Instant::now();
    files.append(&event(1, false), 1).expect("it is written");
    assert!(wait(&Merge::default(), &files, told) <= Duration::from_secs(1));
    files.sync_at(Instant::now() + Duration::from_secs(2));
    assert!(!files.is_dirty());
    assert!(
        wait(&Merge::default(), &files, told) > Duration::from_secs(1),
        "nothing is due"
    );
    let (sender, events) = sync_channel(2);
    for event in [Some(event(2, false)), None] {
        sender.send(event).expect("there is room");
    }
    let files = write(files, &events, &Lost::default(), &AtomicU64::default());
    assert!(!files.is_dirty(), "at the end");
}
