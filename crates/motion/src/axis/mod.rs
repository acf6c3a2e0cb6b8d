//! One axis: its state, its drive, and what moves it.

mod average;
pub(crate) mod camming;
mod drive_link;
pub(crate) mod faults;
pub(crate) mod feed;
mod following;
pub(crate) mod generator;
pub(crate) mod homing;
pub(crate) mod probes;
mod redefine;
pub(crate) mod sum;

use arcline_instruction_set::ExceptionAction;
use arcline_planner::profile::{Bounds, Jerk, Limits, Profile};
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use crate::control::Execution;
use crate::dynamics::Maxima;
use crate::machine::{Axis as Description, AxisKind, CommandLimits, Home, ProgrammedStopMode};
use crate::masters::cam::Cam;
use crate::masters::links::AxisMasterLinks;
use crate::output::OutputCams;
use average::Average;
use camming::Cams;
use drive_link::DriveLink;
use faults::Faults;
use feed::Feeding;
use following::TransformPart;
use generator::Generator;
use homing::Homing;
use probes::{Registration, Watch};
use sum::{Slot, Sum};

/// The axis state machine (spec/axis-and-data-types.md §12), as far as instructions see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxisState {
    /// Ready, servo off.
    Stopped,
    /// MSO is under way.
    Starting,
    /// Servo on: the drive follows the command.
    Running,
    /// MSF is under way.
    Stopping,
    /// A fault brakes the axis; the servo goes off when it stands.
    Aborting,
    /// A fault has switched the servo off.
    Faulted,
    /// Shut down until a shutdown reset.
    Shutdown,
}

/// What becomes of an axis that has been stopped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum AfterStop {
    /// The servo stays on.
    #[default]
    Hold,
    /// Servo off.
    Disable,
    /// Shutdown.
    Shutdown,
}

/// An axis at the present tick.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) state: AxisState,
    /// What it gives to its drive and has from it.
    pub(crate) link: DriveLink,
    /// Where the feedback of the last exchange says that the axis is.
    pub(crate) actual: KinematicState,
    /// What [`Sum::command`] says at the present tick.
    pub(crate) command: KinematicState,
    pub(crate) sum: Sum,
    /// Something began since the command of this tick was computed.
    pub(crate) stale: bool,
    pub(crate) homed: bool,
    pub(crate) home: Home,
    pub(crate) homing: Option<Homing>,
    /// Homing came to its end within the update.
    home_reached: bool,
    /// The home event of the last MAH came.
    pub(crate) home_event: bool,
    /// What positions were shifted by so far without motion: who follows the axis subtracts its changes.
    pub(crate) redefined: f64,
    /// Command and actual position when the last motion began.
    pub(crate) started_at: [f64; 2],
    pub(crate) dynamics: Maxima,
    /// The Dynamics Configuration Bits.
    pub(crate) bounds: Bounds,
    /// How far from 0 it can be, position units.
    pub(crate) range: f64,
    pub(crate) unwind: Option<f64>,
    pub(crate) is_virtual: bool,
    pub(crate) transforms: TransformPart,
    /// Links to masters (MDAC).
    pub(crate) links: AxisMasterLinks,
    /// Of position cams, and of time cams.
    pub(super) cams: [Cams; 2],
    pub(crate) stop_mode: ProgrammedStopMode,
    /// What happens when the stop that is under way has ended.
    pub(crate) after_stop: AfterStop,
    /// Command and actual position at the last MGSP, as shown.
    pub(crate) strobed: [f64; 2],
    pub(crate) faults: Faults,
    /// What its set-points may ask of it.
    pub(crate) command_limits: CommandLimits,
    pub(crate) average: Average,
    /// Where the position of an encoder comes from: it has no drive.
    pub(crate) feeding: Option<Feeding>,
    pub(crate) watch: Watch,
    pub(crate) registrations: [Registration; 2],
    pub(crate) outputs: OutputCams,
}

