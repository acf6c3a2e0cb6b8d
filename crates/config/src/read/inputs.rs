//! `feed` and `registration` of an `[[axis]]` table: the inputs of the axis from tags that clients write.

use arcline_controller::image::{Image, TagKind};
use arcline_controller::machine::{AxisInputs, FeedTag, Machine};
use arcline_tag::{DataType, Elementary, TagPath};

use crate::section::Section;
use crate::{InstructionTag, PlainTag};

/// `feedback`: whether the axis is of that type.
pub(super) fn inputs(axis: &Section<'_>, feedback: bool) -> AxisInputs {
    let (section, present) = axis.table("feed");
    match (present, feedback) {
        (false, true) if !axis.has("feed") => axis.missing("feed"),
        (true, false) => axis.conflict("feed", "type", "only an axis of type \"feedback\" is fed"),
        _ => {}
    }
    let feed = section.text("tag").map(|tag| FeedTag {
        tag: tag.value,
        interval: section.required("interval_ms") / 1000.0,
        timeout: section.required("timeout_ms") / 1000.0,
    });
    let (section, _) = axis.table("registration");
    let registration = INPUTS.map(|key| section.text(key).map(|tag| tag.value));
    AxisInputs { feed, registration }
}

/// Reports tags of axes that are not there, or are not of the type that is read.
pub(super) fn check_inputs(root: &Section<'_>, machine: &Machine, instructions: &[InstructionTag], tags: &[PlainTag]) {
    let reads = |inputs: &AxisInputs| inputs.feed.is_some() || inputs.registration.iter().any(Option::is_some);
    if !machine.axes.iter().any(|axis| reads(&axis.inputs)) {
        return;
    }
    let image = Image::new(machine, instructions, tags);
    let is_there = |path: &str, fits: fn(&DataType, Option<u8>) -> bool| {
        let place = path.parse().ok().and_then(|path: TagPath| image.locate(&path).ok());
        place.is_some_and(|(id, place)| {
            let plain = image.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
            plain && fits(&place.data_type, place.bit)
        })
    };
    for section in root.tables("axis") {
        let (feed, _) = section.table("feed");
        if let Some(tag) = feed.text("tag")
            && !is_there(&tag.value, |data_type, bit| {
                matches!(data_type, DataType::Elementary(kind) if *kind != Elementary::Bool) && bit.is_none()
            })
        {
            feed.refuse("tag", &tag, None);
        }
        let (registration, _) = section.table("registration");
        for key in INPUTS {
            if let Some(tag) = registration.text(key)
                && !is_there(&tag.value, |data_type, bit| {
                    bit.is_some() || *data_type == DataType::Elementary(Elementary::Bool)
                })
            {
                registration.refuse(key, &tag, None);
            }
        }
    }
}

const INPUTS: [&str; 2] = ["input_1", "input_2"];
