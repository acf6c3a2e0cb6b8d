//! The memory of a project: where each tag stands in it, and its first bytes.

mod values;

pub(crate) use values::{for_each_structure, number};

use std::collections::BTreeMap;

use arcline_tag::{DataType, TagType, Template, TemplateBuilder};

use self::values::{Definitions, FirstValues};
use crate::error::{Finding, FindingKind};
use crate::source::{Access, Datum, Project, TagSource, is_module};
use crate::types::Types;

/// Writes the first values of the definitions of add-on instructions to an instance.
pub(crate) fn first_values_of_instance(project: &Project, data_type: &DataType, bytes: &mut [u8]) {
    FirstValues::new(&definitions(project)).instances(&TagType::scalar(data_type.clone()), bytes);
}

fn definitions(project: &Project) -> Definitions<'_> {
    let all = project.instructions.iter();
    all.map(|one| (one.name.to_ascii_lowercase(), one)).collect()
}

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
    /// The file has its first value.
    pub(crate) has_value: bool,
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
        let definitions = definitions(project);
        for source in &project.tags {
            if let Some(symbol) = tags.add(source, None, types, object, &definitions, findings) {
                tags.controller.insert(source.name.to_ascii_lowercase(), symbol);
            }
        }
        for program in &project.programs {
            let mut scope = Scope::new();
            for source in &program.tags {
                if let Some(symbol) = tags.add(source, Some(&program.name), types, object, &definitions, findings) {
                    // An alias of the controller's tag of the same name.
                    let of_controller = source
                        .alias
                        .as_ref()
                        .filter(|alias| alias.eq_ignore_ascii_case(&source.name))
                        .and_then(|alias| tags.controller.get(&alias.to_ascii_lowercase()).cloned());
                    let symbol = of_controller.unwrap_or(symbol);
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
        definitions: &Definitions<'_>,
        findings: &mut Vec<Finding>,
    ) -> Option<Symbol> {
        let finding = |kind, name: &str, reason: String| Finding {
            program: program.map(str::to_owned),
            ..Finding::new(kind, name, reason)
        };
        if let Some(alias) = &source.alias {
            return Some(Symbol::Alias(alias.clone()));
        }
        if is_module(&source.data_type) {
            return None;
        }
        let of_machine = program.is_none().then(|| object(&source.name)).flatten();
        let is_of_machine = of_machine.is_some();
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
                    findings.push(finding(FindingKind::Type, &source.data_type, String::new()));
                    return None;
                }
            },
        };
        let size = tag_type.size();
        let at = self.bytes.len().next_multiple_of(8);
        if at.saturating_add(size) > MAX_MEMORY {
            let reason = format!("the tags need more than {MAX_MEMORY} bytes");
            findings.push(finding(FindingKind::Error, &source.name, reason));
            return None;
        }
        self.bytes.resize(at + size, 0);
        let bytes = self.bytes.get_mut(at..at + size).unwrap_or_default();
        let mut values = FirstValues::new(definitions);
        values.instances(&tag_type, bytes);
        if let Some(value) = source.value.as_ref().filter(|_| !is_of_machine) {
            values.fill(bytes, &tag_type.data_type, tag_type.dimensions[0] > 0, value);
        }
        if let Some(reason) = values.wrong {
            let reason = format!("its first value is not that of the file: {reason}");
            findings.push(finding(FindingKind::Tag, &source.name, reason));
        }
        values::attributes(&tag_type, bytes, &source.attributes);
        let is_bool = source.data_type.eq_ignore_ascii_case("BOOL");
        let bits = (is_bool && !source.dimensions.is_empty()).then(|| source.dimensions.iter().product());
        self.list.push(Tag {
            name: source.name.clone(),
            program: program.map(str::to_owned),
            tag_type,
            access: source.access,
            at: at as u32,
            bits,
            has_value: source.value.is_some(),
        });
        Some(Symbol::Tag(self.list.len() - 1))
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
