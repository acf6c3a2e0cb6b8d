//! The network adapter of the host as the system's files show it: the interface of an address, its mask, gateway, name servers, speed
//! and counters.
//!
//! The server reads these values and never sets them, since the host's network is not its own. A value that the system does not show is
//! 0 or empty. Addresses are numbers, their first byte the highest.

use std::collections::BTreeMap;
use std::fs;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use crate::work_threads::WorkThreads;

/// The adapter of an address at the time of its last read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Adapter {
    /// The interface, such as `eth0`; empty: not known.
    pub(crate) name: String,
    /// The address.
    pub(crate) address: Ipv4Addr,
    /// Its network's mask; 0.0.0.0: not known.
    pub(crate) mask: Ipv4Addr,
    /// The default gateway of this interface; 0.0.0.0: none.
    pub(crate) gateway: Ipv4Addr,
    /// The first two name servers; 0.0.0.0: none.
    pub(crate) name_servers: [Ipv4Addr; 2],
    /// The host's name, at most 64 bytes.
    pub(crate) host_name: String,
    /// Mbit/s; 0: not known.
    pub(crate) speed: u32,
    /// Whether the link is up. A loopback interface reports "unknown" and counts as up.
    pub(crate) is_up: bool,
    /// Whether the duplex mode is half; it counts as full unless the system reports half.
    pub(crate) is_half_duplex: bool,
    /// The hardware address; zeros: not known.
    pub(crate) hardware_address: [u8; 6],
    /// In Octets, In Unicast, In Non-unicast, In Discards, In Errors, In Unknown Protocols, and the five of Out. They wrap.
    pub(crate) interface_counters: [u32; 11],
    /// Alignment, FCS, single and multiple collisions, SQE, deferred, late and excessive collisions, MAC transmit, carrier
    /// sense, frame too long, MAC receive. They wrap.
    pub(crate) media_counters: [u32; 12],
}

/// The adapters of the host. The system's files are read once a second at most, and beside the requests that want to know: some dozen
/// files take milliseconds.
#[derive(Debug)]
pub(crate) struct Adapters {
    /// The root of the system's files: `/`, or the folder of a test.
    root: PathBuf,
    /// Where they are read again.
    threads: WorkThreads,
    known: Arc<Mutex<BTreeMap<Ipv4Addr, Known>>>,
}

#[derive(Debug)]
struct Known {
    adapter: Arc<Adapter>,
    read: Instant,
    /// A thread reads it again.
    reading: bool,
}

/// The age at which the values of an adapter are read again.
const FRESH: Duration = Duration::from_secs(1);
/// Addresses of the host that are known.
const MANY: usize = 64;

impl Adapters {
    /// `root`: where the system's files are; `threads` read them.
    pub(crate) fn new(root: &Path, threads: WorkThreads) -> Self {
        Self {
            root: root.to_owned(),
            threads,
            known: Arc::default(),
        }
    }

    /// The adapter of a local address: read here when it is asked for the first time, as it was read last otherwise.
    pub(crate) fn of(&self, address: Ipv4Addr) -> Arc<Adapter> {
        if let Some(adapter) = self.known(address) {
            return adapter;
        }
        read(&self.root, address, &self.known)
    }

    /// Reads the adapter of a local address beside the tasks of this thread, unless it is known.
    pub(crate) fn prepare(&self, address: Ipv4Addr) {
        if !lock(&self.known).contains_key(&address) {
            self.read_beside(address);
        }
    }

    /// Returns the known adapter of an address, and reads it again if it is old.
    fn known(&self, address: Ipv4Addr) -> Option<Arc<Adapter>> {
        let (adapter, is_old) = {
            let mut all = lock(&self.known);
            let known = all.get_mut(&address)?;
            let is_old = known.read.elapsed() >= FRESH && !std::mem::replace(&mut known.reading, true);
            (known.adapter.clone(), is_old)
        };
        if is_old {
            self.read_beside(address);
        }
        Some(adapter)
    }

    fn read_beside(&self, address: Ipv4Addr) {
        let (root, known) = (self.root.clone(), self.known.clone());
        self.threads.run_beside(move || drop(read(&root, address, &known)));
    }
}

