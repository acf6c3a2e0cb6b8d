//! The web HMI: a page that the server carries with it, and one WebSocket for each viewer.
//!
//! Everything here lives on tokio beside the rest of the server. It reads the plant as any client does, and what it sends
//! goes through bounded queues: a slow viewer loses frames or its connection, and nothing here is ever waited for by the
//! tick. Not here: what an instruction means (the catalogue), motion (the controller), the page itself (`web/`).

mod access;
mod assets;
mod drive;
mod events;
mod frames;
mod instructions;
mod jog;
mod line;
mod machine;
mod paths;
mod peaks;
mod preview;
mod program;
mod protocol;
mod serve;
mod status;
mod tags;
#[cfg(test)]
mod tests;
mod viewer;
mod workers;

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use axum::extract::ws::Utf8Bytes;
use tokio::net::TcpListener;
use tokio::sync::{broadcast, watch};

use crate::limits::{Full, Places};
use crate::plant::Plant;
use assets::Assets;
use jog::Jogs;
use preview::Previews;
use program::Programs;
use protocol::text_of;
use status::Status;
use workers::Workers;

/// The bound HMI.
#[derive(Debug)]
pub struct Hmi {
    listener: TcpListener,
    shared: Arc<Shared>,
}

/// What all viewers share: the plant, and each subject with its own state.
#[derive(Debug)]
struct Shared {
    plant: Plant,
    assets: Assets,
    /// Where it listens.
    listen: SocketAddr,
    /// `/api/machine` and `/api/instructions`, which do not change.
    machine: String,
    instructions: String,
    /// One for each viewer that may still come.
    places: Arc<Places>,
    /// Viewers so far.
    viewers: AtomicU64,
    status: watch::Sender<Status>,
    /// Frames of samples.
    frames: broadcast::Sender<bytes::Bytes>,
    jogs: Jogs,
    /// How often STOP was pressed.
    stops: AtomicU64,
    workers: Workers,
    program: Arc<Programs>,
    previews: Previews,
    /// Changes of instructions.
    events: broadcast::Sender<Utf8Bytes>,
}

impl Hmi {
    /// Binds `address`; port 0 picks a free one.
    ///
    /// # Errors
    /// The address cannot be bound.
    pub async fn bind(address: SocketAddr, plant: Plant) -> io::Result<Self> {
        let listener = TcpListener::bind(address).await?;
        let shared = Shared {
            assets: Assets::from_environment(),
            listen: listener.local_addr()?,
            machine: text_of(&machine::description(&plant)),
            instructions: text_of(&instructions::catalogue()),
            places: Places::new(VIEWERS, Full::ClosesOldestOfLargerShare),
            viewers: AtomicU64::new(0),
            status: watch::Sender::new(Status::default()),
            frames: broadcast::Sender::new(frames::WAITING),
            jogs: Jogs::default(),
            stops: AtomicU64::new(0),
            workers: Workers::default(),
            program: Arc::default(),
            previews: Previews::default(),
            events: broadcast::Sender::new(events::WAITING),
            plant,
        };
        Ok(Self {
            listener,
            shared: Arc::new(shared),
        })
    }

    /// The address that was really bound.
    pub fn local_addr(&self) -> SocketAddr {
        self.shared.listen
    }

    /// Serves until the future is dropped; that closes every viewer.
    pub async fn serve(self) {
        let statuses = status::produce(self.shared.clone());
        let samples = frames::produce(self.shared.clone());
        let rights = jog::watch(self.shared.clone());
        let events = events::produce(self.shared.clone());
        let connections = serve::accept(self.listener, self.shared);
        tokio::join!(rights, statuses, samples, events, connections);
    }
}

/// Viewers at a time.
const VIEWERS: usize = 32;
