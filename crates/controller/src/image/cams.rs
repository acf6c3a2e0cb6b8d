//! Instructions that work on cam tags: their data from tags enter the tick with the call, and their results are written to tags when they are
//! done (spec/axis-and-data-types.md §3.9, §8.9).
//!
//! Not here: the layout of cams and profiles in their tags ([`super::cam_tags`]), the mathematics (`arcline_cam`), and the motion of a cam.

use std::sync::Arc;

use arcline_instruction_set::operands::{Mapc, Matc, Mccp, Mcpm, Mcsv, Mcto, Mctp, Mctpo, OperandValue, Operands};
use arcline_instruction_set::predefined::cam_profile_status::{BEING_CALCULATED, CALCULATED, NOT_CALCULATED};
use arcline_instruction_set::{Call, Detail, Flag, Mnemonic, MotionControl, MotionError, TagAddress, WrittenArray};
use arcline_motion::cam::{CalculateError, Profile};
use arcline_motion::{CallData, Results};

use super::calls::tag_and_offset;
use super::cam_tags::{CAM, ElementRange, SEGMENT};
use super::shared::Unshared;
use super::{Image, TagId};

/// The writes of an instruction to tags, which take place when it is done.
#[derive(Clone, Debug)]
#[must_use = "a profile stays \"being calculated\" until it is settled"]
pub struct StagedWrites(Writes);

#[derive(Clone, Debug)]
enum Writes {
    Profile(ElementRange, Profile),
    Numbers(Vec<(TagAddress, f64)>),
    /// Results of the tick, for an array.
    Results(TagAddress, Arc<Results>),
    /// Results of MCTPO: six numbers for an array, the others for a DINT and an INT[4].
    Pose([TagAddress; 3], Arc<Results>),
}

/// Profiles of tags that are being calculated or used.
#[derive(Clone, Debug, Default)]
pub(super) struct Profiles {
    calculated: Vec<ElementRange>,
    /// Profiles in use. An entry stays until it holds the last reference, so that the memory is freed here and not in the tick.
    used: Unshared<(ElementRange, Arc<Profile>)>,
}

impl Image {
    /// The data of a call that stand in tags, and the writes that it stages: those are for [`Image::settle`] after the execution of the
    /// instruction.
    pub fn prepare(&mut self, call: &Call) -> (Option<CallData>, Option<StagedWrites>) {
        let prepared = match call.mnemonic {
            Mnemonic::Mccp => self.calculate_profile(call),
            Mnemonic::Mcsv => self.calculate_values(call),
            Mnemonic::Mapc => self.use_profile(&Mapc::of(call).cam_profile),
            Mnemonic::Matc => self.use_profile(&Matc::of(call).cam_profile),
            Mnemonic::Maoc => self.prepare_output_cam(call),
            Mnemonic::Mcto => {
                let Mcto {
                    work_frame, tool_frame, ..
                } = Mcto::of(call);
                let frames = self.frames(&work_frame, &tool_frame);
                frames
                    .map(|frames| (CallData::Frames(frames), None))
                    .map_err(Refusal::from)
            }
            Mnemonic::Mcpm => self
                .path_move(&Mcpm::of(call))
                .map(|path| (CallData::Path(path), None))
                .map_err(Refusal::from),
            Mnemonic::Mctpo => self.calculate_pose(&Mctpo::of(call)),
            Mnemonic::Mctp => return Self::expect_results(*Mctp::of(call).transform_position),
            _ => return (None, None),
        };
        match prepared {
            Ok((data, staged)) => (Some(data), staged),
            Err(Refusal { error, element }) => (Some(CallData::Refused { error, element }), None),
        }
    }

