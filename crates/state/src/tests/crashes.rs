//! Every content of the file that a crash after any call may leave, compared with the answers to the clients.
//!
//! The bounds come from the calls and the answers alone: at least the answered records (process), or those synchronised under a name that the
//! disk had (system); at most the sent ones, in whole records.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::recording::{Call, Crashes, Inode, Kind, Recording, Rules};

/// One step of a script.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// A client writes this number of bytes of the table.
    Write(usize),
    /// The table of tags changes.
    Table,
    /// The disk ends the task under way, if there is one.
    Disk,
    /// A pause goes by.
    Pause,
    /// From now on calls of this kind fail.
    Fail(Kind),
    /// From now on all calls succeed.
    Mend,
}
use Step::{Disk as Ends, Fail, Mend, Pause, Table, Write};

enum Under {
    Begun(Task<Recording>),
    Done(Ended),
}

/// A writer on a recording disk, with the records it was sent and its answers.
struct Scene {
    disk: Recording,
    writer: Writer<Recording, usize>,
    /// The task under way. The disk carries every other one out when it is handed out, the rest when they end.
    task: Option<Under>,
    tasks: usize,
    now: Duration,
    /// The states that there were, the first one first.
    history: Vec<RetainedState>,
    /// Records that had been sent when each call was made.
    sent: Vec<usize>,
    /// Calls that had been made when a record was answered, the number of the record counted from 1, and the answer.
    answers: Vec<(usize, usize, Result<(), NotPersisted>)>,
}

impl Scene {
    fn start(disk: Recording, state: RetainedState) -> Self {
        let locked = LockedFile::lock_on(disk.clone(), file()).expect("a lock");
        let pace = Pace {
            growth: 48 * 1024,
            ..Pace::default()
        };
        let writer = Writer::start(locked, state.clone(), pace, Duration::ZERO);
        Scene {
            sent: vec![0; disk.count()],
            disk,
            writer,
            task: None,
            tasks: 0,
            now: Duration::ZERO,
            history: vec![state],
            answers: Vec::new(),
        }
    }

    fn step(&mut self, step: Step) {
        match step {
            Write(bytes) => {
                let number = self.history.len();
                let bytes = (0..bytes).map(|at| (number + at) as u8).collect();
                let count = number.to_le_bytes()[..4].to_vec();
                let changes = [(0, count), (1, bytes)].map(|(tag, bytes)| Change::Tag { tag, offset: 0, bytes });
                self.send(Record::Changes(changes.to_vec()));
            }
            Table => {
                let mut state = self.history.last().expect("the first state").clone();
                state
                    .tags
                    .push(tag(&format!("New{}", self.history.len()), "DINT", &[7; 4]));
                self.send(Record::State(state));
            }
            Ends => {
                let ended = self.task.take().map(|task| match task {
                    Under::Begun(task) => task.run(),
                    Under::Done(ended) => ended,
                });
                if let Some(ended) = ended {
                    self.writer.ended(ended, self.now);
                }
            }
            Pause => self.now += Pace::default().pause,
            Fail(kind) => self.disk.fail(Box::new(move |_, which| which == kind)),
            Mend => self.disk.fail(Box::new(|_, _| false)),
        }
        self.turn();
    }

    fn send(&mut self, record: Record) {
        self.sent.resize(self.disk.count(), self.history.len() - 1);
        let mut state = self.history.last().expect("the first state").clone();
        state.apply(&record).expect("it fits");
        self.history.push(state);
        self.writer.keep(record, self.history.len() - 1);
    }

    fn turn(&mut self) {
        let task = self.writer.turn(self.now);
        if let Some(task) = task {
            assert!(self.task.is_none(), "one task at a time");
            self.tasks += 1;
            let at_once = self.tasks.is_multiple_of(2);
            self.task = Some(if at_once {
                Under::Done(task.run())
            } else {
                Under::Begun(task)
            });
        }
        self.sent.resize(self.disk.count(), self.history.len() - 1);
        for action in self.writer.actions() {
            if let Action::Answer(number, answer) = action {
                self.answers.push((self.disk.count(), number, answer));
            }
        }
    }

    /// Records that a crash behind these calls always leaves in the file.
    fn at_least(&self, calls: &[Call], rules: Rules) -> Option<usize> {
        match rules {
            Rules::Process => {
                let answered = self
                    .answers
                    .iter()
                    .filter(|(at, _, answer)| *at < calls.len() && answer.is_ok());
                let named = calls.iter().any(|call| matches!(call, Call::Rename(..)));
                named.then(|| answered.map(|(_, number, _)| *number).max().unwrap_or(0))
            }
            Rules::Ordered | Rules::Weak => self.synchronised(calls),
        }
    }

