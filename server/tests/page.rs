//! The users of the page with the real program: the commands that write them, and the protection of their secrets in files.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

const SERVER: &str = env!("CARGO_BIN_EXE_arcline-server");
/// Longer than any step of these tests may take on a slow machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// Runs a command with a line on its standard input; returns its exit code and its output.
fn run(arguments: &[&str], input: &str) -> (Option<i32>, String) {
    let mut child = Command::new(SERVER)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    // A command that needs no password may have ended.
    let _ = child.stdin.take().expect("piped").write_all(input.as_bytes());
    let Output { status, stdout, stderr } = child.wait_with_output().expect("it ends");
    let text = [stdout, stderr].concat();
    (status.code(), String::from_utf8_lossy(&text).into_owned())
}

#[test]
fn commands_keep_the_users() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("users.toml");
    let at = file.to_str().expect("UTF-8");
    #[rustfmt::skip]
    let cases: &[(&str, &[&str], &str, i32, &str)] = &[
        ("too short",       &["users", "add", at, "anna", "--role", "operator"],  "eleven char\n",          2, "expected 12 or more"),
        ("the name",        &["users", "add", at, "a long enough name", "--role", "viewer"], "A long enough name\n", 2, "is the name"),
        ("no such role",    &["users", "add", at, "anna", "--role", "boss"],      "a long password\n",      2, "viewer, operator, engineer, administrator"),
        ("a user",          &["users", "add", at, "anna", "--role", "operator"],  "a long password\n",      0, "anna is operator"),
        ("the same again",  &["users", "add", at, "anna", "--role", "viewer"],    "a long password\n",      2, "there is a user \"anna\" already"),
        ("another one",     &["users", "add", at, "bert", "--role", "engineer"],  "another password\n",     0, "bert is engineer"),
        ("another role",    &["users", "role", at, "anna", "--role", "viewer"],   "",                       0, "anna is viewer"),
        ("disabled",        &["users", "disable", at, "anna"],                    "",                       0, "anna cannot log in"),
        ("the list",        &["users", "list", at],                               "",                       0, "viewer         anna  disabled\nengineer       bert\n"),
        ("enabled",         &["users", "enable", at, "anna"],                     "",                       0, "anna can log in"),
        ("logged out",      &["users", "logout", at, "anna"],                     "",                       0, "anna is logged out"),
        ("nobody's session", &["users", "logout", at, "carl"],                    "",                       2, "there is no user \"carl\""),
        ("a password",      &["users", "passwd", at, "anna"],                     "yet another one\n",      0, "anna has another password"),
        ("nobody",          &["users", "passwd", at, "carl"],                     "yet another one\n",      2, "there is no user \"carl\""),
        ("removed",         &["users", "remove", at, "bert"],                     "",                       0, "the user bert was removed"),
        ("a token",         &["tokens", "add", at, "logger", "--role", "viewer"], "",                       0, "arc_"),
        ("its row",         &["tokens", "list", at],                              "",                       0, "logger"),
        ("it goes",         &["tokens", "remove", at, "logger"],                  "",                       0, "the token logger was removed"),
        ("it has gone",     &["tokens", "remove", at, "logger"],                  "",                       2, "there is no token"),
    ];
    for (why, arguments, input, code, expected) in cases {
        let (ended, text) = run(arguments, input);
        assert_eq!(ended, Some(*code), "{why}: {text}");
        assert!(text.contains(expected), "{why}: {text}");
        assert!(!text.contains("argon2"), "{why}: {text}");
    }
    let mode = fs::metadata(&file).expect("it is there").permissions().mode();
    assert_eq!(mode & 0o777, 0o600, "{mode:o}");
}

/// A server that is killed when this is dropped.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn post(page: SocketAddr, path: &str, headers: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(page).expect("it accepts");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time");
    let length = body.len();
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
    );
    stream.write_all(request.as_bytes()).expect("it reads");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("it answers");
    answer
}

fn all_files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => files.extend(all_files(&path)),
            false => files.push((path.display().to_string(), fs::read(&path).expect("a file"))),
        }
    }
    files
}

