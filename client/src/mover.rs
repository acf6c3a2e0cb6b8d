//! The source of the motion of an axis or coordinate system.

use arcline_instruction_set::Object;
use arcline_proto::arcline::motion::{Mover, MoverKind, axis, coordinate_system};
use arcline_proto::cip::service;
use arcline_proto::epath::Epath;
use bytes::Bytes;

use crate::{Client, ClientError};

impl Client {
    /// The client, page, program or server that moves an axis or coordinate system, by its instance: instances count from 1 in the
    /// order of their tags. `None` while no instruction moves it, for the motion group, and on a server that does not show it.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn mover(&self, object: Object, instance: u32) -> Result<Option<Mover>, ClientError> {
        let attribute = match object {
            Object::Axis => axis::MOVER,
            Object::CoordinateSystem => coordinate_system::MOVER,
            Object::MotionGroup => return Ok(None),
        };
        let path = Epath::attribute(object.class_code(), instance, attribute);
        match self
            .ask("a mover", service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await
        {
            Ok(reply) => {
                let mover = Mover::decode(&reply.data).ok_or(ClientError::Malformed { what: "a mover is cut" })?;
                Ok(Some(mover).filter(|mover| mover.kind != MoverKind::NONE))
            }
            Err(ClientError::Refused { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }
}
