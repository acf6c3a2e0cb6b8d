//! Asks an Arcline server, or any Logix-like controller, over EtherNet/IP: tags, motion instructions, discovery.
//!
//! Asynchronous, on tokio. Every value that comes from the server is checked before it is believed: a wrong length or
//! type is an error, and the client holds at most [`MAX_BYTES`] of one tag. Not here: the effect of an instruction. The
//! command line, the binary `arcline` of this package, is [`cli`]; the feature of that name leaves it out.
//!
//! # Tags
//!
//! ```no_run
//! # async fn example() -> Result<(), arcline_client::ClientError> {
//! use arcline_client::Client;
//!
//! let client = Client::connect("127.0.0.1:44818").await?;
//! println!("X is at {}", client.read("X.ActualPosition").await?);
//! client.write("Move1.Position", vec![100.0, 50.0, 0.0]).await?;
//! for tag in client.browse().await? {
//!     println!("{} {}", tag.name, tag.type_name());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Motion
//!
//! ```no_run
//! # async fn example() -> Result<(), arcline_client::ClientError> {
//! use std::time::Duration;
//! use arcline_client::{Client, Flag, Mnemonic, Operands};
//!
//! let client = Client::connect("127.0.0.1").await?;
//! let operands = Operands::full_speed(Mnemonic::Mclm)
//!     .with("Position", vec![100.0, 50.0, 0.0])?
//!     .with("Speed", 50.0)?;
//! let execution = client.execute(Mnemonic::Mclm, "CS1", "", operands.as_slice()).await?;
//! client.wait_for(&execution, Flag::Pc, Duration::from_secs(60)).await?;
//! # Ok(())
//! # }
//! ```
//!
//! # Lost connections
//!
//! A [`Client`] has one TCP connection and on it one class 3 connection. When a reply does not come in time
//! ([`ClientError::Timeout`]), the class 3 connection is lost; the next request opens it again. A request that only reads is
//! then repeated once. A write or an instruction without a reply is never repeated, since the server may have carried it out:
//! read the tag or the motion control tag, then decide. When the TCP connection is lost, every request fails with
//! [`ClientError::Closed`]; connect again, and expect that the jogs of the lost connection have been stopped.
#![forbid(unsafe_code)]

// The command line names this library as any other program does.
#[cfg(feature = "cli")]
extern crate self as arcline_client;

#[cfg(feature = "cli")]
pub mod cli;

mod attribute;
mod client;
mod discover;
mod ended;
mod error;
mod fault;
mod feed_override;
mod fetch;
mod inhibit;
mod link;
mod machine;
mod motion;
mod mover;
mod program;
mod progress;
mod read;
mod refusal;
mod series;
mod tags;
mod tls;
mod trace;
mod write;

pub use arcline_instruction_set::{
    ATTRIBUTES, Attribute, FaultKind, FaultSet, Flag, Mnemonic, MotionControl, Object, UnboundOperand,
};
pub use arcline_proto::arcline::machine::{CommandCount, ControllerMode, Identification};
pub use arcline_proto::arcline::motion::{Mover, MoverKind};
pub use arcline_proto::identity::Identity;
pub use arcline_tag::{Elementary, StructureValue, TagType, TagValue, Value, WriteValue, nearest};

pub use client::{Client, DEFAULT_PORT, Options};
pub use discover::{Discovered, discover};
pub use ended::Ended;
pub use error::ClientError;
pub use fault::shown_faults;
pub use machine::SystemAxis;
pub use motion::{Execution, Operands};
pub use program::{Event, OnError, ProgramError, QueueFull, Runner, TICK};
pub use progress::Progress;
pub use read::MAX_BYTES;
pub use tags::{Access, Tag};
pub use tls::{TLS_PORT, Tls, TlsFiles};
pub use trace::{TraceRequest, TraceRows, TraceState, Trigger};
