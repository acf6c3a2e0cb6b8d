//! Options become operands, by their faceplate names. The other operands have the values of a full-speed S-curve.

use arcline_client::{ClientError, Mnemonic, Operands, UnboundOperand};

use super::args::{Arc, AxisMotion, Change, Circle, Direction, Dynamics, Jog, Motion, MoveAxis, Point, Ramps, Rate};

/// Operands of `move`.
pub(super) fn line(position: &Point, dynamics: &Dynamics) -> Result<Operands, ClientError> {
    let operands = Operands::full_speed(Mnemonic::Mclm).with("Position", position.0.clone())?;
    with_dynamics(operands, dynamics)
}

/// Operands of `arc`.
pub(super) fn arc(command: &Arc) -> Result<Operands, ClientError> {
    let Arc {
        position,
        circle,
        direction,
        full,
        dynamics,
        ..
    } = command;
    let (circle_type, point) = match circle {
        Circle { via: Some(point), .. } => (0, point.0.clone()),
        Circle {
            center: Some(point), ..
        } => (1, point.0.clone()),
        Circle {
            radius: Some(radius), ..
        } => (2, vec![*radius]),
        Circle {
            center_offset: Some(point),
            ..
        } => (3, point.0.clone()),
        // The arguments do not parse without one of them.
        Circle { .. } => (0, Vec::new()),
    };
    let Direction { ccw, longest, .. } = direction;
    let direction = i64::from(*ccw || *longest) + if *full { 2 } else { 0 };
    let operands = Operands::full_speed(Mnemonic::Mccm)
        .with("Position", position.0.clone())?
        .with("Circle Type", UnboundOperand::Integer(circle_type))?
        .with("Via/Center/Radius", point)?
        .with("Direction", UnboundOperand::Integer(direction))?;
    with_dynamics(operands, dynamics)
}

fn with_dynamics(mut operands: Operands, dynamics: &Dynamics) -> Result<Operands, ClientError> {
    let Dynamics {
        relative,
        speed,
        motion,
        termination,
        merge,
    } = dynamics;
    operands = operands.with("Move Type", UnboundOperand::Integer(i64::from(*relative)))?;
    operands = with_rate(operands, "Speed", "Speed Units", speed.speed)?;
    operands = with_profile(operands, motion)?;
    for (name, value) in [("Termination Type", termination), ("Merge", merge)] {
        if let Some(value) = value {
            operands = operands.with(name, UnboundOperand::Integer(i64::from(*value)))?;
        }
    }
    Ok(operands)
}

/// Operands of `move-axis`.
pub(super) fn axis(command: &MoveAxis) -> Result<Operands, ClientError> {
    let MoveAxis {
        position,
        relative,
        shortest,
        positive,
        negative,
        speed,
        motion,
        ..
    } = command;
    let ways = [*relative, *shortest, *positive, *negative];
    let kind = ways.iter().position(|way| *way).map_or(0, |index| index as i64 + 1);
    let operands = Operands::full_speed(Mnemonic::Mam)
        .with("Move Type", UnboundOperand::Integer(kind))?
        .with("Position", *position)?;
    let operands = with_rate(operands, "Speed", "Speed Units", speed.speed)?;
    with_motion(operands, motion)
}

/// Operands of `jog`: the sign of the speed is the direction.
pub(super) fn jog(command: &Jog) -> Result<Operands, ClientError> {
    let (reverse, speed) = match command.speed {
        Rate::Units(speed) => (speed < 0.0, Rate::Units(speed.abs())),
        Rate::Percent(speed) => (speed < 0.0, Rate::Percent(speed.abs())),
    };
    let operands =
        Operands::full_speed(Mnemonic::Maj).with("Direction", UnboundOperand::Integer(i64::from(reverse)))?;
    let operands = with_rate(operands, "Speed", "Speed Units", Some(speed))?;
    with_motion(operands, &command.motion)
}

fn with_motion(operands: Operands, motion: &AxisMotion) -> Result<Operands, ClientError> {
    let operands = with_profile(operands, &motion.motion)?;
    operands.with("Merge", UnboundOperand::Integer(i64::from(motion.merge)))
}

