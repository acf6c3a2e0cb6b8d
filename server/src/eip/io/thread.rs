//! The thread of implicit I/O: it sleeps until a datagram comes or one is due.
//!
//! Its priority is below that of the tick and, where the system allows that, above all other threads, so it bounds its own work: a flood of
//! datagrams makes it pause. It waits only for the short locks of the connections and of the plant.

use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use arcline_realtime::prepare_beside_tick;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use tracing::{debug, error};

use super::Io;
use super::turn::{Arrived, IoTurns};
use crate::eip::device::Device;

/// Pause after a whole batch of datagrams, unless a connection is due. Datagrams that come faster are a flood, not I/O, and are lost.
const REST: Duration = Duration::from_micros(400);

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
        let mut turns = IoTurns::new(self.device.clone(), self.io.clone());
        while !self.ended.load(Ordering::Acquire) {
            match turns.turn() {
                Arrived::Batch => std::thread::sleep(turns.until_due().min(REST)),
                Arrived::All => self.sleep(turns.until_due()),
            }
        }
    }

    fn sleep(&self, until_due: Duration) {
        // Too long for the system is for ever.
        let timeout = Timespec::try_from(until_due).ok();
        let socket = self.io.socket.descriptor().unwrap_or(self.io.wake.as_fd());
        let mut fds = [
            PollFd::from_borrowed_fd(socket, PollFlags::IN),
            PollFd::new(&self.io.wake, PollFlags::IN),
        ];
        // A signal ends the wait early: the next turn checks the due times again.
        let _ = poll(&mut fds, timeout.as_ref());
        let woken = fds.get(1).is_some_and(|fd| !fd.revents().is_empty());
        if woken {
            let mut count = [0; 8];
            let _ = rustix::io::read(&self.io.wake, &mut count);
        }
    }
}
