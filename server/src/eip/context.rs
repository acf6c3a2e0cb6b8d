//! The resources for the answer to a request: the device, the ends of the connection, the room for the reply, and the tag memory.

use std::net::SocketAddrV4;
use std::sync::Arc;

use arcline_controller::image::Image;
use arcline_proto::session::Transport;

use super::adapter::Adapter;
use super::device::Device;
use crate::plant::{Principal, Transaction};

/// The resources for the answer to a request.
pub(crate) struct Context<'a> {
    /// The device.
    pub(crate) device: &'a Device,
    /// The local end of the connection.
    pub(crate) local: SocketAddrV4,
    /// The longest reply, bytes with its head.
    pub(crate) budget: usize,
    /// The transport of the message.
    pub(crate) transport: Transport,
    /// The client; it owns the motion that begins.
    pub(crate) principal: Principal,
}

impl Context<'_> {
    /// The host's adapter through which the message came.
    pub(crate) fn adapter(&self) -> Arc<Adapter> {
        self.device.adapters.of(*self.local.ip())
    }
}

/// The tag memory as one message sees it.
pub(crate) enum Memory<'a, 't> {
    /// For reading; the plant's lock is free.
    Read(&'a Image),
    /// For reading and writing, under the plant's lock.
    Write(&'a mut Transaction<'t>),
}

impl<'t> Memory<'_, 't> {
    /// The tag memory for reading.
    pub(crate) fn image(&self) -> &Image {
        match self {
            Self::Read(image) => image,
            Self::Write(transaction) => transaction.image(),
        }
    }

    /// The memory for a part of the message.
    pub(crate) fn reborrow(&mut self) -> Memory<'_, 't> {
        match self {
            Self::Read(image) => Memory::Read(image),
            Self::Write(transaction) => Memory::Write(transaction),
        }
    }
}
