//! The data types of a project: elementary, predefined, of the project, and those of add-on instructions' instances.

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_instruction_set::predefined;
use arcline_tag::{DataType, Elementary, Member, TagType, Template, TemplateBuilder};

use crate::expression::{Expression, Step};
use crate::source::{Access, MemberSource, Project, Usage};

/// The types by name in lower case.
#[derive(Debug, Default)]
pub(crate) struct Types {
    known: BTreeMap<String, DataType>,
    /// Types of which a member is left out, and why.
    pub(crate) wrong: Vec<(String, String)>,
    next: u16,
}

/// The members of a type that is not complete yet.
struct Pending<'p> {
    name: &'p str,
    members: Vec<&'p MemberSource>,
    /// Parameters that are aliases, and their targets.
    aliases: Vec<(&'p MemberSource, &'p str)>,
}

impl Pending<'_> {
    /// A parameter stands for a member, or for a part of it; its access counts for both.
    fn has_alias_of(&self, member: &str) -> bool {
        self.aliases
            .iter()
            .any(|(_, target)| root_of(target).eq_ignore_ascii_case(member))
    }
}

impl Types {
    pub(crate) fn new(project: &Project) -> Self {
        let mut types = Types {
            next: 0x200,
            ..Types::default()
        };
        for template in predefined::all().into_iter().chain(own()) {
            // The template of STRING has another name than the type.
            let data_type = DataType::Structure(template);
            types.known.insert(data_type.name().to_ascii_lowercase(), data_type);
        }
        let mut pending: BTreeMap<String, Pending<'_>> = BTreeMap::new();
        for source in &project.types {
            let members = source.members.iter().collect();
            pending.insert(
                source.name.to_ascii_lowercase(),
                Pending {
                    name: &source.name,
                    members,
                    aliases: Vec::new(),
                },
            );
        }
        for source in &project.instructions {
            let parameters = source
                .parameters
                .iter()
                .filter(|one| one.usage != Usage::InOut && one.alias.is_none());
            let members = parameters
                .map(|one| &one.member)
                .chain(source.locals.iter().map(|(local, _)| local));
            let members = members.collect();
            // Encoded content has no local tags that a parameter could stand for.
            let aliases = source.parameters.iter().filter(|_| !source.is_encoded);
            let aliases = aliases.filter_map(|one| Some((&one.member, one.alias.as_deref()?)));
            pending.insert(
                source.name.to_ascii_lowercase(),
                Pending {
                    name: &source.name,
                    members,
                    aliases: aliases.collect(),
                },
            );
        }
        while let Some(name) = pending.keys().next().cloned() {
            types.make(&name, &mut pending, 0);
        }
        types
    }

    /// Makes a type, those it uses first. A type that is being made no longer waits, so a circle ends.
    fn make(&mut self, name: &str, pending: &mut BTreeMap<String, Pending<'_>>, depth: usize) {
        let Some(source) = pending.remove(name) else { return };
        if depth > MAX_NESTING || self.known.contains_key(name) {
            return;
        }
        let mut builder = TemplateBuilder::new(source.name, self.next);
        for member in &source.members {
            let word = member.data_type.to_ascii_lowercase();
            self.make(&word, pending, depth + 1);
            let Some(data_type) = self.data_type(&word) else {
                let reason = format!(
                    "the type {} of its member {} is not known",
                    member.data_type, member.name
                );
                self.wrong.push((source.name.to_owned(), reason));
                continue;
            };
            let count = member
                .dimensions
                .iter()
                .fold(1_u32, |all, size| all.saturating_mul(*size));
            let elements = if data_type == DataType::Elementary(Elementary::Bool) {
                count.div_ceil(32)
            } else {
                count
            };
            if u16::try_from(elements).is_err() {
                let reason = format!(
                    "its member {} has {count} elements, more than {}",
                    member.name,
                    u16::MAX
                );
                self.wrong.push((source.name.to_owned(), reason));
                continue;
            }
            builder = match (&data_type, member.dimensions.is_empty()) {
                (_, true) => builder.member(&member.name, data_type),
                (DataType::Elementary(Elementary::Bool), false) => {
                    let words = u16::try_from(count.div_ceil(32)).unwrap_or(u16::MAX);
                    builder.array(&member.name, Elementary::Dword, words)
                }
                _ => builder.array(&member.name, data_type, u16::try_from(count).unwrap_or(u16::MAX)),
            };
            if member.access != Access::ReadWrite && !source.has_alias_of(&member.name) {
                builder = builder.read_only();
            }
        }
        self.next = self.next.saturating_add(1);
        let template = self.with_aliases(builder.build(), &source);
        self.known.insert(name.to_owned(), DataType::Structure(template));
    }

