//! What the host's own adapter shows: the interface that an address belongs to, its mask, gateway, name servers, speed
//! and counters, as the system tells them in its files.
//!
//! Only read, never set: the host's network is not ours. What the system does not tell is 0 or empty. Addresses are
//! numbers, their first byte the highest.

use std::fs;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};

/// The adapter that has an address.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Adapter {
    /// Where the system's files are: `/`, or what a test has put together.
    root: PathBuf,
    /// The interface, such as `eth0`; empty: not known.
    pub(crate) name: String,
    /// The address.
    pub(crate) address: Ipv4Addr,
    /// Its network's mask; 0.0.0.0: not known.
    pub(crate) mask: Ipv4Addr,
}

/// The counters of an interface, in the order of Ethernet Link's attribute 4 (CIP Vol. 2, 5-5). Empty: there is none.
const INTERFACE_COUNTERS: [&str; 11] = [
    "rx_bytes",
    "rx_packets",
    "multicast",
    "rx_dropped",
    "rx_errors",
    "rx_nohandler",
    "tx_bytes",
    "tx_packets",
    "",
    "tx_dropped",
    "tx_errors",
];

/// The counters of a medium, in the order of attribute 5.
const MEDIA_COUNTERS: [&str; 12] = [
    "rx_frame_errors",
    "rx_crc_errors",
    "collisions",
    "",
    "tx_heartbeat_errors",
    "",
    "tx_window_errors",
    "tx_aborted_errors",
    "tx_fifo_errors",
    "tx_carrier_errors",
    "rx_length_errors",
    "rx_fifo_errors",
];

/// Longest file that is looked at, bytes.
const MAX_FILE: usize = 64 * 1024;

impl Adapter {
    /// The adapter of a local address, by the routing table.
    pub(crate) fn of(root: &Path, address: Ipv4Addr) -> Self {
        let mut this = Self {
            root: root.to_owned(),
            name: String::new(),
            address,
            mask: Ipv4Addr::UNSPECIFIED,
        };
        if address.is_loopback() {
            // The routing table leaves it out.
            this.name = "lo".to_owned();
            this.mask = Ipv4Addr::new(255, 0, 0, 0);
            return this;
        }
        let own = |route: &Route| {
            !route.mask.is_unspecified() && address.to_bits() & route.mask.to_bits() == route.to.to_bits()
        };
        if let Some(route) = this.routes().into_iter().find(own) {
            this.name = route.interface;
            this.mask = route.mask;
        }
        this
    }

    /// The first of its multicast addresses: 239.192.1.0 + 32 × ((host part of the address & 0x3FF) − 1)
    /// (spec/ethernet-ip.md §14.2).
    pub(crate) fn first_multicast(&self) -> Ipv4Addr {
        let host = self.address.to_bits() & !self.mask.to_bits();
        let base = Ipv4Addr::new(239, 192, 1, 0).to_bits();
        Ipv4Addr::from_bits(base + 32 * (host & 0x3FF).saturating_sub(1))
    }

    /// The default gateway of this interface; 0.0.0.0: none.
    pub(crate) fn gateway(&self) -> Ipv4Addr {
        let default = |route: &Route| route.mask.is_unspecified() && route.interface == self.name;
        let found = self.routes().into_iter().find(default);
        found.map_or(Ipv4Addr::UNSPECIFIED, |route| route.gateway)
    }

    /// The first two name servers; 0.0.0.0: none.
    pub(crate) fn name_servers(&self) -> [Ipv4Addr; 2] {
        let mut servers = [Ipv4Addr::UNSPECIFIED; 2];
        let text = self.read("etc/resolv.conf");
        let found = text
            .lines()
            .filter_map(|line| line.strip_prefix("nameserver")?.trim().parse().ok());
        servers.iter_mut().zip(found).for_each(|(place, found)| *place = found);
        servers
    }

    /// The host's name, at most 64 bytes.
    pub(crate) fn host_name(&self) -> String {
        let text = self.read("proc/sys/kernel/hostname");
        text.trim().chars().filter(char::is_ascii_graphic).take(64).collect()
    }

    /// Mbit/s; 0: not known.
    pub(crate) fn speed(&self) -> u32 {
        self.interface("speed").trim().parse().unwrap_or(0)
    }

    /// Whether the link is up. A loopback interface says "unknown" and is up all the same.
    pub(crate) fn is_up(&self) -> bool {
        matches!(self.interface("operstate").trim(), "up" | "unknown")
    }

    /// Whether the duplex mode is half; full unless the system says otherwise.
    pub(crate) fn is_half_duplex(&self) -> bool {
        self.interface("duplex").trim() == "half"
    }

    /// Whether it is inside the host.
    pub(crate) fn is_internal(&self) -> bool {
        self.address.is_loopback()
    }

    /// The hardware address; zeros: not known.
    pub(crate) fn hardware_address(&self) -> [u8; 6] {
        let text = self.interface("address");
        let mut bytes = [0; 6];
        let mut parts = text.trim().split(':');
        for byte in &mut bytes {
            match parts.next().map(|part| u8::from_str_radix(part, 16)) {
                Some(Ok(value)) => *byte = value,
                _ => return [0; 6],
            }
        }
        bytes
    }

    /// In Octets, In Unicast, In Non-unicast, In Discards, In Errors, In Unknown Protocols, and the five of Out. They wrap.
    pub(crate) fn interface_counters(&self) -> [u32; 11] {
        let mut counters = INTERFACE_COUNTERS.map(|name| self.counter(name));
        // The system counts multicast packets among all.
        counters[1] = counters[1].wrapping_sub(counters[2]);
        counters
    }

