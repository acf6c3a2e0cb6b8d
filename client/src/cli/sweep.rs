//! The estimated length of an arc, radius times angle, for the progress of `arc`.
//!
//! The estimate begins at the present position. The server defines the arc and refuses an impossible one.

use std::f64::consts::TAU;

use super::args::{Arc, Circle};

type Vector = [f64; 3];

/// The arc, all points relative to its start, in position units.
#[derive(Debug)]
pub(crate) struct Sweep {
    end: Vector,
    circle: Round,
    /// In the plane: counterclockwise. In space: the longer arc.
    other_way: bool,
    full: bool,
    planar: bool,
}

#[derive(Debug)]
enum Round {
    Via(Vector),
    Center(Vector),
    Radius(f64),
}

impl Sweep {
    /// `None` when a point has too few coordinates.
    pub(crate) fn new(start: &[f64], command: &Arc) -> Option<Self> {
        let axes = command.position.0.len();
        let relative = |point: &[f64], is_relative: bool| {
            let mut vector = [0.0; 3];
            for (axis, component) in vector.iter_mut().enumerate().take(axes) {
                let from = if is_relative { 0.0 } else { *start.get(axis)? };
                *component = *point.get(axis)? - from;
            }
            Some(vector)
        };
        let is_relative = command.dynamics.relative;
        let circle = match &command.circle {
            Circle { via: Some(point), .. } => Round::Via(relative(&point.0, is_relative)?),
            Circle {
                center: Some(point), ..
            } => Round::Center(relative(&point.0, is_relative)?),
            Circle {
                center_offset: Some(point),
                ..
            } => Round::Center(relative(&point.0, true)?),
            Circle { radius, .. } => Round::Radius((*radius)?),
        };
        Some(Self {
            end: relative(&command.position.0, is_relative)?,
            circle,
            other_way: command.direction.ccw || command.direction.longest,
            full: command.full,
            planar: axes < 3,
        })
    }

    /// Position units; `None` for an impossible circle.
    pub(crate) fn length(&self) -> Option<f64> {
        let (radius, angle) = match &self.circle {
            Round::Radius(radius) => {
                let angle = 2.0 * (norm(self.end) / (2.0 * radius.abs())).asin();
                (radius.abs(), if *radius < 0.0 { TAU - angle } else { angle })
            }
            Round::Center(center) => (norm(*center), self.angle(*center)),
            Round::Via(via) => {
                let center = circumcenter(*via, self.end);
                let normal = cross(*via, self.end);
                let around = |point| turned(scale(center, -1.0), sub(point, center), normal);
                // The direction of the arc is the one that meets the via point before the end.
                let (to_via, to_end) = (around(*via), around(self.end));
                (norm(center), if to_via <= to_end { to_end } else { TAU - to_end })
            }
        };
        let length = radius * if self.full { TAU } else { angle };
        length.is_finite().then_some(length)
    }

    fn angle(&self, center: Vector) -> f64 {
        let (from, to) = (scale(center, -1.0), sub(self.end, center));
        if self.planar {
            let counterclockwise = turned(from, to, [0.0, 0.0, 1.0]);
            if self.other_way {
                counterclockwise
            } else {
                TAU - counterclockwise
            }
        } else {
            let shorter = norm(cross(from, to)).atan2(dot(from, to));
            if self.other_way { TAU - shorter } else { shorter }
        }
    }
}

/// The angle from one vector to another about a normal, 0 to a full turn.
fn turned(from: Vector, to: Vector, normal: Vector) -> f64 {
    let side = cross(from, to);
    let sine = norm(side).copysign(dot(side, normal));
    sine.atan2(dot(from, to)).rem_euclid(TAU)
}

/// Centre of the circle through the origin and two points.
fn circumcenter(a: Vector, b: Vector) -> Vector {
    let normal = cross(a, b);
    let sum = sub(scale(b, dot(a, a)), scale(a, dot(b, b)));
    // ((|a|² b − |b|² a) × (a × b)) / (2 |a × b|²)
    scale(cross(sum, normal), 1.0 / (2.0 * dot(normal, normal)))
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

fn sub([a0, a1, a2]: Vector, [b0, b1, b2]: Vector) -> Vector {
    [a0 - b0, a1 - b1, a2 - b2]
}

fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|a| a * factor)
}

fn cross([a0, a1, a2]: Vector, [b0, b1, b2]: Vector) -> Vector {
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn arcs_are_as_long_as_they_are() {
        let sweep = |end, circle, other_way, full, planar| Sweep {
            end,
            circle,
            other_way,
            full,
            planar,
        };
        #[rustfmt::skip]
        let cases = [
            // why,                              sweep,                                                                                         length
            ("half a circle by its centre",      sweep([20.0, 0.0, 0.0], Round::Center([10.0, 0.0, 0.0]), false, false, true),  Some(10.0 * PI)),
            ("a quarter clockwise",              sweep([10.0, 10.0, 0.0], Round::Center([10.0, 0.0, 0.0]), false, false, true), Some(5.0 * PI)),
            ("the rest counterclockwise",        sweep([10.0, 10.0, 0.0], Round::Center([10.0, 0.0, 0.0]), true, false, true),  Some(15.0 * PI)),
            ("a full circle",                    sweep([0.0; 3], Round::Center([10.0, 0.0, 0.0]), false, true, true),           Some(20.0 * PI)),
            ("half by its radius",               sweep([20.0, 0.0, 0.0], Round::Radius(10.0), false, false, true),              Some(10.0 * PI)),
            ("too small a radius",               sweep([20.0, 0.0, 0.0], Round::Radius(5.0), false, false, true),               None),
            ("through a point",                  sweep([10.0, 10.0, 0.0], Round::Via([20.0, 0.0, 0.0]), false, false, true),    Some(15.0 * PI)),
            ("through a point in space",         sweep([0.0, 0.0, 20.0], Round::Via([0.0, 10.0, 10.0]), false, false, false),   Some(10.0 * PI)),
            ("the shorter way in space",         sweep([0.0, 10.0, 10.0], Round::Center([0.0, 10.0, 0.0]), false, false, false), Some(5.0 * PI)),
            ("the longer way in space",          sweep([0.0, 10.0, 10.0], Round::Center([0.0, 10.0, 0.0]), true, false, false), Some(15.0 * PI)),
            ("points on a line",                 sweep([20.0, 0.0, 0.0], Round::Via([10.0, 0.0, 0.0]), false, false, true),     None),
        ];
        for (why, sweep, expected) in cases {
            let length = sweep.length();
            let close = match (length, expected) {
                (Some(length), Some(expected)) => (length - expected).abs() < 1e-9,
                (length, expected) => length == expected,
            };
            assert!(close, "{why}: {length:?}, expected {expected:?}");
        }
    }
}