impl Axis {
    /// `clock`: at the first tick.
    pub(crate) fn new(description: &Description, clock: &Clock) -> Self {
        let start = &description.start;
        let position = start.position;
        let state = match &description.kind {
            AxisKind::Virtual => AxisState::Running,
            AxisKind::Servo if start.servo_on => AxisState::Starting,
            AxisKind::Servo | AxisKind::Feedback => AxisState::Stopped,
        };
        let faults = Faults::new(description);
        let state = match faults.strongest() {
            Some(ExceptionAction::Shutdown) => AxisState::Shutdown,
            Some(ExceptionAction::StopDrive) if state == AxisState::Stopped => AxisState::Faulted,
            _ => state,
        };
        Axis {
            state,
            link: DriveLink::default(),
            actual: KinematicState::at_rest(position),
            command: KinematicState::at_rest(position),
            sum: Sum::at_rest(position),
            stale: false,
            homed: start.homed,
            home: description.home,
            homing: None,
            home_reached: false,
            home_event: false,
            redefined: start.redefined,
            started_at: [position; 2],
            dynamics: Maxima::from(description),
            bounds: description.dynamics_bits,
            range: description.range(clock.period()),
            unwind: description.unwind,
            is_virtual: description.is_virtual(),
            transforms: TransformPart::default(),
            links: AxisMasterLinks::default(),
            cams: Default::default(),
            stop_mode: description.programmed_stop_mode,
            after_stop: AfterStop::Hold,
            strobed: [0.0; 2],
            feeding: description
                .inputs
                .feed
                .as_ref()
                .map(|feed| Feeding::new(feed, position)),
            watch: Watch::default(),
            registrations: description
                .inputs
                .registration
                .each_ref()
                .map(|input| Registration::new(input.is_some())),
            faults,
            command_limits: description.command_limits,
            average: Average::new(
                position - start.redefined,
                description.average_velocity_timebase,
                clock.period(),
            ),
            outputs: OutputCams::new(description.output_cam_targets, clock),
        }
    }

    /// Whether something moves the axis, or holds it to move it.
    pub(crate) fn in_motion(&self) -> bool {
        self.transforms.controlled || self.moves_itself()
    }

    /// The same, but for transforms.
    pub(crate) fn moves_itself(&self) -> bool {
        self.sum.is_active_but(Slot::Transform)
    }

    /// Whether its drive follows the command.
    pub(crate) fn has_torque(&self) -> bool {
        matches!(
            self.state,
            AxisState::Running | AxisState::Starting | AxisState::Aborting
        )
    }

    /// Whether something moves the axis that comes to an end by itself: not a jog, not what follows others, nor what waits
    /// for a master. Of coordinated motion its system tells.
    pub(crate) fn will_end(&self) -> bool {
        let endless = |slot| match slot {
            Slot::Jog | Slot::Gear | Slot::Transform | Slot::System => true,
            Slot::PositionCam | Slot::TimeCam => !self.cam(slot).is_some_and(Cam::will_end),
            _ => false,
        };
        let waits = |generator: &Generator| generator.guide.is_some_and(|guide| !guide.will_go_on());
        let mut active = self.sum.active();
        active.any(|(slot, generator)| generator.stopping || !(endless(slot) || waits(generator)))
    }

    /// Whether the axis as a whole brakes: everything on it, or its part of a coordinated move that was ended.
    pub(crate) fn is_stopping(&self) -> bool {
        let braking = |slot| {
            let generator = self.sum.get(slot);
            generator.is_some_and(|generator| generator.stopping || generator.ending)
        };
        braking(Slot::Stop) || braking(Slot::System)
    }

    /// Whether anything on the axis brakes that a coordinate system's stop waits for.
    pub(crate) fn is_braking(&self) -> bool {
        self.is_stopping() || self.sum.is_active(Slot::Parting)
    }

    /// Whether a coordinate system moves the axis, and not only its brake.
    pub(crate) fn is_coordinated(&self) -> bool {
        self.sum.get(Slot::System).is_some_and(|generator| !generator.stopping)
    }

    /// Whether coordinated motion moves the axis still: a move, or the brake of one that was ended.
    pub(crate) fn has_coordinated_motion(&self) -> bool {
        self.sum.is_active(Slot::System) || self.sum.get(Slot::Stop).is_some_and(|stop| stop.coordinated)
    }

    /// A stop of everything on the axis brakes its coordinated motion on the path.
    pub(crate) fn end_on_path(&mut self) {
        if let Some(generator) = self.sum.get_mut(Slot::System) {
            generator.ending = true;
        }
    }

    /// Whether one does.
    pub(crate) fn is_ending_on_path(&self) -> bool {
        self.sum.get(Slot::System).is_some_and(|generator| generator.ending)
    }

    /// The axis becomes part of a coordinated move that starts where the axis is commanded to be.
    pub(crate) fn join(&mut self, s_curve: bool) {
        self.begin(Slot::System, Generator::followed(s_curve));
    }

    /// A generator begins at the present command.
    pub(crate) fn begin(&mut self, slot: Slot, generator: Generator) {
        if slot == Slot::MasterOffset {
            self.note_offset(true);
        } else {
            self.mark_start();
        }
        self.sum.begin(slot, generator);
        self.command = self.sum.command();
    }

