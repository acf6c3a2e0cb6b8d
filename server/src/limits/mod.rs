//! Limits by the address of a peer: places, rates, and lines of the log. None of them is for a stop.

mod lockouts;
mod log_limit;
mod places;
mod rate;

use std::net::{IpAddr, Ipv6Addr};

pub(crate) use lockouts::Lockouts;
pub(crate) use log_limit::LogLimit;
pub(crate) use places::{Full, Place, Places};
pub(crate) use rate::{AddressRate, Rate};

/// The address by which limits count a peer: IPv4 as it is, also inside of IPv6; of IPv6 the network of 64 bits, since one host has
/// all of its addresses.
pub(crate) fn counted(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) if !v6.is_loopback() => {
            let [a, b, c, d, ..] = v6.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_counted_by_host() {
        #[rustfmt::skip]
        let cases = [
            ("IPv4",                 "10.0.0.7",             "10.0.0.7"),
            ("IPv4 inside of IPv6",  "::ffff:10.0.0.7",      "10.0.0.7"),
            ("one host of a /64",    "2001:db8:1:2:3:4:5:6", "2001:db8:1:2::"),
            ("another address of it","2001:db8:1:2::1",      "2001:db8:1:2::"),
            ("IPv6 loopback",        "::1",                  "::1"),
        ];
        for (why, address, expected) in cases {
            let address: IpAddr = address.parse().expect("an address");
            assert_eq!(counted(address).to_string(), expected, "{why}");
        }
    }
}
