//! The network between the clients and the server: streams whose bytes arrive at a drawn time, in pieces, late, or never.
//!
//! Time is that of the scenario, ms. The model has the properties of TCP that the programs at its ends observe, not packets: bytes arrive in order or
//! the connection is reset.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

use arcline_tests::random::Random;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use crate::record::lock;

/// The network of a scenario. Clones are the same one.
#[derive(Clone, Default)]
pub(crate) struct Network {
    now: Arc<AtomicU64>,
    links: Arc<Mutex<Vec<Arc<Mutex<Link>>>>>,
}

/// The delays and sizes of a connection.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Weather {
    /// The longest delay of a piece, ms.
    pub(crate) delay: u64,
    /// Bytes that arrive at once, at most; 0: all.
    pub(crate) piece: usize,
}

/// Both directions of a connection.
struct Link {
    /// The ways from the client to the server, and back.
    ways: [Way; 2],
    weather: Weather,
    random: Random,
    /// The time before which no bytes arrive.
    held_until: u64,
    /// The connection has failed for each end; the time at which each notices.
    reset_at: [Option<u64>; 2],
    /// The ends that are still in use.
    open: [bool; 2],
}

#[derive(Default)]
struct Way {
    /// Bytes under way, with the time of their arrival.
    flying: VecDeque<(u64, Vec<u8>)>,
    arrived: VecDeque<u8>,
    /// When the end of the stream arrives.
    end_at: Option<u64>,
    ended: bool,
    /// Whether sent bytes never arrive.
    swallows: bool,
    /// The receiver's window is closed.
    stalled: bool,
    reader: Option<Waker>,
    writer: Option<Waker>,
    last: u64,
}

/// One end of a connection.
pub(crate) struct End {
    link: Arc<Mutex<Link>>,
    now: Arc<AtomicU64>,
    /// 0: the client's, 1: the server's.
    side: usize,
    /// Dropped, it says nothing.
    silent: bool,
}

impl Network {
    /// Connects a client to the server: the client's end and the server's.
    pub(crate) fn connect(&self, weather: Weather, random: Random) -> (End, End) {
        let link = Arc::new(Mutex::new(Link {
            ways: Default::default(),
            weather,
            random,
            held_until: 0,
            reset_at: [None; 2],
            open: [true; 2],
        }));
        lock(&self.links).push(link.clone());
        let end = |side| End {
            link: link.clone(),
            now: self.now.clone(),
            side,
            silent: false,
        };
        (end(0), end(1))
    }

    /// Begins a millisecond: the due bytes arrive.
    pub(crate) fn begin(&self, now: u64) {
        self.now.store(now, Ordering::Relaxed);
        let mut wake = Vec::new();
        lock(&self.links).retain(|link| {
            let mut link = lock(link);
            link.begin(now, &mut wake);
            link.open[0] || link.open[1]
        });
        for waker in wake {
            waker.wake();
        }
    }

    /// Holds all bytes until a time.
    pub(crate) fn hold(&self, until: u64) {
        self.each(|link| link.held_until = until);
    }

    /// Cuts every connection; both ends notice it.
    pub(crate) fn reset(&self) {
        let now = self.now.load(Ordering::Relaxed);
        self.each(|link| link.reset_at = [Some(now + 1); 2]);
    }

    /// The server is gone without a reset: its ends send nothing from now on, and clients notice it later.
    pub(crate) fn lose_server(&self, noticed_at: u64) {
        self.each(|link| {
            link.ways[1].swallows = true;
            link.ways[1].flying.clear();
            link.reset_at[0] = link.reset_at[0].or(Some(noticed_at));
        });
    }

    fn each(&self, mut change: impl FnMut(&mut Link)) {
        for link in lock(&self.links).iter() {
            change(&mut lock(link));
        }
    }
}

impl Link {
    fn begin(&mut self, now: u64, wake: &mut Vec<Waker>) {
        let held = now < self.held_until;
        for (side, way) in self.ways.iter_mut().enumerate() {
            let mut woken = false;
            while !held && way.flying.front().is_some_and(|(due, _)| *due <= now) {
                if let Some((_, bytes)) = way.flying.pop_front() {
                    way.arrived.extend(bytes);
                    woken = true;
                }
            }
            if !held && !way.ended && way.flying.is_empty() && way.end_at.is_some_and(|due| due <= now) {
                way.ended = true;
                woken = true;
            }
            let reader = 1 - side;
            if self.reset_at[reader].is_some_and(|at| at <= now) || self.reset_at[side].is_some_and(|at| at <= now) {
                wake.extend(way.reader.take());
                wake.extend(way.writer.take());
            }
            if woken {
                wake.extend(way.reader.take());
            }
        }
    }

