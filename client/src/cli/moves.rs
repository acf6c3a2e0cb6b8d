//! `move`, `arc`, `move-axis`, `jog`, `change`, `stop`, `servo`, `home`: executes them, waits for their end and prints it.

use arcline_client::{Client, ClientError, Execution, Flag, Mnemonic, Object, Operands, SystemAxis, UnboundOperand};

use super::args::{Arc, Change, Home, Jog, Motion, Move, MoveAxis, OnOff, Servo, Stop, StopType};
use super::operands;
use super::output::counted;
use super::sweep::Sweep;
use super::wait::{self, StopCommand};
use super::{Failure, Output};

/// `move`.
pub(crate) async fn line(client: &Client, command: Move, output: &Output) -> Result<(), Failure> {
    let Move {
        system,
        position,
        dynamics,
    } = command;
    let system = system.name;
    refuse_too_many(client, &system, position.0.len()).await?;
    let length = line_length(client, &system, &position.0, dynamics.relative).await;
    let operands = operands::line(&position, &dynamics)?;
    let moved = execute(client, &system, &operands, &dynamics.motion, length, output).await;
    match moved {
        Err(failure) => Err(position_explained(client, failure, &system, position.0.len()).await),
        Ok(()) => Ok(()),
    }
}

/// `arc`.
pub(crate) async fn arc(client: &Client, command: Arc, output: &Output) -> Result<(), Failure> {
    refuse_too_many(client, &command.system.name, command.position.0.len()).await?;
    let length = arc_length(client, &command).await;
    let operands = operands::arc(&command)?;
    let motion = &command.dynamics.motion;
    let system = &command.system.name;
    let moved = execute(client, system, &operands, motion, length, output).await;
    match moved {
        Err(failure) => Err(position_explained(client, failure, system, command.position.0.len()).await),
        Ok(()) => Ok(()),
    }
}

/// Refuses more coordinates than a coordinate system has axes: the server would ignore them.
async fn refuse_too_many(client: &Client, system: &str, given: usize) -> Result<(), Failure> {
    match client.axes_of(system).await {
        Ok(axes) if given > axes.len() => Err(Failure::Usage(wrong_number(system, &axes, given))),
        Err(error) if error.is_connection() => Err(error.into()),
        // The move itself is refused with the reason.
        Ok(_) | Err(_) => Ok(()),
    }
}

fn wrong_number(system: &str, axes: &[SystemAxis], given: usize) -> String {
    let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
    let (names, axes) = (names.join(", "), counted(axes.len(), "axis"));
    let were = if given == 1 { "was" } else { "were" };
    format!("{system} has {axes} ({names}), {given} {were} given")
}

/// A refused move with its explanation: an axis in place of a coordinate system, or a wrong number of coordinates.
async fn position_explained(client: &Client, failure: Failure, system: &str, given: usize) -> Failure {
    match failure {
        Failure::Client(source @ ClientError::WrongObject { is: Object::Axis, .. }) => {
            let hint = format!("`arcline move-axis {system} POSITION` moves it");
            Failure::Hint { source, hint }
        }
        Failure::Client(source) if source.motion() == Some((OUT_OF_RANGE, POSITION)) => {
            match client.axes_of(system).await {
                Ok(axes) if axes.len() != given => {
                    let hint = wrong_number(system, &axes, given);
                    Failure::Hint { source, hint }
                }
                _ => source.into(),
            }
        }
        failure => failure,
    }
}

/// `move-axis`.
pub(crate) async fn axis(client: &Client, command: MoveAxis, output: &Output) -> Result<(), Failure> {
    let length = axis_length(client, &command).await;
    let operands = operands::axis(&command)?;
    let motion = &command.motion.motion;
    execute(client, &command.axis.name, &operands, motion, length, output).await
}

/// `jog`: waits until an instruction ends it.
pub(crate) async fn jog(client: &Client, command: Jog, output: &Output) -> Result<(), Failure> {
    let operands = operands::jog(&command)?;
    let motion = &command.motion.motion;
    execute(client, &command.axis.name, &operands, motion, None, output).await
}

/// `change`.
pub(crate) async fn change(client: &Client, command: Change, output: &Output) -> Result<(), Failure> {
    let operands = operands::change(&command)?;
    let execution = client
        .execute(Mnemonic::Mccd, &command.system.name, "", operands.as_slice())
        .await?;
    output.execution(&execution, &execution.control);
    Ok(())
}

