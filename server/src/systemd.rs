//! The messages to systemd, or to another supervisor with `sd_notify(3)`: the server is ready, its ticks pass, it stops.
//!
//! A message is one datagram to the socket that the environment names. Without one the server says nothing; a message that does not arrive changes nothing.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::Duration;

use arcline_realtime::Clock;

use crate::plant::Plant;

/// The supervisor of this process.
#[derive(Debug)]
pub(crate) struct Supervisor {
    socket: UnixDatagram,
    /// The supervisor ends a process that is silent for this time; `None`: it does not watch.
    watchdog: Option<Duration>,
}

impl Supervisor {
    /// The one that the environment names.
    pub(crate) fn of_environment() -> Option<Self> {
        let own = std::process::id().to_string();
        let is_watched = std::env::var("WATCHDOG_PID").map_or(true, |pid| pid == own);
        let micros = std::env::var("WATCHDOG_USEC").ok().filter(|_| is_watched);
        let socket = connected(&std::env::var_os("NOTIFY_SOCKET")?);
        let socket = socket.inspect_err(|error| tracing::warn!(%error, "NOTIFY_SOCKET: the supervisor hears nothing"));
        Some(Supervisor {
            socket: socket.ok()?,
            watchdog: watchdog(micros.as_deref()),
        })
    }

    /// All listeners are bound.
    pub(crate) fn ready(&self) {
        self.say("READY=1");
    }

    /// The server ends.
    pub(crate) fn stopping(&self) {
        self.say("STOPPING=1");
    }

    /// Says that the server lives as long as its ticks pass; for ever. On the step clock they pass when a client wants.
    pub(crate) async fn watch(&self, plant: &Plant, clock: Clock) {
        let Some(watchdog) = self.watchdog else {
            return std::future::pending().await;
        };
        let mut last = None;
        loop {
            let ticks = plant.health().ticks;
            if clock == Clock::Step || last != Some(ticks) {
                self.say("WATCHDOG=1");
            }
            last = Some(ticks);
            tokio::time::sleep(watchdog / 3).await;
        }
    }

    fn say(&self, message: &str) {
        if let Err(error) = self.socket.send(message.as_bytes()) {
            tracing::debug!(%error, message, "the supervisor did not get a message");
        }
    }
}

/// A socket that sends to a path, or to an abstract name behind `@`.
fn connected(name: &OsString) -> io::Result<UnixDatagram> {
    let address = match name.as_bytes() {
        [b'@', name @ ..] => SocketAddr::from_abstract_name(name)?,
        path => SocketAddr::from_pathname(OsStr::from_bytes(path))?,
    };
    let socket = UnixDatagram::unbound()?;
    socket.connect_addr(&address)?;
    // No message waits for a supervisor that does not read.
    socket.set_nonblocking(true)?;
    Ok(socket)
}

/// The time of WATCHDOG_USEC.
fn watchdog(micros: Option<&str>) -> Option<Duration> {
    let micros: u64 = micros?.parse().ok()?;
    (micros > 0).then(|| Duration::from_micros(micros))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_go_to_a_path_and_to_an_abstract_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("notify");
        let abstract_name = format!("arcline-test-{}", std::process::id());
        let heard = [
            (
                path.clone().into_os_string(),
                UnixDatagram::bind(&path).expect("a free path"),
            ),
            (
                OsString::from(format!("@{abstract_name}")),
                UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(&abstract_name).expect("short")).expect("free"),
            ),
        ];
        for (name, socket) in heard {
            let supervisor = Supervisor {
                socket: connected(&name).expect("it is bound"),
                watchdog: None,
            };
            supervisor.ready();
            supervisor.stopping();
            for expected in ["READY=1", "STOPPING=1"] {
                let mut message = [0; 64];
                let length = socket.recv(&mut message).expect("it was sent");
                assert_eq!(&message[..length], expected.as_bytes(), "{name:?}");
            }
        }
        assert!(connected(&OsString::from("/nowhere/at/all")).is_err());
    }

    #[test]
    fn the_time_of_the_watchdog_is_in_microseconds() {
        let cases = [
            (Some("10000000"), Some(10_000)),
            (Some("0"), None),
            (Some("x"), None),
            (None, None),
        ];
        for (given, millis) in cases {
            assert_eq!(watchdog(given), millis.map(Duration::from_millis), "{given:?}");
        }
    }
}
