//! The Dynamics Configuration Bits of axes and coordinate systems, which clients set while the machine runs
//! (spec/axis-and-data-types.md §9.6).

use arcline_instruction_set::{AxisId, Object, SystemId};

use crate::machine::DynamicsBits;
use crate::motion::Motion;

impl Motion {
    /// Sets the Dynamics Configuration Bits of an axis or a coordinate system. Later instructions and stops follow them; a ramp that is planned
    /// already does not change. An index without an object changes nothing. Real-time.
    pub fn set_dynamics_bits(&mut self, object: Object, index: u16, bits: DynamicsBits) {
        match object {
            Object::MotionGroup => {}
            Object::Axis => {
                if let Some(axis) = self.axes.get_mut(AxisId(index)) {
                    axis.dynamics_bits = bits;
                }
            }
            Object::CoordinateSystem => {
                if let Some(system) = self.systems.get_mut(SystemId(index)) {
                    system.travel.set_dynamics_bits(bits);
                }
            }
        }
    }
}