    /// Writes the staged results of an instruction, if it is done.
    pub fn settle(&mut self, staged: StagedWrites, control: &MotionControl) {
        let done = control.has(Flag::Dn) && !control.has(Flag::Er);
        match staged.0 {
            Writes::Profile(range, profile) => {
                self.profiles.calculated.retain(|other| *other != range);
                if done {
                    self.write_profile(range, &profile);
                } else if self.status(range) == BEING_CALCULATED {
                    // The profile that the tag already holds is still valid.
                    let status = self.stored(range).map_or(NOT_CALCULATED, |_| CALCULATED);
                    self.set_status(range, status);
                }
            }
            Writes::Results(array, results) => {
                for (index, number) in results.numbers().enumerate().filter(|_| done) {
                    self.write_element(array, index, number);
                }
            }
            Writes::Pose([position, configuration, turns], results) => {
                for (index, number) in results.numbers().enumerate().filter(|_| done) {
                    match index {
                        0..=5 => self.write_element(position, index, number),
                        6 => self.write_bytes(configuration, 0, &(number as i32).to_le_bytes()),
                        _ => self.write_bytes(turns, 2 * (index - 7), &(number as i16).to_le_bytes()),
                    }
                }
            }
            Writes::Numbers(numbers) => {
                for (tag, number) in numbers.into_iter().filter(|_| done) {
                    self.write_number(tag, number);
                }
            }
        }
    }

    /// Shows the number of instructions that use each profile, and frees unused profiles.
    pub fn show_uses(&mut self) {
        self.free_output_cams();
        if self.profiles.used.is_empty() {
            return;
        }
        let ranges: Vec<ElementRange> = self.profiles.used.iter().map(|(range, _)| *range).collect();
        for range in ranges {
            if self.status(range) >= CALCULATED {
                self.set_status(range, CALCULATED + self.users(range));
            }
        }
        self.profiles.used.retain(|(_, profile)| Arc::strong_count(profile) > 1);
    }

    /// The results that the tick calculates, if the operand refers to an array for them.
    fn expect_results(array: Option<WrittenArray>) -> (Option<CallData>, Option<StagedWrites>) {
        let Some(array) = array else {
            return (None, None);
        };
        let results = Arc::new(Results::new(usize::from(array.elements)));
        (
            Some(CallData::Results(results.clone())),
            Some(StagedWrites(Writes::Results(array.tag, results))),
        )
    }

    /// The tags that MCTPO reads, and those that it writes.
    fn calculate_pose(&mut self, operands: &Mctpo) -> Prepared {
        let calculation = self.calculation(operands)?;
        let tags = (
            *operands.transform_position,
            *operands.robot_configuration,
            *operands.turns_counter,
        );
        let staged = match tags {
            (Some(position), Some(configuration), Some(turns)) => {
                let tags = [position.tag, configuration, turns];
                Some(StagedWrites(Writes::Pose(tags, calculation.results.clone())))
            }
            _ => None,
        };
        Ok((CallData::Calculation(calculation), staged))
    }

    /// Instructions that use a profile of these elements.
    fn users(&self, range: ElementRange) -> i32 {
        let overlapping = self.profiles.used.iter().filter(|(used, _)| used.overlaps(&range));
        overlapping
            .map(|(_, profile)| Arc::strong_count(profile) as i32 - 1)
            .sum()
    }

    fn calculate_profile(&mut self, call: &Call) -> Prepared {
        let Mccp {
            cam,
            length,
            start_slope,
            end_slope,
            cam_profile,
        } = Mccp::of(call);
        let points = self.array_of(&cam, CAM)?;
        let range = self.array_of(&cam_profile, SEGMENT)?;
        let Some(length) = usize::try_from(*length)
            .ok()
            .filter(|length| (2..=points.elements).contains(length))
        else {
            return Err(MotionError::IllegalCamLength.into());
        };
        if range.elements < length {
            return Err(MotionError::IllegalCamProfileLength.into());
        }
        if self.is_calculated(range) {
            return Err(MotionError::CamProfileBeingCalculated.into());
        }
        if self.users(range) > 0 {
            return Err(MotionError::CamProfileBeingUsed.into());
        }
        let points = self.points(points, length)?;
        let profile = Profile::calculate(&points, *start_slope, *end_slope).map_err(|error| match error {
            CalculateError::TooFew { .. } => Refusal::from(MotionError::IllegalCamLength),
            CalculateError::Order { point } => Refusal::element(MotionError::IllegalCamOrder, point),
            // A NaN counts as an operand out of range.
            CalculateError::NotFinite { point } => Refusal {
                error: cam.out_of_range(),
                element: point as u32,
            },
        })?;
        self.profiles.calculated.push(range);
        self.set_status(range, BEING_CALCULATED);
        Ok((CallData::Done, Some(StagedWrites(Writes::Profile(range, profile)))))
    }