    /// Records that a synchronisation covers of the file to which the disk has the name; `None`: it has no name.
    fn synchronised(&self, calls: &[Call]) -> Option<usize> {
        // Records that each file has, and those of them that its last synchronisation covers.
        let mut files = BTreeMap::<Inode, (usize, Option<usize>)>::new();
        let mut bad: Vec<Inode> = Vec::new();
        let (mut named, mut disk) = (BTreeMap::<&Path, Inode>::new(), None);
        for (call, sent) in calls.iter().zip(&self.sent) {
            match call {
                Call::Create(name, inode) => {
                    named.insert(name, *inode);
                    files.insert(*inode, (0, None));
                }
                Call::Append(inode, _) => files.get_mut(inode).expect("created").0 = *sent,
                Call::FailedAppend(..) | Call::FailedRename(..) | Call::Overwrite(..) => {}
                Call::Sync(inode) if !bad.contains(inode) => {
                    let (records, synchronised) = files.get_mut(inode).expect("created");
                    *synchronised = Some(*records);
                }
                Call::Sync(_) => {}
                Call::FailedSync(inode) => bad.push(*inode),
                Call::Rename(from, to) => {
                    let inode = named.remove(from.as_path()).expect("it has the name");
                    named.insert(to, inode);
                }
                Call::SyncFolder => disk = named.get(file().as_path()).copied(),
            }
        }
        files.get(&disk?)?.1
    }

    /// Holds every content behind every call against the bounds. Returns how many there were.
    fn hold(&self, what: &str, most: usize) -> usize {
        let (calls, name) = (self.disk.calls(), file());
        let mut random = arbitrary(0x5EED);
        let mut states = 0;
        for behind in 1..=calls.len() {
            let calls = &calls[..behind];
            let sent = self.sent[behind - 1];
            for rules in [Rules::Process, Rules::Ordered, Rules::Weak] {
                let least = self.at_least(calls, rules);
                let why = || format!("{what}: {rules:?}, behind call {behind}, {}", shown(&calls[behind - 1]));
                let mut number = 0;
                let crashes = Crashes::behind(calls, &name);
                states += crashes.each(rules, most, &mut random, &mut |content| {
                    number += 1;
                    let Some(content) = content else {
                        return assert_eq!(least, None, "{}: the file is gone", why());
                    };
                    let contents = parse(content).unwrap_or_else(|damage| panic!("{}: {damage}", why()));
                    let which = self.history.iter().position(|state| *state == contents.state);
                    let which = which.unwrap_or_else(|| panic!("{}: a state that never was", why()));
                    let least = least.unwrap_or(0);
                    assert!(
                        (least..=sent).contains(&which),
                        "{}: {which} records, not {least} to {sent}",
                        why()
                    );
                    if number % 64 == 1 {
                        goes_on(content, &contents.state);
                    }
                });
            }
        }
        states
    }
}

/// A file that was found after a crash is continued: one record more is read back with all that there was.
fn goes_on(content: &[u8], state: &RetainedState) {
    let disk = Recording::with([(file(), content.to_vec())]);
    let mut scene = Scene::start(disk.clone(), state.clone());
    scene.step(Write(10));
    assert_eq!(scene.answers.last().map(|answer| answer.2), Some(Ok(())));
    let read = LockedFile::lock_on(disk, file()).expect("a lock").read();
    assert_eq!(
        read.expect("whole").map(|contents| contents.state),
        scene.history.last().cloned()
    );
}

fn shown(call: &Call) -> String {
    match call {
        Call::Append(inode, bytes) => format!("Append({inode:?}, {} bytes)", bytes.len()),
        Call::Overwrite(inode, at, _) => format!("Overwrite({inode:?}, at {at})"),
        other => format!("{other:?}"),
    }
}

fn file() -> PathBuf {
    PathBuf::from("machine.state")
}

fn table() -> RetainedState {
    RetainedState {
        axes: vec![axis("X", 12.5)],
        tags: vec![tag("Count", "DINT", &[0; 4]), tag("Table", "SINT[12000]", &[0; 12_000])],
    }
}

fn arbitrary(seed: u64) -> impl FnMut(usize) -> usize {
    let mut random = seed;
    move |below| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    }
}