/// `stop`: a coordinate system, an axis, or everything.
pub(crate) async fn stop(client: &Client, command: Stop, output: &Output) -> Result<(), Failure> {
    let tags = client.browse().await?;
    let of = |object| {
        let tags = tags.iter().filter(move |tag| tag.object() == Some(object));
        tags.map(|tag| tag.name.clone()).collect::<Vec<_>>()
    };
    let named = match &command.name {
        Some(name) => match tags.iter().find(|tag| tag.name.eq_ignore_ascii_case(name)) {
            Some(tag) => Some((tag.name.clone(), tag.object())),
            None => {
                let known = tags.iter().filter(|tag| tag.object().is_some());
                return Err(ClientError::unknown_tag(name, known.map(|tag| &tag.name)).into());
            }
        },
        None => None,
    };
    let (systems, axes) = match named {
        Some((system, Some(Object::CoordinateSystem))) => (vec![system], Vec::new()),
        Some((axis, Some(Object::Axis))) => (Vec::new(), vec![axis]),
        None | Some((_, Some(Object::MotionGroup))) => (of(Object::CoordinateSystem), of(Object::Axis)),
        Some((name, None)) => {
            let tag = client.tag(&name).await?;
            return Err(Failure::WrongType {
                name,
                type_name: tag.type_name(),
                expected: "an axis, a coordinate system or the motion group",
            });
        }
    };
    let kind = match command.kind {
        StopType::All => 0,
        StopType::Move => 2,
        StopType::Transform => 3,
    };
    let operands = Operands::full_speed(Mnemonic::Mcs).with("Stop Type", UnboundOperand::Integer(kind))?;
    // All of them begin to stop before the first wait.
    let mut executions = Vec::new();
    for system in &systems {
        let stop = client.execute(Mnemonic::Mcs, system, "", operands.as_slice()).await;
        // Where everything is to stop, a coordinate system that cannot move does not count.
        let cannot_move = |error: &ClientError| error.motion().is_some_and(|(err, _)| err == SERVO_OFF);
        if command.name.is_some() || !stop.as_ref().is_err_and(cannot_move) {
            executions.push((system.clone(), stop));
        }
    }
    if !systems.is_empty() {
        executions.extend(stop_others(client, &axes, command.kind).await?);
    } else {
        let kind = match command.kind {
            StopType::All => 0,
            StopType::Move => 2,
            StopType::Transform => {
                let axis = axes.join(" ");
                return Err(Failure::Usage(format!(
                    "{axis} is an axis: --type transform stops coordinate systems"
                )));
            }
        };
        let operands = Operands::full_speed(Mnemonic::Mas).with("Stop Type", UnboundOperand::Integer(kind))?;
        for axis in &axes {
            let stop = client.execute(Mnemonic::Mas, axis, "", operands.as_slice()).await;
            executions.push((axis.clone(), stop));
        }
    }
    let wait = async |execution: &Execution| {
        let completed = wait::complete(client, execution, None, output).await?;
        output.completed(execution, &completed);
        Ok(())
    };
    each(executions, wait, output).await
}

/// Stops the motion of single-axis instructions, kind by kind, so that a stopping coordinate system continues to brake
/// on its path.
async fn stop_others(
    client: &Client,
    axes: &[String],
    what: StopType,
) -> Result<Vec<(String, Result<Execution, ClientError>)>, ClientError> {
    if what == StopType::Transform || axes.is_empty() {
        return Ok(Vec::new());
    }
    let paths: Vec<&str> = axes.iter().map(String::as_str).collect();
    let mut executions = Vec::new();
    for (axis, reading) in axes.iter().zip(client.read_many(&paths).await?) {
        let reading = reading?;
        for (member, kind) in SINGLE_AXIS {
            if reading.flag(member) && (what == StopType::All || *kind == MOVE) {
                let operands = Operands::full_speed(Mnemonic::Mas).with("Stop Type", UnboundOperand::Integer(*kind))?;
                let stop = client.execute(Mnemonic::Mas, axis, "", operands.as_slice()).await;
                executions.push((axis.clone(), stop));
            }
        }
    }
    Ok(executions)
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
        executions.push((axis.clone(), client.execute(mnemonic, axis, "", &[]).await));
    }
    let wait = async |execution: &Execution| {
        output.execution(execution, &execution.control);
        Ok(())
    };
    each(executions, wait, output).await
}

