//! Data of a call that stand in tags: the image of the tags reads them beside the tick, when the call is made.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use arcline_cam::Profile;
use arcline_instruction_set::MotionError;

use crate::output::OutputCam;
use crate::path_data::PathMove;

/// The data that go into the tick with a call.
///
/// The tick only reads the memory behind them. The sender keeps an [`Arc`] of its own until that is the last one, so that the
/// tick never frees anything.
#[derive(Clone, Debug)]
pub enum CallData {
    /// The instruction was calculated beside the tick: it is done once its operands are verified.
    Done,
    /// It errs, once its operands are verified.
    Refused {
        /// Why.
        error: MotionError,
        /// The element of a cam that is to blame: SEGMENT.
        element: u32,
    },
    /// A calculated cam profile.
    Cam(Arc<Profile>),
    /// The tags of a path move, as they were.
    Path(PathMove),
    /// An output cam, and the values of the tags of its output and its input.
    OutputCam(Arc<OutputCam>, [u32; 2]),
    /// For the numbers that the instruction calculates in the tick.
    Results(Arc<Results>),
    /// Frames of MCTO.
    Frames(Frames),
    /// The tags that MCTPO reads, and its results.
    Calculation(Calculation),
}

/// The tags of MCTPO.
#[derive(Clone, Debug)]
pub struct Calculation {
    /// Of the work and the tool.
    pub frames: Frames,
    /// Robot Configuration, for Inverse.
    pub configuration: i32,
    /// Turns Counter, for Inverse.
    pub turns: [i16; 4],
    /// For the position; Forward gives Robot Configuration and Turns Counter behind it.
    pub results: Arc<Results>,
}

/// Where a work and a tool are, for MCTO and MCTPO.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frames {
    /// The work, in the frame of the robot's base.
    pub work: Frame,
    /// The tool centre, in the frame of the end of the arm.
    pub tool: Frame,
}

/// A POSITION_DATA (spec/coordinated-instructions.md §22.8).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// What ActiveWorkFrameID or ActiveToolFrameID shows; without effect on motion.
    pub id: i32,
    /// X, Y, Z in position units, Rx, Ry, Rz in degrees, as the tag has them.
    pub coordinates: [f64; 6],
}

/// The results of an instruction that calculates in the tick: written once there, read when the instruction is done.
#[derive(Debug, Default)]
pub struct Results {
    elements: usize,
    count: AtomicUsize,
    numbers: [AtomicU64; MOST_NUMBERS],
}

/// Six coordinates, a configuration and four counters.
const MOST_NUMBERS: usize = 11;

impl Results {
    /// For an array of so many elements.
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
    /// The element of a cam that is to blame for an error: SEGMENT.
    pub(crate) fn element(&self) -> u32 {
        match self.0 {
            Some(CallData::Refused { element, .. }) => element,
            _ => 0,
        }
    }

    /// For the results, where an operand names an array for them.
    pub(crate) fn results(&self) -> Option<&Results> {
        match &self.0 {
            Some(CallData::Results(results)) => Some(results),
            _ => None,
        }
    }

    /// Frames of a work and a tool.
    ///
    /// # Errors
    /// Why there are none.
    pub(crate) fn frames(&self) -> Result<&Frames, MotionError> {
        match &self.0 {
            Some(CallData::Frames(frames)) => Ok(frames),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// What MCTPO calculates with.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn calculation(&self) -> Result<&Calculation, MotionError> {
        match &self.0 {
            Some(CallData::Calculation(calculation)) => Ok(calculation),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// Of an instruction that was worked out beside the tick.
    ///
    /// # Errors
    /// What it errs with; `FeatureNotSupported` where no result has come.
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
    /// Why there are none.
    pub(crate) fn path(&self) -> Result<PathMove, MotionError> {
        match &self.0 {
            Some(CallData::Path(path)) => Ok(*path),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// An output cam, and what is in the tags of its output and its input.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn output_cam(&self) -> Result<(Arc<OutputCam>, [u32; 2]), MotionError> {
        match &self.0 {
            Some(CallData::OutputCam(cam, words)) => Ok((cam.clone(), *words)),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }

    /// The profile of a cam.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn cam(&self) -> Result<Arc<Profile>, MotionError> {
        match &self.0 {
            Some(CallData::Cam(profile)) => Ok(profile.clone()),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }
}
