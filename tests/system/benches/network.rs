//! The speed of tag reads over the network, beside a bare echo of the same sizes and the servers of two other projects, all on
//! this machine and in one run: `cargo bench -p arcline-system-tests --bench network`. Rounds take turns, so that whatever else the
//! machine does meets all of them. Then plain reads beside the same over TLS, in turns. `-- --test` asks each a few times and measures nothing;
//! `-- --than FILE` compares with the server of another build, and with nothing else.
#![allow(missing_docs)]

use std::io::{BufRead, BufReader, Write as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use arcline_client::Tls;
use arcline_system_tests::load::{Load, Outcome, Question, read, read_all, serve_echo};
use arcline_system_tests::python::Python;
use arcline_system_tests::secured::Secured;
use arcline_system_tests::server::{Server, processor_time};

/// Tags that one Multiple Service Packet reads.
const TAGS: usize = 100;
/// Connections that are opened in a round, plain and over TLS.
const CONNECTS: usize = 5;
/// The size of class 3 connections, bytes.
const SIZE: u16 = 500;
/// The same where 100 replies have to fit.
const LARGE: u16 = 4000;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if arguments.get(1).is_some_and(|first| first == "echo") {
        return serve_echo();
    }
    let smoke = arguments.iter().any(|argument| argument == "--test");
    let (rounds, time) = if smoke {
        (1, Duration::from_millis(30))
    } else {
        (40, Duration::from_millis(250))
    };
    let run = Run { rounds, time };
    let folder = tempfile::tempdir().expect("a folder");
    let machine = machine(folder.path());
    let server = Server::start_on(&machine);
    let mut faults = 0;
    if let Some(flag) = arguments.iter().position(|argument| argument == "--than") {
        let file = arguments
            .get(flag + 1)
            .expect("--than FILE: the server of another build");
        let machine = machine.to_str().expect("a path of plain letters");
        let other = Server::try_start(Command::new(file), &["--config", machine]).expect("the other build starts");
        let question = Question::Connected(read("Bench"), SIZE);
        for connections in [1, 32] {
            let [ours, other] = [("this build", &server), ("the other build", &other)]
                .map(|(name, server)| Rival::new(&format!("{name}, one tag"), &question, server));
            faults += run.beside(connections, &ours, &other);
        }
        assert_eq!(faults, 0, "questions that had no right answer");
        return;
    }
    let echo = Other::echo();

    for connections in [1, 32] {
        let question = Question::Connected(read("Bench"), SIZE);
        faults += run.beside_echo("one tag", &question, connections, &server, &echo);
    }
    let packet = read_all((0..TAGS).map(|number| format!("Bench{number}")));
    faults += run.beside_echo("100 tags", &Question::Connected(packet, LARGE), 1, &server, &echo);

    faults += run.over_tls(32, smoke);

    for client in ["cm_ethernetip", "cpppo"] {
        let other = match Python::with(client) {
            Ok(python) => Other::python(&python, client),
            Err(why) => {
                println!("{client}: NOT RUN: {why}");
                continue;
            }
        };
        for connections in [1, 32] {
            for question in [
                Question::Connected(read("Bench"), SIZE),
                Question::Unconnected(read("Bench")),
            ] {
                let outcome = Run {
                    rounds: run.rounds.min(4),
                    ..run
                }
                .of(&question, connections, other.address);
                if outcome.errors == 0 {
                    print(&format!("{client}, one tag"), connections, &outcome);
                    break;
                }
                println!("{client}: {}", outcome.first_error.unwrap_or_default());
            }
        }
    }
    assert_eq!(faults, 0, "questions that had no right answer");
}

/// The settings of a measurement.
#[derive(Clone, Copy)]
struct Run {
    rounds: usize,
    /// The time of a round.
    time: Duration,
}

impl Run {
    fn of(self, question: &Question, connections: usize, server: SocketAddr) -> Outcome {
        let mut all = Outcome::default();
        for _ in 0..self.rounds {
            all.add(self.once(question, connections, server, None));
        }
        all
    }

