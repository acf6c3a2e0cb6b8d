//! The page on a network of the caller: browsers connect through a channel, and the page serves them as usual. Work that the page gives to
//! other threads runs here in order, on the runtime of the caller.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;

use tokio::sync::{Mutex, mpsc};

use super::serve::{Acceptor, Browser};
use super::{Hmi, ListenSettings, Listener, Shared};
use crate::plant::Plant;
use crate::work_threads::WorkThreads;

/// The page on such a network.
#[derive(Debug)]
pub(crate) struct SteppedPage {
    shared: Arc<Shared>,
    incoming: mpsc::UnboundedSender<Browser>,
}

impl SteppedPage {
    /// Serves browsers on the runtime of the caller.
    pub(crate) fn start(plant: Plant) -> Self {
        let (incoming, browsers) = mpsc::unbounded_channel();
        let listener = Listener {
            acceptor: Acceptor::Stepped(Mutex::new(browsers)),
            listen: LISTEN,
            tls: None,
        };
        let hmi = Hmi::of(vec![listener], ListenSettings::default(), plant, WorkThreads::Caller);
        let shared = hmi.shared.clone();
        tokio::spawn(hmi.serve());
        SteppedPage { shared, incoming }
    }

    /// A browser comes in.
    pub(crate) fn connect(&self, browser: Browser) {
        // The task that takes it lives as long as the runtime.
        let _ = self.incoming.send(browser);
    }

    /// Connections of browsers that are served, those of viewers among them.
    pub(crate) fn browsers(&self) -> usize {
        self.shared.connections.taken() + self.shared.places.taken()
    }
}

/// The page's address in that network.
const LISTEN: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::new(10, 0, 0, 1)), 8080);
