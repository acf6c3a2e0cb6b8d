//! `move`, `arc`, `move-axis`, `jog`, `change`, `stop`, `servo`, `home`: executed, waited for, told.

use arcline_client::{Client, ClientError, Execution, Flag, Given, Mnemonic, Object, Operands};

use super::args::{Arc, Change, Home, Jog, Motion, Move, MoveAxis, OnOff, Servo, Stop, StopType};
use super::operands;
use super::sweep::Sweep;
use super::wait::{self, Course, Stopping};
use super::{Failure, Output};

/// `move`.
pub(crate) async fn line(client: &Client, command: Move, output: &Output) -> Result<(), Failure> {
    let Move {
        system,
        position,
        dynamics,
    } = command;
    let system = system.name;
    let length = line_length(client, &system, &position.0, dynamics.relative).await;
    let operands = operands::line(&position, &dynamics)?;
    execute(client, &system, &operands, &dynamics.motion, Course { length }, output).await
}

/// `arc`.
pub(crate) async fn arc(client: &Client, command: Arc, output: &Output) -> Result<(), Failure> {
    let length = arc_length(client, &command).await;
    let operands = operands::arc(&command)?;
    let motion = &command.dynamics.motion;
    execute(
        client,
        &command.system.name,
        &operands,
        motion,
        Course { length },
        output,
    )
    .await
}

/// `move-axis`.
pub(crate) async fn axis(client: &Client, command: MoveAxis, output: &Output) -> Result<(), Failure> {
    let length = axis_length(client, &command).await;
    let operands = operands::axis(&command)?;
    let motion = &command.motion.motion;
    execute(client, &command.axis.name, &operands, motion, Course { length }, output).await
}

/// `jog`: waits until something ends it.
pub(crate) async fn jog(client: &Client, command: Jog, output: &Output) -> Result<(), Failure> {
    let operands = operands::jog(&command)?;
    let motion = &command.motion.motion;
    execute(client, &command.axis.name, &operands, motion, Course::default(), output).await
}

/// `change`.
pub(crate) async fn change(client: &Client, command: Change, output: &Output) -> Result<(), Failure> {
    let operands = operands::change(&command)?;
    let execution = client
        .execute(Mnemonic::Mccd, &command.system.name, "", operands.given())
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

/// `home`. Ctrl-C stops all of the axes.
pub(crate) async fn home(client: &Client, command: Home, output: &Output) -> Result<(), Failure> {
    // All of them begin before the first is waited for.
    let mut executions = Vec::new();
    for axis in &command.axes {
        executions.push(client.execute(Mnemonic::Mah, axis, "", &[]).await);
    }
    let started = executions.iter().flatten();
    let stops: Vec<_> = started
        .filter_map(|execution| Stopping::all(Object::Axis, execution.target.clone()))
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

/// Executes a move and, unless it is not wanted, waits for the end of its course.
async fn execute(
    client: &Client,
    target: &str,
    operands: &Operands,
    motion: &Motion,
    course: Course,
    output: &Output,
) -> Result<(), Failure> {
    let tag = motion.tag.as_deref().unwrap_or_default();
    let execution = client
        .execute(operands.mnemonic(), target, tag, operands.given())
        .await?;
    let control = if motion.waiting.no_wait {
        execution.control
    } else {
        wait::complete(client, &execution, course, output).await?
    };
    output.execution(&execution, &control);
    Ok(())
}

/// How far an axis goes from where it stands, for the progress only; `None` when it cannot be told.
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

/// Length of an arc from where the system stands, for the progress only; `None` when it cannot be told, as for a move
/// that the server will refuse.
async fn arc_length(client: &Client, command: &Arc) -> Option<f64> {
    let start = client
        .read_numbers(&format!("{}.ActualPosition", command.system.name))
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

/// Whether an execution is waited for: it has a PC.
pub(crate) fn is_waited_for(execution: &Execution) -> bool {
    execution.completes() && !execution.control.has(Flag::Pc)
}
