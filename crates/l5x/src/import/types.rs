//! `DataTypes`: structure types of the project, ordered so that each stands behind those it uses.

use std::collections::BTreeMap;

use arcline_config::{ELEMENTARY, MAX_ELEMENTS, MAX_MEMBERS, MAX_SIZE, MAX_TYPES, is_name};
use arcline_instruction_set::predefined;
use arcline_tag::{DataType, Elementary};
use roxmltree::Node;
use toml::{Table, Value};

use super::Importer;
use crate::document::{child, children};
use crate::{L5xError, Reason};

/// The type of one element of a tag or member.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Kind {
    Elementary(Elementary),
    Text,
    /// A structure of the project or a predefined one, by its name in lower case.
    Structure(String),
}

#[derive(Clone, PartialEq, Debug)]
pub(super) struct Member {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// 0: not an array.
    pub(super) dimension: u32,
}

/// A structure type: its name as it is written, its members without hosts of BOOLs, its size, bytes, from above.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Structure {
    pub(super) name: String,
    pub(super) members: Vec<Member>,
    size: u64,
}

/// The structure types, by name in lower case.
pub(super) struct Types(BTreeMap<String, Structure>);

impl Types {
    /// The predefined types.
    pub(super) fn new() -> Self {
        let structures = predefined::for_tags().into_iter().map(|template| {
            let members = template.members.iter().filter(|member| !member.hidden);
            let members = members.filter_map(|member| match member.data_type {
                DataType::Elementary(kind) => Some(Member {
                    name: member.name.clone(),
                    kind: Kind::Elementary(kind),
                    dimension: member.dimension.into(),
                }),
                DataType::Structure(_) => None,
            });
            let structure = Structure {
                name: template.name.clone(),
                members: members.collect(),
                size: template.size.into(),
            };
            (template.name.to_ascii_lowercase(), structure)
        });
        Self(structures.collect())
    }

    pub(super) fn structure(&self, name: &str) -> Option<&Structure> {
        self.0.get(name)
    }

    /// The type that a `DataType` attribute means; `None`: a type that Arcline does not have.
    pub(super) fn kind(&self, word: &str) -> Option<Kind> {
        match ELEMENTARY.iter().find(|name| name.eq_ignore_ascii_case(word)) {
            Some(name) => Some(Elementary::from_name(name).map_or(Kind::Text, Kind::Elementary)),
            None => {
                let key = word.to_ascii_lowercase();
                self.0.contains_key(&key).then_some(Kind::Structure(key))
            }
        }
    }

    /// The word for a type in a configuration.
    pub(super) fn word(&self, kind: &Kind, dimensions: &[u32]) -> String {
        let name = match kind {
            Kind::Elementary(kind) => kind.name(),
            Kind::Text => "STRING",
            Kind::Structure(key) => self.0.get(key).map_or("", |structure| &structure.name),
        };
        if dimensions.is_empty() {
            return name.to_owned();
        }
        let counts: Vec<String> = dimensions.iter().map(u32::to_string).collect();
        format!("{name}[{}]", counts.join(","))
    }

    /// Bytes of an array, alignment included, so never too few.
    pub(super) fn size(&self, kind: &Kind, dimensions: &[u32]) -> u64 {
        let one = match kind {
            Kind::Elementary(kind) => kind.size() as u64,
            Kind::Text => arcline_tag::STRING_SIZE as u64,
            Kind::Structure(key) => self.0.get(key).map_or(0, |structure| structure.size),
        };
        dimensions
            .iter()
            .fold(one, |size, count| size.saturating_mul(u64::from(*count)))
    }
}

