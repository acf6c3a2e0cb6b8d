//! Instructions of motion (spec/programs.md §11): operands by the catalogue of `arcline-instruction-set`. Literal operands are bound when the
//! project is loaded; operands in tags are read when the instruction executes.

use arcline_instruction_set::{
    Argument as Bound, Call, ControlSlot, Kind, MAX_OPERANDS, Mnemonic, Object, RealArray, predefined,
};
use arcline_tag::{DataType, Elementary, elements_of};

use super::expression::{Sort, cast};
use super::operand::parse;
use super::{Compiler, Wrong};
use crate::code::{Area, Ex, MotionCall, MotionOperand};
use crate::error::{Finding, FindingKind};
use crate::expression::Expression;

impl Compiler<'_> {
    /// Notes where the machine's objects and the motion control tags stand.
    pub(crate) fn motion_objects(&mut self) {
        let control = DataType::Structure(predefined::motion_instruction());
        let mut without = Vec::new();
        for tag in &self.tags.list {
            if tag.program.is_none() {
                for kind in Object::ALL {
                    if let Some(index) = self.directory.object(kind, &tag.name) {
                        self.objects.push((tag.at, kind, index));
                    }
                }
            }
            let mut places = Vec::new();
            controls_in(
                &tag.tag_type.data_type,
                tag.at,
                &tag.full_name(),
                &control,
                &tag.tag_type.dimensions,
                &mut places,
            );
            for (at, name) in places {
                match self.directory.control(&name) {
                    Some(slot) => self.controls.push((at, slot)),
                    None => without.push(name),
                }
            }
        }
        if let Some(first) = without.first().filter(|_| self.directory.has_motion()) {
            self.findings.push(Finding {
                kind: FindingKind::Error,
                name: first.clone(),
                reason: format!(
                    "there is no room for it and {} further motion control tags, the machine has room for {}",
                    without.len() - 1,
                    self.controls.len()
                ),
                program: None,
                routine: None,
                place: None,
            });
        }
        self.objects.sort_by_key(|(at, ..)| *at);
        self.controls.sort_by_key(|(at, _)| *at);
    }

    /// A call of an instruction of motion; `None`: it is none.
    pub(crate) fn motion_call(&mut self, name: &str, operands: &[&str]) -> Result<Option<MotionCall>, Wrong> {
        let Ok(mnemonic) = name.to_ascii_uppercase().parse::<Mnemonic>() else {
            return Ok(None);
        };
        let instruction = mnemonic.instruction();
        let expected = instruction.operands.len();
        let ignored = instruction.ignored_operand().filter(|_| operands.len() == expected + 1);
        if operands.len() > expected && ignored.is_none() {
            return Err(format!("{} operands, expected {expected}", operands.len()).into());
        }
        let given = operands
            .iter()
            .enumerate()
            .filter(|(place, _)| Some(*place) != ignored)
            .map(|(_, text)| *text);
        let given: Vec<&str> = given.collect();
        let mut call = Call {
            mnemonic,
            target: None,
            control: ControlSlot(0),
            arguments: [Bound::None; MAX_OPERANDS],
        };
        let (mut target, mut control, mut dynamic) = (None, None, Vec::new());
        for (place, operand) in instruction.operands.iter().enumerate() {
            let text = given.get(place).copied().unwrap_or_default();
            let wrong = |reason: Wrong| reason.of(format_args!("{} {text}", operand.name));
            match &operand.kind {
                Kind::Target(_) => target = Some(self.area_of(text).map_err(wrong)?.place),
                Kind::MotionControl => {
                    let area = self.area_of(text).map_err(wrong)?;
                    if area.data_type.name() != "MOTION_INSTRUCTION" || area.is_whole {
                        let reason = format!("is {}, expected MOTION_INSTRUCTION", area.data_type.name());
                        return Err(wrong(reason.into()));
                    }
                    control = Some(area.place);
                }
                kind => {
                    let bound = self.motion_operand(kind, text).map_err(wrong)?;
                    let fixed = match bound {
                        Operand::Fixed(fixed) => fixed,
                        Operand::Read(operand) => {
                            dynamic.push((place as u8, operand));
                            Bound::None
                        }
                    };
                    if let Some(argument) = call.arguments.get_mut(place) {
                        *argument = fixed;
                    }
                }
            }
        }
        let control = control.ok_or("expected a motion control tag")?;
        Ok(Some(MotionCall {
            call,
            target,
            control,
            operands: dynamic.into(),
            is_text: self.is_text,
        }))
    }

    fn motion_operand(&mut self, kind: &Kind, text: &str) -> Result<Operand, Wrong> {
        let is_none = text.is_empty() || text == "0" || text == "?" || text.eq_ignore_ascii_case("none");
        match kind {
            Kind::Word(words) => {
                if text.is_empty() {
                    return Ok(Operand::Fixed(Bound::Number(arcline_instruction_set::Operand::OMITTED)));
                }
                // A tag may have the name of a word only where no word is meant.
                match words.parse_word(text) {
                    Some(value) => Ok(Operand::Fixed(Bound::Number(f64::from(value)))),
                    None => self.motion_number(text),
                }
            }
            Kind::Number(_) | Kind::Integer(_) => self.motion_number(text),
            Kind::ArrayOrNone | Kind::WrittenArray(_) | Kind::StructureOrNone(_) if is_none => {
                Ok(Operand::Fixed(Bound::None))
            }
            Kind::Array(_) | Kind::ArrayOrNone => match parse(text)? {
                Expression::Reference(_) => {
                    let area = self.area_of(text)?;
                    if !matches!(area.data_type, DataType::Elementary(kind) if kind != Elementary::Bool) {
                        return Err(format!("is {}, expected an array of REAL", area.data_type.name()).into());
                    }
                    Ok(Operand::Read(MotionOperand::Array(area)))
                }
                expression => match self.number(&expression, Sort::Double)?.0 {
                    Ex::Real(number) => Ok(Operand::Fixed(Bound::Array(RealArray::from_slice(&[number])))),
                    Ex::Integer(number) => Ok(Operand::Fixed(Bound::Array(RealArray::from_slice(&[number as f64])))),
                    _ => Err("expected an array".into()),
                },
            },
            Kind::Object(_) => Ok(Operand::Read(MotionOperand::Object(self.area_of(text)?.place))),
            Kind::WrittenArray(_) => {
                let area = self.area_of(text)?;
                if area.data_type != DataType::Elementary(Elementary::Real) {
                    return Err(format!("is {}, expected an array of REAL", area.data_type.name()).into());
                }
                self.share(&area);
                Ok(Operand::Read(MotionOperand::Written(area)))
            }
            Kind::Structure(name) | Kind::StructureOrNone(name) => {
                let area = self.area_of(text)?;
                let expected = name.split('[').next().unwrap_or(name);
                if !area.data_type.name().eq_ignore_ascii_case(expected) {
                    return Err(format!("is {}, expected {name}", area.data_type.name()).into());
                }
                self.share(&area);
                Ok(Operand::Read(MotionOperand::Tag(area)))
            }
            Kind::Target(_) | Kind::MotionControl => Ok(Operand::Fixed(Bound::None)),
        }
    }

    fn motion_number(&mut self, text: &str) -> Result<Operand, Wrong> {
        if text.is_empty() || text == "?" {
            return Ok(Operand::Fixed(Bound::Number(arcline_instruction_set::Operand::OMITTED)));
        }
        let (value, sort) = self.number(&parse(text)?, Sort::Double)?;
        Ok(match cast(value, sort, Sort::Double) {
            Ex::Real(number) => Operand::Fixed(Bound::Number(number)),
            value => Operand::Read(MotionOperand::Number(value)),
        })
    }

    pub(crate) fn area_of(&mut self, text: &str) -> Result<Area, Wrong> {
        match parse(text)? {
            Expression::Reference(reference) => match self.resolve(&reference)? {
                found if found.bit.is_some() => Err("is a bit, expected data".into()),
                found => Ok(found.area()),
            },
            _ => Err("expected a tag".into()),
        }
    }

    /// Makes the tag of an operand known to the host, which reads and writes it as a whole. A tag that an add-on instruction gets by
    /// reference is shared at the call of that instruction.
    fn share(&mut self, area: &Area) {
        if area.place.base == 0 {
            self.share_at(area.place.at);
        }
    }

    /// The same of the tag that holds a byte.
    pub(crate) fn share_at(&mut self, at: u32) {
        // Tags stand in the order of their first bytes.
        let behind = self.tags.list.partition_point(|tag| tag.at <= at);
        if let Some(number) = behind.checked_sub(1) {
            self.share_tag(number);
        }
    }

    fn share_tag(&mut self, number: usize) {
        if self.shared.contains_key(&number) {
            return;
        }
        if let Some(tag) = self.tags.list.get(number)
            && let Some(id) = self.directory.tag(&tag.full_name(), &tag.tag_type)
        {
            self.shared.insert(number, id);
        }
    }
}

