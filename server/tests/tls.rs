//! EtherNet/IP over TLS against the real program: handshakes of OpenSSL's client, the client library, roles by certificate, reload, limits.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use arcline_client::{Client, Options, Tls, TlsFiles};
use arcline_tests::not_run::not_run;
use rcgen::{CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair, date_time_ymd};
use tempfile::TempDir;

const SERVER: &str = env!("CARGO_BIN_EXE_arcline-server");
/// Longer than any step of these tests may take on a slow machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// A folder with certificates of `arcline-server certs` and a configuration, and a server that may run with it.
struct Bench {
    folder: TempDir,
    server: Option<Child>,
    eip: Option<SocketAddr>,
    tls: Option<SocketAddr>,
    /// The TLS listener of the page.
    page: Option<SocketAddr>,
}

impl Drop for Bench {
    fn drop(&mut self) {
        if let Some(server) = &mut self.server {
            let _ = server.kill();
            let _ = server.wait();
        }
    }
}

fn certs(arguments: &[&str]) -> String {
    let output = Command::new(SERVER)
        .arg("certs")
        .args(arguments)
        .output()
        .expect("it runs");
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("text")
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path().to_str().expect("a name").to_owned();
        certs(&["init", &at]);
        for name in ["operator", "engineer", "stranger"] {
            certs(&["client", &at, name]);
        }
        // An authority without a revoked certificate has an empty list: make one by revoking another client.
        certs(&["client", &at, "old"]);
        certs(&["revoke", &at, "old"]);
        Self {
            folder,
            server: None,
            eip: None,
            tls: None,
            page: None,
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes the configuration, with a role for each of these clients.
    fn configure(&self, more: &str, roles: &[(&str, &str)]) {
        let rows: String = roles
            .iter()
            .map(|(client, role)| {
                let shown = certs(&["show", self.file(&format!("{client}.pem")).to_str().expect("a name")]);
                let names: String = shown.lines().take(2).map(|line| format!("{line}\n")).collect();
                format!("[[security.certificates]]\n{names}role = \"{role}\"\n")
            })
            .collect();
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nhmi = \"off\"\nio = \"127.0.0.1:0\"\n[security]\ntls = \"127.0.0.1:0\"\nrevoked = \"crl.pem\"\n{more}\n{rows}\n\
             [[tag]]\nname = \"Count\"\ntype = \"DINT\"\n[[axis]]\nname = \"X\"\ntype = \"virtual\"\nmax_speed = 100\nmax_acceleration = 1000\n"
        );
        fs::write(self.file("machine.toml"), text).expect("a writable folder");
    }

    fn start(mut self, more: &str) -> Self {
        self.configure(more, &[("operator", "operator"), ("engineer", "engineer")]);
        let mut server = Command::new(SERVER)
            .arg("--config")
            .arg(self.file("machine.toml"))
            .arg("--audit")
            .arg(self.file("audit"))
            .arg("--state")
            .arg(self.file("state"))
            .env("RUST_LOG", "warn")
            .stdout(Stdio::piped())
            .stderr(fs::File::create(self.file("log")).expect("a writable folder"))
            .spawn()
            .expect("it starts");
        let mut line = String::new();
        let mut out = BufReader::new(server.stdout.take().expect("piped"));
        out.read_line(&mut line).expect("it says ready");
        let address = |key: &str| {
            let of = line.split_whitespace().find_map(|word| word.strip_prefix(key));
            of.and_then(|address| address.parse().ok())
        };
        (self.eip, self.tls, self.page) = (address("eip="), address("tls="), address("hmi_tls="));
        self.server = Some(server);
        assert!(self.tls.is_some(), "{line:?} {}", self.log());
        self
    }

    fn tls(&self) -> SocketAddr {
        self.tls.expect("it listens")
    }

    fn log(&self) -> String {
        fs::read_to_string(self.file("log")).unwrap_or_default()
    }

    fn hang_up(&self) {
        let server = self.server.as_ref().expect("it runs").id();
        let done = Command::new("kill").args(["-HUP", &server.to_string()]).status();
        assert!(done.is_ok_and(|status| status.success()));
    }

    async fn client(&self, name: &str) -> Result<Client, arcline_client::ClientError> {
        let files = TlsFiles {
            ca: self.file("ca.pem"),
            certificate: self.file(&format!("{name}.pem")),
            key: self.file(&format!("{name}.key")),
            server_name: None,
        };
        let tls = Tls::new(&files)?;
        Client::connect_tls(&self.tls().to_string(), &tls, &Options::default()).await
    }

    /// A handshake of OpenSSL, then RegisterSession; whether the server answered it.
    fn openssl(&self, certificate: Option<&str>, options: &[&str]) -> (bool, String) {
        let mut command = Command::new("openssl");
        command
            .args([
                "s_client",
                "-quiet",
                "-connect",
                &self.tls().to_string(),
                "-verify_return_error",
            ])
            .arg("-CAfile")
            .arg(self.file("ca.pem"))
            .args(options);
        if let Some(name) = certificate {
            command.arg("-cert").arg(self.file(&format!("{name}.pem")));
            command.arg("-key").arg(self.file(&format!("{name}.key")));
        }
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("openssl runs");
        let mut stdin = child.stdin.take().expect("piped");
        let register = [
            0x65, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,
        ];
        let _ = stdin.write_all(&register);
        let _ = stdin.flush();
        let mut reply = [0; 28];
        let answered = child.stdout.as_mut().expect("piped").read_exact(&mut reply).is_ok();
        drop(stdin);
        let _ = child.kill();
        let Output { stderr, .. } = child.wait_with_output().expect("it ends");
        // A session that is not 0.
        let is_session = answered && reply[0] == 0x65 && reply[4..8] != [0; 4];
        (is_session, String::from_utf8_lossy(&stderr).into_owned())
    }

    /// A certificate of the authority, as the case changes it.
    fn forge(&self, name: &str, change: impl FnOnce(&mut CertificateParams)) {
        let key = KeyPair::generate().expect("a key");
        self.sign(name, &key, change);
    }

    fn sign(&self, name: &str, key: &KeyPair, change: impl FnOnce(&mut CertificateParams)) {
        let ca_key = fs::read_to_string(self.file("ca.key")).expect("a key");
        let shown = certs(&["show", self.file("ca.pem").to_str().expect("a name")]);
        let cn = shown.split('"').nth(1).expect("a name").to_owned();
        let mut authority = CertificateParams::default();
        authority.distinguished_name.remove(DnType::CommonName);
        authority.distinguished_name.push(DnType::CommonName, cn);
        authority.is_ca = IsCa::Ca(rcgen::BasicConstraints::Constrained(0));
        let issuer = Issuer::new(authority, KeyPair::from_pem(&ca_key).expect("a key"));
        let mut params = CertificateParams::default();
        params.distinguished_name.push(DnType::CommonName, name);
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ClientAuth];
        params.use_authority_key_identifier_extension = true;
        change(&mut params);
        let certificate = params.signed_by(key, &issuer).expect("signed");
        self.write(name, &certificate.pem(), &key.serialize_pem());
    }

    /// Waits until the log has a text.
    async fn logged(&self, text: &str) {
        let began = Instant::now();
        while !self.log().contains(text) {
            assert!(began.elapsed() < PATIENCE, "{text}: {}", self.log());
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    fn write(&self, name: &str, certificate: &str, key: &str) {
        fs::write(self.file(&format!("{name}.pem")), certificate).expect("a writable folder");
        fs::write(self.file(&format!("{name}.key")), key).expect("a writable folder");
    }
}

fn has_openssl() -> bool {
    let found = Command::new("openssl").arg("version").output();
    if let Err(error) = &found {
        not_run(
            "handshakes with OpenSSL",
            &format!("openssl: {error} (Debian: apt-get install openssl)"),
        );
    }
    found.is_ok()
}

/// The matrix of spec/security.md §10.
#[test]
fn handshakes() {
    if !has_openssl() {
        return;
    }
    let bench = Bench::new().start("");
    bench.forge("expired", |params| {
        (params.not_before, params.not_after) = (date_time_ymd(2020, 1, 1), date_time_ymd(2021, 1, 1));
    });
    bench.forge("early", |params| {
        (params.not_before, params.not_after) = (date_time_ymd(2090, 1, 1), date_time_ymd(2095, 1, 1));
    });
    bench.forge("server-only", |params| {
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth]
    });
    bench.forge("authority", |params| {
        params.is_ca = IsCa::Ca(rcgen::BasicConstraints::Unconstrained)
    });
    let foreign = KeyPair::generate().expect("a key");
    let self_made = CertificateParams::default().self_signed(&foreign).expect("signed");
    bench.write("foreign", &self_made.pem(), &foreign.serialize_pem());
    let wide = KeyPair::generate_for(&rcgen::PKCS_ECDSA_P384_SHA384).expect("a key");
    bench.sign("p384", &wide, |_| {});
    // A certificate with another one's key.
    let [theirs, ours] =
        ["operator.pem", "stranger.key"].map(|name| fs::read_to_string(bench.file(name)).expect("it is there"));
    bench.write("mixed", &theirs, &ours);
    for (bits, name) in [("3072", "rsa"), ("1024", "weak")] {
        openssl_key(&bench, name, bits);
    }
    #[rustfmt::skip]
    let cases: &[(&str, Option<&str>, &[&str], bool)] = &[
        ("TLS 1.3",                       Some("operator"),    &["-tls1_3"], true),
        ("TLS 1.2",                       Some("operator"),    &["-tls1_2"], true),
        ("RSA of 3072 bits, TLS 1.3",     Some("rsa"),         &["-tls1_3"], true),
        ("RSA of 3072 bits, TLS 1.2",     Some("rsa"),         &["-tls1_2"], true),
        ("AES-256 of TLS 1.2",            Some("operator"),    &["-tls1_2", "-cipher", "ECDHE-ECDSA-AES256-GCM-SHA384"], true),
        ("ChaCha20 of TLS 1.3",           Some("operator"),    &["-ciphersuites", "TLS_CHACHA20_POLY1305_SHA256"], true),
        ("no certificate, TLS 1.3",       None,                &["-tls1_3"], false),
        ("no certificate, TLS 1.2",       None,                &["-tls1_2"], false),
        ("a foreign authority",           Some("foreign"),     &[], false),
        ("expired",                       Some("expired"),     &[], false),
        ("not yet valid",                 Some("early"),       &[], false),
        ("revoked",                       Some("old"),         &[], false),
        ("revoked, TLS 1.2",              Some("old"),         &["-tls1_2"], false),
        ("for servers only",              Some("server-only"), &[], false),
        ("an authority as a client",      Some("authority"),   &[], false),
        ("another's key",                 Some("mixed"),       &[], false),
        ("RSA of 1024 bits",              Some("weak"),        &["-tls1_2"], false),
        ("CBC only",                      Some("operator"),    &["-tls1_2", "-cipher", "ECDHE-ECDSA-AES128-SHA256:@SECLEVEL=0"], false),
        ("key exchange by RSA only",      Some("operator"),    &["-tls1_2", "-cipher", "AES128-GCM-SHA256:@SECLEVEL=0"], false),
        ("PSK only",                      Some("operator"),    &["-tls1_2", "-cipher", "PSK-AES128-GCM-SHA256:@SECLEVEL=0", "-psk", "00112233"], false),
        ("TLS 1.1",                       Some("operator"),    &["-tls1_1", "-cipher", "ALL:@SECLEVEL=0"], false),
        ("P-256 alone",                   Some("operator"),    &["-curves", "P-256"], true),
        ("P-384 alone",                   Some("operator"),    &["-curves", "P-384"], true),
        ("X25519 alone",                  Some("operator"),    &["-curves", "X25519"], true),
        ("P-521 alone",                   Some("operator"),    &["-curves", "P-521"], false),
        ("a key of P-384, TLS 1.3",       Some("p384"),        &["-tls1_3"], true),
        ("a key of P-384, TLS 1.2",       Some("p384"),        &["-tls1_2"], true),
        ("the server has another name",   Some("operator"),    &["-verify_hostname", "other.example"], false),
        ("the server by its address",     Some("operator"),    &["-verify_ip", "127.0.0.1"], true),
        ("the server by its name",        Some("operator"),    &["-verify_hostname", "localhost"], true),
    ];
    let mut wrong = Vec::new();
    for (why, certificate, options, expected) in cases {
        let (is_session, said) = bench.openssl(*certificate, options);
        if is_session != *expected {
            wrong.push(format!("{why}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.join("\n"), bench.log());
    let log = bench.log();
    assert!(log.contains("a TLS handshake failed"), "{log}");
    assert!(!log.contains("PRIVATE KEY"), "{log}");
}

/// RSA keys, which `ring` does not make.
fn openssl_key(bench: &Bench, name: &str, bits: &str) {
    let extensions = "extendedKeyUsage=clientAuth\nsubjectAltName=DNS:client\n";
    openssl_certificate(bench, name, &["rsa:".to_owned() + bits], "-sha256", extensions);
}

/// A key and a certificate of the authority, made by OpenSSL.
fn openssl_certificate(bench: &Bench, name: &str, key_kind: &[String], hash: &str, extensions: &str) {
    let run = |arguments: &[&str]| {
        let done = Command::new("openssl")
            .args(arguments)
            .current_dir(bench.folder.path())
            .output()
            .expect("it runs");
        assert!(
            done.status.success(),
            "{arguments:?}: {}",
            String::from_utf8_lossy(&done.stderr)
        );
    };
    fs::write(bench.file("extensions"), extensions).expect("a writable folder");
    let (key, request, certificate) = (format!("{name}.key"), format!("{name}.csr"), format!("{name}.pem"));
    let subject = format!("/CN={name}");
    let mut ask = vec!["req", "-newkey"];
    ask.extend(key_kind.iter().map(String::as_str));
    ask.extend(["-nodes", "-keyout", &key, "-out", &request, "-subj", &subject]);
    run(&ask);
    run(&[
        "x509",
        "-req",
        "-in",
        &request,
        "-CA",
        "ca.pem",
        "-CAkey",
        "ca.key",
        "-set_serial",
        "77",
        "-days",
        "10",
        hash,
        "-extfile",
        "extensions",
        "-out",
        &certificate,
    ]);
}

/// The client library, which does not judge its own certificate: the server refuses one that is signed with SHA-1, and takes the same with SHA-256.
#[tokio::test]
async fn a_certificate_that_is_signed_with_sha_1_is_refused() {
    if !has_openssl() {
        return;
    }
    let bench = Bench::new().start("");
    let extensions = "extendedKeyUsage=clientAuth\nsubjectAltName=DNS:client\n";
    let kind = ["ec", "-pkeyopt", "ec_paramgen_curve:P-256"].map(str::to_owned);
    for (hash, is_taken) in [("-sha256", true), ("-sha384", true), ("-sha1", false)] {
        openssl_certificate(&bench, "hashed", &kind, hash, extensions);
        let client = bench.client("hashed").await;
        assert_eq!(client.is_ok(), is_taken, "{hash}: {:?} {}", client.err(), bench.log());
    }
}

/// The suites of spec/security.md §3 by their names in OpenSSL: TLS 1.3; TLS 1.2 with a certificate of ECDSA, and of RSA.
const SUITES: [&[&str]; 3] = [
    &[
        "TLS_AES_256_GCM_SHA384",
        "TLS_AES_128_GCM_SHA256",
        "TLS_CHACHA20_POLY1305_SHA256",
    ],
    &[
        "ECDHE-ECDSA-AES256-GCM-SHA384",
        "ECDHE-ECDSA-AES128-GCM-SHA256",
        "ECDHE-ECDSA-CHACHA20-POLY1305",
    ],
    &[
        "ECDHE-RSA-AES256-GCM-SHA384",
        "ECDHE-RSA-AES128-GCM-SHA256",
        "ECDHE-RSA-CHACHA20-POLY1305",
    ],
];

/// Of all suites of OpenSSL, the server takes the nine of the list and no other.
#[test]
fn the_suites_that_are_taken_are_those_of_the_list() {
    if !has_openssl() {
        return;
    }
    let ciphers = |options: &[&str]| {
        let output = Command::new("openssl").arg("ciphers").args(options).output();
        let text = String::from_utf8(output.expect("it runs").stdout).expect("text");
        text.trim().split(':').map(str::to_owned).collect::<Vec<_>>()
    };
    let tls13 = ["TLS_AES_128_CCM_SHA256", "TLS_AES_128_CCM_8_SHA256"].map(str::to_owned);
    let tls13: Vec<String> = SUITES[0].iter().map(|suite| (*suite).to_owned()).chain(tls13).collect();
    let tls12 = ciphers(&["-s", "-tls1_2", "ALL:COMPLEMENTOFALL:@SECLEVEL=0"]);
    assert!(tls12.len() > 40, "{tls12:?}");
    let taken = |bench: &Bench, version: &str, option: &str, of: &[String], more: &str| {
        let is_taken = |suite: &&String| {
            let suite = format!("{suite}{more}");
            bench.openssl(Some("operator"), &[version, option, &suite]).0
        };
        let mut taken: Vec<String> = of.iter().filter(is_taken).cloned().collect();
        taken.sort_unstable();
        taken
    };
    let listed = |suites: &[&str]| {
        let mut suites: Vec<String> = suites.iter().map(|suite| (*suite).to_owned()).collect();
        suites.sort_unstable();
        suites
    };
    let bench = Bench::new().start("");
    assert_eq!(taken(&bench, "-tls1_3", "-ciphersuites", &tls13, ""), listed(SUITES[0]));
    assert_eq!(
        taken(&bench, "-tls1_2", "-cipher", &tls12, ":@SECLEVEL=0"),
        listed(SUITES[1])
    );
    let bench = Bench::new();
    let extensions = "extendedKeyUsage=serverAuth\nsubjectAltName=DNS:localhost,IP:127.0.0.1\n";
    openssl_certificate(&bench, "server", &["rsa:3072".to_owned()], "-sha256", extensions);
    let bench = bench.start("");
    assert_eq!(
        taken(&bench, "-tls1_2", "-cipher", &tls12, ":@SECLEVEL=0"),
        listed(SUITES[2])
    );
}

/// The TLS listener of the page: browsers show no certificate.
#[test]
fn handshakes_with_the_page() {
    if !has_openssl() {
        return;
    }
    let bench = Bench::new().start("hmi_tls = \"127.0.0.1:0\"");
    let page = bench.page.expect("it listens").to_string();
    #[rustfmt::skip]
    let cases: &[(&str, &[&str], bool)] = &[
        ("TLS 1.3",                     &["-tls1_3"], true),
        ("TLS 1.2",                     &["-tls1_2"], true),
        ("HTTP/1.1 by ALPN",            &["-alpn", "http/1.1"], true),
        ("HTTP/2 alone by ALPN",        &["-alpn", "h2"], false),
        ("the server by its name",      &["-verify_hostname", "localhost"], true),
        ("another name",                &["-verify_hostname", "other.example"], false),
        ("CBC only",                    &["-tls1_2", "-cipher", "ECDHE-ECDSA-AES128-SHA256:@SECLEVEL=0"], false),
        ("key exchange by RSA only",    &["-tls1_2", "-cipher", "AES128-GCM-SHA256:@SECLEVEL=0"], false),
        ("TLS 1.1",                     &["-tls1_1", "-cipher", "ALL:@SECLEVEL=0"], false),
    ];
    for (why, options, expected) in cases {
        let mut child = Command::new("openssl")
            .args([
                "s_client",
                "-quiet",
                "-connect",
                &page,
                "-verify_return_error",
                "-CAfile",
            ])
            .arg(bench.file("ca.pem"))
            .args(*options)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("openssl runs");
        let mut stdin = child.stdin.take().expect("piped");
        let _ = stdin.write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
        // The end of standard input would end it; the server closes.
        let output = child.wait_with_output().expect("it ends");
        drop(stdin);
        let answer = String::from_utf8_lossy(&output.stdout);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(answer.starts_with("HTTP/1.1 200"), *expected, "{why}: {answer} {said}");
    }
}

/// A byte of a record that changes on the way ends the connection: the request in it is not served.
#[tokio::test]
async fn a_record_that_is_changed_on_the_way_ends_the_connection() {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    let bench = Bench::new().start("");
    let between = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let at = between.local_addr().expect("bound");
    let server = bench.tls();
    let flips = Arc::new(AtomicBool::new(false));
    let flipping = flips.clone();
    // The last byte is the end of the tag that authenticates the record.
    let relay = std::thread::spawn(move || {
        let (mut near, _) = between.accept().expect("a client");
        let mut far = TcpStream::connect(server).expect("it accepts");
        let (mut back_from, mut back_to) = (far.try_clone().expect("a socket"), near.try_clone().expect("a socket"));
        let back = std::thread::spawn(move || std::io::copy(&mut back_from, &mut back_to));
        let mut buf = [0; 4096];
        while let Ok(length @ 1..) = near.read(&mut buf) {
            if flipping.load(Ordering::SeqCst) {
                buf[length - 1] ^= 1;
            }
            if far.write_all(&buf[..length]).is_err() {
                break;
            }
        }
        // The thread ends when the server has closed.
        back.join().expect("no panic")
    });
    let files = TlsFiles {
        ca: bench.file("ca.pem"),
        certificate: bench.file("operator.pem"),
        key: bench.file("operator.key"),
        server_name: None,
    };
    let tls = Tls::new(&files).expect("good files");
    let client = Client::connect_tls(&at.to_string(), &tls, &Options::default())
        .await
        .expect("connected");
    client.write("Count", 1_i32).await.expect("an operator");
    flips.store(true, Ordering::SeqCst);
    client
        .write("Count", 2_i32)
        .await
        .expect_err("the record is not authentic");
    drop(client);
    relay.join().expect("no panic").expect("the server has closed");
    let other = bench.client("operator").await.expect("others come in");
    let count = other.read("Count").await.expect("a tag");
    let first = arcline_client::TagValue::Value(arcline_client::Value::Dint(1));
    assert_eq!(count, first, "it was not written");
}

/// The client library and roles: a row, no row; plain EtherNet/IP beside.
#[tokio::test]
async fn certificates_have_roles() {
    let bench = Bench::new().start("default_role = \"viewer\"\nloopback = \"viewer\"\n");
    for (name, may_write, may_create) in [
        ("stranger", false, false),
        ("operator", true, false),
        ("engineer", true, true),
    ] {
        let client = bench.client(name).await.expect("connected");
        client.read("Count").await.expect("everybody reads");
        let written = client.write("Count", 5_i32).await;
        assert_eq!(written.is_ok(), may_write, "{name}: {written:?}");
        let created = client
            .create_tag("Fresh", "DINT", arcline_client::Access::ReadWrite)
            .await;
        assert_eq!(created.is_ok(), may_create, "{name}: {created:?}");
        client.inhibit_motion().await.expect("STOP is everybody's");
        client.close().await;
    }
    let plain = Client::connect(&bench.eip.expect("it listens").to_string())
        .await
        .expect("plain is on");
    plain.read("Count").await.expect("it looks");
    assert!(plain.write("Count", 6_i32).await.is_err(), "a viewer");
    let log = bench.log();
    assert!(
        log.contains("needs operator to write tags") && log.contains("cn:stranger"),
        "{log}"
    );
    drop(plain);
    // The audit has all of it, in a chain that holds.
    let server = bench.server.as_ref().expect("it runs").id();
    let done = Command::new("kill").args(["-TERM", &server.to_string()]).status();
    assert!(done.is_ok_and(|status| status.success()));
    let began = Instant::now();
    let lines = loop {
        let text = fs::read_to_string(bench.file("audit").join("000001.jsonl")).unwrap_or_default();
        if text.contains("\"what\":\"stop\"") {
            break text;
        }
        assert!(began.elapsed() < PATIENCE, "{text}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    };
    let verified = Command::new(SERVER)
        .args(["audit", "verify"])
        .arg(bench.file("audit"))
        .output()
        .expect("it runs");
    assert!(
        verified.status.success(),
        "{}",
        String::from_utf8_lossy(&verified.stderr)
    );
    for (who, what) in [
        ("cn:stranger", "\"what\":\"denied\""),
        (
            "cn:operator",
            "\"what\":\"write\",\"object\":\"Count\",\"old\":\"00000000\",\"new\":\"05000000\"",
        ),
        ("cn:operator", "\"role\":\"operator\""),
        ("cn:engineer", "\"object\":\"create Fresh\""),
        ("cn:engineer", "\"what\":\"disconnect\""),
        ("", "\"what\":\"estop\""),
        ("\"door\":\"enip\"", "\"what\":\"denied\""),
    ] {
        assert!(
            lines.lines().any(|line| line.contains(who) && line.contains(what)),
            "{who} {what}: {lines}"
        );
    }
    // A line that was changed is named, with exit code 3.
    fs::write(
        bench.file("audit").join("000001.jsonl"),
        lines.replace("05000000", "06000000"),
    )
    .expect("a writable folder");
    let verified = Command::new(SERVER)
        .args(["audit", "verify"])
        .arg(bench.file("audit"))
        .output()
        .expect("it runs");
    assert_eq!(verified.status.code(), Some(3));
}

/// Plain EtherNet/IP that is off, or only discovery.
#[tokio::test]
async fn plain_ethernet_ip_can_be_switched_off() {
    let off = Bench::new().start("plain = \"off\"");
    assert!(TcpStream::connect(off.eip.expect("UDP has it")).is_err(), "not bound");
    off.client("operator").await.expect("TLS is on");
    let discovery = Bench::new().start("plain = \"discovery\"");
    let mut stream = TcpStream::connect(discovery.eip.expect("it listens")).expect("it accepts");
    stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
    let mut ask = |command: u8, data: &[u8]| {
        let mut frame = vec![0; 24];
        (frame[0], frame[2]) = (command, data.len() as u8);
        frame.extend_from_slice(data);
        stream.write_all(&frame).expect("it reads");
        let mut head = [0; 24];
        stream.read_exact(&mut head).expect("it answers");
        let mut rest = vec![0; usize::from(u16::from_le_bytes([head[2], head[3]]))];
        stream.read_exact(&mut rest).expect("it answers");
        (u32::from_le_bytes(head[8..12].try_into().expect("four")), rest.len())
    };
    assert_eq!(ask(0x65, &[1, 0, 0, 0]), (0x6A, 0), "RegisterSession");
    assert_eq!(ask(0x6F, &[0; 16]), (0x6A, 0), "SendRRData");
    let (status, length) = ask(0x63, &[]);
    assert!(status == 0 && length > 40, "ListIdentity");
    assert_eq!(ask(0x04, &[]).0, 0, "ListServices");
}

/// Reloading drops no connection but those whose certificate was revoked, and these within a second. `ARCLINE_LONG=1` makes it the 100 connections and
/// 50 reloads of the specification.
#[tokio::test]
async fn a_reload_closes_revoked_connections_alone() {
    let (connections, rounds) = match std::env::var_os("ARCLINE_LONG") {
        Some(_) => (100, 50),
        None => (10, 10),
    };
    let bench = Bench::new().start("");
    let folder = bench.folder.path().to_str().expect("a name").to_owned();
    let mut clients = Vec::new();
    for _ in 0..connections {
        clients.push(bench.client("operator").await.expect("connected"));
    }
    let victim = bench.client("stranger").await.expect("connected");
    for round in 0..rounds {
        bench.hang_up();
        for client in &clients {
            client.write("Count", round).await.expect("not dropped");
        }
    }
    certs(&["revoke", &folder, "stranger"]);
    // When the server has read the files, and when the connection ends: from outside of the process.
    let reloads = || bench.log().matches("the certificates of TLS were read again").count();
    let before = reloads();
    bench.hang_up();
    let began = Instant::now();
    while reloads() == before {
        assert!(began.elapsed() < PATIENCE, "{}", bench.log());
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    let read = Instant::now();
    while victim.read("Count").await.is_ok() {
        assert!(read.elapsed() < PATIENCE, "{}", bench.log());
    }
    let took = read.elapsed();
    assert!(
        took < Duration::from_secs(1),
        "closed {took:?} after the files were read"
    );
    assert!(bench.client("stranger").await.is_err(), "no new connection");
    for client in &clients {
        client.read("Count").await.expect("the others stay");
    }
    // A file that is of no use changes nothing.
    fs::write(bench.file("ca.pem"), "rubbish").expect("a writable folder");
    bench.hang_up();
    clients[0].read("Count").await.expect("the old files hold");
}

/// Rows and `default_role` of the configuration hold for open connections when it is read again; so does another authority.
#[tokio::test]
async fn a_reload_takes_roles_and_authorities_over() {
    let bench = Bench::new().start("");
    let client = bench.client("operator").await.expect("connected");
    let stranger = bench.client("stranger").await.expect("connected");
    client.write("Count", 1_i32).await.expect("an operator");
    stranger.write("Count", 2_i32).await.expect_err("a viewer, by default");
    bench.configure("default_role = \"operator\"", &[("operator", "viewer")]);
    bench.hang_up();
    bench.logged("the certificates of TLS were read again").await;
    // The new rows decide on the request behind the reload; the log reports the reload before that.
    let began = Instant::now();
    while client.write("Count", 1_i32).await.is_ok() {
        assert!(began.elapsed() < Duration::from_secs(1), "{}", bench.log());
    }
    let refused = client.write("Count", 3_i32).await.expect_err("demoted");
    assert!(refused.to_string().contains("0x0F"), "{refused}");
    client.read("Count").await.expect("its connection stays");
    stranger.write("Count", 2_i32).await.expect("promoted");
    let lines = fs::read_to_string(bench.file("audit").join("000001.jsonl")).expect("it is there");
    assert!(lines.contains("the roles of certificates"), "{lines}");
    // The change that needs a restart is refused, and the rows take effect all the same.
    let text = fs::read_to_string(bench.file("machine.toml")).expect("it is there");
    let text = text
        .replace("role = \"viewer\"", "role = \"engineer\"")
        .replace("max_speed = 100", "max_speed = 200");
    fs::write(bench.file("machine.toml"), text).expect("a writable folder");
    bench.hang_up();
    bench.logged("Reload refused: axis X changed").await;
    client.write("Count", 4_i32).await.expect("promoted");
    // Another authority signs the clients from now on.
    let other = tempfile::tempdir().expect("a folder");
    certs(&["init", other.path().to_str().expect("a name")]);
    fs::copy(other.path().join("ca.pem"), bench.file("ca.pem")).expect("a writable folder");
    bench.hang_up();
    let began = Instant::now();
    while client.read("Count").await.is_ok() {
        assert!(began.elapsed() < PATIENCE, "{}", bench.log());
    }
    stranger
        .read("Count")
        .await
        .expect_err("its authority is no authority any more");
}

/// A certificate holds until its last second, and a connection by it no longer; without a clock it holds.
#[tokio::test]
async fn a_connection_ends_with_its_certificate() {
    let clocked = Bench::new().start("");
    let clockless = Bench::new().start("check_expiration = false");
    let ends = time::OffsetDateTime::now_utc() + Duration::from_secs(6);
    let mut clients = Vec::new();
    for bench in [&clocked, &clockless] {
        bench.forge("brief", |params| {
            params.not_before = date_time_ymd(2020, 1, 1);
            params.not_after = ends;
        });
        clients.push(bench.client("brief").await.expect("it holds yet"));
    }
    let stays = clocked.client("operator").await.expect("connected");
    while clients[0].read("Count").await.is_ok() {
        assert!(time::OffsetDateTime::now_utc() < ends + PATIENCE, "{}", clocked.log());
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert!(time::OffsetDateTime::now_utc() >= ends, "not before");
    assert!(
        clocked.log().contains("its certificate does not hold any more"),
        "{}",
        clocked.log()
    );
    assert!(clocked.client("brief").await.is_err(), "nor does it open another one");
    stays.read("Count").await.expect("it is valid for longer");
    // The other server checked its certificates in the same second.
    clients[1].read("Count").await.expect("it does not look at the clock");
    clockless.client("brief").await.expect("nor for new connections");
    clockless.forge("early", |params| {
        (params.not_before, params.not_after) = (date_time_ymd(2090, 1, 1), date_time_ymd(2095, 1, 1));
    });
    clockless.client("early").await.expect("nor at the beginning");
    let foreign = KeyPair::generate().expect("a key");
    let self_made = CertificateParams::default().self_signed(&foreign).expect("signed");
    clockless.write("foreign", &self_made.pem(), &foreign.serialize_pem());
    assert!(clockless.client("foreign").await.is_err(), "all else is judged");
    assert!(clockless.client("old").await.is_err(), "revoked");
}

/// The status of a Forward Open of class 1 for the exclusive owner of a machine with one axis, over TLS.
async fn forward_open(bench: &Bench) -> u8 {
    use arcline_proto::cip::{Reply, Request, service};
    use arcline_proto::connection::{ConnectionKey, ForwardOpen, NetworkParameters, TickTime};
    use arcline_proto::cpf::{ConnectionId, Packet};
    use arcline_proto::encap::{self, FrameDecoder, RegisterSession, SessionHandle};
    use arcline_proto::epath::{Epath, Segment};
    use rustls::pki_types::pem::PemObject as _;
    use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

    let pem = |name: &str| CertificateDer::from_pem_file(bench.file(name)).expect("a certificate");
    let mut roots = rustls::RootCertStore::empty();
    roots.add(pem("ca.pem")).expect("an authority");
    let key = PrivateKeyDer::from_pem_file(bench.file("operator.key")).expect("a key");
    let config = rustls::ClientConfig::builder_with_provider(rustls::crypto::ring::default_provider().into())
        .with_safe_default_protocol_versions()
        .expect("versions")
        .with_root_certificates(roots)
        .with_client_auth_cert(vec![pem("operator.pem")], key)
        .expect("a pair");
    let name = ServerName::try_from("localhost").expect("a name");
    let socket = tokio::net::TcpStream::connect(bench.tls()).await.expect("it accepts");
    let connector = tokio_rustls::TlsConnector::from(std::sync::Arc::new(config));
    let mut stream = connector.connect(name, socket).await.expect("a handshake");
    let mut buf = bytes::BytesMut::new();
    let mut session = SessionHandle(0);
    let parameters = |size| NetworkParameters {
        variable: false,
        priority: 2,
        ..NetworkParameters::explicit(size)
    };
    let open = ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(1),
        key: ConnectionKey {
            serial: 1,
            vendor: 0x1337,
            originator: 42,
        },
        multiplier: 2,
        o_to_t_rpi: 5000,
        o_to_t: parameters(4 + 6),
        t_to_o_rpi: 5000,
        t_to_o: parameters(12 + 20 + 2),
        transport: 1,
        path: Epath(vec![
            Segment::Class(4),
            Segment::Instance(151),
            Segment::ConnectionPoint(150),
            Segment::ConnectionPoint(100),
        ]),
    };
    let data = open.to_bytes(false).expect("a short path");
    let request = Request::new(service::FORWARD_OPEN, Epath::object(6, 1), data);
    let packet = Packet::unconnected(request.to_bytes().expect("short"));
    for (command, data) in [
        (encap::Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes()),
        (encap::Command::SEND_RR_DATA, packet.to_bytes()),
    ] {
        let frame = encap::EncapFrame::request(command, session, [0; 8], data);
        stream.write_all(&frame.to_bytes()).await.expect("it reads");
        let frame = loop {
            if let Some(frame) = FrameDecoder::new(encap::MAX_DATA).decode(&mut buf).expect("a frame") {
                break frame;
            }
            assert!(stream.read_buf(&mut buf).await.expect("it answers") > 0, "it closed");
        };
        session = frame.header.session;
        if command == encap::Command::SEND_RR_DATA {
            let packet = Packet::decode(&frame.data).expect("a packet");
            let reply = Reply::decode(packet.unconnected_message().expect("a message")).expect("a reply");
            return reply.status.general();
        }
    }
    unreachable!("the second frame returns")
}

/// Implicit I/O would travel in the clear beside a connection over TLS.
#[tokio::test]
async fn a_forward_open_of_class_1_through_tls_is_refused_unless_the_plant_allows_it() {
    let refuses = Bench::new().start("");
    assert_eq!(forward_open(&refuses).await, 0x0F);
    refuses.logged("class 0 and 1 through TLS need DTLS").await;
    let allows = Bench::new().start("io_over_tls = \"plain\"");
    assert_eq!(forward_open(&allows).await, 0, "{}", allows.log());
}

/// Bytes that are no TLS, silence, and a flood of handshakes that go no further: a client with a certificate gets in meanwhile.
#[tokio::test]
async fn strangers_keep_no_client_out() {
    let bench = Bench::new().start("");
    let mut plain = TcpStream::connect(bench.tls()).expect("it accepts");
    let _ = plain.write_all(&[
        0x65, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,
    ]);
    plain.set_read_timeout(Some(PATIENCE)).expect("a socket");
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(
        answer.first().is_none_or(|kind| *kind == 0x15),
        "an alert at most, never EtherNet/IP: {answer:?}"
    );
    // Eight handshakes of one address at a time: silent ones end after five seconds.
    let silent: Vec<TcpStream> = (0..200).filter_map(|_| TcpStream::connect(bench.tls()).ok()).collect();
    let began = Instant::now();
    let client = loop {
        match bench.client("operator").await {
            Ok(client) => break client,
            Err(error) => assert!(began.elapsed() < PATIENCE, "{error}"),
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    };
    let took = began.elapsed();
    assert!(
        took < Duration::from_secs(15),
        "the place of a silent one after {took:?}"
    );
    client.read("Count").await.expect("it is served");
    for stream in &silent {
        let _ = stream.shutdown(Shutdown::Both);
    }
}

/// Keys and the state are the owner's alone, also while a server runs that has written the state.
#[tokio::test]
async fn keys_are_readable_by_their_owner_only() {
    use std::os::unix::fs::PermissionsExt as _;
    let bench = Bench::new().start("");
    let client = bench.client("operator").await.expect("connected");
    client.write("Count", 7_i32).await.expect("it is kept");
    for name in ["ca.key", "server.key", "operator.key", "state"] {
        let mode = fs::metadata(bench.file(name))
            .expect("it is there")
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o600, "{name}: {mode:o}");
    }
    let audit = fs::metadata(bench.file("audit").join("000001.jsonl")).expect("it is there");
    assert_eq!(audit.permissions().mode() & 0o777 & !0o640, 0, "the audit");
}

/// The error of the files is reported at the start, without their content.
#[test]
fn files_that_are_of_no_use_are_refused_at_the_start() {
    let bench = Bench::new();
    let open = |file: &Path, mode: u32| {
        use std::os::unix::fs::PermissionsExt as _;
        fs::set_permissions(file, fs::Permissions::from_mode(mode)).expect("our file");
    };
    let text = "[server]\nlisten = \"127.0.0.1:0\"\nhmi = \"off\"\nio = \"off\"\n[security]\ntls = \"127.0.0.1:0\"\n";
    fs::write(bench.file("machine.toml"), text).expect("a writable folder");
    let start = || {
        let output = Command::new(SERVER)
            .arg("--config")
            .arg(bench.file("machine.toml"))
            .output()
            .expect("it runs");
        assert_eq!(output.status.code(), Some(2), "it does not start");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    open(&bench.file("server.key"), 0o644);
    assert!(start().contains("readable by other users"));
    open(&bench.file("server.key"), 0o600);
    let key = fs::read_to_string(bench.file("server.key")).expect("it is there");
    fs::copy(bench.file("operator.key"), bench.file("server.key")).expect("a copy");
    let said = start();
    assert!(said.contains("the certificates cannot be used"), "{said}");
    fs::write(
        bench.file("server.key"),
        "-----BEGIN PRIVATE KEY-----\nQUJD\n-----END PRIVATE KEY-----\n",
    )
    .expect("writable");
    let said = start();
    assert!(!said.contains("QUJD"), "{said}");
    fs::write(bench.file("server.key"), key).expect("writable");
    fs::remove_file(bench.file("ca.pem")).expect("it is there");
    assert!(start().contains("ca.pem"));
}