/// `home`. Ctrl-C stops all of the axes.
pub(crate) async fn home(client: &Client, command: Home, output: &Output) -> Result<(), Failure> {
    // All of them begin before the first wait.
    let mut executions = Vec::new();
    for axis in &command.axes {
        executions.push((axis.clone(), client.execute(Mnemonic::Mah, axis, "", &[]).await));
    }
    let started = executions.iter().filter_map(|(_, execution)| execution.as_ref().ok());
    let stops: Vec<_> = started
        .filter_map(|execution| StopCommand::all(Object::Axis, execution.target.clone()))
        .collect();
    let wait = async |execution: &Execution| {
        let control = if command.waiting.no_wait {
            execution.control
        } else {
            tokio::select! {
                control = client.wait_for(execution, Flag::Pc, wait::FOREVER) => control?,
                () = wait::interrupted() => return Err(wait::interrupt(client, stops.clone(), output).await),
            }
        };
        output.execution(execution, &control);
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

/// Finishes all executions, reports each failure, and fails at the end if there was one.
async fn each(
    executions: Vec<(String, Result<Execution, ClientError>)>,
    then: impl AsyncFn(&Execution) -> Result<(), Failure>,
    output: &Output,
) -> Result<(), Failure> {
    let (all, mut failures) = (executions.len(), Vec::new());
    for (target, execution) in executions {
        let result = match execution {
            Ok(execution) => then(&execution).await,
            Err(source) if source.motion().is_some() && all > 1 => Err(Failure::On { target, source }),
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

/// Executes a move and waits for its end, except with `--no-wait`. `length`: of its path in position units, for the progress.
async fn execute(
    client: &Client,
    target: &str,
    operands: &Operands,
    motion: &Motion,
    length: Option<f64>,
    output: &Output,
) -> Result<(), Failure> {
    let tag = motion.tag.as_deref().unwrap_or_default();
    let execution = client
        .execute(operands.mnemonic(), target, tag, operands.as_slice())
        .await?;
    let completed = if motion.waiting.no_wait {
        execution.control.into()
    } else {
        wait::complete(client, &execution, length, output).await?
    };
    output.completed(&execution, &completed);
    Ok(())
}

/// The distance of an axis from its present position to the target, for the progress only; `None` when it is not known.
async fn axis_length(client: &Client, command: &MoveAxis) -> Option<f64> {
    if command.shortest || command.positive || command.negative {
        return None;
    }
    if command.relative {
        return Some(command.position.abs());
    }
    let start = client
        .read_numbers(&format!("{}.ActualPosition", command.axis.name))
        .await
        .ok()?;
    Some((command.position - start.first()?).abs())
}

/// Length of an arc from the present position, for the progress only; `None` when it is not known, as for a move
/// that the server will refuse.
async fn arc_length(client: &Client, command: &Arc) -> Option<f64> {
    let start = client
        .read_numbers(&format!("{}.ActualPosition", command.system.name))
        .await
        .ok()?;
    Sweep::new(&start, command)?.length()
}

/// Distance from the present position; `None` when that is not known.
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

/// Whether the command waits for the end of an execution: the execution has a PC.
pub(crate) fn is_waited_for(execution: &Execution) -> bool {
    execution.completes() && !execution.control.has(Flag::Pc)
}

/// Status bits of an axis that is moved by single-axis instructions, and the Stop Type of MAS that ends each.
const SINGLE_AXIS: &[(&str, i64)] = &[
    ("JogStatus", 1),
    ("MoveStatus", MOVE),
    ("GearingStatus", 3),
    ("HomingStatus", 4),
    ("TimeCamStatus", 7),
    ("PositionCamStatus", 8),
];
/// MAS, Stop Type: Move.
const MOVE: i64 = 2;
/// ERR of a stop of axes whose drives are off.
const SERVO_OFF: i16 = 5;
/// ERR of an operand out of range, and the operand Position of MCLM and MCCM.
const OUT_OF_RANGE: i16 = 13;
const POSITION: i8 = 3;