fn with_profile(operands: Operands, motion: &Motion) -> Result<Operands, ClientError> {
    let Ramps { accel, decel } = motion.ramps;
    let operands = with_rate(operands, "Accel Rate", "Accel Units", accel)?;
    let operands = with_rate(operands, "Decel Rate", "Decel Units", decel)?;
    if motion.trapezoid {
        operands.with("Profile", UnboundOperand::Integer(0))
    } else {
        Ok(operands)
    }
}

/// Operands of `change`.
pub(super) fn change(command: &Change) -> Result<Operands, ClientError> {
    let Change {
        speed, ramps, pending, ..
    } = command;
    let mut operands =
        Operands::full_speed(Mnemonic::Mccd).with("Scope", UnboundOperand::Integer(i64::from(*pending)))?;
    for (flag, name, units, rate) in [
        ("Change Speed", "Speed", "Speed Units", speed.speed),
        ("Change Accel", "Accel Rate", "Accel Units", ramps.accel),
        ("Change Decel", "Decel Rate", "Decel Units", ramps.decel),
    ] {
        operands = operands.with(flag, UnboundOperand::Integer(i64::from(rate.is_some())))?;
        operands = with_rate(operands, name, units, rate)?;
    }
    Ok(operands)
}

fn with_rate(operands: Operands, name: &str, units: &str, rate: Option<Rate>) -> Result<Operands, ClientError> {
    match rate {
        None => Ok(operands),
        Some(Rate::Units(value)) => operands.with(name, value)?.with(units, UnboundOperand::Integer(UNITS)),
        Some(Rate::Percent(value)) => operands
            .with(name, value)?
            .with(units, UnboundOperand::Integer(PERCENT)),
    }
}

