//! The files of the audit: `000001.jsonl` and so on, of 16 MiB each, the oldest of more than 16 removed; readable by owner and group.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use tokio::time::Instant;

use super::chain::{self, Chain};
use super::{Event, EventKind};

/// Bytes of a file.
const LONGEST: u64 = 16 * 1024 * 1024;
/// Files.
const FILES: usize = 16;
/// Time between two synchronisations.
const SYNC: Duration = Duration::from_secs(1);
/// A wait without data to synchronise.
const IDLE: Duration = Duration::from_secs(3600);

/// The files, open at their end.
#[derive(Debug)]
pub(super) struct Files {
    folder: PathBuf,
    number: u64,
    file: File,
    length: u64,
    chain: Chain,
    synced: Instant,
    is_dirty: bool,
    longest: u64,
}

impl Files {
    /// Opens the newest file of a folder, or makes the first one. A last line that a crash cut is removed, and the next line says so.
    pub(super) fn open(folder: &Path) -> io::Result<Self> {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true).mode(0o750).create(folder)?;
        let mut boot = [0; 8];
        getrandom::fill(&mut boot).map_err(io::Error::other)?;
        let mut chain = Chain {
            next: 1,
            prev: chain::first(),
            boot: crate::tls::hex(&boot),
        };
        let mut number = 1;
        let mut repaired = 0;
        let all = numbered(folder)?;
        if let Some((newest, file)) = all.last() {
            number = *newest;
            repaired = cut_last_line(file)?;
        }
        // The newest file has no line when a crash came right behind its beginning.
        for (_, file) in all.iter().rev() {
            let text = String::from_utf8_lossy(&fs::read(file)?).into_owned();
            if let Some(last) = text.lines().last() {
                let of: serde_json::Value = serde_json::from_str(last).unwrap_or_default();
                chain.next = of["n"].as_u64().unwrap_or(0) + 1;
                chain.prev = chain::hash(last.as_bytes());
                break;
            }
        }
        let (file, length) = append_to(&folder.join(name(number)))?;
        let mut this = Self {
            folder: folder.to_owned(),
            number,
            file,
            length,
            chain,
            synced: Instant::now(),
            is_dirty: false,
            longest: LONGEST,
        };
        this.begin(&match repaired {
            0 => "begun".to_owned(),
            bytes => format!("repaired: {bytes} bytes of a cut line were removed"),
        })?;
        Ok(this)
    }

    /// The hash of the newest line.
    pub(super) fn head(&self) -> &str {
        &self.chain.prev
    }

    /// The number of the newest line.
    pub(super) fn newest(&self) -> u64 {
        self.chain.next - 1
    }

    /// Appends a line.
    pub(super) fn append(&mut self, event: &Event, count: u64) -> io::Result<()> {
        if self.length >= self.longest {
            self.roll()?;
        }
        self.write(event, count)
    }

    /// The time until the next synchronisation is due.
    pub(super) fn due(&self) -> Duration {
        match self.is_dirty {
            true => SYNC.saturating_sub(self.synced.elapsed()),
            false => IDLE,
        }
    }

    /// Synchronises the written lines, once a second.
    pub(super) fn sync_at(&mut self, now: Instant) {
        if self.is_dirty && now.saturating_duration_since(self.synced) >= SYNC {
            self.sync();
        }
    }

    /// Synchronises the written lines.
    pub(super) fn sync(&mut self) {
        // A disk that fails shows with the next write.
        let _ = self.file.sync_data();
        self.synced = Instant::now();
        self.is_dirty = false;
    }

    fn write(&mut self, event: &Event, count: u64) -> io::Result<()> {
        let line = self.chain.line(event, count);
        let before = self.length;
        let written = self.file.write_all(format!("{line}\n").as_bytes());
        if let Err(error) = written {
            // A part of a line would break the chain.
            let _ = self.file.set_len(before);
            return Err(error);
        }
        self.length += line.len() as u64 + 1;
        self.is_dirty = true;
        self.chain.wrote(&line);
        Ok(())
    }

    fn begin(&mut self, object: &str) -> io::Result<()> {
        let event = Event {
            at: SystemTime::now(),
            kind: EventKind::Open,
            door: "server",
            from: "".into(),
            role: "",
            object: object.to_owned(),
            values: None,
            result: "done",
            is_plain_write: false,
        };
        self.write(&event, 1)
    }

    fn roll(&mut self) -> io::Result<()> {
        self.file.sync_data()?;
        let (file, length) = append_to(&self.folder.join(name(self.number + 1)))?;
        (self.file, self.length) = (file, length);
        self.number += 1;
        let all = numbered(&self.folder)?;
        for (_, old) in all.iter().take(all.len().saturating_sub(FILES)) {
            fs::remove_file(old)?;
        }
        self.begin("the next file")
    }

    #[cfg(test)]
    pub(super) fn is_dirty(&self) -> bool {
        self.is_dirty
    }

    #[cfg(test)]
    pub(super) fn set_file(&mut self, file: &str) {
        self.file = OpenOptions::new().append(true).open(file).expect("it is there");
    }

    #[cfg(test)]
    pub(super) fn set_longest(&mut self, longest: u64) {
        self.longest = longest;
    }
}

/// Removes a last line that has no end; the number of its bytes.
fn cut_last_line(file: &Path) -> io::Result<usize> {
    let bytes = fs::read(file)?;
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    if whole < bytes.len() {
        OpenOptions::new().write(true).open(file)?.set_len(whole as u64)?;
    }
    Ok(bytes.len() - whole)
}

/// The files of a folder with their numbers, the oldest first.
pub(super) fn numbered(folder: &Path) -> io::Result<Vec<(u64, PathBuf)>> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder)? {
        let file = entry?.path();
        let number = file
            .file_name()
            .and_then(|name| name.to_str()?.strip_suffix(".jsonl")?.parse().ok());
        all.extend(number.map(|number| (number, file)));
    }
    all.sort_unstable();
    Ok(all)
}

fn name(number: u64) -> String {
    format!("{number:06}.jsonl")
}

fn append_to(file: &Path) -> io::Result<(File, u64)> {
    if fs::symlink_metadata(file).is_ok_and(|found| !found.is_file()) {
        return Err(io::Error::other("it is no file"));
    }
    let file = OpenOptions::new().create(true).append(true).mode(0o640).open(file)?;
    let length = file.metadata()?.len();
    Ok((file, length))
}
