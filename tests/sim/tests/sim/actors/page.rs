//! Viewers of the page: one that jogs by its button and is lost in each way in which a viewer can be, two that want to run programs, and one
//! that reads.

use std::time::Duration;

use serde_json::json;

use super::motion::LATE;
use super::tags::TAGS;
use super::{Order, Stage};
use crate::client::{Answer, NoAnswer, PATIENCE_MS};
use crate::history::WriteAnswer;
use crate::motion::Deadline;
use crate::page::Page;

/// The index of the jogger's axis.
const S: usize = 3;
/// A jog stops that long after the newest sign of its button, ms: 150, and a look every 10.
const BUTTON: u64 = 160;
/// The tag that programs write.
pub(crate) const PROGRAM_TAG: &str = "PageRun";

impl Stage {
    /// A page of its own connection.
    async fn page(&mut self) -> Answer<Page> {
        Page::open(self.browse()).await
    }
}

/// Jogs axis S by the button, and then releases it, hangs, vanishes, or closes the page.
pub(crate) async fn page_jogger(mut stage: Stage) {
    while !stage.is_over() {
        let asked = stage.now();
        match stage.page().await {
            Ok(page) => {
                if let Err(error) = jog(&mut stage, page).await {
                    stage.judge(asked, &error);
                }
            }
            Err(error) => stage.judge(asked, &error),
        }
        // Longer than any of its stops takes.
        tokio::time::sleep(Duration::from_millis(1500)).await;
    }
}

async fn jog(stage: &mut Stage, mut page: Page) -> Answer<()> {
    let taken = page.ask(json!({"do": "take", "object": "S"})).await?;
    if let Err(refused) = taken {
        // The viewer before it has vanished, and is not noticed yet.
        stage.note(&refused);
        page.leave().await;
        return Ok(());
    }
    let reset = page.ask(json!({"do": "execute", "text": "MAFR(S, PageS)"})).await?;
    let on = page.ask(json!({"do": "execute", "text": "MSO(S, PageS)"})).await?;
    stage.note(&format!("{reset:?}, {on:?}"));
    stage.order(Order::Moves(S));
    let jog = json!({"do": "jog", "axis": "S", "speed": 20.0, "accel": 1000.0, "decel": 1000.0});
    if let Err(refused) = page.ask(jog).await? {
        stage.note(&refused);
        page.leave().await;
        return Ok(());
    }
    stage.sometimes("a jog of the page");
    for _ in 0..stage.random.below(12) {
        // The server has ended it, where a sign came too late.
        if page.ask(json!({"do": "keep", "axis": "S"})).await?.is_err() {
            stage.sometimes("a sign of a jog's button comes too late");
            break;
        }
        stage.pause(90).await;
    }
    let rest = |at, why| Order::Rest(Deadline { axis: S, at, why });
    let heard = page.end().arrives_by().max(stage.now());
    match stage.random.below(4) {
        0 => {
            stage.sometimes("the button of a page is released");
            page.ask(json!({"do": "jog_end", "axis": "S"}))
                .await?
                .map_err(NoAnswer::Wrong)?;
            // A stop from 20 units/s at 1,000 units/s², or by the guard.
            stage.order(rest(stage.now() + 50 + LATE, "its button is released"));
            page.leave().await;
        }
        1 => {
            stage.sometimes("a page hangs");
            stage.order(rest(heard + BUTTON + LATE, "its page hangs"));
            tokio::time::sleep(Duration::from_millis(1000)).await;
            page.leave().await;
        }
        2 => {
            stage.sometimes("a page vanishes");
            stage.order(rest(heard + BUTTON + LATE, "its page has vanished"));
            page.into_end().vanish(stage.now() + 4000);
        }
        _ => {
            stage.sometimes("a page is closed while it jogs");
            stage.order(rest(heard + BUTTON + LATE, "its page is closed"));
            page.leave().await;
        }
    }
    Ok(())
}

pub(crate) async fn page_program_1(stage: Stage) {
    programs(stage, 5_000_000).await;
}

pub(crate) async fn page_program_2(stage: Stage) {
    programs(stage, 6_000_000).await;
}

/// Wants control of axis P and to run programs that move it, in turn with another page.
async fn programs(mut stage: Stage, first: i32) {
    let mut next = first;
    while !stage.is_over() {
        let asked = stage.now();
        match stage.page().await {
            Ok(page) => {
                if let Err(error) = run_some(&mut stage, page, &mut next).await {
                    stage.judge(asked, &error);
                }
            }
            Err(error) => stage.judge(asked, &error),
        }
        stage.pause(1500).await;
    }
}

