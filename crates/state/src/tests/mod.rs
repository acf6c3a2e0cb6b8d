//! Files as written, cut off, damaged and foreign.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

use proptest::prelude::*;

use crate::recording::{Kind, Recording};
use crate::*;

mod crashes;

fn axis(name: &str, position: f64) -> Axis {
    Axis {
        name: name.to_owned(),
        kind: "servo, mm".to_owned(),
        state: AxisState {
            position,
            homed: true,
            ..AxisState::default()
        },
    }
}

fn tag(name: &str, kind: &str, bytes: &[u8]) -> Tag {
    Tag {
        name: name.to_owned(),
        kind: kind.to_owned(),
        bytes: bytes.to_vec(),
    }
}

fn first() -> RetainedState {
    RetainedState {
        axes: vec![axis("X", 12.5), axis("Y", -0.1)],
        tags: vec![tag("Count", "DINT", &[1, 2, 3, 4]), tag("Recipe", "REAL[2]", &[0; 8])],
    }
}

fn moved(axis: u32, position: f64, moving: bool) -> Change {
    let state = AxisState {
        position,
        homed: true,
        moving,
        faults: 0x8000_0007,
        redefined: -position,
    };
    Change::Axis { axis, state }
}

fn written(tag: u32, offset: u32, bytes: &[u8]) -> Change {
    let bytes = bytes.to_vec();
    Change::Tag { tag, offset, bytes }
}

/// The records in the files of these tests, in their order.
fn steps() -> Vec<Record> {
    vec![
        Record::Changes(vec![written(0, 0, &[9, 0, 0, 0])]),
        Record::Changes(vec![moved(0, 13.0, true), moved(1, 0.5, true)]),
        Record::Changes(vec![written(1, 4, &[1, 1, 1, 1]), written(0, 2, &[5])]),
        Record::Changes(vec![moved(0, 99.0, false)]),
    ]
}

/// Every state that there was, in order.
fn history() -> Vec<RetainedState> {
    let mut state = first();
    let mut all = vec![state.clone()];
    for step in steps() {
        state.apply(&step).expect("it has them");
        all.push(state.clone());
    }
    all
}

fn begin(file: &Path, state: RetainedState) -> Writer<System, ()> {
    let locked = LockedFile::lock(file).expect("no other process has it");
    Writer::start(locked, state, Pace::default(), Duration::ZERO)
}

/// Hands a record to the writer, and returns the answer.
fn keep(writer: &mut Writer<System, ()>, record: Record) -> Result<(), NotPersisted> {
    writer.keep(record, ());
    let _ = writer.turn(Duration::ZERO);
    let answer = writer.actions().find_map(|action| match action {
        Action::Answer((), answer) => Some(answer),
        Action::Report(_) => None,
    });
    answer.expect("each record is answered")
}

fn read(file: &Path) -> Option<RetainedState> {
    let contents = LockedFile::lock(file).expect("no other process has it").read();
    contents.expect("whole").map(|contents| contents.state)
}

/// A file with the first state and every step, of which only the first state was synchronised.
fn example() -> Vec<u8> {
    let (mut bytes, mut chain) = format::fresh(&first());
    for step in steps() {
        chain.push(&step, &mut bytes);
    }
    bytes
}

/// The same after a synchronisation.
fn synchronised(mut bytes: Vec<u8>) -> Vec<u8> {
    let (page, at) = (horizon::page(bytes.len()), horizon::offset(1));
    bytes[at..at + page.len()].copy_from_slice(&page);
    bytes
}

#[test]
fn appended_records_are_read_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    assert_eq!(read(&file), None, "nothing was ever kept");
    let mut writer = begin(&file, first());
    assert_eq!(read_unlocked(&file), first(), "at once");
    for (step, expected) in steps().into_iter().zip(history().iter().skip(1)) {
        assert_eq!(keep(&mut writer, step), Ok(()));
        assert_eq!(read_unlocked(&file), *expected);
    }
    drop(writer);
    let last = history().pop();
    assert_eq!(read(&file), last);
    let mut writer = begin(&file, last.expect("there are steps"));
    let mut other = first();
    other.tags.push(tag("New", "BOOL", &[1]));
    assert_eq!(keep(&mut writer, Record::State(other.clone())), Ok(()), "other tags");
    assert_eq!(keep(&mut writer, Record::Changes(vec![written(2, 0, &[0])])), Ok(()));
    other.tags[2].bytes = vec![0];
    drop(writer);
    assert_eq!(read(&file), Some(other));
}

