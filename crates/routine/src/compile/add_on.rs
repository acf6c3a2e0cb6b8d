//! Add-on instructions (spec/programs.md §13): compiled once, called with the instance and references as bases.

use arcline_tag::{DataType, Elementary, elements_of};

use super::operand::parse;
use super::reference::Found;
use super::{Compiler, Owner, Wrong};
use crate::code::{AddOn, AddOnCall, Argument, Cellular, Copy, Ex, Place, Referenced, Select, Sizes};
use crate::expression::{Expression, TagReference};
use crate::source::{MemberSource, Usage, is_module};

impl Compiler<'_> {
    pub(crate) fn add_on(&mut self, number: usize) -> AddOn {
        let Some(definition) = self.project.instructions.get(number) else {
            return AddOn::default();
        };
        let id = |name: &str| self.routines.get(&(Owner::AddOn(number), name.to_owned())).copied();
        let mut add_on = AddOn {
            logic: id("logic"),
            prescan: id("prescan").filter(|_| definition.has_prescan),
            enable_in_false: id("enableinfalse").filter(|_| definition.has_enable_in_false),
            ..AddOn::default()
        };
        if let Some(DataType::Structure(template)) = self.types.data_type(&definition.name) {
            let bit = |name: &str| {
                template
                    .member(name)
                    .and_then(|member| Some((member.offset, 1 << member.bit?)))
            };
            add_on.enable_in = bit("EnableIn").unwrap_or_default();
            add_on.enable_out = bit("EnableOut").unwrap_or_default();
        }
        add_on
    }

    /// A call of an add-on instruction; `None`: it is none.
    pub(crate) fn add_on_call(&mut self, name: &str, operands: &[&str]) -> Result<Option<AddOnCall>, Wrong> {
        let project = self.project;
        let Some(number) = project
            .instructions
            .iter()
            .position(|one| one.name.eq_ignore_ascii_case(name))
        else {
            return Ok(None);
        };
        let definition = project.instructions.get(number).ok_or("there is no such instruction")?;
        let (instance, rest) = operands.split_first().ok_or("expected the instance")?;
        let area = self.area_of(instance).map_err(|reason| reason.of(instance))?;
        if !area.data_type.name().eq_ignore_ascii_case(&definition.name) || area.is_whole {
            return Err(format!("{instance} is {}, expected {}", area.data_type.name(), definition.name).into());
        }
        let required = definition
            .parameters
            .iter()
            .filter(|one| one.is_required || one.usage == Usage::InOut);
        let required: Vec<_> = required.collect();
        if rest.len() != required.len() {
            return Err(format!("{} parameters, expected {}", rest.len(), required.len()).into());
        }
        let DataType::Structure(template) = area.data_type.clone() else {
            return Ok(None);
        };
        let (mut inputs, mut outputs, mut references) = (Vec::new(), Vec::new(), Vec::new());
        for (parameter, text) in required.into_iter().zip(rest) {
            let wrong = |reason: Wrong| reason.of(format_args!("{} {text}", parameter.member.name));
            if parameter.usage == Usage::InOut {
                let (reference, literal) = self.referenced(&parameter.member, text).map_err(wrong)?;
                references.push(reference);
                inputs.extend(literal);
                continue;
            }
            let Some(member) = template.member(&parameter.member.name) else {
                return Err(wrong("has no place in the instance".into()));
            };
            let place = Place {
                base: 1,
                at: member.offset,
                index: Box::default(),
            };
            let inner = match (member.bit, &member.data_type) {
                (Some(bit), _) => Argument::Bit(crate::code::Bit {
                    place,
                    select: Select::Mask(1 << bit),
                }),
                (None, DataType::Elementary(kind)) => Argument::Target(Cellular { place, kind: *kind }),
                (None, DataType::Structure(_)) => return Err(wrong("structures are passed by reference".into())),
            };
            // An operand that is left out keeps the parameter's value.
            if text.is_empty() || *text == "?" {
                continue;
            }
            match parameter.usage {
                // The operand of an output that nothing takes.
                Usage::Output if parse(text)? == Expression::Integer(0) => {}
                Usage::Input => {
                    let from = self.value(&parse(text)?).map_err(wrong)?;
                    inputs.push(Copy { from, to: inner });
                }
                _ => {
                    let to = self.target(&parse(text)?).map_err(wrong)?;
                    let from = match inner {
                        Argument::Bit(bit) => Argument::Integer(Ex::Bit(Box::new(bit))),
                        Argument::Target(cell) if cell.kind.is_real() => Argument::Real(Ex::Load(Box::new(cell))),
                        Argument::Target(cell) => Argument::Integer(Ex::Load(Box::new(cell))),
                        other => other,
                    };
                    outputs.push(Copy { from, to });
                }
            }
        }
        Ok(Some(AddOnCall {
            definition: number as u32,
            instance: area.place,
            size: area.size,
            inputs: inputs.into(),
            outputs: outputs.into(),
            references: references.into(),
        }))
    }

    /// The place that a call gives for a parameter by reference, and the value that stands there before each call when it is a literal.
    fn referenced(&mut self, parameter: &MemberSource, text: &str) -> Result<(Referenced, Option<Copy>), Wrong> {
        let reference = match parse(text)? {
            Expression::Reference(reference) => reference,
            literal => return self.literal(parameter, &literal),
        };
        if is_module(&parameter.data_type) {
            return match self.names_module(&reference) {
                true => Ok((Referenced::nothing(), None)),
                false => Err("is no module".into()),
            };
        }
        self.referenced_tag(parameter, &reference).map(|one| (one, None))
    }

    /// A literal has a place of its own, which no tag names: 0 stands for data of any type.
    fn literal(&mut self, parameter: &MemberSource, literal: &Expression) -> Result<(Referenced, Option<Copy>), Wrong> {
        let tag_type = self.types.tag_type(&parameter.data_type, &parameter.dimensions);
        let tag_type = tag_type.ok_or("expected a tag")?;
        let kind = match tag_type.data_type {
            DataType::Elementary(kind) if parameter.dimensions.is_empty() => Some(kind),
            _ if *literal == Expression::Integer(0) => None,
            _ => return Err("expected a tag".into()),
        };
        let from = match self.value(literal)? {
            from @ (Argument::Integer(Ex::Integer(_)) | Argument::Real(Ex::Real(_))) => from,
            _ => return Err("expected a tag".into()),
        };
        let (at, size) = (self.tags.bytes.len().next_multiple_of(8), tag_type.size());
        self.tags.bytes.resize(at + size.max(8), 0);
        let place = Place {
            base: 0,
            at: at as u32,
            index: Box::default(),
        };
        let reference = Referenced {
            place: place.clone(),
            bit: (kind == Some(Elementary::Bool)).then_some(Select::Mask(1)),
            sizes: Some(Sizes {
                dimensions: tag_type.dimensions,
                bits: parameter.dimensions.first().copied().unwrap_or_default(),
                bytes: size as u32,
            }),
        };
        let copy = kind.map(|kind| Copy {
            from,
            to: Argument::Target(Cellular { place, kind }),
        });
        Ok((reference, copy))
    }

    /// Whether a name is that of a module, of a parameter by reference that is one, or of a tag of their type.
    fn names_module(&self, reference: &TagReference) -> bool {
        let (project, name) = (self.project, &reference.name);
        if !reference.steps.is_empty() {
            return false;
        }
        let tags = match self.owner {
            Owner::AddOn(number) => {
                let parameters = project.instructions.get(number).map(|one| one.parameters.as_slice());
                let mut parameters = parameters.unwrap_or_default().iter();
                return parameters
                    .any(|one| one.member.name.eq_ignore_ascii_case(name) && is_module(&one.member.data_type));
            }
            Owner::Program(number) => project.programs.get(number).map(|one| one.tags.as_slice()),
        };
        let mut tags = tags.unwrap_or_default().iter().chain(&project.tags);
        project.modules.iter().any(|one| one.eq_ignore_ascii_case(name))
            || tags.any(|one| one.name.eq_ignore_ascii_case(name) && is_module(&one.data_type))
    }

    fn referenced_tag(&mut self, parameter: &MemberSource, reference: &TagReference) -> Result<Referenced, Wrong> {
        let found = self.resolve(reference)?;
        let place = found.place();
        if parameter.data_type.eq_ignore_ascii_case("BOOL") && parameter.dimensions.is_empty() {
            let bit = found
                .as_bit()
                .ok_or_else(|| format!("is {}, expected BOOL", found.data_type.name()))?;
            return Ok(Referenced {
                place,
                bit: Some(bit.select),
                sizes: Some(Sizes {
                    bytes: 1,
                    ..Sizes::default()
                }),
            });
        }
        check_type(&parameter.data_type, &found)?;
        check_size(parameter, &found)?;
        if let Some(at) = place.fixed()
            && matches!(found.data_type, DataType::Structure(_))
        {
            self.share_if_motion(&found.data_type, at);
        }
        let sizes = Sizes {
            dimensions: found.dimensions,
            bits: found.bits.unwrap_or_default(),
            bytes: elements_of(&found.dimensions) * found.data_type.size() as u32,
        };
        Ok(Referenced {
            place,
            bit: None,
            sizes: (!found.is_of_operand).then_some(sizes),
        })
    }

    fn share_if_motion(&mut self, data_type: &DataType, at: u32) {
        if matches!(
            data_type.name(),
            "PATH_DATA" | "DYNAMICS_DATA" | "POSITION_DATA" | "CAM" | "CAM_PROFILE"
        ) {
            self.share_at(at);
        }
    }
}

