//! Faults of axes: the faults that an axis shows, and injected causes (attributes of class 0x0301).

use arcline_instruction_set::{FAULTS, FaultSet, FaultWord, Object};
use arcline_proto::arcline::motion::axis;
use arcline_proto::cip::service;
use arcline_proto::epath::Epath;
use arcline_tag::Value;
use bytes::Bytes;

use crate::{Client, ClientError, TagValue};

impl Client {
    /// The causes of faults that are injected into an axis.
    ///
    /// # Errors
    /// [`ClientError::UnknownObject`] when there is no such axis; [`ClientError::Refused`] when the server has no injection.
    pub async fn injected_faults(&self, axis: &str) -> Result<FaultSet, ClientError> {
        self.fault_attribute(axis, axis::INJECTED_FAULTS).await
    }

    /// The causes of faults that can be injected into an axis.
    ///
    /// # Errors
    /// As [`Client::injected_faults`].
    pub async fn possible_faults(&self, axis: &str) -> Result<FaultSet, ClientError> {
        self.fault_attribute(axis, axis::POSSIBLE_FAULTS).await
    }

    /// Sets the causes of faults that are injected into an axis: each is there until it is taken out of the set.
    ///
    /// # Errors
    /// As [`Client::injected_faults`]; [`ClientError::Refused`] (0x09) for a cause that the axis cannot have.
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// use arcline_client::{FaultKind, FaultSet};
    ///
    /// client.inject_faults("X", FaultSet::default().with(FaultKind::Overcurrent)).await?;
    /// # Ok(())
    /// # }
    /// ```
    pub async fn inject_faults(&self, axis: &str, causes: FaultSet) -> Result<(), ClientError> {
        let path = self.axis_path(axis, axis::INJECTED_FAULTS).await?;
        let value = Bytes::copy_from_slice(&causes.bits().to_le_bytes());
        self.ask(axis, service::SET_ATTRIBUTE_SINGLE, path, value).await?;
        Ok(())
    }

    async fn fault_attribute(&self, axis: &str, attribute: u16) -> Result<FaultSet, ClientError> {
        let path = self.axis_path(axis, attribute).await?;
        let reply = self
            .ask(axis, service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await?;
        let value = reply.data.first_chunk().ok_or(ClientError::Malformed {
            what: "a set of faults is not a UDINT",
        })?;
        Ok(FaultSet::from_bits(u32::from_le_bytes(*value)))
    }

    async fn axis_path(&self, axis: &str, attribute: u16) -> Result<Epath, ClientError> {
        let instance = self.instance(Object::Axis, axis).await?;
        Ok(Epath::attribute(Object::Axis.class_code(), instance, attribute))
    }
}

/// The faults that the tag of an axis shows in MotionFaultStatus and CIPAxisFaults. AXIS_VIRTUAL has neither.
pub fn shown_faults(axis: &TagValue) -> FaultSet {
    let word = |name| match axis.member(name).and_then(TagValue::value) {
        Some(Value::Dint(word)) => i64::from(word) as u64,
        Some(Value::Lint(word)) => word as u64,
        _ => 0,
    };
    let (motion, cip) = (word("MotionFaultStatus"), word("CIPAxisFaults"));
    let shown = FAULTS.iter().filter(|fault| {
        let word = match fault.shows {
            FaultWord::Motion => motion,
            FaultWord::Cip => cip,
        };
        word >> fault.bit & 1 != 0
    });
    shown.fold(FaultSet::default(), |set, fault| set.with(fault.kind))
}
