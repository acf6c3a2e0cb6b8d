//! Instructions that work on cam tags: what they need of them goes with the call into the tick, and what they write is
//! written when they are done (spec/axis-and-data-types.md §3.9, §8.9).
//!
//! Not here: how cams and profiles stand in their tags ([`super::cam_tags`]), the mathematics (`arcline_cam`) and what a cam does.

use std::sync::Arc;

use arcline_instruction_set::predefined::cam_profile_status::{BEING_CALCULATED, CALCULATED, NOT_CALCULATED};
use arcline_instruction_set::{Call, Detail, Flag, Mnemonic, MotionControl, MotionError, OperandIndex};
use arcline_motion::cam::{CalculateError, Profile};
use arcline_motion::{Answer, Material};

use super::cam_tags::{CAM, Place, SEGMENT};
use super::shared::Kept;
use super::{Image, TagId};

/// What an instruction writes to tags when it is done.
#[derive(Clone, Debug)]
#[must_use = "a profile stays \"being calculated\" until it is settled"]
pub struct Staged(Result_);

#[derive(Clone, Debug)]
enum Result_ {
    Profile(Place, Profile),
    Numbers(Vec<(u32, f64)>),
    /// What the tick calculates, for an array.
    Answer(u32, Arc<Answer>),
    /// The same of MCTPO: six numbers for an array, and what is behind them for a DINT and an INT[4].
    Pose([u32; 3], Arc<Answer>),
}

/// Profiles of the tags that something is done with.
#[derive(Clone, Debug, Default)]
pub(super) struct Profiles {
    calculated: Vec<Place>,
    /// Kept until nobody else has the profile any more: it is freed here.
    used: Kept<(Place, Arc<Profile>)>,
}

impl Image {
    /// What a call needs of tags, and what it writes to them: the latter is for [`Image::settle`] once the instruction was
    /// executed.
    pub fn prepare(&mut self, call: &Call) -> (Option<Material>, Option<Staged>) {
        let prepared = match call.mnemonic {
            Mnemonic::Mccp => self.calculate_profile(call),
            Mnemonic::Mcsv => self.calculate_values(call),
            Mnemonic::Mapc | Mnemonic::Matc => self.use_profile(call),
            Mnemonic::Maoc => self.prepare_output_cam(call),
            Mnemonic::Mcto => self
                .frames(call)
                .map(|frames| (Material::Frames(frames), None))
                .map_err(Refusal::from),
            Mnemonic::Mcpm => self
                .path_move(call)
                .map(|path| (Material::Path(path), None))
                .map_err(Refusal::from),
            Mnemonic::Mctpo => self.calculate_pose(call),
            Mnemonic::Mctp => return Self::expect_numbers(call, "Transform Position"),
            _ => return (None, None),
        };
        match prepared {
            Ok((material, staged)) => (Some(material), staged),
            Err(Refusal { error, element }) => (Some(Material::Refused { error, element }), None),
        }
    }

    /// Writes what an instruction has calculated, if it is done.
    pub fn settle(&mut self, staged: Staged, control: &MotionControl) {
        let done = control.has(Flag::Dn) && !control.has(Flag::Er);
        match staged.0 {
            Result_::Profile(place, profile) => {
                self.profiles.calculated.retain(|other| *other != place);
                if done {
                    self.write_profile(place, &profile);
                } else if self.status(place) == BEING_CALCULATED {
                    // What was there is there still.
                    let status = self.stored(place).map_or(NOT_CALCULATED, |_| CALCULATED);
                    self.set_status(place, status);
                }
            }
            Result_::Answer(tag, answer) => {
                // The elements of an array follow each other in what a tag is called.
                for (place, number) in (tag..).zip(answer.numbers().filter(|_| done)) {
                    self.write_number(place, number);
                }
            }
            Result_::Pose([position, configuration, turns], answer) => {
                for (place, number) in answer.numbers().enumerate().filter(|_| done) {
                    match place {
                        0..=5 => self.write_number(position + place as u32, number),
                        6 => self.write_bytes(configuration, 0, &(number as i32).to_le_bytes()),
                        _ => self.write_bytes(turns, 2 * (place - 7), &(number as i16).to_le_bytes()),
                    }
                }
            }
            Result_::Numbers(numbers) => {
                for (tag, number) in numbers.into_iter().filter(|_| done) {
                    self.write_number(tag, number);
                }
            }
        }
    }

