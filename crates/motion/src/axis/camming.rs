//! The cams of an axis: pending cams, instructions of cams that have ended, and the directions of the last profiles.
//!
//! Not here: the position of a cam (`crate::masters::cam`). Real-time: nothing allocates.

use arcline_instruction_set::AxisId;
use arcline_planner::Clock;
use arcline_profile::KinematicState;

use super::Axis;
use super::generator::Equation;
use super::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::masters::MasterAt;
use crate::masters::cam::{self, Cam, Ended, Pending, Source};

/// The state of the cams of one kind on one axis, besides the active cam.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cams {
    /// The pending cam: it becomes active when the active one ends.
    pub(crate) pending: Option<Pending>,
    /// The instruction of the cam that the active one replaced, until it is reported as ended.
    pub(crate) ended: Option<Execution>,
    /// 1 when the last profile was added, -1 when it was subtracted.
    pub(crate) direction: Option<f64>,
    /// The offset of the master of a position cam.
    pub(crate) offset: Offset,
}

impl Cams {
    /// No cam is pending and no instruction is still to be reported.
    pub(crate) fn are_idle(&self) -> bool {
        self.pending.is_none() && self.ended.is_none()
    }
}

/// An offset of a master, in its units (MAM 5, 6).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Offset {
    /// Its value while no move changes it.
    rest: f64,
    /// The value at which its last move began: StartMasterOffset.
    pub(crate) start: f64,
    /// The value at the last MGSP: StrobeMasterOffset.
    pub(crate) strobed: f64,
}

impl Axis {
    /// The kinds of generators that are cams.
    pub(crate) const CAMS: [GeneratorKind; 2] = [GeneratorKind::PositionCam, GeneratorKind::TimeCam];

    /// The cams of a kind.
    pub(crate) fn cams(&self, kind: GeneratorKind) -> &Cams {
        &self.cams[usize::from(kind == GeneratorKind::TimeCam)]
    }

    pub(crate) fn cams_mut(&mut self, kind: GeneratorKind) -> &mut Cams {
        &mut self.cams[usize::from(kind == GeneratorKind::TimeCam)]
    }

    /// The next kind of generators behind `last` that is active or has a cam that ended.
    pub(crate) fn next_to_report(&self, last: Option<GeneratorKind>) -> Option<GeneratorKind> {
        let ended = |kind: &GeneratorKind| self.cams(*kind).ended.is_some();
        let ended = Axis::CAMS.into_iter().filter(ended);
        self.sum.next_active(last, ended)
    }

    /// The cam of a kind that is under way.
    pub(crate) fn cam(&self, kind: GeneratorKind) -> Option<&Cam> {
        match &self.sum.get(kind)?.equation {
            Equation::Cammed(cam) => Some(cam),
            _ => None,
        }
    }

    /// The master axis of a cam of a kind.
    pub(crate) fn cam_master(&self, kind: GeneratorKind) -> Option<AxisId> {
        match self.cam(kind)?.source() {
            Source::Axis { master, .. } => Some(master),
            Source::Time { .. } => None,
        }
    }

    /// Updates a cam to the position of its master.
    pub(crate) fn follow_cam(&mut self, kind: GeneratorKind, at: &MasterAt, clock: &Clock) {
        let cams = &mut self.cams[usize::from(kind == GeneratorKind::TimeCam)];
        let Some(generator) = self.sum.get_mut(kind) else {
            return;
        };
        let Equation::Cammed(cam) = &mut generator.equation else {
            return;
        };
        if generator.over {
            return;
        }
        let (now, ended) = cam.follow(at, generator.now.position, &mut cams.pending, clock);
        generator.now = now;
        match ended {
            Ended::Nothing => {}
            Ended::Cam => generator.over = true,
            Ended::HandedOver(next) => cams.ended = generator.execution.replace(next),
        }
    }

    /// The offset of the position cam's master now.
    pub(crate) fn master_offset(&self) -> KinematicState {
        match self.sum.get(GeneratorKind::MasterOffset) {
            Some(generator) => generator.now,
            None => KinematicState {
                position: self.cams(GeneratorKind::PositionCam).offset.rest,
                ..KinematicState::default()
            },
        }
    }

    /// A master as a cam sees it: a position cam with its offset.
    pub(crate) fn offset_master(&mut self, kind: GeneratorKind, mut at: MasterAt, clock: &Clock) -> MasterAt {
        if kind == GeneratorKind::PositionCam {
            if let Some(generator) = self.sum.get_mut(GeneratorKind::MasterOffset) {
                generator.advance(clock);
            }
            let offset = self.master_offset();
            at.point.position += offset.position;
            at.point.velocity += offset.velocity;
            at.point.acceleration += offset.acceleration;
        }
        at
    }

    /// A move of the offset begins, or one has ended and the offset stays at its end.
    pub(super) fn note_offset(&mut self, begins: bool) {
        let now = self.master_offset().position;
        let offset = &mut self.cams_mut(GeneratorKind::PositionCam).offset;
        offset.rest = now;
        if begins {
            offset.start = now;
        }
    }

    /// Updates the time cam; its master is time.
    pub(crate) fn follow_time(&mut self, clock: &Clock) {
        if let Some(Source::Time { since }) = self.cam(GeneratorKind::TimeCam).map(Cam::source) {
            self.follow_cam(GeneratorKind::TimeCam, &cam::time(since, clock), clock);
        }
    }
}