fn read(root: &Path, address: Ipv4Addr, known: &Mutex<BTreeMap<Ipv4Addr, Known>>) -> Arc<Adapter> {
    let adapter = Arc::new(Adapter::of(root, address));
    let mut all = lock(known);
    if all.len() >= MANY {
        all.clear();
    }
    let now = Known {
        adapter: adapter.clone(),
        read: Instant::now(),
        reading: false,
    };
    all.insert(address, now);
    adapter
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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

/// Longest file that the server reads, bytes.
const MAX_FILE: usize = 64 * 1024;

impl Adapter {
    /// The adapter of a local address, by the routing table. Reads some dozen files.
    pub(crate) fn of(root: &Path, address: Ipv4Addr) -> Self {
        let files = Files(root);
        let routes = files.routes();
        let (name, mask) = if address.is_loopback() {
            // The routing table leaves it out.
            ("lo".to_owned(), Ipv4Addr::new(255, 0, 0, 0))
        } else {
            let own = |route: &&Route| {
                !route.mask.is_unspecified() && address.to_bits() & route.mask.to_bits() == route.to.to_bits()
            };
            let own = routes.iter().find(own);
            own.map_or((String::new(), Ipv4Addr::UNSPECIFIED), |route| {
                (route.interface.clone(), route.mask)
            })
        };
        let default = |route: &&Route| route.mask.is_unspecified() && route.interface == name;
        let gateway = routes.iter().find(default);
        let host_name = files.read("proc/sys/kernel/hostname");
        let mut interface_counters = INTERFACE_COUNTERS.map(|counter| files.counter(&name, counter));
        // The system counts multicast packets among all.
        interface_counters[1] = interface_counters[1].wrapping_sub(interface_counters[2]);
        Self {
            gateway: gateway.map_or(Ipv4Addr::UNSPECIFIED, |route| route.gateway),
            name_servers: files.name_servers(),
            host_name: host_name
                .trim()
                .chars()
                .filter(char::is_ascii_graphic)
                .take(64)
                .collect(),
            speed: files.interface(&name, "speed").trim().parse().unwrap_or(0),
            is_up: matches!(files.interface(&name, "operstate").trim(), "up" | "unknown"),
            is_half_duplex: files.interface(&name, "duplex").trim() == "half",
            hardware_address: files.hardware_address(&name),
            interface_counters,
            media_counters: MEDIA_COUNTERS.map(|counter| files.counter(&name, counter)),
            name,
            address,
            mask,
        }
    }

    /// The first of its multicast addresses: 239.192.1.0 + 32 × ((host part of the address & 0x3FF) − 1)
    /// (spec/ethernet-ip.md §14.2).
    pub(crate) fn first_multicast(&self) -> Ipv4Addr {
        let host = self.address.to_bits() & !self.mask.to_bits();
        let base = Ipv4Addr::new(239, 192, 1, 0).to_bits();
        Ipv4Addr::from_bits(base + 32 * (host & 0x3FF).saturating_sub(1))
    }

    /// Whether the adapter is inside the host.
    pub(crate) fn is_internal(&self) -> bool {
        self.address.is_loopback()
    }
}

/// The files in which the system shows its network, below a folder.
struct Files<'r>(&'r Path);

impl Files<'_> {
    fn name_servers(&self) -> [Ipv4Addr; 2] {
        let mut servers = [Ipv4Addr::UNSPECIFIED; 2];
        let text = self.read("etc/resolv.conf");
        let found = text
            .lines()
            .filter_map(|line| line.strip_prefix("nameserver")?.trim().parse().ok());
        servers
            .iter_mut()
            .zip(found)
            .for_each(|(server, found)| *server = found);
        servers
    }

    fn hardware_address(&self, name: &str) -> [u8; 6] {
        let text = self.interface(name, "address");
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

    fn counter(&self, name: &str, counter: &str) -> u32 {
        if counter.is_empty() {
            return 0;
        }
        let wide: u64 = self
            .interface(name, &format!("statistics/{counter}"))
            .trim()
            .parse()
            .unwrap_or(0);
        wide as u32
    }

    fn interface(&self, name: &str, file: &str) -> String {
        let known = !name.is_empty() && !name.contains('/') && !name.starts_with('.');
        if known {
            self.read(&format!("sys/class/net/{name}/{file}"))
        } else {
            String::new()
        }
    }

    /// The system's small text files; empty: there is none such.
    fn read(&self, file: &str) -> String {
        let text = fs::read_to_string(self.0.join(file)).unwrap_or_default();
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
        let address = |column: usize| {
            let number = u32::from_str_radix(columns.get(column)?, 16).ok()?;
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
        assert_eq!(adapter.gateway, Ipv4Addr::new(192, 168, 1, 1));
        assert_eq!(
            adapter.name_servers,
            [Ipv4Addr::new(192, 168, 1, 2), Ipv4Addr::new(8, 8, 4, 4)]
        );
        assert_eq!(adapter.host_name, "cell4");
        assert_eq!(adapter.hardware_address, [0, 0x1B, 0x54, 0xAA, 0x0B, 0x0C]);
        assert_eq!(
            (adapter.speed, adapter.is_up, adapter.is_half_duplex),
            (1000, true, false)
        );
        assert_eq!(adapter.interface_counters, [2, 7, 3, 0, 0, 0, 0, 8, 0, 0, 0]);
        assert_eq!(adapter.media_counters, [0, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_host_that_tells_nothing_gives_zeros() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for address in [Ipv4Addr::new(10, 0, 0, 1), Ipv4Addr::LOCALHOST] {
            let adapter = Adapter::of(folder.path(), address);
            assert_eq!(adapter.gateway, Ipv4Addr::UNSPECIFIED);
            assert_eq!((adapter.hardware_address, adapter.speed), ([0; 6], 0));
            assert_eq!(adapter.interface_counters, [0; 11]);
        }
    }
}
