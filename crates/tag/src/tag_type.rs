//! The type of a tag, and where a path leads in its bytes.

use std::fmt;
use std::ops::Range;

use crate::{DataType, Elementary, PathError, PathSegment};

/// The type of a tag: an element type and up to three dimensions.
#[derive(Clone, PartialEq, Debug)]
pub struct TagType {
    /// Type of one element.
    pub data_type: DataType,
    /// Elements of each dimension, 0 for one that is not used; the last one changes fastest.
    pub dimensions: [u32; 3],
}

/// As a configuration spells it: `REAL[16]`.
impl fmt::Display for TagType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.data_type.name())?;
        match self.dimensions {
            [0, ..] => Ok(()),
            [count, 0, _] => write!(f, "[{count}]"),
            [planes, rows, 0] => write!(f, "[{planes},{rows}]"),
            [planes, rows, columns] => write!(f, "[{planes},{rows},{columns}]"),
        }
    }
}

/// A part of a tag.
#[derive(Clone, PartialEq, Debug)]
pub struct Location {
    /// Byte offset from the start of the tag.
    pub offset: usize,
    /// Type of one element there.
    pub data_type: DataType,
    /// Elements from here to the end of the array, 1 for a scalar.
    pub elements: u32,
    /// The bit, for BOOL members (0 to 7 of the byte at `offset`) and bits of integers (0 to 63).
    pub bit: Option<u8>,
}

impl Location {
    /// Size in bytes of one element.
    pub fn element_size(&self) -> usize {
        self.data_type.size()
    }
}

impl TagType {
    /// A tag that is no array.
    pub fn scalar(data_type: impl Into<DataType>) -> Self {
        Self {
            data_type: data_type.into(),
            dimensions: [0; 3],
        }
    }

    /// A one-dimensional array.
    pub fn array(data_type: impl Into<DataType>, elements: u32) -> Self {
        Self {
            data_type: data_type.into(),
            dimensions: [elements, 0, 0],
        }
    }

    /// A BOOL array as Logix keeps it: 32 to a DWORD. Clients address its DWORDs and pick the bit themselves.
    pub fn bool_array(bits: u32) -> Self {
        Self::array(Elementary::Dword, bits.div_ceil(32))
    }

    /// Clients cannot write one of these bits: of a single byte those of a mask, of several bytes all.
    pub fn is_read_only(&self, bytes: &Range<usize>, mask: u8) -> bool {
        self.data_type.is_read_only(self.elements() as usize, bytes, mask)
    }

    /// Number of dimensions, 0 to 3.
    pub fn rank(&self) -> usize {
        self.dimensions.iter().take_while(|size| **size > 0).count()
    }

    /// Number of elements, 1 if it is not an array.
    pub fn elements(&self) -> u32 {
        elements_of(&self.dimensions)
    }

    /// Size in bytes of all elements.
    pub fn size(&self) -> usize {
        self.data_type.size().saturating_mul(self.elements() as usize)
    }

    /// The symbol type word (spec/ethernet-ip.md §10): bit 15 structure, bits 14–13 number of dimensions, then the
    /// template instance or the type code.
    pub fn symbol_type(&self) -> u16 {
        self.data_type.type_word() | ((self.rank() as u16) << 13)
    }