    /// The type of an instance with the parameters that are aliases: each stands where its target is.
    fn with_aliases(&mut self, template: Arc<Template>, source: &Pending<'_>) -> Arc<Template> {
        let mut all = Template::clone(&template);
        let mut left = source.aliases.clone();
        // An alias may stand for another one.
        loop {
            let before = left.len();
            left.retain(|(parameter, target)| match target_of(&all, &source.members, target) {
                Some(found) => {
                    all.members.push(Member {
                        name: parameter.name.clone(),
                        read_only: parameter.access != Access::ReadWrite,
                        ..found
                    });
                    false
                }
                None => true,
            });
            if left.is_empty() || left.len() == before {
                break;
            }
        }
        for (parameter, target) in left {
            // A local tag of an unknown type is named already.
            let root = root_of(target);
            let is_left_out = all.member(root).is_none();
            if is_left_out && source.members.iter().any(|one| one.name.eq_ignore_ascii_case(root)) {
                continue;
            }
            let reason = format!(
                "its parameter {} is an alias of {target}, which it does not have",
                parameter.name
            );
            self.wrong.push((source.name.to_owned(), reason));
        }
        if all.members.len() == template.members.len() {
            return template;
        }
        let builder = TemplateBuilder::new(all.name, all.instance).size(all.size);
        let add = |builder: TemplateBuilder, member: Member| {
            let builder = match member.bit {
                Some(bit) => builder.bit_at(member.name, member.offset, bit),
                None => builder.member_at(member.name, member.data_type, member.dimension, member.offset),
            };
            let builder = if member.hidden { builder.hide() } else { builder };
            if member.read_only { builder.read_only() } else { builder }
        };
        all.members.into_iter().fold(builder, add).build()
    }

    /// A type by its name.
    pub(crate) fn data_type(&self, name: &str) -> Option<DataType> {
        let name = name.to_ascii_lowercase();
        if name == "bit" {
            return Some(Elementary::Bool.into());
        }
        let elementary = Elementary::from_name(&name.to_ascii_uppercase()).map(DataType::Elementary);
        elementary.or_else(|| self.known.get(&name).cloned())
    }

    /// The type of a tag; arrays of BOOL are packed.
    pub(crate) fn tag_type(&self, name: &str, dimensions: &[u32]) -> Option<TagType> {
        let data_type = self.data_type(name)?;
        let mut sizes = [0; 3];
        for (size, dimension) in sizes.iter_mut().zip(dimensions) {
            *size = *dimension;
        }
        if data_type == DataType::Elementary(Elementary::Bool) && !dimensions.is_empty() {
            return Some(TagType::bool_array(sizes[0]));
        }
        Some(TagType {
            data_type,
            dimensions: sizes,
        })
    }

    /// Adds a type that a tag of a module has.
    pub(crate) fn add(&mut self, template: Arc<Template>) {
        self.next = self.next.saturating_add(1);
        self.known
            .insert(template.name.to_ascii_lowercase(), DataType::Structure(template));
    }

    /// An instance for a type that is added.
    pub(crate) fn instance(&self) -> u16 {
        self.next
    }
}

/// The tag at the beginning of a path.
pub(crate) fn root_of(path: &str) -> &str {
    path.split(['.', '[']).next().unwrap_or(path)
}

/// The part of an instance that an alias stands for; `None`: there is none, or one of its subscripts is calculated.
fn target_of(template: &Template, sources: &[&MemberSource], target: &str) -> Option<Member> {
    let reference = Expression::parse_reference(target).ok()?;
    let mut found = template
        .member(&reference.name)
        .filter(|_| reference.program.is_none())?
        .clone();
    // The template knows one dimension, an array of BOOLs by its words.
    let is_words = |found: &Member| found.dimension > 0 && found.data_type == Elementary::Dword.into();
    let source = sources
        .iter()
        .find(|one| one.name.eq_ignore_ascii_case(&reference.name));
    let mut dimensions = match source {
        Some(source) if !is_words(&found) => source.dimensions.clone(),
        _ => vec![u32::from(found.dimension); usize::from(found.dimension > 0)],
    };
    for step in &reference.steps {
        match step {
            Step::Member(name) => {
                let DataType::Structure(inner) = &found.data_type else {
                    return None;
                };
                let inner = inner.member(name).filter(|_| dimensions.is_empty())?;
                let offset = found.offset + inner.offset;
                found = Member {
                    offset,
                    ..inner.clone()
                };
                dimensions = vec![u32::from(found.dimension); usize::from(found.dimension > 0)];
            }
            Step::Index(values) => {
                let is_words = is_words(&found);
                let mut element = 0;
                for (value, size) in values.iter().zip(&dimensions) {
                    let Expression::Integer(value) = value else { return None };
                    let size = if is_words { 32 * size } else { *size };
                    element = element * size + u32::try_from(*value).ok().filter(|value| *value < size)?;
                }
                if values.len() != dimensions.len() {
                    return None;
                }
                dimensions.clear();
                found.dimension = 0;
                if is_words {
                    found = bit_of(found, element);
                } else {
                    found.offset += element * found.data_type.size() as u32;
                }
            }
            Step::Bit(bit) => {
                let DataType::Elementary(kind) = found.data_type else {
                    return None;
                };
                let is_number = dimensions.is_empty() && found.bit.is_none() && !kind.is_real();
                let bit = u32::try_from(*bit)
                    .ok()
                    .filter(|bit| is_number && *bit < 8 * kind.size() as u32)?;
                found = bit_of(found, bit);
            }
            Step::BitAt(_) => return None,
        }
    }
    found.hidden = false;
    Some(found)
}

