//! Instructions as tags: shaped like the backing tag of an add-on instruction (spec/contract.md §3).
//!
//! The members are `EnableIn`, `EnableOut`, the target's name if there is one, `MotionControl`, then a member for every other
//! operand in faceplate order. Writing and executing them is the controller's business.

use std::sync::{Arc, LazyLock};

use arcline_tag::{
    DataType, Elementary, Location, Member, PathError, PathSegment, STRING_SIZE, TagType, Template, TemplateBuilder,
    Value, string_template, string_text, write_string,
};

use crate::instruction::{ArrayRule, Kind};
use crate::{Instruction, MAX_ELEMENTS, Mnemonic, Operand, UnboundOperand, predefined};

/// Template instance of the first instruction's tag type; the others follow in the order of [`Mnemonic::ALL`].
const FIRST_INSTANCE: u16 = 0x100;

/// The member that is the instruction's MOTION_INSTRUCTION.
const MOTION_CONTROL: &str = "MotionControl";

/// Elements of an Event Distance member.
const EVENT_ELEMENTS: u16 = 4;

/// The type of a tag for this instruction, such as `MCLM`; the same in every run.
pub fn instruction_tag_template(mnemonic: Mnemonic) -> Arc<Template> {
    static TEMPLATES: LazyLock<Vec<Arc<Template>>> = LazyLock::new(|| {
        Mnemonic::ALL
            .iter()
            .map(|mnemonic| build(mnemonic.instruction()))
            .collect()
    });
    TEMPLATES[mnemonic as usize].clone()
}

/// Follows the segments behind a tag's name. The path of a status bit of an instruction tag may omit `MotionControl`:
/// `PC` is `MotionControl.PC`. For other tags it is [`TagType::locate`].
///
/// # Errors
/// Names the member, index or bit that does not exist.
pub fn locate<S: AsRef<str>>(tag_type: &TagType, rest: &[PathSegment<S>]) -> Result<Location, PathError> {
    tag_type.locate(rest).or_else(|error| {
        if !matches!(error, PathError::NoSuchMember { .. }) || !is_instruction(tag_type) {
            return Err(error);
        }
        let control = std::iter::once(PathSegment::Symbol(MOTION_CONTROL));
        let inner: Vec<_> = control.chain(rest.iter().map(PathSegment::borrowed)).collect();
        tag_type.locate(&inner).map_err(|_| error)
    })
}

fn is_instruction(tag_type: &TagType) -> bool {
    match &tag_type.data_type {
        DataType::Structure(template) => tag_type.rank() == 0 && template.name.parse::<Mnemonic>().is_ok(),
        DataType::Elementary(_) => false,
    }
}

/// The first bytes of such a tag: a full-speed S-curve, no target.
pub fn instruction_tag_defaults(mnemonic: Mnemonic) -> Vec<u8> {
    let instruction = mnemonic.instruction();
    let template = instruction_tag_template(mnemonic);
    let mut bytes = vec![0; template.size as usize];
    for operand in instruction
        .operands_behind_control()
        .map(|place| &instruction.operands[place])
    {
        let Some(member) = member_of(&template, operand) else {
            continue;
        };
        if let DataType::Elementary(kind) = &member.data_type {
            let value = Value::from_f64(*kind, f64::from(operand.initial));
            // A member is inside its template.
            let _ = value.write(&mut bytes[member.offset as usize..]);
        }
    }
    bytes
}

/// The target's name in the bytes of an instruction tag; empty when there is none.
pub fn instruction_tag_target(mnemonic: Mnemonic, bytes: &[u8]) -> String {
    let template = instruction_tag_template(mnemonic);
    let member = template.member(mnemonic.instruction().object.member());
    member.map_or_else(String::new, |member| text_at(bytes, member))
}

/// Writes the target's name into the bytes of an instruction tag; `None` when it is too long.
pub fn set_instruction_tag_target(mnemonic: Mnemonic, bytes: &mut [u8], target: &str) -> Option<()> {
    let template = instruction_tag_template(mnemonic);
    let member = template.member(mnemonic.instruction().object.member())?;
    write_string(bytes.get_mut(member.offset as usize..)?, target)
}

/// The operands in the bytes of the instruction tag `tag`, for [`crate::bind`].
///
/// An array for results, such as `CalculatedData`, is named as the tag's own member. An `EventDistance`
/// of zeros only is "none", and then the instruction calculates no result. Missing bytes read as 0.
pub fn instruction_tag_operands(mnemonic: Mnemonic, tag: &str, bytes: &[u8]) -> Vec<UnboundOperand> {
    let instruction = mnemonic.instruction();
    let template = instruction_tag_template(mnemonic);
    let mut events = true;
    let operands = instruction
        .operands_behind_control()
        .map(|place| &instruction.operands[place]);
    operands
        .map(|operand| {
            let Some(member) = member_of(&template, operand) else {
                return UnboundOperand::Missing;
            };
            match operand.kind {
                Kind::Target(_) | Kind::MotionControl => UnboundOperand::Missing,
                Kind::Word(_) | Kind::Integer(_) | Kind::Number(_) => {
                    UnboundOperand::Number(number_at(bytes, member, 0))
                }
                Kind::Array(_) => UnboundOperand::Array(numbers_at(bytes, member)),
                Kind::ArrayOrNone => {
                    let numbers = numbers_at(bytes, member);
                    events = numbers.iter().any(|number| *number != 0.0);
                    if events {
                        UnboundOperand::Array(numbers)
                    } else {
                        UnboundOperand::Integer(0)
                    }
                }
                Kind::WrittenArray(_) if events => UnboundOperand::Name(format!("{tag}.{}", member.name)),
                Kind::WrittenArray(_) => UnboundOperand::Integer(0),
                Kind::Object(_) | Kind::Structure(_) | Kind::StructureOrNone(_) => {
                    UnboundOperand::Name(text_at(bytes, member))
                }
            }
        })
        .collect()
}

