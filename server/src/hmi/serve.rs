//! HTTP: the page's files, two descriptions as JSON, and the way to the WebSocket. Every answer carries the headers that
//! keep foreign pages out.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use arcline_config::Role;
use arcline_proto::arcline::machine::Identification;
use axum::Router;
use axum::body::Body;
use axum::extract::{Extension, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use bytes::Bytes;
use hyper::server::conn::http1;
use hyper::upgrade::Upgraded;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Mutex, mpsc};
use tokio::task::JoinSet;
use tokio_rustls::server::TlsStream;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;
use tracing::debug;

use super::login::{self, session_of};
use super::socket::Socket;
use super::viewer::{self, Page};
use super::{Listener, Shared, access};
use crate::eip::stepped::Duplex;
use crate::limits::Place;
use crate::metrics;
use crate::plant::roles::{is_local, role_of_address, role_of_page};
use crate::tls::Tls;

/// The longest time for the head of a request, and the longest idle time of a connection.
const HEAD_WITHIN: Duration = Duration::from_secs(15);
/// Wait after a connection could not be accepted.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Longest message of a viewer, bytes.
pub(super) const LONGEST_MESSAGE: usize = 256 * 1024;

/// Scripts, styles and connections of this server only; nothing inline, nothing embedded anywhere.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Sent with every answer.
#[rustfmt::skip]
const HEADERS: [(HeaderName, &str); 7] = [
    (header::CONTENT_SECURITY_POLICY,                                POLICY),
    (header::X_CONTENT_TYPE_OPTIONS,                                 "nosniff"),
    (header::X_FRAME_OPTIONS,                                        "DENY"),
    (header::REFERRER_POLICY,                                        "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"),          "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"),        "same-origin"),
    // Revalidated: after an update the page is the new one.
    (header::CACHE_CONTROL,                                          "no-cache"),
];

/// The source of the browsers' connections.
#[derive(Debug)]
pub(super) enum Acceptor {
    /// A socket of the system.
    System(TcpListener),
    /// The network of a simulation (`stepped`).
    Stepped(Mutex<mpsc::UnboundedReceiver<Browser>>),
}

/// A browser of a simulation: its stream and its address.
pub(super) type Browser = (Box<dyn Duplex>, SocketAddr);

/// The connection of a browser.
enum Stream {
    System(TcpStream),
    Stepped(Box<dyn Duplex>),
}

impl Acceptor {
    async fn accept(&self) -> std::io::Result<(Stream, SocketAddr)> {
        match self {
            Self::System(listener) => {
                let (stream, peer) = listener.accept().await?;
                // A frame of samples is not to wait for the next one.
                let _ = stream.set_nodelay(true);
                Ok((Stream::System(stream), peer))
            }
            Self::Stepped(browsers) => match browsers.lock().await.recv().await {
                Some((stream, peer)) => Ok((Stream::Stepped(stream), peer)),
                None => std::future::pending().await,
            },
        }
    }
}

/// Accepts connections until the future is dropped; that closes them.
pub(super) async fn accept(listener: Listener, shared: Arc<Shared>) {
    let router = router(shared.clone());
    let mut connections = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            biased;
            // The memory of a connection that has ended is free at once, not when the next browser comes.
            Some(_) = connections.join_next() => continue,
            accepted = listener.acceptor.accept() => accepted,
        };
        match accepted {
            Ok((_, peer)) if !shared.plant.server().security.hmi_allow.allows(peer.ip()) => {
                shared.plant.log_limit().warn("allow", Some(peer.ip()), || {
                    format!("a browser was closed: {} is in no network of hmi_allow", peer.ip())
                });
            }
            Ok((stream, peer)) => match shared.connections.enter(peer.ip()) {
                Some(place) => {
                    let near = Near {
                        peer: peer.ip(),
                        listen: listener.listen,
                        is_tls: listener.tls.is_some(),
                    };
                    connections.spawn(serve_one(
                        stream,
                        near,
                        listener.tls.clone(),
                        router.clone(),
                        place,
                        shared.clone(),
                    ));
                }
                None => debug!("too many connections to the HMI: closed"),
            },
            Err(error) => {
                let text = || format!("cannot accept a connection to the page: {error}");
                shared.plant.log_limit().warn("accept", None, text);
                tokio::time::sleep(ACCEPT_PAUSE).await;
            }
        }
    }
}

async fn serve_one(
    stream: Stream,
    near: Near,
    tls: Option<Arc<Tls>>,
    router: Router,
    place: Place,
    shared: Arc<Shared>,
) {
    let close = place.close();
    let peer = near.peer;
    let router = router.layer(Extension(near));
    let served = async {
        match (stream, tls) {
            (Stream::Stepped(stream), _) => serve_http(stream, router).await,
            (Stream::System(stream), None) => serve_http(stream, router).await,
            (Stream::System(stream), Some(tls)) => match tls.accept_page(stream, peer).await {
                Ok(stream) => serve_http(stream, router).await,
                Err(failed) => tls.log_failed(shared.plant.log_limit(), peer, &failed),
            },
        }
    };
    if close.run_until_cancelled(served).await.is_none() {
        debug!("too many connections to the HMI: a newcomer got the place of this one");
    }
    drop(place);
}

