//! The thread of implicit I/O: it sleeps until a datagram comes or something is due.
//!
//! What has arrived is taken before a watchdog is looked at, so that a thread that was late itself ends no connection.
//! It comes after the tick and before everything else, where the system allows that, so it bounds its own work: a flood of
//! datagrams makes it pause. It waits only for the short locks of the connections and of the plant.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use arcline_realtime::prepare_beside_tick;
use bytes::BytesMut;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use tracing::{debug, error};

use super::lateness::Lateness;
use super::{Io, apply_events, lock};
use crate::eip::device::Device;

/// Datagrams that are taken before what is due is done.
const BATCH: usize = 128;
/// Rest after as many, unless something is due: what comes faster than this is no I/O but a flood, and is lost.
const REST: Duration = Duration::from_micros(400);
/// The longest datagram that is looked at.
const MAX_DATAGRAM: usize = 65_535;
/// The longest sleep, when nothing is due.
const IDLE: Duration = Duration::from_secs(3600);

/// The running thread; it ends when this is dropped.
#[derive(Debug)]
pub(crate) struct IoThread {
    io: Arc<Io>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl IoThread {
    /// Starts the thread of a device's I/O.
    pub(crate) fn spawn(device: Arc<Device>, io: Arc<Io>) -> std::io::Result<Self> {
        let ended = Arc::new(AtomicBool::new(false));
        let worker = Worker {
            device,
            io: io.clone(),
            ended: ended.clone(),
        };
        let thread = std::thread::Builder::new()
            .name("arcline-io".to_owned())
            .spawn(move || worker.run())?;
        Ok(Self {
            io,
            ended,
            thread: Some(thread),
        })
    }
}

impl Drop for IoThread {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        self.io.wake();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            error!("the thread of implicit I/O panicked");
        }
    }
}

struct Worker {
    device: Arc<Device>,
    io: Arc<Io>,
    ended: Arc<AtomicBool>,
}

impl Worker {
    fn run(&self) {
        for shortfall in prepare_beside_tick().shortfalls {
            debug!(%shortfall, "datagrams of implicit I/O may leave late");
        }
        let mut received = vec![0_u8; MAX_DATAGRAM];
        let (mut input, mut out) = (BytesMut::new(), BytesMut::new());
        let mut lateness = Lateness::new();
        while !self.ended.load(Ordering::Acquire) {
            let is_flood = self.take(&mut received);
            self.send_due(&mut input, &mut out, &mut lateness);
            if is_flood {
                std::thread::sleep(self.until_due().min(REST));
            } else {
                self.sleep();
            }
        }
    }

    /// Takes what has arrived; whether that was a whole batch.
    fn take(&self, buf: &mut [u8]) -> bool {
        for _ in 0..BATCH {
            let Ok((length, from)) = self.io.socket.recv_from(buf) else {
                // Nothing more; anything else shows again, if it lasts.
                return false;
            };
            let now = self.io.now();
            let mut connections = lock(&self.io.connections);
            let datagram = buf.get(..length).unwrap_or_default();
            if !connections.handle_datagram(datagram, from, now) {
                continue;
            }
            apply_events(&self.device, &mut connections);
        }
        true
    }

    /// Ends what is overdue, sends what is due.
    fn send_due(&self, input: &mut BytesMut, out: &mut BytesMut, lateness: &mut Lateness) {
        let mut connections = lock(&self.io.connections);
        connections.handle_timeout(self.io.now());
        apply_events(&self.device, &mut connections);
        let now = self.io.now();
        if let Some(floor) = lateness.look(now) {
            debug!(floor, "the shortest interval that is confirmed, µs");
            connections.set_min_interval(floor);
        }
        let Some(due) = connections.next_datagram().filter(|due| *due <= now) else {
            return;
        };
        lateness.sent(now - due);
        let ownership = connections.outputs();
        self.device
            .assembly_data()
            .refresh_input(&self.device.plant, ownership, input);
        loop {
            out.clear();
            let Some(to) = connections.poll_transmit(now, input, out) else {
                return;
            };
            if let SocketAddr::V4(to) = to
                && to.ip().is_multicast()
            {
                self.io.route(*to.ip());
            }
            if let Err(error) = self.io.socket.send_to(out, to) {
                debug!(%error, %to, "I/O send");
            }
        }
    }

    fn until_due(&self) -> Duration {
        let next = lock(&self.io.connections).poll_timeout();
        next.map_or(IDLE, |next| next.saturating_sub(self.io.now()))
    }

    fn sleep(&self) {
        // Too long for the system is for ever.
        let timeout = Timespec::try_from(self.until_due()).ok();
        let mut fds = [
            PollFd::new(&self.io.socket, PollFlags::IN),
            PollFd::new(&self.io.wake, PollFlags::IN),
        ];
        // A signal ends it early: what is due is looked at again.
        let _ = poll(&mut fds, timeout.as_ref());
        let woken = fds.get(1).is_some_and(|fd| !fd.revents().is_empty());
        if woken {
            let mut count = [0; 8];
            let _ = rustix::io::read(&self.io.wake, &mut count);
        }
    }
}
