//! The security objects, to be read: CIP Security (0x5D), EtherNet/IP Security (0x5E), Certificate Management (0x5F)
//! (spec/security.md §4). A commissioning tool sees that TLS is on; the files of `[security]` are changed on the server's computer only, so
//! each service that would change an attribute is refused to every role, with 0x0F.

use arcline_proto::cip::{CipStatus, Reply, class, service};
use arcline_proto::security::{CONFIDENTIALITY, CONFIGURED, FACTORY_DEFAULT};
use bytes::{BufMut, Bytes, BytesMut};

use super::object::{Access, Extent, Object, ObjectContext, On, OwnService};
use super::values::{no_attribute, short_string, u8_value, u16_value, u32_value};
use crate::plant::Right;

/// The suites that are offered, in the order of the offer, as IANA numbers them: their two bytes stand in this order.
const SUITES: [[u8; 2]; 9] = [
    [0x13, 0x02],
    [0x13, 0x01],
    [0x13, 0x03],
    [0xC0, 0x2C],
    [0xC0, 0x2B],
    [0xCC, 0xA9],
    [0xC0, 0x30],
    [0xC0, 0x2F],
    [0xCC, 0xA8],
];
/// The instance of the certificate of `[security]`.
const IN_USE: u8 = 2;
/// A list without entries, and a path without words.
const NONE: u8 = 0;
/// The status of the pull model, which is not there.
const NO_PULL: u16 = 0xFFFF;
/// The time-out of DTLS, which is not there, at its default, s.
const DTLS_TIMEOUT: u16 = 12;
/// States of a certificate: none, verified.
const NON_EXISTENT: u8 = 0;
const VERIFIED: u8 = 3;
/// Encodings of certificates: PEM, as a number and as a bit.
const PEM: u8 = 0;
const PEM_BIT: u32 = 1;

/// A service that every role is refused. The audit records the clients that requested it without the right.
const fn refused(code: u8, name: &'static str, on: On) -> OwnService {
    OwnService {
        code,
        name,
        on,
        access: Access::Read,
        right: Right::Administer,
    }
}

/// The answer of every service of this file.
fn refuse() -> Result<Reply, CipStatus> {
    Err(CipStatus::PRIVILEGE_VIOLATION)
}

fn has_tls(cx: &ObjectContext<'_, '_>) -> bool {
    cx.device().settings.config.security.tls.is_some()
}

fn state(cx: &ObjectContext<'_, '_>) -> u8 {
    if has_tls(cx) { CONFIGURED } else { FACTORY_DEFAULT }
}

#[derive(Debug)]
pub(super) struct CipSecurity;

impl Object for CipSecurity {
    fn class(&self) -> u16 {
        class::CIP_SECURITY
    }

    fn name(&self) -> &'static str {
        "CIP Security"
    }

    fn revision(&self) -> u16 {
        3
    }

    fn services(&self) -> &'static [OwnService] {
        const SERVICES: [OwnService; 5] = [
            refused(service::RESET, "Reset", On::Instance),
            refused(0x4B, "Begin Config", On::Instance),
            refused(0x4C, "Kick Timer", On::Instance),
            refused(0x4D, "End Config", On::Instance),
            refused(0x4E, "Object Cleanup", On::Class),
        ];
        &SERVICES
    }

    fn serve(&self, _cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        refuse()
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 3)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u8_value(state(cx)),
            2 => u16_value(CONFIDENTIALITY),
            3 => u16_value(if has_tls(cx) { CONFIDENTIALITY } else { 0 }),
            _ => no_attribute(),
        }
    }

    /// Attribute 3 is left out, as in OpENer.
    fn all(&self) -> &'static [u16] {
        &[1, 2]
    }
}

#[derive(Debug)]
pub(super) struct EthernetIpSecurity;

impl Object for EthernetIpSecurity {
    fn class(&self) -> u16 {
        class::ETHERNET_IP_SECURITY
    }

