//! Cams and their profiles as the bytes of tags (spec/axis-and-data-types.md §8.9).
//!
//! The elements of a CAM_PROFILE array are the segments of its profile, up to the last one whose Status marks a segment; that one is the last
//! point. Not here: the instructions that use them ([`super::cams`]).

use arcline_instruction_set::operands::OperandValue;
use arcline_instruction_set::predefined::cam_profile_status::{BEING_CALCULATED, CALCULATED, NOT_CALCULATED};
use arcline_instruction_set::{MotionError, TagAddress};
use arcline_motion::cam::{CamSegment, Point, Profile, SegmentType};
use arcline_tag::{DataType, Member};

use super::calls::tag_and_offset;
use super::cams::Refusal;
use super::structures::{real, word};
use super::{Image, TagId};

/// Elements of an array of structures, from one of them to the end of the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementRange {
    pub(super) id: TagId,
    /// Byte of the first element.
    pub(super) offset: usize,
    /// Number of elements from there on.
    pub(super) elements: usize,
}

impl Image {
    /// The array that an operand refers to.
    pub(super) fn array_of(
        &self,
        operand: &OperandValue<Option<TagAddress>>,
        size: usize,
    ) -> Result<ElementRange, Refusal> {
        let unknown = || operand.out_of_range();
        let (id, offset) = operand.map(tag_and_offset).ok_or_else(unknown)?;
        let tag_type = &self.tag(id).ok_or_else(unknown)?.tag_type;
        let elements = elements_from(&tag_type.data_type, tag_type.elements() as usize, offset, size);
        match elements {
            Some(elements) => Ok(ElementRange { id, offset, elements }),
            None => Err(unknown().into()),
        }
    }

    pub(super) fn points(&self, cam: ElementRange, length: usize) -> Result<Vec<Point>, Refusal> {
        let bytes = self.bytes(cam.id).get(cam.offset..).unwrap_or_default();
        let mut points: Vec<Point> = Vec::with_capacity(length);
        for (index, element) in bytes.chunks_exact(CAM).take(length).enumerate() {
            let [x, y] = [0, 4].map(|at| real(element, at));
            let kind = match i32::from_le_bytes(word(element, 8)) {
                0 => SegmentType::Linear,
                1 => SegmentType::Cubic,
                _ => return Err(Refusal::element(MotionError::IllegalCamType, index)),
            };
            let rises = points.last().is_none_or(|last| x > last.x);
            if !rises {
                return Err(Refusal::element(MotionError::IllegalCamOrder, index));
            }
            points.push(Point { x, y, kind });
        }
        Ok(points)
    }

    pub(super) fn status(&self, range: ElementRange) -> i32 {
        let bytes = self.bytes(range.id).get(range.offset..);
        bytes.map_or(NOT_CALCULATED, |bytes| i32::from_le_bytes(word(bytes, 0)))
    }

    pub(super) fn set_status(&mut self, range: ElementRange, status: i32) {
        self.put(range.id, range.offset, &status.to_le_bytes());
    }

    /// The profile in the bytes of these elements.
    pub(super) fn stored(&self, range: ElementRange) -> Option<Profile> {
        let bytes = self.bytes(range.id).get(range.offset..)?;
        let elements = bytes.chunks_exact(SEGMENT).take(range.elements).enumerate();
        let segments = elements.map_while(|(at, element)| {
            let status = i32::from_le_bytes(word(element, 0));
            // The Status of the first element holds the number of uses, or that the profile is being calculated again.
            let is_one = status >= CALCULATED || (at == 0 && status == BEING_CALCULATED);
            let number = |at: usize| f64::from_le_bytes(word(element, at));
            is_one.then(|| CamSegment {
                x: number(8),
                y: number(16),
                coefficients: [number(32), number(40), number(48)],
                kind: match i32::from_le_bytes(word(element, 4)) {
                    0 => SegmentType::Linear,
                    _ => SegmentType::Cubic,
                },
            })
        });
        Profile::from_segments(segments.collect())
    }

    pub(super) fn write_profile(&mut self, range: ElementRange, profile: &Profile) {
        let mut bytes = Vec::with_capacity(range.elements * SEGMENT);
        for segment in profile.segments() {
            bytes.extend(CALCULATED.to_le_bytes());
            bytes.extend((segment.kind as i32).to_le_bytes());
            let [a1, a2, a3] = segment.coefficients;
            for number in [segment.x, segment.y, segment.y, a1, a2, a3] {
                bytes.extend(number.to_le_bytes());
            }
        }
        bytes.resize(range.elements * SEGMENT, 0);
        self.put(range.id, range.offset, &bytes);
        self.note_written(range.id, range.offset, bytes.len());
    }
}

impl ElementRange {
    pub(super) fn overlaps(&self, other: &ElementRange) -> bool {
        let end = |range: &ElementRange| range.offset + range.elements * SEGMENT;
        self.id == other.id && self.offset < end(other) && other.offset < end(self)
    }
}

/// The number of structures of a size from a byte of an array on.
fn elements_from(data_type: &DataType, elements: usize, offset: usize, size: usize) -> Option<usize> {
    let DataType::Structure(template) = data_type else {
        return None;
    };
    let own = data_type.size();
    if own == size && offset.is_multiple_of(own) {
        return elements.checked_sub(offset / own).filter(|left| *left > 0);
    }
    let inside = offset % own;
    let holds = |member: &&Member| {
        let from = member.offset as usize;
        member.bit.is_none() && (from..from + member.size()).contains(&inside)
    };
    let member = template.members.iter().find(holds)?;
    elements_from(
        &member.data_type,
        member.elements(),
        inside - member.offset as usize,
        size,
    )
}

/// Bytes of a CAM.
pub(super) const CAM: usize = 12;
/// Bytes of a CAM_PROFILE.
pub(super) const SEGMENT: usize = 56;
