//! Files as written, cut off, damaged and foreign.

use std::fs;
use std::path::Path;

use proptest::prelude::*;

use crate::*;

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

fn first() -> State {
    State {
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

/// What is written after another in the files of these tests.
fn steps() -> Vec<Vec<Change>> {
    vec![
        vec![written(0, 0, &[9, 0, 0, 0])],
        vec![moved(0, 13.0, true), moved(1, 0.5, true)],
        vec![written(1, 4, &[1, 1, 1, 1]), written(0, 2, &[5])],
        vec![moved(0, 99.0, false)],
    ]
}

/// Every state that there was, in order.
fn history() -> Vec<State> {
    let mut state = first();
    let mut all = vec![state.clone()];
    for step in steps() {
        step.iter()
            .try_for_each(|change| state.apply(change))
            .expect("it has them");
        all.push(state.clone());
    }
    all
}

fn begin(file: &Path, state: State) -> Store {
    let place = Place::lock(file).expect("nobody has it");
    let kept = place.read().expect("whole");
    place.begin(state, kept).expect("a writable folder")
}

fn read(file: &Path) -> Option<State> {
    let kept = Place::lock(file).expect("nobody has it").read();
    kept.expect("whole").map(|kept| kept.state)
}

/// A file with the first state and every step.
fn example() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    let mut store = begin(&file, first());
    for step in steps() {
        store.append([step.as_slice()]).expect("a writable file");
    }
    fs::read(&file).expect("it was written")
}

#[test]
fn what_was_appended_is_read_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    assert_eq!(read(&file), None, "nothing was ever kept");
    let mut store = begin(&file, first());
    assert_eq!(read_unlocked(&file), first(), "at once");
    for (step, expected) in steps().iter().zip(history().iter().skip(1)) {
        store.append([step.as_slice()]).expect("a writable file");
        assert_eq!(read_unlocked(&file), *expected);
        assert_eq!(store.state(), expected);
    }
    drop(store);
    let last = history().pop();
    assert_eq!(read(&file), last);
    let length = fs::metadata(&file).expect("it is there").len();
    let mut store = begin(&file, last.clone().expect("there are steps"));
    let continued = fs::metadata(&file).expect("it is there").len();
    assert_eq!(continued, length, "the same axes and tags go on where they were");
    store.append([steps()[0].as_slice()]).expect("a writable file");
    drop(store);
    let mut other = last.expect("there are steps");
    other.tags.push(tag("New", "BOOL", &[1]));
    drop(begin(&file, other.clone()));
    assert_eq!(read(&file), Some(other), "other tags: written anew");
}

fn read_unlocked(file: &Path) -> State {
    let bytes = fs::read(file).expect("it is there");
    parse(&bytes).expect("whole").state
}

