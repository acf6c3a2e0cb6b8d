//! The page: the path on the left, the diagrams over time on the right.

use std::fmt::Write;

use crate::panel::{Box2, Panel};
use crate::path::Path;
use crate::scale::Range;
use crate::trace::{Axis, Trace};
use crate::{Mark, PlotError};

/// The options of a picture.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Options {
    /// The axes, the first three of them with their path; empty: those that move, with the path of a robot's tool where the trace
    /// has it.
    pub axes: Vec<String>,
    /// The marks.
    pub marks: Vec<Mark>,
    /// Above the picture; empty: nothing.
    pub title: String,
}

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 596.0;
const TOP: f64 = 58.0;
/// Highest number of axes with distinct colours.
const COLOURS: [&str; 8] = [
    "#1f5fa8", "#c2541b", "#2a8a4a", "#8a3fa0", "#b08900", "#00838f", "#a83250", "#5a5a5a",
];
const MARKED: &str = "#777777";
const ERRED: &str = "#c62828";
/// Most marks with a text; more would cover each other.
const TEXTS: usize = 40;

/// Draws a trace as SVG.
///
/// # Errors
/// [`PlotError::UnknownAxis`].
pub fn svg(trace: &Trace, options: &Options) -> Result<String, PlotError> {
    let axes = chosen(trace, &options.axes)?;
    let tool = if options.axes.is_empty() { trace.tool() } else { None };
    let drawn = tool.filter(|tool| tool.len() > 1).unwrap_or_else(|| axes.clone());
    let mut parts = String::new();
    let mut left = 70.0;
    let mut path = None;
    if drawn.len() > 1 {
        let place = Box2 {
            left: 56.0,
            top: TOP + 14.0,
            width: 390.0,
            height: 390.0,
        };
        path = Some(Path::draw(trace, drawn.get(..3).unwrap_or(&drawn), place));
        left = 520.0;
    }
    for mark in &options.marks {
        let row = trace.time.partition_point(|time| *time < mark.time);
        if let Some(path) = &mut path {
            path.mark(row, if mark.erred { ERRED } else { MARKED });
        }
    }
    if let Some(path) = path {
        parts.push_str(&path.panel.svg);
    }
    parts.push_str(&over_time(trace, &axes, &options.marks, left));
    let title = if options.title.is_empty() {
        String::new()
    } else {
        let title = crate::panel::escaped(&options.title);
        format!("<text x=\"56\" y=\"22\" font-size=\"15\" fill=\"#333333\">{title}</text>\n")
    };
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"DejaVu Sans, sans-serif\" font-size=\"12\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n{title}{parts}</svg>\n"
    ))
}

/// The axes of these names, or those that move.
fn chosen<'t>(trace: &'t Trace, names: &[String]) -> Result<Vec<&'t Axis>, PlotError> {
    if names.is_empty() {
        return Ok(trace.moving());
    }
    let find = |name: &String| {
        let axis = trace.axes.iter().find(|axis| axis.name.eq_ignore_ascii_case(name));
        axis.ok_or_else(|| {
            let known: Vec<&str> = trace.axes.iter().map(|axis| axis.name.as_str()).collect();
            PlotError::UnknownAxis {
                name: name.clone(),
                known: known.join(", "),
            }
        })
    };
    names.iter().map(find).collect()
}

