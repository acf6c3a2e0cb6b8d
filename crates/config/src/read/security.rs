//! The `[security]` table.

use crate::keys::NETWORKS;
use crate::section::Section;
use crate::{AllowList, CertificateRole, PlainAccess, Role, Security};

pub(super) fn security(root: &Section<'_>) -> Security {
    let (section, is_given) = root.table("security");
    let default = Security::default();
    let role = |key, default| section.word(key).and_then(Role::of_word).unwrap_or(default);
    let rate = |key| {
        section
            .integer(key)
            .and_then(|rate| u32::try_from(rate).ok())
            .unwrap_or(0)
    };
    let seconds = |key, default| {
        let seconds = section.integer(key).and_then(|seconds| u32::try_from(seconds).ok());
        seconds.unwrap_or(default)
    };
    let engineers = rate("max_requests_per_s_engineer");
    let plain = section.word("plain").unwrap_or_default();
    let plain = PlainAccess::WORDS.iter().find(|(word, _)| *word == plain);
    let security = Security {
        is_given,
        tls: section.text_or_default("tls").parse().ok(),
        certificate: section.text_or_default("certificate"),
        key: section.text_or_default("key"),
        clients: section.text_or_default("clients"),
        revoked: section.text("revoked").map(|file| file.value),
        check_expiration: section.boolean("check_expiration").unwrap_or(true),
        plain: plain.map_or(default.plain, |(_, plain)| *plain),
        refuses_io_over_tls: section.word("io_over_tls") != Some("plain"),
        default_role: role("default_role", default.default_role),
        certificates: section.tables("certificates").iter().map(certificate).collect(),
        loopback: role("loopback", default.loopback),
        remote_plain: role("remote_plain", default.remote_plain),
        hmi_tls: section.text_or_default("hmi_tls").parse().ok(),
        hmi_names: section.texts("hmi_names").into_iter().map(|name| name.value).collect(),
        login_notice: section.text("login_notice").map(|text| text.value),
        users: section.text("users").map(|file| file.value),
        idle: seconds("idle_s", default.idle),
        session: seconds("session_s", default.session),
        plain_allow: allow_list(&section, "plain_allow"),
        tls_allow: allow_list(&section, "tls_allow"),
        hmi_allow: allow_list(&section, "hmi_allow"),
        max_requests: [
            rate("max_requests_per_s_viewer"),
            rate("max_requests_per_s_operator"),
            engineers,
            engineers,
        ],
    };
    if security.plain != PlainAccess::On && security.tls.is_none() {
        section.conflict(
            "plain",
            "tls",
            "without TLS and without plain EtherNet/IP no client could connect",
        );
    }
    if section.count("hmi_names") > 32 {
        section.refuse_value("hmi_names", "a list of 1 to 32 names of the host");
    }
    security
}

fn allow_list(section: &Section<'_>, key: &'static str) -> AllowList {
    if section.has(key) && !(1..=AllowList::MOST).contains(&section.count(key)) {
        section.refuse_value(key, NETWORKS);
    }
    let networks = section.texts(key).into_iter().filter_map(|text| {
        let network = AllowList::network(&text.value);
        if network.is_none() {
            section.refuse_as(&text, "a network such as \"10.1.2.0/24\", or an address", None);
        }
        network
    });
    AllowList(networks.collect())
}

fn certificate(row: &Section<'_>) -> CertificateRole {
    let text = |key| row.text(key).map(|text| text.value);
    let read = CertificateRole {
        cn: text("cn"),
        issuer: text("issuer"),
        sha256: text("sha256"),
        role: row.word("role").and_then(Role::of_word).unwrap_or(Role::Viewer),
    };
    match ["cn", "issuer", "sha256"].map(|key| row.has(key)) {
        [true, true, false] | [false, false, true] => {}
        [_, _, true] => row.conflict("sha256", "cn", "a row names a certificate in one way"),
        [false, _, false] => row.missing("cn"),
        [true, false, false] => row.missing("issuer"),
    }
    read
}
