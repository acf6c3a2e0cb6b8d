//! `margin`: what a master must go further than Calculated Data say. No server is asked.

use serde_json::json;

use arcline_instruction_set::BlendedSequence;

use super::Output;
use super::args::Margin;

/// Prints the safety margin of a sequence.
pub(crate) fn print(margin: &Margin, output: &Output) {
    // Rounded to what the last digits of a sum leave.
    let margin = (BlendedSequence::from(margin).safety_margin() * 1e12).round() / 1e12;
    output.result(format!("{margin} master units"), || json!({"safety_margin": margin}));
}
