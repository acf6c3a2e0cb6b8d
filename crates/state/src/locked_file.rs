//! The name of a file, locked for one process: reading it, setting it aside, beginning to keep a state there.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::disk::{Disk, OpenError, System};
use crate::{Damage, FileContents, MAX_FILE, format};

/// A file in which no other process keeps a state while this lives. It may not exist yet.
#[derive(Debug)]
pub struct LockedFile<D: Disk = System> {
    disk: D,
    file: PathBuf,
    _lock: D::File,
}

/// The reason for which a file gave no state.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file is damaged or foreign.
    #[error(transparent)]
    Damage(#[from] Damage),
    /// The system's error.
    #[error("{0}")]
    Io(#[from] io::Error),
}

impl LockedFile {
    /// Takes a file for this process.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn lock(file: &Path) -> Result<LockedFile, OpenError> {
        let (disk, file) = System::with(file)?;
        LockedFile::lock_on(disk, file)
    }

    /// Checks that [`LockedFile::lock`] could take a file and read it, and changes nothing: it makes no lock file. Returns the file, that behind a link
    /// for a link.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn examine(file: &Path) -> Result<PathBuf, OpenError> {
        let (disk, file) = System::with(file)?;
        let lock = with_suffix(&file, ".lock");
        if disk.exists(&lock) {
            disk.lock(&lock)?;
        }
        match File::open(&file) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error.into()),
            _ => Ok(file),
        }
    }
}

impl<D: Disk> LockedFile<D> {
    /// Takes a file of this disk for this process.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn lock_on(disk: D, file: PathBuf) -> Result<Self, OpenError> {
        let lock = disk.lock(&with_suffix(&file, ".lock"))?;
        Ok(LockedFile {
            disk,
            file,
            _lock: lock,
        })
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The file that is written before it takes the place of this one.
    pub(crate) fn beside(&self) -> PathBuf {
        with_suffix(&self.file, ".new")
    }

    pub(crate) fn disk(&self) -> &D {
        &self.disk
    }

    /// Reads the file; `None`: there is none.
    ///
    /// # Errors
    /// See [`ReadError`]. After a [`Damage`] the file should be [set aside](LockedFile::set_aside).
    pub fn read(&self) -> Result<Option<FileContents>, ReadError> {
        match self.disk.read(&self.file, MAX_FILE) {
            Ok(None) => Ok(None),
            Ok(Some(bytes)) => Ok(Some(format::parse(&bytes)?)),
            Err(error) if error.kind() == io::ErrorKind::FileTooLarge => {
                Err(Damage::TooLong { limit: MAX_FILE }.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Renames the file to one that did not exist, and returns its name.
    ///
    /// # Errors
    /// The system's. Then the file is where it was.
    pub fn set_aside(&self) -> io::Result<PathBuf> {
        for number in 1..=MOST_ASIDE {
            let aside = with_suffix(&self.file, &format!(".set-aside-{number}"));
            if !self.disk.exists(&aside) {
                self.disk.rename(&self.file, &aside)?;
                return Ok(aside);
            }
        }
        Err(io::Error::other(format!(
            "{MOST_ASIDE} files have been set aside already"
        )))
    }
}

fn with_suffix(file: &Path, suffix: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Files that are set aside before an operator must remove some.
const MOST_ASIDE: u32 = 1000;
