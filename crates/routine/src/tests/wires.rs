//! Wires between tags and axes (spec/programs.md §15).

use super::motion::{Bench, Machine};
use super::project;
use crate::load;
use crate::source::{Datum, Project, TagSource, Wire};

fn wire(from: &str, to: &str, delay_ms: u32) -> Wire {
    Wire {
        from: from.to_owned(),
        to: to.to_owned(),
        delay_ms,
    }
}

/// A project with a module of 32 inputs and one of outputs. Each rung copies the input 0 to the output 3.
fn cell(wires: Vec<Wire>) -> Project {
    let mut of = project(
        "X AXIS_CIP_DRIVE, Y AXIS_CIP_DRIVE, B BOOL, N DINT, A DINT[2], Other BOOL, Break BOOL",
        &[("Main", "XIC(Local:1:I.Data.0)OTE(Local:2:O.Data.3)ADD(N,1,N);")],
    );
    let typed = |kind: &str| Datum::Typed(kind.to_owned(), Box::new(Datum::Number("0".to_owned())));
    let module = |name: &str, kind: &str, members: &[(&str, &str)]| {
        let members = members.iter().map(|(name, kind)| ((*name).to_owned(), typed(kind)));
        let value = Datum::Structure(kind.to_owned(), members.collect());
        TagSource {
            is_module: true,
            ..TagSource::new(name, kind, [], Some(value))
        }
    };
    of.tags.push(module(
        "Local:1:I",
        "AB:1756_DI:I:0",
        &[("ConnectionFaulted", "BOOL"), ("Data", "DINT")],
    ));
    of.tags.push(module("Local:2:O", "AB:1756_DO:O:0", &[("Data", "DINT")]));
    of.wires = wires;
    of
}

#[test]
fn inputs_come_before_the_scan_and_outputs_behind_it() {
    let mut bench = Bench::new(cell(vec![
        wire("X.home_switch", "Local:1:I.Data.0", 0),
        wire("Local:2:O.Data.3", "X.enable", 0),
        wire("local:2:o.data.3", "Y.registration_1", 0),
    ]));
    bench.scan(": N=0; Local:2:O.Data.3=0");
    assert_eq!(bench.machine.inputs, [(1, false), (2, false)], "first all of them");
    // In one tick from the switch through the rung to the drive.
    bench.scan("X.HomeInputStatus : Local:1:I.Data.0; N=1; Local:2:O.Data.3");
    assert_eq!(bench.machine.inputs[2..], [(1, true), (2, true)]);
    bench.scan(": N=2");
    bench.scan("X.HomeInputStatus=0 : N=2; Local:1:I.Data.0=0");
    assert_eq!(bench.machine.inputs[4..], [(1, false), (2, false)], "only what changes");
}

#[test]
fn a_delay_passes_signals_that_hold_for_its_time() {
    let mut bench = Bench::new(cell(vec![wire("B", "Local:1:I.Data.0", 20)]));
    bench.scan(": Local:1:I.Data.0=0");
    bench.scan("B : Local:1:I.Data.0=0");
    bench.scan(": Local:1:I.Data.0=0");
    bench.scan(": Local:1:I.Data.0");
    // A shorter pulse does not pass.
    bench.scan("B=0 : Local:1:I.Data.0");
    bench.scan("B : Local:1:I.Data.0");
    bench.scan(": Local:1:I.Data.0");
    bench.scan(": Local:1:I.Data.0");
    bench.scan("B=0 : Local:1:I.Data.0");
    bench.scan(": Local:1:I.Data.0");
    bench.scan(": Local:1:I.Data.0=0");
}

#[test]
fn the_first_value_passes_at_once() {
    let mut of = cell(vec![wire("B", "Local:1:I.Data.0", 5000)]);
    of.tags
        .iter_mut()
        .filter(|tag| tag.name == "B")
        .for_each(|tag| tag.value = Some(Datum::Number("1".to_owned())));
    let mut bench = Bench::new(of);
    bench.scan(": Local:1:I.Data.0; N=1");
}

#[test]
fn the_inputs_of_a_module_that_lost_its_connection_keep_their_values() {
    let mut bench = Bench::new(cell(vec![
        wire("B", "Local:1:I.Data.0", 0),
        wire("Break", "Local:1:I.ConnectionFaulted", 0),
        wire("B", "Other", 0),
    ]));
    bench.scan("B : Local:1:I.Data.0; Other");
    // The fault comes with the tick, and the tags wired behind it keep their values.
    bench.scan("Break : Local:1:I.ConnectionFaulted");
    bench.scan("B=0 : Local:1:I.Data.0; Other=0");
    bench.scan("Break=0 : Local:1:I.ConnectionFaulted=0");
    bench.scan(": Local:1:I.Data.0=0");
}

#[test]
fn a_force_has_priority_over_a_wire() {
    let mut bench = Bench::new(cell(vec![wire("B", "Local:1:I.Data.0", 0)]));
    let tag = bench.cell.tags().iter().find(|tag| tag.name == "Local:1:I").cloned();
    let tag = tag.expect("the module's tag");
    let arcline_tag::DataType::Structure(template) = &tag.tag_type.data_type else {
        panic!("{tag:?}")
    };
    let at = tag.at + template.member("Data").expect("its data").offset;
    bench.machine.forced = Some((at as usize, 1));
    bench.scan(": Local:1:I.Data.0; N=1");
    bench.machine.forced = None;
    bench.scan(": Local:1:I.Data.0=0; N=1");
}

#[test]
fn ends_that_lead_nowhere_are_named() {
    #[rustfmt::skip]
    let cases = [
        (wire("Nothing", "B", 0),                  "wire from Nothing to B: Nothing: there is no tag Nothing"),
        (wire("B", "Local:9:I.Data.0", 0),         "wire from B to Local:9:I.Data.0: Local:9:I.Data.0: there is no tag Local:9:I"),
        (wire("B", "Local:1:I.Data.32", 0),        "wire from B to Local:1:I.Data.32: Local:1:I.Data.32: DINT has 32 bits"),
        (wire("N", "B", 0),                        "wire from N to B: N: is no BOOL and no bit"),
        (wire("A[N].3", "B", 0),                   "wire from A[N].3 to B: A[N].3: has a subscript that is calculated"),
        (wire("X.ServoActionStatus", "X.DNStatus", 0), "wire from X.ServoActionStatus to X.DNStatus: X.DNStatus: AXIS_CIP_DRIVE has no member DNStatus"),
        (wire("B", "X.ServoActionStatus", 0),      "wire from B to X.ServoActionStatus: X.ServoActionStatus: is the machine's, expected a tag or X.home_switch, X.enable, X.registration_1, X.registration_2 of an axis X"),
        (wire("Z.home_switch", "B", 0),            "wire from Z.home_switch to B: Z.home_switch: there is no tag Z"),
    ];
    for (wire, expected) in cases {
        let findings = load(&cell(vec![wire]), &mut Machine::default()).findings;
        let told: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(told, [expected]);
    }
}
