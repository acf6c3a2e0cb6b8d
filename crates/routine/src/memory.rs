//! The memory of a project: where each tag stands in it, and its first bytes.

use std::collections::BTreeMap;

use arcline_tag::{DataType, Elementary, Member, TagType, Template, TemplateBuilder};

use crate::Expression;
use crate::error::{Finding, FindingKind};
use crate::source::{Access, Datum, InstructionSource, Project, TagSource, Usage, is_module};
use crate::types::{Types, text_layout};

/// A tag and its place in the memory.
#[derive(Clone, PartialEq, Debug)]
pub struct Tag {
    /// Its name.
    pub name: String,
    /// The program in whose scope it is.
    pub program: Option<String>,
    /// Its type.
    pub tag_type: TagType,
    /// The access of clients.
    pub access: Access,
    /// Its first byte.
    pub at: u32,
    /// Bits of an array of BOOLs, whose words may have more.
    pub(crate) bits: Option<u32>,
}

impl Tag {
    /// Bits of an array of BOOLs; `None`: it is none.
    pub fn bits(&self) -> Option<u32> {
        self.bits
    }

    /// Its name with its program: `Program:Main.X`.
    pub fn full_name(&self) -> String {
        match &self.program {
            Some(program) => format!("Program:{program}.{}", self.name),
            None => self.name.clone(),
        }
    }
}

/// The meaning of a name in a scope.
#[derive(Clone, Debug)]
pub(crate) enum Symbol {
    /// Index of a tag.
    Tag(usize),
    /// Another name for a part of a tag, as the file writes it.
    Alias(String),
}

/// Names of a scope, in lower case.
pub(crate) type Scope = BTreeMap<String, Symbol>;

/// The tags of a project.
#[derive(Debug, Default)]
pub(crate) struct Tags {
    pub(crate) list: Vec<Tag>,
    pub(crate) controller: Scope,
    /// The scopes by program, in the order of the project.
    pub(crate) programs: Vec<Scope>,
    pub(crate) bytes: Vec<u8>,
}

impl Tags {
    /// Places every tag; `object` knows the types of the machine's axes and coordinate systems.
    pub(crate) fn new(
        project: &Project,
        types: &mut Types,
        object: &dyn Fn(&str) -> Option<TagType>,
        findings: &mut Vec<Finding>,
    ) -> Self {
        let mut tags = Tags::default();
        let definitions: BTreeMap<String, &InstructionSource> = project
            .instructions
            .iter()
            .map(|one| (one.name.to_ascii_lowercase(), one))
            .collect();
        for source in &project.tags {
            if let Some(symbol) = tags.add(source, None, types, object, &definitions, findings) {
                tags.controller.insert(source.name.to_ascii_lowercase(), symbol);
            }
        }
        for program in &project.programs {
            let mut scope = Scope::new();
            for source in &program.tags {
                if let Some(symbol) = tags.add(source, Some(&program.name), types, object, &definitions, findings) {
                    scope.insert(source.name.to_ascii_lowercase(), symbol);
                }
            }
            tags.programs.push(scope);
        }
        tags
    }

