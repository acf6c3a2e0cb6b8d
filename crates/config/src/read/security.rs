//! The `[security]` table.

use crate::section::Section;
use crate::{Role, Security};

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
    let engineers = rate("max_requests_per_s_engineer");
    Security {
        is_given,
        loopback: role("loopback", default.loopback),
        remote_plain: role("remote_plain", default.remote_plain),
        max_requests: [
            rate("max_requests_per_s_viewer"),
            rate("max_requests_per_s_operator"),
            engineers,
            engineers,
        ],
    }
}