    /// The present positions are those at which the last motion began.
    pub(crate) fn mark_start(&mut self) {
        self.started_at = [self.command.position, self.actual.position];
    }

    /// A coordinate system says where its part of the axis's motion is.
    pub(crate) fn set_coordinated(&mut self, now: KinematicState) {
        self.sum.set(Slot::System, now);
        self.command = self.sum.command();
    }

    /// The coordinated motion of the axis is over; it stands where it is, but for what else moves it.
    pub(crate) fn release(&mut self) {
        self.end(Slot::System);
    }

    /// Ends a generator where it is; its speed is gone at once.
    pub(crate) fn end(&mut self, slot: Slot) -> Option<Generator> {
        if !self.sum.is_active(slot) {
            return None;
        }
        if slot == Slot::MasterOffset {
            self.note_offset(false);
        }
        let ended = self.sum.end(slot);
        self.command = self.sum.command();
        ended
    }

    /// One generator brakes, out of what it does now, and reports to `execution` when it stands. Whoever had
    /// begun it is told nothing here. A stop that is under way only becomes harder.
    pub(crate) fn brake(&mut self, slot: Slot, limits: &Limits, execution: Option<Execution>, now: Instant) {
        let Some(generator) = self.sum.get_mut(slot) else {
            return;
        };
        let limits = &harder(limits, generator.brake.as_ref());
        let mut from = generator.now;
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let before = generator.in_force.filter(|_| generator.guide.is_none());
        let kept = stopping(limits, before.as_ref());
        let stop = Profile::stop_within(from, limits, before.as_ref(), self.bounds);
        generator.jerk = generator.highest_jerk();
        // A stop is a function of time, whatever it stops.
        generator.guide = None;
        generator.follow(stop, now);
        generator.keeps(&kept);
        generator.execution = execution;
        generator.program = None;
        generator.stopping = true;
        generator.brake = Some(*limits);
    }

    /// One generator is being stopped by its own profile, and reports to `execution` when it stands.
    pub(crate) fn let_rest(&mut self, slot: Slot, execution: Option<Execution>) {
        if let Some(generator) = self.sum.get_mut(slot) {
            generator.jerk = generator.highest_jerk();
            generator.execution = execution;
            generator.program = None;
            generator.stopping = true;
        }
    }

    /// The stop with which the axis is kept from leading a robot where that cannot go: at its maxima, with no less jerk than what moves
    /// it was programmed with.
    pub(crate) fn guarded_stop(&self) -> Limits {
        let mut limits = self.dynamics.stop(self.is_s_curve());
        if let Some(jerk) = &mut limits.jerk {
            let programmed = self.sum.active().map(|(_, generator)| generator.highest_jerk());
            let highest = programmed.fold(jerk.deceleration, f64::max);
            (jerk.acceleration, jerk.deceleration) = (highest, highest);
        }
        limits
    }

    /// Everything on the axis becomes one deceleration, out of its total speed and acceleration. Whoever had
    /// begun it is told nothing here. It is at least as hard as every stop under way.
    pub(crate) fn brake_all(&mut self, limits: &Limits, execution: Option<Execution>, now: Instant) {
        let brakes = self.sum.active().filter_map(|(_, generator)| generator.brake);
        let limits = &brakes.fold(*limits, |limits, brake| harder(&limits, Some(&brake)));
        let mut from = self.command;
        if limits.jerk.is_none() {
            from.acceleration = 0.0;
        }
        let started_at = self.started_at;
        let before = self.sum.in_force(|_| true);
        let profile = Profile::stop_within(from, limits, before.as_ref(), self.bounds);
        let mut stop = Generator::planned(profile, now);
        stop.keeps(&stopping(limits, before.as_ref()));
        stop.execution = execution;
        stop.stopping = true;
        stop.brake = Some(*limits);
        stop.s_curve = limits.jerk.is_some();
        stop.parting = self.is_parting();
        stop.coordinated = self.has_coordinated_motion();
        self.after_stop = AfterStop::Hold;
        self.sum.place(from.position);
        self.begin(Slot::Stop, stop);
        self.started_at = started_at;
    }

    /// One deceleration at its Maximum Deceleration becomes all that moves the axis, from a set-point that went out at `began`.
    pub(crate) fn brake_from(&mut self, last: KinematicState, began: Instant) {
        let limits = self.dynamics.stop(false);
        self.after_stop = AfterStop::Hold;
        self.sum.place(last.position);
        self.command = KinematicState::at_rest(last.position);
        if limits.deceleration <= 0.0 {
            return;
        }
        let mut stop = Generator::planned(Profile::stop(last, &limits), began);
        stop.stopping = true;
        stop.brake = Some(limits);
        let started_at = self.started_at;
        self.begin(Slot::Stop, stop);
        self.started_at = started_at;
    }

