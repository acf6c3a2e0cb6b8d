//! The `[security]` table.

use crate::keys::NETWORKS;
use crate::section::Section;
use crate::{AllowList, CertificateRole, PlainAccess, Security, words};

pub(super) fn security(root: &Section<'_>) -> Security {
    let (section, is_given) = root.table("security");
    let engineers = section.whole("max_requests_per_s_engineer");
    let security = Security {
        is_given,
        tls: section.address("tls"),
        certificate: section.text_or_default("certificate"),
        key: section.text_or_default("key"),
        clients: section.text_or_default("clients"),
        revoked: section.text("revoked").map(|file| file.value),
        check_expiration: section.flag("check_expiration"),
        plain: section.one_of("plain", words::PLAIN),
        refuses_io_over_tls: section.one_of("io_over_tls", words::IO_OVER_TLS),
        default_role: section.one_of("default_role", words::ROLES),
        certificates: section.tables("certificates").iter().map(certificate).collect(),
        loopback: section.one_of("loopback", words::ROLES),
        remote_plain: section.one_of("remote_plain", words::ROLES),
        hmi_tls: section.address("hmi_tls"),
        hmi_names: section.texts("hmi_names").into_iter().map(|name| name.value).collect(),
        login_notice: section.text("login_notice").map(|text| text.value),
        users: section.text("users").map(|file| file.value),
        idle: section.whole("idle_s"),
        session: section.whole("session_s"),
        plain_allow: allow_list(&section, "plain_allow"),
        tls_allow: allow_list(&section, "tls_allow"),
        hmi_allow: allow_list(&section, "hmi_allow"),
        max_requests: [
            section.whole("max_requests_per_s_viewer"),
            section.whole("max_requests_per_s_operator"),
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
        role: row.one_of("role", words::ROLES),
    };
    match ["cn", "issuer", "sha256"].map(|key| row.has(key)) {
        [true, true, false] | [false, false, true] => {}
        [_, _, true] => row.conflict("sha256", "cn", "a row names a certificate in one way"),
        [false, _, false] => row.missing("cn"),
        [true, false, false] => row.missing("issuer"),
    }
    read
}
