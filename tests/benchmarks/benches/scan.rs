//! The scan of the controller's own program: `cargo bench -p arcline-benchmarks --bench scan`.
//!
//! Goals (issue "the machine's own program"): 20 million simple instructions a second and core, which is 50 ns for each; a project of
//! 1,000 rungs on a task of 2 ms within 4 µs of each scan and its ticks, 500 times real time. `throughput` counts instructions, also of rungs that
//! would change nothing and are passed over; "looked at" is the same scan while a page shows the routine, which executes all. "One second of" is what
//! `simulate` does, with the ticks of the default machine: 2 ms are 500 times real time.
#![allow(missing_docs)]

use std::hint::black_box;

use arcline_cell::{RunLimits, SimulatedCell, UnknownParts};
use arcline_routine::source::{
    Content, ProgramSource, Project, RoutineSource, RungSource, TagSource, TaskSource, Trigger,
};
use arcline_routine::{Cell, NoMachine, load};
use arcline_simulation::Blind;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const RUNGS: usize = 1000;
const PERIOD: u64 = 2_000_000;

/// A ladder routine on a task of 2 ms; `rung` makes the text of each rung.
fn project(rung: impl Fn(usize) -> String) -> Project {
    // The default machine has axes with names of one letter.
    let names = [("B[", "Bits["), ("D[", "Dints["), ("R[", "Reals["), ("T[", "Timers[")];
    let long = |text: String| names.iter().fold(text, |text, (short, long)| text.replace(short, long));
    let rungs = (0..RUNGS).map(|number| RungSource {
        number: number as u32,
        kind: "N".to_owned(),
        text: long(rung(number)),
        comment: String::new(),
    });
    Project {
        tags: vec![
            TagSource::new("Bits", "BOOL", [1024], None),
            TagSource::new("Dints", "DINT", [1024], None),
            TagSource::new("Reals", "REAL", [1024], None),
            TagSource::new("Timers", "TIMER", [64], None),
            TagSource::new("X", "AXIS_CIP_DRIVE", [], None),
            TagSource::new("There", "MOTION_INSTRUCTION", [], None),
            TagSource::new("Home", "MOTION_INSTRUCTION", [], None),
            TagSource::new("Back", "BOOL", [], None),
            TagSource::new("Edge", "BOOL", [], None),
            TagSource::new("HomeEdge", "BOOL", [], None),
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
    }
}

fn cell(project: &Project) -> Cell {
    let loaded = load(project, &mut NoMachine);
    assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("no fault");
    cell
}

fn bench(c: &mut Criterion) {
    type Text = fn(usize) -> String;
    #[rustfmt::skip]
    let kinds: [(&str, u64, Text); 4] = [
        // name, instructions of a rung, its text
        ("contacts and coils", 6, |k| format!("XIC(B[{k}])XIO(B[{}])[XIC(B[{}]) ,XIO(B[{}]) ]XIO(B[{}])OTE(B[{}]);", (k + 7) % 1000, (k + 11) % 1000, (k + 13) % 1000, (k + 17) % 1000, (k + 1) % 1000)),
        ("arithmetic", 4, |k| format!("ADD(D[{k}],1,D[{k}])GRT(D[{k}],5)MUL(D[{k}],3,D[{}])MOV(D[{k}],R[{k}]);", (k + 1) % 1000)),
        ("a mixed project", 5, |k| match k % 5 {
            0 => format!("XIO(T[{}].DN)TON(T[{}],?,?)XIC(B[{k}])XIO(B[1])OTE(B[{}]);", k % 64, k % 64, k % 1000),
            1 => format!("XIC(B[{k}])EQU(D[{k}],3)ADD(D[{k}],1,D[{k}])LES(D[{k}],100)MOV(D[{k}],D[{}]);", (k + 3) % 1000),
            2 => format!("XIC(B[{k}])[OTL(B[{}]) ,OTU(B[{}]) ]XIC(B[2])OTE(B[{k}]);", (k + 1) % 1000, (k + 2) % 1000),
            3 => format!("LIM(0,D[{k}],50)CPT(R[{k}],R[{k}]*0.5+1.25)XIC(B[{k}])XIO(B[{}])OTE(B[{k}]);", (k + 9) % 1000),
            _ => format!("XIC(B[{k}])ONS(B[{}])ADD(D[{k}],1,D[{k}])NEQ(D[{k}],7)SUB(D[{k}],1,D[{}]);", (k + 5) % 1000, (k + 6) % 1000),
        }),
        ("a machine that waits, with 50 running timers", 5, |k| match k % 20 {
            0 => format!("XIO(B[{k}])TON(T[{0}],?,?)XIC(T[{0}].DN)OTE(B[{1}]);", k / 20, k + 1),
            // The timer of the next 20 rungs runs for ever.
            18 => format!("MOV(2000000000,T[{}].PRE);", k / 20 + 1),
            n if n % 2 == 0 => format!("XIC(B[{k}])XIO(B[{}])[XIC(B[{}]) ,OTE(B[{k}]) ]OTE(B[{k}]);", k + 1, k + 3),
            _ => format!("XIC(B[{}])GRT(D[{k}],3)ADD(D[{k}],1,D[{k}])LES(D[{k}],9)MOV(D[{k}],R[{k}]);", k - 1),
        }),
    ];
    let moving = |k: usize| MOVER.get(k).map_or_else(|| kinds[3].2(k), |rung| (*rung).to_owned());
    simulated(c, "a machine that moves, with 50 running timers", &project(moving));
    for (name, instructions, text) in kinds {
        let mut group = c.benchmark_group("1,000 rungs");
        group.throughput(Throughput::Elements(instructions * RUNGS as u64));
        for (looked_at, words) in [(false, name.to_owned()), (true, format!("{name}, looked at"))] {
            let mut cell = cell(&project(text));
            if looked_at {
                cell.trace([0]);
            }
            let mut tick = 0;
            group.bench_function(words, |b| {
                b.iter(|| {
                    tick += 1;
                    black_box(cell.tick(tick, PERIOD, &mut NoMachine)).expect("no fault");
                });
            });
        }
        group.finish();
        simulated(c, name, &project(text));
    }
}

/// What `simulate` does with a project.
fn simulated(c: &mut Criterion, name: &str, project: &Project) {
    let mut group = c.benchmark_group("1,000 rungs and the default machine, one second of");
    let machine = arcline_config::load(arcline_config::DEFAULT, "default.toml").expect("the default configuration");
    let simulated = SimulatedCell::load(&machine, project.clone(), UnknownParts::Refused);
    let mut simulated = simulated.expect("it runs");
    simulated.begin(&mut Blind).expect("no fault");
    let second = RunLimits {
        until: None,
        ticks: 1000,
        time: f64::INFINITY,
    };
    group.bench_function(name, |b| b.iter(|| black_box(simulated.run(second, &mut Blind))));
}

/// Rungs that move an axis to and fro.
const MOVER: [&str; 4] = [
    "XIO(Back)XIO(There.IP)XIO(Home.IP)MAM(X,There,0,100,150,Units per sec,2000,Units per sec2,2000,Units per sec2,S-Curve,100,100,% of Time,Disabled,Programmed,0,None);",
    "XIC(Back)XIO(There.IP)XIO(Home.IP)MAM(X,Home,0,0,150,Units per sec,2000,Units per sec2,2000,Units per sec2,S-Curve,100,100,% of Time,Disabled,Programmed,0,None);",
    "XIC(There.PC)ONS(Edge)OTL(Back);",
    "XIC(Home.PC)ONS(HomeEdge)OTU(Back);",
];

criterion_group!(benches, bench);
criterion_main!(benches);
