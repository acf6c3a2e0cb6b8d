//! A disk in memory that records every call, and every content that a crash may leave behind.
//!
//! [`Recording`] is used like any disk. For a prefix of its calls, [`Crashes`] lists the files that may be found after a crash, by the
//! rules of one kind of crash ([`Rules`]): the end of the process, the end of the system on a file system that keeps data in order, or on
//! one that keeps no more than it promises (ALICE, OSDI 2014: the abstract persistence model).

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::{Disk, OpenError};

/// A file by its identity; a name points at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Inode(usize);

/// A call that changed the disk, or synchronised it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Call {
    /// A new, empty file has the name.
    Create(PathBuf, Inode),
    /// Bytes at the end of a file.
    Append(Inode, Vec<u8>),
    /// The part of them that was written by an append that has failed.
    FailedAppend(Inode, Vec<u8>),
    /// Bytes inside a file, at an offset.
    Overwrite(Inode, usize, Vec<u8>),
    /// A synchronisation of a file that has succeeded.
    Sync(Inode),
    /// A synchronisation of a file that has failed.
    FailedSync(Inode),
    /// A file has another name, in place of the file that had it.
    Rename(PathBuf, PathBuf),
    /// A renaming that has failed. The disk may have made it all the same.
    FailedRename(PathBuf, PathBuf),
    /// A synchronisation of the folder that has succeeded.
    SyncFolder,
}

/// Decides by the number of a call, counted from 0, whether it fails.
pub type Fails = Box<dyn Fn(usize, Kind) -> bool + Send>;

/// The kinds of calls that can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// [`Disk::create`].
    Create,
    /// [`Disk::append`] and [`Disk::overwrite`].
    Write,
    /// [`Disk::sync`].
    Sync,
    /// [`Disk::rename`].
    Rename,
    /// [`Disk::sync_folder`].
    SyncFolder,
}

/// A disk in memory.
#[derive(Clone, Default)]
pub struct Recording(Arc<Mutex<Recorded>>);

#[derive(Default)]
struct Recorded {
    calls: Vec<Call>,
    files: Files,
    fails: Option<Fails>,
    asked: usize,
}

/// Files and their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Files {
    names: BTreeMap<PathBuf, Inode>,
    contents: Vec<Vec<u8>>,
}

impl Recording {
    /// A disk that has these files, all of them synchronised.
    pub fn with(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        let mut recorded = Recorded::default();
        for (name, content) in files {
            let inode = Inode(recorded.files.contents.len());
            for call in [
                Call::Create(name, inode),
                Call::Append(inode, content),
                Call::Sync(inode),
            ] {
                recorded.carry_out(call);
            }
        }
        recorded.carry_out(Call::SyncFolder);
        Recording(Arc::new(Mutex::new(recorded)))
    }

    /// Makes calls fail from now on if `fails` returns true for them.
    pub fn fail(&self, fails: Fails) {
        let mut recorded = self.lock_recorded();
        recorded.fails = Some(fails);
        recorded.asked = 0;
    }

    /// The calls so far.
    pub fn calls(&self) -> Vec<Call> {
        self.lock_recorded().calls.clone()
    }

    /// Reads the calls so far, without a copy of them.
    pub fn with_calls<T>(&self, look: impl FnOnce(&[Call]) -> T) -> T {
        look(&self.lock_recorded().calls)
    }

    /// The newest call.
    pub fn last(&self) -> Option<Call> {
        self.lock_recorded().calls.last().cloned()
    }

    /// Whether a name points at this file.
    pub fn is_named(&self, inode: Inode, name: &Path) -> bool {
        self.lock_recorded().files.names.get(name) == Some(&inode)
    }

    /// Whether a wanted name exists.
    pub fn has(&self, is_wanted: impl Fn(&Path) -> bool) -> bool {
        self.lock_recorded().files.names.keys().any(|name| is_wanted(name))
    }

    /// The disk after the system has ended behind the newest call: under each name one of the contents that it may have then. `random`
    /// draws below a number.
    pub fn crashed(&self, rules: Rules, random: &mut dyn FnMut(usize) -> usize) -> Recording {
        let calls = self.calls();
        let mut names = BTreeSet::new();
        for call in &calls {
            if let Call::Create(name, _) | Call::Rename(_, name) = call {
                names.insert(name.as_path());
            }
        }
        let mut files = Vec::new();
        for name in names {
            let found = Crashes::behind(&calls, name).draw(rules, random);
            files.extend(found.map(|content| (name.to_owned(), content)));
        }
        Recording::with(files)
    }

