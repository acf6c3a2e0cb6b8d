//! A picture as pixels. Texts are drawn as outlines of DejaVu Sans, which is built in, so every machine draws the same.

use std::fmt::Write;

use resvg::{tiny_skia, usvg};
use ttf_parser::{Face, OutlineBuilder};

use crate::PlotError;

/// Draws an SVG of [`crate::svg`] as PNG, `scale` pixels for each of its own.
///
/// # Errors
/// [`PlotError::Pixels`] for a text that is no SVG, or a scale without a picture.
pub fn png(svg: &str, scale: f32) -> Result<Vec<u8>, PlotError> {
    let pixels = |error: &dyn std::fmt::Display| PlotError::Pixels(error.to_string());
    let face = Face::parse(dejavu::sans::regular(), 0).map_err(|error| pixels(&error))?;
    let outlined: String = svg.lines().map(|line| outlined(line, &face) + "\n").collect();
    let tree = usvg::Tree::from_str(&outlined, &usvg::Options::default()).map_err(|error| pixels(&error))?;
    let size = tree.size();
    let sides = [size.width(), size.height()].map(|side| (side * scale).round());
    if !sides.iter().all(|side| (1.0..=LARGEST).contains(side)) {
        return Err(PlotError::Pixels(format!("{} × {} pixels", sides[0], sides[1])));
    }
    // Both are whole and small enough.
    let mut pixmap = tiny_skia::Pixmap::new(sides[0] as u32, sides[1] as u32)
        .ok_or_else(|| PlotError::Pixels("no memory for it".to_owned()))?;
    resvg::render(
        &tree,
        tiny_skia::Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    pixmap.encode_png().map_err(|error| pixels(&error))
}

/// Longest side, pixels.
const LARGEST: f32 = 16_384.0;
/// Size of a text that does not say its own.
const FONT_SIZE: f64 = 12.0;

/// A line of our SVG with its text, one on a line, as a path; other lines as they are.
fn outlined(line: &str, face: &Face<'_>) -> String {
    let Some((head, rest)) = line.strip_prefix("<text ").and_then(|text| text.split_once('>')) else {
        return line.to_owned();
    };
    let text = rest.strip_suffix("</text>").unwrap_or(rest);
    let attribute = |name: &str| {
        let (_, from) = head.split_once(&format!("{name}=\""))?;
        from.split('"').next()
    };
    let number = |name: &str| attribute(name).and_then(|text| text.parse::<f64>().ok());
    let scale = number("font-size").unwrap_or(FONT_SIZE) / f64::from(face.units_per_em());
    let mut pen = Pen::default();
    for character in unescaped(text).chars() {
        let Some(glyph) = face.glyph_index(character) else {
            continue;
        };
        face.outline_glyph(glyph, &mut pen);
        pen.at += f32::from(face.glyph_hor_advance(glyph).unwrap_or_default());
    }
    let width = f64::from(pen.at) * scale;
    let shift = match attribute("text-anchor") {
        Some("middle") => -0.5 * width,
        Some("end") => -width,
        _ => 0.0,
    };
    let place = match attribute("transform") {
        Some(transform) => transform.to_owned(),
        None => format!(
            "translate({} {})",
            number("x").unwrap_or_default() + shift,
            number("y").unwrap_or_default()
        ),
    };
    let fill = attribute("fill").unwrap_or("#000000");
    format!(
        "<path transform=\"{place} scale({scale:.6} {:.6})\" fill=\"{fill}\" d=\"{}\"/>",
        -scale, pen.path
    )
}

/// Collects outlines, in units of the font, `at` being where the next glyph begins.
#[derive(Debug, Default)]
struct Pen {
    path: String,
    at: f32,
}

impl Pen {
    fn put(&mut self, command: char, points: &[(f32, f32)]) {
        self.path.push(command);
        for (x, y) in points {
            // Writing to a String cannot fail.
            let _ = write!(self.path, "{} {} ", x + self.at, y);
        }
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.put('M', &[(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.put('L', &[(x, y)]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.put('Q', &[(x1, y1), (x, y)]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.put('C', &[(x1, y1), (x2, y2), (x, y)]);
    }

    fn close(&mut self) {
        self.path.push('Z');
    }
}

fn unescaped(text: &str) -> String {
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
    text.replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_outlines_where_they_stood() {
        let face = Face::parse(dejavu::sans::regular(), 0).expect("the font that is built in");
        let begins = |line: &str| outlined(line, &face);
        let start = begins("<text x=\"10.0\" y=\"20.0\" text-anchor=\"start\" fill=\"#123456\">A</text>");
        assert!(
            start.starts_with("<path transform=\"translate(10 20) scale(0.005859 -0.005859)\" fill=\"#123456\" d=\"M"),
            "{start}"
        );
        // An A is 1401 units wide of 2048.
        let end = begins("<text x=\"10.0\" y=\"20.0\" text-anchor=\"end\" fill=\"#123456\">A</text>");
        assert!(end.contains("translate(1.79"), "{end}");
        let turned =
            begins("<text transform=\"translate(5 6) rotate(-35)\" font-size=\"9\" fill=\"#123456\">&lt;</text>");
        assert!(turned.contains("translate(5 6) rotate(-35) scale(0.004395"), "{turned}");
        assert_eq!(begins("<rect/>"), "<rect/>");
    }
}
