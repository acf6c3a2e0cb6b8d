//! The motion objects, classes 0x0300 to 0x0302, by their attributes: names, members, limits, the feed override, the mover. All other
//! values that change while the machine runs are in the tags; the services are in [`motion`](super::motion).
//!
//! | attribute | Motion Group | Axis | Coordinate System |
//! |---|---|---|---|
//! | 1 | name, SHORT_STRING | name | name |
//! | 2 | coarse update period, UDINT ns | 0 virtual, 1 servo, USINT | axes: `n UINT, instance UINT × n` |
//! | 3 | axes: `n UINT, instance UINT × n` | maximum speed, LREAL | maximum speed; can be set |
//! | 4 | | maximum acceleration | maximum acceleration; can be set |
//! | 5 | | maximum deceleration | maximum deceleration; can be set |
//! | 6 | | maximum acceleration jerk | maximum acceleration jerk; can be set |
//! | 7 | | maximum deceleration jerk | maximum deceleration jerk; can be set |
//! | 8 | | position units, SHORT_STRING | actual position tolerance, LREAL; can be set |
//! | 9 | | injected faults, UDINT, can be set | command position tolerance, LREAL; can be set |
//! | 10 | | faults that can be injected, UDINT | feed override, REAL, percent, 0 to 200; can be set |
//! | 11 | | Dynamics Configuration Bits, UDINT, 0 to 7; can be set | the last feed override that was not 0, REAL, percent |
//! | 12, 13 | | | LinkLength1, LinkLength2, LREAL |
//! | 14 to 16 | | | BaseOffset1 to BaseOffset3, LREAL |
//! | 17 to 19 | | | EndEffectorOffset1 to EndEffectorOffset3, LREAL |
//! | 20 to 25 | | | ZeroAngleOffset1 to ZeroAngleOffset6, LREAL, degrees |
//! | 12 (axis) | | faults, UDINT: bits of docs/FAULTS.md | |
//! | 26 | | | Dynamics Configuration Bits, UDINT, 0 to 7; can be set |
//! | 27 to 29 | | | of the active move, LREAL: distance to go, length of its path (0: no move is active), seconds to its planned end or its successor (NaN: not known) |
//! | 13 (axis), 30 | | the mover: a [`Mover`](arcline_proto::arcline::motion::Mover) | the mover |
//!
//! Maxima, tolerances and Dynamics Configuration Bits hold for the instructions that are executed afterwards, up to a restart
//! (spec/axis-and-data-types.md §9.6); the numbers of numeric attributes are those of [`Attribute`]. Attribute 10 of a coordinate system is its element of the tag `FeedOverride`, attribute 9 of an axis that of the tag
//! `FaultInject`: bits of docs/FAULTS.md. A value out of range is refused with 0x09.
//!
//! Attributes 12 to 25 are those of a robot (spec/coordinated-instructions.md §22.1), 0 of a Cartesian system.
//! Position units of the axis, per second, per second², per second³. Get Attributes All returns all of them in order,
//! but not the mover, whose length changes while the machine runs.

use arcline_controller::image::FEED_OVERRIDE_PERCENT;
use arcline_controller::machine::{Axis, CoordinateSystem, Machine};
use arcline_instruction_set::{Attribute, AxisId, FaultSet, Object as MotionObject, SystemId};
use arcline_proto::arcline::motion::{
    NAME, axis as of_axis, coordinate_system as of_system, encode_instances, group as of_group,
};
use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::{f64_value, no_attribute, short_string, u8_value, u32_value};
use crate::eip::status::unknown;
use crate::plant::{Command, Mover, Right};

/// The objects of one of the three classes.
#[derive(Debug)]
pub(super) struct MotionObjects(pub(super) MotionObject);

/// Objects of a kind; instances count from 1.
pub(super) fn count(machine: &Machine, object: MotionObject) -> usize {
    match object {
        MotionObject::MotionGroup => 1,
        MotionObject::Axis => machine.axes.len(),
        MotionObject::CoordinateSystem => machine.systems.len(),
    }
}

impl Object for MotionObjects {
    fn class(&self) -> u16 {
        self.0.class_code()
    }

