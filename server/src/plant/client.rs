//! The identity of a client: its address, and the identification that it has sent.

use std::fmt;
use std::net::IpAddr;

use arcline_proto::arcline::machine::Identification;

/// A client as far as it is known.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ClientIdentity {
    /// Its address; of a viewer of the page with its number.
    pub address: String,
    /// Its IP address, if it has one.
    pub ip: Option<IpAddr>,
    /// The identification that the client has sent; its product also as its connections or its browser show it.
    pub identification: Identification,
}

impl ClientIdentity {
    /// An identity of which only the address is known, with the name that the client has shown.
    pub fn of_address(address: &str, ip: Option<IpAddr>) -> Self {
        ClientIdentity {
            address: address.to_owned(),
            ip,
            identification: Identification::default(),
        }
    }
}

impl fmt::Display for ClientIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.address, self.identification)
    }
}