fn read_unlocked(file: &Path) -> RetainedState {
    let bytes = fs::read(file).expect("it is there");
    parse(&bytes).expect("whole").state
}

#[test]
fn a_table_of_tags_that_does_not_fit_refuses_the_changes_that_count_on_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    let mut writer = begin(&file, first());
    let mut large = first();
    large.tags[1].name = "n".repeat(MAX_TEXT + 1);
    assert_eq!(keep(&mut writer, Record::State(large)), Err(NotPersisted));
    let change = || Record::Changes(vec![written(0, 0, &[1])]);
    assert_eq!(
        keep(&mut writer, change()),
        Err(NotPersisted),
        "of a tag of the other table"
    );
    assert_eq!(
        keep(&mut writer, Record::Changes(vec![moved(0, 7.0, false)])),
        Ok(()),
        "axes are as before"
    );
    assert_eq!(keep(&mut writer, Record::State(first())), Ok(()));
    assert_eq!(keep(&mut writer, change()), Ok(()));
    assert_eq!(
        keep(&mut writer, Record::Changes(vec![written(9, 0, &[1])])),
        Err(NotPersisted)
    );
    assert_eq!(keep(&mut writer, change()), Ok(()), "one that fits");
}

#[test]
fn a_file_cut_off_behind_its_horizon_is_a_state_that_there_was() {
    let (bytes, history) = (example(), history());
    let mut seen = Vec::new();
    for length in 0..=bytes.len() {
        match parse(&bytes[..length]) {
            Ok(contents) => {
                let which = history.iter().position(|state| *state == contents.state);
                let which = which.unwrap_or_else(|| panic!("cut at {length}: {:?} never was", contents.state));
                seen.push(which);
            }
            Err(Damage::TooShort { length: told }) => {
                assert_eq!(told, length);
                assert!(seen.is_empty(), "cut at {length}: a longer one was read before");
            }
            Err(other) => panic!("cut at {length}: {other}"),
        }
    }
    assert!(seen.is_sorted());
    seen.dedup();
    assert_eq!(seen, [0, 1, 2, 3, 4], "every state is reached");
}

#[test]
fn a_file_cut_off_before_its_horizon_is_damaged() {
    let bytes = synchronised(example());
    let first = format::fresh(&first()).0.len();
    for length in first..bytes.len() {
        let damage = parse(&bytes[..length]).expect_err("it is shorter than it was");
        let truncated = matches!(damage, Damage::Truncated { synchronised, .. } if synchronised == bytes.len() as u64);
        assert!(truncated, "cut at {length}: {damage}");
    }
    assert_eq!(parse(&bytes).map(|contents| Some(contents.state)), Ok(history().pop()));
}

#[test]
fn a_bit_that_has_flipped_before_the_horizon_is_found() {
    let (bytes, last) = (synchronised(example()), history().pop());
    for byte in (0..16).chain(4096..4108).chain(8192..8204).chain(12_288..bytes.len()) {
        for bit in 0..8 {
            let mut bytes = bytes.clone();
            bytes[byte] ^= 1 << bit;
            let read = parse(&bytes);
            if (4096..8204).contains(&byte) {
                assert_eq!(
                    read.map(|contents| Some(contents.state)),
                    Ok(last.clone()),
                    "a horizon, and the other is whole"
                );
            } else {
                assert!(read.is_err(), "bit {bit} of byte {byte}: {read:?}");
            }
        }
    }
}

/// The remains of a crash of the system in files from before there were horizons, and in files whose horizons are both gone.
#[test]
fn a_file_without_a_horizon_ends_where_only_zeros_follow() {
    let mut without = example();
    without[4096..12_288].fill(0);
    let last = history().pop().expect("there are steps");
    for zeros in [1, 78, 4096] {
        let mut bytes = without.clone();
        bytes.resize(bytes.len() + zeros, 0);
        let contents = parse(&bytes).unwrap_or_else(|damage| panic!("{zeros} zeros: {damage}"));
        assert_eq!((&contents.state, contents.cut_off), (&last, zeros));
    }
    let mut bytes = without.clone();
    bytes.extend_from_slice(&[0, 0, 0, 1, 0, 0, 0, 0, 0]);
    assert!(matches!(parse(&bytes), Err(Damage::Checksum { .. })), "other bytes");
    let mut bytes = without.clone();
    bytes[12_300] ^= 1;
    assert!(parse(&bytes).is_err(), "and no record is cut off that was whole");
}

