//! One axis: its state, its drive, and the generators that move it.

mod average;
mod braking;
pub(crate) mod camming;
mod drive_link;
mod ending;
pub(crate) mod faults;
pub(crate) mod feed;
mod following;
pub(crate) mod generator;
pub(crate) mod generator_kind;
pub(crate) mod homing;
mod links;
pub(crate) mod probes;
mod redefine;
mod reporting;
pub(crate) mod state;
pub(crate) mod sum;

use arcline_instruction_set::ExceptionAction;
use arcline_planner::Clock;
use arcline_planner::profile::DynamicsBits;
use arcline_profile::KinematicState;

use crate::cause::Cause;
use crate::dynamics::Maxima;
use crate::machine::{Axis as Description, AxisKind, CommandLimits, Home, ProgrammedStopMode};
use crate::masters::cam::Cam;
use crate::masters::links::AxisMasterLinks;
use crate::output::OutputCams;
use average::Average;
use camming::Cams;
use drive_link::DriveLink;
use faults::Faults;
use feed::EncoderFeed;
use following::TransformMembership;
use generator::Generator;
use generator_kind::GeneratorKind;
use homing::Homing;
use probes::{Registration, Watch};
use state::AxisState;
use sum::Sum;

/// The state of an axis after a stop.
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
    /// Its side of the exchange with its drive.
    pub(crate) link: DriveLink,
    /// The actual motion by the feedback of the last exchange.
    pub(crate) actual: KinematicState,
    /// [`Sum::command`] at the present tick.
    pub(crate) command: KinematicState,
    pub(crate) sum: Sum,
    /// The next tick changes nothing of the axis unless its feedback changes or an instruction acts on it: the tick passes over it.
    pub(crate) dormant: bool,
    /// The tick from which on it is dormant, while it is.
    pub(crate) dormant_since: u64,
    /// A generator has begun since the command of this tick was computed.
    pub(crate) stale: bool,
    pub(crate) homed: bool,
    pub(crate) home: Home,
    /// The values of `home` from the next MAH on.
    pub(crate) next_home: Home,
    pub(crate) homing: Option<Homing>,
    /// Homing reached the home point within the update.
    home_reached: bool,
    /// The home event of the last MAH came.
    pub(crate) home_event: bool,
    /// The sum of all shifts of positions without motion; the followers of the axis subtract its changes.
    pub(crate) redefined: f64,
    /// Command and actual position when the last motion began.
    pub(crate) started_at: [f64; 2],
    pub(crate) dynamics: Maxima,
    /// The Dynamics Configuration Bits.
    pub(crate) dynamics_bits: DynamicsBits,
    /// The greatest distance of its positions from 0, position units.
    pub(crate) range: f64,
    pub(crate) unwind: Option<f64>,
    pub(crate) is_virtual: bool,
    pub(crate) transforms: TransformMembership,
    /// Links to masters (MDAC).
    pub(crate) links: AxisMasterLinks,
    /// The state of its position cams, and of its time cams.
    pub(super) cams: [Cams; 2],
    pub(crate) stop_mode: ProgrammedStopMode,
    /// Its state after the stop that is under way.
    pub(crate) after_stop: AfterStop,
    /// Command and actual position at the last MGSP, as shown.
    pub(crate) strobed: [f64; 2],
    pub(crate) faults: Faults,
    /// The limits of its set-points.
    pub(crate) command_limits: CommandLimits,
    pub(crate) average: Average,
    /// The tag that gives the positions of an encoder, an axis without a drive; `None` for other axes.
    pub(crate) feeding: Option<EncoderFeed>,
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
            dormant: false,
            dormant_since: 0,
            stale: false,
            homed: start.homed,
            home: description.home,
            next_home: description.home,
            homing: None,
            home_reached: false,
            home_event: false,
            redefined: start.redefined,
            started_at: [position; 2],
            dynamics: Maxima::from(description),
            dynamics_bits: description.dynamics_bits,
            range: description.range(clock.period()),
            unwind: description.unwind,
            is_virtual: description.is_virtual(),
            transforms: TransformMembership::default(),
            links: AxisMasterLinks::default(),
            cams: Default::default(),
            stop_mode: description.programmed_stop_mode,
            after_stop: AfterStop::Hold,
            strobed: [0.0; 2],
            feeding: description
                .inputs
                .feed
                .as_ref()
                .map(|feed| EncoderFeed::new(feed, position)),
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

    /// A generator or a transform moves the axis, or reserves it for motion.
    pub(crate) fn in_motion(&self) -> bool {
        self.transforms.controlled || self.moves_itself()
    }

    /// A generator apart from a transform's moves the axis, or reserves it for motion.
    pub(crate) fn moves_itself(&self) -> bool {
        self.sum.is_active_but(GeneratorKind::Transform)
    }

    /// The drive follows the command.
    pub(crate) fn has_torque(&self) -> bool {
        matches!(
            self.state,
            AxisState::Running | AxisState::Starting | AxisState::Aborting
        )
    }

    /// A generator of the axis ends on its own. Jogs, gears, transforms and motion that waits for a master do not; for coordinated motion, ask
    /// the coordinate system.
    pub(crate) fn will_end(&self) -> bool {
        let endless = |kind| match kind {
            GeneratorKind::Jog | GeneratorKind::Gear | GeneratorKind::Transform | GeneratorKind::System => true,
            GeneratorKind::PositionCam | GeneratorKind::TimeCam => !self.cam(kind).is_some_and(Cam::will_end),
            _ => false,
        };
        let waits = |generator: &Generator| generator.follower.is_some_and(|follower| !follower.will_go_on());
        let mut active = self.sum.active();
        active.any(|(kind, generator)| generator.stopping || !(endless(kind) || waits(generator)))
    }

    /// A stop brakes the whole axis: all its generators, or its part of a coordinated move that was ended.
    pub(crate) fn is_stopping(&self) -> bool {
        let braking = |kind| {
            let generator = self.sum.get(kind);
            generator.is_some_and(|generator| generator.stopping || generator.ending)
        };
        braking(GeneratorKind::Stop) || braking(GeneratorKind::System)
    }

    /// A stop brakes the axis, or the motion that a cancelled transform left: the stop of a coordinate system waits for both.
    pub(crate) fn is_braking(&self) -> bool {
        self.is_stopping() || self.sum.is_active(GeneratorKind::TransformStop)
    }

    /// A coordinate system moves the axis, beyond the stop of an ended move.
    pub(crate) fn is_coordinated(&self) -> bool {
        self.sum
            .get(GeneratorKind::System)
            .is_some_and(|generator| !generator.stopping)
    }

    /// Coordinated motion still moves the axis: a move, or the stop of one that was ended.
    pub(crate) fn has_coordinated_motion(&self) -> bool {
        self.sum.is_active(GeneratorKind::System)
            || self.sum.get(GeneratorKind::Stop).is_some_and(|stop| stop.coordinated)
    }

    /// Brakes the coordinated motion on its path, as part of a stop of the whole axis.
    pub(crate) fn end_on_path(&mut self) {
        if let Some(generator) = self.sum.get_mut(GeneratorKind::System) {
            generator.ending = true;
        }
    }

    /// A stop of the whole axis brakes its coordinated motion on the path.
    pub(crate) fn is_ending_on_path(&self) -> bool {
        self.sum
            .get(GeneratorKind::System)
            .is_some_and(|generator| generator.ending)
    }

    /// Begins the coordinated motion of the axis, for a move that starts at the present command position.
    pub(crate) fn begin_coordinated(&mut self, s_curve: bool) {
        self.begin(GeneratorKind::System, Generator::followed(s_curve));
    }

    /// Begins the coordinated motion of the axis, for a move whose path starts at the position that the axis had when the move was executed. The planning
    /// of a contour takes time, and other instructions may have moved the axis since.
    pub(crate) fn begin_coordinated_from(&mut self, s_curve: bool, start: f64) {
        self.mark_start();
        self.sum
            .begin_from(GeneratorKind::System, Generator::followed(s_curve), start);
        self.command = self.sum.command();
    }

    /// A generator begins at the present command.
    pub(crate) fn begin(&mut self, kind: GeneratorKind, generator: Generator) {
        if kind == GeneratorKind::MasterOffset {
            self.note_offset(true);
        } else {
            self.mark_start();
        }
        self.sum.begin(kind, generator);
        self.command = self.sum.command();
    }

    /// Records the present positions as those at which the last motion began.
    pub(crate) fn mark_start(&mut self) {
        self.started_at = [self.command.position, self.actual.position];
    }

    /// Sets the motion of its only generator and its command, as a tick leaves them.
    pub(crate) fn set_sole(&mut self, kind: GeneratorKind, now: KinematicState, command: KinematicState) {
        self.sum.set(kind, now);
        self.sum.keep_displacements();
        self.command = command;
    }

    /// Sets the coordinated part of the axis's motion, which the coordinate system has calculated.
    pub(crate) fn set_coordinated(&mut self, now: KinematicState) {
        self.sum.set(GeneratorKind::System, now);
        self.command = self.sum.command();
    }

    /// Ends the coordinated motion of the axis; its position stays, unless other generators move it.
    pub(crate) fn release(&mut self) {
        self.end(GeneratorKind::System);
    }

    /// Ends a generator; its position stays, and its velocity drops to 0 at once.
    pub(crate) fn end(&mut self, kind: GeneratorKind) -> Option<Generator> {
        if !self.sum.is_active(kind) {
            return None;
        }
        if kind == GeneratorKind::MasterOffset {
            self.note_offset(false);
        }
        let ended = self.sum.end(kind);
        self.command = self.sum.command();
        ended
    }

    /// A master or a transform determines the acceleration of the axis.
    pub(crate) fn follows_a_master(&self) -> bool {
        let mut active = self.sum.active();
        active.any(|(kind, generator)| {
            generator.follower.is_some()
                || matches!(
                    kind,
                    GeneratorKind::Gear
                        | GeneratorKind::PositionCam
                        | GeneratorKind::TimeCam
                        | GeneratorKind::Transform
                        | GeneratorKind::MasterOffset
                )
        })
    }

    /// A generator of the axis has an S-curve profile; a stop of the whole axis then has one too.
    pub(crate) fn is_s_curve(&self) -> bool {
        self.sum.active().any(|(_, generator)| generator.s_curve)
    }

    /// Calculates the command at the present tick, except under homing, which sets its own command.
    pub(crate) fn advance(&mut self, clock: &Clock) {
        if !self.sum.is_idle() && !self.is_driven_home() {
            self.follow_time(clock);
            self.sum.advance(clock);
            self.command = self.sum.command();
        }
    }

    /// The next tick would leave the axis unchanged if its feedback does not change: the axis stands, no motion is under way, no event is
    /// awaited, and no report is pending. Valid at the end of a tick.
    pub(crate) fn can_be_dormant(&self) -> bool {
        let stands = |motion: &KinematicState| motion.velocity == 0.0 && motion.acceleration == 0.0;
        self.sum.is_idle()
            && stands(&self.command)
            && stands(&self.actual)
            && self.average.is_steady()
            && matches!(
                self.state,
                AxisState::Stopped | AxisState::Running | AxisState::Faulted | AxisState::Shutdown
            )
            && self.expects_nothing()
    }

    /// Nothing but its generators and its feedback can change the axis in the next tick: no instruction, event, link or fault is under way.
    /// Valid at the end of a tick.
    pub(crate) fn expects_nothing(&self) -> bool {
        !self.stale
            && !self.transforms.controlled
            && self.homing.is_none()
            && !self.home_reached
            && self.feeding.is_none()
            && self.links.is_empty()
            && self.cams.iter().all(Cams::are_idle)
            && !self.awaits_events()
            && self.is_link_steady()
            && self.faults.are_steady()
    }

    /// Clears its faults. A faulted axis is then stopped; one that is shut down stays so. Returns true if no cause is left that would fault the
    /// axis again at the next update.
    pub(crate) fn reset_faults(&mut self, by: Cause) -> bool {
        let gone = self.faults.reset(by);
        if self.state == AxisState::Faulted {
            self.state = AxisState::Stopped;
        }
        gone
    }

    /// The servo is off for a reason other than a fault or a shutdown.
    pub(crate) fn is_off(&self) -> bool {
        matches!(
            self.state,
            AxisState::Stopped | AxisState::Starting | AxisState::Stopping
        )
    }

    /// A fault prevents motion of the axis.
    pub(crate) fn is_faulted(&self) -> bool {
        matches!(self.state, AxisState::Aborting | AxisState::Faulted) || self.faults.block()
    }

    /// Opens the loop and ends all motion of the axis. The instructions that began the motion do not end here.
    pub(crate) fn disable(&mut self, state: AxisState) {
        self.state = state;
        self.stale = true;
        if self.is_virtual {
            self.actual = KinematicState::at_rest(self.actual.position);
        }
        self.stand_at(self.command.position);
    }

    /// Closes the loop at the position at which the axis stands.
    pub(crate) fn enable(&mut self) {
        self.stand_at(self.actual.position);
        self.state = AxisState::Starting;
        self.stale = true;
    }

    pub(super) fn stand_at(&mut self, position: f64) {
        self.after_stop = AfterStop::Hold;
        self.sum.set_position(position);
        self.command = KinematicState::at_rest(position);
    }
}