    fn name(&self) -> &'static str {
        match self.0 {
            MotionObject::MotionGroup => "Motion Group",
            MotionObject::Axis => "Axis",
            MotionObject::CoordinateSystem => "Coordinate System",
        }
    }

    fn is_motion(&self) -> bool {
        true
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        let last_attribute = match self.0 {
            MotionObject::MotionGroup => of_group::AXES,
            MotionObject::Axis => of_axis::MOVER,
            MotionObject::CoordinateSystem => of_system::MOVER,
        };
        Extent::dense(count(cx.device().plant.machine(), self.0), last_attribute)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let index = usize::try_from(instance).unwrap_or(usize::MAX).wrapping_sub(1);
        if let Some(attribute) = Attribute::numbered(self.0, id) {
            let index = u16::try_from(index).map_err(|_| unknown())?;
            let value = cx
                .image()
                .attribute(cx.device().plant.machine(), attribute, index)
                .ok_or_else(unknown)?;
            return Ok(attribute.encode(value).into());
        }
        match self.0 {
            MotionObject::MotionGroup => group(cx.device().plant.machine(), id),
            MotionObject::Axis => {
                let described = cx.device().plant.machine().axes.get(index).ok_or_else(unknown)?;
                let index = u16::try_from(index).map_err(|_| unknown())?;
                match id {
                    of_axis::INJECTED_FAULTS => word_value(cx.image().injected_faults().nth(index.into())),
                    of_axis::POSSIBLE_FAULTS => word_value(cx.image().possible_faults(AxisId(index))),
                    of_axis::FAULTS => word_value(cx.image().faults(AxisId(index))),
                    of_axis::MOVER => Ok(mover(cx.device().plant.movers().of_axis(AxisId(index)))),
                    id => axis(described, id),
                }
            }
            MotionObject::CoordinateSystem => {
                let described = cx.device().plant.machine().systems.get(index).ok_or_else(unknown)?;
                let index = u16::try_from(index).map_err(|_| unknown())?;
                match id {
                    of_system::FEED_OVERRIDE => real_value(cx.image().feed_overrides().nth(index.into())),
                    of_system::OVERRIDE_BEFORE_HOLD => {
                        real_value(cx.image().feed_override_before_hold(SystemId(index)))
                    }
                    of_system::DISTANCE_TO_GO..=of_system::TIME_LEFT => {
                        let progress = cx.image().progress(SystemId(index)).unwrap_or_default();
                        f64_value(match id {
                            of_system::DISTANCE_TO_GO => progress.remaining,
                            of_system::TIME_LEFT => progress.time_left,
                            _ => progress.length,
                        })
                    }
                    of_system::MOVER => Ok(mover(cx.device().plant.movers().of_system(SystemId(index)))),
                    id => system(described, id),
                }
            }
        }
    }

    fn all(&self) -> &'static [u16] {
        match self.0 {
            MotionObject::MotionGroup => &[1, 2, 3],
            MotionObject::Axis => &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12],
            MotionObject::CoordinateSystem => &[
                1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28,
                29,
            ],
        }
    }

    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Option<usize> {
        if let Some(attribute) = Attribute::numbered(self.0, id) {
            return attribute.is_settable().then(|| attribute.size());
        }
        let settable = match self.0 {
            MotionObject::MotionGroup => false,
            MotionObject::Axis => id == of_axis::INJECTED_FAULTS,
            MotionObject::CoordinateSystem => id == of_system::FEED_OVERRIDE,
        };
        settable.then_some(4)
    }

    /// Each attribute is a command of the plant, which has a right of its own.
    fn right_to_set(&self) -> Right {
        Right::Look
    }

    fn set(&self, cx: &mut ObjectContext<'_, '_>, instance: u32, id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let bytes = *value.first_chunk().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let index = u16::try_from(instance.wrapping_sub(1)).map_err(|_| unknown())?;
        let word = u32::from_le_bytes(bytes);
        let command = match (Attribute::numbered(self.0, id), self.0) {
            (Some(attribute), _) => {
                let value = attribute.decode(value).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
                Command::SetAttribute {
                    attribute,
                    index,
                    value,
                }
            }
            (None, MotionObject::Axis) => {
                let possible = cx.image().possible_faults(AxisId(index)).ok_or_else(unknown)?;
                if word & !possible.bits() != 0 {
                    return Err(CipStatus::INVALID_ATTRIBUTE_VALUE);
                }
                Command::InjectFaults {
                    axis: AxisId(index),
                    bits: word,
                }
            }
            (None, _) => {
                let percent = f32::from_le_bytes(bytes);
                if !FEED_OVERRIDE_PERCENT.contains(&percent) {
                    return Err(CipStatus::INVALID_ATTRIBUTE_VALUE);
                }
                Command::SetFeedOverride {
                    system: SystemId(index),
                    percent,
                }
            }
        };
        cx.apply(command).map(drop)
    }
}

