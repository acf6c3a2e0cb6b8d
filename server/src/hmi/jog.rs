//! Jogs with a dead-man: an axis moves as long as its viewer confirms that the button is pressed. The guard (`crate::guard`) stops the
//! jogs of viewers that confirm no more; here a jog begins, and ends with the release of its button.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use arcline_config::ConnectionLoss;
use arcline_instruction_set::{AxisId, Flag, Mnemonic};
use tokio::time::{MissedTickBehavior, interval};

use super::Shared;
use super::drive::{axis_of, call, instruction, rate};
use super::protocol::{Done, Jog, Refusal};
use crate::guard::{ClientInterface, VIEWERS};
use crate::plant::control::{MotionObject, ViewerId};
use crate::plant::{Call, Command, Outcome, Plant, Principal};

/// Time between two checks that viewers that jog still have control of the axis.
const LOOK: Duration = Duration::from_millis(10);
/// The longest stop of a jog at its own deceleration; after it, the axis's full deceleration applies.
const SOFT_STOP: Duration = Duration::from_secs(1);
/// Stop Type of MAS: Jog.
const JOG: f64 = 1.0;

/// The jogs of viewers: the decelerations, u/s², with which they stop when the button is released; `None`: the axis's own.
#[derive(Debug, Default)]
pub(super) struct Jogs(Mutex<BTreeMap<(ViewerId, AxisId), Option<f64>>>);

impl Jogs {
    /// Moves an axis until [`Jogs::keep`] does not come any more. `is_held`: the button has not been released since the request.
    pub(super) async fn begin(
        &self,
        plant: &Plant,
        viewer: ViewerId,
        request: &Jog,
        is_held: impl Fn() -> bool,
    ) -> Result<Done, Refusal> {
        let Jog {
            axis,
            speed,
            accel,
            decel,
        } = request;
        let (speed, accel, decel) = (*speed, *accel, *decel);
        let machine = plant.machine();
        let place = axis_of(plant, axis)?;
        let limit = machine.axes[usize::from(place)].max_speed;
        if !speed.is_finite() || speed.abs() > limit {
            return Err(Refusal::new(format!(
                "the speed is {speed}, expected -{limit} to {limit}"
            )));
        }
        if !is_held() {
            return Err(Refusal::new("the button was released before the jog began"));
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
        self.decelerations().insert((viewer, place), decel);
        // The guard watches it from the tick in which it is sent.
        let maj = instruction(Mnemonic::Maj, axis, &operands);
        let done = call(plant, Principal::Button(viewer), &maj, None).await;
        if !is_held() {
            self.end(plant, viewer, axis).await?;
        }
        done.map(|_| Done {})
    }

    /// A sign of life for a jog.
    pub(super) fn keep(&self, plant: &Plant, viewer: ViewerId, axis: &str) -> Result<Done, Refusal> {
        let place = axis_of(plant, axis)?;
        if plant.guard().keep(VIEWERS | viewer, place) {
            Ok(Done {})
        } else {
            Err(Refusal::new(format!("this page does not jog {axis} any more")))
        }
    }

    /// The end of a jog.
    pub(super) async fn end(&self, plant: &Plant, viewer: ViewerId, axis: &str) -> Result<Done, Refusal> {
        let place = axis_of(plant, axis)?;
        let decel = self.decelerations().remove(&(viewer, place));
        if plant.guard().release(VIEWERS | viewer, place, SOFT_STOP) {
            stop_jog(plant, viewer, place, decel.flatten()).await;
        }
        Ok(Done {})
    }

    /// Stops the jogs of a viewer that has gone.
    pub(super) fn leave(&self, plant: &Plant, viewer: ViewerId) {
        plant.guard().lose(VIEWERS | viewer);
        plant.leave(VIEWERS | viewer);
        self.decelerations().retain(|(of, _), _| *of != viewer);
        plant.control().leave(viewer);
    }

    fn decelerations(&self) -> MutexGuard<'_, BTreeMap<(ViewerId, AxisId), Option<f64>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops a jog with the deceleration of its request. The guard stops it, should this fail.
async fn stop_jog(plant: &Plant, viewer: ViewerId, axis: AxisId, decel: Option<f64>) {
    let machine = plant.machine();
    let name = MotionObject::Axis(axis).name(machine);
    let change = if decel.is_some() { 1.0 } else { 0.0 };
    let (units, rate) = rate(decel);
    #[rustfmt::skip]
    let operands = [
        ("Stop Type", JOG), ("Change Decel", change), ("Decel Rate", rate), ("Decel Units", units),
    ];
    let stop = instruction(Mnemonic::Mas, name, &operands).operands;
    let command = Command::Call(Call {
        mnemonic: Mnemonic::Mas,
        target: Some(axis.0),
        control: None,
        operands: &stop,
        text: None,
    });
    match plant.apply(Principal::Button(viewer), command).await {
        Ok(Outcome::Executed(executed)) if executed.control.has(Flag::Er) => {
            // Without motion there is no jog to stop.
            tracing::debug!(axis = name, err = executed.control.err, "a jog was not stopped");
        }
        Ok(_) => {}
        Err(error) => {
            tracing::error!(axis = name, %error, "a jog could not be stopped: the server stops all motion");
            plant.stop_all();
        }
    }
}

impl ClientInterface for Shared {
    fn keeps_jogs(&self, _: Principal) -> bool {
        false
    }

    fn lost(&self, session: u64) {
        let viewer = session & !VIEWERS;
        for owner in [Principal::Viewer(viewer), Principal::Button(viewer)] {
            self.plant.lose(owner, ConnectionLoss::Jogs);
        }
    }
}

/// Stops the jogs of viewers that have lost control of the axis, until the future is dropped.
pub(super) async fn watch(shared: Arc<Shared>) {
    let mut due = interval(LOOK);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        due.tick().await;
        let machine = shared.plant.machine();
        for (session, axis) in shared.plant.guard().held() {
            let viewer = session & !VIEWERS;
            if shared
                .plant
                .control()
                .check(machine, viewer, MotionObject::Axis(axis))
                .is_err()
            {
                shared.plant.guard().release(session, axis, Duration::ZERO);
            }
        }
    }
}
