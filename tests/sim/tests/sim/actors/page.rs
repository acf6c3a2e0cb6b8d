//! Viewers of the page: one that jogs by its button and is lost in each way in which a viewer can be, two that want to run programs, and one
//! that reads.

use std::time::Duration;

use serde_json::json;

use super::motion::LATE;
use super::tags::TAGS;
use super::{Environment, Order};
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

impl Environment {
    /// A page of its own connection.
    async fn page(&mut self) -> Answer<Page> {
        Page::open(self.browse(), self.in_time()).await
    }
}

/// Jogs axis S by the button, and then releases it, hangs, vanishes, or closes the page.
pub(crate) async fn page_jogger(mut env: Environment) {
    while !env.is_over() {
        let asked = env.now();
        match env.page().await {
            Ok(page) => {
                if let Err(error) = jog(&mut env, page).await {
                    env.judge(asked, &error);
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        // Longer than any of its stops takes.
        tokio::time::sleep(Duration::from_millis(1500)).await;
    }
}

async fn jog(env: &mut Environment, mut page: Page) -> Answer<()> {
    let taken = page.ask(json!({"do": "take", "object": "S"})).await?;
    if let Err(refused) = taken {
        // The viewer before it has vanished, and is not noticed yet.
        env.note(&refused);
        page.leave().await;
        return Ok(());
    }
    let reset = page.ask(json!({"do": "execute", "text": "MAFR(S, PageS)"})).await?;
    let on = page.ask(json!({"do": "execute", "text": "MSO(S, PageS)"})).await?;
    env.note(&format!("{reset:?}, {on:?}"));
    env.order(Order::Moves(S));
    let jog = json!({"do": "jog", "axis": "S", "speed": 20.0, "accel": 1000.0, "decel": 1000.0});
    if let Err(refused) = page.ask(jog).await? {
        env.note(&refused);
        page.leave().await;
        return Ok(());
    }
    env.sometimes("a jog of the page");
    for _ in 0..env.random.below(12) {
        // The server has ended it, where a sign came too late.
        if page.ask(json!({"do": "keep", "axis": "S"})).await?.is_err() {
            env.sometimes("a sign of a jog's button comes too late");
            break;
        }
        env.pause(90).await;
    }
    let rest = |at, why| Order::Rest(Deadline { axis: S, at, why });
    let heard = page.end().arrives_by().max(env.now());
    match env.random.below(4) {
        0 => {
            env.sometimes("the button of a page is released");
            page.ask(json!({"do": "jog_end", "axis": "S"}))
                .await?
                .map_err(NoAnswer::Wrong)?;
            // A stop from 20 units/s at 1,000 units/s², or by the guard.
            env.order(rest(env.now() + 50 + LATE, "its button is released"));
            page.leave().await;
        }
        1 => {
            env.sometimes("a page hangs");
            env.order(rest(heard + BUTTON + LATE, "its page hangs"));
            tokio::time::sleep(Duration::from_millis(1000)).await;
            page.leave().await;
        }
        2 => {
            env.sometimes("a page vanishes");
            env.order(rest(heard + BUTTON + LATE, "its page has vanished"));
            page.into_end().vanish(env.now() + 4000);
        }
        _ => {
            env.sometimes("a page is closed while it jogs");
            env.order(rest(heard + BUTTON + LATE, "its page is closed"));
            page.leave().await;
        }
    }
    Ok(())
}

pub(crate) async fn page_program_1(env: Environment) {
    programs(env, 5_000_000).await;
}

pub(crate) async fn page_program_2(env: Environment) {
    programs(env, 6_000_000).await;
}

/// Wants control of axis P and to run programs that move it, in turn with another page.
async fn programs(mut env: Environment, first: i32) {
    let mut next = first;
    while !env.is_over() {
        let asked = env.now();
        match env.page().await {
            Ok(page) => {
                if let Err(error) = run_some(&mut env, page, &mut next).await {
                    env.judge(asked, &error);
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        env.pause(1500).await;
    }
}

async fn run_some(env: &mut Environment, mut page: Page, next: &mut i32) -> Answer<()> {
    if let Err(refused) = page.ask(json!({"do": "take", "object": "P"})).await? {
        env.note(&refused);
        env.sometimes("another page has control");
    }
    for _ in 0..1 + env.random.below(4) {
        if env.is_over() {
            break;
        }
        *next += 1;
        run_one(env, &mut page, *next).await?;
        env.pause(200).await;
    }
    if env.chance(25) && !env.is_over() {
        env.sometimes("a page with control vanishes");
        page.into_end().vanish(env.now() + 3000);
    } else {
        page.leave().await;
    }
    Ok(())
}

/// Runs a program that writes a value of its own and moves.
async fn run_one(env: &mut Environment, page: &mut Page, value: i32) -> Answer<()> {
    let distance = env.random.between(0.5, 4.0);
    let text = format!(
        "MAFR(P, PageOn);\n\
         MSO(P, PageOn);\n\
         {PROGRAM_TAG} := {value};\n\
         MAM(P, PageMove, 1, {distance:.3}, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\n\
         WHILE PageMove.IP DO DELAY(0.01); END_WHILE;\n\
         {PROGRAM_TAG} := -{value};"
    );
    let (history, sent) = (env.common.history.clone(), env.now());
    let written = [value, -value];
    for value in written {
        history.asks(PROGRAM_TAG, value);
    }
    if let Err(refused) = page.ask(json!({"do": "run", "text": text})).await? {
        if refused.contains("runs already") {
            env.sometimes("a second program is refused");
        }
        env.note(&refused);
        for value in written {
            history.has(PROGRAM_TAG, value, WriteAnswer::Refused);
        }
        return Ok(());
    }
    env.sometimes("a program of the page");
    // Its end is shown, however it ends.
    let shown = loop {
        match tokio::time::timeout(Duration::from_secs(1), page.end_of(&text)).await {
            Ok(shown) => break shown?,
            // The program waits for a lost change.
            Err(_) if env.has_lost() => return Ok(()),
            Err(_) if env.now() - sent > PATIENCE_MS => return Err(NoAnswer::Late),
            Err(_) => {}
        }
    };
    env.note(&format!("the program of {value}: {}", shown.state));
    if shown.text == text && shown.state == "ended" {
        env.sometimes("a program of the page is complete");
        for value in written {
            history.has(PROGRAM_TAG, value, WriteAnswer::NotPersistent);
        }
    }
    read(env, page, PROGRAM_TAG).await
}

/// Reads the tags that others write.
pub(crate) async fn page_reader(mut env: Environment) {
    while !env.is_over() {
        let asked = env.now();
        match env.page().await {
            Ok(page) => {
                if let Err(error) = look(&mut env, page).await {
                    env.judge(asked, &error);
                }
            }
            Err(error) => env.judge(asked, &error),
        }
        env.pause(800).await;
    }
}

async fn look(env: &mut Environment, mut page: Page) -> Answer<()> {
    for _ in 0..5 + env.random.below(30) {
        if env.is_over() {
            break;
        }
        let tag = *env.random.one_of(&TAGS);
        read(env, &mut page, tag).await?;
        env.pause(60).await;
    }
    page.leave().await;
    Ok(())
}

/// Reads a tag whose writes are in the history.
async fn read(env: &Environment, page: &mut Page, tag: &'static str) -> Answer<()> {
    let asked = env.common.history.clock();
    let read = page.ask(json!({"do": "read", "names": [tag]})).await?;
    match read.ok().and_then(|read| read["values"][tag].as_i64()) {
        Some(value) => {
            env.sometimes("the page reads a tag");
            env.common.history.read(tag, value as i32, asked);
            env.common.record.saw(env.name, &value.to_le_bytes());
        }
        None => {
            let why = format!("the page cannot read {tag}");
            env.common.record.violated("N1", &why);
        }
    }
    Ok(())
}
