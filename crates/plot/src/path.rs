//! The path: in the plane of two axes, or of three seen from above at a corner, coloured by speed.

use crate::panel::{Box2, INK, Panel};
use crate::scale::Range;
use crate::trace::{Axis, Trace};

/// Colours of the speed from none to the highest: dark to light, distinct for colour-blind readers too.
const SPEEDS: [[f64; 3]; 6] = [
    [68.0, 1.0, 84.0],
    [65.0, 68.0, 135.0],
    [42.0, 120.0, 142.0],
    [34.0, 168.0, 132.0],
    [122.0, 209.0, 81.0],
    [222.0, 196.0, 26.0],
];
/// Number of distinct shades.
const SHADES: usize = 32;
/// Pixels between two points of the path.
const FINE: f64 = 0.8;
/// cos 30° and sin 30°: an isometric view.
const COS: f64 = 0.866_025_403_784_438_6;
const SIN: f64 = 0.5;

/// A path on the page.
#[derive(Debug)]
pub(crate) struct Path {
    pub(crate) panel: Panel,
    points: Vec<(f64, f64)>,
}

impl Path {
    /// The path of two or three axes in a square of the page.
    pub(crate) fn draw(trace: &Trace, axes: &[&Axis], place: Box2) -> Self {
        let points: Vec<(f64, f64)> = (0..trace.time.len())
            .map(|row| flat(&axes.iter().map(|axis| axis.position[row]).collect::<Vec<_>>()))
            .collect();
        let speeds: Vec<f64> = (0..trace.time.len())
            .map(|row| axes.iter().map(|axis| axis.velocity[row].powi(2)).sum::<f64>().sqrt())
            .collect();
        let top = speeds.iter().copied().fold(0.0, f64::max);
        // In space the box around the path must fit too.
        let seen: Vec<(f64, f64)> = if axes.len() > 2 {
            points.iter().copied().chain(corners(&extents(axes))).collect()
        } else {
            points.clone()
        };
        let range = |of: fn(&(f64, f64)) -> f64| Range::of(seen.iter().map(of));
        let (x, y) = same_scale(range(|point| point.0), range(|point| point.1), place);
        let mut panel = Panel::new(place, x, y);
        match axes {
            [first, second] => {
                let above = format!("{}, coloured by speed", second.name);
                panel.grid(Some(&first.name), &above, (6, 6));
            }
            _ => frame_of_space(&mut panel, axes),
        }
        coloured(&mut panel, &points, &speeds, top);
        legend(&mut panel, top);
        Self { panel, points }
    }

    /// A dot on the path at a row.
    pub(crate) fn mark(&mut self, row: usize, colour: &str) {
        let Some((x, y)) = self.points.get(row).copied() else {
            return;
        };
        let (x, y) = self.panel.at(x, y);
        self.panel.put(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"1.5\"/>\n"
        ));
    }
}

/// Where a position is seen.
fn flat(position: &[f64]) -> (f64, f64) {
    match position {
        [x, y, z, ..] => ((x - y) * COS, z + (x + y) * SIN),
        [x, y] => (*x, *y),
        [x] => (*x, 0.0),
        [] => (0.0, 0.0),
    }
}

/// Both ranges, widened so that a unit is as long in both directions.
fn same_scale(x: Range, y: Range, place: Box2) -> (Range, Range) {
    let unit = (x.span() / place.width).max(y.span() / place.height);
    let around =
        |range: Range, size: f64| Range(range.middle() - 0.5 * size * unit, range.middle() + 0.5 * size * unit);
    (around(x, place.width), around(y, place.height))
}

/// From where to where each axis goes.
fn extents(axes: &[&Axis]) -> Vec<Range> {
    let extent = |axis: &&Axis| {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let positions = axis.position.iter();
        let (low, high) = positions.fold(start, |(low, high), at| (low.min(*at), high.max(*at)));
        Range(low, high)
    };
    axes.iter().map(extent).collect()
}

/// The corners of the box around a path on the page; bit k of the index is the high end of axis k.
fn corners(extents: &[Range]) -> Vec<(f64, f64)> {
    let at = |ends: usize| {
        let end = |(axis, range): (usize, &Range)| if ends & (1 << axis) != 0 { range.1 } else { range.0 };
        flat(&extents.iter().enumerate().map(end).collect::<Vec<_>>())
    };
    (0..8).map(at).collect()
}

