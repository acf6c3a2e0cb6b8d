//! `move`, `arc`, `change`, `stop`, `servo`: options become operands by their faceplate names.

use arcline_client::{Client, ClientError, Execution, Flag, Given, Mnemonic, Object, Operands};

use super::args::{Arc, Change, Circle, Direction, Dynamics, Move, OnOff, Point, Rate, Servo, Stop, StopType};
use super::sweep::Sweep;
use super::wait::{self, Course};
use super::{Failure, Output};

/// Units per second (squared), the word 0 of every units operand.
const UNITS: i64 = 0;
/// Percent of the maximum.
const PERCENT: i64 = 1;

/// `move`.
pub(crate) async fn line(client: &Client, command: Move, output: &Output) -> Result<(), Failure> {
    let Move {
        system,
        position,
        dynamics,
    } = command;
    let length = line_length(client, &system, &position.0, dynamics.relative).await;
    let operands = line_operands(&position, &dynamics)?;
    execute(client, &system, &operands, &dynamics, Course { length }, output).await
}

/// `arc`.
pub(crate) async fn arc(client: &Client, command: Arc, output: &Output) -> Result<(), Failure> {
    let length = arc_length(client, &command).await;
    let operands = arc_operands(&command)?;
    execute(
        client,
        &command.system,
        &operands,
        &command.dynamics,
        Course { length },
        output,
    )
    .await
}

/// `change`.
pub(crate) async fn change(client: &Client, command: Change, output: &Output) -> Result<(), Failure> {
    let operands = change_operands(&command)?;
    let execution = client
        .execute(Mnemonic::Mccd, &command.system, "", operands.given())
        .await?;
    output.execution(&execution, &execution.control);
    Ok(())
}

/// `stop`.
pub(crate) async fn stop(client: &Client, command: Stop, output: &Output) -> Result<(), Failure> {
    let kind = match command.kind {
        StopType::All => 0,
        StopType::Move => 2,
        StopType::Transform => 3,
    };
    let operands = Operands::full_speed(Mnemonic::Mcs).with("Stop Type", Given::Integer(kind))?;
    let systems = match command.system {
        Some(system) => vec![system],
        None => client.objects(Object::CoordinateSystem).await?,
    };
    // All are told to stop before the first is waited for.
    let mut executions = Vec::new();
    for system in &systems {
        executions.push(client.execute(Mnemonic::Mcs, system, "", operands.given()).await);
    }
    let wait = async |execution: &Execution| {
        let control = wait::complete(client, execution, Course::default(), output).await?;
        output.execution(execution, &control);
        Ok(())
    };
    each(executions, wait, output).await
}

/// `servo`.
pub(crate) async fn servo(client: &Client, command: Servo, output: &Output) -> Result<(), Failure> {
    let mnemonic = if command.state == OnOff::On {
        Mnemonic::Mso
    } else {
        Mnemonic::Msf
    };
    let axes = if command.all {
        drives(client).await?
    } else {
        command.axes
    };
    let mut executions = Vec::new();
    for axis in &axes {
        executions.push(client.execute(mnemonic, axis, "", &[]).await);
    }
    let wait = async |execution: &Execution| {
        output.execution(execution, &execution.control);
        Ok(())
    };
    each(executions, wait, output).await
}

/// Axes that have a drive.
async fn drives(client: &Client) -> Result<Vec<String>, ClientError> {
    let tags = client.browse().await?.into_iter();
    let axes = tags.filter(|tag| tag.object() == Some(Object::Axis) && tag.type_name() != "AXIS_VIRTUAL");
    Ok(axes.map(|axis| axis.name).collect())
}

/// Goes through all of them, tells what failed, and fails in the end when one did.
async fn each(
    executions: Vec<Result<Execution, ClientError>>,
    then: impl AsyncFn(&Execution) -> Result<(), Failure>,
    output: &Output,
) -> Result<(), Failure> {
    let (all, mut failures) = (executions.len(), Vec::new());
    for execution in executions {
        let result = match execution {
            Ok(execution) => then(&execution).await,
            Err(error) => Err(error.into()),
        };
        match result {
            Ok(()) => {}
            Err(failure @ Failure::Interrupted) => return Err(failure),
            Err(failure) if failure.client().is_some_and(ClientError::is_connection) => return Err(failure),
            Err(failure) => failures.push(failure),
        }
    }
    let count = failures.len();
    match (failures.pop(), all) {
        (None, _) => Ok(()),
        (Some(only), 1) => Err(only),
        (Some(last), _) => {
            failures
                .into_iter()
                .chain([last])
                .for_each(|failure| output.failure(&failure));
            Err(Failure::Several { count })
        }
    }
}

