//! The rules of the page's requests: whether a request may move the machine, which right it needs, and its record in the audit.

use crate::audit::{EventKind, sha256};
use crate::hmi::protocol::{Request, Take};
use crate::plant::Right;

/// Whether a request may move an axis.
pub(super) fn moves(request: &Request) -> bool {
    match request {
        Request::Execute(_)
        | Request::Jog(_)
        | Request::Run(_)
        | Request::Step(_)
        | Request::Continue(_)
        | Request::Override(_)
        | Request::Resume(_)
        | Request::Mode(_)
        | Request::Force(_)
        | Request::RemoveForces(_)
        | Request::Write(_) => true,
        Request::Ping(_)
        | Request::Active(_)
        | Request::Sessions(_)
        | Request::EndSession(_)
        | Request::Take(_)
        | Request::Release(_)
        | Request::Line(_)
        | Request::Keep(_)
        | Request::JogEnd(_)
        | Request::Stop(_)
        | Request::ReleaseStop(_)
        | Request::Hold(_)
        | Request::Preview(_)
        | Request::DryRun(_)
        | Request::Check(_)
        | Request::Pause(_)
        | Request::End(_)
        | Request::Tags(_)
        | Request::Read(_)
        | Request::Watch(_)
        | Request::Routines(_)
        | Request::Rungs(_)
        | Request::Look(_)
        | Request::Uses(_)
        | Request::Trace(_)
        | Request::History(_)
        | Request::Events(_) => false,
    }
}

/// The record in the audit of a request that is not a command of the plant.
pub(super) fn audited(request: &Request) -> Option<(EventKind, String)> {
    Some(match request {
        Request::Take(take) if take.force => (EventKind::Take, format!("{} by force", take.object)),
        Request::Take(take) => (EventKind::Take, take.object.clone()),
        Request::Release(release) => (EventKind::Take, format!("{} given back", release.object)),
        Request::Run(run) => (EventKind::Program, format!("run, sha256 {}", sha256(&run.text))),
        Request::Continue(_) => (EventKind::Program, "continue".to_owned()),
        Request::End(_) => (EventKind::Program, "end".to_owned()),
        _ => return None,
    })
}

/// The right that a request needs. The plant checks its own commands too.
pub(super) fn right(request: &Request) -> Right {
    match request {
        Request::Ping(_)
        | Request::Active(_)
        | Request::Line(_)
        | Request::Preview(_)
        | Request::DryRun(_)
        | Request::Check(_)
        | Request::Tags(_)
        | Request::Read(_)
        | Request::Watch(_)
        | Request::Routines(_)
        | Request::Rungs(_)
        | Request::Look(_)
        | Request::Uses(_)
        | Request::Trace(_)
        | Request::History(_)
        | Request::Events(_) => Right::Look,
        Request::Keep(_)
        | Request::JogEnd(_)
        | Request::Stop(_)
        | Request::Hold(_)
        | Request::Pause(_)
        | Request::End(_) => Right::Stop,
        Request::Take(Take { force: true, .. }) => Right::TakeByForce,
        Request::Take(_) | Request::Release(_) => Right::TakeControl,
        Request::Jog(_) => Right::Move,
        Request::ReleaseStop(_) => Right::ReleaseStop,
        Request::Run(_) | Request::Step(_) | Request::Continue(_) => Right::RunProgram,
        // They are commands of the plant: the right that each needs depends on its operands.
        Request::Execute(_) | Request::Override(_) | Request::Resume(_) | Request::Write(_) => Right::Look,
        Request::Mode(_) => Right::ChangeMode,
        Request::Sessions(_) | Request::EndSession(_) => Right::EndSessions,
        Request::Force(_) | Request::RemoveForces(_) => Right::Force,
    }
}
