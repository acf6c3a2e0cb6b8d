//! The controller's own program for a viewer: the text of its routines, its state, the uses of a tag, and the routine that a viewer watches
//! while the program runs.

use arcline_routine::source::{Project, Trigger};
use arcline_routine::{Finding, Line, ListedElement, ListedRoutine, Listing, MonitorSample, MonitoredValue};
use arcline_tag::{FloatsOnly, TagValue, Value as Scalar};
use serde_json::Value;

use super::protocol::{
    AddOnRow, ControllerFault, ControllerState, ControllerStatus, ForceRow, Look, MonitorRow, PassedOver, ProgramRow,
    Push, Refusal, RoutineList, RoutinePage, RoutineRow, Rung, RungElement, RungOperand, TaskRow, TextLine, UseList,
    UseRow, text_of,
};
use crate::plant::control::ViewerId;
use crate::plant::{Command, Force, Plant, Principal, Program, ProgramState};
use crate::watch;

/// Rungs or lines of one request.
const PAGE: usize = 100;
/// Uses of a tag.
const USES: usize = 500;
/// Parts that do not run.
const MOST_PASSED_OVER: usize = 200;
/// The longest name of a tag, bytes.
const NAME: usize = 500;

fn program(plant: &Plant) -> Result<&Program, Refusal> {
    let program = plant.program().map(|program| &**program);
    program.ok_or_else(|| Refusal::new("the controller has no program of its own"))
}

/// The state of the program; `None`: the controller has none.
pub(super) fn status(plant: &Plant) -> Option<Box<ControllerStatus>> {
    let program = plant.program()?;
    let status = program.status();
    let (_, listing) = program.listing();
    let fault = status.fault.map(|fault| {
        let (owner, name) = fault
            .routine
            .split_once('.')
            .unwrap_or((&fault.program, &fault.routine));
        let (Line::Rung(line) | Line::Text(line)) = fault.place;
        let (operand, value) = fault.operand.clone().unzip();
        ControllerFault {
            text: fault.to_string(),
            routine: listing.routine(owner, name),
            line,
            instruction: fault.instruction.clone(),
            operand,
            value,
        }
    });
    let forces = program.forces.all().into_iter().map(|force| ForceRow {
        tag: force.name,
        value: number(force.value),
    });
    Some(Box::new(ControllerStatus {
        mode: program.mode().word(),
        state: match status.state {
            ProgramState::Stopped => ControllerState::Stopped,
            ProgramState::Running => ControllerState::Running,
            ProgramState::Faulted(_) => ControllerState::Faulted,
        },
        version: status.version,
        scans: status.scans,
        last_us: status.last_us,
        longest_us: status.longest_us,
        fault,
        forces: forces.collect(),
    }))
}

/// Tasks, programs and routines.
pub(super) fn routines(plant: &Plant) -> Result<RoutineList, Refusal> {
    let program = program(plant)?;
    let (version, listing) = program.listing();
    let all = listing.routines();
    let rows = |owner: &str, is_add_on: bool| -> Vec<RoutineRow> {
        let own = all
            .iter()
            .filter(|one| one.owner == owner && one.is_add_on == is_add_on);
        own.map(routine_row).collect()
    };
    let project = listing.project();
    let programs = project.programs.iter().map(|one| ProgramRow {
        name: one.name.clone(),
        main: one.main.clone(),
        fault: one.fault.clone(),
        disabled: one.is_disabled,
        routines: rows(&one.name, false),
    });
    let add_ons = project.instructions.iter().map(|one| AddOnRow {
        name: one.name.clone(),
        instances: listing.instances(&one.name),
        routines: rows(&one.name, true),
    });
    Ok(RoutineList {
        version,
        file: program.status().file,
        tasks: tasks(project),
        programs: programs.collect(),
        add_ons: add_ons.collect(),
        passed_over: listing
            .findings()
            .iter()
            .take(MOST_PASSED_OVER)
            .map(|finding| passed_over(&listing, finding))
            .collect(),
        passed_over_count: listing.findings().len(),
    })
}

