//! `mode`: the mode of the controller's program.

use std::time::Duration;

use serde_json::json;

use arcline_client::{Client, ControllerMode};

use super::args::{Mode, ModeWord};
use super::{Failure, Output};

/// Shows the mode, or changes it and waits until the program has taken it.
pub(crate) async fn mode(client: &Client, command: &Mode, output: &Output) -> Result<(), Failure> {
    let wanted = command.mode.map(|word| match word {
        ModeWord::Run => ControllerMode::Run,
        ModeWord::Program => ControllerMode::Program,
    });
    if let Some(wanted) = wanted
        && let Err(source) = client.set_controller_mode(wanted).await
    {
        return Err(match client.controller_mode().await {
            Ok(ControllerMode::None) => Failure::Hint {
                source,
                hint: "the server runs no program, as `arcline-server run PROJECT.L5X` does".to_owned(),
            },
            _ => source.into(),
        });
    }
    let mut mode = client.controller_mode().await?;
    for _ in 0..MOST_READS {
        if wanted.is_none_or(|wanted| mode == wanted || mode == ControllerMode::Faulted) {
            break;
        }
        tokio::time::sleep(PAUSE).await;
        mode = client.controller_mode().await?;
    }
    let fault = client.major_fault().await?;
    let text = match &fault {
        Some(fault) => format!("{}: {fault}", mode.word()),
        None => mode.word().to_owned(),
    };
    output.result(&text, || json!({"mode": mode.word(), "major_fault": fault}));
    Ok(())
}

/// The program takes a mode between two scans; a scan ends within its watchdog.
const MOST_READS: usize = 250;
const PAUSE: Duration = Duration::from_millis(20);
