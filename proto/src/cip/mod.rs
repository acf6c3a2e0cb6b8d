//! CIP messages: router request and reply (CIP Vol. 1, 2-4), the attribute list services, and the Multiple Service
//! Packet (spec/ethernet-ip.md §4, §9.1, §13). Status codes are in [`crate::status`].
//!
//! Not here: the effects of services. Surplus bytes behind a request's data are the service's business, and most must ignore them.

mod attribute_list;
mod message;
mod multiple_service;

pub use crate::status::CipStatus;
pub use attribute_list::{
    AttributeListReader, AttributeListReply, MAX_ATTRIBUTES, decode_attribute_ids, encode_attribute_ids,
};
pub use message::{REPLY_HEAD, Reply, Request, RequestError, is_stray_route};
pub use multiple_service::{MAX_SERVICES, MultipleReplies, join_multiple, split_multiple, split_multiple_replies};

/// Class ids every device has, and those of a Logix controller (spec/ethernet-ip.md §13).
pub mod class {
    /// Identity.
    pub const IDENTITY: u16 = 0x01;
    /// Message Router.
    pub const MESSAGE_ROUTER: u16 = 0x02;
    /// Assembly.
    pub const ASSEMBLY: u16 = 0x04;
    /// Connection Manager.
    pub const CONNECTION_MANAGER: u16 = 0x06;
    /// Quality of service.
    pub const QOS: u16 = 0x48;
    /// CIP Security.
    pub const CIP_SECURITY: u16 = 0x5D;
    /// EtherNet/IP Security.
    pub const ETHERNET_IP_SECURITY: u16 = 0x5E;
    /// Certificate Management.
    pub const CERTIFICATE_MANAGEMENT: u16 = 0x5F;
    /// Program name.
    pub const PROGRAM_NAME: u16 = 0x64;
    /// Program.
    pub const PROGRAM: u16 = 0x68;
    /// Symbol: the tags.
    pub const SYMBOL: u16 = 0x6B;
    /// Template: the structures.
    pub const TEMPLATE: u16 = 0x6C;
    /// Wall clock time.
    pub const WALL_CLOCK: u16 = 0x8B;
    /// Change counters of the tag table.
    pub const CHANGE_DETECTION: u16 = 0xAC;
    /// Port.
    pub const PORT: u16 = 0xF4;
    /// TCP/IP interface.
    pub const TCP_IP: u16 = 0xF5;
    /// Ethernet link.
    pub const ETHERNET_LINK: u16 = 0xF6;
}

/// Service codes (CIP Vol. 1, appendix A; the class-specific ones of spec/ethernet-ip.md §7, §9, §10).
pub mod service {
    /// Get Attributes All.
    pub const GET_ATTRIBUTES_ALL: u8 = 0x01;
    /// Set Attributes All.
    pub const SET_ATTRIBUTES_ALL: u8 = 0x02;
    /// Get Attribute List.
    pub const GET_ATTRIBUTE_LIST: u8 = 0x03;
    /// Set Attribute List.
    pub const SET_ATTRIBUTE_LIST: u8 = 0x04;
    /// Reset.
    pub const RESET: u8 = 0x05;
    /// Create.
    pub const CREATE: u8 = 0x08;
    /// Delete.
    pub const DELETE: u8 = 0x09;
    /// Multiple Service Packet.
    pub const MULTIPLE_SERVICE_PACKET: u8 = 0x0A;
    /// Get Attribute Single.
    pub const GET_ATTRIBUTE_SINGLE: u8 = 0x0E;
    /// Set Attribute Single.
    pub const SET_ATTRIBUTE_SINGLE: u8 = 0x10;
    /// Read Tag; on class 0x6C: read a template's definition.
    pub const READ_TAG: u8 = 0x4C;
    /// Write Tag.
    pub const WRITE_TAG: u8 = 0x4D;
    /// Read-Modify-Write Tag; on class 6: Forward Close.
    pub const READ_MODIFY_WRITE_TAG: u8 = 0x4E;
    /// Read Tag Fragmented; on class 6: Unconnected Send.
    pub const READ_TAG_FRAGMENTED: u8 = 0x52;
    /// Write Tag Fragmented.
    pub const WRITE_TAG_FRAGMENTED: u8 = 0x53;
    /// Get Instance Attribute List.
    pub const GET_INSTANCE_ATTRIBUTE_LIST: u8 = 0x55;
    /// Forward Close, on class 6.
    pub const FORWARD_CLOSE: u8 = 0x4E;
    /// Unconnected Send, on class 6.
    pub const UNCONNECTED_SEND: u8 = 0x52;
    /// Forward Open, on class 6.
    pub const FORWARD_OPEN: u8 = 0x54;
    /// Large Forward Open, on class 6.
    pub const LARGE_FORWARD_OPEN: u8 = 0x5B;
    /// Set in the service code of a reply.
    pub const REPLY: u8 = 0x80;
}
