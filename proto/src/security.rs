//! The security of a device as it announces it (CIP Vol. 8, as Wireshark's `packet-enip.c` and OpENer's branch `CIPSecurity_develop` have it;
//! spec/security.md §2, §4).

use crate::wire::Reader;

/// The profile EtherNet/IP Confidentiality, among security profiles.
pub const CONFIDENTIALITY: u16 = 0x0002;

/// State 0 of the CIP Security object and the EtherNet/IP Security object: factory default.
pub const FACTORY_DEFAULT: u8 = 0;
/// State 2 of both: configured.
pub const CONFIGURED: u8 = 2;

/// The ports that are open, as bits (Vol. 8, 3-5.3.1).
pub mod port {
    /// 44818/tcp.
    pub const EXPLICIT_TCP: u8 = 1;
    /// 44818/udp.
    pub const EXPLICIT_UDP: u8 = 1 << 1;
    /// 2222/udp.
    pub const IMPLICIT_UDP: u8 = 1 << 2;
    /// 2221/tcp.
    pub const TLS: u8 = 1 << 3;
    /// 2221/udp.
    pub const DTLS: u8 = 1 << 4;
}

/// The item CIP Security Information (0x0086) of a ListIdentity reply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SecurityInformation {
    /// The security profiles that the device has.
    pub profiles: u16,
    /// The state of its CIP Security object.
    pub state: u8,
    /// The state of its EtherNet/IP Security object.
    pub ethernet_ip_state: u8,
    /// Its open ports, see [`port`].
    pub ports: u8,
    /// The security profiles that are in use.
    pub profiles_configured: u16,
}

impl SecurityInformation {
    /// Length of the item's data.
    pub const LEN: usize = 7;

    /// The item's data.
    pub fn encode(self) -> [u8; Self::LEN] {
        let [profiles, configured] = [self.profiles, self.profiles_configured].map(u16::to_le_bytes);
        [
            profiles[0],
            profiles[1],
            self.state,
            self.ethernet_ip_state,
            self.ports,
            configured[0],
            configured[1],
        ]
    }

    /// Reads the item's data; older devices send 5 bytes, without the profiles in use. `None` if it is cut.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        Some(Self {
            profiles: reader.u16()?,
            state: reader.u8()?,
            ethernet_ip_state: reader.u8()?,
            ports: reader.u8()?,
            profiles_configured: if data.len() >= Self::LEN { reader.u16()? } else { 0 },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_item_reads_back() {
        let hardened = SecurityInformation {
            profiles: CONFIDENTIALITY,
            state: CONFIGURED,
            ethernet_ip_state: CONFIGURED,
            ports: port::EXPLICIT_UDP | port::TLS,
            profiles_configured: CONFIDENTIALITY,
        };
        // Profiles, both states, ports 0A, profiles in use.
        let bytes = [0x02, 0x00, 0x02, 0x02, 0x0A, 0x02, 0x00];
        assert_eq!(hardened.encode(), bytes);
        assert_eq!(SecurityInformation::decode(&bytes), Some(hardened));
        let older = SecurityInformation {
            profiles_configured: 0,
            ..hardened
        };
        assert_eq!(SecurityInformation::decode(&bytes[..5]), Some(older), "of 5 bytes");
        for end in 0..5 {
            assert_eq!(SecurityInformation::decode(&bytes[..end]), None, "cut at {end}");
        }
    }
}