/// A file of the format before, as a server of that version wrote it.
#[test]
fn a_file_of_format_2_is_read() {
    let records = &example()[12_288..];
    let mut bytes = b"ARCSTATE\x02\0\0\0".to_vec();
    let mut chain = crc32fast::hash(&bytes);
    bytes.extend_from_slice(&chain.to_le_bytes());
    let mut rest = records;
    while let Some((length, tail)) = rest.split_first_chunk::<4>() {
        let data = &tail[4..][..u32::from_le_bytes(*length) as usize];
        for part in [length.as_slice(), data] {
            let mut hasher = crc32fast::Hasher::new_with_initial(chain);
            hasher.update(part);
            chain = hasher.finalize();
            bytes.extend_from_slice(part);
            bytes.extend_from_slice(&chain.to_le_bytes());
        }
        rest = &tail[4 + data.len() + 4..];
    }
    let last = history().pop().expect("there are steps");
    let contents = parse(&bytes).expect("whole");
    assert_eq!((&contents.state, contents.cut_off), (&last, 0));
    let synchronised = bytes.len();
    bytes.resize(synchronised + 78, 0);
    let contents = parse(&bytes).expect("zeros of a crash");
    assert_eq!((&contents.state, contents.cut_off), (&last, 78));
    bytes[synchronised - 30] ^= 4;
    assert!(parse(&bytes).is_err());
}

#[test]
fn a_record_that_is_missing_repeated_or_moved_is_found() {
    let bytes = synchronised(example());
    let mut chain = format::fresh(&first()).1;
    let mut ends = vec![format::fresh(&first()).0.len()];
    for step in steps() {
        let mut record = Vec::new();
        chain.push(&step, &mut record);
        ends.push(ends.last().expect("the first") + record.len());
    }
    let [state, one, two, three, _] = ends[..] else {
        panic!("{ends:?} are not the ends of a state and four changes")
    };
    let join = |parts: &[&[u8]]| parts.concat();
    let cases = [
        ("missing", join(&[&bytes[..state], &bytes[one..]])),
        ("repeated", join(&[&bytes[..one], &bytes[state..]])),
        (
            "moved",
            join(&[&bytes[..state], &bytes[one..two], &bytes[state..one], &bytes[two..]]),
        ),
        ("a state among changes", join(&[&bytes[..three], &bytes[12_288..state]])),
    ];
    for (why, bytes) in cases {
        let read = parse(&bytes);
        assert!(matches!(read, Err(Damage::Checksum { .. })), "{why}: {read:?}");
    }
}

#[test]
fn foreign_files() {
    let mut newer = b"ARCSTATE\x04\0\0\0".to_vec();
    newer.extend_from_slice(&crc32fast::hash(&newer).to_le_bytes());
    newer.extend_from_slice(b"whatever it holds");
    #[rustfmt::skip]
    let cases: [(&str, &[u8], &str); 6] = [
        ("another version",  &newer,                       "it has format 4, and this version of Arcline reads format 3"),
        ("a configuration",  b"[server]\nname = \"A\"\n",  "it is not a retained state of Arcline"),
        ("zeros",            &[0; 4096],                   "it is not a retained state of Arcline"),
        ("nothing",          b"",                          "it ends after 0 bytes, before its first state is whole"),
        ("nearly",           b"ARCSTATUS and more of it",  "it is not a retained state of Arcline"),
        ("its name only",    b"ARCSTATE",                  "it ends after 8 bytes, before its first state is whole"),
    ];
    for (why, bytes, expected) in cases {
        let error = parse(bytes).expect_err(why);
        assert_eq!(error.to_string(), expected, "{why}");
    }
}