/// A parameter by reference takes data of its own type; any axis for any type of axis.
fn check_type(expected: &str, found: &Found) -> Result<(), Wrong> {
    let is_axis = |name: &str| name.to_ascii_uppercase().starts_with("AXIS_");
    let name = found.data_type.name();
    let same = name.eq_ignore_ascii_case(expected)
        || (is_axis(name) && is_axis(expected))
        || (name == "DWORD" && expected.eq_ignore_ascii_case("BOOL"));
    if found.bit.is_some() {
        Err(format!("is a bit, expected {expected}").into())
    } else if same {
        Ok(())
    } else {
        Err(format!("is {name}, expected {expected}").into())
    }
}

/// An array by reference takes an array of as many dimensions that is as long as its definition or longer (spec/programs.md §13).
fn check_size(parameter: &MemberSource, found: &Found) -> Result<(), Wrong> {
    let (expected, name) = (&parameter.dimensions, &parameter.data_type);
    let rank = found.dimensions.iter().take_while(|size| **size > 0).count();
    match (expected.len(), rank) {
        (0, 0) => return Ok(()),
        (0, _) => return Err(format!("is an array, expected one {name}").into()),
        (_, 0) => return Err(format!("is one {name}, expected an array").into()),
        (expected, rank) if expected != rank => {
            return Err(format!("has {rank} dimensions, expected {expected}").into());
        }
        _ => {}
    }
    let given = match found.bits {
        Some(bits) => [bits, 0, 0],
        None => found.dimensions,
    };
    match expected.iter().zip(given).find(|(expected, given)| *given < **expected) {
        Some((expected, given)) => Err(format!("has {given} elements, expected {expected} or more").into()),
        None => Ok(()),
    }
}