/// Position, velocity, acceleration and jerk, one below the other, and the marks through all of them.
fn over_time(trace: &Trace, axes: &[&Axis], marks: &[Mark], left: f64) -> String {
    let jerks: Vec<Vec<f64>> = axes.iter().map(|axis| axis.jerk(&trace.time)).collect();
    let rows: [(&str, Vec<&[f64]>); 4] = [
        ("position", axes.iter().map(|axis| axis.position.as_slice()).collect()),
        (
            "velocity /s",
            axes.iter().map(|axis| axis.velocity.as_slice()).collect(),
        ),
        (
            "acceleration /s²",
            axes.iter().map(|axis| axis.acceleration.as_slice()).collect(),
        ),
        ("jerk /s³", jerks.iter().map(Vec::as_slice).collect()),
    ];
    let time = Range(trace.time[0], trace.time[trace.time.len() - 1]);
    let (step, height) = (126.0, 98.0);
    let mut svg = String::new();
    for (place, (title, curves)) in rows.iter().enumerate() {
        let is_last = place + 1 == rows.len();
        let (range, note) = range(curves, is_last);
        let area = Box2 {
            left,
            top: TOP + 14.0 + place as f64 * step,
            width: WIDTH - left - 26.0,
            height,
        };
        let mut panel = Panel::new(area, time, range);
        panel.grid(is_last.then_some("time / s"), &format!("{title}{note}"), (6, 3));
        for mark in marks {
            let (x, _) = panel.at(mark.time.clamp(time.0, time.1), 0.0);
            let colour = if mark.erred { ERRED } else { MARKED };
            panel.put(format_args!(
                "<path d=\"M{x:.1} {:.1}v{height}\" stroke=\"{colour}\" stroke-dasharray=\"3 3\"/>\n",
                area.top
            ));
        }
        for (number, curve) in curves.iter().enumerate() {
            panel.curve(&trace.time, curve, COLOURS[number % COLOURS.len()]);
        }
        if place == 0 {
            names(&mut panel, axes);
            texts(&mut panel, marks, time);
        }
        let _ = write!(svg, "{}", panel.svg);
    }
    svg
}

/// The range of some curves. A step of the acceleration, which a trapezoid has, would leave nothing else to see of the
/// jerk: it is cut then, and said so.
fn range(curves: &[&[f64]], is_jerk: bool) -> (Range, &'static str) {
    let all = || curves.iter().flat_map(|curve| curve.iter().copied());
    if !is_jerk {
        return (Range::of(all()), "");
    }
    let mut sizes: Vec<f64> = all().map(f64::abs).filter(|size| *size > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() * 98 / 100).copied().unwrap_or_default();
    let highest = sizes.last().copied().unwrap_or_default();
    if highest > 4.0 * usual && usual > 0.0 {
        (Range(-1.3 * usual, 1.3 * usual), ", steps cut off")
    } else {
        (Range::of(all()), "")
    }
}

/// The axes' names in their colours, at the right above the diagram.
fn names(panel: &mut Panel, axes: &[&Axis]) {
    let Box2 { left, top, width, .. } = panel.place;
    let mut x = left + width;
    for (number, axis) in axes.iter().enumerate().rev() {
        panel.text((x, top - 7.0), &axis.name, "end", COLOURS[number % COLOURS.len()]);
        x -= 14.0 + 7.5 * axis.name.chars().count() as f64;
    }
}