    /// Follows the path segments behind the tag's name.
    ///
    /// An array without index is the whole array, from its first element.
    ///
    /// # Errors
    /// Names the member, index or bit that does not exist.
    pub fn locate<S: AsRef<str>>(&self, rest: &[PathSegment<S>]) -> Result<Location, PathError> {
        let (mut data_type, mut dimensions) = (&self.data_type, self.dimensions);
        let (mut offset, mut elements, mut bit) = (0, self.elements(), None);
        let mut rest = rest;
        while let Some(segment) = rest.first() {
            match segment {
                PathSegment::Element(_) => {
                    let (index, behind) = flat_index(rest, dimensions, data_type)?;
                    offset += index as usize * data_type.size();
                    elements -= index;
                    dimensions = [0; 3];
                    rest = behind;
                    continue;
                }
                PathSegment::Symbol(name) => {
                    let name = name.as_ref();
                    let template = match data_type {
                        DataType::Structure(template) if dimensions[0] == 0 => template,
                        _ => return Err(not_a_structure(name, data_type)),
                    };
                    let Some(member) = template.member(name) else {
                        return Err(PathError::NoSuchMember {
                            member: name.to_owned(),
                            structure: template.clone(),
                        });
                    };
                    offset += member.offset as usize;
                    elements = member.elements() as u32;
                    bit = member.bit;
                    data_type = &member.data_type;
                    dimensions = [u32::from(member.dimension), 0, 0];
                }
                PathSegment::Bit(of) => {
                    let fits = match data_type {
                        DataType::Elementary(kind) => kind.has_bits() && usize::from(*of) < 8 * kind.size(),
                        DataType::Structure(_) => false,
                    };
                    if !fits || bit.is_some() || dimensions[0] > 0 {
                        return Err(PathError::NoSuchBit {
                            bit: *of,
                            of: data_type.name().to_owned(),
                        });
                    }
                    bit = Some(*of);
                    elements = 1;
                }
            }
            rest = &rest[1..];
        }
        Ok(Location {
            offset,
            data_type: data_type.clone(),
            elements,
            bit,
        })
    }
}

/// Takes the indices off the front of `rest` and turns them into one.
fn flat_index<'a, S>(
    rest: &'a [PathSegment<S>],
    dimensions: [u32; 3],
    of: &DataType,
) -> Result<(u32, &'a [PathSegment<S>]), PathError> {
    let expected = dimensions.iter().take_while(|size| **size > 0).count();
    if expected == 0 {
        return Err(PathError::NotAnArray {
            of: of.name().to_owned(),
        });
    }
    let given = rest
        .iter()
        .take_while(|segment| matches!(segment, PathSegment::Element(_)))
        .count();
    if given != expected {
        return Err(PathError::WrongDimensions { given, expected });
    }
    let (indices, behind) = rest.split_at(given);
    let mut flat = 0;
    for (segment, size) in indices.iter().zip(dimensions) {
        let PathSegment::Element(index) = *segment else {
            continue;
        };
        if index >= size {
            return Err(PathError::IndexOutOfRange { index, size });
        }
        flat = flat * size + index;
    }
    Ok((flat, behind))
}

fn not_a_structure(member: &str, of: &DataType) -> PathError {
    PathError::NotAStructure {
        member: member.to_owned(),
        of: of.name().to_owned(),
    }
}

