//! STOP that holds: the tag `MotionInhibit`.

use crate::{Client, ClientError};

/// The tag that stops all motion and inhibits it.
const MOTION_INHIBIT: &str = "MotionInhibit";

impl Client {
    /// STOP: stops everything that moves and inhibits motion, for every client and program, until [`Client::release_motion`].
    /// Instructions that would begin motion end with error 53.
    ///
    /// # Errors
    /// [`ClientError::UnknownTag`] when the server cannot inhibit motion.
    pub async fn inhibit_motion(&self) -> Result<(), ClientError> {
        self.write(MOTION_INHIBIT, true).await
    }

    /// Releases STOP, of any client: motion may begin again. Nothing moves by itself.
    ///
    /// # Errors
    /// As [`Client::inhibit_motion`].
    pub async fn release_motion(&self) -> Result<(), ClientError> {
        self.write(MOTION_INHIBIT, false).await
    }

    /// Whether STOP inhibits motion.
    ///
    /// # Errors
    /// As [`Client::inhibit_motion`].
    pub async fn is_motion_inhibited(&self) -> Result<bool, ClientError> {
        Ok(self.read(MOTION_INHIBIT).await?.as_bool().unwrap_or(false))
    }
}
