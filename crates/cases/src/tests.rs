//! Cases and batches.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use crate::worker::Worker;
use crate::{Batch, BatchError, DEFECT, Defaults, Done, Finished, Other, finished};

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
        behind: None,
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
            ..Done::default()
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
        "\n[]\n",
        "\n",
        &case(MOVE, ""),
    ]
    .concat();
    let (results, done) = results(&batch(2), &lines);
    assert_eq!(
        done,
        Done {
            results: 16,
            invalid: 14,
            ..Done::default()
        }
    );
    #[rustfmt::skip]
    let expected = [
        "finished", "line 3: expected", "line 4: unknown field `progam`", "line 5: program is a file", "line 6: expected a program",
        "line 7: no/such/file.st: cannot be read", "line 8: the program: line 1, column 5: there is no axis `XX`",
        "line 9: set axis.XX.max_speed: there is no axis \"XX\"", "line 10: ", "line 11: set Move1.Sped: ",
        "line 12: there is no fault \"overcurent\", did you mean \"overcurrent\"?", "line 13: faults[0].at: expected", "line 14: until is -1",
        "line 15: the line is longer", "line 16: expected a JSON object", "finished",
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

/// What a file of results has; the first is to be that of case 5.
fn finished_from_5(text: &str) -> Result<Finished, Other> {
    finished(text.as_bytes(), 5).expect("memory can be read")
}

#[test]
fn a_file_of_results_is_gone_on_with_behind_its_last_whole_line() {
    let lines =
        "{\"case\":5,\"end\":\"invalid\"}\n{\"case\":6}\n{\"case\":7,\"end\":\"finished\",\"trace_error\":\"\"}\n";
    assert_eq!(finished_from_5("").expect("empty"), Finished::default());
    let three = finished_from_5(lines).expect("three");
    let done = Done {
        results: 3,
        invalid: 1,
        untraced: 1,
        ..Done::default()
    };
    assert_eq!((three.done, three.bytes), (done, lines.len() as u64));
    for torn in ["{\"case\":8,\"en", "{\"ca", "{"] {
        assert_eq!(finished_from_5(&format!("{lines}{torn}")), Ok(three.clone()), "{torn}");
    }
    for (text, line, expected) in [
        ("{\"case\":6}\n", 1, 5),
        ("{\"case\":5}\n{\"case\":5}\n", 2, 6),
        ("not JSON\n", 1, 5),
        ("a text of one line without end", 1, 5),
    ] {
        assert_eq!(finished_from_5(text), Err(Other::Line { line, expected }), "{text}");
    }
}

#[test]
fn a_batch_goes_on_behind_its_own_results_only() {
    let cases = [
        case(MOVE, ",\"id\":1"),
        case(MOVE, ",\"id\":2"),
        "{}\n".to_owned(),
        case(MOVE, ",\"id\":4"),
    ];
    let lines = cases.concat();
    let run = |defaults: &Arc<Defaults>, lines: &str, from, to, behind: Option<Finished>| {
        let mut output = Vec::new();
        let part = Batch {
            defaults: defaults.clone(),
            from,
            to,
            behind,
            ..batch(1)
        };
        let done = part.run(lines.as_bytes(), &mut output, &mut |_| true)?;
        Ok::<_, BatchError>((String::from_utf8(output).expect("JSON is UTF-8"), done))
    };
    let defaults = batch(1).defaults;
    // Behind a result of a case that ran, and behind one that did not.
    for count in [2, 3] {
        let (text, _) = run(&defaults, &lines, 0, Some(count), None).expect("it runs");
        let behind = finished(text.as_bytes(), 0).expect("readable").expect("results");
        let resumed = |defaults: &Arc<Defaults>, lines: &str| {
            let ran = run(defaults, lines, count, None, Some(behind.clone()));
            ran.map_err(|error| error.to_string())
        };
        let (rest, _) = resumed(&defaults, &lines).expect("it goes on");
        assert_eq!(rest.lines().count() as u64, 4 - count);
        let other = |change: fn(&mut Defaults)| {
            let mut other = (*defaults).clone();
            change(&mut other);
            Arc::new(other)
        };
        let other_id = lines.replace("\"id\":2", "\"id\":\"two\"");
        let short = cases[..1].concat();
        let other_text = lines.replace("[10, 5, 0]", "[11, 5, 0]");
        let other_seed = other(|defaults| defaults.seed += 1);
        let other_machine =
            other(|defaults| defaults.set = vec![("axis.X.max_speed".to_owned(), "50".parse().expect("a value"))]);
        let all = count == 2;
        #[rustfmt::skip]
        let rows = [
            ("as before",         &defaults,      &lines,      None),
            ("another seed",      &other_seed,    &lines,      all.then_some("seed 101, expected 102")),
            ("another machine",   &other_machine, &lines,      all.then_some("config")),
            ("another program",   &defaults,      &other_text, all.then_some("program")),
            ("another id",        &defaults,      &other_id,   all.then_some("id 2, expected \"two\"")),
            ("too few cases",     &defaults,      &short,      Some("no such case")),
        ];
        for (why, defaults, lines, expected) in rows {
            match (resumed(defaults, lines), expected) {
                (Ok(_), None) => {}
                (Err(error), Some(expected)) => assert!(error.contains(expected), "{why}: {error}"),
                (resumed, expected) => panic!("{why}: {resumed:?}, expected {expected:?}"),
            }
        }
    }
    let old = "{\"case\":0,\"id\":1,\"version\":\"0.0.1\"}\n";
    let behind = finished(old.as_bytes(), 0).expect("readable").expect("a result");
    let error = run(&defaults, &lines, 1, None, Some(behind)).expect_err("of another version");
    assert!(error.to_string().contains("version 0.0.1"), "{error}");
}

#[test]
fn a_panic_is_the_result_of_its_case() {
    let lines: String = (0..10).map(|id| case("DELAY(0);", &format!(",\"id\":{id}"))).collect();
    let run_line = |worker: &mut Worker, number: u64, line: u64, text: &str| {
        assert!(number != 3, "case {number}");
        worker.run_line(number, line, text)
    };
    let mut output = Vec::new();
    let done = batch(2).run_with(lines.as_bytes(), &mut output, &mut |_| true, &run_line);
    let done = done.expect("it ends");
    assert_eq!((done.results, done.invalid, done.defects), (10, 0, 1));
    let again = finished(output.as_slice(), 0).expect("readable").expect("results");
    assert_eq!(again.done, done, "a batch that is continued counts it too");
    let text = String::from_utf8(output).expect("JSON is UTF-8");
    for (number, line) in text.lines().enumerate() {
        let result: Value = serde_json::from_str(line).expect("a result is JSON");
        assert_eq!((&result["case"], &result["id"]), (&number.into(), &number.into()));
        let expected = if number == 3 { DEFECT } else { "finished" };
        assert_eq!(result["end"], expected, "{line}");
        if number == 3 {
            assert_eq!(result["error"], "line 4: a defect of Arcline: case 3");
        }
    }
}

#[test]
fn numbers_that_are_too_large_are_refused() {
    for (first, from) in [(u64::MAX - 1, 0), ((1 << 53) + 1, 0), (0, u64::MAX)] {
        let batch = Batch {
            first,
            from,
            ..batch(1)
        };
        let ran = batch.run(&b"{}\n{}\n{}\n"[..], std::io::sink(), &mut |_| true);
        let error = ran.expect_err("too large").to_string();
        assert!(error.contains("expected at most 9007199254740992"), "{error}");
    }
    let last = Batch {
        first: 1 << 53,
        ..batch(1)
    };
    assert_eq!(results(&last, &case(MOVE, "")).0[0]["case"], 1_u64 << 53);
}

#[test]
fn each_case_has_a_trace_of_its_own_and_never_standard_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let traced = |name: &str| case("DELAY(0);", &format!(",\"trace\":{}", Value::from(name)));
    let same = folder.path().join(".").join("a.csv").display().to_string();
    let lines = [
        traced("-"),
        traced(&at("a.csv")),
        traced(&at("{case}.csv")),
        traced(&same),
        traced(&at("{case}.csv")),
        traced(&at("b.csv")),
        traced("/dev/full"),
    ]
    .concat();
    for jobs in [1, 3] {
        let (results, done) = results(&batch(jobs), &lines);
        let ends: Vec<_> = results
            .iter()
            .map(|result| result["end"].as_str().unwrap_or_default())
            .collect();
        #[rustfmt::skip]
        assert_eq!(ends, ["invalid", "finished", "finished", "invalid", "finished", "finished", "finished"]);
        let error = |number: usize| results[number]["error"].as_str().unwrap_or_default().to_owned();
        assert!(error(0).contains("line 1: trace is -, expected a file"), "{}", error(0));
        assert!(
            error(3).contains("line 4: trace: an earlier case has written"),
            "{}",
            error(3)
        );
        // It ran, and its trace is not there.
        let lost = results[6]["trace_error"].as_str().expect("it says so");
        assert!(
            lost.contains("cannot be written") && results[6]["hash"].is_string(),
            "{lost}"
        );
        assert_eq!((done.invalid, done.untraced), (2, 1));
        assert!(
            ["a.csv", "2.csv", "4.csv", "b.csv"]
                .iter()
                .all(|name| Path::new(&at(name)).exists())
        );
    }
    // The same cases are refused where only a part is run.
    let part = Batch { from: 3, ..batch(1) };
    assert_eq!(results(&part, &lines).1.invalid, 1);
    let one = Batch {
        defaults: Arc::new(Defaults {
            trace: Some(at("all.csv")),
            ..Defaults::default()
        }),
        ..batch(1)
    };
    let ran = one.run(lines.as_bytes(), std::io::sink(), &mut |_| true);
    assert!(matches!(ran, Err(BatchError::Trace(_))), "{ran:?}");
}

#[test]
fn more_machines_and_programs_than_a_worker_keeps_all_run() {
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