    /// The number of calls.
    pub fn count(&self) -> usize {
        self.lock_recorded().calls.len()
    }

    fn lock_recorded(&self) -> MutexGuard<'_, Recorded> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Carries a call out unless it is to fail.
    fn call(&self, kind: Kind, call: impl FnOnce(&mut Files) -> Call) -> io::Result<Call> {
        let mut recorded = self.lock_recorded();
        let number = recorded.asked;
        recorded.asked += 1;
        if recorded.fails.as_ref().is_some_and(|fails| fails(number, kind)) {
            return Err(io::Error::other("an input/output error by design"));
        }
        let call = call(&mut recorded.files);
        recorded.carry_out(call.clone());
        Ok(call)
    }
}

impl Recorded {
    fn carry_out(&mut self, call: Call) {
        self.files.apply(&call);
        self.calls.push(call);
    }
}

impl Files {
    fn apply(&mut self, call: &Call) {
        match call {
            Call::Create(name, inode) => {
                self.contents.resize(self.contents.len().max(inode.0 + 1), Vec::new());
                self.names.insert(name.clone(), *inode);
            }
            Call::Append(inode, bytes) | Call::FailedAppend(inode, bytes) => {
                self.contents[inode.0].extend_from_slice(bytes)
            }
            Call::Overwrite(inode, offset, bytes) => {
                self.contents[inode.0][*offset..offset + bytes.len()].copy_from_slice(bytes);
            }
            Call::Rename(from, to) => {
                let inode = self.names.remove(from).expect("the name that is renamed exists");
                self.names.insert(to.clone(), inode);
            }
            Call::Sync(_) | Call::FailedSync(_) | Call::FailedRename(..) | Call::SyncFolder => {}
        }
    }
}

impl Disk for Recording {
    type File = Inode;

    fn lock(&self, _: &Path) -> Result<Inode, OpenError> {
        Ok(Inode(usize::MAX))
    }

    fn read(&self, name: &Path, most: usize) -> io::Result<Option<Vec<u8>>> {
        let recorded = self.lock_recorded();
        let Some(inode) = recorded.files.names.get(name) else {
            return Ok(None);
        };
        let content = &recorded.files.contents[inode.0];
        if content.len() > most {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        Ok(Some(content.clone()))
    }

    fn create(&self, name: &Path) -> io::Result<Inode> {
        let call = self.call(Kind::Create, |files| {
            Call::Create(name.to_owned(), Inode(files.contents.len()))
        })?;
        match call {
            Call::Create(_, inode) => Ok(inode),
            other => unreachable!("{other:?} was made above"),
        }
    }

    /// A write that fails leaves half of its bytes.
    fn append(&self, file: &Inode, bytes: &[u8]) -> io::Result<()> {
        let written = self.call(Kind::Write, |_| Call::Append(*file, bytes.to_vec()));
        if written.is_err() {
            let mut recorded = self.lock_recorded();
            recorded.carry_out(Call::FailedAppend(*file, bytes[..bytes.len() / 2].to_vec()));
        }
        written.map(drop)
    }

    fn overwrite(&self, file: &Inode, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let offset = usize::try_from(offset).expect("files in memory are small");
        self.call(Kind::Write, |_| Call::Overwrite(*file, offset, bytes.to_vec()))
            .map(drop)
    }

    fn sync(&self, file: &Inode) -> io::Result<()> {
        let synced = self.call(Kind::Sync, |_| Call::Sync(*file));
        if synced.is_err() {
            self.lock_recorded().calls.push(Call::FailedSync(*file));
        }
        synced.map(drop)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        let renamed = self.call(Kind::Rename, |_| Call::Rename(from.to_owned(), to.to_owned()));
        if renamed.is_err() {
            let failed = Call::FailedRename(from.to_owned(), to.to_owned());
            self.lock_recorded().calls.push(failed);
        }
        renamed.map(drop)
    }

    fn sync_folder(&self) -> io::Result<()> {
        self.call(Kind::SyncFolder, |_| Call::SyncFolder).map(drop)
    }

    fn exists(&self, name: &Path) -> bool {
        self.lock_recorded().files.names.contains_key(name)
    }
}

/// The kind of crash, and the promises of the file system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rules {
    /// The process is killed: all calls that have returned are there, and a part of the one under way.
    Process,
    /// The system ends, on a file system that keeps the data of an append before its length and names in order (ext4, XFS, Btrfs): a prefix
    /// of each.
    Ordered,
    /// The system ends, and the file system promises only the synchronised data: each page, each length, each name on its own. Pages that were
    /// never synchronised hold the data, zeros, part of the data or garbage. A file whose synchronisation has failed once never has the pages that
    /// it failed for synchronised again.
    Weak,
}

