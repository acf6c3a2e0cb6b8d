//! Jogs with a dead-man: an axis moves as long as its viewer says that it is still meant.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use arcline_instruction_set::{Flag, Mnemonic};
use serde_json::{Value as Json, json};
use tokio::time::{Instant, MissedTickBehavior, interval};

use super::Shared;
use super::drive::{instruction, rate};
use super::message::Refusal;
use super::rights::{Thing, ViewerId};

/// Without a sign of life for so long, a jog is stopped.
const KEEP_WITHIN: Duration = Duration::from_millis(150);
/// How often jogs are looked at.
const LOOK: Duration = Duration::from_millis(10);
/// Stop Type of MAS: Jog.
const JOG: f64 = 1.0;

/// Axes that move as long as somebody holds a button, by their place.
#[derive(Debug, Default)]
pub(super) struct Jogs(BTreeMap<u16, Jog>);

#[derive(Debug)]
struct Jog {
    viewer: ViewerId,
    until: Instant,
    /// Deceleration of its stop, u/s²; `None`: the axis's own.
    decel: Option<f64>,
}

impl Jogs {
    /// Takes out what a condition holds for.
    fn drain(&mut self, condition: impl Fn(u16, &Jog) -> bool) -> BTreeMap<u16, Jog> {
        let (out, rest) = std::mem::take(&mut self.0)
            .into_iter()
            .partition(|(axis, jog)| condition(*axis, jog));
        self.0 = rest;
        out
    }
}

impl Shared {
    /// Moves an axis until [`Shared::keep`] does not come any more.
    pub(super) async fn jog(
        &self,
        viewer: ViewerId,
        axis: &str,
        speed: f64,
        accel: Option<f64>,
        decel: Option<f64>,
    ) -> Result<Json, Refusal> {
        let machine = self.plant.machine();
        let place = self.axis(axis)?;
        self.check_right(viewer, Thing::Axis(place))?;
        let limit = machine.axes[usize::from(place)].max_speed;
        if !speed.is_finite() || speed.abs() > limit {
            return Err(Refusal::new(format!(
                "the speed is {speed}, expected -{limit} to {limit}"
            )));
        }
        let (accel_units, accel) = rate(accel);
        let (decel_units, decel_rate) = rate(decel);
        #[rustfmt::skip]
        let operands = [
            ("Direction", if speed < 0.0 { 1.0 } else { 0.0 }),
            ("Speed", speed.abs()), ("Speed Units", 0.0),
            ("Accel Rate", accel), ("Accel Units", accel_units),
            ("Decel Rate", decel_rate), ("Decel Units", decel_units),
            ("Profile", 0.0),
        ];
        // Watched before it moves.
        let jog = Jog {
            viewer,
            until: Instant::now() + KEEP_WITHIN,
            decel,
        };
        self.jogs().0.insert(place, jog);
        let done = self
            .call(viewer, &instruction(Mnemonic::Maj, axis, &operands), None)
            .await;
        if done.is_err() {
            self.jogs().0.remove(&place);
        }
        done.map(|_| json!({}))
    }

    /// A sign of life for a jog.
    pub(super) fn keep(&self, viewer: ViewerId, axis: &str) -> Result<Json, Refusal> {
        let place = self.axis(axis)?;
        let now = Instant::now();
        match self.jogs().0.get_mut(&place) {
            Some(jog) if jog.viewer == viewer && jog.until > now => {
                jog.until = now + KEEP_WITHIN;
                Ok(json!({}))
            }
            _ => Err(Refusal::new(format!("{axis} is not jogged by you any more"))),
        }
    }

    /// The end of a jog.
    pub(super) async fn jog_end(&self, viewer: ViewerId, axis: &str) -> Result<Json, Refusal> {
        let place = self.axis(axis)?;
        let ended = {
            let mut jogs = self.jogs();
            let own = jogs.0.get(&place).is_some_and(|jog| jog.viewer == viewer);
            if own { jogs.0.remove(&place) } else { None }
        };
        if let Some(jog) = ended {
            self.stop_jog(place, jog.decel).await;
        }
        Ok(json!({}))
    }

    /// A viewer has gone: what it jogged stops.
    pub(super) async fn leave(&self, viewer: ViewerId) {
        let gone = self.jogs().drain(|_, jog| jog.viewer == viewer);
        self.stop_jogs(gone).await;
        self.rights().leave(viewer);
    }

    async fn stop_jogs(&self, jogs: BTreeMap<u16, Jog>) {
        let stops = jogs.iter().map(|(axis, jog)| self.stop_jog(*axis, jog.decel));
        futures_util::future::join_all(stops).await;
    }

    async fn stop_jog(&self, axis: u16, decel: Option<f64>) {
        let machine = self.plant.machine();
        let name = Thing::Axis(axis).name(machine);
        let change = if decel.is_some() { 1.0 } else { 0.0 };
        let (units, rate) = rate(decel);
        #[rustfmt::skip]
        let operands = [
            ("Stop Type", JOG), ("Change Decel", change), ("Decel Rate", rate), ("Decel Units", units),
        ];
        let given = instruction(Mnemonic::Mas, name, &operands).given;
        let stopped = self.plant.call(Mnemonic::Mas, Some(axis), None, &given).await;
        match stopped {
            Ok(executed) if !executed.control.has(Flag::Er) => {}
            // Without motion there is nothing to stop; with a stop under way neither.
            Ok(executed) => tracing::debug!(axis = name, err = executed.control.err, "a jog was not stopped"),
            Err(error) => {
                tracing::error!(axis = name, %error, "a jog was not stopped: everything is");
                self.plant.stop_all();
            }
        }
    }

    fn jogs(&self) -> std::sync::MutexGuard<'_, Jogs> {
        self.jogs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops jogs that nobody keeps, and those of viewers that lost the right, until the future is dropped.
pub(super) async fn watch(shared: Arc<Shared>) {
    let mut due = interval(LOOK);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        due.tick().await;
        let dead = {
            let rights = shared.rights();
            let now = Instant::now();
            let machine = shared.plant.machine();
            shared
                .jogs()
                .drain(|axis, jog| jog.until <= now || rights.check(machine, jog.viewer, Thing::Axis(axis)).is_err())
        };
        shared.stop_jogs(dead).await;
    }
}