fn passed_over(listing: &Listing, finding: &Finding) -> PassedOver {
    let owner = finding.program.as_deref();
    let routine = finding.routine.as_deref();
    PassedOver {
        text: finding.what(),
        place: finding.position(),
        routine: owner
            .zip(routine)
            .and_then(|(owner, name)| listing.routine(owner, name)),
        number: finding.place.map(|line| match line {
            Line::Rung(number) | Line::Text(number) => number,
        }),
    }
}

fn tasks(project: &Project) -> Vec<TaskRow> {
    let rows = project.tasks.iter().map(|task| TaskRow {
        name: task.name.clone(),
        trigger: match &task.trigger {
            Trigger::Continuous => "continuous".to_owned(),
            Trigger::Periodic(ms) => format!("every {ms} ms"),
            Trigger::Event(event, None) => format!("event: {event}"),
            Trigger::Event(event, Some(ms)) => format!("event: {event}, or {ms} ms without one"),
        },
        priority: task.priority,
        watchdog_ms: task.watchdog_ms,
        inhibited: task.is_inhibited,
        programs: task.programs.clone(),
    });
    rows.collect()
}

fn routine_row(routine: &ListedRoutine<'_>) -> RoutineRow {
    use arcline_routine::Language;
    RoutineRow {
        routine: routine.number,
        name: routine.name.to_owned(),
        language: match routine.language {
            Language::Ladder => "ladder".to_owned(),
            Language::Text => "text".to_owned(),
            Language::Other(words) => words.to_owned(),
        },
        count: routine.count,
    }
}

/// Rungs or lines as they are written.
pub(super) fn rungs(plant: &Plant, routine: u32, from: usize, count: usize) -> Result<RoutinePage, Refusal> {
    let (version, listing) = program(plant)?.listing();
    check_count(count)?;
    let rungs = listing.rungs(routine, from, count).into_iter().map(|rung| Rung {
        number: rung.number,
        comment: rung.comment,
        elements: rung.elements.into_iter().map(element).collect(),
    });
    let lines = listing.lines(routine, from, count).into_iter().map(|line| TextLine {
        number: line.number,
        text: line.text,
        names: line.names,
    });
    Ok(RoutinePage {
        version,
        rungs: rungs.collect(),
        lines: lines.collect(),
    })
}

fn check_count(count: usize) -> Result<(), Refusal> {
    if count > PAGE {
        return Err(Refusal::new(format!("{count} rungs, at most {PAGE} are possible")));
    }
    Ok(())
}

fn element(element: ListedElement) -> RungElement {
    match element {
        ListedElement::Instruction {
            name,
            title,
            operands,
            condition,
        } => {
            let operands = operands.into_iter().map(|one| RungOperand {
                name: one.name,
                text: one.text,
            });
            RungElement {
                condition,
                name,
                title,
                operands: operands.collect(),
                legs: Vec::new(),
            }
        }
        ListedElement::Branch { legs, condition } => {
            let legs = legs.into_iter().map(|leg| leg.into_iter().map(self::element).collect());
            RungElement {
                condition,
                name: String::new(),
                title: String::new(),
                operands: Vec::new(),
                legs: legs.collect(),
            }
        }
    }
}

/// The uses of a tag in the routines of the controller's own program.
pub(super) fn uses(plant: &Plant, tag: &str, program: Option<&str>) -> Result<UseList, Refusal> {
    let (_, listing) = self::program(plant)?.listing();
    if tag.len() > NAME {
        return Err(Refusal::new(format!(
            "the name has {} bytes, at most {NAME} are possible",
            tag.len()
        )));
    }
    let (tag, found) = listing
        .uses(tag, program, USES + 1)
        .map_err(|error| Refusal::new(format!("{tag}: {error}")))?;
    let more = found.len() > USES;
    let uses = found.into_iter().take(USES).map(|one| UseRow {
        routine: one.routine,
        line: one.line.to_string(),
        index: one.index,
        instruction: one.instruction,
        operand: one.operand,
        writes: one.is_written,
    });
    Ok(UseList {
        tag,
        uses: uses.collect(),
        more,
    })
}