/// Executes a move and waits for its end.
async fn execute(
    client: &Client,
    system: &str,
    operands: &Operands,
    dynamics: &Dynamics,
    course: Course,
    output: &Output,
) -> Result<(), Failure> {
    let tag = dynamics.tag.as_deref().unwrap_or_default();
    let execution = client
        .execute(operands.mnemonic(), system, tag, operands.given())
        .await?;
    let control = if dynamics.no_wait {
        execution.control
    } else {
        wait::complete(client, &execution, course, output).await?
    };
    output.execution(&execution, &control);
    Ok(())
}

/// Length of an arc from where the system stands, for the progress only; `None` when it cannot be told, as for a move
/// that the server will refuse.
async fn arc_length(client: &Client, command: &Arc) -> Option<f64> {
    let start = client
        .read_numbers(&format!("{}.ActualPosition", command.system))
        .await
        .ok()?;
    Sweep::new(&start, command)?.length()
}

/// Distance from where the system stands; `None` when that is not known.
async fn line_length(client: &Client, system: &str, end: &[f64], relative: bool) -> Option<f64> {
    let mut sum = 0.0;
    let start = if relative {
        None
    } else {
        Some(client.read_numbers(&format!("{system}.ActualPosition")).await.ok()?)
    };
    for (axis, end) in end.iter().enumerate() {
        let start = start
            .as_ref()
            .and_then(|start| start.get(axis))
            .copied()
            .unwrap_or_default();
        sum += (end - start).powi(2);
    }
    Some(sum.sqrt())
}

fn line_operands(position: &Point, dynamics: &Dynamics) -> Result<Operands, ClientError> {
    let operands = Operands::full_speed(Mnemonic::Mclm).with("Position", position.0.clone())?;
    with_dynamics(operands, dynamics)
}

fn arc_operands(command: &Arc) -> Result<Operands, ClientError> {
    let Arc {
        position,
        circle,
        direction,
        full,
        dynamics,
        ..
    } = command;
    let (circle_type, point) = match circle {
        Circle { via: Some(point), .. } => (0, point.0.clone()),
        Circle {
            center: Some(point), ..
        } => (1, point.0.clone()),
        Circle {
            radius: Some(radius), ..
        } => (2, vec![*radius]),
        Circle {
            center_offset: Some(point),
            ..
        } => (3, point.0.clone()),
        // The arguments do not parse without one of them.
        Circle { .. } => (0, Vec::new()),
    };
    let Direction { ccw, longest, .. } = direction;
    let direction = i64::from(*ccw || *longest) + if *full { 2 } else { 0 };
    let operands = Operands::full_speed(Mnemonic::Mccm)
        .with("Position", position.0.clone())?
        .with("Circle Type", Given::Integer(circle_type))?
        .with("Via/Center/Radius", point)?
        .with("Direction", Given::Integer(direction))?;
    with_dynamics(operands, dynamics)
}

fn with_dynamics(mut operands: Operands, dynamics: &Dynamics) -> Result<Operands, ClientError> {
    let Dynamics {
        relative,
        speed,
        accel,
        decel,
        trapezoid,
        termination,
        merge,
        ..
    } = dynamics;
    operands = operands.with("Move Type", Given::Integer(i64::from(*relative)))?;
    operands = with_rate(operands, "Speed", "Speed Units", *speed)?;
    operands = with_rate(operands, "Accel Rate", "Accel Units", *accel)?;
    operands = with_rate(operands, "Decel Rate", "Decel Units", *decel)?;
    if *trapezoid {
        operands = operands.with("Profile", Given::Integer(0))?;
    }
    for (name, value) in [("Termination Type", termination), ("Merge", merge)] {
        if let Some(value) = value {
            operands = operands.with(name, Given::Integer(i64::from(*value)))?;
        }
    }
    Ok(operands)
}

fn change_operands(command: &Change) -> Result<Operands, ClientError> {
    let Change {
        speed,
        accel,
        decel,
        pending,
        ..
    } = command;
    let mut operands = Operands::full_speed(Mnemonic::Mccd).with("Scope", Given::Integer(i64::from(*pending)))?;
    for (flag, name, units, rate) in [
        ("Change Speed", "Speed", "Speed Units", speed),
        ("Change Accel", "Accel Rate", "Accel Units", accel),
        ("Change Decel", "Decel Rate", "Decel Units", decel),
    ] {
        operands = operands.with(flag, Given::Integer(i64::from(rate.is_some())))?;
        operands = with_rate(operands, name, units, *rate)?;
    }
    Ok(operands)
}