#[test]
fn contents_beyond_their_limits_are_refused() {
    let mut named = first();
    named.axes[1].name = "n".repeat(MAX_TEXT + 1);
    let mut nowhere = first();
    nowhere.axes[1].state.position = f64::NAN;
    let mut large = first();
    large.tags[0].bytes = vec![0; MAX_TAG_BYTES + 1];
    let many = RetainedState {
        axes: (0..=MAX_AXES).map(|_| axis("X", 0.0)).collect(),
        tags: Vec::new(),
    };
    let cases = [
        (named, "it has 256 bytes in a name, and there are at most 255"),
        (nowhere, "the position of its axis 1 is not a number"),
        (large, "it has 8388609 bytes in a tag, and there are at most 8388608"),
        (many, "it has 4097 axes, and there are at most 4096"),
    ];
    for (state, expected) in cases {
        let error = parse(&format::fresh(&state).0).expect_err(expected);
        assert_eq!(error.to_string(), expected);
    }
    let changes = [
        (moved(2, 0.0, false), "it changes axes number 2, which it does not have"),
        (
            moved(0, f64::INFINITY, false),
            "the position of its axis 0 is not a number",
        ),
        (
            written(0, 1, &[0; 4]),
            "it changes tags number 0, which it does not have",
        ),
        (
            written(7, u32::MAX, &[0]),
            "it changes tags number 7, which it does not have",
        ),
    ];
    for (change, expected) in changes {
        let (mut bytes, mut chain) = format::fresh(&first());
        chain.push(&Record::Changes(vec![change]), &mut bytes);
        let error = parse(&synchronised(bytes)).expect_err(expected);
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn a_file_is_set_aside_and_never_written_over() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    for (number, text) in (1..).zip(["one", "two", "three"]) {
        fs::write(&file, text).expect("a writable folder");
        let locked = LockedFile::lock(&file).expect("nobody has it");
        assert!(matches!(locked.read(), Err(ReadError::Damage(Damage::NotAState))));
        let aside = locked.set_aside().expect("a writable folder");
        let expected = folder.path().join(format!("machine.state.set-aside-{number}"));
        assert_eq!(aside, expected.canonicalize().expect("it is there"));
        assert!(!file.exists());
    }
    for (number, text) in (1..).zip(["one", "two", "three"]) {
        let aside = folder.path().join(format!("machine.state.set-aside-{number}"));
        assert_eq!(fs::read_to_string(aside).expect("it is there"), text);
    }
}

#[test]
fn one_process_has_a_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    let first_one = LockedFile::lock(&file).expect("nobody has it");
    assert!(matches!(LockedFile::lock(&file), Err(OpenError::InUse)));
    drop(first_one);
    assert!(LockedFile::lock(&file).is_ok());
    assert!(matches!(LockedFile::lock(folder.path()), Err(OpenError::NotAFile)));
    let nowhere = folder.path().join("missing").join("machine.state");
    assert!(matches!(LockedFile::lock(&nowhere), Err(OpenError::Io(_))));
}

#[test]
fn a_long_file_is_written_anew_while_changes_go_on() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    let locked = LockedFile::lock(&file).expect("no other process has it");
    let pace = Pace {
        growth: 100_000,
        ..Pace::default()
    };
    let mut writer = Writer::start(locked, first(), pace, Duration::ZERO);
    let mut state = first();
    let mut step = |writer: &mut Writer<System, ()>| {
        let count = u32::from_le_bytes(state.tags[0].bytes[..].try_into().expect("a DINT")) + 1;
        let record = Record::Changes(vec![written(0, 0, &count.to_le_bytes()); 100]);
        state.apply(&record).expect("it has them");
        writer.keep(record, ());
        let task = writer.turn(Duration::ZERO);
        assert_eq!(read_unlocked(&file), state, "with every change");
        task
    };
    let task = std::iter::from_fn(|| Some(step(&mut writer))).find_map(|task| task);
    let long = fs::metadata(&file).expect("it is there").len();
    for _ in 0..10 {
        assert!(step(&mut writer).is_none(), "it is under way");
    }
    writer.ended(task.expect("it is long").run(), Duration::ZERO);
    let folder_task = step(&mut writer).expect("the folder is synchronised next");
    writer.ended(folder_task.run(), Duration::ZERO);
    step(&mut writer);
    let short = fs::metadata(&file).expect("it is there").len();
    assert!(short < 50_000 && 100_000 < long, "from {long} to {short} bytes");
}

