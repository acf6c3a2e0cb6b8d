//! The rules that hold for every command, each one exhaustive `match`: the right that it needs, the owner of the motion that it begins,
//! whether the retained state includes its changes, and its counter. A new command or instruction does not compile before all are answered.
//!
//! A CIP client may execute every command. A viewer of the page needs control of the objects that its commands move. A jog button
//! moves no axis that another principal moves. [`Right`](super::Right) says which commands a role may execute.

use arcline_config::Role;
use arcline_controller::image::{Image, TagId, TagKind};
use arcline_controller::machine::Machine;
use arcline_instruction_set::{
    AxisId, Directory as _, Mnemonic, Object, SystemId, UnboundOperand, instruction_tag_target,
};

use super::command::{Call, Command, Refused, Systems};
use super::control::{Control, MotionObject};
use super::counters::Counter;
use super::principal::Principal;
use super::rights::Right;

/// Checks that a principal of a role may execute a command on the tags as they are. A program of the page needs the right to run
/// programs beside that of each of its commands.
///
/// # Errors
/// [`Refused::Role`].
pub(super) fn authorize_role(
    principal: Principal,
    role: Role,
    command: &Command<'_>,
    image: &Image,
) -> Result<(), Refused> {
    let of_program = matches!(principal, Principal::Program { .. }).then_some(Right::RunProgram);
    let missing = [of_program, Some(Right::of_command(command, image))]
        .into_iter()
        .flatten()
        .find(|right| !right.is_of(role));
    missing.map_or(Ok(()), |right| Err(Refused::Role { right, role }))
}

/// Checks that a principal has the control that a command needs.
///
/// # Errors
/// [`Refused::NoControl`].
pub(super) fn authorize(
    principal: Principal,
    command: &Command<'_>,
    image: &Image,
    machine: &Machine,
    control: &Control,
) -> Result<(), Refused> {
    let Some(viewer) = principal.viewer() else {
        return Ok(());
    };
    for object in moved_by(command, image, machine) {
        control
            .check(machine, viewer, object)
            .map_err(|conflict| Refused::NoControl {
                object: object.name(machine).to_owned(),
                holder: conflict.map(|conflict| conflict.by),
            })?;
    }
    Ok(())
}

/// The axis that no other principal may move when the command begins: that of a jog button.
pub(super) fn alone_on(principal: Principal, command: &Command<'_>) -> Option<AxisId> {
    match (principal, command) {
        (Principal::Button(_), Command::Call(call)) if call.mnemonic == Mnemonic::Maj => call.target.map(AxisId),
        _ => None,
    }
}

/// The objects of which a viewer needs control: those that move, or move in another way, because of the command. Stops and holds
/// need none.
fn moved_by(command: &Command<'_>, image: &Image, machine: &Machine) -> Vec<MotionObject> {
    match command {
        Command::WriteTag { tag, offset, data } => written(image, *tag, *offset, data.len()),
        Command::WriteBit { tag, offset, bit, on } => {
            let executes = *on && image.is_enable_in(*tag, *offset, *bit);
            match image.tag(*tag).map(|tag| tag.kind) {
                Some(TagKind::Instruction(kind)) if executes && !is_free(kind.mnemonic) => {
                    let target = instruction_tag_target(kind.mnemonic, image.bytes(*tag));
                    let object = kind.mnemonic.instruction().object;
                    let index = image.object(object, &target);
                    index.map(|index| MotionObject::of(object, index)).into_iter().collect()
                }
                _ => written(image, *tag, offset + usize::from(bit / 8), 1),
            }
        }
        Command::SetAttribute { attribute, index, .. } => vec![MotionObject::of(attribute.object, *index)],
        Command::InjectFaults { axis, .. } => vec![MotionObject::Axis(*axis)],
        Command::SetFeedOverride { system, .. } => vec![MotionObject::System(*system)],
        Command::Resume(Systems::One(system)) => vec![MotionObject::System(*system)],
        Command::Resume(Systems::All) => SystemId::first(machine.systems.len())
            .map(MotionObject::System)
            .collect(),
        Command::Call(call) => called(call, image),
        // The program of the controller is no viewer.
        Command::Execute(_)
        | Command::RungFalse(..)
        | Command::SetMode(_)
        | Command::Force(_)
        | Command::RemoveForce(_)
        | Command::Hold(_)
        | Command::CreateTag(_)
        | Command::DeleteTag(_)
        | Command::Reload { .. }
        | Command::Lose { .. }
        | Command::Disown(_)
        | Command::StopAll
        | Command::Inhibit
        | Command::Release
        | Command::Step { .. } => Vec::new(),
    }
}

/// The objects that bytes of a tag move: those of the elements of the feed overrides and the injected faults.
fn written(image: &Image, tag: TagId, offset: usize, length: usize) -> Vec<MotionObject> {
    let kind = match image.tag(tag).map(|tag| tag.kind) {
        Some(TagKind::FeedOverride) => |index| MotionObject::System(SystemId::from_index(index)),
        Some(TagKind::FaultInject) => |index| MotionObject::Axis(AxisId::from_index(index)),
        _ => return Vec::new(),
    };
    let elements = image.bytes(tag).len() / ELEMENT;
    let from = offset / ELEMENT;
    let end = offset.saturating_add(length).div_ceil(ELEMENT).min(elements);
    (from..end).map(kind).collect()
}