fn build(instruction: &Instruction) -> Arc<Template> {
    let mut builder = TemplateBuilder::new(
        instruction.mnemonic.name(),
        FIRST_INSTANCE + instruction.mnemonic as u16,
    )
    .member("EnableIn", Elementary::Bool)
    .member("EnableOut", Elementary::Bool);
    if instruction.has_target() {
        builder = builder.member(instruction.object.member(), string_template());
    }
    builder = builder.member(MOTION_CONTROL, predefined::motion_instruction());
    for operand in instruction
        .operands_behind_control()
        .map(|place| &instruction.operands[place])
    {
        let name = operand.member();
        builder = match operand.kind {
            Kind::Target(_) | Kind::MotionControl => builder,
            Kind::Word(_) | Kind::Integer(_) => builder.member(name, Elementary::Dint),
            Kind::Number(_) => builder.member(name, Elementary::Real),
            Kind::Array(ArrayRule::PerAxis | ArrayRule::PerAxisUnless { .. }) => {
                builder.array(name, Elementary::Real, MAX_ELEMENTS as u16)
            }
            Kind::Array(ArrayRule::AtLeast(least)) => builder.array(name, Elementary::Real, u16::from(least)),
            Kind::ArrayOrNone => builder.array(name, Elementary::Real, EVENT_ELEMENTS),
            Kind::WrittenArray(elements) => builder.array(name, Elementary::Real, elements),
            Kind::Object(_) | Kind::Structure(_) | Kind::StructureOrNone(_) => builder.member(name, string_template()),
        };
    }
    builder.build()
}

fn member_of<'a>(template: &'a Template, operand: &Operand) -> Option<&'a Member> {
    template.member(&operand.member())
}

fn number_at(bytes: &[u8], member: &Member, element: usize) -> f64 {
    let DataType::Elementary(kind) = &member.data_type else {
        return 0.0;
    };
    let bytes = bytes
        .get(member.offset as usize + element * kind.size()..)
        .unwrap_or_default();
    Value::read(*kind, bytes).map_or(0.0, Value::as_f64)
}

fn numbers_at(bytes: &[u8], member: &Member) -> Vec<f64> {
    (0..member.elements())
        .map(|element| number_at(bytes, member, element))
        .collect()
}