/// A reader would take it for damage, and everything behind it with it.
#[test]
fn a_record_that_is_longer_than_a_reader_takes_is_refused_and_the_state_written_anew() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    let mut large = first();
    large.tags[1].bytes = vec![0; MAX_TAG_BYTES];
    let mut writer = begin(&file, large.clone());
    let all = Record::Changes(vec![written(1, 0, &vec![7; MAX_TAG_BYTES]); 17]);
    assert_eq!(keep(&mut writer, all), Err(NotPersisted));
    large.tags[1].bytes.fill(7);
    let later = Duration::from_secs(2);
    for _ in 0..2 {
        let task = writer.turn(later).expect("it is written anew");
        writer.ended(task.run(), later);
    }
    assert_eq!(read_unlocked(&file), large);
    assert_eq!(keep(&mut writer, Record::Changes(vec![written(1, 0, &[1])])), Ok(()));
}

/// Its room on a full disk is that of others.
#[test]
fn a_new_file_that_cannot_be_written_is_emptied() {
    let disk = Recording::default();
    let file = Path::new("machine.state");
    let locked = LockedFile::lock_on(disk.clone(), file.to_owned()).expect("a lock");
    let pace = Pace {
        growth: 1000,
        ..Pace::default()
    };
    let mut writer: Writer<Recording, ()> = Writer::start(locked, first(), pace, Duration::ZERO);
    disk.fail(Box::new(|_, kind| kind == Kind::Sync));
    let task = std::iter::from_fn(|| {
        writer.keep(Record::Changes(vec![written(0, 0, &[1]); 100]), ());
        Some(writer.turn(Duration::ZERO))
    });
    let task = task.flatten().next().expect("it has grown");
    writer.ended(task.run(), Duration::ZERO);
    let beside = disk.read(Path::new("machine.state.new"), MAX_FILE);
    assert_eq!(beside.expect("it is read"), Some(Vec::new()));
    assert!(
        writer
            .actions()
            .any(|action| matches!(action, Action::Report(Report::Grows(_))))
    );
}

#[test]
fn a_link_in_the_way_of_the_new_file_is_not_followed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [file, other] = ["machine.state", "other"].map(|name| folder.path().join(name));
    fs::write(&other, "of another user").expect("a writable folder");
    std::os::unix::fs::symlink(&other, folder.path().join("machine.state.new")).expect("a writable folder");
    drop(begin(&file, first()));
    assert_eq!(fs::read_to_string(&other).expect("it is there"), "of another user");
    assert_eq!(read(&file), Some(first()));
    let mode = std::os::unix::fs::PermissionsExt::mode(&fs::metadata(&file).expect("it is there").permissions());
    assert_eq!(mode & 0o777, 0o600, "readable by its owner only");
}

fn any_state() -> impl Strategy<Value = RetainedState> {
    let number = any::<f64>().prop_filter("positions are finite", |number| number.is_finite());
    let numbers = (number.clone(), number);
    let state = (numbers, any::<bool>(), any::<bool>(), any::<u32>()).prop_map(
        |((position, redefined), homed, moving, faults)| AxisState {
            position,
            homed,
            moving,
            faults,
            redefined,
        },
    );
    let axis = (".{0,20}", ".{0,20}", state).prop_map(|(name, kind, state)| Axis { name, kind, state });
    let tag = (".{0,20}", ".{0,20}", prop::collection::vec(any::<u8>(), 0..100)).prop_map(|(name, kind, bytes)| Tag {
        name,
        kind,
        bytes,
    });
    (prop::collection::vec(axis, 0..8), prop::collection::vec(tag, 0..8))
        .prop_map(|(axes, tags)| RetainedState { axes, tags })
}

proptest! {
    #[test]
    fn any_state_is_read_as_it_was_written(state in any_state()) {
        let (bytes, _) = format::fresh(&state);
        prop_assert_eq!(parse(&bytes).map(|contents| contents.state), Ok(state));
    }

    /// Any bytes in a file are read to a state or an error. The checksums are right, so that the reader decodes the
    /// records.
    #[test]
    fn any_bytes_in_a_record_are_a_state_or_an_error(data in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut bytes = format::fresh(&RetainedState::default()).0[..12_288].to_vec();
        let mut chain = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]);
        for part in [&(data.len() as u32).to_le_bytes()[..], &data[..]] {
            let mut hasher = crc32fast::Hasher::new_with_initial(chain);
            hasher.update(part);
            chain = hasher.finalize();
            bytes.extend_from_slice(part);
            bytes.extend_from_slice(&chain.to_le_bytes());
        }
        if let Ok(contents) = parse(&bytes) {
            prop_assert!(contents.state.check().is_ok());
        }
    }

    #[test]
    fn any_bytes_are_a_state_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(parse(&bytes).is_err());
    }
}
