//! `fault inject`, `fault clear`, `fault list`.

use std::time::{Duration, Instant};

use serde_json::json;

use arcline_client::{Client, ClientError, FaultSet, Flag, Mnemonic, Object, TagValue, shown_faults};

use super::args::{FaultClear, FaultInject, FaultList};
use super::output::table;
use super::status::{AXIS_FAULTS, words};
use super::{Failure, Output};

/// `fault inject`.
pub(crate) async fn inject(client: &Client, command: &FaultInject, output: &Output) -> Result<(), Failure> {
    let axis = &command.axis.name;
    let (kind, word) = (command.kind, command.kind.fault().word);
    if !client.possible_faults(axis).await?.contains(kind) {
        return Err(Failure::NoSuchFault {
            axis: axis.clone(),
            fault: word,
        });
    }
    let causes = client.injected_faults(axis).await?.with(kind);
    client.inject_faults(axis, causes).await?;
    output.result(format!("{axis}: {word} injected"), || injection(axis, causes));
    Ok(())
}

/// `fault clear`: the causes, then the faults (MAFR). An axis that still brakes because of them is waited for: until it is at rest, no
/// instruction is accepted on it.
pub(crate) async fn clear(client: &Client, command: &FaultClear, output: &Output) -> Result<(), Failure> {
    let axis = &command.axis.name;
    let left = match command.kind {
        Some(kind) => client
            .injected_faults(axis)
            .await?
            .without(FaultSet::default().with(kind)),
        None => FaultSet::default(),
    };
    client.inject_faults(axis, left).await?;
    let execution = client.execute(Mnemonic::Mafr, axis, "", &[]).await?;
    client.wait_for(&execution, Flag::Dn, DONE).await?;
    let end = Instant::now() + DONE;
    while state(&client.read(axis).await?) == ABORTING && Instant::now() < end {
        tokio::time::sleep(LOOK_AGAIN).await;
    }
    output.result(format!("{axis}: faults cleared"), || injection(axis, left));
    Ok(())
}

/// `fault list`.
pub(crate) async fn list(client: &Client, command: &FaultList, output: &Output) -> Result<(), Failure> {
    let axes = if command.axes.is_empty() {
        client.objects(Object::Axis).await?
    } else {
        command.axes.clone()
    };
    let mut rows = Vec::new();
    for axis in &axes {
        let injected = match client.injected_faults(axis).await {
            // A server whose tag `FaultInject` has another meaning.
            Err(ClientError::Refused { .. }) => FaultSet::default(),
            injected => injected?,
        };
        let reading = client.read(axis).await?;
        let faults = names(shown_faults(&reading));
        // A virtual axis shows only that it has a fault.
        let faults = if faults.is_empty() {
            words(&reading, AXIS_FAULTS)
                .split_whitespace()
                .map(str::to_owned)
                .collect()
        } else {
            faults
        };
        let state = state(&reading);
        if output.is_json() {
            output.result(
                "",
                || json!({"name": axis, "faults": faults, "injected": names(injected), "state": state}),
            );
        }
        let or_none = |words: &[String]| {
            if words.is_empty() {
                "none".to_owned()
            } else {
                words.join(" ")
            }
        };
        rows.push(vec![
            axis.clone(),
            or_none(&faults),
            or_none(&names(injected)),
            state.to_owned(),
        ]);
    }
    if !output.is_json() {
        output.result(table(&["axis", "faults", "injected", "state"], &rows), || json!(null));
    }
    Ok(())
}

/// CIPAxisState in a word (spec/axis-and-data-types.md §12); a virtual axis has none.
fn state(axis: &TagValue) -> &'static str {
    if axis.flag("ShutdownStatus") {
        return "shutdown";
    }
    match axis.member("CIPAxisState").and_then(TagValue::as_f64) {
        None => "ready",
        Some(2.0) => "stopped",
        Some(3.0) => "starting",
        Some(4.0) => "running",
        Some(6.0) => "stopping",
        Some(7.0) => ABORTING,
        Some(8.0) => "faulted",
        Some(_) => "not ready",
    }
}

fn injection(axis: &str, causes: FaultSet) -> serde_json::Value {
    json!({"name": axis, "injected": names(causes)})
}

fn names(set: FaultSet) -> Vec<String> {
    set.kinds().map(|kind| kind.fault().word.to_owned()).collect()
}

/// A reset is done within two updates, and an axis brakes within seconds.
const DONE: Duration = Duration::from_secs(10);

/// Time between two reads of an axis that brakes.
const LOOK_AGAIN: Duration = Duration::from_millis(10);

/// An axis that brakes because of a fault.
const ABORTING: &str = "aborting";
