//! The cause that ended an instruction before its end: attribute 8 of class 0x0303.

use std::fmt;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use arcline_instruction_set::Ending;
use arcline_proto::arcline::execution;
use arcline_proto::cip::service;
use arcline_proto::epath::Epath;
use bytes::Bytes;

use crate::{Client, ClientError};

/// The end of an instruction before its end.
#[derive(Clone, PartialEq, Debug)]
pub struct Ended {
    /// The cause.
    pub ending: Ending,
    /// When, seconds of the machine's time.
    pub time: f64,
    /// When, by the server's clock.
    pub at: SystemTime,
}

impl Client {
    /// The cause that ended an executed instruction before its end; `None` for every other instruction, and from a server without
    /// this attribute.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn ending(&self, instance: u32) -> Result<Option<Ended>, ClientError> {
        let path = Epath::attribute(execution::CLASS, instance, execution::attribute::ENDING);
        let what = "the end of an instruction";
        match self.ask(what, service::GET_ATTRIBUTE_SINGLE, path, Bytes::new()).await {
            Ok(reply) => Ok(read(&reply.data)),
            Err(ClientError::Refused { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn read(data: &[u8]) -> Option<Ended> {
    let ending = execution::Ending::decode(data)?;
    Some(Ended {
        time: ending.time,
        at: UNIX_EPOCH.checked_add(Duration::from_micros(ending.utc_micros))?,
        ending: Ending::from_parts(ending.code, &ending.name, &ending.detail)?,
    })
}

/// `stopped by a fault: X overcurrent, at 14:03:22.123 UTC, 12.345 s of machine time`; of other endings without the time.
impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.ending)?;
        match self.ending {
            Ending::Fault { .. } => write!(f, ", at {}, {} s of machine time", time_of_day(self.at), self.time),
            Ending::Instruction { .. } | Ending::StopAll | Ending::Jog(_) => Ok(()),
        }
    }
}

/// The time of the day, UTC.
fn time_of_day(at: SystemTime) -> String {
    let since = at.duration_since(UNIX_EPOCH).unwrap_or_default();
    let seconds = since.as_secs() % 86_400;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    let (seconds, milliseconds) = (seconds % 60, since.subsec_millis());
    format!("{hours:02}:{minutes:02}:{seconds:02}.{milliseconds:03} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_read_and_told() {
        let mut data = vec![2, 1, b'X', 11];
        data.extend_from_slice(b"overcurrent");
        data.extend_from_slice(&12.345_f64.to_le_bytes());
        data.extend_from_slice(&50_602_123_000_u64.to_le_bytes());
        let ended = read(&data).expect("it is whole");
        let expected = "stopped by a fault: X overcurrent, at 14:03:22.123 UTC, 12.345 s of machine time";
        assert_eq!(ended.to_string(), expected);
        for cut in 0..data.len() {
            assert_eq!(read(&data[..cut]), None, "{cut} bytes");
        }
        let none = [&[0, 0, 0][..], &[0; 16]].concat();
        assert_eq!(read(&none), None, "it has not ended this way");
    }
}
