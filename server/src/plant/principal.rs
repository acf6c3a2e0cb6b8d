//! The principals of commands, which own the motion that these begin.

use std::fmt;

use crate::guard::VIEWERS;

/// The source of a command. Motion that it begins belongs to its owner ([`Principal::owner`]) until it ends, from every interface.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Principal {
    /// The server itself: it stops or holds the motion of a lost client, or takes over another configuration.
    Server,
    /// The owner of the outputs of implicit I/O.
    Io,
    /// The controller's own program.
    Controller,
    /// A CIP session, or a class 3 connection of it.
    Client {
        /// The session's number; never used again.
        session: u64,
        /// The O→T id of the connection; 0: none.
        connection: u32,
    },
    /// A viewer of the page.
    Viewer(u64),
    /// A jog button of the page that a viewer holds: the jog ends without a sign of life.
    Button(u64),
    /// The program that a viewer has started.
    Program {
        /// The viewer.
        viewer: u64,
        /// The line of the statement, from 1.
        line: u32,
    },
}

impl Principal {
    /// The owner of the motion that begins: that of a program is its viewer's.
    pub fn owner(self) -> Principal {
        match self {
            Self::Program { viewer, .. } => Self::Viewer(viewer),
            Self::Server | Self::Io | Self::Controller | Self::Client { .. } | Self::Viewer(_) | Self::Button(_) => {
                self
            }
        }
    }

    /// The session by which the guard knows the client; `None`: it cannot be lost like a client.
    pub(crate) fn session(self) -> Option<u64> {
        match self {
            Self::Server | Self::Io | Self::Controller => None,
            Self::Client { session, .. } => Some(session),
            Self::Viewer(viewer) | Self::Button(viewer) | Self::Program { viewer, .. } => Some(VIEWERS | viewer),
        }
    }

    /// The viewer of the page that needs control of the objects it moves; `None`: the principal is not a viewer.
    pub(crate) fn viewer(self) -> Option<u64> {
        match self {
            Self::Server | Self::Io | Self::Controller | Self::Client { .. } => None,
            Self::Viewer(viewer) | Self::Button(viewer) | Self::Program { viewer, .. } => Some(viewer),
        }
    }

    /// The line of a program's statement.
    pub fn line(self) -> Option<u32> {
        match self {
            Self::Program { line, .. } => Some(line),
            Self::Server | Self::Io | Self::Controller | Self::Client { .. } | Self::Viewer(_) | Self::Button(_) => {
                None
            }
        }
    }
}

impl fmt::Display for Principal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Server => f.write_str("the server"),
            Self::Io => f.write_str("the owner of the outputs"),
            Self::Controller => f.write_str("the program of the controller"),
            Self::Client { .. } => f.write_str("an EtherNet/IP client"),
            Self::Viewer(_) | Self::Button(_) => f.write_str("a viewer of the page"),
            Self::Program { .. } => f.write_str("a program of the page"),
        }
    }
}
