//! One section: moves without a stop between them, from rest or from a running motion to rest.
//!
//! The optimisation runs in a few stages, each on control points at equal times of the previous result, with a narrower corridor where the
//! curve was outside. Position units and seconds.

use crate::limits::{MoveLimits, Smoothness};
use crate::path::allowance::{Allowance, SectionStart};
use crate::path::margin::ToleranceMargin;
use crate::path::reference::ReferencePath;
use crate::path::rounding::{Corners, Stretch, round};
use crate::path::smooth::smooth;
use crate::plan::PlanningTime;
use crate::solve::measure::{Measured, measured};
use crate::solve::setup::Conditions;
use crate::solve::stages::{Limited, Quality, Stage, StageResult, last_stages, stages};
use crate::solve::work::Work;
use crate::timing::control_points::ControlPoints;
use crate::timing::first_guess::{first_guess, pass_times};
use crate::timing::resample::{project, resample};
use crate::tolerance::LIMIT_SHARE;
use crate::trajectory::MoveEnd;
use crate::tuning::{SlowDown, TUNING};
use crate::{AxisLimits, ContourMove, Trajectory};

/// The result of a section.
pub(crate) struct Solved {
    pub(crate) trajectory: Trajectory,
    pub(crate) control: ControlPoints,
    /// The time of each node.
    pub(crate) times: Vec<f64>,
    /// Repairs that brought its curve inside the corridor.
    repairs: usize,
}

/// The end of a search that found no motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Missed {
    /// Another curve or another timing may be within all limits.
    Near,
    /// The motion is so far outside its limits that only a slower start comes within them.
    Far,
}

/// What brings a warm start within all limits that is nearly within them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mend {
    /// One smoothing of its curve, if it needs a mend at all.
    Smoothing,
    /// Its timing, which takes more work.
    Timing,
}

/// The usual update period, of which the others are multiples or parts, s.
const TICK: f64 = 1e-3;

/// Moves from rest to rest without a stop between them.
pub(crate) struct Section<'a> {
    moves: &'a [ContourMove],
    pub(crate) reference: ReferencePath,
    pub(crate) bounds: Vec<MoveLimits>,
    pub(crate) allowance: Allowance,
    pub(crate) smoothness: Smoothness,
    pub(crate) quality: Quality,
    slow_down: SlowDown,
    /// The excess beyond which a continuation that closes in on its limits is given up.
    far: f64,
    /// The time of its start since the motion began to move.
    begins: f64,
}

impl<'a> Section<'a> {
    /// A section of moves, at least one of which has a length.
    pub(crate) fn new(moves: &'a [ContourMove], limits: &AxisLimits, start: SectionStart, quality: Quality) -> Self {
        let smoothness = Smoothness::of(moves);
        let long: Vec<&ContourMove> = moves.iter().filter(|m| m.has_length()).collect();
        let reference = ReferencePath::new(long.iter().map(|m| m.path).collect());
        let tolerances = long.iter().map(|m| m.tolerance).collect();
        let deviations = long.iter().map(|m| m.deviation);
        Section {
            moves,
            allowance: Allowance::new(&reference, tolerances, deviations, smoothness, start, quality),
            reference,
            bounds: long.iter().map(|m| MoveLimits::new(m, limits, smoothness)).collect(),
            smoothness,
            quality,
            slow_down: SlowDown::Outside,
            far: TUNING.smooth.far,
            begins: 0.0,
        }
    }

    /// The same from an instant of a running motion on.
    pub(crate) fn beginning(self, begins: f64) -> Self {
        Section { begins, ..self }
    }

    /// The same with a different slow-down of a start outside the limits, and another excess beyond which it is given up.
    pub(crate) fn attempted(self, slow_down: SlowDown, far: f64) -> Self {
        Section { slow_down, far, ..self }
    }

    /// The limits without those of the jerk, and the reference path rounded for them: an S-curve starts from the trapezoid's shape, as without
    /// jerk limits the optimisation is not stiff.
    pub(crate) fn without_jerk(&self) -> (Vec<MoveLimits>, Vec<Stretch>) {
        (
            self.bounds.iter().map(MoveLimits::without_jerk).collect(),
            round(
                &self.reference,
                &self.allowance,
                Corners::Superposed(Smoothness::Trapezoid),
            ),
        )
    }

