//! Instructions of the message class that are under way: DN at the next update, or when the drive has answered
//! (spec/axis-and-data-types.md §1.2, §12).
//!
//! Not here: the effect of the instruction on its axis. Real-time: nothing allocates; bounded by [`MESSAGES`].

use arcline_instruction_set::{AxisId, Detail, Flag, Mnemonic, MotionError};

use super::Motion;
use crate::axis::state::AxisState;
use crate::execution::Execution;

/// An instruction that completes one update later, or when the drive of its axis has answered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Message {
    execution: Execution,
    axis: AxisId,
    request: Option<Request>,
}

/// A request to a drive.
#[derive(Clone, Copy, Debug)]
struct Request {
    /// The state of the axis until its drive has answered.
    state: AxisState,
    /// The last tick at which an answer is awaited.
    last_tick: u64,
}

/// Messages under way at once. A further one completes at once, or fails if a drive would have to answer.
pub(super) const MESSAGES: usize = 1024;

/// The time within which a drive must answer (spec/axis-and-data-types.md §12), nanoseconds.
const ANSWER_TIME_NS: u64 = 2_000_000_000;

/// The drive did not answer, or there is no room for the request: error 12 with EXERR 2.
const NO_RESPONSE: MotionError = MotionError::ServoMessageFailure(Detail(2));

impl Motion {
    /// Sets DN now.
    pub(crate) fn done(&mut self, execution: Execution) {
        self.controls.write(execution, Flag::Dn.mask(), 0);
    }

    /// Sets DN at the next update; with `asked`, once the drive has answered and the axis has left this state.
    pub(crate) fn done_next_update(&mut self, execution: Execution, axis: AxisId, asked: Option<AxisState>) {
        let last_tick = self.clock.tick + ANSWER_TIME_NS / self.clock.period_ns;
        let request = asked.map(|state| Request { state, last_tick });
        if self.messages.len() < MESSAGES {
            self.messages.push(Message {
                execution,
                axis,
                request,
            });
        } else if request.is_some() {
            self.controls.fail(execution, NO_RESPONSE);
        } else {
            self.done(execution);
        }
    }

    /// Sets DN at the next update.
    pub(crate) fn done_at_next_update(&mut self, execution: Execution) {
        self.done_next_update(execution, AxisId::default(), None);
    }

    /// An instruction redefines the positions of the axis.
    pub(crate) fn is_redefining(&self, axis: AxisId) -> bool {
        let redefines = |message: &Message| message.axis == axis && message.execution.mnemonic == Mnemonic::Mrp;
        self.messages.iter().any(redefines)
    }

    /// Completes the messages that need no answer of a drive.
    pub(super) fn finish_messages(&mut self) {
        self.finish_where(|message, _| message.request.is_none());
    }

    /// Completes the requests that drives have answered, and fails those that they have not answered in time.
    pub(super) fn finish_requests(&mut self) {
        self.finish_where(|message, state| message.request.is_some_and(|request| state != Some(request.state)));
        let tick = self.clock.tick;
        let late = |message: &Message| message.request.is_some_and(|request| tick > request.last_tick);
        while let Some(message) = self.messages.iter().copied().find(late) {
            self.fail_requests(message.axis);
        }
    }

    /// Fails every request to the drive of an axis, which does not answer, and withdraws a request to enable it.
    fn fail_requests(&mut self, axis: AxisId) {
        let mut messages = std::mem::take(&mut self.messages);
        messages.retain(|message| {
            let fails = message.axis == axis && message.request.is_some();
            if fails {
                self.controls.fail(message.execution, NO_RESPONSE);
            }
            !fails
        });
        self.messages = messages;
        if self.axes[axis].state == AxisState::Starting {
            self.axes[axis].disable(AxisState::Stopped);
        }
    }

    /// Sets DN of messages, in order. `done` decides by the message and the state of its axis.
    fn finish_where(&mut self, done: impl Fn(&Message, Option<AxisState>) -> bool) {
        let mut messages = std::mem::take(&mut self.messages);
        messages.retain(|message| {
            let axis = self.axes.get(message.axis);
            let done = done(message, axis.map(|axis| axis.state));
            if done {
                self.done(message.execution);
            }
            !done
        });
        self.messages = messages;
    }
}