/// Units per second (squared), the word 0 of every units operand.
const UNITS: i64 = 0;
/// Percent of the maximum.
const PERCENT: i64 = 1;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{Axis, Speed, System};

    fn operand(operands: &Operands, name: &str) -> UnboundOperand {
        let instruction = operands.mnemonic().instruction();
        let index = instruction.operand(name).expect("an operand");
        let index = instruction
            .operands_behind_control()
            .position(|place| place == index)
            .expect("an operand behind the control");
        operands.as_slice()[index].clone()
    }

    fn number(operands: &Operands, name: &str) -> f64 {
        match operand(operands, name) {
            UnboundOperand::Number(number) => number,
            UnboundOperand::Integer(number) => number as f64,
            other => panic!("{name} is {other}"),
        }
    }

    #[test]
    fn a_plain_move_is_a_full_speed_s_curve() {
        let operands = line(&Point(vec![1.0, 2.0]), &Dynamics::default()).expect("operands");
        assert_eq!(operand(&operands, "Position"), UnboundOperand::Array(vec![1.0, 2.0]));
        for (name, value) in [
            ("Move Type", 0.0),
            ("Speed", 100.0),
            ("Speed Units", 1.0),
            ("Accel Units", 1.0),
            ("Profile", 1.0),
            ("Accel Jerk", 100.0),
            ("Jerk Units", 2.0),
            ("Termination Type", 0.0),
            ("Merge", 0.0),
        ] {
            assert_eq!(number(&operands, name), value, "{name}");
        }
    }

    fn ramps(accel: Rate) -> Ramps {
        Ramps {
            accel: Some(accel),
            decel: None,
        }
    }

    #[test]
    fn options_set_operands() {
        let dynamics = Dynamics {
            relative: true,
            speed: Speed {
                speed: Some(Rate::Units(50.0)),
            },
            motion: Motion {
                ramps: ramps(Rate::Percent(20.0)),
                trapezoid: true,
                ..Motion::default()
            },
            termination: Some(1),
            merge: Some(2),
        };
        let operands = line(&Point(vec![1.0]), &dynamics).expect("operands");
        for (name, value) in [
            ("Move Type", 1.0),
            ("Speed", 50.0),
            ("Speed Units", 0.0),
            ("Accel Rate", 20.0),
            ("Accel Units", 1.0),
            ("Decel Rate", 100.0),
            ("Decel Units", 1.0),
            ("Profile", 0.0),
            ("Termination Type", 1.0),
            ("Merge", 2.0),
        ] {
            assert_eq!(number(&operands, name), value, "{name}");
        }
    }

    #[test]
    fn arcs_take_one_circle_and_one_direction() {
        let point = || Some(Point(vec![5.0, 0.0]));
        #[rustfmt::skip]
        let cases = [
            // circle,                                          direction,                          full,  type, direction
            (Circle { via: point(), ..Circle::default() },           Direction::default(),               false, 0.0, 0.0),
            (Circle { center: point(), ..Circle::default() },        Direction { ccw: true, ..Direction::default() }, false, 1.0, 1.0),
            (Circle { radius: Some(-3.0), ..Circle::default() },     Direction { longest: true, ..Direction::default() }, true, 2.0, 3.0),
            (Circle { center_offset: point(), ..Circle::default() }, Direction { cw: true, ..Direction::default() }, true, 3.0, 2.0),
        ];
        for (circle, direction, full, circle_type, expected) in cases {
            let command = Arc {
                system: System { name: "XY".to_owned() },
                position: Point(vec![10.0, 0.0]),
                circle,
                direction,
                full,
                dynamics: Dynamics::default(),
            };
            let operands = arc(&command).expect("operands");
            assert_eq!(number(&operands, "Circle Type"), circle_type, "{command:?}");
            assert_eq!(number(&operands, "Direction"), expected, "{command:?}");
        }
    }

    #[test]
    fn moves_and_jogs_of_an_axis() {
        let motion = || AxisMotion {
            motion: Motion {
                ramps: ramps(Rate::Units(20.0)),
                ..Motion::default()
            },
            merge: true,
        };
        let command = |ways: [bool; 4]| MoveAxis {
            axis: Axis { name: "R".to_owned() },
            position: 90.0,
            relative: ways[0],
            shortest: ways[1],
            positive: ways[2],
            negative: ways[3],
            speed: Speed::default(),
            motion: motion(),
        };
        for (kind, ways) in [
            (0.0, [false; 4]),
            (1.0, [true, false, false, false]),
            (4.0, [false, false, false, true]),
        ] {
            let operands = axis(&command(ways)).expect("operands");
            assert_eq!(number(&operands, "Move Type"), kind);
            assert_eq!(number(&operands, "Position"), 90.0);
            assert_eq!(
                (number(&operands, "Accel Rate"), number(&operands, "Merge")),
                (20.0, 1.0)
            );
        }
        for (speed, direction, units) in [(Rate::Units(-5.0), 1.0, 0.0), (Rate::Percent(5.0), 0.0, 1.0)] {
            let command = Jog {
                axis: Axis { name: "X".to_owned() },
                speed,
                motion: motion(),
            };
            let operands = jog(&command).expect("operands");
            assert_eq!(
                (number(&operands, "Direction"), number(&operands, "Speed")),
                (direction, 5.0)
            );
            assert_eq!(
                (number(&operands, "Speed Units"), number(&operands, "Accel Units")),
                (units, 0.0)
            );
        }
    }

    #[test]
    fn a_change_changes_only_the_named_operands() {
        let command = Change {
            system: System { name: "CS1".to_owned() },
            speed: Speed {
                speed: Some(Rate::Percent(20.0)),
            },
            ramps: Ramps {
                accel: None,
                decel: Some(Rate::Units(300.0)),
            },
            pending: true,
        };
        let operands = change(&command).expect("operands");
        for (name, value) in [
            ("Motion Type", 1.0),
            ("Change Speed", 1.0),
            ("Speed", 20.0),
            ("Speed Units", 1.0),
            ("Change Accel", 0.0),
            ("Change Decel", 1.0),
            ("Decel Rate", 300.0),
            ("Decel Units", 0.0),
            ("Scope", 1.0),
        ] {
            assert_eq!(number(&operands, name), value, "{name}");
        }
    }
}
