//! The common functions for foreign programs: a folder under `target/` for downloads, and a run with a time limit.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The longest run of one program.
const LIMIT: Duration = Duration::from_secs(120);

/// A folder under `target/`, locked: of test processes that run at the same time one fetches, the others wait.
pub struct Store {
    folder: PathBuf,
    _lock: File,
}

impl Store {
    /// Makes `target/NAME` and waits for its lock.
    ///
    /// # Errors
    /// Says which file cannot be made.
    pub fn open(name: &str) -> Result<Self, String> {
        let folder = crate::programs::target_directory().join(name);
        fs::create_dir_all(&folder).map_err(|error| format!("{folder:?}: {error}"))?;
        let lock = File::create(folder.join("lock")).map_err(|error| format!("{folder:?}: {error}"))?;
        lock.lock().map_err(|error| format!("{folder:?}: {error}"))?;
        Ok(Self { folder, _lock: lock })
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether the folder was filled for exactly these contents.
    #[must_use]
    pub fn holds(&self, wanted: &str) -> bool {
        fs::read_to_string(self.stamp()).is_ok_and(|installed| installed == wanted)
    }

    /// Records the contents of the folder.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn filled(&self, wanted: &str) -> Result<(), String> {
        fs::write(self.stamp(), wanted).map_err(|error| format!("{:?}: {error}", self.stamp()))
    }

    fn stamp(&self) -> PathBuf {
        self.folder.join("installed.txt")
    }
}

/// Runs a program to its end and returns its output.
///
/// # Panics
/// When it cannot be started, fails (with all its output) or has not ended within two minutes.
#[must_use]
pub fn run(name: &str, command: &mut Command) -> String {
    attempt(name, command, LIMIT).unwrap_or_else(|why| panic!("{why}"))
}

/// Runs a program to its end, which must come before `limit`, and returns its output.
///
/// # Errors
/// Describes its end, with all its output.
pub fn attempt(name: &str, command: &mut Command, limit: Duration) -> Result<String, String> {
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{name} cannot be started: {error}"))?;
    let stdout = collect(child.stdout.take());
    let stderr = collect(child.stderr.take());
    let status = ended_within(&mut child, limit);
    let stdout = stdout.join().unwrap_or_default();
    let stderr = stderr.join().unwrap_or_default();
    if status.is_some_and(|status| status.success()) {
        Ok(stdout)
    } else {
        Err(format!("{name} ended with {status:?}; it printed:\n{stdout}\n{stderr}"))
    }
}

fn collect(pipe: Option<impl io::Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(mut pipe) = pipe {
            // The text before a read error is still worth showing.
            let _ = pipe.read_to_end(&mut text);
        }
        String::from_utf8_lossy(&text).into_owned()
    })
}

/// Waits for the child; ends it and gives `None` when it takes too long.
fn ended_within(child: &mut Child, limit: Duration) -> Option<std::process::ExitStatus> {
    let deadline = std::time::Instant::now() + limit;
    while std::time::Instant::now() < deadline {
        if let Ok(Some(status)) = child.try_wait() {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    // The program may have ended by itself in the meantime.
    let _ = child.kill();
    let _ = child.wait();
    None
}
