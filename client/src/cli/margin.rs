//! `margin`: the distance of a master beyond the sum of Calculated Data. Without a server.

use serde_json::json;

use arcline_instruction_set::BlendedSequence;

use super::Output;
use super::args::Margin;

/// Prints the safety margin of a sequence.
pub(crate) fn print(margin: &Margin, output: &Output) {
    // Without the digits that the rounding of the sum made.
    let margin = (BlendedSequence::from(margin).safety_margin() * 1e12).round() / 1e12;
    output.result(format!("{margin} master units"), || json!({"safety_margin": margin}));
}
