//! The progress of the active move of a coordinate system: attributes of class 0x0302.

use arcline_instruction_set::{FaultSet, Object};
use arcline_proto::arcline::motion::{axis, coordinate_system};
use arcline_proto::cip::{encode_attribute_ids, service};
use arcline_proto::epath::Epath;
use arcline_proto::wire::Reader;
use bytes::Bytes;

use crate::{Client, ClientError};

/// Attributes of a coordinate system, LREAL: distance to go of the active move, length of its path, seconds to its end.
const PROGRESS: [u16; 3] = [
    coordinate_system::DISTANCE_TO_GO,
    coordinate_system::PATH_LENGTH,
    coordinate_system::TIME_LEFT,
];

/// The active move of a coordinate system.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Progress {
    /// Distance to go along its path, position units.
    pub remaining: f64,
    /// Length of its path, position units, above 0.
    pub length: f64,
    /// Seconds until its end or its successor as it is planned now, deceleration included; `None` while it is held, is stopped or follows
    /// a master.
    pub time_left: Option<f64>,
}

impl Progress {
    /// The part of the path that is done, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        (1.0 - self.remaining / self.length).clamp(0.0, 1.0)
    }
}

impl Client {
    /// The active move of a coordinate system by its instance; `None` when there is none, and on a server that does not show it.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn progress(&self, instance: u32) -> Result<Option<Progress>, ClientError> {
        let path = Epath::object(Object::CoordinateSystem.class_code(), instance);
        let what = "the progress of a move";
        match self
            .ask(what, service::GET_ATTRIBUTE_LIST, path, encode_attribute_ids(&PROGRESS))
            .await
        {
            Ok(reply) => Ok(read(&reply.data).filter(|progress| progress.length > 0.0)),
            Err(ClientError::Refused { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The faults of an axis by its instance, by their kind; none on a server that does not show them.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn faults_of(&self, instance: u32) -> Result<FaultSet, ClientError> {
        let path = Epath::attribute(Object::Axis.class_code(), instance, axis::FAULTS);
        let what = "the faults of an axis";
        match self.ask(what, service::GET_ATTRIBUTE_SINGLE, path, Bytes::new()).await {
            Ok(reply) => {
                let bits = reply.data.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
                Ok(FaultSet::from_bits(bits.unwrap_or_default()))
            }
            Err(ClientError::Refused { .. }) => Ok(FaultSet::default()),
            Err(error) => Err(error),
        }
    }
}

/// The answer of Get Attribute List: count, then id, status and value of each.
fn read(data: &[u8]) -> Option<Progress> {
    let mut reader = Reader::new(data);
    let count = reader.u16()?;
    let mut numbers = [0.0; PROGRESS.len()];
    if usize::from(count) != numbers.len() {
        return None;
    }
    for (number, id) in numbers.iter_mut().zip(PROGRESS) {
        if (reader.u16()?, reader.u16()?) != (id, 0) {
            return None;
        }
        *number = f64::from_le_bytes(reader.array()?);
    }
    let [remaining, length, time_left] = numbers;
    Some(Progress {
        remaining,
        length,
        time_left: Some(time_left).filter(|time| time.is_finite()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_is_read_and_every_cut_refused() {
        let mut data = vec![3, 0];
        for (id, number) in PROGRESS.iter().zip([25.0_f64, 100.0, f64::NAN]) {
            data.extend_from_slice(&id.to_le_bytes());
            data.extend_from_slice(&[0, 0]);
            data.extend_from_slice(&number.to_le_bytes());
        }
        let progress = read(&data).expect("it is whole");
        assert_eq!(
            (progress.remaining, progress.length, progress.time_left),
            (25.0, 100.0, None)
        );
        assert_eq!(progress.share(), 0.75);
        for cut in 0..data.len() {
            assert_eq!(read(&data[..cut]), None, "{cut} bytes");
        }
    }
}
