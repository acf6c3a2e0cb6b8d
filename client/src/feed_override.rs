//! The feed override of coordinate systems: the tag `FeedOverride`, and attributes of class 0x0302.

use arcline_instruction_set::Object;
use arcline_proto::arcline::motion::coordinate_system;
use arcline_proto::cip::service;
use arcline_proto::epath::Epath;
use bytes::Bytes;

use crate::{Client, ClientError};

impl Client {
    /// The feed override of a coordinate system, in percent: 100 as programmed, 0 holds its moves.
    ///
    /// # Errors
    /// [`ClientError::UnknownObject`] when there is no such coordinate system; [`ClientError::Refused`] when the server
    /// has no overrides.
    pub async fn feed_override(&self, system: &str) -> Result<f64, ClientError> {
        self.override_attribute(system, coordinate_system::FEED_OVERRIDE).await
    }

    /// The last feed override of a coordinate system that was not 0, in percent: the value that resuming restores.
    ///
    /// # Errors
    /// As [`Client::feed_override`].
    pub async fn feed_override_before_hold(&self, system: &str) -> Result<f64, ClientError> {
        self.override_attribute(system, coordinate_system::OVERRIDE_BEFORE_HOLD)
            .await
    }

    /// Sets the feed override of a coordinate system, in percent, 0 to 200. It holds for its coordinated moves until it
    /// is changed; 0 holds them, at rest on their path.
    ///
    /// # Errors
    /// As [`Client::feed_override`]; [`ClientError::Refused`] (0x09) for a percentage out of range.
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// client.set_feed_override("CS1", 50.0).await?;
    /// # Ok(())
    /// # }
    /// ```
    pub async fn set_feed_override(&self, system: &str, percent: f64) -> Result<(), ClientError> {
        let path = self.override_path(system, coordinate_system::FEED_OVERRIDE).await?;
        let value = Bytes::copy_from_slice(&(percent as f32).to_le_bytes());
        self.ask(system, service::SET_ATTRIBUTE_SINGLE, path, value).await?;
        Ok(())
    }

    async fn override_attribute(&self, system: &str, attribute: u16) -> Result<f64, ClientError> {
        let path = self.override_path(system, attribute).await?;
        let reply = self
            .ask(system, service::GET_ATTRIBUTE_SINGLE, path, Bytes::new())
            .await?;
        let value = reply.data.first_chunk().ok_or(ClientError::Malformed {
            what: "an override is not a REAL",
        })?;
        Ok(f32::from_le_bytes(*value).into())
    }

    async fn override_path(&self, system: &str, attribute: u16) -> Result<Epath, ClientError> {
        let instance = self.instance(Object::CoordinateSystem, system).await?;
        Ok(Epath::attribute(
            Object::CoordinateSystem.class_code(),
            instance,
            attribute,
        ))
    }
}
