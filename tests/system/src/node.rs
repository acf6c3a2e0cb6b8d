//! JavaScript with packages from npm, fetched into the target folder. Nothing is installed on the machine.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::foreign::{self, Store};

/// A Node.js with the packages of a folder of tests.
pub struct Node {
    scripts: PathBuf,
    folder: PathBuf,
}

impl Node {
    /// Finds Node.js and npm and fetches the packages of `tests/NAME/package-lock.json` into `target/NAME`, once for
    /// each version of the lock file.
    ///
    /// # Errors
    /// Names the missing program on this machine.
    pub fn with(name: &str) -> Result<Self, String> {
        let version = output("node", Command::new("node").arg("--version"))?;
        output("npm", Command::new("npm").arg("--version"))?;
        let scripts = crate::fixture(name);
        let lock = scripts.join("package-lock.json");
        let wanted = fs::read_to_string(&lock).map_err(|error| format!("{lock:?}: {error}"))? + &version;
        let store = Store::open(name)?;
        let folder = store.folder().to_owned();
        if !store.holds(&wanted) {
            for file in ["package.json", "package-lock.json"] {
                let from = scripts.join(file);
                fs::copy(&from, folder.join(file)).map_err(|error| format!("{from:?}: {error}"))?;
            }
            let mut npm = Command::new("npm");
            npm.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"]);
            output("npm", npm.current_dir(&folder))
                .map_err(|why| format!("npm could not fetch the packages of tests/{name}: {why}"))?;
            store.filled(&wanted)?;
        }
        Ok(Self { scripts, folder })
    }

    /// Runs the script of `tests/NAME` to its end and returns its output.
    ///
    /// # Panics
    /// As [`foreign::run`].
    #[must_use]
    pub fn run(&self, script: &str, arguments: &[&str]) -> String {
        let mut command = Command::new("node");
        command
            .arg(self.scripts.join(script))
            .args(arguments)
            .current_dir(&self.folder);
        foreign::run(script, &mut command)
    }
}

/// The output of a program, or its error.
fn output(name: &str, command: &mut Command) -> Result<String, String> {
    let output = command
        .output()
        .map_err(|error| format!("{name} cannot be started ({error}); install Node.js 18 or newer with npm"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).trim().to_owned())
    }
}
