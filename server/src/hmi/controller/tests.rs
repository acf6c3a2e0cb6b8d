//! The cost of 1,000 rungs that pages show: the operands that a sample evaluates, the bytes of its pushes, and the time of both.

use std::sync::Arc;

use arcline_realtime::thread_time;
use arcline_routine::source::{Content, ProgramSource, RoutineSource, RungSource, TagSource, TaskSource};
use arcline_routine::{Cell, Monitor, NoMachine, load};

use super::*;

/// Rungs of the routine, and those of one page: ten pages show all of them.
const RUNGS: usize = 1000;
const MONITORED: usize = PAGE;
const PERIOD: u64 = 2_000_000;
/// Samples a second (`SHOW_EVERY` of `live`).
const A_SECOND: f64 = 5.0;
/// Ticks between two samples.
const TICKS: u64 = 100;

/// A rung of a mixed project: timers, compares, branches, arithmetic.
fn rung(k: usize) -> String {
    match k % 5 {
        0 => format!(
            "XIO(T[{}].DN)TON(T[{}],?,?)XIC(B[{k}])XIO(B[1])OTE(B[{k}]);",
            k % 64,
            k % 64
        ),
        1 => format!(
            "XIC(B[{k}])EQU(D[{k}],3)ADD(D[{k}],1,D[{k}])LES(D[{k}],100)MOV(D[{k}],D[{}]);",
            (k + 3) % RUNGS
        ),
        2 => format!(
            "XIC(B[{k}])[OTL(B[{}]) ,OTU(B[{}]) ]XIC(B[2])OTE(B[{k}]);",
            (k + 1) % RUNGS,
            (k + 2) % RUNGS
        ),
        3 => format!(
            "LIM(0,D[{k}],50)CPT(R[{k}],R[{k}]*0.5+1.25)ADD(D[{k}],1,D[{k}])XIO(B[{}])OTE(B[{k}]);",
            (k + 9) % RUNGS
        ),
        _ => format!("ADD(D[{k}],1,D[{k}])NEQ(D[{k}],7)SUB(D[{k}],2,D[{}]);", (k + 5) % RUNGS),
    }
}

/// The project with a number of these rungs.
fn cell(rungs: usize) -> (Cell, Arc<Listing>) {
    let rungs = (0..rungs).map(|number| RungSource {
        number: number as u32,
        kind: "N".to_owned(),
        text: rung(number),
        comment: String::new(),
    });
    let project = Project {
        tags: vec![
            TagSource::new("B", "BOOL", [1024], None),
            TagSource::new("D", "DINT", [1024], None),
            TagSource::new("R", "REAL", [1024], None),
            TagSource::new("T", "TIMER", [64], None),
        ],
        programs: vec![ProgramSource {
            name: "Main".to_owned(),
            main: Some("Go".to_owned()),
            fault: None,
            is_disabled: false,
            tags: Vec::new(),
            routines: vec![RoutineSource {
                name: "Go".to_owned(),
                content: Content::Ladder(rungs.collect()),
            }],
        }],
        tasks: vec![TaskSource::new("Task", Trigger::Periodic(2.0), &["Main"])],
        ..Project::default()
    };
    let loaded = load(&project, &mut NoMachine);
    assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("no fault");
    (cell, Arc::new(Listing::new(project, loaded.names, loaded.findings)))
}

/// A page that watches 100 rungs.
fn page(listing: &Arc<Listing>, from: usize) -> (Monitor, MonitorUpdates) {
    let monitor = listing.monitor(0, from, MONITORED, None);
    let updates = MonitorUpdates {
        routine: 0,
        from,
        sent: Vec::new(),
        samples: watch::Sender::new(Vec::new()).subscribe(),
    };
    (monitor, updates)
}

/// The cost of one sample of all monitored rungs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Cost {
    /// Digits of power flow and values.
    elements: usize,
    /// Rows and bytes of the pushes.
    rows: usize,
    bytes: usize,
}

fn sample(cell: &mut Cell, pages: &mut [(Monitor, MonitorUpdates)]) -> Cost {
    let mut cost = Cost::default();
    for (monitor, updates) in pages {
        let newest = cell.sample(monitor);
        cost.elements += newest
            .iter()
            .map(|row| row.power.len() + row.values.len())
            .sum::<usize>();
        let rows = updates.news(newest);
        if rows.is_empty() {
            continue;
        }
        cost.rows += rows.len();
        cost.bytes += text_of(&Push::Look {
            routine: updates.routine,
            rows,
        })
        .len();
    }
    cost
}

/// Ten pages show all rungs of a routine of 1,000. The counts are exact: a change of the code that costs more shows here first.
#[test]
fn a_thousand_rungs_that_are_monitored() {
    let (mut cell, listing) = cell(RUNGS);
    let mut pages: Vec<_> = (0..RUNGS).step_by(MONITORED).map(|from| page(&listing, from)).collect();
    cell.trace([0]);
    let mut tick = 0;
    let mut run = |cell: &mut Cell| {
        for _ in 0..TICKS {
            tick += 1;
            cell.tick(tick, PERIOD, &mut NoMachine).expect("no fault");
        }
    };
    run(&mut cell);
    let first = sample(&mut cell, &mut pages);
    let same = sample(&mut cell, &mut pages);
    let mut then = Vec::new();
    for _ in 0..10 {
        run(&mut cell);
        then.push(sample(&mut cell, &mut pages));
    }
    let most = then.iter().map(|cost| cost.bytes).max().unwrap_or_default();
    println!("{first:?} where every rung has changed, {:?} then", then[9]);
    // Digits and values: 13.8 a rung. A page that comes is sent all of its rungs, and then those that have changed.
    let elements = 13_800;
    assert_eq!((first.elements, first.rows), (elements, RUNGS));
    assert_eq!(
        (same.elements, same.rows, same.bytes),
        (elements, 0, 0),
        "nothing has changed"
    );
    assert!(
        then.iter().all(|cost| (cost.elements, cost.rows) == (elements, 400)),
        "{then:?}"
    );
    assert!(
        first.bytes <= 82 * RUNGS && most <= 36 * RUNGS,
        "{first:?}, then {most} bytes"
    );
    // The time where every rung changes. Other work on the computer only adds, through caches and cores that are shared.
    let mut least = f64::INFINITY;
    for _ in 0..20 {
        run(&mut cell);
        for (_, updates) in &mut pages {
            updates.sent.clear();
        }
        let began = thread_time();
        assert_eq!(sample(&mut cell, &mut pages).rows, RUNGS);
        least = least.min((thread_time() - began).as_secs_f64());
    }
    let share = least * A_SECOND;
    println!("{:.2} ms a sample: {:.2} % of a core", least * 1e3, share * 1e2);
    assert!(share <= 0.05, "{:.1} % of a core", share * 1e2);
}

/// A page of 100 rungs costs the same, however long their routine is.
#[test]
fn rungs_without_a_viewer_cost_nothing() {
    let costs = [MONITORED, RUNGS].map(|rungs| {
        let (mut cell, listing) = cell(rungs);
        cell.trace([0]);
        cell.tick(1, PERIOD, &mut NoMachine).expect("no fault");
        sample(&mut cell, &mut [page(&listing, 0)])
    });
    // The bytes differ, since other rungs write the values that these show.
    for cost in costs {
        assert_eq!((cost.elements, cost.rows), (1_380, MONITORED), "{costs:?}");
    }
}
