//! A program as Structured Text: one statement a line, all moves under one motion control tag.

use crate::{Corner, Motion, Program, Speed, Step};

/// Structured Text and where its lines come from.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct StructuredText {
    /// The program.
    pub text: String,
    /// For each of its lines the line of G-code, from 1.
    pub lines: Vec<usize>,
}

impl Program {
    /// Moves of the coordinate system `system` under the motion control tag `control`: rapids at 100 % of its maximum
    /// speed, feeds as programmed, all with its maximum rates and an S-curve.
    ///
    /// | path control | termination type |
    /// |---|---|
    /// | G61 | Follow Contour Velocity Constrained (4) |
    /// | G61.1, and where no move follows at once | No Settle (1) |
    /// | G64 | Command Tolerance (2) |
    /// | G64 P | Command Tolerance Programmed (6) with P |
    pub fn structured_text(&self, system: &str, control: &str) -> StructuredText {
        let mut text = String::new();
        let mut lines = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            text.push_str(&step.structured_text(self.axes, system, control));
            text.push('\n');
            lines.push(step.line);
        }
        StructuredText { text, lines }
    }
}

impl Step {
    /// The step as one line of Structured Text; see [`Program::structured_text`].
    pub fn structured_text(&self, axes: usize, system: &str, control: &str) -> String {
        match self.motion {
            Motion::Line { end, speed, corner } => format!(
                "MCLM({system}, {control}, Absolute, {}, {});",
                point(end, axes),
                dynamics(speed, corner)
            ),
            Motion::Arc {
                via,
                end,
                speed,
                corner,
            } => format!(
                "MCCM({system}, {control}, Absolute, {}, Via, {}, 0, {});",
                point(end, axes),
                point(via, axes),
                dynamics(speed, corner)
            ),
            Motion::Dwell { seconds } => format!("WAIT(NOT {control}.IP); DELAY({seconds});"),
        }
    }
}

fn point(point: [f64; 3], axes: usize) -> String {
    let numbers = point.iter().take(axes).map(|number| format!("{}", number + 0.0));
    format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
}

/// The operands from Speed to Command Tolerance.
fn dynamics(speed: Speed, corner: Corner) -> String {
    let speed = match speed {
        Speed::Rapid => "100, %ofMaximum".to_owned(),
        Speed::Feed(feed) => format!("{feed}, Unitspersec"),
    };
    let corner = match corner {
        Corner::Exact => "FollowContourVelocityConstrained".to_owned(),
        Corner::Stop => "NoSettle".to_owned(),
        Corner::Rounded => "CommandTolerance".to_owned(),
        Corner::Within(tolerance) => {
            format!("CommandToleranceProgrammed, Disabled, Programmed, {tolerance}")
        }
    };
    format!("{speed}, 100, %ofMaximum, 100, %ofMaximum, S-curve, 100, 100, %ofTime, {corner}")
}