    fn once(self, question: &Question, connections: usize, server: SocketAddr, tls: Option<Tls>) -> Outcome {
        let question = question.clone();
        Load {
            server,
            question,
            connections,
            time: self.time,
            pace: None,
            tls,
        }
        .run()
    }

    /// Against the server and the echo in turns; how many answers were wrong.
    fn beside_echo(self, what: &str, question: &Question, connections: usize, server: &Server, echo: &Other) -> usize {
        let (request, reply) = self.once(question, connections, server.address(), None).sizes;
        let ours = Rival::new(&format!("Arcline, {what}"), question, server);
        let echo = Rival {
            name: format!("echo of {request} and {reply} bytes"),
            question: Question::Echo { request, reply },
            address: echo.address,
            process: echo.child.id(),
        };
        self.beside(connections, &ours, &echo)
    }

    /// Two servers in turns; how many answers were wrong.
    fn beside(self, connections: usize, ours: &Rival, other: &Rival) -> usize {
        let rivals = [ours, other];
        let idle = rivals.map(|rival| idle(rival.process));
        let mut outcomes = [Outcome::default(), Outcome::default()];
        let mut busy = [Duration::ZERO; 2];
        let mut ratios = Vec::with_capacity(self.rounds);
        for round in 0..self.rounds {
            let mut rates = [0.0; 2];
            for index in [round % 2, 1 - round % 2] {
                let rival = rivals[index];
                let before = processor_time(rival.process);
                let outcome = self.once(&rival.question, connections, rival.address, None);
                busy[index] += processor_time(rival.process).saturating_sub(before);
                rates[index] = outcome.rate();
                outcomes[index].add(outcome);
            }
            ratios.push(rates[0] / rates[1]);
        }
        ratios.sort_by(f64::total_cmp);
        for (rival, outcome) in rivals.iter().zip(&outcomes) {
            print(&rival.name, connections, outcome);
        }
        let [ours, other] = &outcomes;
        println!(
            "{:>56} {:.3} of the other's rate (median of rounds {:.3}), p50 {:+.1} µs, p99 {:.2} times",
            "",
            ours.rate() / other.rate(),
            ratios[ratios.len() / 2],
            ours.percentile(0.5) - other.percentile(0.5),
            ours.percentile(0.99) / other.percentile(0.99),
        );
        // The time of all threads, without the server's time without requests.
        let [own, others] = [0, 1].map(|index| {
            let outcome = &outcomes[index];
            let answers = busy[index].saturating_sub(outcome.elapsed.mul_f64(idle[index]));
            answers.as_secs_f64() * 1e6 / outcome.times.len().max(1) as f64
        });
        println!(
            "{:>56} processor time of an answer: {own:.2} µs, the other's {others:.2} µs",
            ""
        );
        for (rival, outcome) in rivals.iter().zip(&outcomes) {
            if let Some(why) = &outcome.first_error {
                println!("{}: {why}", rival.name);
            }
        }
        ours.errors + other.errors
    }
}

/// One of two servers that are measured in turns, and what it is asked.
struct Rival {
    name: String,
    question: Question,
    address: SocketAddr,
    process: u32,
}

impl Rival {
    fn new(name: &str, question: &Question, server: &Server) -> Self {
        Self {
            name: name.to_owned(),
            question: question.clone(),
            address: server.address(),
            process: server.process(),
        }
    }
}