/// The contents that one name may have after a crash.
pub struct Crashes<'c> {
    calls: &'c [Call],
    name: &'c Path,
}

impl<'c> Crashes<'c> {
    /// The crash comes behind the last of these calls. The disk was empty before the first.
    pub fn behind(calls: &'c [Call], name: &'c Path) -> Self {
        Crashes { calls, name }
    }

    /// Calls `found` with every content that the file may have, `None` where it does not exist: all of them when there are at most
    /// `most`, otherwise `most` that are drawn. Returns how many there were.
    pub fn each(
        &self,
        rules: Rules,
        most: usize,
        random: &mut dyn FnMut(usize) -> usize,
        found: &mut dyn FnMut(Option<&[u8]>),
    ) -> usize {
        let mut every = |inode: Option<Inode>| match inode {
            None => {
                found(None);
                1
            }
            Some(inode) => {
                let file = PartlySynchronised::of(inode, self.calls, rules);
                file.each(most, random, &mut |content| found(Some(content)))
            }
        };
        self.pointed_at(rules).into_iter().map(&mut every).sum()
    }

    /// Draws one content that the file may have; `None`: it does not exist. `random` draws below a number.
    pub fn draw(&self, rules: Rules, random: &mut dyn FnMut(usize) -> usize) -> Option<Vec<u8>> {
        let may = self.pointed_at(rules);
        let inode = may[random(may.len())]?;
        let mut drawn = None;
        let file = PartlySynchronised::of(inode, self.calls, rules);
        file.each(1, random, &mut |content| drawn = Some(content.to_vec()));
        drawn
    }

    /// The files that the name may point at.
    fn pointed_at(&self, rules: Rules) -> Vec<Option<Inode>> {
        let mut now = BTreeMap::new();
        // Every file that had the name since the folder was synchronised, and that from before.
        let mut may: Vec<Option<Inode>> = vec![None];
        // The files that have the name if a failed renaming was made all the same.
        let mut perhaps: Vec<Option<Inode>> = Vec::new();
        for call in self.calls {
            match call {
                Call::Create(name, inode) => {
                    now.insert(name.as_path(), *inode);
                }
                Call::Rename(from, to) => {
                    let inode = now.remove(from.as_path()).expect("the name exists");
                    now.insert(to.as_path(), inode);
                    if to == self.name {
                        perhaps.clear();
                    }
                }
                Call::FailedRename(from, to) if to == self.name => perhaps.push(now.get(from.as_path()).copied()),
                Call::SyncFolder => may = vec![now.get(self.name).copied()],
                _ => continue,
            }
            let current = now.get(self.name).copied();
            if rules == Rules::Process {
                may = vec![current];
            } else if !may.contains(&current) {
                may.push(current);
            }
        }
        for inode in perhaps {
            if !may.contains(&inode) {
                may.push(inode);
            }
        }
        may
    }
}

