//! `margin`: a sequence of blended master driven moves.

use clap::Args;

use arcline_instruction_set::BlendedSequence;

use super::values::{milliseconds, speed};

#[derive(Args, Debug)]
pub(crate) struct Margin {
    /// Moves of the sequence, the first and the last included
    #[arg(value_name = "MOVES", value_parser = clap::value_parser!(u32).range(1..))]
    moves: u32,
    /// Speed of the master axis, master units/s
    #[arg(long, value_name = "V", allow_hyphen_values = true, value_parser = speed)]
    master_speed: f64,
    /// The coarse update period, ms
    #[arg(long, value_name = "MS", default_value = "1", value_parser = milliseconds)]
    update_period: f64,
    /// The first move is blended over its full length (a Command Tolerance of 100 %)
    #[arg(long)]
    first_is_full: bool,
    /// The last move is blended over its full length
    #[arg(long)]
    last_is_full: bool,
}

impl From<&Margin> for BlendedSequence {
    fn from(margin: &Margin) -> Self {
        BlendedSequence {
            moves: margin.moves,
            update_period: margin.update_period / 1e3,
            master_speed: margin.master_speed,
            first_is_full: margin.first_is_full,
            last_is_full: margin.last_is_full,
        }
    }
}