    /// Shows how many instructions use each profile, and frees those that none uses any more.
    pub fn show_uses(&mut self) {
        self.free_output_cams();
        if self.profiles.used.is_empty() {
            return;
        }
        let places: Vec<Place> = self.profiles.used.iter().map(|(place, _)| *place).collect();
        for place in places {
            if self.status(place) >= CALCULATED {
                self.set_status(place, CALCULATED + self.users(place));
            }
        }
        self.profiles.used.retain(|(_, profile)| Arc::strong_count(profile) > 1);
    }

    /// A place for what the tick calculates, where the operand names an array.
    fn expect_numbers(call: &Call, name: &str) -> (Option<Material>, Option<Staged>) {
        let Some(array) = call.written(operand(call.mnemonic, name)) else {
            return (None, None);
        };
        let answer = Arc::new(Answer::new(usize::from(array.elements)));
        (
            Some(Material::Answer(answer.clone())),
            Some(Staged(Result_::Answer(array.tag, answer))),
        )
    }

    /// What MCTPO reads, and what it writes.
    fn calculate_pose(&mut self, call: &Call) -> Prepared {
        let calculation = self.calculation(call)?;
        let tags = ["Robot Configuration", "Turns Counter"].map(|name| call.tag(operand(call.mnemonic, name)));
        let position = call.written(operand(call.mnemonic, "Transform Position"));
        let staged = match (position, tags) {
            (Some(position), [Some(configuration), Some(turns)]) => {
                let tags = [position.tag, configuration, turns];
                Some(Staged(Result_::Pose(tags, calculation.answer.clone())))
            }
            _ => None,
        };
        Ok((Material::Calculation(calculation), staged))
    }

    /// Instructions that use a profile of these elements.
    fn users(&self, place: Place) -> i32 {
        let of_place = self.profiles.used.iter().filter(|(used, _)| used.overlaps(&place));
        of_place.map(|(_, profile)| Arc::strong_count(profile) as i32 - 1).sum()
    }

    fn calculate_profile(&mut self, call: &Call) -> Prepared {
        let cam = self.array_of(call, Mnemonic::Mccp, "Cam", CAM)?;
        let place = self.array_of(call, Mnemonic::Mccp, CAM_PROFILE_OPERAND, SEGMENT)?;
        let [length, start_slope, end_slope] =
            ["Length", "Start Slope", "End Slope"].map(|name| call.number(operand(Mnemonic::Mccp, name)));
        let length = length.round_ties_even();
        if !(2.0..=cam.elements as f64).contains(&length) {
            return Err(MotionError::IllegalCamLength.into());
        }
        let length = length as usize;
        if place.elements < length {
            return Err(MotionError::IllegalCamProfileLength.into());
        }
        if self.is_calculated(place) {
            return Err(MotionError::CamProfileBeingCalculated.into());
        }
        if self.users(place) > 0 {
            return Err(MotionError::CamProfileBeingUsed.into());
        }
        let points = self.points(cam, length)?;
        let profile = Profile::calculate(&points, start_slope, end_slope).map_err(|error| match error {
            CalculateError::TooFew { .. } => Refusal::from(MotionError::IllegalCamLength),
            CalculateError::Order { place } => Refusal::element(MotionError::IllegalCamOrder, place),
            // A number that is none: an operand out of range.
            CalculateError::NotFinite { place } => Refusal {
                error: MotionError::ParameterOutOfRange(OperandIndex(operand(Mnemonic::Mccp, "Cam") as u8)),
                element: place as u32,
            },
        })?;
        self.profiles.calculated.push(place);
        self.set_status(place, BEING_CALCULATED);
        Ok((Material::Done, Some(Staged(Result_::Profile(place, profile)))))
    }

