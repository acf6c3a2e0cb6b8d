//! Structure templates: members, offsets, handles (spec/ethernet-ip.md §11).
//!
//! Not here: tag instances, their writers, and the definition that a client uploads, which is `arcline-proto`'s. Offsets and sizes are bytes.

use std::ops::Range;
use std::sync::Arc;

use crate::{Elementary, STRING_HANDLE, STRING_SIZE, handle};

/// An elementary type or a structure.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum DataType {
    /// One of the elementary CIP types.
    Elementary(Elementary),
    /// A structure, described by its template.
    Structure(Arc<Template>),
}

impl DataType {
    /// Size of one element in bytes.
    pub fn size(&self) -> usize {
        match self {
            Self::Elementary(kind) => kind.size(),
            Self::Structure(template) => template.size as usize,
        }
    }

    /// The name, such as `DINT`, `STRING` or `COORDINATE_SYSTEM`.
    pub fn name(&self) -> &str {
        match self {
            Self::Elementary(kind) => kind.name(),
            Self::Structure(template) if template.is_string() => "STRING",
            Self::Structure(template) => &template.name,
        }
    }

    /// The 16-bit type of a tag or member that is no array: the code, or 0x8000 and the template instance.
    pub fn type_word(&self) -> u16 {
        match self {
            Self::Elementary(kind) => u16::from(kind.code()),
            Self::Structure(template) => 0x8000 | (template.instance & 0x0FFF),
        }
    }

    /// Elementary values, bits and texts in one element: the numbers that a reader of it gets.
    pub fn leaves(&self) -> usize {
        match self {
            Self::Elementary(_) => 1,
            Self::Structure(template) => template.leaves(),
        }
    }

    /// Clients cannot write one of these bits of some elements: of a single byte those of a mask, of several bytes all.
    pub(crate) fn is_read_only(&self, elements: usize, bytes: &Range<usize>, mask: u8) -> bool {
        let Self::Structure(template) = self else { return false };
        let size = template.size as usize;
        if size == 0 || bytes.is_empty() {
            return false;
        }
        let last = bytes.end.div_ceil(size).min(elements);
        (bytes.start / size..last).any(|element| {
            let begin = element * size;
            let within = bytes.start.saturating_sub(begin)..(bytes.end - begin).min(size);
            template.is_read_only(&within, mask)
        })
    }

    /// Natural alignment in a user structure: the size of an elementary type; 4 for structures, 8 if they
    /// hold an 8-byte type.
    fn alignment(&self) -> u32 {
        match self {
            Self::Elementary(kind) => kind.size() as u32,
            Self::Structure(template) => template.alignment(),
        }
    }
}

impl From<Elementary> for DataType {
    fn from(kind: Elementary) -> Self {
        Self::Elementary(kind)
    }
}

impl From<Arc<Template>> for DataType {
    fn from(template: Arc<Template>) -> Self {
        Self::Structure(template)
    }
}

/// A structure type as clients see it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Template {
    /// Type name, without the `;n` of user types.
    pub name: String,
    /// Template instance id, 1 to 0xFFF. 0x100 to 0xEFF are user types, the others predefined.
    pub instance: u16,
    /// Structure handle, the word behind `A0 02` in tag services.
    pub handle: u16,
    /// Size on the wire in bytes.
    pub size: u32,
    /// Members in template order; status words come before the BOOLs that overlay them.
    pub members: Vec<Member>,
}

/// A member of a structure.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Member {
    /// Name, matched without case.
    pub name: String,
    /// Type of one element.
    pub data_type: DataType,
    /// Byte offset from the start of the structure; for a BOOL the byte that holds its bit.
    pub offset: u32,
    /// Number of elements, 0: not an array.
    pub dimension: u16,
    /// Bit 0 to 7 within the byte at `offset`: BOOLs only.
    pub bit: Option<u8>,
    /// Not shown by clients: hosts of BOOLs, reserved space.
    pub hidden: bool,
    /// Clients cannot write it.
    pub read_only: bool,
}

impl Member {
    /// Number of elements, 1 if it is not an array.
    pub fn elements(&self) -> usize {
        usize::from(self.dimension).max(1)
    }

    /// Size in bytes of all elements.
    pub fn size(&self) -> usize {
        self.elements() * self.data_type.size()
    }

    /// The type word of the member in a template definition.
    pub fn type_word(&self) -> u16 {
        let array = if self.dimension == 0 { 0 } else { 0x2000 };
        self.data_type.type_word() | array
    }
}

impl Template {
    /// The member of that name, case ignored.
    pub fn member(&self, name: &str) -> Option<&Member> {
        self.members
            .iter()
            .find(|member| member.name.eq_ignore_ascii_case(name))
    }