    /// Alignment, FCS, single and multiple collisions, SQE, deferred, late and excessive collisions, MAC transmit, carrier
    /// sense, frame too long, MAC receive. They wrap.
    pub(crate) fn media_counters(&self) -> [u32; 12] {
        MEDIA_COUNTERS.map(|name| self.counter(name))
    }

    fn counter(&self, name: &str) -> u32 {
        if name.is_empty() {
            return 0;
        }
        let wide: u64 = self
            .interface(&format!("statistics/{name}"))
            .trim()
            .parse()
            .unwrap_or(0);
        wide as u32
    }

    fn interface(&self, file: &str) -> String {
        let known = !self.name.is_empty() && !self.name.contains('/') && !self.name.starts_with('.');
        if known {
            self.read(&format!("sys/class/net/{}/{file}", self.name))
        } else {
            String::new()
        }
    }

    /// The system's small text files; empty: there is none such.
    fn read(&self, file: &str) -> String {
        let text = fs::read_to_string(self.root.join(file)).unwrap_or_default();
        if text.len() > MAX_FILE { String::new() } else { text }
    }

    fn routes(&self) -> Vec<Route> {
        let text = self.read("proc/net/route");
        text.lines().skip(1).filter_map(Route::parse).collect()
    }
}

/// A line of the routing table.
struct Route {
    interface: String,
    to: Ipv4Addr,
    gateway: Ipv4Addr,
    mask: Ipv4Addr,
}

impl Route {
    /// `Iface Destination Gateway Flags RefCnt Use Metric Mask …`, addresses in hexadecimal as they lie in memory.
    fn parse(line: &str) -> Option<Self> {
        let columns: Vec<&str> = line.split_whitespace().collect();
        let address = |place: usize| {
            let number = u32::from_str_radix(columns.get(place)?, 16).ok()?;
            Some(Ipv4Addr::from(number.to_le_bytes()))
        };
        Some(Self {
            interface: (*columns.first()?).to_owned(),
            to: address(1)?,
            gateway: address(2)?,
            mask: address(7)?,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A host with one adapter, `eth0` at 192.168.1.10/24.
    pub(crate) fn host(root: &Path) {
        let files = [
            ("proc/sys/kernel/hostname", "cell4\n"),
            (
                "etc/resolv.conf",
                "# a comment\nnameserver 192.168.1.2\nnameserver ::1\nnameserver 8.8.4.4\n",
            ),
            (
                "proc/net/route",
                "Iface\tDestination\tGateway\tFlags\tRefCnt\tUse\tMetric\tMask\tMTU\tWindow\tIRTT\n\
                 eth0\t00000000\t0101A8C0\t0003\t0\t0\t0\t00000000\t0\t0\t0\n\
                 eth0\t0001A8C0\t00000000\t0001\t0\t0\t0\t00FFFFFF\t0\t0\t0\nbroken\n",
            ),
            ("sys/class/net/eth0/address", "00:1b:54:aa:0b:0c\n"),
            ("sys/class/net/eth0/speed", "1000\n"),
            ("sys/class/net/eth0/duplex", "full\n"),
            ("sys/class/net/eth0/operstate", "up\n"),
            ("sys/class/net/eth0/statistics/rx_bytes", "4294967298\n"),
            ("sys/class/net/eth0/statistics/rx_packets", "10\n"),
            ("sys/class/net/eth0/statistics/multicast", "3\n"),
            ("sys/class/net/eth0/statistics/tx_packets", "8\n"),
            ("sys/class/net/eth0/statistics/rx_crc_errors", "5\n"),
        ];
        for (file, text) in files {
            let file = root.join(file);
            fs::create_dir_all(file.parent().expect("a folder")).expect("a temporary folder");
            fs::write(file, text).expect("a temporary folder");
        }
    }

    #[test]
    fn an_adapter_is_found_by_its_address() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        host(folder.path());
        let adapter = Adapter::of(folder.path(), Ipv4Addr::new(192, 168, 1, 10));
        assert_eq!(
            (adapter.name.as_str(), adapter.mask),
            ("eth0", Ipv4Addr::new(255, 255, 255, 0))
        );
        assert_eq!(adapter.gateway(), Ipv4Addr::new(192, 168, 1, 1));
        assert_eq!(
            adapter.name_servers(),
            [Ipv4Addr::new(192, 168, 1, 2), Ipv4Addr::new(8, 8, 4, 4)]
        );
        assert_eq!(adapter.host_name(), "cell4");
        assert_eq!(adapter.hardware_address(), [0, 0x1B, 0x54, 0xAA, 0x0B, 0x0C]);
        assert_eq!(
            (adapter.speed(), adapter.is_up(), adapter.is_half_duplex()),
            (1000, true, false)
        );
        assert_eq!(adapter.interface_counters(), [2, 7, 3, 0, 0, 0, 0, 8, 0, 0, 0]);
        assert_eq!(adapter.media_counters(), [0, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_host_that_tells_nothing_gives_zeros() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for address in [Ipv4Addr::new(10, 0, 0, 1), Ipv4Addr::LOCALHOST] {
            let adapter = Adapter::of(folder.path(), address);
            assert_eq!(adapter.gateway(), Ipv4Addr::UNSPECIFIED);
            assert_eq!((adapter.hardware_address(), adapter.speed()), ([0; 6], 0));
            assert_eq!(adapter.interface_counters(), [0; 11]);
        }
    }
}
