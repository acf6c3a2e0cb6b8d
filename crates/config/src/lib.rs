//! The configuration: TOML text in, a [`Project`] out whose machine is valid by its type.
//!
//! It reads no files and opens nothing: [`load`] takes the text, and the file's name only for its errors.
//! What the keys mean is spec/contract.md §2; the units are the machine's (position units of each axis,
//! seconds), but for the coarse update period, which is written in milliseconds.

mod describe;
mod error;
mod read;
mod section;

use std::net::SocketAddr;
use std::sync::Arc;

use arcline_controller::image::Configured;
use arcline_controller::machine::Machine;
use arcline_tag::Template;

pub use arcline_controller::image::{InstructionTag, PlainTag};
pub use describe::describe;
pub use error::{ConfigError, Problem};
pub use read::tag_type;

/// The default configuration, commented: what the server runs without `--config`.
pub const DEFAULT: &str = include_str!("default.toml");

/// Everything a configuration says.
#[derive(Clone, PartialEq, Debug)]
pub struct Project {
    /// The network side.
    pub server: ServerConfig,
    /// The motion side.
    pub machine: Machine,
    /// Instructions as tags, in configuration order, at most 1024.
    pub instruction_tags: Vec<InstructionTag>,
    /// Structure types, in configuration order: what one uses stands before it.
    pub data_types: Vec<Arc<Template>>,
    /// Plain data, in configuration order, at most 4096.
    pub tags: Vec<PlainTag>,
}

impl Project {
    /// Its tags and types.
    pub fn configured(&self) -> Configured<'_> {
        Configured {
            data_types: &self.data_types,
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
    /// Where EtherNet/IP listens, TCP and UDP; port 0 picks a free one.
    pub listen: SocketAddr,
    /// Where the HMI listens; `None`: off.
    pub hmi: Option<SocketAddr>,
}

impl Default for ServerConfig {
    fn default() -> Self {
        Self {
            name: "Arcline".to_owned(),
            listen: read::DEFAULT_LISTEN,
            hmi: Some(read::DEFAULT_HMI),
        }
    }
}

/// Reads a configuration. `file` only names the text in errors.
///
/// # Errors
/// The first thing that is wrong, with its line, column and key, what was found and what was expected.
pub fn load(text: &str, file: &str) -> Result<Project, ConfigError> {
    read::project(text, file)
}

#[cfg(test)]
mod tests;
