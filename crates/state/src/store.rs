//! The file on a disk: locked, read, continued, rewritten beside and renamed, set aside.
//!
//! Against the end of the process, what [`Store::append`] has returned from is kept: the system has it. Against the end of
//! the system, what has been synchronised is kept; when that happens is the caller's to say, for it may take
//! long ([`Store::file`], [`Store::begin_rewrite`]).

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::format::{self, Chain};
use crate::{Change, Damage, Kept, Limit, MAX_FILE, State};

/// A file that nobody else keeps a state in while this lives. It may not exist yet.
#[derive(Debug)]
pub struct Place {
    file: PathBuf,
    /// Of the lock file; the system lets go of it with the process.
    _lock: File,
}

/// Why nothing can be kept in a file.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Another process has it.
    #[error("another server keeps its state there")]
    InUse,
    /// Not a file, but a folder or a device.
    #[error("it is not a file")]
    NotAFile,
    /// The system says no.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// Why a file gave no state.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It is damaged or foreign.
    #[error(transparent)]
    Damage(#[from] Damage),
    /// The system says no.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// A state and its file, which are the same but for what could not be written.
#[derive(Debug)]
pub struct Store {
    place: Place,
    state: State,
    /// `None` when the last attempt to write has failed: nothing may stand behind half a record.
    log: Option<Log>,
    /// The state written anew, until it takes the place of the file.
    beside: Option<Log>,
    /// When the file is this long it is time to write it anew, bytes.
    rewrite_at: usize,
    buffer: Vec<u8>,
}

/// An open file whose last record is whole.
#[derive(Debug)]
struct Log {
    file: File,
    length: usize,
    chain: Chain,
}

impl Place {
    /// Takes a file for this process.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn lock(file: &Path) -> Result<Place, OpenError> {
        // A link stays a link: what it leads to is replaced.
        let file = match fs::canonicalize(file) {
            Ok(file) if !file.is_file() => return Err(OpenError::NotAFile),
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => file.to_owned(),
            Err(error) => return Err(error.into()),
        };
        let lock = OpenOptions::new()
            .create(true)
            .append(true)
            .open(with_suffix(&file, ".lock"))?;
        match lock.try_lock() {
            Ok(()) => Ok(Place { file, _lock: lock }),
            Err(TryLockError::WouldBlock) => Err(OpenError::InUse),
            Err(TryLockError::Error(error)) => Err(error.into()),
        }
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Reads the file; `None`: there is none.
    ///
    /// # Errors
    /// See [`ReadError`]. After a [`Damage`] the file should be [set aside](Place::set_aside).
    pub fn read(&self) -> Result<Option<Kept>, ReadError> {
        let file = match File::open(&self.file) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let length = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
        crate::state::within(Limit::File, length, MAX_FILE)?;
        let mut bytes = Vec::with_capacity(length);
        // Nobody makes it longer than it was: it is locked.
        file.take(length as u64).read_to_end(&mut bytes)?;
        Ok(Some(format::parse(&bytes)?))
    }

    /// Renames the file to one that did not exist, and says which.
    ///
    /// # Errors
    /// What the system says. Then the file is where it was.
    pub fn set_aside(&self) -> io::Result<PathBuf> {
        for number in 1..=MOST_ASIDE {
            let aside = with_suffix(&self.file, &format!(".set-aside-{number}"));
            if fs::symlink_metadata(&aside).is_err() {
                fs::rename(&self.file, &aside)?;
                return Ok(aside);
            }
        }
        Err(io::Error::other(format!(
            "{MOST_ASIDE} files have been set aside already"
        )))
    }

    /// Begins to keep a state. A file of the same axes and tags is continued; another one, or none, is written anew
    /// and synchronised.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(self, state: State, kept: Option<Kept>) -> io::Result<Store> {
        let mut store = Store {
            place: self,
            state,
            log: None,
            beside: None,
            rewrite_at: 0,
            buffer: Vec::new(),
        };
        let known = kept.and_then(|kept| Some((kept.state.changes_to(&store.state)?, kept)));
        let Some((changes, kept)) = known else {
            store.rewrite()?;
            return Ok(store);
        };
        let file = OpenOptions::new().append(true).open(&store.place.file)?;
        if file.metadata()?.len() != kept.end as u64 {
            file.set_len(kept.end as u64)?;
        }
        store.log = Some(Log {
            file,
            length: kept.end,
            chain: kept.chain,
        });
        store.rewrite_at = rewrite_at(format::fresh(&store.state).0.len());
        if !changes.is_empty() {
            store.append([changes.as_slice()])?;
        }
        Ok(store)
    }
}

