//! A cam of an execution target with the states of its elements.
//!
//! Not here: the events of the elements ([`super::events`]). Nothing allocates after [`CamState::new`].

use std::sync::Arc;

use super::super::element::ElementState;
use super::super::program::{Compensation, Element, MAX_OUTPUT_ELEMENTS, OutputCam};
use crate::execution::Execution;
use crate::masters::displacement::Crossing;
use arcline_instruction_set::enumerations::ExecutionMode;

/// Index of the active cam.
pub(super) const ACTIVE: usize = 0;
/// Index of the pending cam.
pub(super) const PENDING: usize = 1;
/// Index of the previous cam, some elements of which continue.
pub(super) const TAIL: usize = 2;

/// An output cam that an instruction arms.
#[derive(Clone, Debug)]
pub(crate) struct ArmedCam {
    pub(crate) cam: Arc<OutputCam>,
    pub(crate) mode: ExecutionMode,
    pub(crate) execution: Execution,
}

/// The phase of the cam of an execution target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    Free,
    /// The cam waits until the axis crosses the arm position.
    Waiting(Crossing),
    Armed,
    /// The cam has ended, but some of its elements continue.
    Ending,
}

#[derive(Clone, Debug)]
pub(super) struct CamState {
    pub(super) program: Option<ArmedCam>,
    pub(super) states: Vec<ElementState>,
}

impl CamState {
    pub(super) fn new() -> Self {
        CamState {
            program: None,
            states: Vec::with_capacity(MAX_OUTPUT_ELEMENTS),
        }
    }

    pub(super) fn load(&mut self, program: ArmedCam) {
        self.states.clear();
        self.states.resize(program.cam.elements.len(), ElementState::default());
        self.program = Some(program);
    }

    pub(super) fn take(&mut self) -> Option<Execution> {
        self.states.clear();
        self.program.take().map(|program| program.execution)
    }

    pub(super) fn cam(&self) -> Option<&Arc<OutputCam>> {
        self.program.as_ref().map(|program| &program.cam)
    }

    /// An element and the compensation of its bit.
    pub(super) fn element(&self, element_index: usize) -> Option<(&Element, &Compensation)> {
        let cam = self.cam()?;
        let element = cam.elements.get(element_index)?;
        Some((element, &cam.compensation[usize::from(element.bit)]))
    }
}

impl Compensation {
    pub(super) fn delay(&self, latch: bool) -> f64 {
        if latch { self.latch_delay } else { self.unlatch_delay }
    }
}