    fn add(
        &mut self,
        source: &TagSource,
        program: Option<&str>,
        types: &mut Types,
        object: &dyn Fn(&str) -> Option<TagType>,
        definitions: &BTreeMap<String, &InstructionSource>,
        findings: &mut Vec<Finding>,
    ) -> Option<Symbol> {
        if let Some(alias) = &source.alias {
            return Some(Symbol::Alias(alias.clone()));
        }
        if is_module(&source.data_type) {
            return None;
        }
        let of_machine = program.is_none().then(|| object(&source.name)).flatten();
        let found = of_machine.or_else(|| types.tag_type(&source.data_type, &source.dimensions));
        let tag_type = match found {
            Some(tag_type) => tag_type,
            None => match source
                .value
                .as_ref()
                .filter(|_| source.is_module)
                .and_then(|datum| module_type(types, &source.data_type, datum))
            {
                Some(template) => TagType::scalar(template),
                None => {
                    findings.push(Finding {
                        kind: FindingKind::Type,
                        name: source.data_type.clone(),
                        reason: String::new(),
                        program: program.map(str::to_owned),
                        routine: None,
                        place: None,
                    });
                    return None;
                }
            },
        };
        let size = tag_type.size();
        let at = self.bytes.len().next_multiple_of(8);
        if at.saturating_add(size) > MAX_MEMORY {
            findings.push(Finding {
                kind: FindingKind::Error,
                name: source.name.clone(),
                reason: format!("the tags need more than {MAX_MEMORY} bytes"),
                program: program.map(str::to_owned),
                routine: None,
                place: None,
            });
            return None;
        }
        self.bytes.resize(at + size, 0);
        let bytes = self.bytes.get_mut(at..at + size).unwrap_or_default();
        first_values(&tag_type, bytes, definitions);
        if let Some(value) = &source.value {
            fill(bytes, &tag_type.data_type, tag_type.dimensions[0] > 0, value);
        }
        for (name, value) in &source.attributes {
            if let DataType::Structure(template) = &tag_type.data_type
                && let Some(member) = template.member(name)
            {
                fill_member(bytes, member, &Datum::Number(value.clone()));
            }
        }
        let is_bool = source.data_type.eq_ignore_ascii_case("BOOL");
        let bits = (is_bool && !source.dimensions.is_empty()).then(|| source.dimensions.iter().product());
        self.list.push(Tag {
            name: source.name.clone(),
            program: program.map(str::to_owned),
            tag_type,
            access: source.access,
            at: at as u32,
            bits,
        });
        Some(Symbol::Tag(self.list.len() - 1))
    }
}

/// The first values of instances: those of the definitions' parameters and local tags.
fn first_values(tag_type: &TagType, bytes: &mut [u8], definitions: &BTreeMap<String, &InstructionSource>) {
    let size = tag_type.data_type.size();
    if size == 0 {
        return;
    }
    for element in bytes.chunks_exact_mut(size) {
        instance_values(&tag_type.data_type, element, definitions, 0);
    }
}

fn instance_values(
    data_type: &DataType,
    bytes: &mut [u8],
    definitions: &BTreeMap<String, &InstructionSource>,
    depth: usize,
) {
    let DataType::Structure(template) = data_type else {
        return;
    };
    if depth > MAX_DEPTH {
        return;
    }
    for member in &template.members {
        let size = member.data_type.size();
        if matches!(member.data_type, DataType::Structure(_)) && size > 0 {
            let from = member.offset as usize;
            let part = bytes.get_mut(from..from + member.size()).unwrap_or_default();
            for element in part.chunks_exact_mut(size) {
                instance_values(&member.data_type, element, definitions, depth + 1);
            }
        }
    }
    let Some(definition) = definitions.get(&template.name.to_ascii_lowercase()) else {
        return;
    };
    let parameters = definition.parameters.iter().filter(|one| one.usage != Usage::InOut);
    let values = parameters.map(|one| (&one.member.name, &one.value));
    let locals = definition.locals.iter().map(|(member, value)| (&member.name, value));
    for (name, value) in values.chain(locals) {
        if let (Some(member), Some(value)) = (template.member(name), value) {
            fill_member(bytes, member, value);
        }
    }
}

fn fill_member(bytes: &mut [u8], member: &Member, value: &Datum) {
    let from = member.offset as usize;
    if let Some(bit) = member.bit {
        if let (Some(byte), Datum::Number(text)) = (bytes.get_mut(from), plain(value)) {
            let mask = 1 << bit;
            *byte = if number(text).0 != 0 {
                *byte | mask
            } else {
                *byte & !mask
            };
        }
        return;
    }
    if let Some(part) = bytes.get_mut(from..from + member.size()) {
        fill(part, &member.data_type, member.dimension > 0, value);
    }
}

fn plain(value: &Datum) -> &Datum {
    match value {
        Datum::Typed(_, inner) => inner,
        value => value,
    }
}