/// The mover of an object as an attribute.
fn mover(mover: Option<&Mover>) -> Bytes {
    mover.map(Mover::encoded).unwrap_or_default().to_bytes()
}

fn group(machine: &Machine, id: u16) -> Result<Bytes, CipStatus> {
    match id {
        NAME => Ok(short_string(&machine.group)),
        of_group::PERIOD => u32_value(u32::try_from(machine.period_ns).unwrap_or(u32::MAX)),
        of_group::AXES => Ok(encode_instances((1..).take(machine.axes.len()))),
        _ => no_attribute(),
    }
}

fn axis(axis: &Axis, id: u16) -> Result<Bytes, CipStatus> {
    match id {
        NAME => Ok(short_string(&axis.name)),
        of_axis::KIND => u8_value(u8::from(!axis.is_virtual())),
        of_axis::UNITS => Ok(short_string(&axis.units)),
        _ => no_attribute(),
    }
}

fn system(system: &CoordinateSystem, id: u16) -> Result<Bytes, CipStatus> {
    match id {
        NAME => Ok(short_string(&system.name)),
        of_system::AXES => Ok(encode_instances(
            system.axes.iter().map(|axis| axis.0.saturating_add(1)),
        )),
        _ => robot(system, id),
    }
}

/// The dimensions of a robot; each attribute has one number.
fn robot(system: &CoordinateSystem, id: u16) -> Result<Bytes, CipStatus> {
    let parameters = system.robot.map(|robot| robot.parameters).unwrap_or_default();
    let numbers = [
        parameters.link_lengths.as_slice(),
        &parameters.base_offsets,
        &parameters.end_effector_offsets,
        &parameters.zero_angles,
    ];
    let index = id.checked_sub(of_system::ROBOT).map(usize::from);
    match index.and_then(|index| numbers.into_iter().flatten().nth(index)) {
        Some(number) => f64_value(*number),
        None => no_attribute(),
    }
}

/// 0x14 where there is none: the tag's name is taken by another one.
fn real_value(value: Option<f32>) -> Result<Bytes, CipStatus> {
    match value {
        Some(value) => Ok(Bytes::copy_from_slice(&value.to_le_bytes())),
        None => no_attribute(),
    }
}

/// 0x14 where there is none: the tag's name is taken by another one.
fn word_value(value: Option<FaultSet>) -> Result<Bytes, CipStatus> {
    match value {
        Some(value) => u32_value(value.bits()),
        None => no_attribute(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_shows_its_geometry() {
        let config = r#"
            [[axis]]
            name = "J1"
            type = "virtual"
            max_speed = 1.0
            max_acceleration = 1.0
            [[axis]]
            name = "J2"
            type = "virtual"
            max_speed = 1.0
            max_acceleration = 1.0
            [[coordinate_system]]
            name = "R"
            type = "delta"
            axes = ["J1", "J2"]
            max_speed = 1.0
            max_acceleration = 1.0
            link_lengths = [12.0, 13.0]
            base_offsets = [14.0, 15.0, 16.0]
            end_effector_offsets = [17.0, 18.0, 19.0]
            zero_angles = [20.0, 21.0, 22.0]
        "#;
        let project = arcline_config::load(config, "test").expect("a configuration that holds");
        let robot = &project.machine.systems[0];
        for id in 12..=22 {
            assert_eq!(system(robot, id), f64_value(id.into()), "attribute {id}");
        }
        assert_eq!(system(robot, 25), f64_value(0.0), "it has no sixth joint");
        assert_eq!(system(robot, 26), no_attribute(), "and nothing behind that");
    }
}
