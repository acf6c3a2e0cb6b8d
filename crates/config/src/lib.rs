//! The configuration: TOML text in, a [`Project`] out whose machine is valid by its type.
//!
//! It reads no files and opens no sockets: [`load`] takes the text, and the file's name only for its errors.
//! The meaning of the keys is in spec/contract.md §2; the units are the machine's (position units of each axis,
//! seconds), but for the coarse update period, which is written in milliseconds.

mod describe;
mod error;
mod keys;
mod overrides;
mod page;
mod read;
mod schema;
mod section;
mod security;
mod words;
mod write;

use std::net::SocketAddr;
use std::sync::Arc;

use arcline_controller::image::{ConfiguredTags, Image};
use arcline_controller::machine::Machine;
use arcline_tag::Template;

use words::word_of;

pub use arcline_controller::image::MAX_PLAIN_TAGS as MAX_TAGS;
pub use arcline_controller::image::{InstructionTag, PlainTag};
pub use describe::describe;
pub use error::{ConfigError, Problem};
pub use overrides::{is_key, with_keys};
pub use page::page;
pub use read::{ELEMENTARY, MAX_ELEMENTS, MAX_MEMBERS, MAX_SIZE, MAX_TYPES, definitions, is_name, tag_type};
pub use schema::schema;
pub use security::{AllowList, CertificateRole, PlainAccess, Role, Security};
pub use write::{definition_of, format, table, type_of_system};

/// The default configuration, commented: the server runs it without `--config`.
pub const DEFAULT: &str = include_str!("default.toml");

/// All contents of a configuration.
#[derive(Clone, PartialEq, Debug)]
pub struct Project {
    /// The network side.
    pub server: ServerConfig,
    /// The motion side.
    pub machine: Machine,
    /// Instructions as tags, in configuration order, at most 1024.
    pub instruction_tags: Vec<InstructionTag>,
    /// The structure types of plain data, in configuration order, at most 1024.
    pub types: Vec<Arc<Template>>,
    /// Plain data, in configuration order, at most 4096.
    pub tags: Vec<PlainTag>,
}

impl Project {
    /// The tag memory at its first values.
    pub fn image(&self) -> Image {
        let mut image = Image::new(&self.machine, &self.instruction_tags, &self.tags);
        image.declare(&self.types);
        image
    }

    /// Its tags and types.
    pub fn configured(&self) -> ConfiguredTags<'_> {
        ConfiguredTags {
            data_types: &self.types,
            instructions: &self.instruction_tags,
            tags: &self.tags,
        }
    }
}

/// The `[server]` table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ServerConfig {
    /// Product name in the CIP Identity object, 1 to 32 printable ASCII characters.
    pub name: String,
    /// The address of EtherNet/IP, TCP and UDP; port 0 picks a free one.
    pub listen: SocketAddr,
    /// Further addresses of EtherNet/IP.
    pub listen_also: Vec<SocketAddr>,
    /// TCP connections at a time.
    pub max_clients: usize,
    /// TCP connections at a time from one address.
    pub max_clients_per_address: usize,
    /// Class 3 connections at a time.
    pub max_connections: usize,
    /// Class 3 connections at a time of all clients at one address.
    pub max_connections_per_address: usize,
    /// Silence after which a TCP connection is closed, s; 0: never.
    pub inactivity_timeout: u16,
    /// The address of the HMI; `None`: off.
    pub hmi: Option<SocketAddr>,
    /// The address of implicit I/O, UDP.
    pub io: IoListen,
    /// The reaction of motion when the owner of the outputs is lost, closes its connection or goes idle.
    pub io_loss: IoLoss,
    /// The reaction of motion when the class 3 connection or the session that began it is lost.
    pub connection_loss: ConnectionLoss,
    /// Silence after which the jogs (MAJ) of a client are stopped, ms; 0: never.
    pub jog_silence: u16,
    /// The `[security]` table.
    pub security: Security,
    /// The `[controller]` table.
    pub controller: ControllerConfig,
}

/// The `[controller]` table: the program of the controller.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ControllerConfig {
    /// The L5X file, relative to the folder of the configuration; `None`: no program.
    pub program: Option<String>,
    /// Whether the program does not run at first.
    pub begins_stopped: bool,
    /// Whether the program passes over unknown instructions.
    pub allow_missing: bool,
    /// The answers to the MSG instructions of the program.
    pub messages: Vec<MessageAnswer>,
    /// Wires between tags of the program and axes.
    pub wires: Vec<WireConfig>,
}