    /// Plans from rest to rest; `None` if the result is not inside the corridor and the limits.
    pub(crate) fn plan(&self, planning_time: PlanningTime) -> Option<Trajectory> {
        let control = self.first_guess();
        let mut work = match (planning_time, self.quality) {
            // Without a smooth curve in time, the corners are rounded one by one, which is found soon.
            (PlanningTime::Streaming, Quality::Smooth) => Work::to_begin(self.smoothness),
            _ => Work::from_rest(control.points.len()),
        };
        let mut stages = stages(self.smoothness, self.quality);
        if planning_time == PlanningTime::Streaming {
            stages.iter_mut().for_each(Stage::end_soon);
        }
        Some(self.finish(self.run(control, &stages, planning_time, &mut work).ok()?))
    }

    /// The same, with its control points, within a budget of work that it shares with others.
    pub(crate) fn solve_with(&self, work: &mut Work) -> Option<Solved> {
        let stages = stages(self.smoothness, self.quality);
        self.run(self.first_guess(), &stages, PlanningTime::Unlimited, work)
            .ok()
    }

    /// The instants at which the first guess passes the ends of the moves that have a length, with limits of the jerk or without.
    pub(crate) fn passes(&self, limited: Limited) -> Vec<f64> {
        match limited {
            Limited::Acceleration => {
                let (free, stretches) = self.without_jerk();
                pass_times(&self.reference, &stretches, &free, Smoothness::Trapezoid)
            }
            Limited::Jerk => {
                let corners = Corners::Superposed(self.smoothness);
                let stretches = round(&self.reference, &self.allowance, corners);
                pass_times(&self.reference, &stretches, &self.bounds, self.smoothness)
            }
        }
    }

    fn first_guess(&self) -> ControlPoints {
        let (free, stretches) = self.without_jerk();
        first_guess(
            &self.reference,
            &self.allowance,
            &stretches,
            &free,
            Smoothness::Trapezoid,
        )
    }

    /// Optimises from a warm start to rest; returns the repairs that it took as well.
    ///
    /// # Errors
    /// The result is not inside the corridor and the limits.
    pub(crate) fn improve(&self, control: ControlPoints, work: &mut Work) -> Result<(Trajectory, usize), Missed> {
        let mut stages = stages(self.smoothness, self.quality);
        if self.quality == Quality::Smooth && self.smoothness == Smoothness::SCurve {
            // The running motion keeps the limits of the jerk; after a stage without them, the motion would not return to them.
            stages.retain(|stage| stage.limits == Limited::Jerk);
            for _ in 0..TUNING.smooth.closing {
                stages.insert(0, stages[0]);
            }
        }
        let solved = self.run(control, &stages, PlanningTime::Unlimited, work)?;
        let repairs = solved.repairs;
        Ok((self.finish(solved), repairs))
    }

    /// Makes a warm start faster that a mend brings within all limits; `None` if it does not.
    pub(crate) fn hasten(&self, warm_start: ControlPoints, mend: Mend, work: &mut Work) -> Option<Trajectory> {
        let stages = stages(self.smoothness, Quality::TimingOnly);
        self.hasten_by(stages.last()?, TUNING.work.hastening_each, warm_start, mend, work)
    }

    /// The same for the beginning of a stream, with little work: the motion waits for it.
    pub(crate) fn hasten_to_begin(&self, warm_start: ControlPoints) -> Option<Trajectory> {
        let mut stage = *stages(self.smoothness, Quality::TimingOnly).last()?;
        stage.end_soon();
        let nodes = warm_start.points.len() as u64;
        let each = TUNING.work.begin_each.min(TUNING.work.most_to_begin / nodes.max(1));
        self.hasten_by(&stage, each, warm_start, Mend::Smoothing, &mut Work::of(0))
    }

    /// One stage, with at least this number of visits of each node.
    fn hasten_by(
        &self,
        stage: &Stage,
        each: u64,
        warm_start: ControlPoints,
        mend: Mend,
        work: &mut Work,
    ) -> Option<Trajectory> {
        let mut margin = ToleranceMargin::new();
        let mut best = match mend {
            Mend::Smoothing => self.within(warm_start.clone(), &mut margin).or_else(|| {
                let mut smoothed = warm_start;
                smooth(&self.reference, &self.allowance, &margin, &self.bounds, &mut smoothed);
                project(&self.reference, &mut smoothed);
                self.within(smoothed, &mut margin)
            })?,
            Mend::Timing => {
                let mut closed_in = warm_start;
                self.run_stage(&mut closed_in, stage, &margin, work);
                self.within(closed_in, &mut margin)?
            }
        };
        let mut control = best.control.clone();
        work.allow(each, control.points.len());
        for round in 0..=TUNING.gentle.repairs {
            // If the curve is outside with the new times of its nodes, it is smoothed for these.
            if round > 0 {
                smooth(&self.reference, &self.allowance, &margin, &self.bounds, &mut control);
                project(&self.reference, &mut control);
            }
            let now = self.run_stage(&mut control, stage, &margin, work);
            let worst = margin.tighten(&now.trajectory, &control, &self.reference, &self.allowance);
            let is_faster = now.trajectory.duration() < best.trajectory.duration();
            let is_within = worst <= 1.0 && now.excess <= 1.0 + LIMIT_SHARE;
            if is_within && is_faster {
                best = Solved {
                    trajectory: now.trajectory,
                    control: control.clone(),
                    times: now.times,
                    repairs: round,
                };
            }
            if is_within || work.is_done() {
                break;
            }
            if worst > 1.0 {
                margin.narrow(worst, &self.allowance);
            }
        }
        Some(self.finish(best))
    }

