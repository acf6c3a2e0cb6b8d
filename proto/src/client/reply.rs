//! Replies inside frames, without their encapsulation.
//!
//! Not here: the call of a reply, and the meaning of its status.

use bytes::Bytes;
use std::net::SocketAddrV4;

use super::ClientError;
use crate::cip::Reply;
use crate::cpf::{Item, Packet, decode_items};
use crate::encap::{Command, EncapFrame};
use crate::identity::Identity;

pub(super) fn unconnected_reply(frame: &EncapFrame) -> Result<Reply, ClientError> {
    let packet = Packet::decode(&frame.data)?;
    Reply::decode(packet.unconnected_message()?).ok_or(ClientError::Malformed(Command::SEND_RR_DATA))
}

pub(super) fn connected_reply(frame: &EncapFrame) -> Result<Reply, ClientError> {
    let (_, _, message) = Packet::decode_connected(&frame.data)?;
    Reply::decode(&message).ok_or(ClientError::Malformed(Command::SEND_UNIT_DATA))
}

pub(super) fn identity(data: &Bytes) -> Option<(SocketAddrV4, Identity)> {
    decode_items(data).ok()?.iter().find_map(|item| match item {
        Item::Identity(data) => Identity::decode_item(data),
        _ => None,
    })
}
