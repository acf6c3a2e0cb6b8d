//! Python scripts with clients from PyPI, fetched into the target folder. Nothing is installed on the machine.

use std::fs;
use std::io;
use std::path::PathBuf;
use std::process::Command;

use crate::foreign::{self, Store};

/// A Python that can import the packages of one file of `tests/python/requirements`.
pub struct Python {
    packages: PathBuf,
}

impl Python {
    /// Finds Python and fetches the packages of `client`.txt, once for each version of that file.
    ///
    /// # Errors
    /// Names the missing program on this machine.
    pub fn with(client: &str) -> Result<Self, String> {
        let requirements = crate::fixture(&format!("python/requirements/{client}.txt"));
        let version = Command::new("python3")
            .arg("--version")
            .output()
            .map_err(|error| format!("python3 cannot be started ({error}); install Python 3.9 or newer"))?;
        let wanted = fs::read_to_string(&requirements).map_err(|error| format!("{requirements:?}: {error}"))?;
        let wanted = format!("{wanted}\n{}", String::from_utf8_lossy(&version.stdout));
        let store = Store::open(&format!("python-{client}"))?;
        let packages = store.folder().join("packages");
        if store.holds(&wanted) {
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
            return Err(format!("pip could not fetch {client} from PyPI: {}", why.trim()));
        }
        store.filled(&wanted)?;
        Ok(Self { packages })
    }

    /// Runs `tests/python/SCRIPT` to its end and returns its output.
    ///
    /// # Panics
    /// When the script fails (with all its output) or has not ended within two minutes.
    #[must_use]
    pub fn run(&self, script: &str, arguments: &[&str]) -> String {
        let mut command = self.command();
        command.arg(crate::fixture("python").join(script)).args(arguments);
        foreign::run(script, &mut command)
    }

    /// Python that finds the packages, without arguments.
    #[must_use]
    pub fn command(&self) -> Command {
        let mut command = Command::new("python3");
        command
            .arg("-B")
            .env("PYTHONPATH", &self.packages)
            .env("PYTHONUNBUFFERED", "1");
        command
    }
}
