//! The further distance that a master must go beyond the Calculated Data (spec/coordinated-instructions.md §8.10, the reference page MCCM).
//!
//! For programs in which a master goes just as far as a sequence of blended, master driven moves needs: without the margin the last
//! move may not reach PC, because the master stops slightly early. Planning adds nothing of it. Master units, seconds.

/// A sequence of master driven moves that blend into each other (termination types 2, 3 and 6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendedSequence {
    /// Moves, the first and the last included.
    pub moves: u32,
    /// The coarse update period, s.
    pub update_period: f64,
    /// Speed of the master axis, master units/s.
    pub master_speed: f64,
    /// Whether the first move is blended over its full length (a Command Tolerance of 100 %).
    pub first_is_full: bool,
    /// Whether the last move is blended over its full length.
    pub last_is_full: bool,
}

impl BlendedSequence {
    /// The distance to add to the sum of the Calculated Data of the moves, master units.
    pub fn safety_margin(&self) -> f64 {
        let update = self.update_period * self.master_speed.abs();
        let end = |is_full: bool| if is_full { update } else { SHARE * update };
        match self.moves {
            0 => 0.0,
            1 => end(self.first_is_full || self.last_is_full),
            moves => end(self.first_is_full) + SHARE * update * f64::from(moves - 2) + end(self.last_is_full),
        }
    }
}

/// Share of an update that a move is allowed for.
const SHARE: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::BlendedSequence;

    #[test]
    fn the_margin_is_that_of_the_reference() {
        let plain = BlendedSequence {
            moves: 5,
            update_period: 0.002,
            master_speed: 500.0,
            first_is_full: false,
            last_is_full: false,
        };
        let full = |first_is_full, last_is_full| BlendedSequence {
            first_is_full,
            last_is_full,
            ..plain
        };
        #[rustfmt::skip]
        let cases = [
            // why,                        sequence,                                  margin (first row: spec/coordinated-instructions.md §27.8)
            ("five moves",                 plain,                                     0.10),
            ("the first over its length",  full(true, false),                         1.08),
            ("both ends",                  full(true, true),                          2.06),
            ("two moves",                  BlendedSequence { moves: 2, ..plain },     0.04),
            ("one move",                   BlendedSequence { moves: 1, ..plain },     0.02),
            ("none",                       BlendedSequence { moves: 0, ..plain },     0.0),
            ("a master that goes back",    BlendedSequence { master_speed: -500.0, ..plain }, 0.10),
        ];
        for (why, sequence, margin) in cases {
            let found = sequence.safety_margin();
            assert!((found - margin).abs() < 1e-15, "{why}: {found} is not {margin}");
        }
    }
}
