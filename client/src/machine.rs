//! What a coordinate system is made of: attributes of classes 0x0301 and 0x0302.

use bytes::Bytes;

use arcline_instruction_set::Object;
use arcline_proto::cip::service;
use arcline_proto::epath::Epath;
use arcline_proto::wire::Reader;

use crate::{Client, ClientError};

/// Attribute of a coordinate system: `n UINT, instance of the axis UINT × n`.
const AXES: u16 = 2;
/// Attribute of an axis: its position units, SHORT_STRING.
const UNITS: u16 = 8;

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
    /// [`ClientError::UnknownObject`]; [`ClientError::Refused`] when the server does not tell it; otherwise what the
    /// session meets.
    pub async fn axes_of(&self, system: &str) -> Result<Vec<SystemAxis>, ClientError> {
        let instance = self.instance(Object::CoordinateSystem, system).await?;
        let names = self.objects(Object::Axis).await?;
        let data = self.bytes_of(system, Object::CoordinateSystem, instance, AXES).await?;
        let mut reader = Reader::new(&data);
        let count = reader.u16().ok_or(CUT)?;
        let mut axes = Vec::new();
        for _ in 0..count {
            let instance = reader.u16().ok_or(CUT)?;
            let name = usize::from(instance)
                .checked_sub(1)
                .and_then(|place| names.get(place))
                .ok_or(CUT)?;
            let text = self.bytes_of(name, Object::Axis, instance.into(), UNITS).await?;
            let (length, text) = text.split_first().ok_or(CUT)?;
            let text = text.get(..usize::from(*length)).ok_or(CUT)?;
            axes.push(SystemAxis {
                name: name.clone(),
                units: String::from_utf8_lossy(text).into_owned(),
            });
        }
        Ok(axes)
    }

    /// How many axes a coordinate system has, by its instance: they count from 1 in the order of their tags.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server does not tell it; otherwise what the session meets.
    pub async fn axis_count(&self, instance: u32) -> Result<usize, ClientError> {
        let what = "the axes of a coordinate system";
        let data = self.bytes_of(what, Object::CoordinateSystem, instance, AXES).await?;
        Reader::new(&data).u16().map(usize::from).ok_or(CUT)
    }

    async fn bytes_of(&self, what: &str, object: Object, instance: u32, id: u16) -> Result<Bytes, ClientError> {
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
