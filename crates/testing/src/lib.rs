//! A real `arcline-server` for the length of a test: [`Server::spawn`] starts one on free ports, and it ends with the [`Server`], or with the process
//! of the test, however that ends.
//!
//! Not here: clients; `arcline-client` is one. Only the standard library, and Linux.

#![forbid(unsafe_code)]

pub mod child;

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use child::{Log, first_line, ready_address};

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
    log: Option<Log>,
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
        /// Its output and its log.
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

    /// The clock of the ticks: `real`, `step` or `fast:N`.
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
        let log = child.stderr.take().map(Log::read);
        let line = child.stdout.take().map(|stdout| first_line(stdout, self.ready_within));
        let line = match line {
            Some(Ok(line)) => line,
            Some(Err(_)) => format!("nothing within {:?} ", self.ready_within),
            None => String::new(),
        };
        let address = |key: &str| ready_address(&line, key);
        let (eip, hmi) = (address("eip="), address("hmi="));
        let input = child.stdin.take();
        // From here on it ends with the value.
        let mut server = Server {
            child,
            input,
            eip: eip.unwrap_or(SocketAddr::from(([127, 0, 0, 1], 0))),
            hmi,
            log,
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

    /// The standard error of the server so far.
    #[must_use]
    pub fn log(&self) -> String {
        self.log.as_ref().map_or_else(String::new, Log::so_far)
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
        if let Some(log) = &mut self.log {
            // It has then read what there is.
            let _ = log.until_the_end();
        }
        ended
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end();
    }
}

/// Far more than a server needs, for machines that are busy.
const READY_WITHIN: Duration = Duration::from_secs(20);
/// Until a server that moves something stands still, and has written its state.
const ENDS_WITHIN: Duration = Duration::from_secs(10);