fn text_at(bytes: &[u8], member: &Member) -> String {
    let start = member.offset as usize;
    let bytes = bytes.get(start..).unwrap_or_default();
    string_text(&bytes[..bytes.len().min(STRING_SIZE)])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn an_mclm_tag_has_the_members_of_the_contract() {
        let template = instruction_tag_template(Mnemonic::Mclm);
        let names: Vec<_> = template
            .members
            .iter()
            .filter(|member| !member.hidden)
            .map(|member| member.name.as_str())
            .collect();
        #[rustfmt::skip]
        assert_eq!(names, [
            "EnableIn", "EnableOut", "CoordinateSystem", "MotionControl", "MoveType", "Position", "Speed",
            "SpeedUnits", "AccelRate", "AccelUnits", "DecelRate", "DecelUnits", "Profile", "AccelJerk", "DecelJerk",
            "JerkUnits", "TerminationType", "Merge", "MergeSpeed", "CommandTolerance", "LockPosition",
            "LockDirection", "EventDistance", "CalculatedData",
        ]);
        #[rustfmt::skip]
        let cases = [
            (Mnemonic::Mclm, "Position", "REAL", 9), (Mnemonic::Mclm, "EventDistance", "REAL", 4),
            (Mnemonic::Mclm, "CalculatedData", "REAL", 4), (Mnemonic::Mccm, "ViaCenterRadius", "REAL", 9),
            (Mnemonic::Mccm, "CircleType", "DINT", 0), (Mnemonic::Mccm, "Speed", "REAL", 0),
            (Mnemonic::Mag, "MasterAxis", "STRING", 0), (Mnemonic::Mag, "SlaveCounts", "DINT", 0),
            (Mnemonic::Mas, "Axis", "STRING", 0), (Mnemonic::Mgs, "MotionGroup", "STRING", 0),
            (Mnemonic::Mdcc, "CoordinateSystem", "STRING", 0), (Mnemonic::Mcs, "MotionControl", "MOTION_INSTRUCTION", 0),
        ];
        for (mnemonic, name, kind, dimension) in cases {
            let template = instruction_tag_template(mnemonic);
            let member = template.member(name).unwrap_or_else(|| panic!("{mnemonic} {name}"));
            assert_eq!(
                (member.data_type.name(), member.dimension),
                (kind, dimension),
                "{mnemonic} {name}"
            );
        }
    }

    #[test]
    fn status_bits_are_found_without_their_structure() {
        let of = |tag_type: &TagType, path: &str| {
            let path: arcline_tag::TagPath = path.parse().expect("a path");
            locate(tag_type, path.rest()).map_err(|error| error.to_string())
        };
        let tag = TagType::scalar(instruction_tag_template(Mnemonic::Mclm));
        for name in ["PC", "pc", "ERR", "FLAGS.3"] {
            let (short, long) = (
                of(&tag, &format!("T.{name}")),
                of(&tag, &format!("T.MotionControl.{name}")),
            );
            assert_eq!(short, long, "{name}");
            assert!(short.is_ok(), "{name}: {short:?}");
        }
        let slip = "MCLM has no member \"Sped\", did you mean \"Speed\"?";
        assert_eq!(of(&tag, "T.Sped"), Err(slip.to_owned()));
        assert!(of(&tag, "T.Position.PC").is_err(), "only of the tag itself");
        assert!(
            of(&TagType::scalar(predefined::axis_virtual()), "T.PC").is_err(),
            "only of an instruction"
        );
    }

    #[test]
    fn every_instruction_has_a_user_type_of_its_own() {
        for (k, mnemonic) in Mnemonic::ALL.iter().enumerate() {
            let template = instruction_tag_template(*mnemonic);
            assert!(template.is_user_type(), "{mnemonic}");
            assert_eq!(template.instance, FIRST_INSTANCE + k as u16, "{mnemonic}");
            // Old clients do not fragment structures of more than 500 bytes; the rare ones that name many tags do not fit.
            let names = matches!(mnemonic, Mnemonic::Mcto | Mnemonic::Mctpo | Mnemonic::Maoc);
            assert!(names || template.size <= 500, "{mnemonic}: {} bytes", template.size);
            assert_eq!(instruction_tag_defaults(*mnemonic).len(), template.size as usize);
        }
    }

    #[test]
    fn first_values_are_a_full_speed_s_curve() {
        let bytes = instruction_tag_defaults(Mnemonic::Mclm);
        let template = instruction_tag_template(Mnemonic::Mclm);
        #[rustfmt::skip]
        let cases = [
            ("MoveType", 0.0), ("Speed", 100.0), ("SpeedUnits", 1.0), ("AccelRate", 100.0), ("AccelUnits", 1.0),
            ("DecelRate", 100.0), ("DecelUnits", 1.0), ("Profile", 1.0), ("AccelJerk", 100.0), ("DecelJerk", 100.0),
            ("JerkUnits", 2.0), ("TerminationType", 0.0), ("Merge", 0.0), ("LockDirection", 0.0), ("Position", 0.0),
        ];
        for (name, expected) in cases {
            assert_eq!(
                number_at(&bytes, template.member(name).expect(name), 0),
                expected,
                "{name}"
            );
        }
    }

    #[test]
    fn a_tag_gives_its_operands() {
        let mut bytes = instruction_tag_defaults(Mnemonic::Mclm);
        assert_eq!(instruction_tag_target(Mnemonic::Mclm, &bytes), "");
        set_instruction_tag_target(Mnemonic::Mclm, &mut bytes, "CS1").expect("it fits");
        assert_eq!(instruction_tag_target(Mnemonic::Mclm, &bytes), "CS1");
        let operands = instruction_tag_operands(Mnemonic::Mclm, "Move1", &bytes);
        assert_eq!(operands.len(), 20);
        assert_eq!(operands[1], UnboundOperand::Array(vec![0.0; 9]));
        assert_eq!(operands[2], UnboundOperand::Number(100.0));
        assert_eq!(
            operands[18..],
            [UnboundOperand::Integer(0), UnboundOperand::Integer(0)],
            "no events, nothing calculated"
        );

        let event = instruction_tag_template(Mnemonic::Mclm)
            .member("EventDistance")
            .expect("member")
            .offset as usize;
        bytes[event..event + 4].copy_from_slice(&5.0f32.to_le_bytes());
        let operands = instruction_tag_operands(Mnemonic::Mclm, "Move1", &bytes);
        assert_eq!(operands[18], UnboundOperand::Array(vec![5.0, 0.0, 0.0, 0.0]));
        assert_eq!(operands[19], UnboundOperand::Name("Move1.CalculatedData".to_owned()));
    }

    proptest! {
        #[test]
        fn any_bytes_give_operands(index in 0..Mnemonic::ALL.len(), bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
            let mnemonic = Mnemonic::ALL[index];
            let operands = instruction_tag_operands(mnemonic, "T", &bytes);
            prop_assert_eq!(operands.len(), mnemonic.instruction().operands_behind_control().count());
            let _ = instruction_tag_target(mnemonic, &bytes);
        }
    }
}