async fn run_some(stage: &mut Stage, mut page: Page, next: &mut i32) -> Answer<()> {
    if let Err(refused) = page.ask(json!({"do": "take", "object": "P"})).await? {
        stage.note(&refused);
        stage.sometimes("another page has control");
    }
    for _ in 0..1 + stage.random.below(4) {
        if stage.is_over() {
            break;
        }
        *next += 1;
        run_one(stage, &mut page, *next).await?;
        stage.pause(200).await;
    }
    if stage.chance(25) && !stage.is_over() {
        stage.sometimes("a page with control vanishes");
        page.into_end().vanish(stage.now() + 3000);
    } else {
        page.leave().await;
    }
    Ok(())
}

/// Runs a program that writes a value of its own and moves.
async fn run_one(stage: &mut Stage, page: &mut Page, value: i32) -> Answer<()> {
    let distance = stage.random.between(0.5, 4.0);
    let text = format!(
        "MAFR(P, PageOn);\n\
         MSO(P, PageOn);\n\
         {PROGRAM_TAG} := {value};\n\
         MAM(P, PageMove, 1, {distance:.3}, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\n\
         WHILE PageMove.IP DO DELAY(0.01); END_WHILE;\n\
         {PROGRAM_TAG} := -{value};"
    );
    let (history, sent) = (stage.common.history.clone(), stage.now());
    let written = [value, -value];
    for value in written {
        history.asks(PROGRAM_TAG, value);
    }
    if let Err(refused) = page.ask(json!({"do": "run", "text": text})).await? {
        if refused.contains("runs already") {
            stage.sometimes("a second program is refused");
        }
        stage.note(&refused);
        for value in written {
            history.has(PROGRAM_TAG, value, WriteAnswer::Refused);
        }
        return Ok(());
    }
    stage.in_time(sent);
    stage.sometimes("a program of the page");
    // Its end is shown, however it ends.
    let shown = loop {
        match tokio::time::timeout(Duration::from_secs(1), page.end_of(&text)).await {
            Ok(shown) => break shown?,
            // The program waits for a lost change.
            Err(_) if stage.has_lost() => return Ok(()),
            Err(_) if stage.now() - sent > PATIENCE_MS => return Err(NoAnswer::Late),
            Err(_) => {}
        }
    };
    stage.note(&format!("the program of {value}: {}", shown.state));
    if shown.text == text && shown.state == "ended" {
        stage.sometimes("a program of the page is complete");
        for value in written {
            history.has(PROGRAM_TAG, value, WriteAnswer::NotPersistent);
        }
    }
    read(stage, page, PROGRAM_TAG).await
}

/// Reads the tags that others write.
pub(crate) async fn page_reader(mut stage: Stage) {
    while !stage.is_over() {
        let asked = stage.now();
        match stage.page().await {
            Ok(page) => {
                if let Err(error) = look(&mut stage, page).await {
                    stage.judge(asked, &error);
                }
            }
            Err(error) => stage.judge(asked, &error),
        }
        stage.pause(800).await;
    }
}

async fn look(stage: &mut Stage, mut page: Page) -> Answer<()> {
    for _ in 0..5 + stage.random.below(30) {
        if stage.is_over() {
            break;
        }
        let tag = *stage.random.one_of(&TAGS);
        read(stage, &mut page, tag).await?;
        stage.pause(60).await;
    }
    page.leave().await;
    Ok(())
}

/// Reads a tag whose writes are in the history.
async fn read(stage: &Stage, page: &mut Page, tag: &'static str) -> Answer<()> {
    let (asked, sent) = (stage.common.history.clock(), stage.now());
    let read = page.ask(json!({"do": "read", "names": [tag]})).await?;
    stage.in_time(sent);
    match read.ok().and_then(|read| read["values"][tag].as_i64()) {
        Some(value) => {
            stage.sometimes("the page reads a tag");
            stage.common.history.read(tag, value as i32, asked);
            stage.common.record.saw(stage.name, &value.to_le_bytes());
        }
        None => {
            let why = format!("the page cannot read {tag}");
            stage.common.record.violated("N1", &why);
        }
    }
    Ok(())
}