/// The scripts, by their subjects.
const SCRIPTS: &[(&str, &[Step])] = &[
    (
        "writes, synchronisations, and the file written anew with writes under way",
        &[
            Write(100),
            Write(5000),
            Pause,
            Ends,
            Write(1),
            Write(9000),
            Write(40),
            Pause,
            Write(700),
            Ends,
            Write(12_000),
            Pause,
            Ends,
            Write(12_000),
            Write(11_000),
            Write(3000),
            Write(4096),
            Write(20),
            Ends,
            Write(2048),
            Ends,
            Write(5),
            Ends,
            Pause,
            Ends,
            Write(60),
            Pause,
            Ends,
        ],
    ),
    (
        "other tags",
        &[
            Write(50),
            Table,
            Write(900),
            Pause,
            Ends,
            Table,
            Pause,
            Write(8000),
            Ends,
            Table,
            Write(3),
            Pause,
            Ends,
            Ends,
            Write(4),
            Ends,
        ],
    ),
    (
        "a synchronisation that fails",
        &[
            Write(100),
            Write(5000),
            Pause,
            Ends,
            Write(6000),
            Fail(Kind::Sync),
            Pause,
            Ends,
            Write(30),
            Write(31),
            Pause,
            Ends,
            Mend,
            Write(32),
            Pause,
            Write(7000),
            Ends,
            Write(33),
            Ends,
            Write(34),
            Pause,
            Ends,
            Write(35),
            Pause,
            Ends,
        ],
    ),
    (
        "a synchronisation that fails while the file is written anew",
        &[
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Fail(Kind::Sync),
            Ends,
            Write(9),
            Mend,
            Write(10),
            Pause,
            Ends,
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Ends,
            Write(1),
            Ends,
            Write(2),
            Pause,
            Ends,
        ],
    ),
    (
        "a write that fails half way, and a disk that stays full for a while",
        &[
            Write(100),
            Pause,
            Ends,
            Fail(Kind::Write),
            Write(9000),
            Write(1),
            Pause,
            Pause,
            Write(2),
            Mend,
            Write(3),
            Pause,
            Ends,
            Ends,
            Write(4),
            Pause,
            Ends,
            Write(5),
        ],
    ),
    (
        "a rename and a folder that cannot be synchronised",
        &[
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Fail(Kind::Rename),
            Ends,
            Write(1),
            Mend,
            Pause,
            Ends,
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Write(12_000),
            Ends,
            Fail(Kind::SyncFolder),
            Write(2),
            Ends,
            Write(3),
            Mend,
            Pause,
            Ends,
            Write(4),
            Ends,
            Write(5),
            Pause,
            Ends,
        ],
    ),
    (
        "a write that fails between the rename of the new file and the synchronisation of the folder",
        &[
            Write(100),
            Fail(Kind::Sync),
            Pause,
            Ends,
            Mend,
            Pause,
            Write(5),
            Ends,
            Fail(Kind::Write),
            Write(900),
            Mend,
            Ends,
            Write(1),
            Pause,
            Ends,
            Ends,
            Ends,
            Pause,
            Ends,
            Ends,
            Ends,
            Write(2),
            Pause,
            Ends,
        ],
    ),
];

/// Steps that are drawn, and at the end a disk that works.
fn drawn(seed: u64) -> Vec<Step> {
    let mut random = arbitrary(0x9E37_79B9_7F4A_7C15 ^ seed);
    let kinds = [Kind::Create, Kind::Write, Kind::Sync, Kind::Rename, Kind::SyncFolder];
    let mut step = || match random(12) {
        0..=3 => Write(random(12_000)),
        4 => Write(random(50)),
        5 => Table,
        6..=7 => Pause,
        8..=9 => Ends,
        10 => Fail(kinds[random(kinds.len())]),
        _ => Mend,
    };
    let mut steps: Vec<Step> = (0..40).map(|_| step()).collect();
    steps.extend([Mend, Ends, Pause, Ends, Ends, Ends, Write(1)]);
    steps
}

fn play(what: &str, script: &[Step], most: usize) -> usize {
    let mut scene = Scene::start(Recording::default(), table());
    script.iter().for_each(|step| scene.step(*step));
    assert_eq!(
        scene.answers.len(),
        scene.history.len() - 1,
        "{what}: every record is answered"
    );
    let last = scene.answers.last().map(|answer| answer.2);
    assert_eq!(last, Some(Ok(())), "{what}: it is kept again at the end");
    [Pause, Ends, Ends, Ends, Pause, Ends]
        .into_iter()
        .for_each(|step| scene.step(step));
    let synchronised = scene.synchronised(&scene.disk.calls());
    assert_eq!(
        synchronised,
        Some(scene.history.len() - 1),
        "{what}: the disk has everything after a pause"
    );
    scene.hold(what, most)
}

/// Plays as many scripts, on as many threads as there are processors: this test takes longer than all others of the crate together. Returns the
/// contents that there were.
fn on_all_processors(scripts: usize, play: impl Fn(usize) -> usize + Sync) -> usize {
    let next = AtomicUsize::new(0);
    let work = || -> usize {
        std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed))
            .take_while(|number| *number < scripts)
            .map(&play)
            .sum()
    };
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().expect("a script failed, see above"))
            .sum()
    })
}

#[test]
fn every_crash_leaves_all_answered_changes_and_none_that_was_not_sent() {
    let long = std::env::var_os("ARCLINE_LONG").is_some();
    let (most, scripts) = if long { (10_000, 500) } else { (1000, 20) };
    let told = on_all_processors(SCRIPTS.len(), |number| {
        let (what, script) = SCRIPTS[number];
        play(what, script, most)
    });
    let drawn = on_all_processors(scripts, |seed| {
        play(&format!("script {seed}"), &drawn(seed as u64), most / 10)
    });
    println!("{told} and {drawn} contents of the file after a crash, and none has lost what was answered");
    assert!(told + drawn >= 100_000, "only {told} and {drawn} contents");
}
