//! A page with users, a token and HTTPS.

use std::fs;
use std::net::Ipv4Addr;
use std::os::unix::fs::PermissionsExt as _;

use arcline_config::Role;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, RootCertStore};
use tempfile::TempDir;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_rustls::TlsConnector;

use super::super::{ListenSettings, Sessions};
use super::*;
use crate::tls::Tls;
use crate::users::{Token, User, Users, password};

pub(super) const ANNA: &str = "annas long password";
pub(super) const BERT: &str = "berts long password";
pub(super) const TOKEN: &str = "arc_abcdefghijklmnopqrstuvwxyz0123456789ABCDEFG";

/// A page with users, where a client on this computer is a viewer until it logs in.
pub(super) struct Secured {
    pub(super) bench: Bench,
    tls: SocketAddr,
    pub(super) folder: TempDir,
    certificate: CertificateDer<'static>,
    pub(super) sessions: Arc<Sessions>,
}

fn users() -> Users {
    let user = |name: &str, role, secret| User {
        name: name.to_owned(),
        role,
        password: password::hash(secret).expect("it is hashed"),
        is_disabled: false,
        logouts: 0,
    };
    Users {
        users: vec![
            user("anna", Role::Operator, ANNA),
            user("bert", Role::Administrator, BERT),
        ],
        tokens: vec![Token {
            name: "logger".to_owned(),
            role: Role::Operator,
            sha256: crate::audit::sha256(TOKEN),
            until: i64::MAX,
        }],
    }
}

impl Secured {
    pub(super) async fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        let made = rcgen::generate_simple_self_signed(["localhost".to_owned(), "cell-4.example".to_owned()]);
        let made = made.expect("a certificate");
        fs::write(at.join("server.pem"), made.cert.pem()).expect("a writable folder");
        fs::write(at.join("server.key"), made.signing_key.serialize_pem()).expect("a writable folder");
        fs::set_permissions(at.join("server.key"), fs::Permissions::from_mode(0o600)).expect("it is ours");
        users().write(&at.join("users.toml")).expect("a writable folder");
        let text = format!(
            "[security]\nhmi_tls = \"127.0.0.1:0\"\nusers = \"users.toml\"\nloopback = \"viewer\"\nhmi_names = [\"arm\"]\n{}",
            arcline_config::DEFAULT
        );
        let project = arcline_config::load(&text, "machine.toml").expect("it is valid");
        let security = &project.server.security;
        let (plant, tick) = Plant::start(&project).expect("a thread");
        let sessions = Arc::new(Sessions::open(security, at).expect("it is valid"));
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let settings = ListenSettings {
            plain: Some(any),
            tls: Some((any, Tls::new(security, at).expect("the files are good"))),
            sessions: Some(sessions.clone()),
        };
        let hmi = Hmi::bind_all(settings, plant.clone()).await.expect("free ports");
        Self {
            tls: hmi.tls_addr().expect("it listens"),
            bench: Bench {
                address: hmi.local_addr().expect("it listens"),
                plant,
                simulations: hmi.shared.previews.turns(),
                serving: tokio::spawn(hmi.serve()),
                _tick: tick,
            },
            folder,
            certificate: made.cert.der().clone(),
            sessions,
        }
    }

    /// The head and the body of the answer to a POST.
    pub(super) async fn post(&self, path: &str, headers: &str, body: &str) -> String {
        let stream = TcpStream::connect(self.bench.address).await.expect("it accepts");
        post(stream, path, headers, body).await
    }

    /// A request without a body, of a page that has the cookie of a session.
    pub(super) async fn post_with(&self, path: &str, cookie: &str) -> String {
        let headers = format!("Cookie: {cookie}\r\nOrigin: http://localhost\r\n");
        self.post(path, &headers, "").await
    }

    /// The cookie of a session.
    pub(super) async fn log_in(&self, user: &str, password: &str) -> Result<String, String> {
        let body = json!({"user": user, "password": password}).to_string();
        let answer = self.post("/login", "", &body).await;
        let cookie = answer.lines().find_map(|line| line.strip_prefix("set-cookie: "));
        let value = cookie.and_then(|cookie| cookie.split(';').next());
        value.map(str::to_owned).ok_or(answer)
    }

    pub(super) async fn viewer(&self, headers: &[(&str, &str)]) -> Viewer {
        Viewer::of(self.connect(headers).await.expect("a place")).await
    }

    pub(super) async fn connect(&self, headers: &[(&str, &str)]) -> Result<Socket, Error> {
        self.bench.connect_with(headers).await
    }

    /// A page that has logged in.
    pub(super) async fn page(&self, cookie: &str) -> Viewer {
        let origin = format!("http://{}", self.bench.address);
        self.viewer(&[("origin", &origin), ("cookie", cookie)]).await
    }

    pub(super) async fn encrypted(&self, name: &str) -> impl AsyncRead + AsyncWrite + Unpin + Send + 'static {
        let mut roots = RootCertStore::empty();
        roots.add(self.certificate.clone()).expect("a certificate");
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let config = ClientConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .expect("TLS")
            .with_root_certificates(roots)
            .with_no_client_auth();
        let socket = TcpStream::connect(self.tls).await.expect("it accepts");
        let name = ServerName::try_from(name.to_owned()).expect("a name");
        let connected = TlsConnector::from(Arc::new(config)).connect(name, socket).await;
        connected.expect("a handshake")
    }

    pub(super) fn change(&self, change: impl FnOnce(&mut Users)) {
        let file = self.folder.path().join("users.toml");
        let mut users = Users::read(&file).expect("it is valid");
        change(&mut users);
        users.write(&file).expect("a writable folder");
    }
}

pub(super) async fn post(
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
    path: &str,
    headers: &str,
    body: &str,
) -> String {
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {}\r\n{headers}\r\n{body}",
        body.len()
    );
    stream.write_all(request.as_bytes()).await.expect("it reads");
    let mut answer = Vec::new();
    // A peer may close TLS without a word.
    let _ = timeout(SOON, stream.read_to_end(&mut answer)).await.expect("in time");
    String::from_utf8_lossy(&answer).into_owned()
}
