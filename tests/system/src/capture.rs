//! Records the traffic of the loopback interface and checks it with Wireshark's dissectors.
//!
//! Needs `dumpcap` and `tshark` (Debian's package `tshark`) and the right to capture, which root has.

use std::fs;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The longest time for the capture to begin and to catch up.
const CATCH_UP: Duration = Duration::from_secs(20);

/// A capture of all EtherNet/IP traffic of one server, from its start on.
pub struct Capture {
    dumpcap: Child,
    file: PathBuf,
    server: SocketAddr,
    _folder: tempfile::TempDir,
}

impl Capture {
    /// Starts recording, and returns once frames are really being written.
    ///
    /// # Errors
    /// Names the missing program on this machine.
    pub fn of(server: SocketAddr) -> Result<Self, String> {
        Self::with(server, &format!("port {}", server.port()))
    }

    /// As [`Self::of`], with the datagrams of implicit I/O, which are on UDP port 2222 of the server's address.
    ///
    /// # Errors
    /// Names the missing program on this machine.
    pub fn with_io(server: SocketAddr) -> Result<Self, String> {
        Self::with(
            server,
            &format!("port {} or (host {} and udp port 2222)", server.port(), server.ip()),
        )
    }

    fn with(server: SocketAddr, filter: &str) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
        let file = folder.path().join("run.pcapng");
        for program in ["dumpcap", "tshark"] {
            Command::new(program)
                .arg("--version")
                .output()
                .map_err(|error| format!("{program} cannot be started ({error}); install Debian's package tshark"))?;
        }
        let dumpcap = Command::new("dumpcap")
            .args(["-q", "-i", "lo", "-B", "64", "-f", filter, "-w"])
            .arg(&file)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("dumpcap: {error}"))?;
        let mut capture = Self {
            dumpcap,
            file,
            server,
            _folder: folder,
        };
        capture.wait_for_mark(*b"arcline0").map(|()| capture)
    }

    /// Ends the recording once everything sent so far is in the file, and gives the file to the dissectors.
    ///
    /// # Errors
    /// Names the error of a program; the dissectors' findings are in the [`Verdict`].
    pub fn finish(mut self) -> Result<Verdict, String> {
        self.wait_for_mark(*b"arcline9")?;
        crate::server::signal("INT", self.dumpcap.id());
        self.dumpcap.wait().map_err(|error| format!("dumpcap: {error}"))?;
        let frames = dissect(&self.file, self.server.port(), "enip || cipio")?;
        let faults = dissect(
            &self.file,
            self.server.port(),
            "_ws.malformed || _ws.expert.severity >= \"Error\"",
        )?;
        Ok(Verdict {
            frames: frames.len(),
            faults,
        })
    }

    /// Sends ListIdentity requests with `mark` as their sender context until one of them is in the file.
    fn wait_for_mark(&mut self, mark: [u8; 8]) -> Result<(), String> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(|error| error.to_string())?;
        let request = list_identity(mark);
        let deadline = std::time::Instant::now() + CATCH_UP;
        while std::time::Instant::now() < deadline {
            socket
                .send_to(&request, self.server)
                .map_err(|error| error.to_string())?;
            std::thread::sleep(Duration::from_millis(50));
            if fs::read(&self.file).is_ok_and(|bytes| bytes.windows(8).any(|window| window == mark)) {
                return Ok(());
            }
            if let Ok(Some(status)) = self.dumpcap.try_wait() {
                let mut why = String::new();
                if let Some(mut stderr) = self.dumpcap.stderr.take() {
                    // Show the part that could be read.
                    let _ = std::io::Read::read_to_string(&mut stderr, &mut why);
                }
                return Err(format!("dumpcap cannot record on lo ({status}): {}", why.trim()));
            }
        }
        Err(format!("dumpcap wrote no frame within {CATCH_UP:?}"))
    }
}

impl Drop for Capture {
    fn drop(&mut self) {
        // Already ended: nothing to do.
        let _ = self.dumpcap.kill();
        let _ = self.dumpcap.wait();
    }
}

/// The findings of the dissectors.
pub struct Verdict {
    /// EtherNet/IP frames in the capture.
    pub frames: usize,
    /// One line for each frame that is malformed or carries an expert note of severity error.
    pub faults: Vec<String>,
}

/// An encapsulation frame ListIdentity (command 0x0063) with `context` as sender context (CIP Vol. 2, 2-4.2).
#[must_use]
pub fn list_identity(context: [u8; 8]) -> [u8; 24] {
    let mut frame = [0; 24];
    frame[0] = 0x63;
    frame[12..20].copy_from_slice(&context);
    frame
}

/// The frames of `file` that `filter` selects, one line each.
fn dissect(file: &Path, port: u16, filter: &str) -> Result<Vec<String>, String> {
    let output = Command::new("tshark")
        .arg("-r")
        .arg(file)
        .args([
            "-d",
            &format!("tcp.port=={port},enip"),
            "-d",
            &format!("udp.port=={port},enip"),
            "-Y",
            filter,
        ])
        .output()
        .map_err(|error| format!("tshark: {error}"))?;
    if !output.status.success() {
        return Err(format!(
            "tshark {filter}: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout)
        .lines()
        .map(str::to_owned)
        .collect())
}