fn with_rate(operands: Operands, name: &str, units: &str, rate: Option<Rate>) -> Result<Operands, ClientError> {
    match rate {
        None => Ok(operands),
        Some(Rate::Units(value)) => operands.with(name, value)?.with(units, Given::Integer(UNITS)),
        Some(Rate::Percent(value)) => operands.with(name, value)?.with(units, Given::Integer(PERCENT)),
    }
}

/// Whether an execution is waited for: it has a PC.
pub(crate) fn is_waited_for(execution: &Execution) -> bool {
    execution.completes() && !execution.control.has(Flag::Pc)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn operand(operands: &Operands, name: &str) -> Given {
        let instruction = operands.mnemonic().instruction();
        let place = instruction.operand(name).expect("an operand");
        let index = instruction
            .given_operands()
            .position(|given| given == place)
            .expect("a given operand");
        operands.given()[index].clone()
    }

    fn number(operands: &Operands, name: &str) -> f64 {
        match operand(operands, name) {
            Given::Number(number) => number,
            Given::Integer(number) => number as f64,
            other => panic!("{name} is {other}"),
        }
    }

    #[test]
    fn a_plain_move_is_a_full_speed_s_curve() {
        let operands = line_operands(&Point(vec![1.0, 2.0]), &Dynamics::default()).expect("operands");
        assert_eq!(operand(&operands, "Position"), Given::Array(vec![1.0, 2.0]));
        for (name, value) in [
            ("Move Type", 0.0),
            ("Speed", 100.0),
            ("Speed Units", 1.0),
            ("Accel Units", 1.0),
            ("Profile", 1.0),
            ("Accel Jerk", 100.0),
            ("Jerk Units", 2.0),
            ("Termination Type", 0.0),
            ("Merge", 0.0),
        ] {
            assert_eq!(number(&operands, name), value, "{name}");
        }
    }

    #[test]
    fn options_set_operands() {
        let dynamics = Dynamics {
            relative: true,
            speed: Some(Rate::Units(50.0)),
            accel: Some(Rate::Percent(20.0)),
            trapezoid: true,
            termination: Some(1),
            merge: Some(2),
            ..Dynamics::default()
        };
        let operands = line_operands(&Point(vec![1.0]), &dynamics).expect("operands");
        for (name, value) in [
            ("Move Type", 1.0),
            ("Speed", 50.0),
            ("Speed Units", 0.0),
            ("Accel Rate", 20.0),
            ("Accel Units", 1.0),
            ("Decel Rate", 100.0),
            ("Decel Units", 1.0),
            ("Profile", 0.0),
            ("Termination Type", 1.0),
            ("Merge", 2.0),
        ] {
            assert_eq!(number(&operands, name), value, "{name}");
        }
    }

    #[test]
    fn arcs_take_one_circle_and_one_direction() {
        let point = || Some(Point(vec![5.0, 0.0]));
        #[rustfmt::skip]
        let cases = [
            // circle,                                          direction,                          full,  type, direction
            (Circle { via: point(), ..Circle::default() },           Direction::default(),               false, 0.0, 0.0),
            (Circle { center: point(), ..Circle::default() },        Direction { ccw: true, ..Direction::default() }, false, 1.0, 1.0),
            (Circle { radius: Some(-3.0), ..Circle::default() },     Direction { longest: true, ..Direction::default() }, true, 2.0, 3.0),
            (Circle { center_offset: point(), ..Circle::default() }, Direction { cw: true, ..Direction::default() }, true, 3.0, 2.0),
        ];
        for (circle, direction, full, circle_type, expected) in cases {
            let (system, position) = ("XY".to_owned(), Point(vec![10.0, 0.0]));
            let command = Arc {
                system,
                position,
                circle,
                direction,
                full,
                dynamics: Dynamics::default(),
            };
            let operands = arc_operands(&command).expect("operands");
            assert_eq!(number(&operands, "Circle Type"), circle_type, "{command:?}");
            assert_eq!(number(&operands, "Direction"), expected, "{command:?}");
        }
    }

    #[test]
    fn a_change_changes_only_what_is_named() {
        let (speed, accel, decel) = (Some(Rate::Percent(20.0)), None, Some(Rate::Units(300.0)));
        let command = Change {
            system: "CS1".to_owned(),
            speed,
            accel,
            decel,
            pending: true,
        };
        let operands = change_operands(&command).expect("operands");
        for (name, value) in [
            ("Motion Type", 1.0),
            ("Change Speed", 1.0),
            ("Speed", 20.0),
            ("Speed Units", 1.0),
            ("Change Accel", 0.0),
            ("Change Decel", 1.0),
            ("Decel Rate", 300.0),
            ("Decel Units", 0.0),
            ("Scope", 1.0),
        ] {
            assert_eq!(number(&operands, name), value, "{name}");
        }
    }
}
