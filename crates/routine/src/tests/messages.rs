//! MSG that a table answers (spec/programs.md §10.8).

use super::{expect, project, set, started};
use crate::NoMachine;
use crate::source::{Answer, Project};

/// A project with a message to a service, a class and an instance, whose data goes to `Data`.
fn messages(service: &str, class: &str, instance: &str, destination: &str, answers: Vec<Answer>) -> Project {
    let mut project = project(
        "M MESSAGE, Go BOOL, Data DINT[2], Small INT, After DINT",
        &[("Main", "XIC(Go)MSG(M);")],
    );
    let parameters = [
        ("ServiceCode", service),
        ("ObjectType", class),
        ("TargetObject", instance),
        ("AttributeNumber", "16#0007"),
        ("DestinationTag", destination),
        ("UnconnectedTimeout", "50000"),
    ];
    let parameters = parameters.map(|(name, value)| (name.to_owned(), value.to_owned()));
    project.tags[0].attributes = parameters.into();
    project.answers = answers;
    project
}

fn row(instance: Option<u32>, data: &[u8], delay_ms: u32, error: (u16, u32)) -> Answer {
    Answer {
        service: 0x0E,
        class: 1,
        instance,
        attribute: None,
        data: data.to_vec(),
        delay_ms,
        error,
    }
}

#[test]
fn a_table_answers_messages() {
    let bytes = [1, 0, 0, 0, 2, 0, 0, 0, 9, 9, 9, 9];
    let well = (0, 0);
    #[rustfmt::skip]
    let cases = [
        // why,                     instance, destination, rows,                                        scans, conditions after them
        ("an answer",               "1", "Data[0]", vec![row(Some(1), &bytes[..4], 0, well)],              2, "M.DN=1, M.ER=0, M.EW=0, Data[0]=1, M.DN_LEN=4, M.EN=1"),
        ("not before its delay",    "1", "Data[0]", vec![row(Some(1), &bytes[..4], 40, well)],             4, "M.DN=0, M.EN=1, M.EW=1, Data[0]=0"),
        ("after its delay",         "1", "Data[0]", vec![row(Some(1), &bytes[..4], 40, well)],             5, "M.DN=1, Data[0]=1"),
        ("an error",                "1", "Data[0]", vec![row(None, &bytes, 0, (8, 5))],                    2, "M.ER=1, M.DN=0, M.ERR=8, M.EXERR=5, Data[0]=0"),
        ("the first that fits",     "2", "Data[0]", vec![row(Some(1), &[7], 0, well), row(Some(2), &[5], 0, well), row(None, &[6], 0, well)], 2, "Data[0]=5"),
        ("into its array only",     "1", "Data[0]", vec![row(None, &bytes, 0, well)],                      2, "Data[0]=1, Data[1]=2, M.DN_LEN=8, Small=0, After=0"),
        ("from an element on",      "1", "Data[1]", vec![row(None, &bytes, 0, well)],                      2, "Data[0]=0, Data[1]=1, M.DN_LEN=4"),
        ("no destination",          "1", "",        vec![row(None, &bytes, 0, well)],                      2, "M.DN=1, M.DN_LEN=0"),
        ("nothing fits: in time",   "3", "Data[0]", vec![row(Some(1), &bytes, 0, well)],                   5, "M.DN=0, M.ER=0"),
        ("nothing fits: too late",  "3", "Data[0]", vec![row(Some(1), &bytes, 0, well)],                   7, "M.ER=1, M.ERR=1, M.EXERR=16#0204"),
    ];
    for (why, instance, destination, answers, scans, expected) in cases {
        let project = messages("16#000e", "16#0001", instance, destination, answers);
        let mut cell = started(why, &project);
        set(why, &mut cell, &project, "Go=1");
        for tick in 0..scans {
            cell.tick(tick, 10_000_000, &mut NoMachine).expect("no fault");
        }
        for text in expected.split(", ") {
            expect(why, &mut cell, &project, text);
        }
    }
}

#[test]
fn another_service_class_or_attribute_does_not_fit() {
    let mut other = row(None, &[1], 0, (0, 0));
    other.attribute = Some(8);
    let mut same = other.clone();
    same.attribute = Some(7);
    #[rustfmt::skip]
    let cases = [
        ("the service",   "16#0001", "16#0001", row(None, &[1], 0, (0, 0)), "M.DN=0"),
        ("the class",     "16#000e", "16#0002", row(None, &[1], 0, (0, 0)), "M.DN=0"),
        ("the attribute", "16#000e", "16#0001", other,                      "M.DN=0"),
        ("all the same",  "16#000e", "16#0001", same,                       "M.DN=1"),
    ];
    for (why, service, class, answer, expected) in cases {
        let project = messages(service, class, "1", "Data[0]", vec![answer]);
        let mut cell = started(why, &project);
        set(why, &mut cell, &project, "Go=1");
        for tick in 0..3 {
            cell.tick(tick, 10_000_000, &mut NoMachine).expect("no fault");
        }
        expect(why, &mut cell, &project, expected);
        // A false rung ends it, and a true one asks again.
        set(why, &mut cell, &project, "Go=0");
        cell.tick(3, 10_000_000, &mut NoMachine).expect("no fault");
        expect(
            why,
            &mut cell,
            &project,
            if expected == "M.DN=1" { "M.EN=0" } else { "M.EN=1" },
        );
    }
}
