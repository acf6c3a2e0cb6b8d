//! The instructions that a program has executed: the newest ones in order, and the newest one of each motion control tag.

use std::collections::{BTreeMap, VecDeque};

use arcline_instruction_set::{Ending, Mnemonic};

use crate::EvaluatedCall;

/// Executions that a program remembers: as many as the newest ones that have instances of class 0x0303.
const REMEMBERED: usize = 4096;

/// A call that was executed.
#[derive(Clone, PartialEq, Debug)]
pub struct Called<X> {
    /// Line of the call, from 1.
    pub line: usize,
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// Name of the object it acts on, as written.
    pub target: String,
    /// Its motion control tag, as written; empty: none.
    pub tag: String,
    /// Its execution; `None`: it erred at once, or EnableIn of the instruction tag [`Called::tag`] began it.
    pub execution: Option<X>,
}

impl<X> Called<X> {
    pub(crate) fn new(call: &EvaluatedCall, execution: Option<X>) -> Self {
        Self {
            line: call.line,
            mnemonic: call.mnemonic,
            target: call.target.clone(),
            tag: call.control.clone().unwrap_or_default(),
            execution,
        }
    }

    /// The execution that EnableIn of an instruction tag began.
    pub(crate) fn enabled(line: usize, mnemonic: Mnemonic, tag: &str) -> Self {
        Self {
            line,
            mnemonic,
            target: tag.to_owned(),
            tag: tag.to_owned(),
            execution: None,
        }
    }
}

/// The known state of an execution.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum CallState {
    /// Its end has not been observed.
    Running,
    /// It has ended without PC, and the run has not read its cause yet.
    Incomplete,
    /// It has ended, and the run has reported its end.
    Over,
}

/// The calls of a program that have been executed.
#[derive(Clone, Debug)]
pub struct Calls<X> {
    /// The newest ones, oldest first.
    executed: VecDeque<(CallState, Called<X>)>,
    /// The number of them that run.
    running: usize,
    /// The index at which the next read of running executions begins.
    next: usize,
    /// The newest execution by motion control tag or instruction tag, in lower case.
    newest: BTreeMap<String, Called<X>>,
    /// The executions by EnableIn whose end has not been observed, one a tag.
    enabled: VecDeque<Called<X>>,
}

impl<X> Default for Calls<X> {
    fn default() -> Self {
        Self {
            executed: VecDeque::new(),
            running: 0,
            next: 0,
            newest: BTreeMap::new(),
            enabled: VecDeque::new(),
        }
    }
}

impl<X: Clone> Calls<X> {
    /// The newest call of a motion control tag, or the newest execution that EnableIn of an instruction tag began.
    pub fn newest(&self, tag: &str) -> Option<&Called<X>> {
        // Most tags that programs read are not among them: no text is made for these.
        if self.newest.is_empty() {
            return None;
        }
        self.newest.get(&tag.to_ascii_lowercase())
    }

    /// The newest 4,096 calls that were accepted, oldest first.
    pub fn executed(&self) -> impl Iterator<Item = &Called<X>> {
        self.executed.iter().map(|(_, called)| called)
    }

    pub(crate) fn add(&mut self, called: Called<X>) {
        if !called.tag.is_empty() {
            self.newest.insert(called.tag.to_ascii_lowercase(), called.clone());
        }
        if called.execution.is_none() {
            return;
        }
        if self.executed.len() == REMEMBERED
            && let Some((state, _)) = self.executed.pop_front()
        {
            self.running -= usize::from(state == CallState::Running);
            self.next = self.next.saturating_sub(1);
        }
        self.executed.push_back((CallState::Running, called));
        self.running += 1;
    }

    /// Adds an execution by EnableIn that runs.
    pub(crate) fn enable(&mut self, called: Called<X>) {
        self.enabled
            .retain(|earlier| !earlier.tag.eq_ignore_ascii_case(&called.tag));
        self.enabled.push_back(called);
    }

    /// The number of executions by EnableIn whose end has not been observed.
    pub(crate) fn enabled(&self) -> usize {
        self.enabled.len()
    }

    /// Takes the execution by EnableIn whose progress was read least recently.
    pub(crate) fn take_enabled(&mut self) -> Option<Called<X>> {
        self.enabled.pop_front()
    }

    /// Whether an instruction of the program ended another one.
    pub(crate) fn is_own(&self, ending: &Ending) -> bool {
        matches!(ending, Ending::Instruction { tag, .. } if self.newest(tag).is_some())
    }

    pub(crate) fn first(&self, state: CallState) -> Option<(usize, &Called<X>)> {
        let mut executed = self.executed.iter().enumerate();
        executed.find_map(|(index, (now, called))| (*now == state).then_some((index, called)))
    }

    pub(crate) fn set(&mut self, index: usize, state: CallState) {
        if let Some((now, _)) = self.executed.get_mut(index) {
            self.running -= usize::from(*now == CallState::Running && state != CallState::Running);
            *now = state;
        }
    }

    /// The number of executions whose end has not been observed.
    pub(crate) fn running(&self) -> usize {
        self.running
    }

    /// The oldest one that runs, from an index on.
    pub(crate) fn oldest_running(&self, from: usize) -> Option<(usize, &Called<X>)> {
        let mut behind = (from..).zip(self.executed.iter().skip(from));
        behind.find_map(|(index, (state, called))| (*state == CallState::Running).then_some((index, called)))
    }

    /// The next one that runs, those of earlier reads last.
    pub(crate) fn next_running(&mut self) -> Option<(usize, &Called<X>)> {
        let count = self.executed.len();
        let is_running = |index: &usize| {
            self.executed
                .get(*index)
                .is_some_and(|(state, _)| *state == CallState::Running)
        };
        let index = (self.next..count).chain(0..self.next.min(count)).find(is_running)?;
        self.next = index + 1;
        let (_, called) = self.executed.get(index)?;
        Some((index, called))
    }
}
