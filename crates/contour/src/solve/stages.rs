//! The runs of the optimisation that make up a plan.

use crate::limits::Smoothness;
use crate::solve::optimise::BarrierSchedule;
use crate::tuning::{StageTuning, TUNING};

/// The quality of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    /// The least time on separately rounded corners.
    TimingOnly,
    /// The least time on a smooth curve through dense chords ([`crate::path::smooth`]).
    Smooth,
    /// The least time for timing and shape together.
    Full,
}

/// One run of the optimisation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage {
    /// The limits that it keeps.
    pub(crate) limits: Limited,
    pub(crate) schedule: BarrierSchedule,
    pub(crate) result: StageResult,
}

/// The limits of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limited {
    /// Speed and acceleration: without limits of jerk the optimisation is not stiff.
    Acceleration,
    /// Those of the jerk as well.
    Jerk,
}

/// The use of a stage's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StageResult {
    /// The next stage starts from it.
    Start,
    /// It is the plan if it is within the corridor and the limits.
    Plan,
    /// The same, for a stage that starts outside.
    Repair,
}

impl Stage {
    fn new(limits: Limited, tuning: &StageTuning, result: StageResult) -> Stage {
        Stage {
            limits,
            schedule: BarrierSchedule {
                first: tuning.first,
                last: tuning.last,
                factor: TUNING.stages.factor,
                steps: tuning.steps,
            },
            result,
        }
    }

    /// Ends with a lower weight of the time: the motion is a little slower, and found sooner.
    pub(crate) fn end_soon(&mut self) {
        self.schedule.last = self.schedule.last.min(TUNING.stages.begun);
    }
}

/// All stages of a plan, in their order.
pub(crate) fn stages(smoothness: Smoothness, quality: Quality) -> Vec<Stage> {
    let tuning = &TUNING.stages;
    let start = |limits, of: &StageTuning| Stage::new(limits, of, StageResult::Start);
    let mut stages = match (smoothness, quality) {
        (Smoothness::Trapezoid, Quality::TimingOnly | Quality::Smooth) => {
            vec![Stage::new(Limited::Acceleration, &tuning.timing, StageResult::Plan)]
        }
        (Smoothness::SCurve, Quality::Smooth) => vec![
            start(Limited::Acceleration, &tuning.without_jerk),
            start(Limited::Jerk, &tuning.without_jerk),
            Stage::new(Limited::Jerk, &tuning.timing_with_jerk, StageResult::Plan),
        ],
        (Smoothness::SCurve, Quality::TimingOnly) => vec![
            start(Limited::Acceleration, &tuning.without_jerk),
            Stage::new(Limited::Jerk, &tuning.timing_with_jerk, StageResult::Plan),
        ],
        (Smoothness::Trapezoid, Quality::Full) => {
            let shape = tuning.shape.iter();
            shape.map(|of| start(Limited::Acceleration, of)).collect()
        }
        (Smoothness::SCurve, Quality::Full) => {
            let shape = tuning.shape_with_jerk.iter();
            core::iter::once(start(Limited::Acceleration, &tuning.without_jerk))
                .chain(shape.map(|of| start(Limited::Jerk, of)))
                .collect()
        }
    };
    match quality {
        Quality::Full => stages.extend(last_stages(smoothness)),
        Quality::Smooth => stages.extend(smooth_repairs(smoothness)),
        Quality::TimingOnly => {}
    }
    stages
}

/// The same timing again, if the smooth curve was outside.
fn smooth_repairs(smoothness: Smoothness) -> Vec<Stage> {
    let (limits, timing) = match smoothness {
        Smoothness::Trapezoid => (Limited::Acceleration, &TUNING.stages.timing),
        Smoothness::SCurve => (Limited::Jerk, &TUNING.stages.timing_with_jerk),
    };
    vec![Stage::new(limits, timing, StageResult::Repair); TUNING.smooth.repairs]
}

/// The stages of a plan that is nearly within the corridor and the limits: one and its repairs.
pub(crate) fn last_stages(smoothness: Smoothness) -> Vec<Stage> {
    let limits = match smoothness {
        Smoothness::Trapezoid => Limited::Acceleration,
        Smoothness::SCurve => Limited::Jerk,
    };
    let stage = |result| Stage::new(limits, &TUNING.stages.last, result);
    let mut stages = vec![stage(StageResult::Plan)];
    stages.resize(1 + TUNING.stages.repairs, stage(StageResult::Repair));
    stages
}
