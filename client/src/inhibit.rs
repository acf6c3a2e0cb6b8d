//! STOP that holds, the mode of the controller, counters of commands, and the identification of this client: class 0x0305.

use arcline_proto::arcline::machine::{
    self, CommandCount, ControllerMode, Identification, attribute, decode_counts, decode_text, service,
};
use arcline_proto::cip;
use arcline_proto::epath::Epath;
use bytes::Bytes;

use crate::{Client, ClientError};

impl Client {
    /// STOP: stops everything that moves and inhibits motion, for every client and program, until [`Client::release_motion`].
    /// Instructions that would begin motion end with error 53. The tag `MotionInhibit` shows and does the same.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server cannot inhibit motion.
    pub async fn inhibit_motion(&self) -> Result<(), ClientError> {
        self.of_machine(service::STOP, Bytes::new()).await
    }

    /// Releases STOP, of any client: motion may begin again. Nothing moves by itself.
    ///
    /// # Errors
    /// As [`Client::inhibit_motion`].
    pub async fn release_motion(&self) -> Result<(), ClientError> {
        self.of_machine(service::RELEASE, Bytes::new()).await
    }

    /// Reads whether STOP inhibits motion.
    ///
    /// # Errors
    /// As [`Client::inhibit_motion`].
    pub async fn is_motion_inhibited(&self) -> Result<bool, ClientError> {
        let value = self.machine_attribute(attribute::MOTION_INHIBITED).await?;
        Ok(value.first().is_some_and(|byte| *byte != 0))
    }

    /// The commands of all clients since the start of the server, by kind.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server does not count them.
    pub async fn command_counts(&self) -> Result<Vec<CommandCount>, ClientError> {
        let value = self.machine_attribute(attribute::COMMANDS).await?;
        decode_counts(&value).ok_or(ClientError::Malformed {
            what: "the counters of commands are cut",
        })
    }

    /// The mode of the controller's program.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the server does not have the attribute.
    pub async fn controller_mode(&self) -> Result<ControllerMode, ClientError> {
        let value = self.machine_attribute(attribute::MODE).await?;
        let mode = value.first().copied().and_then(ControllerMode::from_number);
        mode.ok_or(ClientError::Malformed {
            what: "the mode of the controller",
        })
    }

    /// The major fault that has stopped the controller's program, in words; `None`: there is none.
    ///
    /// # Errors
    /// As [`Client::controller_mode`].
    pub async fn major_fault(&self) -> Result<Option<String>, ClientError> {
        let value = self.machine_attribute(attribute::MAJOR_FAULT).await?;
        let words = decode_text(&value).ok_or(ClientError::Malformed {
            what: "the major fault of the controller",
        })?;
        Ok(Some(words).filter(|words| !words.is_empty()))
    }

    /// Lets the controller's program run ([`ControllerMode::Run`]), or stops it and all motion ([`ControllerMode::Program`]). The change comes
    /// between two scans.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the controller has no program, the role may not, or there is no such mode to set.
    pub async fn set_controller_mode(&self, mode: ControllerMode) -> Result<(), ClientError> {
        let path = Epath::attribute(machine::CLASS, machine::INSTANCE, attribute::MODE);
        let data = Bytes::copy_from_slice(&[mode.number()]);
        let set = cip::service::SET_ATTRIBUTE_SINGLE;
        self.ask("the mode", set, path, data).await.map(drop)
    }

    /// Sends the server the product, the user and the program of this client. The server shows them where this client moves an axis or a
    /// coordinate system. A server without this service is not an error.
    ///
    /// # Errors
    /// The errors of the connection.
    pub async fn introduce(&self, identification: &Identification) -> Result<(), ClientError> {
        match self.of_machine(service::IDENTIFY, identification.to_bytes()).await {
            Err(ClientError::Refused { .. }) => Ok(()),
            done => done,
        }
    }

    async fn of_machine(&self, service: u8, data: Bytes) -> Result<(), ClientError> {
        let path = Epath::object(machine::CLASS, machine::INSTANCE);
        self.ask("the machine", service, path, data).await.map(drop)
    }

    async fn machine_attribute(&self, attribute: u16) -> Result<Bytes, ClientError> {
        let path = Epath::attribute(machine::CLASS, machine::INSTANCE, attribute);
        let get = cip::service::GET_ATTRIBUTE_SINGLE;
        Ok(self.ask("the machine", get, path, Bytes::new()).await?.data)
    }
}
