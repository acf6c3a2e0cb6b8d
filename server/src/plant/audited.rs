//! The events of the audit that the plant records: each command that changes the machine, and each that was refused.

use std::sync::Arc;

use arcline_config::Role;
use arcline_controller::image::{Image, TagId, TagKind};

use super::command::{Command, Outcome, Refused};
use super::principal::Principal;
use super::rights::Right;
use super::{Plant, Shared};
use crate::audit::{Audit, Event, EventKind};

/// Bytes of a value that the audit shows.
const SHOWN: usize = 32;

impl Plant {
    /// Commands are recorded from now on.
    pub(crate) fn set_audit(&self, audit: Audit) {
        // There is one audit, set at the start.
        let _ = self.0.audit.set(audit);
    }

    /// Writes the events that the audit has not written yet.
    pub(crate) fn close_audit(&self) {
        if let Some(audit) = self.0.audit.get() {
            audit.close();
        }
    }

    /// Events that the audit has lost since the start; `None`: there is no audit.
    pub(crate) fn audit_lost(&self) -> Option<u64> {
        self.0.audit.get().map(Audit::lost)
    }

    /// Records an event that is not a command of the plant.
    pub(crate) fn record(&self, principal: Principal, kind: EventKind, object: String, result: &'static str) {
        let role = self.0.roles.of(principal);
        if let Some(audit) = self.0.audit.get() {
            audit.record(self.0.bare(principal, role, kind, object, result));
        }
    }

    /// Records that a client set an attribute that is no command of the plant, with its bytes before and after. Outputs that
    /// are set in a row are merged as plain writes are.
    pub(crate) fn record_set(&self, principal: Principal, right: Right, object: String, before: &[u8], after: &[u8]) {
        let role = self.0.roles.of(principal);
        if let Some(audit) = self.0.audit.get() {
            let mut event = self.0.bare(principal, role, EventKind::Config, object, "done");
            event.values = Some((shown(before), shown(after)));
            event.is_plain_write = right == Right::OwnOutputs;
            audit.record(event);
        }
    }

    /// The number of the newest line of the audit whose hash the log has; `None`: there is no audit.
    pub(crate) fn audit_line(&self) -> Option<u64> {
        self.0.audit.get().map(Audit::told_line)
    }

    /// Records an event of a session of the page; `from` is its address and its user.
    pub(crate) fn record_session(
        &self,
        from: String,
        role: Role,
        kind: EventKind,
        object: String,
        result: &'static str,
    ) {
        if let Some(audit) = self.0.audit.get() {
            audit.record(Event {
                at: self.0.wall.now(),
                kind,
                door: "page",
                from: from.into(),
                role: role.word(),
                object,
                values: None,
                result,
                is_plain_write: false,
            });
        }
    }
}

impl Shared {
    /// Records that a client came or went.
    pub(super) fn record_client(&self, kind: EventKind, session: u64) {
        let principal = if session >= crate::guard::VIEWERS {
            Principal::Viewer(session & !crate::guard::VIEWERS)
        } else {
            Principal::Client { session, connection: 0 }
        };
        if let Some(audit) = self.audit.get() {
            audit.record(self.bare(principal, self.roles.of(principal), kind, String::new(), "done"));
        }
    }

