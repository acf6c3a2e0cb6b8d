//! The parts of a client's certificate that the server reads after rustls has verified it: subject, issuer, end, and the hash of its key
//! (RFC 5280, 4.1).
//!
//! This module does not decide whether a certificate is valid.

use std::net::IpAddr;

use ring::digest::{SHA256, digest};
use time::{Date, Month, Time};

/// A certificate, as roles are given by it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Leaf {
    /// The Common Name of the subject; empty: it has none.
    pub(crate) cn: String,
    /// The issuer, such as `CN=Plant CA,O=Plant`.
    pub(crate) issuer: String,
    /// SHA-256 over the SubjectPublicKeyInfo, hexadecimal.
    pub(crate) sha256: String,
    /// The serial number, hexadecimal.
    pub(crate) serial: String,
    /// The first and the last second of its validity, Unix time.
    pub(crate) valid: (i64, i64),
    /// The host names and addresses that it is for (Subject Alternative Name).
    pub(crate) names: Vec<String>,
}

impl Leaf {
    /// Reads a certificate; `None`: it is not one.
    pub(crate) fn read(der: &[u8]) -> Option<Self> {
        let mut certificate = Der(der).enter(SEQUENCE)?;
        let mut body = certificate.enter(SEQUENCE)?;
        if body.peek() == Some(VERSION) {
            body.next()?;
        }
        let serial = body.take(INTEGER)?;
        body.take(SEQUENCE)?;
        let issuer = name(body.take(SEQUENCE)?.body)?;
        let mut validity = body.enter(SEQUENCE)?;
        let valid = (moment(validity.next()?)?, moment(validity.next()?)?);
        let subject = name(body.take(SEQUENCE)?.body)?;
        let key = body.take(SEQUENCE)?;
        let extensions = std::iter::from_fn(|| body.next()).find(|field| field.tag == EXTENSIONS);
        let names = match extensions {
            Some(extensions) => alternative_names(extensions.body)?,
            None => Vec::new(),
        };
        let cn = subject.iter().rev().find(|(kind, _)| *kind == "CN");
        Some(Self {
            cn: cn.map(|(_, text)| text.clone()).unwrap_or_default(),
            issuer: text_of(&issuer),
            sha256: hex(digest(&SHA256, key.whole).as_ref()),
            serial: hex(serial.body),
            valid,
            names,
        })
    }
}

/// The second at which a list of revoked certificates is to have been followed by another one, Unix time (RFC 5280, 5.1); `None`: it does not say.
pub(crate) fn next_list(der: &[u8]) -> Option<i64> {
    let mut list = Der(der).enter(SEQUENCE)?;
    let mut body = list.enter(SEQUENCE)?;
    if body.peek() == Some(INTEGER) {
        body.next()?;
    }
    // The algorithm and the issuer.
    body.take(SEQUENCE)?;
    body.take(SEQUENCE)?;
    moment(body.next()?)?;
    moment(body.next()?)
}

/// The host names and addresses of a certificate's extensions (RFC 5280, 4.2.1.6).
fn alternative_names(extensions: &[u8]) -> Option<Vec<String>> {
    let mut extensions = Der(extensions).enter(SEQUENCE)?;
    let mut names = Vec::new();
    while extensions.peek().is_some() {
        let mut extension = extensions.enter(SEQUENCE)?;
        if extension.take(OBJECT)?.body != ALTERNATIVE_NAME {
            continue;
        }
        // Perhaps whether it is critical, then the names in an OCTET STRING.
        let value = std::iter::from_fn(|| extension.next()).find(|field| field.tag == OCTETS)?;
        let mut all = Der(value.body).enter(SEQUENCE)?;
        while let Some(name) = all.next() {
            match name.tag {
                DNS_NAME => names.push(String::from_utf8_lossy(name.body).into_owned()),
                ADDRESS => names.extend(address(name.body)),
                _ => {}
            }
        }
    }
    Some(names)
}

fn address(bytes: &[u8]) -> Option<String> {
    let v4 = <[u8; 4]>::try_from(bytes).map(IpAddr::from);
    let address = v4.or_else(|_| <[u8; 16]>::try_from(bytes).map(IpAddr::from));
    address.ok().map(|address| address.to_string())
}

