//! The order of a tick: the commands of all axes, the check of their limits, one exchange with all drives, and the use of the feedback.
//!
//! Not here: instructions ([`Motion::execute`]) and the end of a tick ([`Motion::finish`]). Real-time: no allocation; bounded by the
//! axes and coordinate systems and by a fixed number of moves.

use arcline_drive::Drives;
use arcline_instruction_set::{Flag, SystemId};

use super::Motion;

impl Motion {
    /// Advances the motion to a tick: commands, drives, and the ends of moves, stops and messages before it. Instructions of the tick follow
    /// ([`Motion::execute`]), then [`Motion::finish`].
    pub fn begin(&mut self, tick: u64, drives: &mut dyn Drives) {
        self.clock.tick = tick;
        self.controls.begin_tick(tick);
        self.finish_messages();
        self.compute_commands();
        self.limit_commands();
        self.write_set_points();
        let answered = drives.exchange(&self.set_points, &mut self.feedback);
        self.take_feedback(answered.is_ok(), drives);
    }

    /// The rest of [`Motion::begin`] after the exchange with the drives: uses the feedback of all axes, or that none came.
    pub(super) fn take_feedback(&mut self, answered: bool, drives: &dyn Drives) {
        self.note_feedback(answered);
        self.use_feedback(drives);
        self.check_transforms();
        self.check_faults();
        self.finish_stops();
        self.show_status();
        self.axes.let_rest(self.clock.tick);
    }

    /// Calculates the commands of all axes at the present tick: coordinate systems, then axes; followers after their masters.
    fn compute_commands(&mut self) {
        self.axes.exchanged = false;
        for index in self.systems.ids() {
            // A system that follows a master is advanced after it.
            if self.systems[index].is_busy() && !self.systems[index].follows() {
                self.advance_system(index);
            }
        }
        self.advance_axes();
    }

    /// Writes the set-points of all axes. Before that, `self.set_points` are those of the last exchange.
    fn write_set_points(&mut self) {
        for (axis, set_point) in self.axes.iter().zip(&mut self.set_points) {
            if !axis.dormant {
                axis.write_set_point(set_point);
            }
        }
    }

    /// Takes over the feedback of all axes.
    fn note_feedback(&mut self, answered: bool) {
        let values = self.set_points.iter().zip(&self.feedback);
        for (axis, (sent, feedback)) in self.axes.all_mut().zip(values) {
            let feedback = answered.then_some(feedback);
            axis.dormant &= axis.is_unchanged_by(feedback);
            if !axis.dormant {
                axis.take_feedback(feedback, sent, &self.clock);
            }
        }
        self.axes.exchanged = true;
    }

    /// Acts on the feedback of all axes: completed requests to drives, moves and homing that continue inside the update, and the events that
    /// axes wait for.
    fn use_feedback(&mut self, drives: &dyn Drives) {
        self.finish_requests();
        for index in self.systems.ids() {
            self.systems
                .finish_settling(index, drives, &mut self.axes, &mut self.controls, &self.clock);
        }
        for index in self.axes.ids() {
            if self.axes[index].dormant {
                continue;
            }
            let found = self.axes[index].home_was_found(&self.clock);
            if self.axes[index].in_motion() {
                self.axes[index].report(&mut self.controls, &self.clock);
            }
            let axis = &mut self.axes[index];
            if found && let Some(ended) = axis.homing.take() {
                axis.homed = true;
                self.controls.end_move(ended.execution, Flag::Pc.mask());
            }
            if self.axes[index].awaits_events() {
                self.check_events(index);
            }
            self.axes[index].fold(&self.clock);
        }
    }

    /// Ends the stops whose axes stand.
    fn finish_stops(&mut self) {
        for system in self.systems.iter_mut() {
            system.finish_braking(&self.axes);
            system.finish_stop(&self.axes, &mut self.controls);
        }
        self.finish_group_stop();
    }

    /// Updates the status of instructions and coordinate systems to the present tick.
    fn show_status(&mut self) {
        for system in self.systems.iter_mut() {
            system.update_tolerance(&self.axes);
        }
        self.show_transforms();
        self.show_links();
    }

    /// Advances a coordinate system to the present tick.
    pub(super) fn advance_system(&mut self, index: SystemId) {
        let Motion {
            systems,
            axes,
            controls,
            clock,
            ..
        } = self;
        systems.advance(index, axes, controls, clock);
    }

    /// Calculates only the commands of a coordinate system at the present tick.
    pub(super) fn sample_system(&mut self, index: SystemId) {
        self.systems[index].sample(&mut self.axes, &mut self.controls, &self.clock);
    }
}