    /// The event of a command, with the values before; `None`: there is no audit, or the command is the server's own upkeep.
    pub(super) fn event(
        &self,
        principal: Principal,
        role: Role,
        command: &Command<'_>,
        image: &Image,
    ) -> Option<Event> {
        self.audit.get()?;
        let (kind, object) = match command {
            Command::WriteTag { tag, offset, data } => {
                let place = if *offset == 0 {
                    String::new()
                } else {
                    format!(" from byte {offset}")
                };
                let old = image.bytes(*tag).get(*offset..).unwrap_or_default();
                let old = old.get(..data.len().min(old.len())).unwrap_or_default();
                let mut event = self.bare(
                    principal,
                    role,
                    kind_of_write(image, *tag),
                    name_of(image, *tag) + &place,
                    "",
                );
                event.values = Some((shown(old), shown(data)));
                // An instruction's tag as a whole has its EnableIn.
                event.is_plain_write =
                    event.kind == EventKind::Write && (is_plain(image, *tag) || data.len() <= size_of::<u64>());
                return Some(event);
            }
            Command::WriteBit { tag, offset, bit, on } => {
                let is_edge = image.is_enable_in(*tag, *offset, *bit);
                let bytes = image.bytes(*tag);
                let before = bytes
                    .get(offset + usize::from(bit / 8))
                    .is_some_and(|byte| byte >> (bit % 8) & 1 == 1);
                let kind = if is_edge {
                    EventKind::Motion
                } else {
                    kind_of_write(image, *tag)
                };
                let name = match is_edge {
                    true => format!("{}.EnableIn", name_of(image, *tag)),
                    false => format!("{} byte {offset} bit {bit}", name_of(image, *tag)),
                };
                let mut event = self.bare(principal, role, kind, name, "");
                event.values = Some((u8::from(before).to_string(), u8::from(*on).to_string()));
                event.is_plain_write = kind == EventKind::Write;
                return Some(event);
            }
            Command::SetAttribute {
                attribute,
                index,
                value,
            } => (
                EventKind::Motion,
                format!("{} of {:?} {index} := {value}", attribute.name, attribute.object),
            ),
            Command::InjectFaults { axis, bits } => {
                (EventKind::Motion, format!("faults 0x{bits:08X} of axis {}", axis.0))
            }
            Command::SetFeedOverride { system, percent } => (
                EventKind::Motion,
                format!("feed override {percent} of coordinate system {}", system.index()),
            ),
            Command::Hold(systems) => (EventKind::Motion, format!("hold {systems:?}")),
            Command::Resume(systems) => (EventKind::Motion, format!("resume {systems:?}")),
            Command::Call(call) => {
                let target = call.target.map_or_else(String::new, |target| format!(" {target}"));
                let control = call.control.map_or_else(String::new, |control| format!(" {control}"));
                let object = call.mnemonic.instruction().object;
                (
                    EventKind::Motion,
                    format!("{} {object:?}{target}{control}", call.mnemonic),
                )
            }
            Command::SetMode(mode) => (EventKind::Config, format!("mode {}", mode.word())),
            Command::Force(force) => (
                EventKind::Write,
                format!("force {} := {}", force.name, force.value.as_f64()),
            ),
            Command::RemoveForce(Some(name)) => (EventKind::Write, format!("force of {name} removed")),
            Command::RemoveForce(None) => (EventKind::Write, "all forces removed".to_owned()),
            // A program that runs is one change, not each of its instructions.
            Command::Execute(_) | Command::RungFalse(..) => return None,
            Command::CreateTag(tag) => (EventKind::Config, format!("create {}", tag.name)),
            Command::DeleteTag(tag) => (EventKind::Config, format!("delete {}", name_of(image, *tag))),
            Command::Reload { .. } => (EventKind::Reload, "the tags of the configuration".to_owned()),
            Command::StopAll => (EventKind::Estop, "stop of everything".to_owned()),
            Command::Inhibit => (EventKind::Estop, "STOP".to_owned()),
            Command::Release => (EventKind::Estop, "release of STOP".to_owned()),
            // Tests step in every line.
            Command::Step { .. } => return None,
            Command::Lose { .. } | Command::Disown(_) => return None,
        };
        Some(self.bare(principal, role, kind, object, ""))
    }

    /// Adds the outcome.
    pub(super) fn finish(&self, event: &mut Event, done: &Result<Outcome, Refused>) {
        event.result = match done {
            Ok(_) => "done",
            Err(Refused::Role { right, .. }) => {
                (event.kind, event.is_plain_write) = (EventKind::Denied, false);
                right.name()
            }
            Err(Refused::NoControl { .. }) => "no control",
            Err(Refused::MovedByAnother { .. }) => "moved by another",
            Err(
                Refused::Write(_)
                | Refused::Table(_)
                | Refused::Call(_)
                | Refused::NoProgram
                | Refused::Force(_)
                | Refused::NotStepped,
            ) => "refused",
            Err(Refused::NotPersisted(_)) => "not kept",
        };
    }

    fn bare(&self, principal: Principal, role: Role, kind: EventKind, object: String, result: &'static str) -> Event {
        let from: Arc<str> = match principal.session() {
            Some(session) => self.guard.identity_of(session).address.as_str().into(),
            None => "".into(),
        };
        let door = match principal {
            Principal::Server => "server",
            Principal::Io => "io",
            Principal::Controller => "controller",
            Principal::Client { .. } if from.contains(" cn:") => "enips",
            Principal::Client { .. } => "enip",
            Principal::Viewer(_) | Principal::Button(_) => "page",
            Principal::Program { .. } => "program",
        };
        Event {
            at: self.wall.now(),
            kind,
            door,
            from,
            role: role.word(),
            object,
            values: None,
            result,
            is_plain_write: false,
        }
    }
}

fn kind_of_write(image: &Image, tag: TagId) -> EventKind {
    match image.tag(tag).map(|tag| tag.kind) {
        Some(TagKind::MotionInhibit) => EventKind::Estop,
        Some(TagKind::FeedOverride | TagKind::FaultInject) => EventKind::Motion,
        _ => EventKind::Write,
    }
}

fn is_plain(image: &Image, tag: TagId) -> bool {
    matches!(
        image.tag(tag).map(|tag| tag.kind),
        Some(TagKind::Plain | TagKind::Alias(_))
    )
}

fn name_of(image: &Image, tag: TagId) -> String {
    image.tag(tag).map(|tag| tag.name.clone()).unwrap_or_default()
}

/// Bytes as hexadecimal digits, the first ones.
fn shown(bytes: &[u8]) -> String {
    let mut text = crate::tls::hex(bytes.get(..SHOWN).unwrap_or(bytes));
    if bytes.len() > SHOWN {
        text.push('…');
    }
    text
}
