//! `watch`: the state of the machine again and again, with the mover of each object and a STOP that holds. On a terminal a full screen with
//! the path of a coordinate system; otherwise, or with `--json`, a line for each object whenever something of it has changed.
//!
//! `status` reads the objects and has their words; `screen` draws the screen.

mod screen;
mod view;

use std::time::Duration;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use serde_json::json;
use tokio::time::Instant;

use arcline_client::{Client, Object};

use super::args::Watch;
use super::status::{Kind, ObjectStatus, StatusQuery};
use super::wait::{self, StopCommand};
use super::{Failure, Output};
use view::View;

/// Said while STOP holds.
const INHIBITED: &str = "STOP holds: motion is inhibited until `arcline release`";
/// Time between two reads of the keyboard.
const KEYS: Duration = Duration::from_millis(20);

/// `watch`.
pub(crate) async fn watch(client: &Client, command: &Watch, output: &Output) -> Result<(), Failure> {
    let query = StatusQuery::find(client, &command.of.names).await?;
    // Both are finite and positive: the arguments do not parse otherwise.
    let interval = Duration::from_secs_f64(command.interval);
    let end = command
        .duration
        .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    if !output.is_watched() {
        return lines(client, &query, interval, end, output).await;
    }
    let mut terminal = ratatui::try_init().map_err(Failure::Terminal)?;
    let result = full_screen(client, &query, interval, end, &mut terminal).await;
    ratatui::restore();
    result
}

/// A line for each object that has changed, with the time since the first look.
async fn lines(
    client: &Client,
    query: &StatusQuery,
    interval: Duration,
    end: Option<Instant>,
    output: &Output,
) -> Result<(), Failure> {
    let began = Instant::now();
    let mut last: Vec<ObjectStatus> = Vec::new();
    // The row of the motion group shows it too, where that is watched.
    let mut was_inhibited = query.of(Kind::Group).next().is_none().then_some(false);
    loop {
        let next = Instant::now() + interval;
        let shown = query.read(client).await?;
        let seconds = began.elapsed().as_secs_f64();
        if let Some(was) = &mut was_inhibited {
            let is_inhibited = query.is_inhibited(client).await?;
            if is_inhibited != *was {
                let text = if is_inhibited { INHIBITED } else { "motion is released" };
                output.result(
                    format!("{seconds:.3}  {text}"),
                    || json!({"kind": "machine", "motion_inhibited": is_inhibited, "time_s": seconds}),
                );
            }
            *was = is_inhibited;
        }
        for (index, one) in shown.iter().enumerate() {
            // The counters of the thread change always.
            let same = last
                .get(index)
                .is_some_and(|last| last.row_with_mover() == one.row_with_mover());
            if same || one.kind == Kind::RealTime && !last.is_empty() {
                continue;
            }
            output.result(format!("{seconds:.3}  {}", one.row_with_mover().join("  ")), || {
                let mut object = one.object.clone();
                object["time_s"] = seconds.into();
                object
            });
        }
        last = shown;
        if end.is_some_and(|end| next >= end) {
            return Ok(());
        }
        tokio::select! {
            () = tokio::time::sleep_until(next) => {}
            () = wait::interrupted() => return Ok(()),
        }
    }
}

async fn full_screen(
    client: &Client,
    query: &StatusQuery,
    interval: Duration,
    end: Option<Instant>,
    terminal: &mut DefaultTerminal,
) -> Result<(), Failure> {
    let began = Instant::now();
    let mut view = View::new();
    loop {
        let next = Instant::now() + interval;
        if !view.paused {
            let shown = query.read(client).await?;
            view.is_inhibited = query.is_inhibited(client).await?;
            view.take(shown, began.elapsed().as_secs_f64());
        }
        loop {
            terminal
                .draw(|frame| screen::draw(&view, frame))
                .map_err(Failure::Terminal)?;
            match key(&mut view)? {
                Asked::Nothing => {}
                Asked::End => return Ok(()),
                Asked::Stop => view.note = stop(client, query).await?,
            }
            if end.is_some_and(|end| Instant::now() >= end) {
                return Ok(());
            }
            let now = Instant::now();
            if now >= next {
                break;
            }
            tokio::time::sleep(KEYS.min(next - now)).await;
        }
    }
}

/// The effect of a key beyond the view itself.
enum Asked {
    Nothing,
    End,
    Stop,
}

fn key(view: &mut View) -> Result<Asked, Failure> {
    while event::poll(Duration::ZERO).map_err(Failure::Terminal)? {
        let Event::Key(key) = event::read().map_err(Failure::Terminal)? else {
            continue;
        };
        if key.kind == KeyEventKind::Release {
            continue;
        }
        match key.code {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return Ok(Asked::End),
            KeyCode::Char('q') => return Ok(Asked::End),
            KeyCode::Char('s') | KeyCode::Esc => return Ok(Asked::Stop),
            KeyCode::Char('p') => view.paused = !view.paused,
            KeyCode::Char('c') => view.clear(),
            KeyCode::Tab => view.next_system(),
            _ => {}
        }
    }
    Ok(Asked::Nothing)
}

/// Stops every watched coordinate system, then every watched axis. Returns a report.
async fn stop(client: &Client, query: &StatusQuery) -> Result<String, Failure> {
    let mut failed = Vec::new();
    let mut stopped = Vec::new();
    for (kind, object) in [(Kind::System, Object::CoordinateSystem), (Kind::Axis, Object::Axis)] {
        for name in query.of(kind) {
            let Some(stopping) = StopCommand::all(object, name.to_owned()) else {
                continue;
            };
            match stopping.begin(client).await {
                Ok(_) => stopped.push(name),
                Err(error) if error.is_connection() => return Err(error.into()),
                Err(error) => failed.push(format!("{name}: {error}")),
            }
        }
    }
    let stopped = stopped.join(" ");
    Ok(match failed.first() {
        None => format!("stop: {stopped}"),
        Some(first) => format!("stop: {stopped}; {first}"),
    })
}
