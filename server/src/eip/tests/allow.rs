//! The list of addresses that may connect (spec/security.md §6).

use std::net::SocketAddr;
use std::time::Duration;

use arcline_config::AllowList;
use tokio::io::AsyncReadExt;

use super::{Client, plant, settings_of};
use crate::eip::stepped::SteppedInterface;

#[tokio::test]
async fn only_the_networks_of_the_list_are_answered() {
    let mut settings = settings_of("Bench");
    let networks = ["10.1.2.0/24", "fd00::/8"].map(|text| AllowList::network(text).expect("a network"));
    settings.config.security.plain_allow = AllowList(networks.into());
    let (plant, _thread) = plant();
    let interface = SteppedInterface::start(plant, settings).expect("an interface");
    #[rustfmt::skip]
    let cases = [
        ("in the first network",  "10.1.2.3:50000",           true),
        ("beside it",             "10.1.3.3:50000",           false),
        ("IPv4 inside of IPv6",   "[::ffff:10.1.2.4]:50000",  true),
        ("in the second network", "[fd12::1]:50000",          true),
        ("another IPv6",          "[2001:db8::1]:50000",      false),
        ("this computer",         "127.0.0.1:50000",          true),
    ];
    for (why, peer, is_answered) in cases {
        let peer: SocketAddr = peer.parse().expect("an address");
        let (mut ours, theirs) = tokio::io::duplex(64 * 1024);
        interface.connect(Ok((Box::new(theirs), peer)));
        if is_answered {
            let client = Client::register(ours).await;
            assert_ne!(client.session.0, 0, "{why}");
        } else {
            let read = tokio::time::timeout(Duration::from_secs(20), ours.read(&mut [0; 1])).await;
            assert_eq!(read.expect("it is closed at once").expect("an end"), 0, "{why}");
            assert_eq!(interface.held().clients, 0, "{why}: it has no place");
        }
    }
}