/// Bytes as hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The parts of a name, in their order.
type Name = Vec<(&'static str, String)>;

fn text_of(name: &Name) -> String {
    let parts: Vec<String> = name.iter().map(|(kind, text)| format!("{kind}={text}")).collect();
    parts.join(",")
}

fn name(body: &[u8]) -> Option<Name> {
    let mut sets = Der(body);
    let mut parts = Vec::new();
    while sets.peek().is_some() {
        let mut set = sets.enter(SET)?;
        while set.peek().is_some() {
            let mut part = set.enter(SEQUENCE)?;
            let kind = part.take(OBJECT)?.body;
            let value = part.next()?;
            let known = KINDS.iter().find(|(oid, _)| *oid == kind);
            let text = match value.tag {
                // BMPString.
                0x1E => String::from_utf16_lossy(
                    &value
                        .body
                        .chunks_exact(2)
                        .map(|two| u16::from_be_bytes([two[0], two[1]]))
                        .collect::<Vec<_>>(),
                ),
                _ => String::from_utf8_lossy(value.body).into_owned(),
            };
            parts.push((known.map_or("OID", |(_, word)| *word), text));
        }
    }
    Some(parts)
}

/// UTCTime `YYMMDDhhmmssZ` or GeneralizedTime `YYYYMMDDhhmmssZ`.
fn moment(value: Tlv<'_>) -> Option<i64> {
    let text = std::str::from_utf8(value.body).ok()?.strip_suffix('Z')?;
    let (year, rest) = match value.tag {
        0x17 => {
            let year: i32 = text.get(..2)?.parse().ok()?;
            (if year < 50 { 2000 + year } else { 1900 + year }, text.get(2..)?)
        }
        0x18 => (text.get(..4)?.parse().ok()?, text.get(4..)?),
        _ => return None,
    };
    let part = |at: usize| rest.get(at..at + 2)?.parse::<u8>().ok();
    let date = Date::from_calendar_date(year, Month::try_from(part(0)?).ok()?, part(2)?).ok()?;
    let time = Time::from_hms(part(4)?, part(6)?, part(8)?).ok()?;
    Some(date.with_time(time).assume_utc().unix_timestamp())
}

/// A reader of DER values, one behind the other.
struct Der<'d>(&'d [u8]);

#[derive(Clone, Copy)]
struct Tlv<'d> {
    tag: u8,
    body: &'d [u8],
    whole: &'d [u8],
}

impl<'d> Der<'d> {
    fn peek(&self) -> Option<u8> {
        self.0.first().copied()
    }

    fn next(&mut self) -> Option<Tlv<'d>> {
        let all = self.0;
        let (tag, rest) = all.split_first()?;
        let (first, rest) = rest.split_first()?;
        let (length, rest) = match *first {
            short @ 0..=0x7F => (usize::from(short), rest),
            0x81..=0x83 => {
                let (length, rest) = rest.split_at_checked(usize::from(first & 0x7F))?;
                (length.iter().fold(0, |sum, byte| sum << 8 | usize::from(*byte)), rest)
            }
            _ => return None,
        };
        let (body, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        let whole = all.get(..all.len() - rest.len())?;
        Some(Tlv { tag: *tag, body, whole })
    }

    fn take(&mut self, tag: u8) -> Option<Tlv<'d>> {
        self.next().filter(|value| value.tag == tag)
    }

    fn enter(&mut self, tag: u8) -> Option<Der<'d>> {
        self.take(tag).map(|value| Der(value.body))
    }
}

const INTEGER: u8 = 0x02;
const OCTETS: u8 = 0x04;
const OBJECT: u8 = 0x06;
const SEQUENCE: u8 = 0x30;
const SET: u8 = 0x31;
const VERSION: u8 = 0xA0;
const EXTENSIONS: u8 = 0xA3;
const DNS_NAME: u8 = 0x82;
const ADDRESS: u8 = 0x87;
/// 2.5.29.17.
const ALTERNATIVE_NAME: [u8; 3] = [0x55, 29, 17];

/// Parts of names (RFC 4519).
const KINDS: [(&[u8], &str); 6] = [
    (&[0x55, 4, 3], "CN"),
    (&[0x55, 4, 6], "C"),
    (&[0x55, 4, 7], "L"),
    (&[0x55, 4, 8], "ST"),
    (&[0x55, 4, 10], "O"),
    (&[0x55, 4, 11], "OU"),
];

#[cfg(test)]
mod tests {
    use rcgen::{CertificateParams, DnType, KeyPair, SerialNumber, date_time_ymd};

    use super::*;

    #[test]
    fn a_certificate_is_read() {
        let key = KeyPair::generate().expect("a key");
        let names = ["cell-4.example", "10.1.2.3", "::1"].map(str::to_owned);
        let mut params = CertificateParams::new(names).expect("names");
        params.distinguished_name.push(DnType::CommonName, "line3-hmi");
        params.distinguished_name.push(DnType::OrganizationName, "Plant ü");
        params.serial_number = Some(SerialNumber::from_slice(&[0x12, 0xAB]));
        (params.not_before, params.not_after) = (date_time_ymd(2020, 1, 1), date_time_ymd(2051, 1, 1));
        let der = params.self_signed(&key).expect("signed").der().to_vec();
        let leaf = Leaf::read(&der).expect("it is one");
        assert_eq!(leaf.cn, "line3-hmi");
        assert_eq!(leaf.issuer, "CN=line3-hmi,O=Plant ü");
        assert_eq!(leaf.serial, "12ab");
        assert_eq!(leaf.names, ["cell-4.example", "10.1.2.3", "::1"]);
        assert_eq!(leaf.valid, (1_577_836_800, 2_556_144_000));
        assert_eq!(
            leaf.sha256,
            hex(digest(&SHA256, &rcgen::PublicKeyData::subject_public_key_info(&key)).as_ref())
        );
        assert_eq!(next_list(&der), None, "it is no list");
        for end in 0..der.len() {
            assert_eq!(Leaf::read(&der[..end]), None, "cut at {end}");
        }
        for at in 0..der.len() {
            let mut other = der.clone();
            other[at] ^= 0xFF;
            // No bytes cause a panic.
            let _ = Leaf::read(&other);
        }
    }
}
