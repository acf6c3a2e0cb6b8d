//! References: from a name with members, subscripts and bits to a place in the memory.

use arcline_tag::{DataType, Elementary, TagType};

use super::{Compiler, Owner, Wrong};
use crate::code::{Area, Bit, Ex, Index, Place, Select};
use crate::expression::{Expression, Step, TagReference};
use crate::memory::Symbol;
use crate::source::Usage;

/// The target of a reference.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) base: u8,
    pub(crate) at: u32,
    pub(crate) index: Vec<Index>,
    pub(crate) data_type: DataType,
    /// Dimensions that have no subscript.
    pub(crate) dimensions: [u32; 3],
    pub(crate) bit: Option<Select>,
    length: u32,
    array: [u32; 3],
    skipped: u32,
    inner: usize,
    end: u32,
    /// Bits of an array of BOOLs.
    pub(crate) bits: Option<u32>,
    /// Whether the array is a parameter by reference, of whose operand the sizes are.
    pub(crate) is_of_operand: bool,
}

impl Found {
    pub(crate) fn place(&self) -> Place {
        Place {
            base: self.base,
            at: self.at,
            index: self.index.clone().into(),
        }
    }

    pub(crate) fn is_array(&self) -> bool {
        self.dimensions[0] > 0
    }

    pub(crate) fn area(&self) -> Area {
        Area {
            place: self.place(),
            size: self.data_type.size() as u32,
            data_type: self.data_type.clone(),
            length: self.length,
            dimensions: self.array,
            is_of_operand: self.is_of_operand,
            is_whole: self.is_array(),
            skipped: self.skipped,
            inner: self.inner,
            end: self.end,
        }
    }

    /// The words of an array of BOOLs from an element on that begins one.
    pub(crate) fn words(&self) -> Result<Area, Wrong> {
        match &self.bit {
            Some(Select::Mask(1)) if self.skipped.is_multiple_of(4) => Ok(Area {
                data_type: Elementary::Dword.into(),
                size: 4,
                ..self.area()
            }),
            Some(Select::Mask(_)) => Err("begins no word of 32 BOOLs".into()),
            _ => Err("is a BOOL by a subscript that is calculated, expected one that begins a word of 32 BOOLs".into()),
        }
    }

    pub(crate) fn as_bit(&self) -> Option<Bit> {
        let select = match (&self.bit, &self.data_type) {
            (Some(select), _) => select.clone(),
            (None, DataType::Elementary(Elementary::Bool)) if !self.is_array() => Select::Mask(1),
            _ => return None,
        };
        Some(Bit {
            place: self.place(),
            select,
        })
    }
}

