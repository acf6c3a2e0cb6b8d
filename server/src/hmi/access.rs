//! Access to the HMI: by names of the host that no foreign page can take, and from pages of this server only.
//!
//! A page of another origin may open a WebSocket to any address, and a name of a stranger's may be made to mean this host
//! (DNS rebinding). The first is seen by `Origin`, the second by `Host`, which browsers do not let a page choose.

use std::net::{IpAddr, SocketAddr};

use axum::http::{HeaderMap, header};

/// Whether a `Host` header means this server: a loopback name, or the address it listens on. A server that listens on all
/// addresses takes any address, and of the names only those in `names`.
pub(super) fn is_host(host: &str, listen: SocketAddr, names: &[String]) -> bool {
    let name = without_port(host);
    if name.eq_ignore_ascii_case("localhost") || names.iter().any(|known| known.eq_ignore_ascii_case(name)) {
        return true;
    }
    let literal = name
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
        .unwrap_or(name);
    match literal.parse::<IpAddr>() {
        Ok(address) => address.is_loopback() || listen.ip().is_unspecified() || address == listen.ip(),
        Err(_) => false,
    }
}

/// Whether an `Origin` header is that of a page of this host.
pub(super) fn is_origin(origin: &str, host: &str) -> bool {
    ["http://", "https://"].iter().any(|scheme| {
        origin
            .strip_prefix(scheme)
            .is_some_and(|rest| rest.eq_ignore_ascii_case(host))
    })
}

/// The origin of a request that changes the machine or its settings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Asker {
    /// A page of this server, or a person who typed the address.
    Own,
    /// A page of another origin.
    Foreign,
    /// No browser: those send one of the two headers.
    NoBrowser,
}

/// The origin of a request, by `Sec-Fetch-Site`, or else by `Origin`: browsers let no page choose them.
pub(super) fn asker(headers: &HeaderMap) -> Asker {
    let text = |name: &str| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let host = text(header::HOST.as_str()).unwrap_or_default();
    let is_own = match (text("sec-fetch-site"), text(header::ORIGIN.as_str())) {
        (Some(site), origin) => {
            ["same-origin", "none"].contains(&site) && origin.is_none_or(|origin| is_origin(origin, host))
        }
        (None, Some(origin)) => is_origin(origin, host),
        (None, None) => return Asker::NoBrowser,
    };
    if is_own { Asker::Own } else { Asker::Foreign }
}

fn without_port(host: &str) -> &str {
    match host.rsplit_once(':') {
        // The colon of an IPv6 address stands in brackets.
        Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) && !name.is_empty() => name,
        _ => host,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts() {
        #[rustfmt::skip]
        let cases = [
            ("loopback",                  "127.0.0.1:8080",       "127.0.0.1:8080",   true),
            ("its name",                  "localhost:8080",       "127.0.0.1:8080",   true),
            ("case",                      "LOCALHOST",            "127.0.0.1:8080",   true),
            ("a forwarded port",          "localhost:9000",       "127.0.0.1:8080",   true),
            ("IPv6 loopback",             "[::1]:8080",           "127.0.0.1:8080",   true),
            ("a rebound name",            "evil.example:8080",    "127.0.0.1:8080",   false),
            ("looks like it",             "localhost.evil.example", "127.0.0.1:8080", false),
            ("looks like an address",     "127.0.0.1.nip.io:8080", "127.0.0.1:8080",  false),
            ("another address",           "192.168.1.9:8080",     "127.0.0.1:8080",   false),
            ("the listen address",        "192.168.1.9:8080",     "192.168.1.9:8080", true),
            ("any address of all",        "192.168.1.9:8080",     "0.0.0.0:8080",     true),
            ("a name when on all",        "evil.example",         "0.0.0.0:8080",     false),
            ("a known name",              "Cell-4.example:8080",  "0.0.0.0:8080",     true),
            ("looks like a known name",   "cell-4.example.evil.example", "0.0.0.0:8080", false),
            ("empty",                     "",                     "127.0.0.1:8080",   false),
            ("only a port",               ":8080",                "127.0.0.1:8080",   false),
        ];
        for (why, host, listen, expected) in cases {
            let listen = listen.parse().expect("an address");
            assert_eq!(
                is_host(host, listen, &["cell-4.example".to_owned()]),
                expected,
                "{why}: {host} at {listen}"
            );
        }
    }

    #[test]
    fn askers() {
        #[rustfmt::skip]
        let cases = [
            ("a page of this server", Some("same-origin"), Some("https://cell:8443"), Asker::Own),
            ("without an origin",     Some("same-origin"), None,                      Asker::Own),
            ("a typed address",       Some("none"),        None,                      Asker::Own),
            ("another site",          Some("cross-site"),  Some("https://evil"),      Asker::Foreign),
            ("another port",          Some("same-site"),   Some("https://cell:1"),    Asker::Foreign),
            ("they differ",           Some("same-origin"), Some("https://evil"),      Asker::Foreign),
            ("an old browser",        None,                Some("https://cell:8443"), Asker::Own),
            ("an old browser, foreign", None,              Some("https://evil"),      Asker::Foreign),
            ("a sandbox",             None,                Some("null"),              Asker::Foreign),
            ("no browser",            None,                None,                      Asker::NoBrowser),
        ];
        for (why, site, origin, expected) in cases {
            let mut headers = HeaderMap::new();
            headers.insert("host", "cell:8443".parse().expect("a header"));
            for (name, value) in [("sec-fetch-site", site), ("origin", origin)] {
                if let Some(value) = value {
                    headers.insert(name, value.parse().expect("a header"));
                }
            }
            assert_eq!(asker(&headers), expected, "{why}");
        }
    }

    #[test]
    fn origins() {
        #[rustfmt::skip]
        let cases = [
            ("the page itself",       "http://localhost:8080",       "localhost:8080",  true),
            ("behind TLS",            "https://localhost:8080",      "localhost:8080",  true),
            ("another page",          "http://evil.example",         "localhost:8080",  false),
            ("another port",          "http://localhost:3000",       "localhost:8080",  false),
            ("another name",          "http://127.0.0.1:8080",       "localhost:8080",  false),
            ("a file",                "null",                        "localhost:8080",  false),
            ("a longer name",         "http://localhost:8080.evil",  "localhost:8080",  false),
            ("no scheme",             "localhost:8080",              "localhost:8080",  false),
        ];
        for (why, origin, host, expected) in cases {
            assert_eq!(is_origin(origin, host), expected, "{why}: {origin} at {host}");
        }
    }
}