/// A row of `[[controller.wire]]`: `to` follows `from`.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct WireConfig {
    /// A BOOL or a bit of a tag, or of an axis.
    pub from: String,
    /// A BOOL or a bit of a tag, or an input of an axis.
    pub to: String,
    /// The delay of the wire: the time from a change of `from` to the change of `to`, ms.
    pub delay_ms: u32,
}

impl WireConfig {
    /// The name of the axis whose home switch the wire leads to.
    pub fn home_switch(&self) -> Option<&str> {
        let (axis, input) = self.to.rsplit_once('.')?;
        input.eq_ignore_ascii_case(HOME_SWITCH).then_some(axis)
    }
}

/// The name of the motion group if the configuration gives it none.
pub const DEFAULT_GROUP: &str = "Motion";

/// The home switch of an axis as an end of a wire: `X.home_switch`.
pub const HOME_SWITCH: &str = "home_switch";

/// A row of `[[controller.messages]]`: the answer to a MSG of the type CIP Generic.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct MessageAnswer {
    /// The service code.
    pub service: u8,
    /// The class.
    pub class: u16,
    /// The instance; `None`: any.
    pub instance: Option<u32>,
    /// The attribute; `None`: any.
    pub attribute: Option<u16>,
    /// The data for the destination.
    pub answer: Vec<u8>,
    /// Time from the request to the answer, ms.
    pub delay_ms: u32,
    /// ERR and EXERR; 0: it is answered well.
    pub error: (u16, u32),
}

/// The address of implicit I/O (class 0 and 1 connections).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum IoListen {
    /// On the address of EtherNet/IP: port 2222 beside port 44818, any free one beside another.
    #[default]
    BesideListen,
    /// Here; port 0 picks a free one.
    At(SocketAddr),
    /// Nowhere: such connections are refused.
    Off,
}

impl IoListen {
    /// The address to bind when EtherNet/IP is to listen on `listen`.
    pub fn address(self, listen: SocketAddr) -> Option<SocketAddr> {
        match self {
            Self::BesideListen => {
                let port = if listen.port() == EIP_PORT { IO_PORT } else { 0 };
                Some(SocketAddr::new(listen.ip(), port))
            }
            Self::At(address) => Some(address),
            Self::Off => None,
        }
    }
}

/// EtherNet/IP's own port.
const EIP_PORT: u16 = 44_818;
/// The UDP port of implicit I/O.
const IO_PORT: u16 = 2222;

/// The reaction of motion when the owner of the outputs is lost, closes its connection or goes idle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum IoLoss {
    /// Everything that moves is stopped, every axis by itself at its maximum deceleration.
    Stop,
    /// Every coordinate system is held: a feed override of 0.
    Hold,
    /// Motion goes on to its end.
    Finish,
}

impl IoLoss {
    /// The word of each in a configuration.
    pub const WORDS: [(&'static str, Self); 3] = [("stop", Self::Stop), ("hold", Self::Hold), ("finish", Self::Finish)];

    /// The word in a configuration.
    pub fn word(self) -> &'static str {
        word_of(words::IO_LOSS, &self)
    }
}

/// The reaction of motion when the class 3 connection or the session over which it was begun is lost: ends without a Forward
/// Close or UnRegisterSession. Motion that other clients began goes on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConnectionLoss {
    /// Jogs are stopped; everything else goes on to its end.
    Jogs,
    /// All of it is stopped.
    Stop,
    /// The coordinate systems of its coordinated moves are held (a feed override of 0), jogs are stopped; moves of single
    /// axes go on to their end.
    Hold,
    /// The motion goes on to its end, or without end.
    Finish,
}

impl ConnectionLoss {
    /// The word of each in a configuration.
    pub const WORDS: [(&'static str, Self); 4] = [
        ("jogs", Self::Jogs),
        ("stop", Self::Stop),
        ("hold", Self::Hold),
        ("finish", Self::Finish),
    ];

    /// The word in a configuration.
    pub fn word(self) -> &'static str {
        word_of(words::CONNECTION_LOSS, &self)
    }
}

impl Default for ServerConfig {
    /// The configuration of a file without the table.
    fn default() -> Self {
        read::default_server()
    }
}

/// Reads a configuration. `file` only names the text in errors.
///
/// # Errors
/// The first error, with its line, column and key, the value found and the value expected.
pub fn load(text: &str, file: &str) -> Result<Project, ConfigError> {
    load_all(text, file).map_err(|mut errors| errors.swap_remove(0))
}

/// As [`load`], with all errors of the text instead of the first one.
///
/// # Errors
/// All that is wrong, in the order of the file; at least one.
pub fn load_all(text: &str, file: &str) -> Result<Project, Vec<ConfigError>> {
    read::project(text, file)
}

#[cfg(test)]
mod tests;
