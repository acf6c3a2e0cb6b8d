//! A model of the mechanics behind the drives, which moves axes of a simulated machine in place of their simulated drives.
//!
//! The model finds the answer of the simulated drives, and may change it. From the first tick at which it says that an axis is elsewhere, or moves
//! otherwise, the axis is the model's: its feedback is measured, and its switch, markers and stops see the position of the model. An axis
//! that a model has never changed is the axis of the simulated drive, to the bit. Units: position units, seconds. Nothing allocates after
//! [`ModelDrives::new`].

use arcline_instruction_set::{AxisId, FaultKind, FaultSet};
use arcline_profile::KinematicState;

use super::machine::{SimulatedAxis, SimulatedDrives};
use crate::{DriveState, Drives, ExchangeLost, Feedback, Following, SetPoint, Settled, WrittenInput};

/// A model of the mechanics behind the drives of a machine.
pub trait MechanicalModel: std::fmt::Debug + Send {
    /// One tick: `axes` holds the answers of the simulated drives, and gets those of the model. Axes that the model does not move are there as well.
    ///
    /// # Errors
    /// [`ModelFailed`]: all axes that the model moves have the fault `drive` from now on, and the model is not called any more.
    fn tick(&mut self, set_points: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), ModelFailed>;
}

/// A model that cannot go on. The model itself knows why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelFailed;

/// What a model says of an axis at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelledAxis {
    /// Where the axis is, of the machine.
    pub position: f64,
    /// Position units per second; `None`: of the way since the last tick.
    pub velocity: Option<f64>,
    /// Position units per second²; `None`: of the change of velocity since the last tick.
    pub acceleration: Option<f64>,
    /// The drive reports a fault.
    pub fault: bool,
}

/// The drives of a machine, some of whose axes a model moves.
#[derive(Debug)]
pub struct ModelDrives {
    drives: SimulatedDrives,
    model: Box<dyn MechanicalModel>,
    /// Of each axis: what the model has to do with it.
    shares: Vec<Share>,
    /// The simulated axes before the present tick.
    before: Vec<Option<SimulatedAxis>>,
    answers: Vec<ModelledAxis>,
    failed: bool,
}

/// What a model has to do with an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Share {
    /// Nothing.
    None,
    /// It may move the axis, and has not done so.
    May,
    /// It moves the axis.
    Moves,
}

impl ModelDrives {
    /// The axes that the model may move, of the simulated drives of a machine. The only allocation.
    pub fn new(drives: SimulatedDrives, model: Box<dyn MechanicalModel>, axes: &[AxisId]) -> Self {
        let before: Vec<_> = drives.axes().to_vec();
        let mut shares = vec![Share::None; before.len()];
        for axis in axes {
            let index = usize::from(*axis);
            if let (Some(share), Some(Some(_))) = (shares.get_mut(index), before.get(index)) {
                *share = Share::May;
            }
        }
        ModelDrives {
            answers: vec![ModelledAxis::default(); before.len()],
            drives,
            model,
            shares,
            before,
            failed: false,
        }
    }

    /// The answer of the model for one axis becomes its feedback.
    fn take(&mut self, index: usize, sent: &SetPoint, feedback: &mut Feedback) {
        let period = self.drives.period();
        let (Some(share), Some(answer)) = (self.shares.get_mut(index), self.answers.get(index)) else {
            return;
        };
        let (Some(Some(axis)), Some(Some(before))) = (self.drives.axes_mut().get_mut(index), self.before.get(index))
        else {
            return;
        };
        if *share == Share::May {
            let simulated = feedback.motion;
            let is_same = answer.position.to_bits() == simulated.position.to_bits()
                && answer.velocity.is_none_or(|velocity| velocity == simulated.velocity)
                && answer
                    .acceleration
                    .is_none_or(|acceleration| acceleration == simulated.acceleration);
            if is_same && !answer.fault {
                return;
            }
            *share = Share::Moves;
            *axis = before.ideal();
        }
        let last = axis.actual();
        let velocity = answer.velocity.unwrap_or((answer.position - last.position) / period);
        let motion = KinematicState {
            position: answer.position,
            velocity,
            acceleration: answer.acceleration.unwrap_or((velocity - last.velocity) / period),
        };
        axis.be_moved(motion, sent, period, feedback);
        feedback.following = Following::Measured;
        feedback.error = sent.position - feedback.motion.position;
        feedback.state = if sent.enable {
            DriveState::Enabled
        } else {
            DriveState::Off
        };
        feedback.faults = FaultSet::default();
        if answer.fault {
            feedback.state = DriveState::Faulted;
            feedback.faults = feedback.faults.with(FaultKind::Drive);
        }
    }
}

impl Drives for ModelDrives {
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback]) -> Result<(), ExchangeLost> {
        self.before.copy_from_slice(self.drives.axes());
        let (period, failed) = (self.drives.period(), self.failed);
        let axes = self.drives.axes_mut().iter_mut().zip(&self.shares);
        let values = set_points.iter().zip(feedback.iter_mut()).zip(&mut self.answers);
        for ((axis, share), ((set_point, feedback), answer)) in axes.zip(values) {
            let is_simulated = *share == Share::None || (*share == Share::May && !failed);
            let motion = match axis.as_mut().filter(|_| is_simulated) {
                Some(axis) => {
                    axis.follow(set_point, period, feedback);
                    feedback.motion
                }
                None => set_point.motion(),
            };
            *answer = ModelledAxis {
                position: motion.position,
                ..ModelledAxis::default()
            };
        }
        if !self.failed {
            self.failed = self.model.tick(set_points, &mut self.answers).is_err();
        }
        for index in 0..self.shares.len() {
            let (Some(sent), Some(feedback)) = (set_points.get(index), feedback.get_mut(index)) else {
                continue;
            };
            match (self.shares[index], self.failed) {
                (Share::None, _) => {}
                (_, false) => self.take(index, sent, feedback),
                (_, true) => {
                    feedback.state = DriveState::Faulted;
                    feedback.faults = FaultSet::default().with(FaultKind::Drive);
                    feedback.motion = KinematicState::at_rest(feedback.motion.position);
                    feedback.latches = Default::default();
                }
            }
        }
        Ok(())
    }

    fn write_input(&mut self, input: &WrittenInput, feedback: &mut Feedback) {
        self.drives.write_input(input, feedback);
    }

    /// A model tells no instant inside an update.
    fn settled(&self, axes: &[AxisId], tolerance: f64, stood: f64) -> Settled {
        let moves = |axis: &AxisId| self.shares.get(usize::from(*axis)) == Some(&Share::Moves);
        if axes.iter().any(moves) {
            return Settled::Unknown;
        }
        self.drives.settled(axes, tolerance, stood)
    }
}
