//! A model of the mechanics behind the drives, which moves axes of a simulated machine in place of their simulated drives.
//!
//! The model receives the answers of the simulated drives, and may change them. From the first tick at which its answer for an axis differs, the
//! axis belongs to the model: its feedback counts as measured, and its switch, markers and stops act on the position of the model. An axis
//! that the model has never changed is exactly the axis of the simulated drive. Units: position units, seconds. Nothing allocates after
//! [`ModelDrives::new`].

use arcline_instruction_set::{AxisId, FaultKind, FaultSet};
use arcline_profile::KinematicState;

use super::machine::{SimulatedAxis, SimulatedDrives};
use crate::{DriveState, Drives, ExchangeLost, Feedback, Following, SetPoint, Settled, WrittenInput};

/// A model of the mechanics behind the drives of a machine.
pub trait MechanicalModel: std::fmt::Debug + Send {
    /// Executes one tick. `axes` holds the answers of the simulated drives, or the set-point of an axis that belongs to the model; the model
    /// overwrites them with its own answers. Axes that the model does not move are included.
    ///
    /// # Errors
    /// [`ModelFailed`]: from then on all axes of the model have the fault `drive`, and the model is not called again.
    fn tick(&mut self, set_points: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), ModelFailed>;
}

/// The failure of a model; the model itself reports the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelFailed;

/// The answer of a model for an axis at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelledAxis {
    /// Machine position of the axis.
    pub position: f64,
    /// Position units per second; `None`: from the displacement since the last tick.
    pub velocity: Option<f64>,
    /// Position units per second²; `None`: from the change of velocity since the last tick.
    pub acceleration: Option<f64>,
    /// The drive reports a fault.
    pub fault: bool,
}

/// The drives of a machine, some of whose axes a model moves.
#[derive(Debug)]
pub struct ModelDrives {
    drives: SimulatedDrives,
    model: Box<dyn MechanicalModel>,
    /// The share of the model in each axis.
    shares: Vec<Share>,
    /// The simulated axes before the present tick.
    before: Vec<Option<SimulatedAxis>>,
    answers: Vec<ModelledAxis>,
    failed: bool,
}

/// The share of a model in an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Share {
    /// The model does not move the axis.
    None,
    /// The model may move the axis, and has not done so yet.
    May,
    /// The model moves the axis.
    Moves,
}

impl ModelDrives {
    /// For the simulated drives of a machine, with the axes that the model may move. The only allocation.
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

    /// Makes the model's answer for one axis its feedback.
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

