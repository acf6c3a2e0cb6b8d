//! What is known of a client: its address, and what it has told of itself.

use std::fmt;
use std::net::{IpAddr, SocketAddr};

use arcline_proto::arcline::machine::Identification;

/// A client as far as it is known.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ClientIdentity {
    /// Its address; of a viewer of the page with its number.
    pub address: String,
    /// What it has told of itself; its product also as its connections or its browser show it.
    pub told: Identification,
}

impl ClientIdentity {
    /// The IP address.
    pub(crate) fn ip(&self) -> Option<IpAddr> {
        let address = self.address.split(' ').next().unwrap_or_default();
        let socket = address.parse::<SocketAddr>().map(|socket| socket.ip());
        socket.or_else(|_| address.parse()).ok()
    }

    /// A client of which only the address is known.
    pub fn of_address(address: &str) -> Self {
        ClientIdentity {
            address: address.to_owned(),
            told: Identification::default(),
        }
    }
}

impl fmt::Display for ClientIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.address, self.told)
    }
}
