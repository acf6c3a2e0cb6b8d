//! The causes that break links to masters, and the status of all links (spec/coordinated-instructions.md §8.3, §8.9).
//!
//! Not here: the links of one axis or coordinate system. Real-time: no allocation; bounded by the axes and the coordinate systems.

use arcline_instruction_set::AxisId;

use super::Motion;

impl Motion {
    /// Breaks every link of an axis and of its coordinate systems as slaves. The motions that these links drive brake.
    pub(crate) fn unlink_slave(&mut self, axis: AxisId) {
        self.axes[axis].unlink(&mut self.controls, &self.clock);
        for index in self.systems.ids() {
            if self.systems[index].has(axis) {
                self.systems.unlink(index, &mut self.controls, &self.clock);
            }
        }
    }

    /// Breaks every link of the slaves of a master, including those to other masters.
    pub(crate) fn unlink_master(&mut self, master: AxisId) {
        for index in self.systems.ids() {
            if self.systems[index].has_master(master) {
                self.systems.unlink(index, &mut self.controls, &self.clock);
                for member in 0..self.systems[index].description.axes.len() {
                    self.unlink_slave(self.systems[index].description.axes[member]);
                }
            }
        }
        for axis in self.axes.ids() {
            if self.axes[axis].is_linked_to(master) {
                self.unlink_slave(axis);
            }
        }
    }

    /// Breaks every link.
    pub(crate) fn unlink_all(&mut self) {
        for axis in self.axes.ids() {
            self.axes[axis].unlink(&mut self.controls, &self.clock);
        }
        for index in self.systems.ids() {
            self.systems.unlink(index, &mut self.controls, &self.clock);
        }
    }

    /// Updates AC of links as soon as a motion by a link begins or ends.
    pub(crate) fn show_links(&mut self) {
        // Called in every tick, and few machines have a link.
        if self.link_numbers.is_unused() {
            return;
        }
        for system in self.systems.iter_mut() {
            system.show_links(&mut self.controls);
        }
        for axis in self.axes.awake_mut() {
            axis.show_links(&mut self.controls);
        }
    }
}
