//! Cases and batches.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde_json::Value;

use crate::{Batch, Defaults, Done, finished};

const MOVE: &str = "MCLM(CS1, M1, Absolute, [10, 5, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";

fn batch(jobs: usize) -> Batch {
    Batch {
        defaults: Arc::new(Defaults {
            seed: 100,
            ..Defaults::default()
        }),
        first: 0,
        from: 0,
        to: None,
        jobs,
        over: Arc::default(),
    }
}

/// The results of lines, and what came of them.
fn results(batch: &Batch, lines: &str) -> (Vec<Value>, Done) {
    let mut output = Vec::new();
    let mut told = 0;
    let done = batch
        .run(lines.as_bytes(), &mut output, &mut |_| {
            told += 1;
            true
        })
        .expect("it runs");
    let text = String::from_utf8(output).expect("JSON is UTF-8");
    let results: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("a result is JSON"))
        .collect();
    assert_eq!((told, done.results), (results.len(), results.len() as u64));
    (results, done)
}

/// A line of a case with a program, and further members.
fn case(text: &str, more: &str) -> String {
    format!("{{\"text\":{}{more}}}\n", Value::from(text))
}

#[test]
fn results_come_in_the_order_of_the_cases_on_any_number_of_threads() {
    // Runs of very different lengths.
    let delay = |number: u64| format!("{MOVE} DELAY({});", (number * 7) % 5);
    let lines: String = (0..40)
        .map(|number| case(&delay(number), &format!(",\"id\":{number}")))
        .collect();
    let without_wall = |mut results: Vec<Value>| {
        for result in &mut results {
            result.as_object_mut().expect("an object").remove("wall_s");
        }
        results
    };
    let (one, done) = results(&batch(1), &lines);
    assert_eq!(
        done,
        Done {
            results: 40,
            invalid: 0
        }
    );
    let one = without_wall(one);
    for (number, result) in one.iter().enumerate() {
        assert_eq!((&result["case"], &result["id"]), (&number.into(), &number.into()));
        assert_eq!(result["end"], "finished");
        assert_eq!(result["positions"]["X"], 10.0);
    }
    let hashes: BTreeSet<&str> = one.iter().filter_map(|result| result["hash"].as_str()).collect();
    assert_eq!(hashes.len(), 5, "one of each length");
    assert_eq!(without_wall(results(&batch(4), &lines).0), one);
    // The same parts in other processes: numbers and seeds are those of the whole.
    let part = Batch {
        from: 30,
        to: Some(35),
        ..batch(2)
    };
    assert_eq!(without_wall(results(&part, &lines).0), one[30..35]);
    let chunk: String = lines.lines().skip(30).map(|line| format!("{line}\n")).collect();
    let part = Batch { first: 30, ..batch(2) };
    assert_eq!(without_wall(results(&part, &chunk).0), one[30..]);
    // Whoever looks at the results can end it.
    let mut seen = 0;
    let ended = batch(3).run(lines.as_bytes(), std::io::sink(), &mut |_| {
        seen += 1;
        seen < 7
    });
    assert_eq!(ended.expect("no error").results, 7);
}

