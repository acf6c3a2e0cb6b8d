//! The source of the motion of an axis or coordinate system.

use arcline_instruction_set::Object;
use arcline_proto::arcline::motion::{Mover, MoverKind, axis, coordinate_system};

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
        match self.bytes_of("a mover", object, instance, attribute).await {
            Ok(data) => {
                let mover = Mover::decode(&data).ok_or(ClientError::Malformed { what: "a mover is cut" })?;
                Ok(Some(mover).filter(|mover| mover.kind != MoverKind::NONE))
            }
            Err(ClientError::Refused { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }
}