    /// The motion of the control points, if it is within all limits and the corridor.
    fn within(&self, control: ControlPoints, margin: &mut ToleranceMargin) -> Option<Solved> {
        let Measured {
            trajectory,
            times,
            excess,
        } = measured(&control, &self.bounds, &self.reference, StageResult::Plan);
        let worst = margin.tighten(&trajectory, &control, &self.reference, &self.allowance);
        (worst <= 1.0 && excess <= 1.0 + LIMIT_SHARE).then_some(Solved {
            trajectory,
            control,
            times,
            repairs: 0,
        })
    }

    /// Optimises a warm start that is nearly within its limits.
    pub(crate) fn repair(&self, control: ControlPoints, work: &mut Work) -> Option<Trajectory> {
        let stages = last_stages(self.smoothness);
        let solved = self.run(control, &stages, PlanningTime::Unlimited, work).ok()?;
        Some(self.finish(solved))
    }

    /// The last resort for a single curve: the first guess, slowed down to its limits.
    pub(crate) fn slowed(&self) -> Trajectory {
        let stretches = round(
            &self.reference,
            &self.allowance,
            Corners::Superposed(Smoothness::Trapezoid),
        );
        let control = first_guess(
            &self.reference,
            &self.allowance,
            &stretches,
            &self.bounds,
            self.smoothness,
        );
        let Measured { trajectory, times, .. } = measured(&control, &self.bounds, &self.reference, StageResult::Plan);
        self.finish(Solved {
            trajectory,
            control,
            times,
            repairs: 0,
        })
    }

