//! A real Prometheus reads the metrics of a real server; promtool judges the text and the alert rules; every query of the dashboard is asked.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use arcline_system_tests::server::Server;
use arcline_system_tests::{not_run, workspace};
use serde_json::Value;

/// Longest wait for a scrape, which comes each second.
const DEADLINE: Duration = Duration::from_secs(60);

/// A program that ends with the value.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The folder of `prometheus` and `promtool`: that of `PROMETHEUS`, or of the path.
fn programs() -> Option<PathBuf> {
    let path = std::env::var_os("PROMETHEUS").or_else(|| std::env::var_os("PATH"))?;
    std::env::split_paths(&path).find(|folder| folder.join("prometheus").is_file() && folder.join("promtool").is_file())
}

/// The body of a GET.
fn get(at: SocketAddr, path: &str) -> Option<String> {
    let mut stream = TcpStream::connect(at).ok()?;
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: {at}\r\nConnection: close\r\nAccept-Encoding: identity\r\n\r\n"
    )
    .ok()?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).ok()?;
    let (head, body) = answer.split_once("\r\n\r\n")?;
    if !head.to_ascii_lowercase().contains("transfer-encoding: chunked") {
        return Some(body.to_owned());
    }
    let (mut rest, mut whole) = (body, String::new());
    while let Some((length, behind)) = rest.split_once("\r\n") {
        let length = usize::from_str_radix(length.trim(), 16)
            .ok()
            .filter(|length| *length > 0);
        let Some(piece) = length.and_then(|length| behind.get(..length)) else {
            break;
        };
        whole.push_str(piece);
        rest = behind.get(piece.len() + 2..).unwrap_or_default();
    }
    Some(whole)
}

fn query(at: SocketAddr, expression: &str) -> Option<Value> {
    let encoded: String = expression.bytes().map(|byte| format!("%{byte:02X}")).collect();
    serde_json::from_str(&get(at, &format!("/api/v1/query?query={encoded}"))?).ok()
}

fn check(promtool: &Path, what: &[&str], input: &str) {
    let mut child = Command::new(promtool)
        .args(what)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("promtool is there");
    let mut stdin = child.stdin.take().expect("stdin is piped");
    stdin.write_all(input.as_bytes()).expect("promtool reads");
    drop(stdin);
    let output = child.wait_with_output().expect("promtool ends");
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{what:?}: {said}\n{input}");
}

#[test]
fn prometheus_scrapes_the_server() {
    let Some(programs) = programs() else {
        return not_run(
            "the metrics with Prometheus",
            "prometheus is missing (Debian: apt-get install prometheus)",
        );
    };
    let server = Server::start_with(&["--hmi", "127.0.0.1:0"]);
    let hmi = server.hmi().expect("the server has a page");
    let metrics = get(hmi, "/metrics").expect("the page answers");
    let promtool = programs.join("promtool");
    check(&promtool, &["check", "metrics"], &metrics);
    let rules = workspace().join("docs/metrics/alerts.yml");
    check(&promtool, &["check", "rules", rules.to_str().expect("UTF-8")], "");
    let alerts = std::fs::read_to_string(&rules)
        .expect("the rules")
        .matches("alert:")
        .count();
    // Each alert fires on numbers that are wrong, and not on those of a machine that works.
    let tests = workspace().join("docs/metrics/alerts.test.yml");
    check(&promtool, &["test", "rules", tests.to_str().expect("UTF-8")], "");
    let tested = std::fs::read_to_string(&tests).expect("their tests");
    assert_eq!(tested.matches("alertname:").count(), 2 * alerts, "each alert, twice");
    let series = metrics.lines().filter(|line| !line.starts_with('#')).count();
    assert!((100..5000).contains(&series), "{series} series");

    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("prometheus.yml");
    let text = format!(
        "global:\n  scrape_interval: 1s\nrule_files: [{:?}]\nscrape_configs:\n  - job_name: arcline\n    static_configs:\n      - targets: [\"{hmi}\"]\n",
        rules.display().to_string()
    );
    std::fs::write(&config, text).expect("a file");
    // Prometheus has no ready line with its port.
    let free = TcpListener::bind("127.0.0.1:0")
        .and_then(|free| free.local_addr())
        .expect("a free port");
    let child = Command::new(programs.join("prometheus"))
        .arg(format!("--config.file={}", config.display()))
        .arg(format!("--storage.tsdb.path={}", folder.path().join("data").display()))
        .arg(format!("--web.listen-address={free}"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("prometheus is there");
    let _prometheus = Running(child);
    let began = Instant::now();
    // Two scrapes, so that there are rates.
    let rate = "irate(arcline_ticks_total[1m])";
    let found = loop {
        let result =
            query(free, rate).and_then(|answer| answer["data"]["result"][0]["value"][1].as_str()?.parse::<f64>().ok());
        if let Some(rate) = result {
            break rate;
        }
        assert!(began.elapsed() < DEADLINE, "Prometheus has scraped nothing");
        std::thread::sleep(Duration::from_millis(100));
    };
    assert!(found > 100.0, "{found} ticks a second");
    let axes = query(free, "count(arcline_axis_enabled)").expect("an answer");
    assert_eq!(axes["data"]["result"][0]["value"][1], "7", "{axes}");
    let loaded = get(free, "/api/v1/rules").expect("an answer");
    assert_eq!(loaded.matches("\"health\":").count(), alerts, "{loaded}");
    assert_eq!(loaded.matches("\"health\":\"err\"").count(), 0, "{loaded}");

    let dashboard = std::fs::read_to_string(workspace().join("docs/metrics/dashboard.json")).expect("the dashboard");
    let dashboard: Value = serde_json::from_str(&dashboard).expect("JSON");
    let panels = dashboard["panels"].as_array().expect("panels");
    for target in panels
        .iter()
        .flat_map(|panel| panel["targets"].as_array().into_iter().flatten())
    {
        let asked = target["expr"].as_str().expect("a query");
        let asked = asked.replace("$instance", ".*").replace("$__rate_interval", "1m");
        let answer = query(free, &asked).expect("an answer");
        assert_eq!(answer["status"], "success", "{asked}: {answer}");
        let values = answer["data"]["result"].as_array().map_or(0, Vec::len);
        assert!(values > 0, "{asked}: no series");
    }
}
