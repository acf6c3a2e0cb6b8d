//! The order of a tick: commands of all axes, what none of them may ask of a drive, one exchange with all drives, then what the feedback says.
//!
//! Not here: instructions ([`Motion::execute`]) and the end of a tick ([`Motion::finish`]). Real-time: no allocation; bounded by the
//! axes and coordinate systems and by a fixed number of moves.

use arcline_instruction_set::Flag;

use super::Motion;

impl Motion {
    /// Brings everything to a tick: commands, drives, and the ends of moves, stops and messages that lie before it. Instructions
    /// of the tick follow ([`Motion::execute`]), then [`Motion::finish`].
    pub fn begin(&mut self, tick: u64) {
        self.clock.tick = tick;
        self.finish_messages();
        self.compute_commands();
        self.limit_commands();
        self.exchange();
        self.take_feedback();
        self.look_after_transforms();
        self.check_faults();
        self.finish_stops();
        self.show_status();
    }

    /// Commands of all axes at the present tick: coordinate systems, then axes, what follows behind what it follows.
    fn compute_commands(&mut self) {
        self.axes.exchanged = false;
        for index in 0..self.systems.len() {
            // Behind its masters otherwise.
            if self.systems[index].is_busy() && !self.systems[index].follows() {
                self.advance_system(index);
            }
        }
        self.advance_axes();
    }

    /// Gives the set-points of all axes to the drives and lets these follow. The set-points of the last exchange are in
    /// `self.set_points` until then.
    fn exchange(&mut self) {
        for (axis, set_point) in self.axes.iter_mut().zip(&mut self.set_points) {
            *set_point = axis.set_point();
            axis.exchange(&self.clock);
        }
        self.axes.exchanged = true;
    }

    /// What the feedback of all axes says: where they are, what came to its end, what axes look out for.
    fn take_feedback(&mut self) {
        for axis in self.axes.iter_mut() {
            axis.take_feedback(&self.clock);
        }
        for index in 0..self.axes.len() {
            let found = self.axes[index].home_was_found();
            if self.axes[index].in_motion() {
                self.report_generators(index as u16);
            }
            let axis = &mut self.axes[index];
            if found && let Some(ended) = axis.homing.take() {
                axis.homed = true;
                self.end_move(ended.execution, Flag::Pc.mask());
            }
            self.look_out(index as u16);
            self.axes[index].fold(&self.clock);
        }
    }

    /// Stops that are over.
    fn finish_stops(&mut self) {
        for index in 0..self.systems.len() {
            self.finish_braking(index);
            self.finish_stop(index);
        }
        self.finish_group_stop();
    }

    /// What instructions and coordinate systems show of the present tick.
    fn show_status(&mut self) {
        self.update_tolerances();
        self.show_transforms();
        self.show_links();
    }
}
