//! Plain tags that the machine reads: positions that feed axes, registration inputs, words that enable output cams. A write to one gives
//! [`WriteEffect::Input`], and the caller sends the controller the values ([`Image::take_inputs`]).

use arcline_instruction_set::AxisId;
use arcline_motion::Input;
use arcline_tag::{Elementary, TagPath, Value};

use super::{Image, TagId, TagKind, WriteEffect};
use crate::machine::Machine;

/// The tags that the machine reads.
#[derive(Clone, Debug, Default)]
pub(super) struct InputTags {
    paths: Vec<(TagPath, Means)>,
    /// Their locations, of existing tags only.
    tags: Vec<InputTag>,
    /// The version of the table of tags for which `tags` is valid.
    found_for: Option<u32>,
    /// Written values that have not been taken yet.
    written: Vec<Input>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Means {
    Position(AxisId),
    Registration(AxisId, u8),
}

#[derive(Clone, Copy, Debug)]
struct InputTag {
    means: Means,
    id: TagId,
    offset: usize,
    kind: Elementary,
    bit: Option<u8>,
    /// The last state of a registration input.
    on: bool,
}

impl InputTags {
    pub(super) fn new(machine: &Machine) -> Self {
        let mut inputs = InputTags::default();
        for (axis, described) in (0..).map(AxisId).zip(&machine.axes) {
            let feed = described
                .inputs
                .feed
                .as_ref()
                .map(|feed| (&feed.tag, Means::Position(axis)));
            let registration = (0..).zip(&described.inputs.registration);
            let registration =
                registration.filter_map(|(input, path)| Some((path.as_ref()?, Means::Registration(axis, input))));
            for (path, means) in feed.into_iter().chain(registration) {
                // The configuration has checked the path.
                inputs.paths.extend(path.parse().ok().map(|path| (path, means)));
            }
        }
        inputs
    }
}

impl Image {
    /// The values written since the last call to tags that the machine reads, in order.
    pub fn take_inputs(&mut self) -> Vec<Input> {
        std::mem::take(&mut self.inputs.written)
    }

    /// Records the inputs among written bytes.
    pub(super) fn note_inputs(&mut self, id: TagId, offset: usize, length: usize) -> Option<WriteEffect> {
        if self.inputs.paths.is_empty() && !self.watches_words() {
            return None;
        }
        self.find_inputs();
        let mut written = Vec::new();
        self.note_words(id, offset, length, &mut written);
        for at in 0..self.inputs.tags.len() {
            let tag = self.inputs.tags[at];
            let end = tag.offset + tag.kind.size();
            if tag.id != id || offset >= end || tag.offset >= offset + length {
                continue;
            }
            match tag.means {
                Means::Position(axis) => {
                    let position = self.input_number(&tag);
                    written.push(Input::Position { axis, position });
                }
                Means::Registration(axis, input) => {
                    let on = self.input_bit(&tag);
                    if std::mem::replace(&mut self.inputs.tags[at].on, on) != on {
                        written.push(Input::Registration { axis, input, on });
                    }
                }
            }
        }
        let edge = (!written.is_empty()).then_some(WriteEffect::Input);
        self.inputs.written.extend(written);
        edge
    }

    /// Finds the tags again after the table of tags has changed.
    fn find_inputs(&mut self) {
        if self.inputs.found_for == Some(self.table.changes) {
            return;
        }
        let mut tags = Vec::new();
        for (path, means) in &self.inputs.paths {
            let Ok((id, location)) = self.locate(path) else {
                continue;
            };
            let plain = self.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
            let arcline_tag::DataType::Elementary(kind) = location.data_type else {
                continue;
            };
            if plain {
                let known = self.inputs.tags.iter().find(|tag| tag.means == *means);
                tags.push(InputTag {
                    means: *means,
                    id,
                    offset: location.offset,
                    kind,
                    bit: location.bit,
                    on: known.is_some_and(|tag| tag.on),
                });
            }
        }
        self.inputs.tags = tags;
        self.inputs.found_for = Some(self.table.changes);
    }

    fn input_number(&self, tag: &InputTag) -> f64 {
        let bytes = self.bytes(tag.id).get(tag.offset..).unwrap_or_default();
        Value::read(tag.kind, bytes).map_or(f64::NAN, Value::as_f64)
    }

    fn input_bit(&self, tag: &InputTag) -> bool {
        match tag.bit {
            Some(bit) => {
                let byte = self.bytes(tag.id).get(tag.offset + usize::from(bit / 8));
                byte.is_some_and(|byte| byte & 1 << (bit % 8) != 0)
            }
            None => self.input_number(tag) != 0.0,
        }
    }
}