    /// Whether the structure is the STRING type, whose value is a text.
    pub fn is_string(&self) -> bool {
        self.handle == STRING_HANDLE && self.size as usize == STRING_SIZE
    }

    /// Clients cannot write one of these bits: of a single byte those of a mask, of several bytes all.
    fn is_read_only(&self, bytes: &Range<usize>, mask: u8) -> bool {
        self.members.iter().any(|member| {
            let from = member.offset as usize;
            if from >= bytes.end || bytes.start >= from + member.size() {
                return false;
            }
            let is_meant = bytes.len() > 1 || member.bit.is_none_or(|bit| mask & 1 << bit != 0);
            let within = bytes.start.saturating_sub(from)..bytes.end - from;
            is_meant && (member.read_only || member.data_type.is_read_only(member.elements(), &within, mask))
        })
    }

    /// Elementary values, bits and texts in it, hidden members left out; a STRING is one text.
    pub fn leaves(&self) -> usize {
        if self.is_string() {
            return 1;
        }
        let visible = self.members.iter().filter(|member| !member.hidden);
        let leaves = visible.map(|member| member.elements().saturating_mul(member.data_type.leaves()));
        leaves.fold(0, usize::saturating_add)
    }

    /// Whether clients treat the structure as a user type, with `;n` behind its name.
    pub fn is_user_type(&self) -> bool {
        (0x100..=0xEFF).contains(&self.instance)
    }

    fn alignment(&self) -> u32 {
        self.members
            .iter()
            .map(|member| member.data_type.alignment())
            .fold(4, u32::max)
    }
}

/// Builds a [`Template`] member by member: at natural alignment, or at given offsets for predefined types.
#[derive(Debug)]
pub struct TemplateBuilder {
    template: Template,
    /// First byte behind the members so far.
    end: u32,
    /// The host byte that still has room for BOOLs: offset and bits used.
    host: Option<(u32, u8)>,
    handle: Option<u16>,
    size: Option<u32>,
}

impl TemplateBuilder {
    /// Starts a structure type; `instance` is its template instance id.
    pub fn new(name: impl Into<String>, instance: u16) -> Self {
        let template = Template {
            name: name.into(),
            instance,
            handle: 0,
            size: 0,
            members: Vec::new(),
        };
        Self {
            template,
            end: 0,
            host: None,
            handle: None,
            size: None,
        }
    }

    /// Adds a scalar at its natural alignment. A BOOL is packed: eight share a hidden SINT.
    pub fn member(self, name: impl Into<String>, data_type: impl Into<DataType>) -> Self {
        match data_type.into() {
            DataType::Elementary(Elementary::Bool) => self.packed_bool(name.into()),
            data_type => self.natural(name.into(), data_type, 0),
        }
    }

    /// Adds a one-dimensional array at its natural alignment, at least 4.
    pub fn array(self, name: impl Into<String>, data_type: impl Into<DataType>, dimension: u16) -> Self {
        self.natural(name.into(), data_type.into(), dimension)
    }

    /// Adds a member at an explicit offset; `dimension` 0 is a scalar.
    pub fn member_at(
        self,
        name: impl Into<String>,
        data_type: impl Into<DataType>,
        dimension: u16,
        offset: u32,
    ) -> Self {
        let member = Member {
            name: name.into(),
            data_type: data_type.into(),
            offset,
            dimension,
            bit: None,
            hidden: false,
            read_only: false,
        };
        self.push(member)
    }

    /// Adds a BOOL that overlays a word at `word_offset`: `bit` counts from bit 0 of that word and is turned
    /// into byte and bit 0 to 7.
    pub fn bit_at(self, name: impl Into<String>, word_offset: u32, bit: u8) -> Self {
        let member = Member {
            name: name.into(),
            data_type: Elementary::Bool.into(),
            offset: word_offset + u32::from(bit / 8),
            dimension: 0,
            bit: Some(bit % 8),
            hidden: false,
            read_only: false,
        };
        self.push(member)
    }

    /// Hides the member that was added last.
    pub fn hide(mut self) -> Self {
        if let Some(member) = self.template.members.last_mut() {
            member.hidden = true;
        }
        self
    }

    /// Keeps clients from writing the member that was added last.
    pub fn read_only(mut self) -> Self {
        if let Some(member) = self.template.members.last_mut() {
            member.read_only = true;
        }
        self
    }

    /// Fixes the size in bytes instead of rounding it up to the alignment.
    pub fn size(mut self, size: u32) -> Self {
        self.size = Some(size);
        self
    }

    /// Fixes the handle instead of computing it.
    pub fn handle(mut self, handle: u16) -> Self {
        self.handle = Some(handle);
        self
    }

    /// The finished template.
    pub fn build(self) -> Arc<Template> {
        let mut template = self.template;
        template.size = self
            .size
            .unwrap_or_else(|| self.end.next_multiple_of(template.alignment()));
        template.handle = self.handle.unwrap_or_else(|| handle::handle(&template));
        Arc::new(template)
    }

