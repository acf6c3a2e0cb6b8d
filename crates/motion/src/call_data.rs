//! The data of a call that stand in tags; the tag memory copies them beside the tick when the call is made.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use arcline_cam::Profile;
use arcline_instruction_set::MotionError;

use crate::output::OutputCam;
use crate::path_data::PathMove;

/// The data that enter the tick with a call.
///
/// The tick only reads their memory. The sender keeps its own [`Arc`] until no other one is left, so the tick never frees memory.
#[derive(Clone, Debug)]
pub enum CallData {
    /// The instruction was calculated beside the tick; it is done once its operands are verified.
    Done,
    /// The instruction fails with an error once its operands are verified.
    Refused {
        /// The error.
        error: MotionError,
        /// The element of a cam at fault: SEGMENT.
        element: u32,
    },
    /// A calculated cam profile.
    Cam(Arc<Profile>),
    /// The values of a path move's tags at the call.
    Path(PathMove),
    /// An output cam, and the values of the tags of its output and its input.
    OutputCam(Arc<OutputCam>, [u32; 2]),
    /// The memory for the numbers that the instruction calculates in the tick.
    Results(Arc<Results>),
    /// Frames of MCTO.
    Frames(Frames),
    /// The tags that MCTPO reads, and its results.
    Calculation(Calculation),
}

/// The tags of MCTPO.
#[derive(Clone, Debug)]
pub struct Calculation {
    /// The frames of the work and the tool.
    pub frames: Frames,
    /// Robot Configuration, for Inverse.
    pub configuration: i32,
    /// Turns Counter, for Inverse.
    pub turns: [i16; 4],
    /// The memory for the calculated position; Forward adds Robot Configuration and Turns Counter behind it.
    pub results: Arc<Results>,
}

/// The frames of a work piece and a tool, for MCTO and MCTPO.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frames {
    /// The work piece, in the frame of the robot's base.
    pub work: Frame,
    /// The tool centre, in the frame of the end of the arm.
    pub tool: Frame,
}

/// A POSITION_DATA (spec/coordinated-instructions.md §22.8).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// The number that ActiveWorkFrameID or ActiveToolFrameID shows; it has no effect on motion.
    pub id: i32,
    /// X, Y, Z in position units, Rx, Ry, Rz in degrees, as in the tag.
    pub coordinates: [f64; 6],
}

/// The results of an instruction that calculates in the tick: the tick writes them once, and readers take them when the instruction is
/// done.
#[derive(Debug, Default)]
pub struct Results {
    elements: usize,
    count: AtomicUsize,
    numbers: [AtomicU64; MOST_NUMBERS],
}

/// Six coordinates, a configuration and four counters.
const MOST_NUMBERS: usize = 11;

impl Results {
    /// Memory for an array with this number of elements.
    pub fn new(elements: usize) -> Self {
        Results {
            elements,
            ..Results::default()
        }
    }

    /// The numbers; none before the instruction is done.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let count = self.count.load(Ordering::Acquire);
        let bits = self.numbers.iter().take(count);
        bits.map(|bits| f64::from_bits(bits.load(Ordering::Relaxed)))
    }

    /// Elements of the array that receives them.
    pub(crate) fn elements(&self) -> usize {
        self.elements
    }

    /// Sets them. Real-time.
    pub(crate) fn set(&self, numbers: &[f64]) {
        for (index, number) in self.numbers.iter().zip(numbers) {
            index.store(number.to_bits(), Ordering::Relaxed);
        }
        self.count.store(numbers.len().min(MOST_NUMBERS), Ordering::Release);
    }
}

/// The data that came with a call, of an instruction that works on tags.
pub(crate) struct ReceivedData(pub(crate) Option<CallData>);

impl ReceivedData {
    /// The element of a cam at fault: SEGMENT.
    pub(crate) fn element(&self) -> u32 {
        match self.0 {
            Some(CallData::Refused { element, .. }) => element,
            _ => 0,
        }
    }

    /// The memory for the results, if an operand names an array for them.
    pub(crate) fn results(&self) -> Option<&Results> {
        match &self.0 {
            Some(CallData::Results(results)) => Some(results),
            _ => None,
        }
    }

    /// Frames of a work and a tool.
    ///
    /// # Errors
    /// The reason why the data do not exist.
    pub(crate) fn frames(&self) -> Result<&Frames, MotionError> {
        match &self.0 {
            Some(CallData::Frames(frames)) => Ok(frames),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// The tags of MCTPO.
    ///
    /// # Errors
    /// The reason why the data do not exist.
    pub(crate) fn calculation(&self) -> Result<&Calculation, MotionError> {
        match &self.0 {
            Some(CallData::Calculation(calculation)) => Ok(calculation),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// The outcome of an instruction that was calculated beside the tick.
    ///
    /// # Errors
    /// The error of that calculation; `FeatureNotSupported` if no result has come.
    pub(crate) fn verdict(&self) -> Result<(), MotionError> {
        match &self.0 {
            Some(CallData::Done) => Ok(()),
            Some(CallData::Refused { error, .. }) => Err(*error),
            _ => Err(MotionError::FeatureNotSupported),
        }
    }

    /// The tags of a path move.
    ///
    /// # Errors
    /// The reason why the data do not exist.
    pub(crate) fn path(&self) -> Result<PathMove, MotionError> {
        match &self.0 {
            Some(CallData::Path(path)) => Ok(*path),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// An output cam, and the values of the tags of its output and its input.
    ///
    /// # Errors
    /// The reason why the data do not exist.
    pub(crate) fn output_cam(&self) -> Result<(Arc<OutputCam>, [u32; 2]), MotionError> {
        match &self.0 {
            Some(CallData::OutputCam(cam, words)) => Ok((cam.clone(), *words)),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// The profile of a cam.
    ///
    /// # Errors
    /// The reason why the data do not exist.
    pub(crate) fn cam(&self) -> Result<Arc<Profile>, MotionError> {
        match &self.0 {
            Some(CallData::Cam(profile)) => Ok(profile.clone()),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }
}
