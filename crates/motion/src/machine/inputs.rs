//! The inputs of an axis from tags that clients write.

/// Tags that an axis reads, by their paths.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Inputs {
    /// Where its position comes from: of an axis of kind [`Feedback`](super::AxisKind::Feedback).
    pub feed: Option<Feed>,
    /// Its registration inputs: BOOLs, or bits of integers.
    pub registration: [Option<String>; 2],
}

/// Where the position of an axis comes from.
#[derive(Clone, PartialEq, Debug)]
pub struct Feed {
    /// Path of a number, position units; of a rotary axis any turn will do.
    pub tag: String,
    /// Time over which the axis goes from one written position to the next, s, 0 or more.
    pub interval: f64,
    /// How old a position may become before the axis faults, s, above 0.
    pub timeout: f64,
}
