//! TCP/IP Interface, class 0xF5 (CIP Vol. 2, 5-4): where the device is reached, as the host's system has it. Only the
//! inactivity time-out can be set: the host's network is not ours.

use std::time::Duration;

use arcline_config::{PlainAccess, ServerConfig};
use arcline_proto::cip::{CipStatus, class};
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Extent, Object, ObjectContext};
use super::values::{long_string, no_attribute, short_string, u8_value, u16_value, u32_value};
use crate::eip::adapter::Adapter;
use crate::plant::Right;

/// Status: the configuration is valid, by other means than this object.
const CONFIGURED: u32 = 2;
/// Encapsulation inactivity time-out, s, can be set.
const INACTIVITY: u16 = 13;
/// The ports of EtherNet/IP, and which of them are open.
const PORT_ADMIN: u16 = 14;
/// The longest of it, s.
const MAX_INACTIVITY: u16 = 3600;
/// Attribute 11: no address conflict has been seen.
const NO_CONFLICT: [u8; 35] = [0; 35];
/// Addresses from the first one on (CIP Vol. 2, 3-5.3).
const MULTICAST_COUNT: u16 = 32;

#[derive(Debug)]
pub(super) struct TcpIpInterface;

impl Object for TcpIpInterface {
    fn class(&self) -> u16 {
        class::TCP_IP
    }

    fn name(&self) -> &'static str {
        "TCP/IP Interface"
    }

    fn is_late(&self) -> bool {
        true
    }

    fn revision(&self) -> u16 {
        4
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, PORT_ADMIN)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u32_value(CONFIGURED),
            // A client can configure none of it; the system has set the addresses.
            2 | 3 => u32_value(0),
            // The Ethernet Link object: two words, class 0xF6, instance 1.
            4 => Ok(Bytes::from_static(&[2, 0, 0x20, 0xF6, 0x24, 1])),
            5 => Ok(configuration(&cx.context.adapter())),
            6 => Ok(padded_string(&cx.context.adapter().host_name)),
            8 => u8_value(1),
            9 => Ok(multicast(&cx.context.adapter())),
            10 => u8_value(0),
            11 => Ok(Bytes::from_static(&NO_CONFLICT)),
            INACTIVITY => {
                let seconds = cx.device().inactivity().map_or(0, |time| time.as_secs());
                u16_value(u16::try_from(seconds).unwrap_or(u16::MAX))
            }
            PORT_ADMIN => Ok(ports(
                &cx.device().settings.config,
                cx.device().io().map(|io| io.local().port()),
            )),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6]
    }

    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Option<usize> {
        (id == INACTIVITY).then_some(2)
    }

    fn right_to_set(&self) -> Right {
        Right::SetInactivity
    }

    /// Seconds, 0: never.
    fn set(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let seconds = value.first_chunk().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let seconds = u16::from_le_bytes(*seconds);
        if seconds > MAX_INACTIVITY {
            return Err(CipStatus::INVALID_ATTRIBUTE_VALUE);
        }
        cx.device().set_inactivity(Duration::from_secs(seconds.into()));
        Ok(())
    }
}

/// The ports that the standard names: `count u8`, then each port's name, number, protocol, whether it is open, and no capability: the configuration
/// alone opens and closes them (spec/security.md §4).
fn ports(server: &ServerConfig, io: Option<u16>) -> Bytes {
    let security = &server.security;
    let tls = security.tls.map_or(TLS, |address| address.port());
    let explicit = server.listen.port();
    let rows = [
        ("EtherNet/IP TCP", explicit, TCP, security.plain != PlainAccess::Off),
        ("EtherNet/IP UDP", explicit, UDP, true),
        ("EtherNet/IP I/O", io.unwrap_or(IO), UDP, io.is_some()),
        ("EtherNet/IP TLS", tls, TCP, security.tls.is_some()),
    ];
    let mut out = BytesMut::new();
    out.put_u8(rows.len() as u8);
    for (name, port, protocol, is_open) in rows {
        out.put_slice(&short_string(name));
        out.put_u16_le(port);
        out.put_slice(&[protocol, is_open.into(), 0]);
    }
    out.freeze()
}

/// Protocols of IANA.
const TCP: u8 = 6;
const UDP: u8 = 17;
/// The ports of implicit I/O and of TLS where the configuration has none.
const IO: u16 = 2222;
const TLS: u16 = 2221;

/// Address, mask, gateway and name servers as little-endian numbers; no domain.
fn configuration(adapter: &Adapter) -> Bytes {
    let mut out = BytesMut::with_capacity(22);
    let [first, second] = adapter.name_servers;
    for address in [adapter.address, adapter.mask, adapter.gateway, first, second] {
        out.put_u32_le(address.to_bits());
    }
    out.put_u16_le(0);
    out.freeze()
}

/// The multicast address by the default algorithm: `alloc u8, 0, count u16, first address u32`.
fn multicast(adapter: &Adapter) -> Bytes {
    let mut out = BytesMut::with_capacity(8);
    out.put_slice(&[0, 0]);
    out.put_u16_le(MULTICAST_COUNT);
    out.put_u32_le(adapter.first_multicast().to_bits());
    out.freeze()
}

/// `length u16, bytes`, a zero behind an odd number of them.
fn padded_string(text: &str) -> Bytes {
    let mut out = BytesMut::from(long_string(text).as_ref());
    if out.len() % 2 == 1 {
        out.put_u8(0);
    }
    out.freeze()
}

#[cfg(test)]
mod tests {
    use arcline_config::Security;

    use super::*;

    /// Protocol 6 is TCP, 17 UDP; then whether the port is open.
    #[test]
    fn each_port_is_open_as_the_configuration_says() {
        let tls = Some(([127, 0, 0, 1], 2221).into());
        #[rustfmt::skip]
        let cases = [
            ("the default",    PlainAccess::On,        None, Some(2222),   [1, 1, 1, 0]),
            ("without I/O",    PlainAccess::On,        None, None,         [1, 1, 0, 0]),
            ("beside TLS",     PlainAccess::On,        tls,  Some(50_000), [1, 1, 1, 1]),
            ("discovery only", PlainAccess::Discovery, tls,  None,         [1, 1, 0, 1]),
            ("hardened",       PlainAccess::Off,       tls,  None,         [0, 1, 0, 1]),
        ];
        for (why, plain, tls, io, open) in cases {
            let server = ServerConfig {
                security: Security {
                    plain,
                    tls,
                    ..Security::default()
                },
                ..ServerConfig::default()
            };
            let rows = [
                (b"EtherNet/IP TCP", 44818, 6),
                (b"EtherNet/IP UDP", 44818, 17),
                (b"EtherNet/IP I/O", io.unwrap_or(2222), 17),
                (b"EtherNet/IP TLS", 2221, 6),
            ];
            let mut expected = vec![4];
            for ((name, port, protocol), open) in rows.into_iter().zip(open) {
                expected.push(15);
                expected.extend_from_slice(name);
                expected.extend_from_slice(&u16::to_le_bytes(port));
                expected.extend_from_slice(&[protocol, open, 0]);
            }
            assert_eq!(ports(&server, io)[..], expected, "{why}");
        }
    }
}
