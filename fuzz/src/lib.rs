//! What the fuzz targets share: a watch on how long an input takes, and the device that those of sessions talk to.
//!
//! Not a target itself, and without tags: the driver of a session answers its requests. Times are since the run's beginning.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use arcline_proto::cip::CipStatus;
use arcline_proto::connection::{ConnectionKey, Count};
use arcline_proto::identity::Identity;
use arcline_proto::io::{Assemblies, Assembly, IO_PORT, IoConnections, IoSettings, Originator};
use arcline_proto::session::{Host, IoOpen, IoOpened};
use rustix::time::{ClockId, clock_gettime};

/// The near end.
pub const LOCAL: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1), 44818);
/// The far end.
pub const PEER: IpAddr = IpAddr::V4(Ipv4Addr::new(10, 0, 0, 9));
/// I/O connections at a time.
pub const MOST: usize = 4;
/// Bytes of the assemblies 100 (inputs) and 150 (outputs).
pub const SIZE: u16 = 8;

/// Draws 1, 2, 3 … so that inputs can name the session (1) and what was opened after it.
pub struct Device {
    drawn: u32,
    /// Class 3 connections that the session said it has.
    pub open: usize,
    /// The time.
    pub now: Duration,
    /// Class 0 and 1 connections.
    pub io: IoConnections,
    identity: Identity,
}

impl Default for Device {
    fn default() -> Self {
        let assembly = |instance| Assembly { instance, size: SIZE };
        Self {
            drawn: 0,
            open: 0,
            now: Duration::ZERO,
            io: IoConnections::new(IoSettings {
                assemblies: Assemblies {
                    input: assembly(100),
                    output: assembly(150),
                    configuration: 151,
                    input_only: 254,
                    listen_only: 255,
                },
                max_connections: MOST,
                min_interval: 1000,
                volatile: 2,
                local: SocketAddr::new((*LOCAL.ip()).into(), IO_PORT),
            }),
            identity: Identity::new("Arcline", 1),
        }
    }
}

/// Runs an input and tells when none before took as long. Time is the thread's own, so that a busy machine slows nothing down.
///
/// # Panics
/// When it takes longer than [`LONGEST`]: that is a hang.
pub fn timed(run: impl FnOnce()) {
    static SLOWEST: AtomicU64 = AtomicU64::new(1_000);
    let began = own_time();
    run();
    let took = own_time() - began;
    let micros = u64::try_from(took.as_micros()).unwrap_or(u64::MAX);
    if SLOWEST.fetch_max(micros, Ordering::Relaxed) < micros {
        eprintln!("slowest input so far: {took:?}");
    }
    assert!(took < LONGEST, "an input took {took:?}");
}

/// 10 ms, and what the sanitizer and the counting of branches make of them.
pub const LONGEST: Duration = Duration::from_millis(200);

fn own_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(
        u64::try_from(time.tv_sec).unwrap_or_default(),
        u32::try_from(time.tv_nsec).unwrap_or_default(),
    )
}

fn draw(drawn: &mut u32) -> Option<u32> {
    *drawn = drawn.wrapping_add(1);
    Some(*drawn)
}

impl Host for Device {
    fn random(&mut self) -> Option<u32> {
        draw(&mut self.drawn)
    }

    fn acquire_connection(&mut self) -> bool {
        self.open += 1;
        true
    }

    fn release_connections(&mut self, count: usize) {
        self.open -= count;
    }

    fn count(&mut self, _count: Count) {}

    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn open_io(&mut self, open: &IoOpen<'_>) -> Result<IoOpened, CipStatus> {
        let originator = Originator {
            address: PEER,
            port: open.port,
            group: Some(Ipv4Addr::new(239, 192, 1, 0)),
        };
        let drawn = &mut self.drawn;
        let reply = self
            .io
            .open(open.open, open.application, originator, self.now, || draw(drawn))?;
        Ok(IoOpened {
            reply,
            listens: SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, IO_PORT),
            group: None,
        })
    }

    fn close_io(&mut self, key: ConnectionKey) -> bool {
        self.io.close(key, PEER).is_ok()
    }
}
