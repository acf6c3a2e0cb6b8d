//! The computer on which servers run: its disk, and the lock of a file, which one server has at a time.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};

use arcline_state::recording::{Inode, Recording};
use arcline_state::{Disk, OpenError};

use crate::record::lock;

/// A computer. Clones are the same one.
#[derive(Clone)]
pub(super) struct Computer {
    disk: Recording,
    locks: Arc<Mutex<BTreeMap<PathBuf, Weak<()>>>>,
}

/// An open file.
#[derive(Clone, Debug)]
pub(super) struct Open {
    inode: Inode,
    /// A lock file: the lock ends with its last clone.
    _lock: Option<Arc<()>>,
}

impl Computer {
    pub(super) fn new(disk: Recording) -> Self {
        Computer {
            disk,
            locks: Arc::default(),
        }
    }
}

impl Disk for Computer {
    type File = Open;

    fn lock(&self, name: &Path) -> Result<Open, OpenError> {
        let mut locks = lock(&self.locks);
        if locks.get(name).is_some_and(|held| held.strong_count() > 0) {
            return Err(OpenError::InUse);
        }
        let held = Arc::new(());
        locks.insert(name.to_owned(), Arc::downgrade(&held));
        Ok(Open {
            inode: self.disk.lock(name)?,
            _lock: Some(held),
        })
    }

    fn read(&self, name: &Path, most: usize) -> io::Result<Option<Vec<u8>>> {
        self.disk.read(name, most)
    }

    fn create(&self, name: &Path) -> io::Result<Open> {
        self.disk.create(name).map(Open::of)
    }

    fn append(&self, file: &Open, bytes: &[u8]) -> io::Result<()> {
        self.disk.append(&file.inode, bytes)
    }

    fn overwrite(&self, file: &Open, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.disk.overwrite(&file.inode, offset, bytes)
    }

    fn sync(&self, file: &Open) -> io::Result<()> {
        self.disk.sync(&file.inode)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.disk.rename(from, to)
    }

    fn sync_folder(&self) -> io::Result<()> {
        self.disk.sync_folder()
    }

    fn exists(&self, name: &Path) -> bool {
        self.disk.exists(name)
    }
}

impl Open {
    fn of(inode: Inode) -> Self {
        Open { inode, _lock: None }
    }
}