/// A bit behind the first byte of a member.
fn bit_of(member: Member, bit: u32) -> Member {
    Member {
        data_type: Elementary::Bool.into(),
        offset: member.offset + bit / 8,
        dimension: 0,
        bit: Some((bit % 8) as u8),
        ..member
    }
}

/// LEN and DATA of a type of texts: the offset of DATA and its elements.
pub(crate) fn text_layout(data_type: &DataType) -> Option<(u32, u32)> {
    let DataType::Structure(template) = data_type else {
        return None;
    };
    let length = template.member("LEN")?;
    let data = template.member("DATA")?;
    let visible = template.members.iter().filter(|member| !member.hidden).count();
    let fits = visible == 2
        && length.offset == 0
        && length.data_type == DataType::Elementary(Elementary::Dint)
        && matches!(
            data.data_type,
            DataType::Elementary(Elementary::Sint | Elementary::Usint | Elementary::Byte)
        )
        && data.dimension > 0;
    fits.then_some((data.offset, u32::from(data.dimension)))
}

/// Predefined types that only routines use (RM003, the structures of each instruction).
fn own() -> Vec<Arc<Template>> {
    use Elementary::{Bool, Dint, Int, Sint};
    let plain = |name: &str, instance: u16, members: &[(&str, Elementary)]| {
        let builder = TemplateBuilder::new(name, instance);
        members
            .iter()
            .fold(builder, |builder, (name, kind)| builder.member(*name, *kind))
            .build()
    };
    let message = TemplateBuilder::new("MESSAGE", 0xF90)
        .member_at("(Link)", Dint, 0, 0)
        .hide()
        .member_at("FLAGS", Int, 0, 4);
    let flags = [
        ("EW", 2),
        ("ER", 4),
        ("DN", 5),
        ("ST", 6),
        ("EN", 7),
        ("TO", 8),
        ("EN_CC", 9),
    ];
    let message = flags
        .into_iter()
        .fold(message, |builder, (name, bit)| builder.bit_at(name, 4, bit));
    let message = message
        .member_at("ERR", Int, 0, 6)
        .member_at("EXERR", Dint, 0, 8)
        .member_at("ERR_SRC", Sint, 0, 12)
        .member_at("DN_LEN", Int, 0, 14)
        .member_at("REQ_LEN", Int, 0, 16)
        .member_at("DestinationLink", Int, 0, 18)
        .member_at("DestinationNode", Int, 0, 20)
        .member_at("SourceLink", Int, 0, 22)
        .member_at("Class", Int, 0, 24)
        .member_at("Attribute", Int, 0, 26)
        .member_at("Instance", Dint, 0, 28)
        .member_at("LocalIndex", Dint, 0, 32)
        .member_at("Channel", Sint, 0, 36)
        .member_at("Rack", Sint, 0, 37)
        .member_at("Group", Sint, 0, 38)
        .member_at("Slot", Sint, 0, 39)
        .member_at("UnconnectedTimeout", Dint, 0, 40)
        .member_at("ConnectionRate", Dint, 0, 44)
        .member_at("TimeoutMultiplier", Sint, 0, 48)
        .member_at("LocalElement", arcline_tag::string_template(), 0, 52)
        .member_at("RemoteElement", arcline_tag::string_template(), 0, 140)
        .member_at("Path", arcline_tag::string_template(), 0, 228)
        .size(316)
        .build();
    let text = |name: &str, instance: u16, length: u16| {
        let builder = TemplateBuilder::new(name, instance).member("LEN", Dint);
        builder.array("DATA", Sint, length).build()
    };
    let connection = TemplateBuilder::new("CONNECTION_STATUS", 0xF99)
        .member_at("(Status)", Dint, 0, 0)
        .hide()
        .bit_at("RunMode", 0, 0)
        .bit_at("ConnectionFaulted", 0, 1)
        .size(4)
        .build();
    vec![
        message,
        connection,
        text("STRING_16", 0xF97, 16),
        text("STRING_32", 0xF98, 32),
        plain(
            "FBD_ONESHOT",
            0xF91,
            &[
                ("EnableIn", Bool),
                ("InputBit", Bool),
                ("EnableOut", Bool),
                ("OutputBit", Bool),
                ("(Last)", Bool),
            ],
        ),
        plain(
            "FBD_TIMER",
            0xF92,
            &[
                ("EnableIn", Bool),
                ("TimerEnable", Bool),
                ("PRE", Dint),
                ("Reset", Bool),
                ("EnableOut", Bool),
                ("ACC", Dint),
                ("EN", Bool),
                ("TT", Bool),
                ("DN", Bool),
                ("Status", Dint),
                ("__Last", Dint),
            ],
        ),
        plain("ALARM_DIGITAL", 0xF96, &ALARM_DIGITAL),
        plain(
            "FBD_COUNTER",
            0xF93,
            &[
                ("EnableIn", Bool),
                ("CUEnable", Bool),
                ("CDEnable", Bool),
                ("PRE", Dint),
                ("Reset", Bool),
                ("EnableOut", Bool),
                ("ACC", Dint),
                ("CU", Bool),
                ("CD", Bool),
                ("DN", Bool),
                ("OV", Bool),
                ("UN", Bool),
            ],
        ),
        plain(
            "FBD_BIT_FIELD_DISTRIBUTE",
            0xF94,
            &[
                ("EnableIn", Bool),
                ("Source", Dint),
                ("SourceBit", Dint),
                ("Length", Dint),
                ("DestBit", Dint),
                ("Target", Dint),
                ("EnableOut", Bool),
                ("Dest", Dint),
            ],
        ),
        plain(
            "FBD_MASKED_MOVE",
            0xF95,
            &[
                ("EnableIn", Bool),
                ("Source", Dint),
                ("Mask", Dint),
                ("Target", Dint),
                ("EnableOut", Bool),
                ("Dest", Dint),
            ],
        ),
    ]
}

