//! The seam to the disk: nine calls, and their implementation by the system.
//!
//! All that a [`Writer`](crate::Writer) does to a disk is one of these calls, so that a test can record them and try every content that a
//! crash between any two of them may leave (`recording::Recording`).

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::{FileExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A disk, as a retained state uses it. A handle; clones are of the same disk.
pub trait Disk: Clone + Send + 'static {
    /// An open file. A handle; clones are of the same file.
    type File: Clone + Send + std::fmt::Debug;

    /// Opens the lock file, and makes it if there is none. The lock ends with the last clone of the file.
    ///
    /// # Errors
    /// [`OpenError::InUse`] while another process holds the lock; [`OpenError::Io`].
    fn lock(&self, name: &Path) -> Result<Self::File, OpenError>;

    /// Reads a file; `None`: there is none.
    ///
    /// # Errors
    /// [`io::ErrorKind::FileTooLarge`] for a file of more than `most` bytes; the system's errors.
    fn read(&self, name: &Path, most: usize) -> io::Result<Option<Vec<u8>>>;

    /// Makes an empty file, in place of the one that has the name.
    ///
    /// # Errors
    /// The system's.
    fn create(&self, name: &Path) -> io::Result<Self::File>;

    /// Writes at the end of a file that [`create`](Disk::create) has made.
    ///
    /// # Errors
    /// The system's. Any number of the bytes may have been written then.
    fn append(&self, file: &Self::File, bytes: &[u8]) -> io::Result<()>;

    /// Writes at an offset inside such a file.
    ///
    /// # Errors
    /// The system's.
    fn overwrite(&self, file: &Self::File, offset: u64, bytes: &[u8]) -> io::Result<()>;

    /// Waits until the disk has the content and the length of a file.
    ///
    /// # Errors
    /// The system's. The bytes written since the last success may never get to the disk then, whatever a later call returns.
    fn sync(&self, file: &Self::File) -> io::Result<()>;

    /// Gives a file another name, in place of the file that had it.
    ///
    /// # Errors
    /// The system's. The names are as they were then.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Waits until the disk has the names in the folder.
    ///
    /// # Errors
    /// The system's.
    fn sync_folder(&self) -> io::Result<()>;

    /// Whether a name is in use, even by a dangling link.
    fn exists(&self, name: &Path) -> bool;
}

/// The reason for which a file cannot hold a state.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Another process holds the lock.
    #[error("another server keeps its state there")]
    InUse,
    /// The path is that of a folder or a device.
    #[error("it is not a file")]
    NotAFile,
    /// The system's error.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// The disk of the system. It holds the folder open, so that a lack of file handles never keeps it from synchronising a rename.
#[derive(Clone, Debug)]
pub struct System {
    folder: Arc<File>,
}

impl System {
    /// The disk that has `file`, and the name that the file has there. If `file` is a link, it is the name of the file behind the link.
    ///
    /// # Errors
    /// [`OpenError::NotAFile`], and [`OpenError::Io`] when the folder cannot be opened.
    pub fn with(file: &Path) -> Result<(System, PathBuf), OpenError> {
        let file = match fs::canonicalize(file) {
            Ok(file) if !file.is_file() => return Err(OpenError::NotAFile),
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => file.to_owned(),
            Err(error) => return Err(error.into()),
        };
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = Arc::new(File::open(folder.unwrap_or(Path::new(".")))?);
        Ok((System { folder }, file))
    }
}

impl Disk for System {
    type File = Arc<File>;

    fn lock(&self, name: &Path) -> Result<Arc<File>, OpenError> {
        // A link leads to a file of another user, and a FIFO would wait for its other end.
        if fs::symlink_metadata(name).is_ok_and(|found| !found.is_file()) {
            return Err(OpenError::NotAFile);
        }
        let lock = OpenOptions::new().create(true).append(true).mode(PRIVATE).open(name)?;
        match lock.try_lock() {
            Ok(()) => Ok(Arc::new(lock)),
            Err(TryLockError::WouldBlock) => Err(OpenError::InUse),
            Err(TryLockError::Error(error)) => Err(error.into()),
        }
    }

    fn read(&self, name: &Path, most: usize) -> io::Result<Option<Vec<u8>>> {
        let file = match File::open(name) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        let length = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
        if length > most {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        let mut bytes = Vec::with_capacity(length);
        // The file is locked, so it does not grow meanwhile.
        file.take(length as u64).read_to_end(&mut bytes)?;
        Ok(Some(bytes))
    }

    /// Readable by its owner only. A link that has the name is removed, not followed.
    fn create(&self, name: &Path) -> io::Result<Arc<File>> {
        match fs::remove_file(name) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(PRIVATE)
            .open(name)?;
        Ok(Arc::new(file))
    }

    fn append(&self, file: &Arc<File>, bytes: &[u8]) -> io::Result<()> {
        (&**file).write_all(bytes)
    }

    fn overwrite(&self, file: &Arc<File>, offset: u64, bytes: &[u8]) -> io::Result<()> {
        file.write_all_at(bytes, offset)
    }

    fn sync(&self, file: &Arc<File>) -> io::Result<()> {
        file.sync_data()
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn sync_folder(&self) -> io::Result<()> {
        self.folder.sync_all()
    }

    fn exists(&self, name: &Path) -> bool {
        fs::symlink_metadata(name).is_ok()
    }
}

/// The mode of new files: a tag may hold a recipe that not every user of the computer is to read.
const PRIVATE: u32 = 0o600;