async fn serve_http<S>(stream: S, router: Router)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_WITHIN)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
        .with_upgrades();
    if let Err(error) = served.await {
        debug!(%error, "connection to the HMI");
    }
}

/// The two ends of a connection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    peer: IpAddr,
    /// The address on which the server listens.
    listen: SocketAddr,
    pub(super) is_tls: bool,
}

impl Near {
    /// The far end.
    pub(super) fn peer(&self) -> IpAddr {
        self.peer
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/api/machine", get(machine))
        .route("/api/instructions", get(instructions))
        .route("/metrics", get(measurements))
        .route("/login", post(login::log_in))
        .route("/logout", post(login::log_out))
        .route("/lock", post(login::lock))
        .route("/ws", get(socket))
        .fallback(get(file))
        .layer(middleware::from_fn_with_state(shared.clone(), guard))
        .with_state(shared)
}

/// Refuses hosts that are not this server, and puts the headers on every answer.
async fn guard(
    State(shared): State<Arc<Shared>>,
    Extension(near): Extension<Near>,
    request: Request,
    next: Next,
) -> Response {
    if is_ambiguous(request.headers()) {
        let refused = (
            StatusCode::BAD_REQUEST,
            [(header::CONNECTION, "close")],
            "One Host, and no Transfer-Encoding.\n",
        );
        return with_headers(refused.into_response());
    }
    let names = shared.names();
    let ours = host(request.headers()).is_some_and(|host| access::is_host(host, near.listen, &names));
    let is_proxied = request.headers().contains_key("x-forwarded-for");
    if is_proxied && is_local(near.peer) && shared.plant.server().security.loopback > Role::Viewer {
        let text = || {
            "a proxy on this computer passes on requests of others (X-Forwarded-For): all of them have the role `loopback`".to_owned()
        };
        shared.plant.log_limit().warn("forwarded", Some(near.peer), text);
    }
    let is_private = request.method() == Method::POST;
    let mut response = if ours {
        next.run(request).await
    } else {
        (
            StatusCode::MISDIRECTED_REQUEST,
            "Use the address that the server listens on, or localhost.\n",
        )
            .into_response()
    };
    response = with_headers(response);
    if is_private {
        let value = HeaderValue::from_static("no-store");
        response.headers_mut().insert(header::CACHE_CONTROL, value);
    }
    response
}

/// Whether two servers may read a request as two different ones: it has several hosts, or a chunked body, which no page sends
/// (RFC 9112, 11.2).
fn is_ambiguous(headers: &HeaderMap) -> bool {
    headers.get_all(header::HOST).iter().nth(1).is_some() || headers.contains_key(header::TRANSFER_ENCODING)
}

fn with_headers(mut response: Response) -> Response {
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

fn host(headers: &HeaderMap) -> Option<&str> {
    headers.get(header::HOST)?.to_str().ok()
}

async fn machine(State(shared): State<Arc<Shared>>) -> Response {
    json(shared.machine.clone())
}

async fn instructions(State(shared): State<Arc<Shared>>) -> Response {
    json(shared.instructions.clone())
}

async fn measurements(State(shared): State<Arc<Shared>>) -> Response {
    let text = metrics::metrics(&shared.plant);
    ([(header::CONTENT_TYPE, metrics::CONTENT_TYPE)], text).into_response()
}

fn json(text: String) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

async fn file(State(shared): State<Arc<Shared>>, uri: Uri) -> Response {
    match shared.assets.file(uri.path()) {
        Some((kind, content)) => ([(header::CONTENT_TYPE, kind)], Body::from(content.into_owned())).into_response(),
        None => (StatusCode::NOT_FOUND, "There is no such file.\n").into_response(),
    }
}

/// Becomes a viewer, if a page of this server or a script with a token asks for it and there is a place.
async fn socket(State(shared): State<Arc<Shared>>, Extension(near): Extension<Near>, mut request: Request) -> Response {
    let headers = request.headers();
    let origin = headers.get(header::ORIGIN).and_then(|origin| origin.to_str().ok());
    let own = matches!((origin, host(headers)), (Some(origin), Some(host)) if access::is_origin(origin, host));
    let token = login::bearer(headers);
    if !own && (token.is_none() || origin.is_some()) {
        debug!(?origin, "a foreign page asked for the HMI's WebSocket: refused");
        return (StatusCode::FORBIDDEN, "Only pages of this server may connect.\n").into_response();
    }
    let peer = near.peer();
    let session = session_of(&shared, &near, headers).and_then(|key| shared.sessions.find(key));
    if token.is_some() && session.is_none() {
        let text = || "a script with a token that does not hold was refused".to_owned();
        shared.plant.log_limit().warn("token", Some(peer), text);
        return (StatusCode::UNAUTHORIZED, "The token does not hold.\n").into_response();
    }
    let Some(accepted) = accept_key(headers) else {
        return (StatusCode::BAD_REQUEST, "Here is a WebSocket of version 13.\n").into_response();
    };
    let identification = browser(headers);
    let Some(place) = shared.places.enter(peer) else {
        let text = || "a viewer was refused, since all places of the page are taken".to_owned();
        shared.plant.log_limit().warn("full", Some(peer), text);
        return (StatusCode::SERVICE_UNAVAILABLE, "Too many viewers.\n").into_response();
    };
    let security = &shared.plant.server().security;
    let page = Page {
        peer,
        identification,
        role: match near.is_tls {
            true => role_of_page(security, peer),
            false => role_of_address(security, peer),
        },
        session,
        can_log_in: login::is_private(&near) && shared.sessions.has_users(),
        close: place.close(),
    };
    let upgrade = hyper::upgrade::on(&mut request);
    tokio::spawn(async move {
        match upgrade.await.map(|upgraded| upgraded_socket(upgraded, near.is_tls)) {
            Ok(Some((socket, begun))) => {
                if let Err(error) = viewer::serve(socket, begun, shared, page).await {
                    debug!(%error, "a viewer could not be served");
                }
            }
            Ok(None) => debug!("a viewer came on what is no socket"),
            Err(error) => debug!(%error, "a viewer went before it came"),
        }
        drop(place);
    });
    let headers = [
        (header::CONNECTION, HeaderValue::from_static("upgrade")),
        (header::UPGRADE, HeaderValue::from_static("websocket")),
        (header::SEC_WEBSOCKET_ACCEPT, accepted),
    ];
    (StatusCode::SWITCHING_PROTOCOLS, headers).into_response()
}

/// The socket of a connection that became a WebSocket, and the bytes that it has already received.
fn upgraded_socket(upgraded: Upgraded, is_tls: bool) -> Option<(Socket, Bytes)> {
    if is_tls {
        let parts = upgraded.downcast::<TokioIo<TlsStream<TcpStream>>>().ok()?;
        return Some((Socket::Tls(Box::new(parts.io.into_inner())), parts.read_buf));
    }
    match upgraded.downcast::<TokioIo<TcpStream>>() {
        Ok(parts) => Some((Socket::Plain(parts.io.into_inner()), parts.read_buf)),
        Err(upgraded) => {
            let parts = upgraded.downcast::<TokioIo<Box<dyn Duplex>>>().ok()?;
            Some((Socket::Stepped(parts.io.into_inner()), parts.read_buf))
        }
    }
}

/// The browser of a page as the product of its client.
fn browser(headers: &HeaderMap) -> Identification {
    let agent = headers.get(header::USER_AGENT).and_then(|agent| agent.to_str().ok());
    let identification = Identification {
        product: product_of(agent.unwrap_or_default()),
        ..Identification::default()
    };
    identification.bounded()
}

/// The name and the first number of the version of a browser, such as `Firefox 128`, or else of the first product of its `User-Agent`.
fn product_of(agent: &str) -> String {
    let product = |name: &&str| agent.split_whitespace().find(|product| product.starts_with(*name));
    let known = BROWSERS.iter().find_map(product);
    let product = known.or_else(|| agent.split_whitespace().next()).unwrap_or_default();
    match product.split_once('/') {
        Some((name, version)) => format!("{name} {}", version.split('.').next().unwrap_or_default()),
        None => product.to_owned(),
    }
}

/// Browsers by their product in `User-Agent`; the engines that several have in common come last.
const BROWSERS: [&str; 6] = ["Firefox/", "Edg/", "OPR/", "HeadlessChrome/", "Chrome/", "Safari/"];

/// The accept key of a request for a WebSocket (RFC 6455, 4.2); `None`: the request is not one, or asks for another version.
fn accept_key(headers: &HeaderMap) -> Option<HeaderValue> {
    let text = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    let has = |name, word: &str| {
        text(name).is_some_and(|list| list.split(',').any(|one| one.trim().eq_ignore_ascii_case(word)))
    };
    let asked = has(header::CONNECTION, "upgrade") && has(header::UPGRADE, "websocket");
    if !asked || text(header::SEC_WEBSOCKET_VERSION) != Some("13") {
        return None;
    }
    let key = headers.get(header::SEC_WEBSOCKET_KEY)?;
    HeaderValue::from_str(&derive_accept_key(key.as_bytes())).ok()
}

#[cfg(test)]
mod tests {
    use super::product_of;

    #[test]
    fn browsers_are_named() {
        #[rustfmt::skip]
        let cases = [
            ("Mozilla/5.0 (X11; Linux x86_64; rv:128.0) Gecko/20100101 Firefox/128.0", "Firefox 128"),
            ("Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/126.0.0.0 Safari/537.36", "Chrome 126"),
            ("Mozilla/5.0 (Windows NT 10.0) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/126.0.0.0 Safari/537.36 Edg/126.0.0.0", "Edg 126"),
            ("curl/8.5.0", "curl 8"),
            ("a page", "a"),
            ("", ""),
        ];
        for (agent, expected) in cases {
            assert_eq!(product_of(agent), expected, "{agent}");
        }
    }
}