#[test]
fn a_case_that_cannot_be_run_is_told_with_its_line_and_ends_nothing() {
    let long = format!("{{\"text\":\"{}\"}}", " ".repeat(1 << 20));
    let lines = [
        case(MOVE, "").as_str(),
        "\n",
        "not JSON\n",
        "{\"progam\":\"a.st\"}\n",
        "{\"text\":\"\",\"program\":\"a.st\"}\n",
        "{}\n",
        "{\"program\":\"no/such/file.st\"}\n",
        &case("MAM(XX, M1, Absolute, 5, 1);", ""),
        &case(MOVE, ",\"set\":{\"axis.XX.max_speed\":5}"),
        &case(MOVE, ",\"set\":{\"axis.X.max_speed\":-5}"),
        &case(MOVE, ",\"set\":{\"Move1.Sped\":5}"),
        &case(MOVE, ",\"faults\":[{\"axis\":\"X\",\"fault\":\"overcurent\",\"at\":0}]"),
        &case(
            MOVE,
            ",\"faults\":[{\"axis\":\"X\",\"fault\":\"overcurrent\",\"at\":[2,1]}]",
        ),
        &case(MOVE, ",\"until\":-1"),
        &long,
        "\n",
        &case(MOVE, ""),
    ]
    .concat();
    let (results, done) = results(&batch(2), &lines);
    assert_eq!(
        done,
        Done {
            results: 15,
            invalid: 13
        }
    );
    #[rustfmt::skip]
    let expected = [
        "finished", "line 3: expected", "line 4: unknown field `progam`", "line 5: program is a file", "line 6: expected a program",
        "line 7: no/such/file.st: cannot be read", "line 8: the program: line 1, column 5: there is no axis `XX`",
        "line 9: set axis.XX.max_speed: there is no axis \"XX\"", "line 10: ", "line 11: set Move1.Sped: ",
        "line 12: there is no fault \"overcurent\", did you mean \"overcurrent\"?", "line 13: faults[0].at: expected", "line 14: until is -1",
        "line 15: the line is longer", "finished",
    ];
    for (number, (result, expected)) in results.iter().zip(expected).enumerate() {
        assert_eq!(result["case"], number, "{result}");
        match result["end"].as_str() {
            Some("invalid") => {
                let error = result["error"].as_str().expect("it says why");
                assert!(error.starts_with(expected), "{error}");
            }
            end => assert_eq!(end, Some(expected), "{result}"),
        }
    }
}

#[test]
fn tags_and_keys_are_set_and_faults_come() {
    let moved = "MAM(X, M1, Absolute, Move1.Speed, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    let lines = [
        case(moved, ",\"set\":{\"Move1.Speed\":7.5}"),
        case(
            "MAM(X, M1, Absolute, 10, 100, 1, 1000, Unitspersec2, 1000, Unitspersec2);",
            ",\"set\":{\"axis.X.max_speed\":50.0}",
        ),
        case(
            MOVE,
            ",\"faults\":[{\"axis\":\"x\",\"fault\":\"Overcurrent\",\"at\":0.05}]",
        ),
        case(
            MOVE,
            ",\"faults\":[{\"axis\":\"X\",\"fault\":\"overcurrent\",\"at\":[0.02,0.1]}]",
        ),
        case(
            MOVE,
            ",\"faults\":[{\"axis\":\"X\",\"fault\":\"overcurrent\",\"at\":[0.02,0.1]}],\"seed\":103",
        ),
        case(
            MOVE,
            ",\"faults\":[{\"axis\":\"X\",\"fault\":\"overcurrent\",\"at\":[0.02,0.1]}]",
        ),
        case("MAM(X, M1, Absolute, 5, -1);", ""),
        case("DELAY(100);", ",\"until\":1"),
    ]
    .concat();
    let (results, _) = results(&batch(1), &lines);
    assert_eq!(results[0]["positions"]["X"], 7.5);
    assert_eq!(results[1]["peaks"]["X"]["velocity"], 50.0, "{}", results[1]);
    assert_ne!(results[1]["config"], results[0]["config"]);
    assert_eq!(results[2]["faults"][0]["faults"][0], "overcurrent");
    assert_eq!(
        results[2]["faults"][0]["time_s"], 0.051,
        "in the tick behind that of the cause"
    );
    // By the seed: the same one, the same time.
    assert_eq!((&results[3]["seed"], &results[4]["seed"]), (&103.into(), &103.into()));
    assert_eq!(results[3]["hash"], results[4]["hash"]);
    assert_ne!(results[3]["hash"], results[5]["hash"]);
    let ends: Vec<&Value> = results[6..].iter().map(|result| &result["end"]).collect();
    assert_eq!(ends, ["erred", "timeout"]);
    assert_eq!((&results[6]["err"], &results[6]["exerr"]), (&13.into(), &4.into()));
}

