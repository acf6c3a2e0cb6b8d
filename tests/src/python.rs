//! Python scripts with clients from PyPI, fetched into the target folder. Nothing is installed on the machine.

use std::fs::{self, File};
use std::io;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// How long one script may run.
const SCRIPT: Duration = Duration::from_secs(120);

/// A Python that can import the packages of `tests/python/requirements.txt`.
pub struct Python {
    packages: PathBuf,
}

impl Python {
    /// Finds Python and fetches the packages, once for each version of the requirements.
    ///
    /// # Errors
    /// Says what is missing on this machine.
    pub fn with_clients() -> Result<Self, String> {
        let requirements = crate::fixture("python/requirements.txt");
        let version = Command::new("python3")
            .arg("--version")
            .output()
            .map_err(|error| format!("python3 cannot be started ({error}); install Python 3.9 or newer"))?;
        let wanted = fs::read_to_string(&requirements).map_err(|error| format!("{requirements:?}: {error}"))?;
        let wanted = format!("{wanted}\n{}", String::from_utf8_lossy(&version.stdout));
        let store = crate::programs::target_directory().join("python");
        let packages = store.join("packages");
        let stamp = store.join("installed.txt");
        fs::create_dir_all(&store).map_err(|error| format!("{store:?}: {error}"))?;
        // Test processes may run at the same time: one fetches, the others wait.
        let lock = File::create(store.join("lock")).map_err(|error| format!("{store:?}: {error}"))?;
        lock.lock().map_err(|error| format!("{store:?}: {error}"))?;
        if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
            return Ok(Self { packages });
        }
        match fs::remove_dir_all(&packages) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(format!("{packages:?}: {error}"));
            }
            _ => {}
        }
        let pip = Command::new("python3")
            .args([
                "-m",
                "pip",
                "install",
                "--quiet",
                "--disable-pip-version-check",
                "--no-deps",
            ])
            .args([
                "--require-hashes",
                "--only-binary",
                ":all:",
                "--root-user-action",
                "ignore",
                "--target",
            ])
            .arg(&packages)
            .arg("--requirement")
            .arg(&requirements)
            .output()
            .map_err(|error| format!("pip cannot be started ({error})"))?;
        if !pip.status.success() {
            let why = String::from_utf8_lossy(&pip.stderr);
            return Err(format!(
                "pip could not fetch pycomm3 and pylogix from PyPI: {}",
                why.trim()
            ));
        }
        fs::write(&stamp, wanted).map_err(|error| format!("{stamp:?}: {error}"))?;
        Ok(Self { packages })
    }

    /// Runs `tests/python/SCRIPT` to its end and gives what it printed.
    ///
    /// # Panics
    /// When the script fails (with all it printed) or has not ended within two minutes.
    #[must_use]
    pub fn run(&self, script: &str, arguments: &[&str]) -> String {
        let mut child = Command::new("python3")
            .arg("-B")
            .arg(crate::fixture("python").join(script))
            .args(arguments)
            .env("PYTHONPATH", &self.packages)
            .env("PYTHONUNBUFFERED", "1")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("python3 was found before");
        let stdout = collect(child.stdout.take());
        let stderr = collect(child.stderr.take());
        let status = ended_within(&mut child, SCRIPT);
        let stdout = stdout.join().unwrap_or_default();
        let stderr = stderr.join().unwrap_or_default();
        assert!(
            status.is_some_and(|status| status.success()),
            "{script} ended with {status:?}; it printed:\n{stdout}\n{stderr}"
        );
        stdout
    }
}

fn collect(pipe: Option<impl io::Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(mut pipe) = pipe {
            // What came before a read error is still worth showing.
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
    // It may have ended by itself in the meantime.
    let _ = child.kill();
    let _ = child.wait();
    None
}