    fn natural(self, name: String, data_type: DataType, dimension: u16) -> Self {
        let alignment = data_type.alignment().max(if dimension == 0 { 1 } else { 4 });
        let offset = self.end.next_multiple_of(alignment);
        let member = Member {
            name,
            data_type,
            offset,
            dimension,
            bit: None,
            hidden: false,
            read_only: false,
        };
        Self { host: None, ..self }.push(member)
    }

    fn packed_bool(mut self, name: String) -> Self {
        let (offset, bit) = match self.host {
            Some((offset, used)) if used < 8 => (offset, used),
            _ => {
                let offset = self.end;
                let host = format!("ZZZZZZZZZZ{}{}", self.template.name, self.template.members.len());
                self = self.push(Member {
                    name: host,
                    data_type: Elementary::Sint.into(),
                    offset,
                    dimension: 0,
                    bit: None,
                    hidden: true,
                    read_only: false,
                });
                (offset, 0)
            }
        };
        self.host = Some((offset, bit + 1));
        self.push(Member {
            name,
            data_type: Elementary::Bool.into(),
            offset,
            dimension: 0,
            bit: Some(bit),
            hidden: false,
            read_only: false,
        })
    }

    fn push(mut self, mut member: Member) -> Self {
        member.hidden |= member.name.starts_with("__");
        self.end = self.end.max(member.offset + member.size() as u32);
        self.template.members.push(member);
        self
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::string_template;

    fn pair() -> Arc<Template> {
        TemplateBuilder::new("Vec2", 0x1A1)
            .member("X", Elementary::Real)
            .member("Y", Elementary::Real)
            .build()
    }

    #[test]
    fn the_string_has_the_handle_that_clients_expect() {
        let string = string_template();
        assert_eq!((string.size, string.handle, string.instance), (88, 0x0FCE, 0xFCE));
        let data = string.member("data").expect("DATA");
        assert_eq!((data.offset, data.dimension, data.type_word()), (4, 82, 0x20C2));
    }

    #[test]
    fn members_stand_at_natural_alignment_and_booleans_share_a_host() {
        let mut builder = TemplateBuilder::new("Mixed", 0x100).member("S", Elementary::Sint);
        for k in 0..9 {
            builder = builder.member(format!("B{k}"), Elementary::Bool);
        }
        let template = builder
            .member("I", Elementary::Int)
            .member("D", Elementary::Dint)
            .member("L", Elementary::Lreal)
            .member("N", pair())
            .array("A", Elementary::Sint, 3)
            .member("Last", Elementary::Bool)
            .build();
        #[rustfmt::skip]
        let cases = [
            ("S", 0, None), ("ZZZZZZZZZZMixed1", 1, None), ("B0", 1, Some(0)), ("B7", 1, Some(7)),
            ("ZZZZZZZZZZMixed10", 2, None), ("B8", 2, Some(0)), ("I", 4, None), ("D", 8, None),
            ("L", 16, None), ("N", 24, None), ("A", 32, None), ("Last", 35, Some(0)),
        ];
        for (name, offset, bit) in cases {
            let member = template.member(name).unwrap_or_else(|| panic!("member {name}"));
            assert_eq!((member.offset, member.bit), (offset, bit), "{name}");
            assert_eq!(member.hidden, name.starts_with("ZZZZ"), "{name}");
        }
        assert_eq!(template.size, 40, "rounded up to 8");
    }

    #[test]
    fn the_handle_follows_the_layout() {
        let swapped = TemplateBuilder::new("Vec2", 0x1A1)
            .member("X", Elementary::Real)
            .member("Y", Elementary::Dint)
            .build();
        assert_ne!(pair().handle, swapped.handle);
        assert_eq!(pair().handle, pair().handle);
    }

    proptest! {
        #[test]
        fn members_never_overlap(sizes in proptest::collection::vec((0usize..15, 0u16..4), 1..30)) {
            let mut builder = TemplateBuilder::new("T", 0x200);
            for (k, (kind, dimension)) in sizes.into_iter().enumerate() {
                let kind = Elementary::ALL[kind];
                builder = match dimension {
                    0 => builder.member(format!("M{k}"), kind),
                    n => builder.array(format!("M{k}"), kind, n),
                };
            }
            let template = builder.build();
            let mut end = 0;
            for member in template.members.iter().filter(|member| member.bit.is_none()) {
                prop_assert!(member.offset as usize >= end, "{:?}", member);
                prop_assert_eq!(member.offset as usize % member.data_type.size(), 0);
                end = member.offset as usize + member.size();
            }
            prop_assert!(template.size as usize >= end);
        }
    }
}