impl<'a, 't> Importer<'a, 't> {
    pub(super) fn data_types(&mut self, list: Node<'a, 't>, types: &mut Types) -> Result<(), L5xError> {
        let mut waiting: BTreeMap<String, Node<'a, 't>> = BTreeMap::new();
        let mut order = Vec::new();
        for node in children(list, "DataType") {
            let name = self.source.required(node, "Name", "the type's name")?;
            self.source.check(node);
            let known = ELEMENTARY.iter().any(|known| known.eq_ignore_ascii_case(name));
            let taken = known
                || predefined::all()
                    .iter()
                    .any(|known| known.name.eq_ignore_ascii_case(name));
            if taken || !is_name(name) || order.len() >= MAX_TYPES {
                self.source.report(node, Reason::NoCounterpart);
                continue;
            }
            let key = name.to_ascii_lowercase();
            if waiting.insert(key.clone(), node).is_some() {
                return Err(self.source.wrong(node, "Name", "a name that no other data type has"));
            }
            order.push(key);
        }
        for key in order {
            self.data_type(&key, &mut waiting, types, 0)?;
        }
        Ok(())
    }

    /// Adds a type, those it uses first. A type that is being added is no longer waiting, so a circle ends.
    fn data_type(
        &mut self,
        key: &str,
        waiting: &mut BTreeMap<String, Node<'a, 't>>,
        types: &mut Types,
        depth: usize,
    ) -> Result<(), L5xError> {
        if depth > MAX_NESTING {
            return Ok(());
        }
        let Some(node) = waiting.remove(key) else {
            return Ok(());
        };
        let list = child(node, "Members");
        let nodes: Vec<Node<'a, 't>> = list.map(|list| children(list, "Member").collect()).unwrap_or_default();
        list.into_iter().for_each(|list| self.source.check(list));
        let mut structure = Structure {
            name: node.attribute("Name").unwrap_or_default().to_owned(),
            members: Vec::new(),
            size: 0,
        };
        for member in nodes {
            self.source.check(member);
            if member.attribute("Hidden") == Some("true") {
                continue;
            }
            let name = self.source.required(member, "Name", "the member's name")?;
            let word = self.source.required(member, "DataType", "the member's type")?;
            self.data_type(&word.to_ascii_lowercase(), waiting, types, depth + 1)?;
            let word = if word == "BIT" { "BOOL" } else { word };
            let dimension = match member.attribute("Dimension").unwrap_or("0").parse() {
                Ok(dimension) if dimension <= MAX_ELEMENTS => dimension,
                // A structure of a configuration has no room for it.
                Ok(_) => {
                    self.source.report(member, Reason::NoCounterpart);
                    continue;
                }
                _ => return Err(self.source.wrong(member, "Dimension", "a whole number")),
            };
            let Some(kind) = types
                .kind(word)
                .filter(|_| is_name(name) && structure.members.len() < MAX_MEMBERS)
            else {
                self.source.report(member, Reason::NoCounterpart);
                continue;
            };
            if structure
                .members
                .iter()
                .any(|other| other.name.eq_ignore_ascii_case(name))
            {
                return Err(self.source.wrong(member, "Name", "a name that no other member has"));
            }
            let dimensions = if dimension == 0 { &[][..] } else { &[dimension] };
            // Seven bytes of padding at most stand before a member and seven behind it.
            let size = types.size(&kind, dimensions).saturating_add(14);
            structure.size = structure.size.saturating_add(size);
            structure.members.push(Member {
                name: name.to_owned(),
                kind,
                dimension,
            });
        }
        if structure.members.is_empty() || structure.size > MAX_SIZE as u64 {
            self.source.report(node, Reason::NoCounterpart);
            return Ok(());
        }
        if node.attribute("Family") == Some("StringFamily") {
            self.source.report(
                node,
                Reason::Changed("a string type becomes a structure of LEN and DATA"),
            );
        }
        let members = structure.members.iter().map(|member| {
            let dimensions = if member.dimension == 0 {
                &[][..]
            } else {
                &[member.dimension]
            };
            let word = types.word(&member.kind, dimensions);
            Value::Table(Table::from_iter([
                ("name".to_owned(), Value::String(member.name.clone())),
                ("type".to_owned(), Value::String(word)),
            ]))
        });
        let entry = Table::from_iter([
            ("name".to_owned(), Value::String(structure.name.clone())),
            ("members".to_owned(), Value::Array(members.collect())),
        ]);
        self.push("data_type", node, entry);
        types.0.insert(key.to_owned(), structure);
        Ok(())
    }
}

/// Most structures within one another.
const MAX_NESTING: usize = 32;
