//! The `arcline` program as a user or a script starts it.

use std::net::SocketAddr;
use std::process::{Command, Stdio};

use serde_json::Value;

/// The result of one run of `arcline`.
#[derive(Debug)]
pub struct Outcome {
    /// Exit code; `None` when a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Outcome {
    /// The objects that `--json` printed.
    ///
    /// # Panics
    /// When a line of standard output is no JSON.
    #[must_use]
    pub fn objects(&self) -> Vec<Value> {
        let object = |line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error} in {self:?}"));
        self.stdout.lines().map(object).collect()
    }

    /// The exit code must be `code`.
    ///
    /// # Panics
    /// With all that was printed, when it is another.
    #[must_use]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:?}");
        self
    }
}

/// Runs `arcline --server ADDRESS ARGUMENTS` to its end.
#[must_use]
pub fn arcline(server: SocketAddr, arguments: &[&str]) -> Outcome {
    let output = command(server, arguments)
        .output()
        .expect("the command line was just built");
    Outcome {
        code: output.status.code(),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// The same, not yet started.
#[must_use]
pub fn command(server: SocketAddr, arguments: &[&str]) -> Command {
    let mut command = Command::new(crate::programs::arcline());
    command
        .args(["--server", &server.to_string()])
        .args(arguments)
        .stdin(Stdio::null());
    command
}

/// Numbers that `arcline --json read TAGS` gives, one for each tag; of a BOOL 1 or 0.
///
/// # Panics
/// When a tag cannot be read as a number.
#[must_use]
pub fn read_numbers(server: SocketAddr, tags: &[&str]) -> Vec<f64> {
    let arguments: Vec<&str> = ["--json", "read"].iter().chain(tags).copied().collect();
    let objects = arcline(server, &arguments).expect(0).objects();
    let number = |object: &Value| {
        let bit = || object["value"].as_bool().map(|bit| f64::from(u8::from(bit)));
        object["value"]
            .as_f64()
            .or_else(bit)
            .unwrap_or_else(|| panic!("no number: {object}"))
    };
    objects.iter().map(number).collect()
}