/// Forces an input, or removes its force.
pub(super) async fn force(plant: &Plant, by: Principal, tag: &str, value: &Value) -> Result<(), Refusal> {
    let value = match value {
        Value::Null => None,
        Value::Bool(on) => Some(Scalar::Bool(*on)),
        Value::Number(number) => Some(match number.as_i64() {
            Some(whole) => Scalar::Lint(whole),
            None => Scalar::Lreal(number.as_f64().unwrap_or_default()),
        }),
        _ => {
            return Err(Refusal::new(
                "expected a number, true, false, or null to remove the force",
            ));
        }
    };
    let work = |transaction: &mut crate::plant::Transaction<'_>| match value {
        None => transaction.apply(Command::RemoveForce(Some(tag))),
        Some(value) => {
            let force = Force::new(transaction.image(), tag, value).map_err(crate::plant::Refused::from)?;
            transaction.apply(Command::Force(&force))
        }
    };
    let (done, _) = plant.transact(by, work);
    done?;
    Ok(())
}

/// The rungs or lines that a viewer watches, and the samples that it has received.
pub(super) struct MonitorUpdates {
    routine: u32,
    from: usize,
    sent: Vec<MonitorSample>,
    samples: watch::Receiver<Vec<MonitorSample>>,
}

/// Begins to watch the rungs or lines that a request names; `None`: the viewer watches nothing.
pub(super) fn monitor(plant: &Plant, viewer: ViewerId, request: &Look) -> Result<Option<MonitorUpdates>, Refusal> {
    let program = program(plant)?;
    let Some(routine) = request.routine else {
        program.monitors.end(viewer);
        return Ok(None);
    };
    check_count(request.count)?;
    let (version, listing) = program.listing();
    if version != request.version {
        return Err(Refusal::new("another program was loaded: read its routines again"));
    }
    let monitor = Listing::monitor(
        &listing,
        routine,
        request.from,
        request.count,
        request.instance.as_deref(),
    );
    Ok(Some(MonitorUpdates {
        routine,
        from: request.from,
        sent: Vec::new(),
        samples: program.monitors.begin(viewer, version, monitor),
    }))
}

/// A viewer stops watching.
pub(super) fn leave(plant: &Plant, viewer: ViewerId) {
    if let Some(program) = plant.program() {
        program.monitors.end(viewer);
    }
}

impl MonitorUpdates {
    /// Waits for samples, and gives the push of the rows that have changed; for ever, when the program was replaced.
    pub(super) async fn changed(&mut self) -> String {
        if self.samples.changed().await.is_err() {
            std::future::pending::<()>().await;
        }
        let newest = self.samples.borrow_and_update().clone();
        let rows = self.news(newest);
        text_of(&Push::Look {
            routine: self.routine,
            rows,
        })
    }

    /// The rows that differ from those that the viewer has received.
    fn news(&mut self, newest: Vec<MonitorSample>) -> Vec<MonitorRow> {
        let before = |row: usize| self.sent.get(row);
        let rows = newest
            .iter()
            .enumerate()
            .filter(|(row, now)| before(*row) != Some(*now));
        let rows = rows.map(|(row, now)| MonitorRow {
            index: self.from + row,
            power: now.power.clone(),
            values: now.values.iter().map(shown).collect(),
        });
        let rows = rows.collect();
        self.sent = newest;
        rows
    }
}

fn shown(value: &MonitoredValue) -> Value {
    match value {
        MonitoredValue::Nothing => Value::Null,
        MonitoredValue::Bool(on) => (*on).into(),
        MonitoredValue::Whole(whole) => number(Scalar::Lint(*whole)),
        MonitoredValue::Real(real) => number(Scalar::Lreal(*real)),
        MonitoredValue::Text(text) => text.clone().into(),
    }
}

fn number(value: Scalar) -> Value {
    serde_json::to_value(FloatsOnly(&TagValue::Value(value))).unwrap_or_default()
}

#[cfg(test)]
mod tests;