#[test]
fn a_file_cut_off_anywhere_is_a_state_that_there_was() {
    let (bytes, history) = (example(), history());
    let mut seen = Vec::new();
    for length in 0..=bytes.len() {
        match parse(&bytes[..length]) {
            Ok(kept) => {
                let which = history.iter().position(|state| *state == kept.state);
                let which = which.unwrap_or_else(|| panic!("cut at {length}: {:?} never was", kept.state));
                assert!(kept.end <= length, "cut at {length}");
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
fn what_was_cut_off_is_overwritten() {
    let (bytes, history) = (example(), history());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    for length in 0..bytes.len() {
        fs::write(&file, &bytes[..length]).expect("a writable folder");
        let Ok(kept) = parse(&bytes[..length]) else { continue };
        let was = history.iter().position(|state| *state == kept.state);
        let mut store = begin(&file, kept.state);
        store.append([steps()[0].as_slice()]).expect("a writable file");
        drop(store);
        let mut expected = history[was.expect("a state that there was")].clone();
        steps()[0]
            .iter()
            .try_for_each(|change| expected.apply(change))
            .expect("it has them");
        assert_eq!(read(&file), Some(expected), "cut at {length}");
    }
}

#[test]
fn a_bit_that_has_flipped_anywhere_is_found() {
    let bytes = example();
    for place in 0..bytes.len() {
        for bit in 0..8 {
            let mut bytes = bytes.clone();
            bytes[place] ^= 1 << bit;
            let read = parse(&bytes);
            assert!(read.is_err(), "bit {bit} of byte {place}: {read:?}");
        }
    }
}

#[test]
fn a_record_that_is_missing_repeated_or_moved_is_found() {
    let bytes = example();
    let ends: Vec<usize> = (0..=bytes.len())
        .filter_map(|length| parse(&bytes[..length]).ok().filter(|kept| kept.end == length))
        .map(|kept| kept.end)
        .collect();
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
        ("a state among changes", join(&[&bytes[..three], &bytes[16..state]])),
    ];
    for (why, bytes) in cases {
        let read = parse(&bytes);
        assert!(matches!(read, Err(Damage::Checksum { .. })), "{why}: {read:?}");
    }
}

#[test]
fn foreign_files() {
    let mut newer = b"ARCSTATE\x03\0\0\0".to_vec();
    newer.extend_from_slice(&crc32fast::hash(&newer).to_le_bytes());
    newer.extend_from_slice(b"whatever it holds");
    #[rustfmt::skip]
    let cases: [(&str, &[u8], &str); 6] = [
        ("another version",  &newer,                       "it has format 3, and this version of Arcline reads format 2"),
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
    let many = State {
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
        format::changes(&[change], &mut chain, &mut bytes);
        let error = parse(&bytes).expect_err(expected);
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn a_file_is_set_aside_and_never_written_over() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    for (number, text) in (1..).zip(["one", "two", "three"]) {
        fs::write(&file, text).expect("a writable folder");
        let place = Place::lock(&file).expect("nobody has it");
        assert!(matches!(place.read(), Err(ReadError::Damage(Damage::NotAState))));
        let aside = place.set_aside().expect("a writable folder");
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
    let first_one = Place::lock(&file).expect("nobody has it");
    assert!(matches!(Place::lock(&file), Err(OpenError::InUse)));
    drop(first_one);
    assert!(Place::lock(&file).is_ok());
    assert!(matches!(Place::lock(folder.path()), Err(OpenError::NotAFile)));
    let nowhere = folder.path().join("missing").join("machine.state");
    assert!(matches!(Place::lock(&nowhere), Err(OpenError::Io(_))));
}

#[test]
fn a_long_file_is_written_anew_while_changes_go_on() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("machine.state");
    let mut store = begin(&file, first());
    let mut count = 0_u32;
    let mut step = |store: &mut Store| {
        count += 1;
        let change = [written(0, 0, &count.to_le_bytes())];
        store.append([change.as_slice()]).expect("a writable file");
    };
    while !store.wants_rewrite() {
        step(&mut store);
    }
    let long = fs::metadata(&file).expect("it is there").len();
    store
        .begin_rewrite()
        .and_then(|new| new.sync_all())
        .expect("a writable folder");
    assert!(!store.wants_rewrite(), "it is under way");
    for _ in 0..10 {
        step(&mut store);
        assert_eq!(read_unlocked(&file), *store.state(), "the old file is still the state");
    }
    store.finish_rewrite().expect("a writable folder");
    assert_eq!(read_unlocked(&file), *store.state(), "with what came meanwhile");
    step(&mut store);
    assert_eq!(read_unlocked(&file), *store.state());
    let short = fs::metadata(&file).expect("it is there").len();
    assert!(short < 1000 && 1_000_000 < long, "from {long} to {short} bytes");
    assert!(store.finish_rewrite().is_err(), "nothing is under way");
    store.begin_rewrite().expect("a writable folder");
    let state = store.state().clone();
    drop(store);
    assert_eq!(
        begin(&file, state.clone()).state(),
        &state,
        "one that was never finished does not matter"
    );
}

fn any_state() -> impl Strategy<Value = State> {
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
    (prop::collection::vec(axis, 0..8), prop::collection::vec(tag, 0..8)).prop_map(|(axes, tags)| State { axes, tags })
}

proptest! {
    #[test]
    fn any_state_is_read_as_it_was_written(state in any_state()) {
        let (bytes, _) = format::fresh(&state);
        prop_assert_eq!(parse(&bytes).map(|kept| kept.state), Ok(state));
    }

    #[test]
    fn changes_lead_from_one_state_to_the_other(was in any_state(), seed in any::<u64>()) {
        let mut next = was.clone();
        for (place, axis) in next.axes.iter_mut().enumerate().filter(|(place, _)| seed >> place & 1 == 1) {
            axis.state.position += place as f64 + 1.0;
            axis.state.moving = !axis.state.moving;
        }
        for tag in next.tags.iter_mut().step_by(2) {
            tag.bytes.iter_mut().for_each(|byte| *byte = byte.wrapping_add(seed as u8));
        }
        let changes = was.changes_to(&next).expect("the same axes and tags");
        let (mut bytes, mut chain) = format::fresh(&was);
        format::changes(&changes, &mut chain, &mut bytes);
        prop_assert_eq!(parse(&bytes).map(|kept| kept.state), Ok(next.clone()));
        next.axes.push(axis("one more", 0.0));
        prop_assert_eq!(was.changes_to(&next), None);
    }

    /// Whatever stands in a file, reading it ends, in a state or in an error. The checksums are right, so that the
    /// records are looked at.
    #[test]
    fn any_bytes_in_a_record_are_a_state_or_an_error(data in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut bytes = format::fresh(&State::default()).0[..16].to_vec();
        let mut chain = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]);
        for part in [&(data.len() as u32).to_le_bytes()[..], &data[..]] {
            let mut hasher = crc32fast::Hasher::new_with_initial(chain);
            hasher.update(part);
            chain = hasher.finalize();
            bytes.extend_from_slice(part);
            bytes.extend_from_slice(&chain.to_le_bytes());
        }
        if let Ok(kept) = parse(&bytes) {
            prop_assert!(kept.state.check().is_ok());
        }
    }

    #[test]
    fn any_bytes_are_a_state_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(parse(&bytes).is_err());
    }
}
