//! One diagram: a rectangle of the page, the ranges that it shows, and its curves.

use std::fmt::Write;

use crate::scale::Range;

/// Least distance of two distinct points of a curve, pixels.
const FINE: f64 = 0.5;
pub(crate) const INK: &str = "#333333";
const GRID: &str = "#dddddd";
const FRAME: &str = "#999999";

/// A rectangle in pixels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Box2 {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// A diagram and the SVG of it so far.
#[derive(Debug)]
pub(crate) struct Panel {
    pub(crate) place: Box2,
    pub(crate) x: Range,
    pub(crate) y: Range,
    pub(crate) svg: String,
}

impl Panel {
    pub(crate) fn new(place: Box2, x: Range, y: Range) -> Self {
        Self {
            place,
            x,
            y,
            svg: String::new(),
        }
    }

    /// Pixels of a point.
    pub(crate) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let Box2 {
            left,
            top,
            width,
            height,
        } = self.place;
        (
            left + (x - self.x.0) / self.x.span() * width,
            top + height - (y - self.y.0) / self.y.span() * height,
        )
    }

    /// Lines at round numbers, the numbers, a frame and the titles; no title below also leaves the numbers out there.
    pub(crate) fn grid(&mut self, below: Option<&str>, above: &str, counts: (usize, usize)) {
        let Box2 {
            left,
            top,
            width,
            height,
        } = self.place;
        let (x_range, y_range) = (self.x, self.y);
        for tick in x_range.ticks(counts.0) {
            let (x, _) = self.at(tick, 0.0);
            self.put(format_args!("<path d=\"M{x:.1} {top}v{height}\" stroke=\"{GRID}\"/>\n"));
            if below.is_some() {
                self.text((x, top + height + 15.0), &x_range.label(tick, counts.0), "middle", INK);
            }
        }
        for tick in y_range.ticks(counts.1) {
            let (_, y) = self.at(0.0, tick);
            self.put(format_args!("<path d=\"M{left} {y:.1}h{width}\" stroke=\"{GRID}\"/>\n"));
            self.text((left - 6.0, y + 4.0), &y_range.label(tick, counts.1), "end", INK);
        }
        self.put(format_args!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"{FRAME}\"/>\n"
        ));
        if let Some(title) = below {
            self.text((left + width / 2.0, top + height + 32.0), title, "middle", INK);
        }
        self.text((left, top - 7.0), above, "start", INK);
    }

    /// A text at pixels.
    pub(crate) fn text(&mut self, (x, y): (f64, f64), text: &str, anchor: &str, colour: &str) {
        let text = escaped(text);
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{text}</text>\n"
        ));
    }

    /// A curve over time, `x` ascending: in each column of half a pixel the first and the last point, and the extremes.
    pub(crate) fn curve(&mut self, xs: &[f64], ys: &[f64], colour: &str) {
        let mut points: Vec<(f64, f64)> = Vec::new();
        let mut column: Vec<(f64, f64)> = Vec::new();
        for (x, y) in xs.iter().zip(ys) {
            let here = self.at(*x, y.clamp(self.y.0, self.y.1));
            if column.first().is_some_and(|first| here.0 - first.0 >= FINE) {
                extremes(&mut column, &mut points);
            }
            column.push(here);
        }
        extremes(&mut column, &mut points);
        self.polyline(&points, colour, 1.6);
    }

    /// A line through pixels.
    pub(crate) fn polyline(&mut self, points: &[(f64, f64)], colour: &str, width: f64) {
        if points.is_empty() {
            return;
        }
        let mut list = String::new();
        for (x, y) in points {
            let _ = write!(list, "{}{x:.1},{y:.1}", if list.is_empty() { "" } else { " " });
        }
        self.put(format_args!(
            "<polyline points=\"{list}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"/>\n"
        ));
    }

    pub(crate) fn put(&mut self, what: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.svg.write_fmt(what);
    }
}

/// First, lowest, highest and last of a column, in the order in which they come, once each.
fn extremes(column: &mut Vec<(f64, f64)>, points: &mut Vec<(f64, f64)>) {
    let by_height = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
    let kept = [
        column.first(),
        column.iter().min_by(by_height),
        column.iter().max_by(by_height),
        column.last(),
    ];
    let mut kept: Vec<(f64, f64)> = kept.into_iter().flatten().copied().collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    kept.dedup();
    points.extend(kept);
    column.clear();
}

/// A text as it stands in XML.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            control if control.is_control() => out.push(' '),
            other => out.push(other),
        }
    }
    out
}
