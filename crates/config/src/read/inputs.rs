//! `feed` and `registration` of an `[[axis]]` table: what the axis has from tags that clients write.

use arcline_controller::image::{Image, TagKind};
use arcline_controller::machine::{Feed, Inputs, Machine};
use arcline_tag::{DataType, Elementary, TagPath};

use crate::error::{ConfigError, Problem};
use crate::section::{NumberRule, Section};
use crate::{InstructionTag, PlainTag};

/// `feedback`: the type of the axis.
pub(super) fn inputs(axis: &Section<'_>, feedback: bool) -> Result<Inputs, ConfigError> {
    let (section, present) = axis.table("feed", FEED, FED)?;
    let feed = match (present, feedback) {
        (true, true) => Some(Feed {
            tag: match section.string("tag", NUMBER_TAG)? {
                Some(tag) => tag.value,
                None => return Err(section.missing("tag", NUMBER_TAG)),
            },
            interval: section.number("interval_ms", &INTERVAL)?.unwrap_or(10.0) / 1000.0,
            timeout: section.number("timeout_ms", &TIMEOUT)?.unwrap_or(100.0) / 1000.0,
        }),
        (false, false) => None,
        (false, true) => return Err(axis.missing("feed", FED)),
        (true, false) => {
            let reason = "only an axis of type \"feedback\" is fed";
            return Err(axis.refuse_key("feed", Problem::Conflict { other: "type", reason }));
        }
    };
    let (section, _) = axis.table("registration", REGISTRATION, REGISTERED)?;
    let mut registration = [None, None];
    for (input, key) in registration.iter_mut().zip(REGISTRATION) {
        *input = section.string(key, BIT_TAG)?.map(|tag| tag.value);
    }
    Ok(Inputs { feed, registration })
}

/// The tags that axes read are there, and are what is read.
pub(super) fn check_inputs(
    root: &Section<'_>,
    machine: &Machine,
    instructions: &[InstructionTag],
    tags: &[PlainTag],
) -> Result<(), ConfigError> {
    let reads = |inputs: &Inputs| inputs.feed.is_some() || inputs.registration.iter().any(Option::is_some);
    if !machine.axes.iter().any(|axis| reads(&axis.inputs)) {
        return Ok(());
    }
    let image = Image::new(machine, instructions, tags);
    let is_there = |path: &str, fits: fn(&DataType, Option<u8>) -> bool| {
        let place = path.parse().ok().and_then(|path: TagPath| image.locate(&path).ok());
        place.is_some_and(|(id, place)| {
            let plain = image.tag(id).is_some_and(|tag| tag.kind == TagKind::Plain);
            plain && fits(&place.data_type, place.bit)
        })
    };
    for section in root.tables("axis", super::axis::AXIS, "tables, [[axis]]", machine.axes.len())? {
        let (feed, present) = section.table("feed", FEED, FED)?;
        if present
            && let Some(tag) = feed.string("tag", NUMBER_TAG)?
            && !is_there(&tag.value, |data_type, bit| {
                matches!(data_type, DataType::Elementary(kind) if *kind != Elementary::Bool) && bit.is_none()
            })
        {
            return Err(feed.refuse(&tag, NUMBER_TAG, None));
        }
        let (registration, _) = section.table("registration", REGISTRATION, REGISTERED)?;
        for key in REGISTRATION {
            if let Some(tag) = registration.string(key, BIT_TAG)?
                && !is_there(&tag.value, |data_type, bit| {
                    bit.is_some() || *data_type == DataType::Elementary(Elementary::Bool)
                })
            {
                return Err(registration.refuse(&tag, BIT_TAG, None));
            }
        }
    }
    Ok(())
}

pub(super) const FEED: &[&str] = &["tag", "interval_ms", "timeout_ms"];
pub(super) const REGISTRATION: &[&str] = &["input_1", "input_2"];
const FED: &str = "{ tag = \"TAG\" }, the tag that its position is written to";
const REGISTERED: &str = "a table such as { input_1 = \"Mark\" }";
const NUMBER_TAG: &str = "the path of a number of a [[tag]]";
const BIT_TAG: &str = "the path of a BOOL or of a bit of a [[tag]]";
const INTERVAL: NumberRule = NumberRule {
    expected: "a number from 0 to 10000 (ms)",
    holds: |x| (0.0..=10_000.0).contains(&x),
};
const TIMEOUT: NumberRule = NumberRule {
    expected: "a number above 0, at most 3600000 (ms)",
    holds: |x| x > 0.0 && x <= 3_600_000.0,
};