/// The objects that an instruction moves.
fn called(call: &Call<'_>, image: &Image) -> Vec<MotionObject> {
    if is_free(call.mnemonic) {
        return Vec::new();
    }
    let object = call.mnemonic.instruction().object;
    let target = call.target.map(|index| MotionObject::of(object, index));
    let moves_another = matches!(call.mnemonic, Mnemonic::Mct | Mnemonic::Mcto);
    let others = call
        .operands
        .iter()
        .filter(|_| moves_another)
        .filter_map(|operand| match operand {
            UnboundOperand::Name(name) | UnboundOperand::Word(name) => image.object(Object::CoordinateSystem, name),
            _ => None,
        });
    target
        .into_iter()
        .chain(others.map(|index| MotionObject::System(SystemId(index))))
        .collect()
}

/// Stops need no control.
fn is_free(mnemonic: Mnemonic) -> bool {
    matches!(mnemonic, Mnemonic::Mcs | Mnemonic::Mas | Mnemonic::Mgs)
}

/// Whether the retained state includes the changes of a command, so that its answer waits until the file has them.
pub(super) fn is_retained(command: &Command<'_>) -> bool {
    match command {
        Command::WriteTag { .. }
        | Command::WriteBit { .. }
        | Command::CreateTag(_)
        | Command::DeleteTag(_)
        | Command::Reload { .. } => true,
        // The results of instructions are sent when these are answered, and the snapshots show the changes of axes.
        Command::SetAttribute { .. }
        | Command::InjectFaults { .. }
        | Command::SetFeedOverride { .. }
        | Command::Hold(_)
        | Command::Resume(_)
        | Command::Call(_)
        | Command::Execute(_)
        | Command::RungFalse(..)
        | Command::SetMode(_)
        | Command::Force(_)
        | Command::RemoveForce(_)
        | Command::Lose { .. }
        | Command::Disown(_)
        | Command::StopAll
        | Command::Inhibit
        | Command::Release
        | Command::Step { .. } => false,
    }
}

/// The stop of the motion that an instruction begins, for the loss of its owner: an instruction and its Stop Type. `None`: it begins no motion.
pub(super) fn stop_of(mnemonic: Mnemonic) -> Option<(Mnemonic, &'static str)> {
    Some(match mnemonic {
        Mnemonic::Maj => (Mnemonic::Mas, "Jog"),
        Mnemonic::Mam => (Mnemonic::Mas, "Move"),
        Mnemonic::Mag => (Mnemonic::Mas, "Gear"),
        Mnemonic::Mah => (Mnemonic::Mas, "Home"),
        Mnemonic::Mapc => (Mnemonic::Mas, "Position Cam"),
        Mnemonic::Matc => (Mnemonic::Mas, "Time Cam"),
        Mnemonic::Mclm | Mnemonic::Mccm | Mnemonic::Mcpm => COORDINATED_MOVE,
        Mnemonic::Mct | Mnemonic::Mcto => (Mnemonic::Mcs, "Coordinated Transform"),
        Mnemonic::Mgs
        | Mnemonic::Mgsd
        | Mnemonic::Mgsr
        | Mnemonic::Mgsp
        | Mnemonic::Mso
        | Mnemonic::Msf
        | Mnemonic::Masd
        | Mnemonic::Masr
        | Mnemonic::Mafr
        | Mnemonic::Mas
        | Mnemonic::Mcd
        | Mnemonic::Mrp
        | Mnemonic::Mdac
        | Mnemonic::Mccd
        | Mnemonic::Mcs
        | Mnemonic::Mcsd
        | Mnemonic::Mcsr
        | Mnemonic::Mdcc
        | Mnemonic::Mctp
        | Mnemonic::Mctpo
        | Mnemonic::Mccp
        | Mnemonic::Mcsv
        | Mnemonic::Maw
        | Mnemonic::Mdw
        | Mnemonic::Mar
        | Mnemonic::Mdr
        | Mnemonic::Maoc
        | Mnemonic::Mdoc => return None,
    })
}

/// The stop of coordinated moves, the only motion that can be held.
pub(super) const COORDINATED_MOVE: (Mnemonic, &str) = (Mnemonic::Mcs, "Coordinated Move");

/// The name of a command in the log, and its counter.
pub(super) fn counter(command: &Command<'_>) -> Counter {
    match command {
        Command::WriteTag { .. } | Command::WriteBit { .. } => Counter::Writes,
        Command::SetAttribute { .. } => Counter::Attributes,
        Command::InjectFaults { .. } => Counter::InjectedFaults,
        Command::SetFeedOverride { .. } | Command::Hold(_) | Command::Resume(_) => Counter::Overrides,
        Command::Call(_) | Command::Execute(_) | Command::RungFalse(..) => Counter::Instructions,
        Command::SetMode(_) => Counter::Modes,
        Command::Force(_) | Command::RemoveForce(_) => Counter::Writes,
        Command::CreateTag(_) | Command::DeleteTag(_) | Command::Reload { .. } => Counter::Tables,
        Command::Lose { .. } | Command::Disown(_) => Counter::Owners,
        Command::StopAll | Command::Inhibit | Command::Release => Counter::Stops,
        Command::Step { .. } => Counter::Steps,
    }
}

/// Bytes of an element of `FeedOverride` and `FaultInject`.
const ELEMENT: usize = 4;
