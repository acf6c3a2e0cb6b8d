//! The product of a client, as the vendor id and the serial number of its connections show it.

use arcline_proto::connection::ConnectionKey;
use arcline_proto::identity::VENDOR_ID;

/// Client libraries that always open connections with the same vendor id, and those that have one serial number too.
#[rustfmt::skip]
const PRODUCTS: [(u16, Option<u32>, &str); 5] = [
    (VENDOR_ID, None,              "Arcline client library"),
    (0x1009,    None,              "pycomm3"),
    (0x1337,    Some(42),          "pylogix"),
    (0x3333,    Some(0x1337),      "st-ethernet-ip"),
    (0xF33D,    Some(0x2150_4345), "libplctag"),
];

/// The product that opened a connection, or else its vendor id and serial number.
pub(super) fn product(key: ConnectionKey) -> String {
    let known = PRODUCTS
        .iter()
        .find(|(vendor, serial, _)| *vendor == key.vendor && serial.is_none_or(|serial| serial == key.originator));
    match known {
        Some((_, _, name)) => (*name).to_owned(),
        None => format!("vendor 0x{:04X}, serial 0x{:08X}", key.vendor, key.originator),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn originators_are_named_where_they_are_known() {
        #[rustfmt::skip]
        let cases = [
            ("any serial number",     0x1009, 5,           "pycomm3"),
            ("its serial number",     0xF33D, 0x2150_4345, "libplctag"),
            ("another serial number", 0xF33D, 5,           "vendor 0xF33D, serial 0x00000005"),
            ("not known",             0x0001, 0xC0FF_EE00, "vendor 0x0001, serial 0xC0FFEE00"),
        ];
        for (why, vendor, originator, expected) in cases {
            let key = ConnectionKey {
                serial: 1,
                vendor,
                originator,
            };
            assert_eq!(product(key), expected, "{why}");
        }
    }
}