    fn name(&self) -> &'static str {
        "EtherNet/IP Security"
    }

    fn revision(&self) -> u16 {
        7
    }

    fn services(&self) -> &'static [OwnService] {
        const SERVICES: [OwnService; 5] = [
            refused(service::RESET, "Reset", On::Instance),
            refused(0x4B, "Begin Config", On::Instance),
            refused(0x4C, "Kick Timer", On::Instance),
            refused(0x4D, "Apply Config", On::Instance),
            refused(0x4E, "Abort Config", On::Instance),
        ];
        &SERVICES
    }

    fn serve(&self, _cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        refuse()
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, 16)
    }

    /// 8, 9: pre-shared keys, of which there are none.
    fn class_attribute(&self, _cx: &ObjectContext<'_, '_>, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            8 => u16_value(0),
            9 => u8_value(0),
            _ => no_attribute(),
        }
    }

    fn last_class_attribute(&self) -> u16 {
        9
    }

    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 6, 7, 8, 9]
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            1 => u8_value(state(cx)),
            // No secure renegotiation: there is no renegotiation.
            2 => u32_value(0),
            3 | 4 => Ok(suites()),
            // Pre-shared keys.
            5 => u8_value(NONE),
            6 if has_tls(cx) => Ok([&[1], certificate(IN_USE).as_slice()].concat().into()),
            // Certificates in use; authorities and revoked certificates, which are no objects; trusted identities.
            6 | 7 | 8 | 12 => u8_value(NONE),
            // The client's certificate is verified, the chain is sent.
            9 | 10 => u8_value(1),
            11 => u8_value(cx.device().settings.config.security.check_expiration.into()),
            // The pull model is not there.
            13 => u8_value(0),
            14 => u16_value(NO_PULL),
            15 => u16_value(DTLS_TIMEOUT),
            16 => u8_value(0),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]
    }
}

fn suites() -> Bytes {
    let mut out = BytesMut::with_capacity(1 + 2 * SUITES.len());
    // Nine of them.
    out.put_u8(SUITES.len() as u8);
    out.put_slice(SUITES.as_flattened());
    out.freeze()
}

/// A path of two words to a certificate: class 0x5F and its instance.
fn certificate(instance: u8) -> [u8; 5] {
    [2, 0x20, 0x5F, 0x24, instance]
}

/// The number of certificates: instance 1, the factory's, which is empty, and instance 2, that of `[security]`.
fn certificates(cx: &ObjectContext<'_, '_>) -> u8 {
    if has_tls(cx) { IN_USE } else { 1 }
}

#[derive(Debug)]
pub(super) struct CertificateManagement;

/// The names of the instances.
const NAMES: [&str; 2] = ["Default Device Certificate", "Configured"];

impl Object for CertificateManagement {
    fn class(&self) -> u16 {
        class::CERTIFICATE_MANAGEMENT
    }

    fn name(&self) -> &'static str {
        "Certificate Management"
    }

    fn revision(&self) -> u16 {
        2
    }

    fn services(&self) -> &'static [OwnService] {
        const SERVICES: [OwnService; 4] = [
            refused(service::CREATE, "Create", On::Class),
            refused(service::DELETE, "Delete", On::Instance),
            refused(0x4B, "Create CSR", On::Instance),
            refused(0x4C, "Verify Certificate", On::Instance),
        ];
        &SERVICES
    }

    fn serve(&self, _cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        refuse()
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(certificates(cx).into(), 5)
    }

    /// 8: neither push nor pull; 9: name and path of each certificate; 10: PEM.
    fn class_attribute(&self, cx: &ObjectContext<'_, '_>, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            8 => u32_value(0),
            9 => {
                let count = certificates(cx);
                let mut out = BytesMut::new();
                out.put_u8(count);
                for (name, instance) in NAMES.iter().zip(1..=count) {
                    out.put_slice(&short_string(name));
                    out.put_slice(&certificate(instance));
                }
                Ok(out.freeze())
            }
            10 => u32_value(PEM_BIT),
            _ => no_attribute(),
        }
    }

    fn last_class_attribute(&self) -> u16 {
        10
    }

    fn class_all(&self) -> &'static [u16] {
        &[1, 2, 3, 6, 7, 8, 9, 10]
    }

    fn attribute(&self, _cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let is_configured = instance == u32::from(IN_USE);
        match id {
            1 => Ok(short_string(NAMES[usize::from(is_configured)])),
            2 => u8_value(if is_configured { VERIFIED } else { NON_EXISTENT }),
            // The certificate and that of its authority: whether each is verified, and no path, since no File object holds them.
            3 | 4 => Ok(Bytes::copy_from_slice(&[is_configured.into(), NONE])),
            5 => u8_value(PEM),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[1, 2, 3, 4, 5]
    }
}