#[test]
fn a_batch_that_is_over_ends_within_its_cases() {
    let line = case("DELAY(1e8);", ",\"until\":1e9");
    for jobs in [1, 3] {
        let batch = batch(jobs);
        // The thread sets it while the first cases run, each of which would take hours.
        let done = std::thread::scope(|scope| {
            let over = batch.over.clone();
            let (began, begun) = std::sync::mpsc::channel();
            let input = Begins(line.repeat(5).into_bytes().into(), began);
            scope.spawn(move || {
                let _ = begun.recv();
                over.store(true, std::sync::atomic::Ordering::Relaxed);
            });
            batch.run(std::io::BufReader::new(input), std::io::sink(), &mut |_| true)
        });
        let done = done.expect("no error");
        assert_eq!(done.results, 0, "{jobs} threads: a case that was ended has no result");
    }
}

/// Tells when it is read first.
struct Begins(std::collections::VecDeque<u8>, std::sync::mpsc::Sender<()>);

impl std::io::Read for Begins {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let _ = self.1.send(());
        self.0.read(buffer)
    }
}

#[test]
fn traces_have_the_chosen_signals() {
    let folder = tempfile::tempdir().expect("a folder");
    let pattern = folder.path().join("{case}.csv").display().to_string();
    let traced = |signals: &[&str], every| Batch {
        defaults: Arc::new(Defaults {
            trace: Some(pattern.clone()),
            signals: signals.iter().map(|signal| (*signal).to_owned()).collect(),
            every,
            ..Defaults::default()
        }),
        ..batch(1)
    };
    let line = case(MOVE, "");
    let read = || std::fs::read_to_string(folder.path().join("0.csv")).expect("its trace");
    let (all, _) = results(&traced(&[], 1), &line);
    let rows = all[0]["ticks"].as_u64().expect("ticks") as usize + 1;
    assert_eq!(read().lines().count(), rows + 1);
    let (some, _) = results(&traced(&["Y.CommandPosition", "x.actualposition"], 10), &line);
    assert_eq!(some[0]["hash"], all[0]["hash"], "the hash is that of the whole trace");
    let text = read();
    assert_eq!(
        text.lines().next(),
        Some("tick,time_s,Y.CommandPosition,x.actualposition")
    );
    assert_eq!(text.lines().count(), rows.div_ceil(10) + 1);
    assert!(
        text.lines().nth(2).is_some_and(|row| row.starts_with("10,0.01,")),
        "{text}"
    );
    let (wrong, _) = results(&traced(&["X.Position"], 1), &line);
    assert_eq!(wrong[0]["end"], "invalid");
}

#[test]
fn a_file_of_results_is_gone_on_with_behind_its_last_whole_line() {
    let lines = "{\"case\":5,\"end\":\"finished\"}\n{\"case\":6}\n";
    assert_eq!(finished(&b""[..], 5).expect("empty"), (0, 0));
    assert_eq!(finished(lines.as_bytes(), 5).expect("two"), (2, lines.len() as u64));
    let torn = format!("{lines}{{\"case\":7,\"en");
    assert_eq!(finished(torn.as_bytes(), 5).expect("two"), (2, lines.len() as u64));
    let error = finished(lines.as_bytes(), 0).expect_err("of other cases").to_string();
    assert!(error.contains("line 1 is not the result of case 0"), "{error}");
}

#[test]
fn memory_has_a_bound() {
    // More machines and programs than a worker keeps.
    let lines: String = (0..200)
        .map(|number| {
            case(
                &format!("DELAY(0.00{number});"),
                &format!(",\"set\":{{\"axis.X.max_speed\":{}.0}}", number + 1),
            )
        })
        .collect();
    let (results, done) = results(&batch(2), &lines);
    assert_eq!(done.invalid, 0);
    let configs: BTreeSet<&str> = results.iter().filter_map(|result| result["config"].as_str()).collect();
    assert_eq!(configs.len(), 200);
}