    fn calculate_values(&mut self, call: &Call) -> Prepared {
        let place = self.array_of(call, Mnemonic::Mcsv, CAM_PROFILE_OPERAND, SEGMENT)?;
        let profile = self.profile(place)?;
        let master = operand(Mnemonic::Mcsv, "Master Value");
        let x = call.number(master);
        if !profile.contains(x) {
            return Err(MotionError::ParameterOutOfRange(OperandIndex(master as u8)).into());
        }
        let value = profile.at(x);
        let results = [
            ("Slave Value", value.y),
            ("Slope Value", value.slope),
            ("Slope Derivative", value.curvature),
        ];
        let numbers = results.into_iter().filter_map(|(name, number)| {
            let tag = call.written(operand(Mnemonic::Mcsv, name))?.tag;
            Some((tag, number))
        });
        Ok((Material::Done, Some(Staged(Result_::Numbers(numbers.collect())))))
    }

    fn use_profile(&mut self, call: &Call) -> Prepared {
        self.show_uses();
        let place = self.array_of(call, call.mnemonic, CAM_PROFILE_OPERAND, SEGMENT)?;
        let profile = Arc::new(self.profile(place)?);
        self.profiles.used.push((place, profile.clone()));
        Ok((Material::Cam(profile), None))
    }

    /// The profile of these elements, if it can be used.
    fn profile(&self, place: Place) -> Result<Profile, Refusal> {
        if self.is_calculated(place) {
            return Err(MotionError::CamProfileBeingCalculated.into());
        }
        self.stored(place).ok_or(MotionError::CamProfileNotCalculated.into())
    }

    fn is_calculated(&self, place: Place) -> bool {
        self.profiles.calculated.iter().any(|other| other.overlaps(&place))
    }

    fn write_number(&mut self, tag: u32, number: f64) {
        if let Some((id, offset, 1..)) = self.written_array(tag) {
            let bytes = (number as f32).to_le_bytes();
            self.put(id, offset, &bytes);
            self.note_written(id, offset, bytes.len());
        }
    }

    /// Bytes of a plain tag from where an operand begins.
    fn write_bytes(&mut self, tag: u32, behind: usize, bytes: &[u8]) {
        let (id, offset) = (TagId(tag >> 16), (tag & 0xFFFF) as usize * 4 + behind);
        self.put(id, offset, bytes);
        self.note_written(id, offset, bytes.len());
    }

    pub(super) fn put(&mut self, id: TagId, offset: usize, data: &[u8]) {
        if let Some(place) = self
            .bytes_mut(id)
            .and_then(|bytes| bytes.get_mut(offset..offset + data.len()))
        {
            place.copy_from_slice(data);
        }
    }
}

pub(super) type Prepared = Result<(Material, Option<Staged>), Refusal>;

/// What an instruction errs with, and the element to blame.
pub(super) struct Refusal {
    error: MotionError,
    element: u32,
}

impl Refusal {
    /// EXERR has one byte: elements behind the 127th show in SEGMENT only.
    pub(super) fn element(error: fn(Detail) -> MotionError, place: usize) -> Self {
        Refusal {
            error: error(Detail(place.min(127) as i8)),
            element: place as u32,
        }
    }
}

impl From<MotionError> for Refusal {
    fn from(error: MotionError) -> Self {
        Refusal { error, element: 0 }
    }
}

/// Place of an operand on the faceplate.
pub(super) fn operand(mnemonic: Mnemonic, name: &str) -> usize {
    let operands = mnemonic.instruction().operands;
    operands.iter().position(|operand| operand.name == name).unwrap_or(0)
}

const CAM_PROFILE_OPERAND: &str = "Cam Profile";
