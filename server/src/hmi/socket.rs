//! The socket of a viewer, in two halves: one thread reads it, another one writes it. The halves of a TLS connection share its state, which
//! each locks for as long as it encrypts or decrypts, never while it waits for the network.

use std::io::{self, Read as _, Write as _};
use std::net::TcpStream as StdTcpStream;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};

use bytes::{Buf as _, BytesMut};
use rustls::ServerConnection;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf, ReadHalf};
use tokio::net::TcpStream;
use tokio_rustls::server::TlsStream;

use crate::eip::stepped::Duplex;

/// The socket of a viewer.
pub(super) enum Socket {
    Plain(TcpStream),
    Tls(Box<TlsStream<TcpStream>>),
    /// A stream of a simulation's network.
    Stepped(Box<dyn Duplex>),
}

impl Socket {
    /// Its halves; the reading one is not on any thread yet.
    ///
    /// # Errors
    /// The system has no descriptor left.
    pub(super) fn split(self) -> io::Result<(Unread, Writing)> {
        let (socket, tls) = match self {
            Self::Plain(socket) => (socket, None),
            Self::Tls(stream) => {
                let (socket, tls) = stream.into_inner();
                (socket, Some(Shared(Arc::new(Mutex::new(tls)))))
            }
            Self::Stepped(stream) => {
                let (reading, writing) = tokio::io::split(stream);
                let unread = Unread {
                    socket: Near::Stepped(reading),
                    tls: None,
                };
                let writing = Writing {
                    socket: Box::new(writing),
                    tls: None,
                    out: BytesMut::new(),
                };
                return Ok((unread, writing));
            }
        };
        let reading = socket.into_std()?;
        let writing = TcpStream::from_std(reading.try_clone()?)?;
        let unread = Unread {
            socket: Near::System(reading),
            tls: tls.clone(),
        };
        let out = BytesMut::new();
        Ok((
            unread,
            Writing {
                socket: Box::new(writing),
                tls,
                out,
            },
        ))
    }
}

/// The state of a TLS connection after its handshake.
#[derive(Clone)]
struct Shared(Arc<Mutex<ServerConnection>>);

impl Shared {
    fn lock(&self) -> MutexGuard<'_, ServerConnection> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The half that reads, before it is on the thread that reads.
pub(super) struct Unread {
    socket: Near,
    tls: Option<Shared>,
}

/// The reading end of a connection.
enum Near {
    System(StdTcpStream),
    Stepped(ReadHalf<Box<dyn Duplex>>),
}

impl Unread {
    /// Gives it to the runtime of this thread.
    ///
    /// # Errors
    /// The runtime cannot take it.
    pub(super) fn here(self) -> io::Result<Reading> {
        Ok(Reading {
            socket: match self.socket {
                Near::System(socket) => Box::new(TcpStream::from_std(socket)?),
                Near::Stepped(stream) => Box::new(stream),
            },
            tls: self.tls,
            coming: BytesMut::new(),
        })
    }
}

/// The half that reads; writes are left out.
pub(super) struct Reading {
    socket: Box<dyn AsyncRead + Unpin + Send>,
    tls: Option<Shared>,
    /// Received bytes that are not decrypted yet.
    coming: BytesMut,
}

/// Encrypted bytes that are read at a time.
const READ: usize = 16 * 1024;

impl AsyncRead for Reading {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let this = &mut *self;
        let Some(tls) = &this.tls else {
            return Pin::new(&mut this.socket).poll_read(cx, buf);
        };
        loop {
            let mut connection = tls.lock();
            match connection.reader().read(buf.initialize_unfilled()) {
                Ok(read) => {
                    buf.advance(read);
                    return Poll::Ready(Ok(()));
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                // The peer closed the socket without a word.
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Poll::Ready(Ok(())),
                Err(error) => return Poll::Ready(Err(error)),
            }
            if this.coming.is_empty() {
                drop(connection);
                let mut room = [0; READ];
                let mut room = ReadBuf::new(&mut room);
                ready!(Pin::new(&mut this.socket).poll_read(cx, &mut room))?;
                if room.filled().is_empty() {
                    return Poll::Ready(Ok(()));
                }
                this.coming.extend_from_slice(room.filled());
                continue;
            }
            let taken = connection.read_tls(&mut this.coming.as_ref())?;
            this.coming.advance(taken);
            connection.process_new_packets().map_err(io::Error::other)?;
            if taken == 0 {
                return Poll::Ready(Err(io::Error::other("a TLS record is too long")));
            }
        }
    }
}

impl AsyncWrite for Reading {
    fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

/// The half that writes; nothing comes to it.
pub(super) struct Writing {
    socket: Box<dyn AsyncWrite + Unpin + Send>,
    tls: Option<Shared>,
    /// Encrypted bytes that are not sent yet.
    out: BytesMut,
}

impl Writing {
    /// Sends the encrypted bytes.
    fn poll_out(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        while !self.out.is_empty() {
            let sent = ready!(Pin::new(&mut self.socket).poll_write(cx, &self.out))?;
            if sent == 0 {
                return Poll::Ready(Err(io::ErrorKind::WriteZero.into()));
            }
            self.out.advance(sent);
        }
        Poll::Ready(Ok(()))
    }

    /// Takes the bytes that the TLS connection has to send: encrypted data, and its own answers to the bytes it has read.
    fn take_out(out: &mut BytesMut, connection: &mut ServerConnection) -> io::Result<()> {
        while connection.wants_write() {
            connection.write_tls(&mut Append(out))?;
        }
        Ok(())
    }
}

impl AsyncWrite for Writing {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let this = &mut *self;
        let Some(tls) = this.tls.clone() else {
            return Pin::new(&mut this.socket).poll_write(cx, bytes);
        };
        ready!(this.poll_out(cx))?;
        let mut connection = tls.lock();
        let written = connection.writer().write(bytes)?;
        Self::take_out(&mut this.out, &mut connection)?;
        Poll::Ready(Ok(written))
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let this = &mut *self;
        if let Some(tls) = &this.tls {
            Self::take_out(&mut this.out, &mut tls.lock())?;
        }
        ready!(this.poll_out(cx))?;
        Pin::new(&mut this.socket).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        if let Some(tls) = &self.tls {
            tls.lock().send_close_notify();
        }
        ready!(self.as_mut().poll_flush(cx))?;
        Pin::new(&mut self.socket).poll_shutdown(cx)
    }
}

impl AsyncRead for Writing {
    fn poll_read(self: Pin<&mut Self>, _: &mut Context<'_>, _: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Poll::Pending
    }
}

/// A writer that appends to a buffer.
struct Append<'b>(&'b mut BytesMut);

impl io::Write for Append<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