    /// Runs all stages, until one has a plan or the work is used up.
    fn run(
        &self,
        mut control: ControlPoints,
        stages: &[Stage],
        planning_time: PlanningTime,
        work: &mut Work,
    ) -> Result<Solved, Missed> {
        let quality = self.quality;
        let mut margin = ToleranceMargin::new();
        let mut last: Option<Measured> = None;
        let mut last_worst = 0.0;
        let mut repairs = 0;
        let mut within_before: Option<Solved> = None;
        let mut warp = Smoothness::Trapezoid;
        for stage in stages {
            // A continuation closes in on its limits until it is within them.
            let closes_in =
                control.initial.is_some() && quality == Quality::Smooth && stage.result == StageResult::Start;
            if closes_in && within_before.is_some() {
                continue;
            }
            let is_repair = stage.result == StageResult::Repair;
            // A continuation is close to its limits everywhere: repairs keep its nodes.
            let keeps = closes_in || is_repair && (control.initial.is_some() || quality == Quality::Smooth);
            if let Some(last) = last.as_ref().filter(|_| !keeps) {
                // The first stage with jerk limits warps the time at its ends for them.
                let warp = match stage.limits {
                    Limited::Jerk => core::mem::replace(&mut warp, Smoothness::Trapezoid),
                    Limited::Acceleration => Smoothness::Trapezoid,
                };
                control = self.resampled(&control, last, warp);
            }
            // A motion that is inside the corridor and only exceeds its limits keeps its curve.
            let keeps_curve = closes_in && last.is_some() && last_worst <= 1.0;
            if quality == Quality::Smooth && !keeps_curve {
                smooth(&self.reference, &self.allowance, &margin, &self.bounds, &mut control);
                project(&self.reference, &mut control);
            }
            if stage.limits == Limited::Acceleration {
                warp = self.smoothness;
            }
            if quality == Quality::Smooth {
                work.smooth_stage(control.points.len());
            }
            let most = match planning_time {
                PlanningTime::Unlimited => u64::MAX,
                PlanningTime::Streaming => TUNING.work.begin_stage_each * control.points.len() as u64,
            };
            let now = work.at_most(most, |work| self.run_stage(&mut control, stage, &margin, work));
            if !now.trajectory.duration().is_finite() {
                return Err(Missed::Near);
            }
            let worst = margin.tighten(&now.trajectory, &control, &self.reference, &self.allowance);
            let is_plan = stage.result != StageResult::Start;
            let within = worst <= 1.0 && now.excess <= 1.0 + LIMIT_SHARE;
            // A continuation within all limits is a plan after any stage: if a later stage fails, it starts from this plan again.
            let is_better = |before: &Solved| !within || before.trajectory.duration() < now.trajectory.duration();
            if let Some(within) = within_before.take_if(|before| is_plan && is_better(before)) {
                return Ok(self.improved(within, stage, &margin, work));
            }
            if closes_in && within {
                within_before = Some(Solved {
                    trajectory: now.trajectory.clone(),
                    control: control.clone(),
                    times: now.times.clone(),
                    repairs,
                });
            }
            if closes_in && now.excess > self.far {
                return Err(Missed::Far);
            }
            // A motion whose excess no longer decreases does not come within its limits; a slower one may.
            let comes_nearer = last
                .as_ref()
                .is_none_or(|last| now.excess < TUNING.smooth.nearer * last.excess);
            if closes_in && !within && worst <= 1.0 && last_worst <= 1.0 && !comes_nearer {
                return Err(Missed::Near);
            }
            // A running motion cannot wait for its continuation for long.
            let excess_is_hopeless = is_plan && now.excess > TUNING.stages.hopeless;
            if control.initial.is_some() && (excess_is_hopeless || worst > TUNING.stages.astray) {
                return Err(Missed::Near);
            }
            // The motion waits for its first plan: another quality is found sooner.
            repairs += usize::from(is_repair);
            if planning_time == PlanningTime::Streaming && is_plan && worst > self.far_to_begin(repairs) {
                return Err(Missed::Far);
            }
            if is_plan && within {
                return Ok(Solved {
                    trajectory: now.trajectory,
                    control,
                    times: now.times,
                    repairs,
                });
            }
            if work.is_done() {
                let within = within_before.ok_or(Missed::Near)?;
                let last = stages.iter().rfind(|stage| stage.result == StageResult::Plan);
                work.allow(TUNING.work.hastening_each, within.control.points.len());
                return Ok(match last {
                    Some(stage) => self.improved(within, stage, &margin, work),
                    None => within,
                });
            }
            // The first repair narrows the corridor only where the curve was outside; later ones narrow all of it.
            if is_repair && quality != Quality::TimingOnly {
                margin.narrow(worst, &self.allowance);
            }
            last = Some(now);
            last_worst = worst;
        }
        within_before.ok_or(Missed::Near)
    }

    /// Quotient of the distance from the path and the tolerance beyond which the first motion of a stream is given up after this number of repairs.
    fn far_to_begin(&self, repairs: usize) -> f64 {
        match (self.smoothness, repairs) {
            (Smoothness::Trapezoid, 0) => TUNING.smooth.far_to_begin,
            (Smoothness::SCurve, 0) | (_, 1) => f64::INFINITY,
            (_, 2) => TUNING.smooth.far_repaired,
            _ => 1.0,
        }
    }

    /// A motion within all limits, made faster on its own nodes; the motion itself if that fails.
    fn improved(&self, from: Solved, stage: &Stage, margin: &ToleranceMargin, work: &mut Work) -> Solved {
        let mut control = from.control.clone();
        let better = self.run_stage(&mut control, stage, margin, work);
        let mut margin = ToleranceMargin::new();
        let worst = margin.tighten(&better.trajectory, &control, &self.reference, &self.allowance);
        let faster = better.trajectory.duration() < from.trajectory.duration();
        if faster && worst <= 1.0 && better.excess <= 1.0 + LIMIT_SHARE {
            Solved {
                trajectory: better.trajectory,
                control,
                times: better.times,
                repairs: from.repairs,
            }
        } else {
            from
        }
    }

    /// The control points at equal times of the last result.
    fn resampled(&self, control: &ControlPoints, last: &Measured, warp: Smoothness) -> ControlPoints {
        let Measured { trajectory, times, .. } = last;
        let roundings = self.allowance.roundings(&self.reference, |s| control.time_of(s, times));
        let mut fresh = resample(
            trajectory,
            times,
            control,
            &self.bounds,
            (&roundings, self.allowance.spacing()),
            warp,
        );
        project(&self.reference, &mut fresh);
        fresh
    }