    fn calculate_values(&mut self, call: &Call) -> Prepared {
        let Mcsv {
            cam_profile,
            master_value,
            slave_value,
            slope_value,
            slope_derivative,
        } = Mcsv::of(call);
        let profile = self.profile(self.array_of(&cam_profile, SEGMENT)?)?;
        if !profile.contains(*master_value) {
            return Err(master_value.out_of_range().into());
        }
        let value = profile.at(*master_value);
        let results = [
            (slave_value, value.y),
            (slope_value, value.slope),
            (slope_derivative, value.curvature),
        ];
        let numbers = results
            .into_iter()
            .filter_map(|(array, number)| Some((array.as_ref()?.tag, number)));
        Ok((CallData::Done, Some(StagedWrites(Writes::Numbers(numbers.collect())))))
    }

    fn use_profile(&mut self, cam_profile: &OperandValue<Option<TagAddress>>) -> Prepared {
        self.show_uses();
        let range = self.array_of(cam_profile, SEGMENT)?;
        let profile = Arc::new(self.profile(range)?);
        self.profiles.used.push((range, profile.clone()));
        Ok((CallData::Cam(profile), None))
    }

    /// The profile of these elements, if it can be used.
    fn profile(&self, range: ElementRange) -> Result<Profile, Refusal> {
        if self.is_calculated(range) {
            return Err(MotionError::CamProfileBeingCalculated.into());
        }
        self.stored(range).ok_or(MotionError::CamProfileNotCalculated.into())
    }

    fn is_calculated(&self, range: ElementRange) -> bool {
        self.profiles.calculated.iter().any(|other| other.overlaps(&range))
    }

    fn write_element(&mut self, array: TagAddress, index: usize, number: f64) {
        if let Some(element) = array.element(index) {
            self.write_number(element, number);
        }
    }

    fn write_number(&mut self, tag: TagAddress, number: f64) {
        if let Some((id, offset, 1..)) = self.written_array(tag) {
            let bytes = (number as f32).to_le_bytes();
            self.put(id, offset, &bytes);
            self.note_written(id, offset, bytes.len());
        }
    }

    /// Writes bytes of a plain tag, from the first byte of an operand on.
    fn write_bytes(&mut self, tag: TagAddress, behind: usize, bytes: &[u8]) {
        let (id, offset) = tag_and_offset(tag);
        let offset = offset + behind;
        self.put(id, offset, bytes);
        self.note_written(id, offset, bytes.len());
    }

    pub(super) fn put(&mut self, id: TagId, offset: usize, data: &[u8]) {
        if let Some(bytes) = self
            .bytes_mut(id)
            .and_then(|bytes| bytes.get_mut(offset..offset + data.len()))
        {
            bytes.copy_from_slice(data);
        }
        self.note_part(id, offset, data.len(), 0xFF);
    }
}

pub(super) type Prepared = Result<(CallData, Option<StagedWrites>), Refusal>;

/// The error of an instruction, and the element at fault.
pub(super) struct Refusal {
    error: MotionError,
    element: u32,
}

impl Refusal {
    /// EXERR has one byte: only SEGMENT shows elements behind the 127th.
    pub(super) fn element(error: fn(Detail) -> MotionError, element: usize) -> Self {
        Refusal {
            error: error(Detail(element.min(127) as i8)),
            element: element as u32,
        }
    }
}

impl From<MotionError> for Refusal {
    fn from(error: MotionError) -> Self {
        Refusal { error, element: 0 }
    }
}
