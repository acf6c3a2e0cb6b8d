//! The axes of a coordinate system: attributes of classes 0x0301 and 0x0302.

use bytes::Bytes;

use arcline_instruction_set::Object;
use arcline_proto::arcline::motion::{axis, coordinate_system, decode_instances};
use arcline_proto::cip::service;
use arcline_proto::epath::Epath;

use crate::{Client, ClientError};

/// An axis of a coordinate system.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SystemAxis {
    /// Its name.
    pub name: String,
    /// Its position units, such as `mm`.
    pub units: String,
}

impl Client {
    /// The axes of a coordinate system, in its order.
    ///
    /// # Errors
    /// [`ClientError::UnknownObject`]; [`ClientError::Refused`] when the server does not have the attribute; otherwise an error of the
    /// session meets.
    pub async fn axes_of(&self, system: &str) -> Result<Vec<SystemAxis>, ClientError> {
        let instance = self.instance(Object::CoordinateSystem, system).await?;
        let names = self.objects(Object::Axis).await?;
        let mut axes = Vec::new();
        for instance in self.axis_instances(system, instance).await? {
            let name = usize::from(instance)
                .checked_sub(1)
                .and_then(|index| names.get(index))
                .ok_or(CUT)?;
            let text = self.bytes_of(name, Object::Axis, instance.into(), axis::UNITS).await?;
            let (length, text) = text.split_first().ok_or(CUT)?;
            let text = text.get(..usize::from(*length)).ok_or(CUT)?;
            axes.push(SystemAxis {
                name: name.clone(),
                units: String::from_utf8_lossy(text).into_owned(),
            });
        }
        Ok(axes)
    }

    /// Reads the number of axes of a coordinate system, by its instance: instances count from 1 in the order of their tags.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server does not have the attribute; otherwise an error of the connection.
    pub async fn axis_count(&self, instance: u32) -> Result<usize, ClientError> {
        let what = "the axes of a coordinate system";
        Ok(self.axis_instances(what, instance).await?.len())
    }

    async fn axis_instances(&self, what: &str, instance: u32) -> Result<Vec<u16>, ClientError> {
        let axes = coordinate_system::AXES;
        let data = self.bytes_of(what, Object::CoordinateSystem, instance, axes).await?;
        decode_instances(&data).ok_or(CUT)
    }

    pub(crate) async fn bytes_of(
        &self,
        what: &str,
        object: Object,
        instance: u32,
        id: u16,
    ) -> Result<Bytes, ClientError> {
        let path = Epath::attribute(object.class_code(), instance, id);
        let reply = self
            .ask(what, service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await?;
        Ok(reply.data)
    }
}

const CUT: ClientError = ClientError::Malformed {
    what: "the axes of a coordinate system are cut",
};