    /// Unknown: a model has no instants inside an update.
    fn settled(&self, axes: &[AxisId], tolerance: f64, stood: f64) -> Settled {
        let moves = |axis: &AxisId| self.shares.get(usize::from(*axis)) == Some(&Share::Moves);
        if axes.iter().any(moves) {
            return Settled::Unknown;
        }
        self.drives.settled(axes, tolerance, stood)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::super::{Sensor, Settings};
    use super::*;
    use crate::{ArmLatch, HOME_LATCH, Trigger};

    const PERIOD: f64 = 0.001;

    /// Adds an offset to the position of axis 0 from a tick on, and fails at another.
    #[derive(Debug, Clone, Default)]
    struct Off {
        offset: f64,
        from: u32,
        fails: Option<u32>,
        calls: Arc<AtomicU32>,
    }

    impl MechanicalModel for Off {
        fn tick(&mut self, _: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), ModelFailed> {
            let call = self.calls.fetch_add(1, Ordering::Relaxed);
            if call >= self.from {
                axes[0].position += self.offset;
            }
            if self.fails == Some(call) {
                return Err(ModelFailed);
            }
            Ok(())
        }
    }

    fn simulated() -> SimulatedDrives {
        let sensor = Sensor {
            switch: Some([0.05, f64::INFINITY]),
            ..Sensor::default()
        };
        let axis = SimulatedAxis::new(0.0, &Settings::unlimited(40.0, 0.5), sensor);
        SimulatedDrives::new(vec![Some(axis), Some(axis), None], PERIOD)
    }

    fn modelled(model: &Off) -> ModelDrives {
        ModelDrives::new(simulated(), Box::new(model.clone()), &[AxisId(0), AxisId(2)])
    }

    /// Feedback of 100 ticks of a ramp, with the latch of homing armed.
    fn run(drives: &mut dyn Drives) -> Vec<[Feedback; 3]> {
        let mut feedback = [Feedback::default(); 3];
        let ticks = (0..100).map(|tick| {
            let mut set_point = SetPoint {
                enable: true,
                position: f64::from(tick) * PERIOD,
                velocity: 1.0,
                ..SetPoint::default()
            };
            set_point.latches[HOME_LATCH] = Some(ArmLatch {
                number: 1,
                trigger: Trigger::SwitchOn,
                then_marker: false,
            });
            drives
                .exchange(&[set_point; 3], &mut feedback)
                .expect("a simulated exchange");
            feedback
        });
        ticks.collect()
    }

    #[test]
    fn an_axis_that_a_model_leaves_alone_is_that_of_the_simulated_drive() {
        let plain = run(&mut simulated());
        assert_eq!(run(&mut modelled(&Off::default())), plain);
        // Until the model changes its position; the other axis never belongs to the model.
        let off = run(&mut modelled(&Off {
            offset: 0.25,
            from: 40,
            ..Off::default()
        }));
        assert_eq!(off[..40], plain[..40]);
        for (tick, (off, plain)) in off.iter().zip(&plain).enumerate() {
            assert_eq!(off[1], plain[1], "{tick}");
        }
        let sent = |tick: usize| tick as f64 * PERIOD;
        for (tick, off) in off.iter().enumerate().skip(42) {
            assert_eq!(off[0].motion.position, sent(tick) + 0.25, "{tick}");
            assert!(
                (off[0].motion.velocity - 1.0).abs() < 1e-9,
                "of the way in a tick: {off:?}"
            );
            assert_eq!(
                (off[0].following, off[0].state),
                (Following::Measured, DriveState::Enabled)
            );
            assert!((off[0].error + 0.25).abs() < 1e-12, "{off:?}");
        }
    }

    #[test]
    fn latches_close_where_the_model_passes() {
        let latch = |ticks: &[[Feedback; 3]]| {
            let mut closed = (0..)
                .zip(ticks)
                .filter_map(|(tick, axes)| Some((tick, axes[0].latches[HOME_LATCH]?)));
            let first = closed.next().expect("it closes");
            assert!(closed.next().is_none(), "once");
            first
        };
        let plain = latch(&run(&mut simulated()));
        let early = Off {
            offset: 0.02,
            from: 10,
            ..Off::default()
        };
        let (tick, closed) = latch(&run(&mut modelled(&early)));
        assert!(tick + 15 < plain.0, "{tick}, {plain:?}");
        assert!(
            (closed.position - 0.05).abs() < 1e-12 && (0.0..=PERIOD).contains(&closed.before_end_s),
            "{closed:?}"
        );
    }

    #[test]
    fn a_model_that_fails_is_a_fault_of_its_drives_and_is_not_called_again() {
        let model = Off {
            fails: Some(30),
            ..Off::default()
        };
        let plain = run(&mut simulated());
        let failed = run(&mut modelled(&model));
        assert_eq!(model.calls.load(Ordering::Relaxed), 31);
        assert_eq!(failed[..30], plain[..30]);
        for (tick, [of_model, other, _]) in failed.iter().enumerate().skip(30) {
            assert_eq!(of_model.state, DriveState::Faulted, "{tick}");
            assert_eq!(of_model.faults, FaultSet::default().with(FaultKind::Drive));
            assert_eq!(of_model.motion, KinematicState::at_rest(failed[30][0].motion.position));
            assert_eq!(*other, plain[tick][1]);
        }
    }
}