/// Number of elements of an array of these dimensions, of which the first that is 0 is none; without dimensions 1.
pub fn elements_of(dimensions: &[u32]) -> u32 {
    let sizes = dimensions.iter().take_while(|size| **size > 0);
    sizes.fold(1, |all, size| all.saturating_mul(*size))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{TagPath, TemplateBuilder, string_template};

    fn machine() -> TagType {
        let inner = TemplateBuilder::new("Inner", 0x101)
            .member("On", Elementary::Bool)
            .member("Off", Elementary::Bool)
            .member("Count", Elementary::Dint)
            .array("P", Elementary::Real, 4)
            .build();
        let outer = TemplateBuilder::new("Outer", 0x102)
            .member("Id", Elementary::Int)
            .array("Cells", inner, 3)
            .member("Name", string_template())
            .build();
        TagType::array(outer, 2)
    }

    #[test]
    fn paths_lead_to_bytes() {
        let machine = machine();
        // Inner: host 0, Count 4, P 8..24. Outer: Id 0, Cells 4..76, Name 76..164.
        #[rustfmt::skip]
        let cases = [
            ("M",                      0,   "Outer", 2, None),
            ("M[1]",                   164, "Outer", 1, None),
            ("M[1].Id",                164, "INT",   1, None),
            ("M[1].Id.15",             164, "INT",   1, Some(15)),
            ("M[0].Cells",             4,   "Inner", 3, None),
            ("M[0].Cells[2].off",      52,  "BOOL",  1, Some(1)),
            ("M[0].Cells[1].P[3]",     48,  "REAL",  1, None),
            ("M[0].Cells[1].P[1]",     40,  "REAL",  3, None),
            ("M[0].Name",              76,  "STRING", 1, None),
            ("M[0].Name.DATA[2]",      82,  "SINT",  80, None),
        ];
        for (text, offset, name, elements, bit) in cases {
            let path: TagPath = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            let place = machine.locate(path.rest()).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(
                (place.offset, place.data_type.name(), place.elements, place.bit),
                (offset, name, elements, bit),
                "{text}"
            );
        }
    }

    #[test]
    fn paths_that_lead_nowhere_say_why() {
        let machine = machine();
        #[rustfmt::skip]
        let cases = [
            ("M[2]",          "index 2 is out of range, the array has 2 elements"),
            ("M.Id",          "\"Id\" cannot be a member of Outer"),
            ("M[0].Nothing",  "Outer has no member \"Nothing\""),
            ("M[0].cels",     "Outer has no member \"cels\", did you mean \"Cells\"?"),
            ("M[0].Cells[0].Conut", "Inner has no member \"Conut\", did you mean \"Count\"?"),
            ("M[0].Id[0]",    "INT is not an array"),
            ("M[0].Id.16",    "INT has no bit 16"),
            ("M[0].Id.1.1",   "INT has no bit 1"),
            ("M[0].Id.X",     "\"X\" cannot be a member of INT"),
            ("M[0,0]",        "2 indices given for an array of 1 dimensions"),
            ("M[0].Cells[0].P[0].1", "REAL has no bit 1"),
            ("M.1",           "Outer has no bit 1"),
            ("M[0][0]",       "2 indices given for an array of 1 dimensions"),
        ];
        for (text, expected) in cases {
            let path: TagPath = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            let error = machine.locate(path.rest()).expect_err(text);
            assert_eq!(error.to_string(), expected, "{text}");
        }
    }

    #[test]
    fn several_dimensions_count_the_last_fastest() {
        let grid = TagType {
            data_type: Elementary::Int.into(),
            dimensions: [2, 3, 4],
        };
        let place = grid
            .locate(&[
                PathSegment::<&str>::Element(1),
                PathSegment::Element(2),
                PathSegment::Element(3),
            ])
            .expect("inside");
        assert_eq!((place.offset, place.elements), (2 * 23, 1));
        assert_eq!((grid.elements(), grid.size(), grid.symbol_type()), (24, 48, 0x60C3));
    }

    #[test]
    fn symbol_types() {
        assert_eq!(TagType::scalar(Elementary::Dint).symbol_type(), 0x00C4);
        assert_eq!(TagType::array(Elementary::Real, 9).symbol_type(), 0x20CA);
        assert_eq!(TagType::scalar(string_template()).symbol_type(), 0x8FCE);
        assert_eq!(TagType::array(string_template(), 3).symbol_type(), 0xAFCE);
        assert_eq!(TagType::bool_array(33).elements(), 2);
    }

    fn segment() -> impl Strategy<Value = PathSegment> {
        prop_oneof![
            prop::sample::select(vec!["Id", "Cells", "Name", "On", "Count", "P", "LEN", "DATA", "?"])
                .prop_map(|name| PathSegment::Symbol(name.to_owned())),
            (0u32..100).prop_map(PathSegment::Element),
            any::<u32>().prop_map(PathSegment::Element),
            (0u8..64).prop_map(PathSegment::Bit),
        ]
    }

    proptest! {
        #[test]
        fn a_located_part_is_inside_the_tag(rest in proptest::collection::vec(segment(), 0..6)) {
            let machine = machine();
            if let Ok(place) = machine.locate(&rest) {
                let end = place.offset + place.elements as usize * place.element_size();
                prop_assert!(end <= machine.size(), "{:?} ends at {}", place, end);
            }
        }
    }
}
