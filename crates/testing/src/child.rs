//! The output of a server to its parent process: its ready line on standard output, and its log on standard error.

use std::io::{BufRead as _, BufReader, Read as _};
use std::net::SocketAddr;
use std::process::{ChildStderr, ChildStdout};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// The standard error of a server, collected while it runs.
#[derive(Debug)]
pub struct Log {
    text: Arc<Mutex<Vec<u8>>>,
    reader: Option<JoinHandle<()>>,
}

impl Log {
    /// Begins to read.
    #[must_use]
    pub fn read(mut stderr: ChildStderr) -> Self {
        let text = Arc::new(Mutex::new(Vec::new()));
        let shared = text.clone();
        let reader = std::thread::spawn(move || {
            let mut piece = [0; 4096];
            // A read error ends the log; what came before it is what there is to show.
            while let Ok(length @ 1..) = stderr.read(&mut piece) {
                let mut text = shared.lock().unwrap_or_else(PoisonError::into_inner);
                text.extend_from_slice(&piece[..length]);
            }
        });
        Self {
            text,
            reader: Some(reader),
        }
    }

    /// So far.
    #[must_use]
    pub fn so_far(&self) -> String {
        let text = self.text.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(&text).into_owned()
    }

    /// To its end, which must be near; once.
    pub fn until_the_end(&mut self) -> Option<String> {
        // A reader that panicked has shown what it has.
        let _ = self.reader.take()?.join();
        Some(self.so_far())
    }
}

/// The first line of a server's standard output, without its end; what comes behind it is read and dropped. Empty: the server ended without one.
///
/// # Errors
/// There was none in that time.
pub fn first_line(stdout: ChildStdout, within: Duration) -> Result<String, RecvTimeoutError> {
    let (sender, line) = mpsc::channel();
    std::thread::spawn(move || {
        let mut lines = BufReader::new(stdout).lines();
        // The receiver is gone once the line has come or the waiting was given up.
        let _ = sender.send(lines.next().and_then(Result::ok).unwrap_or_default());
        lines.for_each(drop);
    });
    line.recv_timeout(within)
}

/// An address in `ready eip=127.0.0.1:44818 hmi=off`, by the word before it: `eip=`.
#[must_use]
pub fn ready_address(line: &str, name: &str) -> Option<SocketAddr> {
    let mut words = line.split_whitespace();
    (words.next() == Some("ready")).then_some(())?;
    words.find_map(|word| word.strip_prefix(name))?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ready_lines() {
        #[rustfmt::skip]
        let cases = [
            // why,                   line,                                           of,     address
            ("the contract's line",   "ready eip=127.0.0.1:44818 hmi=127.0.0.1:8080", "eip=", Some("127.0.0.1:44818")),
            ("its second address",    "ready eip=127.0.0.1:44818 hmi=127.0.0.1:8080", "hmi=", Some("127.0.0.1:8080")),
            ("no HMI",                "ready eip=127.0.0.1:40001 hmi=off",            "eip=", Some("127.0.0.1:40001")),
            ("no HMI, asked for it",  "ready eip=127.0.0.1:40001 hmi=off",            "hmi=", None),
            ("something else",        "listening eip=127.0.0.1:40001",                "eip=", None),
            ("no address",            "ready hmi=off",                                "eip=", None),
            ("the server has ended",  "",                                             "eip=", None),
        ];
        for (why, line, of, address) in cases {
            let expected = address.map(|text| text.parse().expect("an address"));
            assert_eq!(ready_address(line, of), expected, "{why}: {line}");
        }
    }
}
