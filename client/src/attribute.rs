//! The numeric attributes of axes and coordinate systems, as GSV and SSV name them.

use arcline_instruction_set::Attribute;
use arcline_proto::cip::{CipStatus, service};
use arcline_proto::epath::Epath;
use bytes::Bytes;

use crate::{Client, ClientError};

impl Client {
    /// The value of a numeric attribute of an axis or a coordinate system, in the units that the attribute's
    /// [`Quantity`](arcline_instruction_set::Quantity) names.
    ///
    /// # Errors
    /// [`ClientError::UnknownObject`] when there is no object of that name.
    pub async fn attribute(&self, attribute: &Attribute, name: &str) -> Result<f64, ClientError> {
        let path = self.attribute_path(attribute, name).await?;
        let reply = self
            .ask(name, service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await?;
        attribute.decode(&reply.data).ok_or(ClientError::Malformed {
            what: "an attribute is shorter than its type",
        })
    }

    /// Sets an attribute that can be set, such as the Command Position Tolerance of a coordinate system: it holds for the instructions that are
    /// executed afterwards, until the server restarts.
    ///
    /// # Errors
    /// [`ClientError::UnknownObject`] when there is no object of that name; [`ClientError::AttributeValue`] for a value that the
    /// attribute cannot have; [`ClientError::Refused`]: 0x0E for an attribute that only the configuration sets.
    pub async fn set_attribute(&self, attribute: &Attribute, name: &str, value: f64) -> Result<(), ClientError> {
        let path = self.attribute_path(attribute, name).await?;
        let data = Bytes::from(attribute.encode(value));
        match self.ask(name, service::SET_ATTRIBUTE_SINGLE, path, data).await {
            Err(ClientError::Refused { status, .. }) if status.is(CipStatus::INVALID_ATTRIBUTE_VALUE) => {
                Err(ClientError::AttributeValue {
                    name: attribute.name,
                    value,
                    range: attribute.range(),
                })
            }
            answer => answer.map(drop),
        }
    }

    async fn attribute_path(&self, attribute: &Attribute, name: &str) -> Result<Epath, ClientError> {
        let instance = self.instance(attribute.object, name).await?;
        Ok(Epath::attribute(
            attribute.object.class_code(),
            instance,
            attribute.number,
        ))
    }
}