/// The box around a path in space, with its axes named at their ends.
fn frame_of_space(panel: &mut Panel, axes: &[&Axis]) {
    let ranges = extents(axes);
    let seen = corners(&ranges);
    let corner = |ends: [bool; 3]| {
        let place = ends
            .iter()
            .enumerate()
            .map(|(axis, end)| usize::from(*end) << axis)
            .sum::<usize>();
        seen.get(place).copied().unwrap_or_default()
    };
    for axis in 0..3 {
        for other in 0..4 {
            let mut from = [false; 3];
            from[(axis + 1) % 3] = other & 1 != 0;
            from[(axis + 2) % 3] = other & 2 != 0;
            let mut to = from;
            to[axis] = true;
            let ends = [corner(from), corner(to)].map(|(x, y)| panel.at(x, y));
            panel.polyline(&ends, "#cccccc", 1.0);
        }
        let mut end = [false; 3];
        end[axis] = true;
        let (px, py) = corner(end);
        let (px, py) = panel.at(px, py);
        let range = ranges[axis];
        let text = format!(
            "{} {} to {}",
            axes[axis].name,
            range.label(range.0, 6),
            range.label(range.1, 6)
        );
        // X goes to the right, Y to the left, Z up.
        let (dx, dy, anchor) = [(4.0, 14.0, "middle"), (-4.0, 14.0, "middle"), (6.0, -4.0, "start")][axis];
        panel.text((px + dx, py + dy), &text, anchor, INK);
    }
    let Box2 { left, top, .. } = panel.place;
    panel.text((left, top - 7.0), "the path, coloured by speed", "start", INK);
}

/// The curve in pieces of one shade each; each begins where the last one ended.
fn coloured(panel: &mut Panel, points: &[(f64, f64)], speeds: &[f64], top: f64) {
    let shade = |speed: f64| {
        if top > 0.0 {
            ((speed / top) * (SHADES - 1) as f64).round() as usize
        } else {
            0
        }
    };
    let mut piece: Vec<(f64, f64)> = Vec::new();
    let mut colour = 0;
    for (place, (point, speed)) in points.iter().zip(speeds).enumerate() {
        let here = panel.at(point.0, point.1);
        let is_apart = |last: &(f64, f64)| (here.0 - last.0).hypot(here.1 - last.1) >= FINE;
        if !piece.last().is_none_or(is_apart) && place + 1 < points.len() {
            continue;
        }
        let new = shade(*speed);
        if new != colour && piece.len() > 1 {
            panel.polyline(&piece, &hex(colour), 2.2);
            piece = piece.last().copied().into_iter().collect();
        }
        colour = new;
        piece.push(here);
    }
    panel.polyline(&piece, &hex(colour), 2.2);
}

/// The scale of the speed, in the upper right corner.
fn legend(panel: &mut Panel, top: f64) {
    let Box2 {
        left, top: y, width, ..
    } = panel.place;
    let (wide, x) = (96.0, left + width - 96.0);
    for shade in 0..SHADES {
        let at = x + wide * shade as f64 / SHADES as f64;
        let colour = hex(shade);
        panel.put(format_args!(
            "<rect x=\"{at:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"7\" fill=\"{colour}\"/>\n",
            y - 14.0,
            wide / SHADES as f64 + 0.2
        ));
    }
    panel.text((x - 5.0, y - 7.0), "0", "end", INK);
    let range = Range(0.0, top.max(1e-9));
    let text = format!("{} /s", range.label(top, 20));
    panel.text((x + wide, y - 18.0), &text, "end", INK);
}

/// The colour of a shade.
fn hex(shade: usize) -> String {
    let place = shade as f64 / (SHADES - 1) as f64 * (SPEEDS.len() - 1) as f64;
    let from = (place.floor() as usize).min(SPEEDS.len() - 2);
    let share = place - from as f64;
    let mut text = String::from("#");
    for (a, b) in SPEEDS[from].iter().zip(SPEEDS[from + 1]) {
        text.push_str(&format!("{:02x}", (a + share * (b - a)).round() as u8));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_go_from_dark_to_light() {
        assert_eq!((hex(0).as_str(), hex(SHADES - 1).as_str()), ("#440154", "#dec41a"));
    }

    #[test]
    fn space_is_seen_from_a_corner() {
        let seen = |position: [f64; 3]| flat(&position);
        assert!(seen([1.0, 0.0, 0.0]).0 > 0.0 && seen([0.0, 1.0, 0.0]).0 < 0.0);
        assert_eq!(seen([0.0, 0.0, 1.0]), (0.0, 1.0));
    }
}
