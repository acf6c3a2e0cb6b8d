//! Every tick of any signals: the Trace object, class 0x0304 (docs/TRACE.md).
//!
//! Not here: the files of traces. Ticks count from the start of the server; values are exact 64-bit numbers.

use std::time::Duration;

use bytes::Bytes;

use arcline_instruction_set::Mnemonic;
use arcline_proto::arcline::trace::{
    CLASS, ListSignals, MAX_SIGNALS, ReadRows, Rows, SignalList, State, TRIGGER_INDEX, TooLong, class_attribute,
    service::{LIST_SIGNALS, READ, STOP},
};
use arcline_proto::cip::{CipStatus, Request, service};
use arcline_proto::epath::Epath;
use arcline_proto::wire::Reader;

use crate::{Client, ClientError};

pub use arcline_proto::arcline::trace::{TraceRequest, Trigger};

/// Most signals that are listed.
const MAX_NAMES: usize = 65_535;

/// The state of a trace.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TraceState {
    /// Waits for its trigger.
    Armed,
    /// Records.
    Running,
    /// Complete, or stopped.
    Ended,
}

/// Rows of a trace, without a gap between them.
#[derive(Clone, PartialEq, Debug)]
pub struct TraceRows {
    /// The state of the trace.
    pub state: TraceState,
    /// Tick of the first row.
    pub first: u64,
    /// Ticks from row to row.
    pub every: u16,
    /// One sample for each signal.
    pub rows: Vec<Vec<f64>>,
}

impl TraceRows {
    /// The first tick of the next request.
    pub fn next(&self) -> u64 {
        self.first
            .saturating_add(self.rows.len() as u64 * u64::from(self.every.max(1)))
    }
}

impl Client {
    /// The coarse update period: the time of a tick.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server has no Trace object.
    pub async fn trace_period(&self) -> Result<Duration, ClientError> {
        let path = Epath::attribute(CLASS, 0, class_attribute::PERIOD);
        let reply = self
            .ask("the trace", service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await?;
        let nanoseconds = Reader::new(&reply.data).u32().ok_or(CUT)?;
        Ok(Duration::from_nanos(nanoseconds.into()))
    }

    /// The signals that can be traced; the bits of words, which can be traced too, are not listed.
    ///
    /// # Errors
    /// As [`Client::trace_period`].
    pub async fn trace_signals(&self) -> Result<Vec<String>, ClientError> {
        let mut names: Vec<String> = Vec::new();
        loop {
            let from = u16::try_from(names.len()).map_err(|_| CUT)?;
            let data = ListSignals { first: from }.to_bytes();
            let reply = self
                .ask("the trace", LIST_SIGNALS, Epath::object(CLASS, 0), data)
                .await?;
            let list = SignalList::decode(&reply.data).ok_or(CUT)?;
            let is_last = list.names.is_empty();
            names.extend(list.names);
            if is_last || names.len() >= usize::from(list.total).min(MAX_NAMES) {
                return Ok(names);
            }
        }
    }

    /// Arms a trace. Returns its instance. The server deletes it after a minute without a request for it.
    ///
    /// # Errors
    /// [`ClientError::UnknownTag`] for a signal, a tag or an instruction that there is not; [`ClientError::Refused`] when
    /// there are too many traces, or one is too long.
    pub async fn start_trace(&self, request: &TraceRequest) -> Result<u32, ClientError> {
        let data = request.to_bytes()?;
        let reply = self
            .request(Request::new(service::CREATE, Epath::object(CLASS, 0), data))
            .await?;
        if reply.status.is_success() {
            return Reader::new(&reply.data).u32().ok_or(CUT);
        }
        let index = reply.status.additional().first().copied();
        let is_name = reply.status.general() == CipStatus::PATH_DESTINATION_UNKNOWN.general();
        let Some(index) = index.filter(|_| is_name) else {
            return Err(ClientError::refused("the trace", reply.status));
        };
        let name = match (&request.trigger, index) {
            (Trigger::Instruction { name, .. }, TRIGGER_INDEX) => {
                let known = self.instruction_names().await.unwrap_or_default();
                return Err(ClientError::unknown_tag(name, known));
            }
            (trigger, TRIGGER_INDEX) => trigger.name(),
            (_, index) => request.signals.get(usize::from(index)).map(String::as_str),
        };
        let name = name.ok_or(CUT)?;
        let known = self.trace_signals().await.unwrap_or_default();
        Err(ClientError::unknown_tag(name, known))
    }

    /// The names that a trigger accepts for an instruction: motion control tags, instruction tags, mnemonics. A motion control tag
    /// that its first execution will make can too, and is not among them.
    ///
    /// # Errors
    /// As [`Client::browse`].
    pub async fn instruction_names(&self) -> Result<Vec<String>, ClientError> {
        let tags = self.browse().await?.into_iter();
        let of_type = |name: &str| name == "MOTION_INSTRUCTION" || name.parse::<Mnemonic>().is_ok();
        let tags = tags.filter(|tag| of_type(&tag.type_name())).map(|tag| tag.name);
        Ok(tags.chain(Mnemonic::ALL.iter().map(ToString::to_string)).collect())
    }

    /// The rows of a trace from a tick on, as many as one reply holds; `from` 0 is its beginning.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn read_trace(&self, instance: u32, from: u64) -> Result<TraceRows, ClientError> {
        let data = ReadRows { from, most: 0 }.to_bytes();
        let path = Epath::object(CLASS, instance);
        let reply = self.ask("the trace", READ, path, data).await?;
        Rows::decode(&reply.data).map(TraceRows::from).ok_or(CUT)
    }

    /// Ends a trace; its recorded rows can still be read.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn stop_trace(&self, instance: u32) -> Result<(), ClientError> {
        self.ask("the trace", STOP, Epath::object(CLASS, instance), Bytes::new())
            .await
            .map(drop)
    }

    /// Deletes a trace.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn delete_trace(&self, instance: u32) -> Result<(), ClientError> {
        let path = Epath::object(CLASS, instance);
        self.ask("the trace", service::DELETE, path, Bytes::new())
            .await
            .map(drop)
    }
}

impl From<Rows> for TraceRows {
    fn from(rows: Rows) -> Self {
        TraceRows {
            state: match rows.state {
                State::Armed => TraceState::Armed,
                State::Running => TraceState::Running,
                State::Complete | State::Stopped => TraceState::Ended,
            },
            first: rows.first,
            every: rows.every,
            rows: rows
                .samples
                .chunks(usize::from(rows.signals).max(1))
                .map(<[f64]>::to_vec)
                .collect(),
        }
    }
}

impl From<TooLong> for ClientError {
    fn from(error: TooLong) -> Self {
        match error {
            TooLong::Signals { count } => ClientError::TooLarge {
                what: "the number of signals",
                claimed: count,
                limit: MAX_SIGNALS.into(),
            },
            TooLong::Name { bytes } => ClientError::TooLarge {
                what: "the length of a name",
                claimed: bytes,
                limit: u8::MAX.into(),
            },
        }
    }
}

const CUT: ClientError = ClientError::Malformed {
    what: "a reply of the trace is cut",
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_one_another_every_so_many_ticks() {
        let rows = TraceRows::from(Rows {
            state: State::Stopped,
            signals: 2,
            every: 3,
            first: 100,
            samples: vec![1.5, -2.5, 3.5, 4.5],
        });
        assert_eq!((rows.state, rows.next()), (TraceState::Ended, 106));
        assert_eq!(rows.rows, [[1.5, -2.5], [3.5, 4.5]]);
    }
}
