//! What makes ticks pass: the monotonic clock, or the clients that step the machine.
//!
//! On the step clock a tick stays open until another one is asked for: commands are executed at its instant and shown at once, no matter how
//! long it takes in real time. So the machine's state depends on the commands and the steps alone.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use arcline_controller::{ContourRequest, Controller};

use crate::rings::Rings;

/// What makes ticks pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Clock {
    /// Real time.
    #[default]
    Real,
    /// So many times real time.
    Fast(f64),
    /// A [`Stepper`].
    Step,
}

/// Lets ticks pass on the step clock. Clones are of one machine.
#[derive(Clone)]
pub struct Stepper(Arc<Shared>);

#[derive(Default)]
struct Shared {
    wanted: Mutex<Option<Steps>>,
    asked: Condvar,
}

/// Ticks that are to pass.
pub struct Steps {
    /// How many, at most.
    pub ticks: u32,
    /// Asked after each tick, and before the first one: true ends the steps.
    pub until: Option<Box<dyn FnMut() -> bool + Send>>,
    /// Told how many ticks have passed. Dropped without, when the thread ends.
    pub done: Box<dyn FnOnce(u32) + Send>,
}

impl fmt::Debug for Stepper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Stepper")
    }
}

impl fmt::Debug for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Steps")
            .field("ticks", &self.ticks)
            .finish_non_exhaustive()
    }
}

impl Stepper {
    pub(crate) fn new() -> Self {
        Stepper(Arc::default())
    }

    /// Lets ticks pass. The steps before must be done: those that are replaced before they began are dropped.
    pub fn step(&self, steps: Steps) {
        *self.0.wanted.lock().unwrap_or_else(PoisonError::into_inner) = Some(steps);
        self.0.asked.notify_one();
    }

    /// The next steps; `None`: there were none for a moment, and there may be commands.
    fn next(&self) -> Option<Steps> {
        let wanted = self.0.wanted.lock().unwrap_or_else(PoisonError::into_inner);
        let none = |wanted: &mut Option<Steps>| wanted.is_none();
        let waited = self.0.asked.wait_timeout_while(wanted, MOMENT, none);
        waited.unwrap_or_else(PoisonError::into_inner).0.take()
    }
}

/// The body of the thread on the step clock.
pub(crate) fn run(mut controller: Controller, mut rings: Rings, stepper: &Stepper, grace: u64, asked: &AtomicBool) {
    let mut contour = ContourRequest::new();
    let mut grace_left = grace;
    let mut steps: Option<(Steps, u32)> = None;
    let mut is_new = true;
    controller.begin_tick();
    loop {
        let ends = asked.load(Ordering::Acquire);
        if ends {
            rings.stop();
        }
        let began = crate::thread::now();
        let took = controller.take_commands(&mut rings);
        if took || is_new {
            controller.plan_contours(&mut contour);
            controller.show(&mut rings);
            is_new = false;
        }
        if took {
            // More may wait, which are executed at this instant too.
            continue;
        }
        if ends {
            if grace_left == 0 || (controller.at_rest() && grace_left < grace) {
                return;
            }
            grace_left -= 1;
        } else {
            let Some((wanted, passed)) = &mut steps else {
                steps = stepper.next().map(|steps| (steps, 0));
                continue;
            };
            let is_true = wanted.until.as_mut().is_some_and(|until| until());
            if is_true || *passed >= wanted.ticks {
                if let Some((wanted, passed)) = steps.take() {
                    (wanted.done)(passed);
                }
                continue;
            }
            *passed += 1;
            rings.wait_for_room(asked);
        }
        rings.close();
        controller.begin_tick();
        is_new = true;
        rings
            .meter
            .tick(0, crate::thread::now().saturating_sub(began), false, false);
    }
}

/// How soon a command is executed that comes while no steps are asked for.
const MOMENT: Duration = Duration::from_micros(500);