    /// Whether a master or a transform decides how the velocity of the axis changes.
    pub(crate) fn follows_a_master(&self) -> bool {
        let mut active = self.sum.active();
        active.any(|(slot, generator)| {
            generator.guide.is_some()
                || matches!(
                    slot,
                    Slot::Gear | Slot::PositionCam | Slot::TimeCam | Slot::Transform | Slot::MasterOffset
                )
        })
    }

    /// What single-axis instructions began, and a stop of it, becomes one deceleration; what a coordinate system or a transform
    /// gives goes on. Whoever had begun it is told nothing here.
    pub(crate) fn brake_own(&mut self, limits: &Limits, now: Instant) {
        let moved = self.sum.motion_of(Slot::is_own);
        let from = KinematicState {
            position: self.command.position,
            velocity: moved.velocity,
            acceleration: if limits.jerk.is_some() { moved.acceleration } else { 0.0 },
        };
        let mut stop = Generator::planned(Profile::stop(from, limits), now);
        stop.stopping = true;
        stop.s_curve = limits.jerk.is_some();
        if let Some(earlier) = self.sum.get(Slot::Stop) {
            (stop.parting, stop.coordinated) = (earlier.parting, earlier.coordinated);
        }
        let started_at = self.started_at;
        for slot in Slot::ALL {
            if slot.is_own() {
                self.end(slot);
            }
        }
        self.after_stop = AfterStop::Hold;
        self.begin(Slot::Stop, stop);
        self.started_at = started_at;
    }

    /// Whether anything on the axis is an S-curve: a stop of everything is one then.
    pub(crate) fn is_s_curve(&self) -> bool {
        self.sum.active().any(|(_, generator)| generator.s_curve)
    }

    /// The command at the present tick, but for what a coordinate system or homing gives.
    pub(crate) fn advance(&mut self, clock: &Clock) {
        if !self.sum.is_idle() && !self.is_driven_home() {
            self.follow_time(clock);
            self.sum.advance(clock);
            self.command = self.sum.command();
        }
    }

    /// Whether its servo is off for another reason than a fault or a shutdown.
    pub(crate) fn is_off(&self) -> bool {
        matches!(
            self.state,
            AxisState::Stopped | AxisState::Starting | AxisState::Stopping
        )
    }

    /// Whether a fault keeps it from being moved.
    pub(crate) fn is_faulted(&self) -> bool {
        matches!(self.state, AxisState::Aborting | AxisState::Faulted) || self.faults.block()
    }

    /// Opens the loop: whatever moved the axis is over. Whoever had begun it is told nothing here.
    pub(crate) fn disable(&mut self, state: AxisState) {
        self.state = state;
        self.stale = true;
        if self.is_virtual {
            self.actual = KinematicState::at_rest(self.actual.position);
        }
        self.stand_at(self.command.position);
    }

    /// Closes the loop where the axis stands.
    pub(crate) fn enable(&mut self) {
        self.stand_at(self.actual.position);
        self.state = AxisState::Starting;
        self.stale = true;
    }

    pub(super) fn stand_at(&mut self, position: f64) {
        self.after_stop = AfterStop::Hold;
        self.sum.place(position);
        self.command = KinematicState::at_rest(position);
    }
}

/// The limits of a stop, an acceleration taken away no slower than before.
fn stopping(limits: &Limits, before: Option<&Limits>) -> Limits {
    let mut limits = *limits;
    limits.speed = before.map_or(0.0, |before| before.speed);
    if let (Some(jerk), Some(own)) = (&mut limits.jerk, before.and_then(|before| before.jerk)) {
        jerk.acceleration = jerk.acceleration.max(own.acceleration);
    }
    limits
}

/// The limits of a stop in place of one that brakes at `under_way` already.
fn harder(limits: &Limits, under_way: Option<&Limits>) -> Limits {
    let Some(under_way) = under_way else { return *limits };
    let jerk = limits.jerk.map(|jerk| match under_way.jerk {
        None => jerk,
        Some(other) => Jerk {
            acceleration: jerk.acceleration.max(other.acceleration),
            deceleration: jerk.deceleration.max(other.deceleration),
        },
    });
    Limits {
        acceleration: limits.acceleration.max(under_way.acceleration),
        deceleration: limits.deceleration.max(under_way.deceleration),
        jerk,
        ..*limits
    }
}