/// Writes a first value to the bytes of a type.
fn fill(bytes: &mut [u8], data_type: &DataType, is_array: bool, value: &Datum) {
    let size = data_type.size().max(1);
    match (plain(value), data_type) {
        (Datum::Array(items), DataType::Elementary(Elementary::Dword)) => {
            for (place, item) in items.iter().enumerate() {
                if let (Datum::Number(text), Some(byte)) = (plain(item), bytes.get_mut(place / 8)) {
                    *byte |= u8::from(number(text).0 != 0) << (place % 8);
                }
            }
        }
        (Datum::Array(items), _) => {
            for (item, part) in items.iter().zip(bytes.chunks_exact_mut(size)) {
                fill(part, data_type, false, item);
            }
        }
        (Datum::Number(text), DataType::Elementary(kind)) => {
            let (whole, real) = number(text);
            let le = whole.to_le_bytes();
            match kind {
                Elementary::Real => put(bytes, &(real as f32).to_le_bytes()),
                Elementary::Lreal => put(bytes, &real.to_le_bytes()),
                Elementary::Bool => put(bytes, &[u8::from(whole != 0)]),
                kind => put(bytes, le.get(..kind.size()).unwrap_or_default()),
            }
        }
        (Datum::Text(text), DataType::Structure(_)) => {
            if let Some((data, capacity)) = text_layout(data_type) {
                let length = text.len().min(capacity as usize);
                put(bytes, &(length as i32).to_le_bytes());
                let from = data as usize;
                put(
                    bytes.get_mut(from..).unwrap_or_default(),
                    text.get(..length).unwrap_or_default(),
                );
            }
        }
        (Datum::Text(text), DataType::Elementary(Elementary::Sint)) if is_array => {
            let length = text.len().min(bytes.len());
            put(bytes, text.get(..length).unwrap_or_default());
        }
        (Datum::Structure(_, members), DataType::Structure(template)) => {
            for (name, value) in members {
                if let Some(member) = template.member(name) {
                    fill_member(bytes, member, value);
                }
            }
        }
        _ => {}
    }
}

fn put(bytes: &mut [u8], value: &[u8]) {
    if let Some(place) = bytes.get_mut(..value.len()) {
        place.copy_from_slice(value);
    }
}

/// A number of the file as a whole number and as one with a point.
pub(crate) fn number(text: &str) -> (i64, f64) {
    let text = text.trim();
    if text.eq_ignore_ascii_case("true") {
        return (1, 1.0);
    }
    let constant = |expression: &Expression| match expression {
        Expression::Integer(value) => Some((*value, *value as f64)),
        Expression::Real(value) => Some((value.round_ties_even() as i64, *value)),
        // Radix ASCII: the first character is the highest byte.
        Expression::Text(bytes) => {
            let whole = bytes.iter().fold(0_i64, |value, byte| value << 8 | i64::from(*byte));
            Some((whole, whole as f64))
        }
        _ => None,
    };
    match Expression::parse(text) {
        Ok(Expression::Unary(crate::Unary::Negate, inner)) => {
            constant(&inner).map_or((0, 0.0), |(whole, real)| (whole.wrapping_neg(), -real))
        }
        Ok(expression) => constant(&expression).unwrap_or_default(),
        Err(_) => (0, 0.0),
    }
}

/// The type of a module's tag, whose members its first value names with their types.
fn module_type(types: &mut Types, name: &str, datum: &Datum) -> Option<std::sync::Arc<Template>> {
    let Datum::Structure(_, members) = datum else {
        return None;
    };
    let name = if name.is_empty() { "Module" } else { name };
    let mut parts = Vec::new();
    for (member, value) in members {
        let (data_type, count): (DataType, u16) = match value {
            Datum::Structure(inner, _) => (DataType::Structure(module_type(types, inner, value)?), 0),
            Datum::Typed(kind, inner) => {
                let data_type = types.data_type(kind)?;
                match &**inner {
                    Datum::Array(items) => (data_type, u16::try_from(items.len()).ok()?),
                    _ => (data_type, 0),
                }
            }
            _ => return None,
        };
        parts.push((member, data_type, count));
    }
    let mut builder = TemplateBuilder::new(name, types.instance());
    for (member, data_type, count) in parts {
        builder = if count == 0 {
            builder.member(member, data_type)
        } else {
            builder.array(member, data_type, count)
        };
    }
    let template = builder.build();
    types.add(template.clone());
    Some(template)
}

/// Most bytes of all tags.
const MAX_MEMORY: usize = 256 << 20;
/// Structures within one another.
const MAX_DEPTH: usize = 32;
