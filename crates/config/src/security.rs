//! The `[security]` table: who may do what (spec/security.md §6).

/// A role. Each may do all that those before it may.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Role {
    /// Looks and stops.
    Viewer,
    /// Moves the machine and writes tags.
    Operator,
    /// Runs programs and sets up the machine.
    Engineer,
    /// Decides about users and certificates.
    Administrator,
}

impl Role {
    /// Every role, the least first.
    pub const ALL: [Role; 4] = [Role::Viewer, Role::Operator, Role::Engineer, Role::Administrator];

    /// The word in a configuration.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Operator => "operator",
            Self::Engineer => "engineer",
            Self::Administrator => "administrator",
        }
    }

    /// That of a word, case ignored.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|role| role.word().eq_ignore_ascii_case(word))
    }
}

/// The `[security]` table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Security {
    /// Whether the file has the table.
    pub is_given: bool,
    /// The role of clients on this computer.
    pub loopback: Role,
    /// The role of clients elsewhere, without TLS.
    pub remote_plain: Role,
    /// The most requests a second of one EtherNet/IP client, by its role; 0: any number.
    pub max_requests: [u32; 4],
}

impl Security {
    /// The most requests a second of an EtherNet/IP client; 0: any number.
    pub fn max_requests_of(&self, role: Role) -> u32 {
        let [viewer, operator, engineer, administrator] = self.max_requests;
        match role {
            Role::Viewer => viewer,
            Role::Operator => operator,
            Role::Engineer => engineer,
            Role::Administrator => administrator,
        }
    }
}

impl Default for Security {
    fn default() -> Self {
        Self {
            is_given: false,
            loopback: Role::Engineer,
            remote_plain: Role::Viewer,
            max_requests: [0; 4],
        }
    }
}