/// Passwords, secrets of sessions and tokens are in no file that the server writes: not in the log at its most, the audit or the state.
/// The text typed in place of a user's name may be a password.
#[test]
fn secrets_are_written_nowhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let users = at("users.toml");
    assert_eq!(
        run(
            &["users", "add", &users, "anna", "--role", "operator"],
            "correct horse battery\n"
        )
        .0,
        Some(0)
    );
    let (code, token) = run(&["tokens", "add", &users, "logger", "--role", "viewer"], "");
    assert_eq!(code, Some(0), "{token}");
    let written = folder.path().join("written");
    fs::create_dir(&written).expect("a writable folder");
    fs::write(at("machine.toml"), "[security]\nusers = \"users.toml\"\n[[axis]]\nname = \"X\"\ntype = \"virtual\"\nmax_speed = 100\nmax_acceleration = 1000\n")
        .expect("a writable folder");
    let mut server = Command::new(SERVER)
        .args([
            "--config",
            &at("machine.toml"),
            "--listen",
            "127.0.0.1:0",
            "--hmi",
            "127.0.0.1:0",
        ])
        .args(["--state", &at("written/state"), "--audit", &at("written/audit")])
        .env("RUST_LOG", "trace")
        .stdout(Stdio::piped())
        .stderr(fs::File::create(at("written/log")).expect("a writable folder"))
        .spawn()
        .map(Killed)
        .expect("it starts");
    let mut line = String::new();
    let mut out = BufReader::new(server.0.stdout.take().expect("piped"));
    out.read_line(&mut line).expect("it says ready");
    let page = line.split_whitespace().find_map(|word| word.strip_prefix("hmi="));
    let page: SocketAddr = page.and_then(|page| page.parse().ok()).expect("an address");
    let wrong = post(
        page,
        "/login",
        "",
        r#"{"user":"anna","password":"wrong horse battery"}"#,
    );
    assert!(wrong.starts_with("HTTP/1.1 401"), "{wrong}");
    let swapped = post(
        page,
        "/login",
        "",
        r#"{"user":"swapped horse battery","password":"anna"}"#,
    );
    assert!(swapped.starts_with("HTTP/1.1 401"), "{swapped}");
    let good = post(
        page,
        "/login",
        "",
        r#"{"user":"anna","password":"correct horse battery"}"#,
    );
    let secret = good.split("arcline=").nth(1).and_then(|rest| rest.split(';').next());
    let secret = secret.expect("a cookie").to_owned();
    assert_eq!(secret.len(), 43, "{good}");
    let bearer = format!(
        "Authorization: Bearer {token}\r\nOrigin: http://localhost\r\n",
        token = token.trim()
    );
    assert!(
        post(page, "/lock", &bearer, "").starts_with("HTTP/1.1 204"),
        "a token is a session"
    );
    let out = post(
        page,
        "/logout",
        &format!("Cookie: arcline={secret}\r\nOrigin: http://localhost\r\n"),
        "",
    );
    assert!(out.starts_with("HTTP/1.1 204"), "{out}");
    let ended = Command::new("kill").arg(server.0.id().to_string()).status();
    assert!(ended.is_ok_and(|status| status.success()));
    assert!(server.0.wait().is_ok_and(|status| status.success()));
    let hash = fs::read_to_string(&users).expect("it is there");
    let hash = hash
        .split('"')
        .find(|text| text.starts_with("$argon2id$"))
        .expect("a hash")
        .to_owned();
    let files = all_files(&written);
    assert!(
        files
            .iter()
            .any(|(name, bytes)| name.ends_with(".jsonl") && bytes.len() > 500),
        "an audit"
    );
    assert!(
        files
            .iter()
            .any(|(name, bytes)| name.ends_with("log") && bytes.len() > 500),
        "a log"
    );
    for (name, bytes) in &files {
        for secret in ["horse battery", &secret, token.trim(), &hash] {
            let found = bytes.windows(secret.len()).any(|window| window == secret.as_bytes());
            assert!(!found, "{name} has {secret:?}");
        }
    }
    let audit = String::from_utf8_lossy(
        &files
            .iter()
            .find(|(name, _)| name.ends_with(".jsonl"))
            .expect("an audit")
            .1,
    )
    .into_owned();
    for what in ["\"login\"", "\"login-refused\"", "\"logout\"", "\"locked\""] {
        assert!(audit.contains(&format!("\"what\":{what}")), "{what} in {audit}");
    }
}

/// Beyond this computer the server listens only with roles in its configuration, or with a banner.
#[test]
fn the_page_is_not_opened_by_accident() {
    for listen in [
        ["--listen", "0.0.0.0:0"],
        ["--hmi", "0.0.0.0:0"],
        ["--listen", "[::]:0"],
    ] {
        let (code, text) = run(&["run", listen[0], listen[1]], "");
        assert_eq!(code, Some(2), "{listen:?}: {text}");
        assert!(
            text.contains("--open-to-network") && text.contains("[security]"),
            "{listen:?}: {text}"
        );
    }
    let mut server = Command::new(SERVER)
        .args(["run", "--listen", "0.0.0.0:0", "--hmi", "off", "--open-to-network"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map(Killed)
        .expect("it starts");
    let mut line = String::new();
    BufReader::new(server.0.stdout.take().expect("piped"))
        .read_line(&mut line)
        .expect("it says ready");
    assert!(line.starts_with("ready eip=0.0.0.0:"), "{line}");
    server.0.kill().expect("it runs");
    let mut text = String::new();
    server
        .0
        .stderr
        .take()
        .expect("piped")
        .read_to_string(&mut text)
        .expect("text");
    assert!(
        text.contains("OPEN TO THE NETWORK") && text.contains("all others the role viewer"),
        "{text}"
    );
}

/// A proxy makes all of its clients clients on this computer: the log says so, unless these may only look.
#[test]
fn a_proxy_on_this_computer_is_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("machine.toml");
    for (more, is_warned) in [("", true), ("[security]\nloopback = \"viewer\"\n", false)] {
        let text =
            format!("{more}[[axis]]\nname = \"X\"\ntype = \"virtual\"\nmax_speed = 100\nmax_acceleration = 1000\n");
        fs::write(&file, text).expect("a writable folder");
        let mut server = Command::new(SERVER)
            .args(["--listen", "127.0.0.1:0", "--hmi", "127.0.0.1:0", "--config"])
            .arg(&file)
            .env("RUST_LOG", "warn")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map(Killed)
            .expect("it starts");
        let mut line = String::new();
        BufReader::new(server.0.stdout.take().expect("piped"))
            .read_line(&mut line)
            .expect("it says ready");
        let page = line.split_whitespace().find_map(|word| word.strip_prefix("hmi="));
        let page: SocketAddr = page.and_then(|page| page.parse().ok()).expect("it listens");
        let answer = post(page, "/logout", "X-Forwarded-For: 10.1.2.3\r\n", "");
        assert!(answer.starts_with("HTTP/1.1 "), "{answer}");
        server.0.kill().expect("it runs");
        let mut text = String::new();
        let mut said = server.0.stderr.take().expect("piped");
        said.read_to_string(&mut text).expect("text");
        assert_eq!(text.contains("X-Forwarded-For"), is_warned, "{more}: {text}");
    }
}
