//! Tasks that wait for events: a bit of an axis, the data of a module, a time without one.

use super::{expect, set, started, tags};
use crate::source::{Access, MemberSource, ProgramSource, Project, TaskSource, Trigger, TypeSource};
use crate::{FindingKind, NoMachine, load};

/// A task for each trigger; its program counts in the tag of its name.
fn project(triggers: &[(&str, &str, &str, Option<f64>)]) -> Project {
    let programs = triggers.iter().map(|(name, ..)| ProgramSource {
        name: (*name).to_owned(),
        main: Some("Go".to_owned()),
        fault: None,
        is_disabled: false,
        tags: Vec::new(),
        routines: vec![super::routine(
            "Go",
            &format!("ADD(N{name},1,N{name});\nGSV(Task,THIS,Status,S{name});"),
        )],
    });
    let tasks = triggers.iter().map(|(name, trigger, tag, timeout)| TaskSource {
        event_tag: (*tag).to_owned(),
        ..TaskSource::new(*name, Trigger::Event((*trigger).to_owned(), *timeout), &[name])
    });
    let names = triggers.iter().map(|(name, ..)| format!("N{name} DINT, S{name} DINT"));
    let text = format!("Axis Events, In DINT[4], {}", names.collect::<Vec<_>>().join(","));
    let bit = |name: &str| MemberSource {
        name: name.to_owned(),
        data_type: "BOOL".to_owned(),
        dimensions: Vec::new(),
        access: Access::ReadWrite,
    };
    Project {
        types: vec![TypeSource {
            name: "Events".to_owned(),
            is_string: false,
            members: [
                "HomeEventStatus",
                "WatchEventStatus",
                "RegEvent1Status",
                "RegEvent2Status",
            ]
            .map(bit)
            .into(),
        }],
        tags: tags(&text),
        programs: programs.collect(),
        tasks: tasks.collect(),
        ..Project::default()
    }
}

#[test]
fn a_task_runs_when_its_event_comes() {
    #[rustfmt::skip]
    let triggers = [
        ("Home",   "Axis Home",                      "Axis", None),
        ("Watch",  "Axis Watch",                     "Axis", None),
        ("First",  "Axis Registration 1",            "Axis", None),
        ("Second", "Axis Registration 2",            "Axis", None),
        ("Input",  "Module Input Data State Change", "In",   None),
        ("Late",   "Axis Watch",                     "Axis", Some(50.0)),
        ("Never",  "EVENT Instruction Only",         "",     None),
    ];
    let project = project(&triggers);
    let mut cell = started("events", &project);
    #[rustfmt::skip]
    let steps = [
        // why,                        tags to set,              counts afterwards: Home Watch First Second Input Late
        ("nothing has come",           "",                       [0, 0, 0, 0, 0, 0]),
        ("a bit becomes true",         "Axis.HomeEventStatus=1", [1, 0, 0, 0, 0, 0]),
        ("a bit that stays",           "",                       [1, 0, 0, 0, 0, 0]),
        ("two tasks of one event",     "Axis.WatchEventStatus=1", [1, 1, 0, 0, 0, 1]),
        ("a bit becomes false",        "Axis.WatchEventStatus=0", [1, 1, 0, 0, 0, 1]),
        ("registration",               "Axis.RegEvent1Status=1", [1, 1, 1, 0, 0, 1]),
        ("the other registration",     "Axis.RegEvent2Status=1", [1, 1, 1, 1, 0, 1]),
        ("data of a module",           "In[3]=7",                [1, 1, 1, 1, 1, 1]),
        ("50 ms without an event",     "",                       [1, 1, 1, 1, 1, 2]),
    ];
    for (tick, (why, text, counts)) in (0..).zip(steps) {
        if !text.is_empty() {
            set(why, &mut cell, &project, text);
        }
        cell.tick(tick, 10_000_000, &mut NoMachine).expect("no fault");
        for ((name, ..), count) in triggers.iter().zip(counts) {
            expect(
                &format!("{why}, {name}"),
                &mut cell,
                &project,
                &format!("N{name}={count}"),
            );
        }
        expect(why, &mut cell, &project, "NNever=0");
    }
    expect("the timeout is in the status", &mut cell, &project, "SLate=2");
}

#[test]
fn an_event_that_nothing_gives_is_named() {
    #[rustfmt::skip]
    let cases = [
        ("no such axis",    "Axis Home",     "Nowhere", "the trigger Axis Home of \"Nowhere\" is not supported, only EVENT runs it"),
        ("a consumed tag",  "Consumed Tag",  "In",      "the trigger Consumed Tag of \"In\" is not supported, only EVENT runs it"),
    ];
    for (why, trigger, tag, reason) in cases {
        let findings = load(&project(&[("Go", trigger, tag, None)]), &mut NoMachine).findings;
        let found: Vec<_> = findings.iter().map(|one| (one.kind, one.reason.as_str())).collect();
        assert_eq!(found, [(FindingKind::Task, reason)], "{why}");
    }
}
