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
/// Longer than anything here may take on a slow machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// A folder with certificates of `arcline-server certs` and a configuration, and a server that may run with it.
struct Bench {
    folder: TempDir,
    server: Option<Child>,
    eip: Option<SocketAddr>,
    tls: Option<SocketAddr>,
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
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn start(mut self, more: &str) -> Self {
        let rows: String = ["operator", "engineer"]
            .iter()
            .map(|role| {
                let shown = certs(&["show", self.file(&format!("{role}.pem")).to_str().expect("a name")]);
                let names: String = shown.lines().take(2).map(|line| format!("{line}\n")).collect();
                format!("[[security.certificates]]\n{names}role = \"{role}\"\n")
            })
            .collect();
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nhmi = \"off\"\nio = \"127.0.0.1:0\"\n[security]\ntls = \"127.0.0.1:0\"\nrevoked = \"crl.pem\"\n{more}\n{rows}\n\
             [[tag]]\nname = \"Count\"\ntype = \"DINT\"\n[[axis]]\nname = \"X\"\ntype = \"virtual\"\nmax_speed = 100\nmax_acceleration = 1000\n"
        );
        fs::write(self.file("machine.toml"), text).expect("a writable folder");
        let mut server = Command::new(SERVER)
            .arg("--config")
            .arg(self.file("machine.toml"))
            .arg("--audit")
            .arg(self.file("audit"))
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
        (self.eip, self.tls) = (address("eip="), address("tls="));
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
        if !expected {
            // Beyond five failures loopback waits a second.
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.join("\n"), bench.log());
    let log = bench.log();
    assert!(log.contains("a TLS handshake failed"), "{log}");
    assert!(!log.contains("PRIVATE KEY"), "{log}");
}

/// RSA keys, which `ring` does not make.
fn openssl_key(bench: &Bench, name: &str, bits: &str) {
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
    fs::write(
        bench.file("extensions"),
        "extendedKeyUsage=clientAuth\nsubjectAltName=DNS:client\n",
    )
    .expect("a writable folder");
    let (key, request, certificate) = (format!("{name}.key"), format!("{name}.csr"), format!("{name}.pem"));
    run(&[
        "req",
        "-newkey",
        &format!("rsa:{bits}"),
        "-nodes",
        "-keyout",
        &key,
        "-out",
        &request,
        "-subj",
        &format!("/CN={name}"),
    ]);
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
        "-sha256",
        "-extfile",
        "extensions",
        "-out",
        &certificate,
    ]);
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

/// Reloading drops no connection but those whose certificate was revoked, and these within a second.
#[tokio::test]
async fn a_reload_closes_revoked_connections_alone() {
    let bench = Bench::new().start("");
    let folder = bench.folder.path().to_str().expect("a name").to_owned();
    let mut clients = Vec::new();
    for _ in 0..10 {
        clients.push(bench.client("operator").await.expect("connected"));
    }
    let victim = bench.client("stranger").await.expect("connected");
    for round in 0..10 {
        bench.hang_up();
        for client in &clients {
            client.write("Count", round).await.expect("not dropped");
        }
    }
    certs(&["revoke", &folder, "stranger"]);
    bench.hang_up();
    let revoked = Instant::now();
    while victim.read("Count").await.is_ok() {
        assert!(revoked.elapsed() < Duration::from_secs(5), "{}", bench.log());
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let took = revoked.elapsed();
    assert!(took < Duration::from_secs(3), "closed after {took:?}");
    assert!(bench.client("stranger").await.is_err(), "no new connection");
    for client in &clients {
        client.read("Count").await.expect("the others stay");
    }
    // A file that is of no use changes nothing.
    fs::write(bench.file("ca.pem"), "rubbish").expect("a writable folder");
    bench.hang_up();
    clients[0].read("Count").await.expect("the old files hold");
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

/// What is wrong with the files is said at the start, without their content.
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
