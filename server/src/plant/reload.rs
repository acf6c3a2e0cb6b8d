//! Another configuration while the machine runs: its tags and types are taken over, its machine is not.

use arcline_config::Project;
use arcline_controller::image::TableError;
use arcline_controller::machine::Machine;
use arcline_state::planted::is_planted;

use super::{Command, Plant, Principal, Refused};
use crate::retained::NotPersisted;

/// The reason for which a configuration is not taken over. Except with [`ReloadError::NotPersisted`], nothing has changed.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ReloadError {
    /// Parts of it that are read at the start only.
    #[error("Reload refused: {} changed, which needs a restart", .parts.join(", "))]
    NeedsRestart {
        /// The parts that have changed, such as `axis X`.
        parts: Vec<String>,
    },
    /// Its tags cannot stand beside those there are.
    #[error("Reload refused: {0}")]
    Table(#[from] TableError),
    /// The server has taken it over, but the file of the retained state does not have it.
    #[error("its tags were reloaded, but {NotPersisted}")]
    NotPersisted,
}

impl Plant {
    /// Takes over the tags and types of `new`, which was read in place of `old`.
    ///
    /// # Errors
    /// See [`ReloadError`].
    pub async fn reload(&self, old: &Project, new: &Project) -> Result<(), ReloadError> {
        let parts = needs_restart(old, new);
        if !parts.is_empty() {
            return Err(ReloadError::NeedsRestart { parts });
        }
        if is_planted("reload in two parts") && new.tags.len() > old.tags.len() {
            let mut half = new.clone();
            half.tags.pop();
            let command = Command::Reload {
                old: old.configured(),
                new: half.configured(),
            };
            let _ = self.apply(Principal::Server, command).await;
            return Ok(());
        }
        let (old, new) = (old.configured(), new.configured());
        match self.apply(Principal::Server, Command::Reload { old, new }).await {
            Ok(_) => Ok(()),
            Err(Refused::Table(error)) => Err(error.into()),
            Err(Refused::NotPersisted(NotPersisted)) => Err(ReloadError::NotPersisted),
            Err(
                Refused::Role { .. }
                | Refused::NoControl { .. }
                | Refused::MovedByAnother { .. }
                | Refused::Write(_)
                | Refused::Call(_)
                | Refused::NoProgram
                | Refused::Force(_)
                | Refused::NotStepped,
            ) => Ok(()),
        }
    }
}

/// Names the changed parts of a configuration that the server reads at the start only.
fn needs_restart(old: &Project, new: &Project) -> Vec<String> {
    let mut parts = Vec::new();
    let mut server = new.server.clone();
    // The side of TLS takes the roles of certificates over.
    let (was, is) = (&old.server.security, &mut server.security);
    (is.certificates, is.default_role) = (was.certificates.clone(), was.default_role);
    if old.server != server {
        parts.push("[server]".to_owned());
    }
    parts.extend(machine_changes(&old.machine, &new.machine));
    parts
}

/// Names the parts of a machine that differ in a file that is read again.
pub(crate) fn machine_changes(was: &Machine, is: &Machine) -> Vec<String> {
    let mut parts = Vec::new();
    if (&was.group, was.period_ns) != (&is.group, is.period_ns) {
        parts.push("[motion_group]".to_owned());
    }
    differing(&mut parts, "axis", &was.axes, &is.axes, |axis| &axis.name);
    differing(&mut parts, "coordinate system", &was.systems, &is.systems, |system| {
        &system.name
    });
    differing(&mut parts, "transform", &was.transforms, &is.transforms, |transform| {
        &transform.name
    });
    parts
}

/// Names the parts that were added, removed or changed; a change of their order alone counts too.
fn differing<T: PartialEq>(parts: &mut Vec<String>, what: &str, was: &[T], is: &[T], name: impl Fn(&T) -> &String) {
    if was == is {
        return;
    }
    let before = parts.len();
    let gone = was.iter().filter(|old| !is.iter().any(|new| name(new) == name(old)));
    let other = is.iter().filter(|new| !was.contains(new));
    parts.extend(gone.chain(other).map(|part| format!("{what} {}", name(part))));
    if parts.len() == before {
        parts.push(format!("the order of the {what}s"));
    }
}