impl Store {
    /// The state, with all changes, also those that could not be written.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.place.file()
    }

    /// Makes changes and writes them, each slice as one that is there whole or not at all.
    ///
    /// # Errors
    /// What the system says. The changes are made all the same; nothing more is written until
    /// [`Store::rewrite`] has succeeded.
    ///
    /// # Panics
    /// When a change is of an axis or tag that the state does not have, or makes a position that is no number.
    pub fn append<'c>(&mut self, changes: impl IntoIterator<Item = &'c [Change]> + Clone) -> io::Result<()> {
        for change in changes.clone().into_iter().flatten() {
            self.state.apply(change).expect("a change of what there is");
        }
        let written = match &mut self.log {
            None => Err(io::Error::other("an earlier record could not be written")),
            Some(log) => log.append(changes.clone(), &mut self.buffer),
        };
        if written.is_err() {
            self.log = None;
            self.beside = None;
        }
        // The one beside is still nobody's: when it cannot be written it is only forgotten.
        if let Some(beside) = &mut self.beside
            && beside.append(changes, &mut self.buffer).is_err()
        {
            self.beside = None;
        }
        written
    }

    /// The open file, to be synchronised; `None` after a failure.
    ///
    /// # Errors
    /// When the system has no handle left.
    pub fn file(&self) -> io::Result<Option<File>> {
        self.log.as_ref().map(|log| log.file.try_clone()).transpose()
    }

    /// Writes the state anew, synchronises it and puts it in the place of the file. As long as the disk takes.
    ///
    /// # Errors
    /// What the system says; the file is then as it was.
    pub fn rewrite(&mut self) -> io::Result<()> {
        self.begin_rewrite()?.sync_all()?;
        self.finish_rewrite()?.sync_all()
    }

    /// Takes another state, of other axes and tags, and writes it in the place of the file. As long as the disk takes.
    ///
    /// # Errors
    /// The state has more than can be kept, and the one there was stays; or what the system says: the state is taken all
    /// the same, the file is as it was, and nothing more is written until [`Store::rewrite`] has succeeded.
    pub fn replace(&mut self, state: State) -> io::Result<()> {
        state.check().map_err(io::Error::other)?;
        self.state = state;
        self.log = None;
        self.beside = None;
        self.rewrite()
    }

    /// Whether the file has so grown that it should be written anew.
    pub fn wants_rewrite(&self) -> bool {
        self.beside.is_none() && self.log.as_ref().is_some_and(|log| log.length >= self.rewrite_at)
    }

    /// Writes the state anew beside the file, and from now on every change to both. The caller synchronises what
    /// is given back, then calls [`Store::finish_rewrite`].
    ///
    /// # Errors
    /// What the system says; it is tried again when the file has grown some more.
    pub fn begin_rewrite(&mut self) -> io::Result<File> {
        self.beside = None;
        if let Some(log) = &self.log {
            self.rewrite_at = log.length + REWRITE_AGAIN;
        }
        let (bytes, chain) = format::fresh(&self.state);
        let mut file = File::create(self.beside_path())?;
        file.write_all(&bytes)?;
        let handle = file.try_clone()?;
        self.beside = Some(Log {
            file,
            length: bytes.len(),
            chain,
        });
        Ok(handle)
    }

    /// Puts what was written anew in the place of the file. Gives back the folder, which is to be synchronised.
    ///
    /// # Errors
    /// What the system says, also when writing beside has failed meanwhile; the file is then as it was.
    pub fn finish_rewrite(&mut self) -> io::Result<File> {
        let beside = self.beside.take();
        let beside = beside.ok_or_else(|| io::Error::other("the new file could not be written"))?;
        fs::rename(self.beside_path(), &self.place.file)?;
        self.rewrite_at = rewrite_at(beside.length);
        self.log = Some(beside);
        let folder = self.place.file.parent().filter(|folder| !folder.as_os_str().is_empty());
        File::open(folder.unwrap_or(Path::new(".")))
    }

    fn beside_path(&self) -> PathBuf {
        with_suffix(&self.place.file, ".new")
    }
}

impl Log {
    /// One `write` for all.
    fn append<'c>(&mut self, changes: impl IntoIterator<Item = &'c [Change]>, buffer: &mut Vec<u8>) -> io::Result<()> {
        buffer.clear();
        for changes in changes {
            format::changes(changes, &mut self.chain, buffer);
        }
        let length = self.length + buffer.len();
        if length > MAX_FILE {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        self.file.write_all(buffer)?;
        self.length = length;
        Ok(())
    }
}

/// When a file that begins with a state of so many bytes is written anew.
fn rewrite_at(fresh: usize) -> usize {
    fresh + fresh.max(REWRITE_AGAIN)
}

fn with_suffix(file: &Path, suffix: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Changes that stand behind a small state before it is written anew, bytes.
const REWRITE_AGAIN: usize = 1024 * 1024;
/// Files that are set aside before somebody must look at them.
const MOST_ASIDE: u32 = 1000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, AxisState};

    fn state() -> State {
        State {
            axes: vec![Axis {
                name: "X".to_owned(),
                kind: "servo, mm".to_owned(),
                state: AxisState::default(),
            }],
            tags: Vec::new(),
        }
    }

    fn at(position: f64) -> [Change; 1] {
        let state = AxisState {
            position,
            ..AxisState::default()
        };
        [Change::Axis { axis: 0, state }]
    }

    #[test]
    fn after_a_failed_write_nothing_is_appended_until_it_was_written_anew() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("state");
        let place = Place::lock(&file).expect("a new file");
        let mut store = place.begin(state(), None).expect("a new file");
        // A file that is open for reading only: every write fails.
        store.log.as_mut().expect("a file").file = File::open(&file).expect("it was written");
        assert!(store.append([at(1.0).as_slice()]).is_err());
        assert!(store.append([at(2.0).as_slice()]).is_err());
        assert_eq!(store.file().expect("no handle").map(drop), None);
        assert!(!store.wants_rewrite());
        store.rewrite().expect("the folder is writable");
        store.append([at(3.0).as_slice()]).expect("the file is whole");
        drop(store);
        let kept = Place::lock(&file).expect("nobody has it").read();
        let kept = kept.expect("whole").expect("it is there");
        assert_eq!(kept.state.axes[0].state.position, 3.0);
    }
}
