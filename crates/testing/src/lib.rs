//! A real `arcline-server` for the length of a test: [`Server::spawn`] starts one on free ports, and it ends with the [`Server`], or with the process
//! of the test, however that ends.
//!
//! Not here: clients; `arcline-client` is one. Only the standard library, and Linux.

#![forbid(unsafe_code)]

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io::{self, BufRead as _, BufReader, Read};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The environment variable that names the program; without it, `arcline-server` of the path is started.
pub const PROGRAM: &str = "ARCLINE_SERVER_PROGRAM";

/// How a server is started.
#[derive(Clone, Debug)]
pub struct Builder {
    program: PathBuf,
    arguments: Vec<OsString>,
    ready_within: Duration,
}

/// A running server. Dropped, it ends.
#[derive(Debug)]
pub struct Server {
    child: Child,
    /// The server ends when it closes.
    input: Option<ChildStdin>,
    eip: SocketAddr,
    hmi: Option<SocketAddr>,
    log: Arc<Mutex<Vec<u8>>>,
    reader: Option<JoinHandle<()>>,
}

/// Why a server does not run.
#[derive(Debug)]
pub enum SpawnError {
    /// The program cannot be started.
    Start {
        /// The program.
        program: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It ended, or was not ready in time.
    NotReady {
        /// What it printed and logged.
        said: String,
    },
}

impl fmt::Display for SpawnError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start { program, source } => write!(
                f,
                "{}: {source}; build it with `cargo install --locked --path server`, or name it by {PROGRAM}",
                program.display()
            ),
            Self::NotReady { said } => write!(f, "the server is not ready: {said}"),
        }
    }
}

impl std::error::Error for SpawnError {}

impl Builder {
    /// A program of another place.
    #[must_use]
    pub fn program(mut self, program: impl AsRef<Path>) -> Self {
        program.as_ref().clone_into(&mut self.program);
        self
    }

    /// The machine of a configuration file; without it, the default one.
    #[must_use]
    pub fn config(self, file: impl AsRef<OsStr>) -> Self {
        self.argument("--config").argument(file)
    }

    /// What makes ticks pass: `real`, `step` or `fast:N`.
    #[must_use]
    pub fn clock(self, clock: &str) -> Self {
        self.argument("--clock").argument(clock)
    }

    /// A further argument of `arcline-server run`.
    #[must_use]
    pub fn argument(mut self, argument: impl AsRef<OsStr>) -> Self {
        self.arguments.push(argument.as_ref().to_owned());
        self
    }

    /// Longest wait until the server is ready; 20 s without it.
    #[must_use]
    pub fn ready_within(mut self, time: Duration) -> Self {
        self.ready_within = time;
        self
    }

    /// Starts the server and waits until it accepts connections.
    ///
    /// # Errors
    /// The program cannot be started, or is not ready in time.
    pub fn spawn(self) -> Result<Server, SpawnError> {
        let mut child = Command::new(&self.program)
            .args([
                "run",
                "--listen",
                "127.0.0.1:0",
                "--hmi",
                "127.0.0.1:0",
                "--state",
                "off",
                "--end-with-stdin",
            ])
            .args(&self.arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|source| SpawnError::Start {
                program: self.program.clone(),
                source,
            })?;
        let log = Arc::new(Mutex::new(Vec::new()));
        let reader = child.stderr.take().map(|stderr| read_log(stderr, log.clone()));
        let (sender, line) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut line = String::new();
                // What could not be read is no ready line.
                let _ = BufReader::new(stdout).read_line(&mut line);
                let _ = sender.send(line);
            });
        }
        let line = match line.recv_timeout(self.ready_within) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => format!("nothing within {:?} ", self.ready_within),
            Err(RecvTimeoutError::Disconnected) => String::new(),
        };
        let address = |key: &str| {
            line.split_whitespace()
                .find_map(|part| part.strip_prefix(key)?.parse().ok())
        };
        let (eip, hmi) = (address("eip="), address("hmi="));
        let input = child.stdin.take();
        // From here on it ends with the value.
        let mut server = Server {
            child,
            input,
            eip: eip.unwrap_or(SocketAddr::from(([127, 0, 0, 1], 0))),
            hmi,
            log,
            reader,
        };
        if eip.is_some() {
            return Ok(server);
        }
        server.end();
        let said = format!("{line}{}", server.log());
        Err(SpawnError::NotReady { said })
    }
}

impl Server {
    /// Starts a server with the default machine.
    ///
    /// # Errors
    /// As [`Builder::spawn`].
    pub fn spawn() -> Result<Self, SpawnError> {
        Self::builder().spawn()
    }

    /// A server that is to be started.
    #[must_use]
    pub fn builder() -> Builder {
        Builder {
            program: std::env::var_os(PROGRAM).map_or_else(|| "arcline-server".into(), PathBuf::from),
            arguments: Vec::new(),
            ready_within: READY_WITHIN,
        }
    }

    /// The address of EtherNet/IP.
    #[must_use]
    pub fn eip(&self) -> SocketAddr {
        self.eip
    }

    /// The address of the web page; `None`: it has none.
    #[must_use]
    pub fn hmi(&self) -> Option<SocketAddr> {
        self.hmi
    }

    /// The number of the process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// What the server has written to standard error so far.
    #[must_use]
    pub fn log(&self) -> String {
        let log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(&log).into_owned()
    }

    /// Stops all motion and the server. `None`: it did not end by itself.
    pub fn stop(mut self) -> Option<ExitStatus> {
        self.end()
    }

    /// Ends the server; kills it when it takes too long.
    fn end(&mut self) -> Option<ExitStatus> {
        drop(self.input.take());
        let began = Instant::now();
        let ended = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if began.elapsed() < ENDS_WITHIN => std::thread::sleep(Duration::from_millis(1)),
                Ok(None) | Err(_) => break None,
            }
        };
        if ended.is_none() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        if let Some(reader) = self.reader.take() {
            // It has read what there is.
            let _ = reader.join();
        }
        ended
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end();
    }
}

fn read_log(mut stderr: ChildStderr, log: Arc<Mutex<Vec<u8>>>) -> JoinHandle<()> {
    std::thread::spawn(move || {
        let mut piece = [0; 4096];
        while let Ok(length @ 1..) = stderr.read(&mut piece) {
            let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
            log.extend_from_slice(&piece[..length]);
        }
    })
}

/// Far more than a server needs, for machines that are busy.
const READY_WITHIN: Duration = Duration::from_secs(20);
/// Until a server that moves something stands still, and has written its state.
const ENDS_WITHIN: Duration = Duration::from_secs(10);