/// An operand of motion.
enum Operand {
    Fixed(Bound),
    Read(MotionOperand),
}

/// The motion control structures in a tag, with names.
fn controls_in(
    of: &DataType,
    at: u32,
    name: &str,
    control: &DataType,
    dimensions: &[u32],
    places: &mut Vec<(u32, String)>,
) {
    let size = of.size() as u32;
    let DataType::Structure(template) = of else { return };
    let is_array = dimensions.first().is_some_and(|size| *size > 0);
    for element in 0..elements_of(dimensions) {
        if places.len() >= MAX_CONTROLS {
            return;
        }
        let at = at + element * size;
        let name = if is_array {
            format!("{name}[{element}]")
        } else {
            name.to_owned()
        };
        if of == control {
            // A parameter that is an alias stands where its target does.
            if places.iter().all(|(known, _)| *known != at) {
                places.push((at, name));
            }
            continue;
        }
        for member in &template.members {
            if matches!(member.data_type, DataType::Structure(_)) {
                let inner = format!("{name}.{}", member.name);
                controls_in(
                    &member.data_type,
                    at + member.offset,
                    &inner,
                    control,
                    &[u32::from(member.dimension)],
                    places,
                );
            }
        }
    }
}

/// Motion control structures of one tag.
const MAX_CONTROLS: usize = 1024;
