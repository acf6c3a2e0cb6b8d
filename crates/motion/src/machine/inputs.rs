//! The inputs of an axis from tags that clients write.

/// Tags that an axis reads, by their paths.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct AxisInputs {
    /// The source of its position: for an axis of kind [`Feedback`](super::AxisKind::Feedback).
    pub feed: Option<FeedTag>,
    /// Its registration inputs: BOOLs, or bits of integers.
    pub registration: [Option<String>; 2],
}

/// The tag that gives the position of an axis.
#[derive(Clone, PartialEq, Debug)]
pub struct FeedTag {
    /// Path of a tag with a number, position units; the position of a rotary axis may lie on any turn.
    pub tag: String,
    /// Time over which the axis goes from one written position to the next, s, 0 or more.
    pub interval: f64,
    /// The age at which a position is too old and faults the axis, s, above 0.
    pub timeout: f64,
}
