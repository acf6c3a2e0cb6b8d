//! Certificates that change while connections come in.

use std::fs;

use arcline_config::Role;

use super::certs::CertsCommand;
use super::*;
use crate::audit::Audit;
use crate::metrics::metrics;

/// A folder with an authority, a server and a client, and the side of TLS of that server.
fn bench() -> (tempfile::TempDir, Arc<Tls>) {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path().to_owned();
    for command in [
        CertsCommand::Init {
            folder: at.clone(),
            host: Vec::new(),
        },
        client(&at, "other", false),
        CertsCommand::Revoke {
            folder: at.clone(),
            name: "other".to_owned(),
        },
        client(&at, "hmi", false),
    ] {
        certs::run(&command).unwrap_or_else(|error| panic!("{command:?}: {error}"));
    }
    let security = Security {
        tls: Some(([127, 0, 0, 1], 0).into()),
        revoked: Some("crl.pem".to_owned()),
        default_role: Role::Operator,
        ..Security::default()
    };
    let tls = Tls::new(&security, &at).expect("the files are good");
    (folder, tls)
}

fn plant() -> (Plant, arcline_realtime::Handle) {
    let project = arcline_config::load(arcline_config::DEFAULT, "machine.toml").expect("it is valid");
    Plant::start(&project).expect("a thread")
}

fn client(folder: &Path, name: &str, replace: bool) -> CertsCommand {
    CertsCommand::Client {
        folder: folder.to_owned(),
        name: name.to_owned(),
        days: 1,
        replace,
    }
}

fn shown(folder: &Path, name: &str) -> TlsClient {
    use rustls::pki_types::pem::PemObject as _;
    let chain = vec![CertificateDer::from_pem_file(folder.join(name)).expect("a certificate")];
    let leaf = Leaf::read(&chain[0]).expect("a certificate");
    TlsClient { chain, leaf }
}

/// The server checked the handshake by the earlier files; the connection enters after the reload.
#[tokio::test]
async fn a_certificate_that_is_revoked_during_its_handshake_does_not_get_in() {
    let (folder, tls) = bench();
    let (plant, _thread) = plant();
    let close = CancellationToken::new();
    tls.enter(1, shown(folder.path(), "hmi.pem"), &plant, close.clone());
    assert!(!close.is_cancelled(), "it holds");
    let revoke = CertsCommand::Revoke {
        folder: folder.path().to_owned(),
        name: "hmi".to_owned(),
    };
    certs::run(&revoke).expect("it is revoked");
    tls.reload(&plant);
    assert!(close.is_cancelled(), "an open connection");
    let late = CancellationToken::new();
    tls.enter(2, shown(folder.path(), "hmi.pem"), &plant, late.clone());
    assert!(late.is_cancelled(), "one whose handshake is done");
    assert!(tls.live().is_empty());
    assert!(!tls.leave(1) && !tls.leave(2), "their certificate does not hold");
}

/// The rows of a configuration that is read again hold for open connections, and for one whose handshake was done by the rows of before.
#[tokio::test]
async fn other_rows_give_open_connections_other_roles() {
    let (folder, tls) = bench();
    let (plant, _thread) = plant();
    let client = shown(folder.path(), "hmi.pem");
    let role_of = |session| plant.roles().of(Principal::Client { session, connection: 0 });
    let close = CancellationToken::new();
    tls.enter(1, client.clone(), &plant, close.clone());
    assert_eq!(role_of(1), Role::Operator, "without a row");
    let row = |role| Security {
        certificates: vec![CertificateRole {
            cn: None,
            issuer: None,
            sha256: Some(client.leaf.sha256.to_uppercase()),
            role,
        }],
        ..Security::default()
    };
    for role in [Role::Administrator, Role::Viewer, Role::Engineer] {
        tls.set_roles(&row(role), &plant);
        // The role that the handshake found is not that of now.
        plant.roles().set(2, Role::Administrator);
        tls.enter(2, client.clone(), &plant, CancellationToken::new());
        assert_eq!(role_of(2), role, "the one that comes in");
        tls.reload(&plant);
        assert_eq!(role_of(1), role, "the open one");
    }
    // A file of certificates that is of no use does not keep the rows back.
    fs::write(folder.path().join("server.pem"), "no certificate").expect("a writable folder");
    tls.set_roles(&Security::default(), &plant);
    tls.reload(&plant);
    assert_eq!(role_of(1), Role::Viewer);
    assert!(!close.is_cancelled() && tls.leave(1), "its certificate holds");
}

#[tokio::test]
async fn the_metrics_say_when_the_certificate_of_the_server_ends() {
    const NAME: &str = "arcline_certificate_expires_timestamp_seconds ";
    let (folder, tls) = bench();
    let (plant, _thread) = plant();
    assert!(!metrics(&plant).contains(NAME.trim()), "no TLS as yet");
    let ends = |plant: &Plant| {
        let text = metrics(plant);
        let value = text.lines().find_map(|line| line.strip_prefix(NAME));
        value.map(|value| value.parse::<f64>().expect("a number"))
    };
    let own = || shown(folder.path(), "server.pem").leaf.valid.1 as f64;
    // The task reports it before its first pause.
    tokio::select! {
        biased;
        () = tls.watch(&plant) => {}
        () = std::future::ready(()) => {}
    }
    let first = own();
    assert_eq!(ends(&plant), Some(first));
    // A new one that holds for one day.
    fs::copy(folder.path().join("hmi.pem"), folder.path().join("server.pem")).expect("a writable folder");
    fs::copy(folder.path().join("hmi.key"), folder.path().join("server.key")).expect("a writable folder");
    tls.reload(&plant);
    assert_eq!(ends(&plant), Some(own()));
    assert_ne!(first, own());
}

#[tokio::test]
async fn the_audit_tells_a_reload_that_failed() {
    let (folder, tls) = bench();
    let (plant, _thread) = plant();
    let audit = folder.path().join("audit");
    plant.set_audit(Audit::open(&audit).expect("a writable folder"));
    tls.reload(&plant);
    fs::write(folder.path().join("server.pem"), "no certificate").expect("a writable folder");
    tls.reload(&plant);
    plant.close_audit();
    let text = fs::read_to_string(audit.join("000001.jsonl")).expect("it is there");
    let results: Vec<bool> = text
        .lines()
        .filter(|line| line.contains("\"what\":\"reload\""))
        .map(|line| line.contains("\"result\":\"done\""))
        .collect();
    assert_eq!(results, [true, false], "{text}");
}

/// The end of the list of `certs revoke`, in ten years: the warning of an old list rests on it.
#[test]
fn a_list_of_revoked_certificates_says_until_when_it_holds() {
    let (_folder, tls) = bench();
    let next = tls.trust.load().next_list.expect("it says so");
    let days = (next - unix_seconds()) / 86_400;
    assert!((3649..=3650).contains(&days), "{days}");
}

/// Every certificate in a file can be revoked: the list has it, even if the file could not be written to its end.
#[test]
fn a_certificate_is_listed_before_it_is_written() {
    let (folder, _) = bench();
    // A folder stands where the certificate belongs.
    fs::create_dir_all(folder.path().join("panel.pem/x")).expect("a writable folder");
    assert!(certs::run(&client(folder.path(), "panel", true)).is_err());
    let revoke = CertsCommand::Revoke {
        folder: folder.path().to_owned(),
        name: "panel".to_owned(),
    };
    certs::run(&revoke).expect("it is listed");
}