impl Compiler<'_> {
    /// Resolves a reference in the scope of the present routine.
    pub(crate) fn resolve(&mut self, reference: &TagReference) -> Result<Found, Wrong> {
        let program = match self.owner {
            Owner::Program(program) => Some(program),
            Owner::AddOn(_) => None,
        };
        if let (Owner::AddOn(add_on), None) = (self.owner, &reference.program) {
            let found = self.parameter(add_on, &reference.name)?;
            return self.walk(found, &reference.steps);
        }
        self.resolve_in(program, reference, 0)
    }

    fn resolve_in(&mut self, program: Option<usize>, reference: &TagReference, depth: usize) -> Result<Found, Wrong> {
        let scope = match &reference.program {
            None => program,
            Some(name) => {
                let place = self
                    .project
                    .programs
                    .iter()
                    .position(|one| one.name.eq_ignore_ascii_case(name));
                Some(place.ok_or_else(|| Wrong::absent(format!("there is no program {name}")))?)
            }
        };
        let name = reference.name.to_ascii_lowercase();
        let local = scope.and_then(|place| self.tags.programs.get(place)?.get(&name).cloned());
        let found = local.map(|symbol| (symbol, scope));
        let found = found.or_else(|| Some((self.tags.controller.get(&name).cloned()?, None)));
        let Some((symbol, scope)) = found else {
            return Err(Wrong::absent(format!("there is no tag {}", reference.name)));
        };
        match symbol {
            Symbol::Tag(number) => {
                let tag = self.tags.list.get(number).ok_or("there is no such tag")?;
                let found = start(0, tag.at, &tag.tag_type, tag.bits);
                self.walk(found, &reference.steps)
            }
            Symbol::Alias(text) => {
                if depth > MAX_ALIASES {
                    return Err(format!("{} is an alias of itself", reference.name).into());
                }
                let text = text
                    .strip_prefix("Program:")
                    .map_or_else(|| text.clone(), |rest| format!("\\{rest}"));
                let mut base = Expression::parse_reference(&text).map_err(|error| format!("alias {text}: {error}"))?;
                base.steps.extend(reference.steps.iter().cloned());
                self.resolve_in(scope, &base, depth + 1)
            }
        }
    }

    /// A parameter or local tag of an add-on instruction.
    fn parameter(&mut self, add_on: usize, name: &str) -> Result<Found, Wrong> {
        let project = self.project;
        let definition = project.instructions.get(add_on).ok_or("there is no such instruction")?;
        let mut base = 2_u8;
        for parameter in definition.parameters.iter().filter(|one| one.usage == Usage::InOut) {
            let member = &parameter.member;
            if member.name.eq_ignore_ascii_case(name) {
                let tag_type = self.types.tag_type(&member.data_type, &member.dimensions);
                let tag_type = tag_type.or_else(|| motion_type(&member.data_type));
                let tag_type = tag_type.ok_or_else(|| unknown(&member.data_type))?;
                let is_bool = member.data_type.eq_ignore_ascii_case("BOOL") && !member.dimensions.is_empty();
                let bits = is_bool.then(|| member.dimensions.iter().product());
                let mut found = start(base, 0, &tag_type, bits);
                found.is_of_operand = found.is_array();
                if tag_type == TagType::scalar(Elementary::Bool) {
                    found.bit = Some(Select::Referenced);
                }
                return Ok(found);
            }
            base = base.saturating_add(1);
        }
        if let Some(parameter) = definition
            .parameters
            .iter()
            .find(|one| one.member.name.eq_ignore_ascii_case(name))
            && let Some(alias) = &parameter.alias
        {
            let reference = Expression::parse_reference(alias).map_err(|error| error.to_string())?;
            let found = self.parameter(add_on, &reference.name)?;
            return self.walk(found, &reference.steps);
        }
        let Some(DataType::Structure(template)) = self.types.data_type(&definition.name) else {
            return Err(unknown(&definition.name));
        };
        let member = template
            .member(name)
            .ok_or_else(|| Wrong::absent(format!("{} has no parameter or local tag {name}", definition.name)))?;
        let sources = definition
            .parameters
            .iter()
            .map(|one| &one.member)
            .chain(definition.locals.iter().map(|(one, _)| one));
        let source = sources.into_iter().find(|one| one.name.eq_ignore_ascii_case(name));
        let mut tag_type = TagType {
            data_type: member.data_type.clone(),
            dimensions: [u32::from(member.dimension), 0, 0],
        };
        let mut bits = None;
        if let Some(source) = source.filter(|one| !one.dimensions.is_empty()) {
            if source.data_type.eq_ignore_ascii_case("BOOL") {
                bits = Some(source.dimensions.iter().product());
            } else {
                for (size, dimension) in tag_type.dimensions.iter_mut().zip(&source.dimensions) {
                    *size = *dimension;
                }
            }
        }
        let mut found = start(1, member.offset, &tag_type, bits);
        found.bit = member.bit.map(|bit| Select::Mask(1 << bit));
        Ok(found)
    }

    fn walk(&mut self, mut found: Found, steps: &[Step]) -> Result<Found, Wrong> {
        for step in steps {
            match step {
                Step::Member(name) => {
                    let DataType::Structure(template) = &found.data_type else {
                        return Err(no_member(found.data_type.name(), name));
                    };
                    if found.is_array() || found.bit.is_some() {
                        return Err(format!("an array has no member {name}").into());
                    }
                    let template = template.clone();
                    let Some(member) = template.member(name) else {
                        return Err(no_member(&template.name, name));
                    };
                    found.at += member.offset;
                    found.bit = member.bit.map(|bit| Select::Mask(1 << bit));
                    found.data_type = member.data_type.clone();
                    found.dimensions = [u32::from(member.dimension), 0, 0];
                    found.array = found.dimensions;
                    found.length = u32::from(member.dimension).max(1);
                    (found.skipped, found.inner) = (0, 0);
                    found.is_of_operand = false;
                    let is_word = member.data_type == DataType::Elementary(Elementary::Dword);
                    found.bits = (is_word && member.dimension > 0).then(|| 32 * u32::from(member.dimension));
                }
                Step::Index(values) => self.subscript(&mut found, values)?,
                Step::Bit(bit) => {
                    let bits = self.bits_of(&found)?;
                    let bit = u32::try_from(*bit).ok().filter(|bit| *bit < bits);
                    let bit = bit.ok_or_else(|| format!("{} has {bits} bits", found.data_type.name()))?;
                    found.at += bit / 8;
                    found.bit = Some(Select::Mask(1 << (bit % 8)));
                }
                Step::BitAt(value) => {
                    let bits = self.bits_of(&found)?;
                    let text = self.text(&value.to_string());
                    let value = self.whole(value)?;
                    found.bit = Some(Select::Number {
                        value,
                        bits: Some(bits),
                        text,
                        fault: 83,
                    });
                }
            }
        }
        Ok(found)
    }

    fn bits_of(&self, found: &Found) -> Result<u32, Wrong> {
        match &found.data_type {
            DataType::Elementary(kind) if found.bit.is_none() && !found.is_array() && !kind.is_real() => {
                Ok(8 * kind.size() as u32)
            }
            other => Err(format!("{} has no bits", other.name()).into()),
        }
    }

    fn subscript(&mut self, found: &mut Found, values: &[Expression]) -> Result<(), Wrong> {
        let rank = found.dimensions.iter().take_while(|size| **size > 0).count();
        if rank == 0 {
            return Err(format!("{} is not an array", found.data_type.name()).into());
        }
        if values.len() != rank {
            return Err(format!("{} subscripts, expected {rank}", values.len()).into());
        }
        if let (Some(bits), [value]) = (found.bits, values) {
            found.dimensions = [0; 3];
            found.data_type = Elementary::Bool.into();
            if let Expression::Integer(bit) = value {
                let bit = u32::try_from(*bit).ok().filter(|bit| *bit < bits);
                let bit = bit.ok_or_else(|| format!("subscript {value}, the array has {bits} bits"))?;
                found.at += bit / 8;
                found.skipped += bit / 8;
                found.bit = Some(Select::Mask(1 << (bit % 8)));
            } else {
                let text = self.text(&value.to_string());
                let value = self.whole(value)?;
                found.bit = Some(Select::Number {
                    value,
                    bits: (!found.is_of_operand).then_some(bits),
                    text,
                    fault: 20,
                });
            }
            return Ok(());
        }
        let size = found.data_type.size() as u32;
        let mut stride = size;
        let mut strides = [0; 3];
        for (place, dimension) in found.dimensions.iter().enumerate().take(rank).rev() {
            strides[place] = stride;
            stride = stride.saturating_mul(*dimension);
        }
        for (place, ((value, dimension), stride)) in values.iter().zip(found.dimensions).zip(strides).enumerate() {
            if let Expression::Integer(number) = value {
                let number = u32::try_from(*number).ok().filter(|number| *number < dimension);
                let number = number.ok_or_else(|| format!("subscript {value}, the array has {dimension} elements"))?;
                // Only the last dimension has the same stride in every operand.
                if !found.is_of_operand || place + 1 == rank {
                    found.at += number * stride;
                    found.skipped += number * stride;
                    continue;
                }
            }
            let text = self.text(&value.to_string());
            let value = self.whole(value)?;
            found.index.push(Index {
                value,
                size: dimension,
                stride: if found.is_of_operand { size } else { stride },
                of_operand: found.is_of_operand.then_some(place as u8),
                text,
            });
            found.inner += 1;
        }
        found.dimensions = [0; 3];
        Ok(())
    }

    /// A whole number.
    pub(crate) fn whole(&mut self, expression: &Expression) -> Result<Ex, Wrong> {
        let (value, sort) = self.number(expression, super::expression::Sort::Whole)?;
        Ok(super::expression::cast(value, sort, super::expression::Sort::Whole))
    }
}

fn unknown(data_type: &str) -> Wrong {
    Wrong::absent(format!("the type {data_type} is not known"))
}

fn no_member(data_type: &str, name: &str) -> Wrong {
    Wrong::absent(format!("{data_type} has no member {name}"))
}

/// The beginning of a tag.
fn start(base: u8, at: u32, tag_type: &TagType, bits: Option<u32>) -> Found {
    Found {
        base,
        at,
        index: Vec::new(),
        data_type: tag_type.data_type.clone(),
        dimensions: tag_type.dimensions,
        bit: None,
        length: tag_type.elements(),
        array: tag_type.dimensions,
        skipped: 0,
        inner: 0,
        end: at + tag_type.size() as u32,
        bits,
        is_of_operand: false,
    }
}

/// Types of motion objects that a parameter names with another word than the machine.
fn motion_type(name: &str) -> Option<TagType> {
    use arcline_instruction_set::predefined;
    let is_axis = name.len() > 5 && name.get(..5).is_some_and(|head| head.eq_ignore_ascii_case("AXIS_"));
    is_axis.then(|| TagType::scalar(predefined::axis_cip_drive()))
}

/// Aliases of aliases.
const MAX_ALIASES: usize = 16;