impl Run {
    /// Reads one tag by plain connections and over TLS, in turns; returns the number of wrong answers.
    fn over_tls(self, connections: usize, smoke: bool) -> usize {
        let tag = "[[tag]]\nname = \"Bench\"\ntype = \"DINT\"\n";
        let secured = Secured::start(&format!("{}\n{tag}", arcline_config::DEFAULT), "", &[]);
        let server = &secured.server;
        let listeners = [
            (server.address(), None),
            (server.tls().expect("it has TLS"), Some(secured.tls())),
        ];
        let question = Question::Connected(read("Bench"), SIZE);
        let connecting = Self {
            time: Duration::ZERO,
            ..self
        };
        let mut outcomes = [Outcome::default(), Outcome::default()];
        // The times from no connection to an open class 3 connection that has answered: with TLS, a whole handshake each.
        let mut connects = [Vec::new(), Vec::new()];
        for round in 0..self.rounds {
            for index in [round % 2, 1 - round % 2] {
                let (server, tls) = listeners[index].clone();
                for _ in 0..CONNECTS {
                    // A certificate that was read anew has no session to resume.
                    let tls = tls.is_some().then(|| secured.tls());
                    let began = Instant::now();
                    let outcome = connecting.once(&question, 1, server, tls);
                    connects[index].push(began.elapsed());
                    outcomes[index].errors += outcome.errors;
                }
                outcomes[index].add(self.once(&question, connections, server, tls));
            }
        }
        let [plain, tls] = &outcomes;
        print("Arcline, one tag, plain", connections, plain);
        print("Arcline, one tag, TLS", connections, tls);
        let ratio = tls.rate() / plain.rate();
        println!("{:>56} {ratio:.3} of the plain rate", "");
        let [plain_connect, tls_connect] = connects.map(|mut times| {
            times.sort_unstable();
            times[times.len() / 2].as_secs_f64()
        });
        println!(
            "{:>56} to connect and read once: {:.0} µs plain, {:.0} µs over TLS, {:.0} handshakes a second of one client",
            "",
            plain_connect * 1e6,
            tls_connect * 1e6,
            1.0 / (tls_connect - plain_connect).max(1e-9)
        );
        // spec/security.md: the permitted cost of TLS.
        assert!(smoke || ratio >= 0.7, "reads over TLS: {ratio:.3} of the plain rate");
        plain.errors + tls.errors
    }
}

/// The processor time that a process takes without requests, as a share of one processor.
fn idle(process: u32) -> f64 {
    let (began, before) = (Instant::now(), processor_time(process));
    std::thread::sleep(Duration::from_millis(300));
    let took = processor_time(process).saturating_sub(before);
    took.as_secs_f64() / began.elapsed().as_secs_f64()
}

fn print(what: &str, connections: usize, outcome: &Outcome) {
    println!(
        "{what:<40} {connections:>3} connections {:>9.0}/s  p50 {:>7.1} µs  p99 {:>7.1} µs  {} errors",
        outcome.rate(),
        outcome.percentile(0.5),
        outcome.percentile(0.99),
        outcome.errors
    );
    let _ = std::io::stdout().flush();
}

/// Writes the default machine with tags to read into a folder.
fn machine(folder: &Path) -> PathBuf {
    let names = std::iter::once("Bench".to_owned()).chain((0..TAGS).map(|number| format!("Bench{number}")));
    let tags: String = names
        .map(|name| format!("[[tag]]\nname = \"{name}\"\ntype = \"DINT\"\n"))
        .collect();
    let file = folder.join("network.toml");
    std::fs::write(&file, format!("{}\n{tags}", arcline_config::DEFAULT)).expect("a file");
    file
}

/// A server of another project, ended when this is dropped.
struct Other {
    child: Child,
    address: SocketAddr,
}

impl Other {
    fn echo() -> Self {
        let this = std::env::current_exe().expect("a running program has a file");
        Self::start(Command::new(this).arg("echo"))
    }

    fn python(python: &Python, client: &str) -> Self {
        let script = arcline_system_tests::fixture("python/servers.py");
        Self::start(python.command().arg(script).args([client, "Bench"]))
    }

    fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it was just built");
        let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("ready eip=")?.trim().parse().ok());
        // Its further output must be read.
        std::thread::spawn(move || lines.for_each(drop));
        let address = address.expect("a ready line");
        Self { child, address }
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
