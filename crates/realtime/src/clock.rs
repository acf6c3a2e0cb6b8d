//! The clock of the ticks: the monotonic clock, or clients that step the machine.
//!
//! On the step clock a tick stays open until a client asks for another one: commands are executed at its instant and shown at once,
//! whatever the real time. The machine's state thus depends only on the commands and the steps.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use arcline_controller::{ContourRequest, Controller};

use crate::rings::Rings;

/// The clock of the ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Clock {
    /// Real time.
    #[default]
    Real,
    /// A multiple of real time.
    Fast(f64),
    /// A [`Stepper`].
    Step,
}

/// The processor time of this thread. Time in which the computer did other work does not count.
#[must_use]
pub fn thread_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    let part = |number: i64| number.unsigned_abs();
    Duration::from_secs(part(time.tv_sec)) + Duration::from_nanos(part(time.tv_nsec))
}

/// Executes ticks on the step clock. Clones belong to the same machine.
#[derive(Clone)]
pub struct Stepper(Arc<Shared>);

#[derive(Default)]
struct Shared {
    wanted: Mutex<Option<Steps>>,
    asked: Condvar,
}

/// Ticks to execute.
pub struct Steps {
    /// The number of ticks, at most.
    pub ticks: u32,
    /// Called before the first tick and after each one: true ends the steps.
    pub until: Option<Box<dyn FnMut() -> bool + Send>>,
    /// True ends the steps at the present tick: the client has gone.
    pub abandoned: Arc<AtomicBool>,
    /// Called with the number of executed ticks. Dropped without a call if the thread ends.
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

    /// Requests steps. The earlier ones must be done: this call drops steps that have not begun.
    pub fn step(&self, steps: Steps) {
        *self.0.wanted.lock().unwrap_or_else(PoisonError::into_inner) = Some(steps);
        self.0.asked.notify_one();
    }

    /// The next steps; `None` if there were none for a moment, so that commands can be executed.
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
            // More commands may wait, which are executed at this instant, too.
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
            if is_true || *passed >= wanted.ticks || wanted.abandoned.load(Ordering::Acquire) {
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

/// The longest delay of a command while no steps are requested.
const MOMENT: Duration = Duration::from_micros(500);