/// The marks, slanted above the diagrams.
fn texts(panel: &mut Panel, marks: &[Mark], time: Range) {
    let top = panel.place.top;
    if marks.len() > TEXTS {
        return;
    }
    let mut last = f64::NEG_INFINITY;
    for mark in marks {
        let (x, _) = panel.at(mark.time.clamp(time.0, time.1), 0.0);
        // One on the other could not be read: they are slanted by 35° and 9 pixels high.
        if x - last < 17.0 {
            continue;
        }
        last = x;
        let colour = if mark.erred { ERRED } else { MARKED };
        let text = crate::panel::escaped(&mark.text);
        panel.put(format_args!(
            "<text transform=\"translate({:.1} {:.1}) rotate(-35)\" font-size=\"9\" fill=\"{colour}\">{text}</text>\n",
            x,
            top - 20.0
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line along some axes at a trapezoid's speed.
    fn trace(axes: &[&str]) -> Trace {
        let rows = 200;
        let mut text = String::from("tick,time_s");
        for axis in axes {
            let _ = write!(
                text,
                ",{axis}.CommandPosition,{axis}.CommandVelocity,{axis}.CommandAcceleration"
            );
        }
        for row in 0..rows {
            let time = f64::from(row) * 0.01;
            let _ = write!(text, "\n{row},{time}");
            for place in 1..=axes.len() {
                let speed = f64::from(row.min(rows - row)) * place as f64;
                let _ = write!(
                    text,
                    ",{},{speed},{}",
                    time * speed,
                    if row < rows / 2 { 100 } else { -100 }
                );
            }
        }
        Trace::parse(&text).expect("a trace")
    }

    fn count(svg: &str, what: &str) -> usize {
        svg.matches(what).count()
    }

    #[test]
    fn the_page_shows_the_signals_of_the_trace() {
        let marks = Mark::parse(
            r#"{"time_s":0.5,"tag":"M<1>","instruction":"MCLM","set":["AC"]}
{"time_s":1.5,"tag":"M2","instruction":"MCLM","set":["ER"],"ERR":13}"#,
        );
        let options = Options {
            marks: marks.expect("events"),
            title: "A & B".to_owned(),
            ..Options::default()
        };
        for (axes, circles) in [(&["X"][..], 0), (&["X", "Y"], 2), (&["X", "Y", "Z"], 2)] {
            let picture = svg(&trace(axes), &options).expect("a picture");
            assert_eq!(count(&picture, "<circle"), circles, "{axes:?}: dots on the path");
            assert_eq!(
                count(&picture, "stroke-dasharray"),
                8,
                "{axes:?}: a line for each mark in each diagram"
            );
            for expected in [
                "A &amp; B",
                "MCLM M&lt;1&gt;",
                "MCLM M2: ERR 13",
                "jerk /s³",
                "time / s",
            ] {
                assert!(picture.contains(expected), "{axes:?}: {expected}");
            }
            assert!(!picture.contains("NaN") && !picture.contains("inf"), "{axes:?}");
        }
    }

    #[test]
    fn single_steps_of_the_acceleration_do_not_hide_the_jerk() {
        let mut jerk = vec![100.0; 500];
        jerk[250] = 1e6;
        let (range, note) = range(&[&jerk], true);
        assert!(range.1 < 200.0 && note.contains("cut off"), "{range:?} {note}");
        let (range, note) = super::range(&[&jerk[..200]], true);
        assert!(range.1 > 100.0 && note.is_empty(), "{range:?} {note}");
    }

    #[test]
    fn the_same_trace_gives_the_same_picture_and_axes_can_be_chosen() {
        let trace = trace(&["X", "Y", "Z"]);
        let all = svg(&trace, &Options::default()).expect("a picture");
        assert_eq!(all, svg(&trace, &Options::default()).expect("the same"));
        let some = |names: &[&str]| {
            let axes = names.iter().map(|name| (*name).to_owned()).collect();
            svg(
                &trace,
                &Options {
                    axes,
                    ..Options::default()
                },
            )
        };
        assert!(some(&["z", "X"]).is_ok_and(|picture| picture != all));
        let error = some(&["W"]).expect_err("no such axis").to_string();
        assert_eq!(error, "the trace has no axis \"W\", only X, Y, Z");
    }

    #[test]
    fn pixels_come_out_as_png() {
        let picture = svg(&trace(&["X", "Y"]), &Options::default()).expect("a picture");
        let small = crate::png(&picture, 0.25).expect("pixels");
        assert_eq!(small.get(..8), Some(&b"\x89PNG\r\n\x1a\n"[..]));
        // Width and height stand in the header, big-endian.
        assert_eq!(small.get(16..24), Some(&[0, 0, 0, 240, 0, 0, 0, 149][..]));
        let blank = svg(&trace(&["X"]), &Options::default())
            .map(|_| "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"240\" height=\"140\"/>");
        let blank = crate::png(blank.expect("a picture"), 1.0).expect("pixels");
        assert!(
            small.len() > 4 * blank.len(),
            "{} and {} bytes: there is something on it",
            small.len(),
            blank.len()
        );
        assert!(crate::png("no picture", 1.0).is_err());
        assert!(crate::png(&picture, 0.0).is_err() && crate::png(&picture, 1e6).is_err());
    }

    #[test]
    fn a_long_trace_stays_small() {
        let rows: String = (0..200_000).map(|row| format!("\n{row},{},{}", row, row % 7)).collect();
        let trace = Trace::parse(&format!("tick,time_s,X.CommandPosition{rows}")).expect("a trace");
        let picture = svg(&trace, &Options::default()).expect("a picture");
        assert!(picture.len() < 1 << 19, "{} bytes", picture.len());
    }
}
