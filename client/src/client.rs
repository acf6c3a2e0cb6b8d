//! The connection as a user sees it. The requests are in the modules by subject: tags, reading, writing, motion.

use std::net::SocketAddrV4;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;

use arcline_proto::cip::{CipStatus, Reply, Request};
use arcline_proto::epath::Epath;
use arcline_proto::identity::Identity;

use crate::ClientError;
use crate::link::Link;
use crate::tags::TagTable;
use crate::tls::{TLS_PORT, Tls};

/// The port of EtherNet/IP.
pub const DEFAULT_PORT: u16 = 44818;

/// Settings of a connection.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Options {
    /// The time-out of the connect, and of every answer.
    pub timeout: Duration,
    /// Bytes of the requested class 3 connection, with its sequence count; 64 to 65,535.
    pub connection_size: u16,
}

impl Default for Options {
    /// 5 s and 4000 bytes.
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(5),
            connection_size: 4000,
        }
    }
}

/// A connection to a server. Methods take `&self`; requests of several tasks go one after the other.
///
/// Dropping it closes the connection; [`Client::close`] waits until the server has confirmed.
#[derive(Debug)]
pub struct Client {
    link: Link,
    /// The known tags; replaced as a whole.
    pub(crate) table: Mutex<Arc<TagTable>>,
}

impl Client {
    /// Connects to `HOST` or `HOST:PORT` with the default settings: registers a session and opens a class 3 connection,
    /// a large one if the server has it, else a small one, else unconnected messages.
    ///
    /// # Errors
    /// [`ClientError::Connect`], or an error of the connection.
    ///
    /// ```no_run
    /// # async fn example() -> Result<(), arcline_client::ClientError> {
    /// let client = arcline_client::Client::connect("192.168.1.10").await?;
    /// let (address, identity) = client.identify().await?;
    /// println!("{} at {address}", identity.name());
    /// client.close().await;
    /// # Ok(())
    /// # }
    /// ```
    pub async fn connect(address: &str) -> Result<Self, ClientError> {
        Self::connect_with(address, &Options::default()).await
    }

    /// Connects with settings.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub async fn connect_with(address: &str, options: &Options) -> Result<Self, ClientError> {
        let stream = connect_tcp(&with_port(address, DEFAULT_PORT), options).await?;
        Self::over(stream, options).await
    }

    /// Connects over TLS; the port is 2221 by default. A server that refuses this client's certificate may say so only when the session is
    /// registered.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub async fn connect_tls(address: &str, tls: &Tls, options: &Options) -> Result<Self, ClientError> {
        let full = with_port(address, TLS_PORT);
        let stream = connect_tcp(&full, options).await?;
        let shaken = tokio::time::timeout(options.timeout, tls.connect(stream, &full)).await;
        let stream = shaken.unwrap_or_else(|late| Err(late.into()));
        let stream = stream.map_err(|source| ClientError::Connect { address: full, source })?;
        Self::over(stream, options).await
    }

    /// Connects over a stream that is there already: a tunnel, or a pair in memory.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn over<S>(stream: S, options: &Options) -> Result<Self, ClientError>
    where
        S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        let link = Link::open(stream, options.connection_size.max(64), options.timeout).await?;
        Ok(Self {
            link,
            table: Mutex::default(),
        })
    }

    /// The identity of the server, and the address at which it says it listens.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn identify(&self) -> Result<(SocketAddrV4, Identity), ClientError> {
        self.link.identify().await
    }

    /// Sends a CIP request of any kind.
    ///
    /// # Errors
    /// The errors of the connection; a status other than success is no error here.
    pub async fn request(&self, request: Request) -> Result<Reply, ClientError> {
        self.link.request(request).await
    }

    /// Closes the connection and the session.
    pub async fn close(self) {
        self.link.close().await;
    }

    /// Sends a request; every status but success and partial transfer is an error about `what`.
    pub(crate) async fn ask(
        &self,
        what: &str,
        service: u8,
        path: Epath,
        data: impl Into<Bytes>,
    ) -> Result<Reply, ClientError> {
        let reply = self.link.request(Request::new(service, path, data)).await?;
        if reply.status.is_success() || reply.status.is(CipStatus::PARTIAL_TRANSFER) {
            Ok(reply)
        } else {
            Err(ClientError::refused(what, reply.status))
        }
    }

    /// Bytes of the longest request or reply.
    pub(crate) fn budget(&self) -> usize {
        self.link.budget()
    }

    pub(crate) fn table(&self) -> Arc<TagTable> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn set_table(&self, table: TagTable) -> Arc<TagTable> {
        let table = Arc::new(table);
        *self.table.lock().unwrap_or_else(PoisonError::into_inner) = table.clone();
        table
    }
}

async fn connect_tcp(full: &str, options: &Options) -> Result<TcpStream, ClientError> {
    let refused = |source| ClientError::Connect {
        address: full.to_owned(),
        source,
    };
    let connecting = tokio::time::timeout(options.timeout, TcpStream::connect(full)).await;
    let stream = connecting.unwrap_or_else(|late| Err(late.into())).map_err(refused)?;
    stream.set_nodelay(true).map_err(refused)?;
    Ok(stream)
}

/// Appends the default port where there is none.
fn with_port(address: &str, port: u16) -> String {
    let has_port = address
        .rsplit_once(':')
        .is_some_and(|(host, _)| !host.contains(':') || host.ends_with(']'));
    if has_port {
        address.to_owned()
    } else if address.contains(':') && !address.starts_with('[') {
        format!("[{address}]:{port}")
    } else {
        format!("{address}:{port}")
    }
}

#[cfg(test)]
mod tests {
    use super::with_port;

    #[test]
    fn addresses_get_the_default_port() {
        for (given, full) in [
            ("localhost", "localhost:44818"),
            ("127.0.0.1:4000", "127.0.0.1:4000"),
            ("::1", "[::1]:44818"),
            ("[::1]", "[::1]:44818"),
            ("[::1]:7", "[::1]:7"),
            // Connecting refuses it: "invalid port value".
            ("localhost:70000", "localhost:70000"),
        ] {
            assert_eq!(with_port(given, super::DEFAULT_PORT), full, "{given}");
        }
    }
}