    /// Improves the control points in one run of the optimisation.
    fn run_stage(
        &self,
        control: &mut ControlPoints,
        stage: &Stage,
        margin: &ToleranceMargin,
        work: &mut Work,
    ) -> Measured {
        let free: Vec<MoveLimits>;
        let bounds = match stage.limits {
            Limited::Jerk => &self.bounds,
            Limited::Acceleration => {
                free = self.bounds.iter().map(MoveLimits::without_jerk).collect();
                &free
            }
        };
        let margins: Vec<f64> = control.progress.iter().map(|&s| margin.at(s)).collect();
        let conditions = Conditions {
            reference: &self.reference,
            allowance: &self.allowance,
            limits: bounds,
            kept_limits: &self.bounds,
            margins: &margins,
            slow_down: self.slow_down,
        };
        let mut problem = conditions.problem(control, self.quality);
        problem.make_feasible();
        problem.run(stage.schedule, work);
        let span = control.spans[0];
        control.points = core::mem::take(&mut problem.points);
        control.spans = problem.spans.iter().map(|h| span * h).collect();
        measured(control, bounds, &self.reference, stage.result)
    }

    /// A continuation that comes to rest just behind a millisecond, a little later; the motion itself if that is not within all limits. The end of an S-curve is a
    /// cubic: its last tick would move the axes by less than a tenth of a nanometre, and the motion seem to rest before its end.
    fn apart_from_tick(&self, solved: Solved) -> Solved {
        let early = too_early(self.begins + solved.trajectory.duration());
        if solved.control.initial.is_none() || self.smoothness == Smoothness::Trapezoid || early == 0.0 {
            return solved;
        }
        let mut later = solved.control.clone();
        later.stretch(early);
        self.within(later, &mut ToleranceMargin::new()).unwrap_or(solved)
    }

    fn finish(&self, solved: Solved) -> Trajectory {
        let Solved {
            mut trajectory,
            control,
            times,
            ..
        } = self.apart_from_tick(solved);
        trajectory.move_ends = self.move_ends(&control, &times, trajectory.duration());
        trajectory.end = self.moves.last().map_or(trajectory.end, |last| last.path.end());
        trajectory
    }

    /// The times of the ends of the moves: those at which the progress passes them; a move without length ends with the previous one.
    fn move_ends(&self, control: &ControlPoints, times: &[f64], whole: f64) -> Vec<MoveEnd> {
        let reference = &self.reference;
        let time_at = |s: f64| control.time_of(s, times);
        let mut ends = Vec::with_capacity(self.moves.len());
        let (mut piece, mut last) = (0, MoveEnd::plain(0.0));
        for one in self.moves {
            if one.has_length() {
                let [before, behind] = self.allowance.rounding(reference, piece);
                piece += 1;
                let s = reference.starts[piece];
                last = if piece == reference.pieces.len() {
                    MoveEnd::plain(whole)
                } else {
                    MoveEnd {
                        time: time_at(s),
                        rounding: [time_at(s - before), time_at(s + behind)],
                    }
                };
            }
            ends.push(last);
        }
        ends
    }
}

/// Seconds by which an S-curve that comes to rest at this time is too early: its last tick would move the axes by nearly nothing.
pub(crate) fn too_early(end: f64) -> f64 {
    let behind = end.rem_euclid(TICK);
    if (TUNING.end.from_s..TUNING.end.to_s).contains(&behind) {
        TUNING.end.to_s - behind
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Deviation, Path, Point};

    #[test]
    fn a_plan_ends_when_its_work_is_done() {
        let corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [10.0, 60.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let moves: Vec<ContourMove> = corners
            .windows(2)
            .map(|ends| ContourMove {
                path: Path::line(ends[0], ends[1]),
                speed: 100.0,
                acceleration: 1000.0,
                deceleration: 1000.0,
                jerk: Some(20_000.0),
                tolerance: 0.5,
                deviation: Deviation::Corners,
            })
            .collect();
        let limits = AxisLimits {
            speed: Point::repeat(100.0),
            acceleration: Point::repeat(1000.0),
            jerk: Some(Point::repeat(20_000.0)),
        };
        let section = Section::new(&moves, &limits, SectionStart::Rest, Quality::Full);
        let nodes = section.first_guess().points.len();
        let mut work = Work::from_rest(nodes);
        assert!(section.solve_with(&mut work).is_some() && !work.is_done());
        let mut little = Work::of(20 * nodes as u64);
        assert!(section.solve_with(&mut little).is_none() && little.is_done());
    }
}