/// The members of ALARM_DIGITAL that ladder and its alarms use, in the order of RM003.
const ALARM_DIGITAL: [(&str, Elementary); 38] = [
    ("EnableIn", Elementary::Bool),
    ("In", Elementary::Bool),
    ("InFault", Elementary::Bool),
    ("Condition", Elementary::Bool),
    ("AckRequired", Elementary::Bool),
    ("Latched", Elementary::Bool),
    ("ProgAck", Elementary::Bool),
    ("OperAck", Elementary::Bool),
    ("ProgReset", Elementary::Bool),
    ("OperReset", Elementary::Bool),
    ("ProgSuppress", Elementary::Bool),
    ("OperSuppress", Elementary::Bool),
    ("ProgUnsuppress", Elementary::Bool),
    ("OperUnsuppress", Elementary::Bool),
    ("ProgDisable", Elementary::Bool),
    ("OperDisable", Elementary::Bool),
    ("ProgEnable", Elementary::Bool),
    ("OperEnable", Elementary::Bool),
    ("AlarmCountReset", Elementary::Bool),
    ("UseProgTime", Elementary::Bool),
    ("ProgTime", Elementary::Lint),
    ("Severity", Elementary::Dint),
    ("MinDurationPRE", Elementary::Dint),
    ("EnableOut", Elementary::Bool),
    ("InAlarm", Elementary::Bool),
    ("Acked", Elementary::Bool),
    ("InAlarmUnack", Elementary::Bool),
    ("Suppressed", Elementary::Bool),
    ("Disabled", Elementary::Bool),
    ("(Timing)", Elementary::Bool),
    ("MinDurationACC", Elementary::Dint),
    ("AlarmCount", Elementary::Dint),
    ("InAlarmTime", Elementary::Lint),
    ("AckTime", Elementary::Lint),
    ("RetToNormalTime", Elementary::Lint),
    ("AlarmCountResetTime", Elementary::Lint),
    ("Status", Elementary::Dint),
    ("(Last)", Elementary::Dint),
];

/// Most structures within one another.
const MAX_NESTING: usize = 32;
