//! The real server on a disk that fails: every system call of the retained state can be made to fail, to wait or to be the last one (strace), and
//! a file system can be full (tmpfs).
//!
//! `ARCLINE_CALLS` sets up to which call of each kind one is the last one, or fails: 40 without it.
#![allow(missing_docs)]

mod calls;
mod slow;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use arcline_client::{Client, ClientError, WriteValue};
use arcline_state::{RetainedState, parse};
use arcline_system_tests::server::{NotReady, Server};
use arcline_system_tests::{not_granted, not_run, programs};

/// DINTs that a client writes in one message.
const ELEMENTS: usize = 16;
/// The calls by which the server uses its state file.
const CALLS: &str = "openat,write,pwrite64,fdatasync,fsync,rename,unlink";

/// A machine with a table of DINTs, and a folder for its state.
struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let files = Files { folder };
        let tag = format!("\n[[tag]]\nname = \"Table\"\ntype = \"DINT[{ELEMENTS}]\"\n");
        let text = arcline_config::DEFAULT.to_owned() + &tag;
        std::fs::write(files.path("machine.toml"), text).expect("the folder is writable");
        files
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The same, with a state that a server has left.
    fn with_state(state: &[u8]) -> Self {
        let files = Files::new();
        std::fs::write(files.path("machine.state"), state).expect("the folder is writable");
        files
    }

    fn start(&self) -> Server {
        let started = self.start_under(Command::new(programs::arcline_server()), &self.path("machine.state"));
        started.unwrap_or_else(|not_ready| panic!("{not_ready}"))
    }

    fn start_under(&self, command: Command, state: &Path) -> Result<Server, NotReady> {
        let [config, state] = [&self.path("machine.toml"), state].map(|path| path.display().to_string());
        Server::try_start(command, &["--config", &config, "--state", &state])
    }

    /// Starts the server under strace, which does something to the calls that concern its state file.
    fn start_injected(&self, injection: &str) -> Result<Server, NotReady> {
        let mut strace = Command::new("strace");
        // As a grandchild, so that the server is the child that tests kill.
        strace.args(["-D", "-f", "-qqq", "-o", "/dev/null"]);
        strace.arg("-e").arg(format!("trace={CALLS}"));
        strace.arg("-e").arg(format!("inject={injection}"));
        for name in ["machine.state", "machine.state.new"] {
            strace.arg("-P").arg(self.path(name));
        }
        strace.arg("-P").arg(self.folder.path());
        strace.arg(programs::arcline_server());
        self.start_under(strace, &self.path("machine.state"))
    }

    /// The state in the file; `None`: there is none.
    fn read(&self, why: &str) -> Option<RetainedState> {
        let bytes = std::fs::read(self.path("machine.state")).ok()?;
        Some(parse(&bytes).unwrap_or_else(|damage| panic!("{why}: {damage}")).state)
    }

    /// The number that the table in the file is full of.
    fn table(&self, why: &str) -> Option<i64> {
        let state = self.read(why)?;
        let numbers: Vec<i32> = (state.tags[0].bytes.chunks_exact(4))
            .filter_map(|four| four.first_chunk().copied().map(i32::from_le_bytes))
            .collect();
        assert_eq!(numbers, [numbers[0]; ELEMENTS], "{why}: the table is of one message");
        Some(numbers[0].into())
    }
}

fn strace_is_missing(test: &str) -> bool {
    let traced = Command::new("strace")
        .args(["-D", "-qqq", "-o", "/dev/null", "true"])
        .output();
    match traced {
        Ok(output) if output.status.success() => return false,
        Ok(output) => not_granted(test, &String::from_utf8_lossy(&output.stderr)),
        Err(error) => not_run(test, &format!("strace: {error} (Debian: apt-get install strace)")),
    }
    true
}

async fn write(client: &Client, number: i64) -> Result<(), ClientError> {
    client
        .write("Table", WriteValue::Array(vec![WriteValue::from(number); ELEMENTS]))
        .await
}

/// Whether a write was refused because the file could not store it.
fn is_not_persistent(error: &ClientError) -> bool {
    error.to_string().contains("could not save it")
}

async fn connect(server: &Server) -> Client {
    let client = Client::connect(&server.address().to_string()).await;
    client.expect("a ready server accepts")
}

/// A file system in memory, gone when this is dropped.
struct Small(PathBuf);

impl Small {
    fn mount(at: PathBuf) -> Result<Self, String> {
        std::fs::create_dir(&at).map_err(|error| error.to_string())?;
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=1m", "tmpfs"])
            .arg(&at)
            .output();
        match mounted {
            Ok(output) if output.status.success() => Ok(Small(at)),
            Ok(output) => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
            Err(error) => Err(error.to_string()),
        }
    }
}

impl Drop for Small {
    fn drop(&mut self) {
        // The folder that is removed with the test would stay otherwise, and the next run has another one.
        let _ = Command::new("umount").arg("-l").arg(&self.0).output();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_file_system_recovers_when_there_is_room_again() {
    let files = Files::new();
    let small = match Small::mount(files.path("small")) {
        Ok(small) => small,
        Err(why) => return not_granted("a full tmpfs", &why),
    };
    let (state, filler) = (small.0.join("machine.state"), small.0.join("filler"));
    let program = || Command::new(programs::arcline_server());
    let server = files
        .start_under(program(), &state)
        .unwrap_or_else(|not_ready| panic!("{not_ready}"));
    let client = connect(&server).await;
    write(&client, 1).await.expect("there is room");
    // As long as there is room for a byte.
    let mut room = 1024 * 1024;
    while room > 0 {
        let filled = std::fs::OpenOptions::new().create(true).append(true).open(&filler);
        let written = filled.and_then(|mut file| std::io::Write::write_all(&mut file, &vec![0; room]));
        room = if written.is_ok() { room } else { room / 2 };
    }
    let mut number = 1;
    while write(&client, number + 1).await.is_ok() {
        number += 1;
        assert!(number < 10_000, "the file system has a limit");
    }
    drop(client);
    let _ = server.kill();
    // A server that starts on a full disk has the answered writes, and refuses new ones.
    let server = files
        .start_under(program(), &state)
        .unwrap_or_else(|not_ready| panic!("{not_ready}"));
    let client = connect(&server).await;
    let shown = client.read_numbers("Table").await.expect("a tag");
    assert_eq!(shown, [number as f64; ELEMENTS]);
    let refused = write(&client, 100_000).await.expect_err("the disk is full");
    assert!(is_not_persistent(&refused), "{refused}");
    std::fs::remove_file(&filler).expect("it was written");
    let until = Instant::now() + Duration::from_secs(20);
    while write(&client, 200_000).await.is_err() {
        assert!(Instant::now() < until, "it is never written again");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let _ = server.kill();
    let bytes = std::fs::read(&state).expect("it is there");
    let kept = parse(&bytes).expect("whole").state;
    assert_eq!(kept.tags[0].bytes[..4], 200_000_i32.to_le_bytes());
}