/// A file of which only a part is sure.
struct PartlySynchronised {
    /// The content as the process has written it.
    written: Vec<u8>,
    /// The certain content, at each byte: the data on the disk.
    sure: Vec<u8>,
    /// Choices: the lengths that the file may have.
    lengths: Vec<usize>,
    /// Choices: parts of pages that are not synchronised, and the contents that each may have.
    parts: Vec<(std::ops::Range<usize>, &'static [Content])>,
}

/// The contents that a part of a page may have.
#[derive(Clone, Copy, Debug)]
enum Content {
    Data,
    Before,
    Zeros,
    Torn,
    Garbage,
}

impl PartlySynchronised {
    fn of(inode: Inode, calls: &[Call], rules: Rules) -> Self {
        let mut written = Vec::new();
        let mut sure: Vec<u8> = Vec::new();
        // Ranges since the last synchronisation, and those that a failed one has lost.
        let mut fresh: Vec<(std::ops::Range<usize>, bool)> = Vec::new();
        let mut lost: Vec<(std::ops::Range<usize>, bool)> = Vec::new();
        let mut last = None;
        for (number, call) in calls.iter().enumerate() {
            match call {
                Call::Append(which, bytes) | Call::FailedAppend(which, bytes) if *which == inode => {
                    let from = written.len();
                    written.extend_from_slice(bytes);
                    fresh.push((from..written.len(), true));
                    last = (number + 1 == calls.len()).then_some(from);
                }
                Call::Overwrite(which, offset, bytes) if *which == inode => {
                    let range = *offset..offset + bytes.len();
                    written[range.clone()].copy_from_slice(bytes);
                    fresh.push((range, false));
                    last = None;
                }
                Call::Sync(which) if *which == inode => {
                    sure.resize(written.len(), 0);
                    for (range, _) in fresh.drain(..) {
                        sure[range.clone()].copy_from_slice(&written[range]);
                    }
                    last = None;
                }
                Call::FailedSync(which) if *which == inode => lost.append(&mut fresh),
                _ => {}
            }
        }
        let synchronised = sure.len();
        if rules == Rules::Process {
            // The last append may be under way.
            let from = last.unwrap_or(written.len());
            let sure = written.clone();
            let lengths = steps(from, written.len(), SECTOR);
            return PartlySynchronised {
                written,
                sure,
                lengths,
                parts: Vec::new(),
            };
        }
        let step = if rules == Rules::Ordered { SECTOR } else { PAGE };
        let lengths = steps(synchronised.min(written.len()), written.len(), step);
        let mut parts = Vec::new();
        for (range, appended) in lost.into_iter().chain(fresh) {
            let contents: &'static [Content] = match (rules, appended) {
                // Behind the length the file is empty; before it, it has the data.
                (Rules::Ordered, true) => continue,
                (Rules::Ordered, false) => &[Content::Data, Content::Before],
                (_, true) => &[Content::Data, Content::Zeros, Content::Torn, Content::Garbage],
                (_, false) => &[Content::Data, Content::Before, Content::Garbage],
            };
            for part in pages(&range) {
                match parts
                    .iter_mut()
                    .find(|(known, _): &&mut (std::ops::Range<usize>, _)| *known == part)
                {
                    Some((_, known)) => *known = contents,
                    None => parts.push((part, contents)),
                }
            }
        }
        if rules == Rules::Ordered {
            // Data that were appended and never synchronised exist up to the length.
            let from = sure.len();
            sure.extend_from_slice(&written[from..]);
        }
        PartlySynchronised {
            written,
            sure,
            lengths,
            parts,
        }
    }

    fn each(&self, most: usize, random: &mut dyn FnMut(usize) -> usize, found: &mut dyn FnMut(&[u8])) -> usize {
        let radices: Vec<usize> = std::iter::once(self.lengths.len())
            .chain(self.parts.iter().map(|(_, contents)| contents.len()))
            .collect();
        let all = radices.iter().try_fold(1_usize, |all, radix| all.checked_mul(*radix));
        let all = all.filter(|all| *all <= most);
        let mut choices = vec![0; radices.len()];
        for number in 0..all.unwrap_or(most) {
            let mut rest = number;
            for (choice, radix) in choices.iter_mut().zip(&radices) {
                *choice = if all.is_some() { rest % radix } else { random(*radix) };
                rest /= radix;
            }
            found(&self.content(&choices));
        }
        all.unwrap_or(most)
    }

    fn content(&self, choices: &[usize]) -> Vec<u8> {
        let length = self.lengths[choices[0]];
        let mut content = self.sure.clone();
        content.resize(self.written.len(), 0);
        for ((range, contents), choice) in self.parts.iter().zip(&choices[1..]) {
            let (from, middle) = (range.clone(), range.start + range.len() / 2);
            match contents[*choice] {
                Content::Data => content[from.clone()].copy_from_slice(&self.written[from]),
                Content::Before => {}
                Content::Zeros => content[from].fill(0),
                Content::Torn => {
                    content[range.start..middle].copy_from_slice(&self.written[range.start..middle]);
                    content[middle..range.end].fill(0);
                }
                Content::Garbage => content[from].fill(0xA5),
            }
        }
        content.truncate(length);
        content
    }
}

/// `from`, `to` and the multiples of `step` between.
fn steps(from: usize, to: usize, step: usize) -> Vec<usize> {
    let mut all: Vec<usize> = (from.div_ceil(step)..=to / step).map(|number| number * step).collect();
    all.extend([from, to]);
    all.sort_unstable();
    all.dedup();
    all
}

/// The parts of a range by page.
fn pages(range: &std::ops::Range<usize>) -> impl Iterator<Item = std::ops::Range<usize>> {
    let range = range.clone();
    (range.start / PAGE..range.end.div_ceil(PAGE))
        .map(move |page| range.start.max(page * PAGE)..range.end.min((page + 1) * PAGE))
}

const PAGE: usize = 4096;
const SECTOR: usize = 512;
