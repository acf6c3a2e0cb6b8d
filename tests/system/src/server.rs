//! A real `arcline-server` for the length of a test. Knows its command line and its ready line, nothing else.

use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use arcline_testing::child::{Log, first_line, ready_address};

/// The longest time until a server is ready; far more than it needs, for busy machines.
const READY: Duration = Duration::from_secs(20);

/// A running server, ended when this is dropped.
pub struct Server {
    child: Child,
    address: SocketAddr,
    hmi: Option<SocketAddr>,
    hmi_tls: Option<SocketAddr>,
    tls: Option<SocketAddr>,
    ready_after: Duration,
    log: Log,
}

/// A server that ended before it was ready, or was not ready in time, with its log.
#[derive(Debug)]
pub struct NotReady(String);

impl std::fmt::Display for NotReady {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl Server {
    /// Starts the server on its default configuration and a free port.
    ///
    /// # Panics
    /// When it is not ready in time, with its log.
    #[must_use]
    pub fn start() -> Self {
        Self::start_with(&[])
    }

    /// Starts the server on the configuration in `file` and a free port.
    #[must_use]
    pub fn start_on(file: &Path) -> Self {
        Self::start_with(&["--config", file.to_str().expect("the project's paths are UTF-8")])
    }

    /// Starts the server with `arguments` besides those for a free port and, unless they name one, no HMI and no
    /// state file.
    #[must_use]
    pub fn start_with(arguments: &[&str]) -> Self {
        Self::start_at("127.0.0.1:0", arguments)
    }

    /// The same at an address and port, port 0 for a free one.
    #[must_use]
    pub fn start_at(listen: &str, arguments: &[&str]) -> Self {
        Self::start_by(Command::new(crate::programs::arcline_server()), listen, arguments)
    }

    /// The same, but no file that the server writes may become longer than a number of blocks of 512 or 1024 bytes: a write beyond
    /// fails, as on a full disk.
    #[must_use]
    pub fn start_short_of_space(blocks: u32, arguments: &[&str]) -> Self {
        // The shell becomes the server, which is not to end by the signal that goes with the limit.
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(script).arg(crate::programs::arcline_server());
        Self::start_by(shell, "127.0.0.1:0", arguments)
    }

    /// Starts the server by a command that becomes it, or runs it.
    ///
    /// # Errors
    /// When it is not ready in time, or ends before it is.
    pub fn try_start(command: Command, arguments: &[&str]) -> Result<Self, NotReady> {
        Self::start_or_say(command, "127.0.0.1:0", arguments)
    }

    fn start_by(command: Command, listen: &str, arguments: &[&str]) -> Self {
        Self::start_or_say(command, listen, arguments).unwrap_or_else(|not_ready| panic!("{not_ready}"))
    }

    fn start_or_say(mut command: Command, listen: &str, arguments: &[&str]) -> Result<Self, NotReady> {
        let began = Instant::now();
        let mut child = command
            .args(["run", "--listen", listen])
            .args(if arguments.contains(&"--hmi") {
                &[][..]
            } else {
                &["--hmi", "off"]
            })
            .args(if arguments.contains(&"--state") {
                &[][..]
            } else {
                &["--state", "off"]
            })
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server was just built");
        let stdout = child.stdout.take().expect("stdout is piped");
        let mut log = Log::read(child.stderr.take().expect("stderr is piped"));
        let line = first_line(stdout, READY).unwrap_or_default();
        let ready_after = began.elapsed();
        let Some(address) = ready_address(&line, "eip=") else {
            // The server may have ended by itself; its log has the reason in either case.
            let _ = child.kill();
            let status = child.wait();
            return Err(NotReady(format!(
                "no ready line within {READY:?} but {line:?} ({status:?}); the server's log:\n{}",
                log.until_the_end().unwrap_or_default()
            )));
        };
        Ok(Self {
            hmi: ready_address(&line, "hmi="),
            hmi_tls: ready_address(&line, "hmi_tls="),
            tls: ready_address(&line, "tls="),
            child,
            address,
            ready_after,
            log,
        })
    }

    /// The address of EtherNet/IP, TCP and UDP.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The address of the HMI, if it is on.
    #[must_use]
    pub fn hmi(&self) -> Option<SocketAddr> {
        self.hmi
    }

    /// The address of the HMI over HTTPS, if it is on.
    #[must_use]
    pub fn hmi_tls(&self) -> Option<SocketAddr> {
        self.hmi_tls
    }

    /// The address of EtherNet/IP over TLS, if it is on.
    #[must_use]
    pub fn tls(&self) -> Option<SocketAddr> {
        self.tls
    }

    /// The process, for signals.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// The time from just before the start of the process to its ready line.
    #[must_use]
    pub fn ready_after(&self) -> Duration {
        self.ready_after
    }

    /// Makes the server read its configuration again, with SIGHUP.
    pub fn hang_up(&self) {
        signal("HUP", self.child.id());
    }

    /// The text of its log so far.
    #[must_use]
    pub fn log(&self) -> String {
        self.log.so_far()
    }

    /// Ends the server at once, with SIGKILL, and waits until it is gone. Returns its messages, as [`Self::terminate`].
    #[must_use]
    pub fn kill(mut self) -> String {
        self.child.kill().expect("the server is our child and runs");
        self.child.wait().expect("the server is our child");
        said(&self.log.until_the_end().unwrap_or_default())
    }

    /// Asks the server to stop, as an init system would, and waits until it has ended. Returns its messages, without those about permissions
    /// that the machine refuses.
    ///
    /// # Panics
    /// When it has not ended within 20 seconds.
    pub fn terminate(mut self) -> (ExitStatus, String) {
        signal("TERM", self.child.id());
        let child = &mut self.child;
        let status = crate::eventually("end of the server after SIGTERM", READY, || {
            child.try_wait().expect("the server is our child")
        });
        (status, said(&self.log.until_the_end().unwrap_or_default()))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // Already ended: nothing to do.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if let Some(log) = self.log.until_the_end()
            && (std::thread::panicking() || log.contains("panicked"))
        {
            eprintln!(
                "--- log of the server on {} ---\n{log}--- end of the log ---",
                self.address
            );
        }
    }
}

/// The lines of a log that are not about the priority that a machine grants to some users and not to others.
#[must_use]
pub fn said(log: &str) -> String {
    log.split_inclusive('\n')
        .filter(|line| !line.contains(" arcline_realtime::thread: no real-time priority"))
        .collect()
}

/// Sends a signal to a process that a test has started.
///
/// # Panics
/// When there is no `kill` program.
pub fn signal(name: &str, process: u32) {
    let status = Command::new("kill")
        .args([&format!("-{name}"), &process.to_string()])
        .status();
    assert!(
        status.is_ok_and(|status| status.success()),
        "kill -{name} {process} failed"
    );
}

/// The processor time of all threads of a process so far.
///
/// # Panics
/// The process has ended.
#[must_use]
pub fn processor_time(process: u32) -> Duration {
    let threads = std::fs::read_dir(format!("/proc/{process}/task")).expect("Linux shows it");
    let time = |thread: std::io::Result<std::fs::DirEntry>| {
        let text = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    };
    Duration::from_nanos(threads.filter_map(time).sum())
}
