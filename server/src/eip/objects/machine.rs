//! Machine, class 0x0305 (docs/spec/contract.md §7): STOP and its release, the identifications of clients, and the counters of commands.
//! Series of moves are in [`series`](super::series).

use arcline_controller::image::MOST_STEPS;
use arcline_proto::arcline::machine::{self, CommandCount, ControllerMode, Identification, Step, attribute, service};
use arcline_proto::cip::{CipStatus, Reply};
use bytes::Bytes;

use super::object::{Access, Extent, Object, ObjectContext, On, OwnService};
use super::values::{no_attribute, u8_value};
use crate::eip::context::Memory;
use crate::plant::{Command, Counter, Mode, Plant, ProgramState, Right};

#[derive(Debug)]
pub(super) struct MachineObject;

const fn row(code: u8, name: &'static str, access: Access, right: Right) -> OwnService {
    OwnService {
        code,
        name,
        on: On::Instance,
        access,
        right,
    }
}

/// Stop alone waits for no lock.
const SERVICES: [OwnService; 5] = [
    row(service::STOP, "Stop", Access::Read, Right::Stop),
    row(service::RELEASE, "Release", Access::Set, Right::ReleaseStop),
    row(service::IDENTIFY, "Identify", Access::Read, Right::Look),
    row(service::EXECUTE_SERIES, "Execute Series", Access::Series, Right::Move),
    row(service::STEP, "Step", Access::Change, Right::StepClock),
];

impl Object for MachineObject {
    fn class(&self) -> u16 {
        machine::CLASS
    }

    fn name(&self) -> &'static str {
        "Machine"
    }

    fn services(&self) -> &'static [OwnService] {
        &SERVICES
    }

    fn serve(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32) -> Result<Reply, CipStatus> {
        let code = cx.request.service;
        match code {
            service::STOP => {
                cx.no_data()?;
                match cx.memory {
                    Memory::Read(_) => cx.device().plant.inhibit(),
                    // In its order among the writes of a packet.
                    Memory::Write(_) => drop(cx.apply(Command::Inhibit)?),
                }
            }
            service::RELEASE => {
                cx.no_data()?;
                cx.apply(Command::Release)?;
            }
            service::STEP => step(cx)?,
            _ => identify(cx)?,
        }
        Ok(Reply::success(code, Bytes::new()))
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, attribute::IS_STEPPED)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let plant = &cx.device().plant;
        match id {
            attribute::MOTION_INHIBITED => u8_value(plant.is_inhibited().into()),
            attribute::COMMANDS => {
                let counts: Vec<CommandCount> = Counter::ALL
                    .iter()
                    .map(|counter| {
                        let count = plant.count(*counter);
                        CommandCount {
                            kind: counter.name().to_owned(),
                            done: count.done,
                            refused: count.refused,
                        }
                    })
                    .collect();
                Ok(machine::encode_counts(&counts))
            }
            attribute::MODE => u8_value(mode(plant).number()),
            attribute::MAJOR_FAULT => {
                let fault = match plant.program_status().map(|status| status.state) {
                    Some(ProgramState::Faulted(words)) => words,
                    _ => String::new(),
                };
                Ok(machine::encode_text(&fault))
            }
            attribute::TICK => Ok(Bytes::copy_from_slice(&cx.image().snapshot_tick().to_le_bytes())),
            attribute::IS_STEPPED => u8_value(plant.is_stepped().into()),
            _ => no_attribute(),
        }
    }

    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Option<usize> {
        (id == attribute::MODE).then_some(1)
    }

    fn right_to_set(&self) -> Right {
        Right::ChangeMode
    }

    fn set(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32, _id: u16, value: &[u8]) -> Result<(), CipStatus> {
        let mode = value.first().copied().and_then(ControllerMode::from_number);
        let mode = match mode {
            Some(ControllerMode::Program) => Mode::Program,
            Some(ControllerMode::Run) => Mode::Run,
            _ => return Err(CipStatus::INVALID_ATTRIBUTE_VALUE),
        };
        cx.apply(Command::SetMode(mode)).map(drop)
    }

    fn all(&self) -> &'static [u16] {
        &[attribute::MOTION_INHIBITED, attribute::COMMANDS]
    }
}

/// The mode of the controller's program.
pub(super) fn mode(plant: &Plant) -> ControllerMode {
    match plant.program_status().map(|status| status.state) {
        None => ControllerMode::None,
        Some(ProgramState::Stopped) => ControllerMode::Program,
        Some(ProgramState::Running) => ControllerMode::Run,
        Some(ProgramState::Faulted(_)) => ControllerMode::Faulted,
    }
}

/// Lets ticks pass behind all else of the packet.
fn step(cx: &mut ObjectContext<'_, '_>) -> Result<(), CipStatus> {
    let Step { ticks, until } = Step::decode(&cx.request.data)?;
    if ticks > MOST_STEPS {
        return Err(CipStatus::INVALID_PARAMETER);
    }
    let until = match until.as_str() {
        "" => None,
        path => Some(path.parse().map_err(|_| CipStatus::INVALID_PARAMETER)?),
    };
    cx.apply(Command::Step { ticks, until }).map(drop)
}

/// Stores the identification that a client sends.
fn identify(cx: &ObjectContext<'_, '_>) -> Result<(), CipStatus> {
    let identification = Identification::decode(&cx.request.data)?;
    if let Some(session) = cx.context.principal.session() {
        let identification = identification.bounded();
        cx.device()
            .plant
            .guard()
            .identify(session, |identity| identity.identification = identification);
    }
    Ok(())
}