    fn is_reset(&self, side: usize, now: u64) -> bool {
        self.reset_at[side].is_some_and(|at| at <= now)
    }
}

impl End {
    /// From now on no byte of this end arrives, and none reaches it; the other end notices that at a time.
    pub(crate) fn vanish(mut self, noticed_at: u64) {
        self.silent = true;
        let mut link = lock(&self.link);
        let side = self.side;
        link.ways[side].swallows = true;
        link.ways[side].flying.clear();
        link.ways[1 - side].swallows = true;
        link.reset_at[1 - side] = Some(noticed_at);
    }

    /// Cuts the connection: the other end notices it at once.
    pub(crate) fn cut(mut self) {
        self.silent = true;
        let now = self.now.load(Ordering::Relaxed);
        lock(&self.link).reset_at[1 - self.side] = Some(now + 1);
    }

    /// The bytes of this end no longer arrive; it still receives.
    pub(crate) fn mute(&self, noticed_at: u64) {
        let mut link = lock(&self.link);
        link.ways[self.side].swallows = true;
        link.reset_at[1 - self.side] = Some(noticed_at);
        link.reset_at[self.side] = Some(noticed_at);
    }

    /// When everything that this end has sent has arrived, ms.
    pub(crate) fn arrives_by(&self) -> u64 {
        let link = lock(&self.link);
        link.ways[self.side].last.max(link.held_until)
    }

    /// Stops or begins to read: the window of this end.
    pub(crate) fn stall(&self, stalled: Window) {
        let mut link = lock(&self.link);
        let way = &mut link.ways[1 - self.side];
        way.stalled = stalled == Window::Closed;
        let waker = way.writer.take();
        drop(link);
        if let Some(waker) = waker {
            waker.wake();
        }
    }
}

/// The receive window of an end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Window {
    /// Bytes that come are taken.
    Open,
    /// The sender waits.
    Closed,
}

impl Drop for End {
    fn drop(&mut self) {
        let now = self.now.load(Ordering::Relaxed);
        let mut link = lock(&self.link);
        link.open[self.side] = false;
        if self.silent {
            return;
        }
        let way = &mut link.ways[self.side];
        if !way.swallows {
            way.end_at = Some(way.last.max(now + 1));
        }
    }
}

impl AsyncRead for End {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let now = self.now.load(Ordering::Relaxed);
        let mut link = lock(&self.link);
        if link.is_reset(self.side, now) {
            return Poll::Ready(Err(io::ErrorKind::ConnectionReset.into()));
        }
        let piece = link.weather.piece;
        let way = &mut link.ways[1 - self.side];
        if way.arrived.is_empty() {
            if way.ended {
                return Poll::Ready(Ok(()));
            }
            way.reader = Some(cx.waker().clone());
            return Poll::Pending;
        }
        let most = if piece == 0 { usize::MAX } else { piece };
        let count = way.arrived.len().min(buf.remaining()).min(most);
        for byte in way.arrived.drain(..count) {
            buf.put_slice(&[byte]);
        }
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for End {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let now = self.now.load(Ordering::Relaxed);
        let mut link = lock(&self.link);
        if link.is_reset(self.side, now) {
            return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
        }
        let other_open = link.open[1 - self.side];
        let delay = link.weather.delay;
        let late = if delay == 0 { 0 } else { link.random.below(delay + 1) };
        let way = &mut link.ways[self.side];
        if way.swallows {
            return Poll::Ready(Ok(bytes.len()));
        }
        if !other_open {
            return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
        }
        if way.stalled {
            way.writer = Some(cx.waker().clone());
            return Poll::Pending;
        }
        // The bytes arrive with the next millisecond at the earliest.
        let due = way.last.max(now + 1 + late);
        way.last = due;
        way.flying.push_back((due, bytes.to_vec()));
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        let now = self.now.load(Ordering::Relaxed);
        let mut link = lock(&self.link);
        let way = &mut link.ways[self.side];
        way.end_at = Some(way.last.max(now + 1));
        Poll::Ready(Ok(()))
    }
}
