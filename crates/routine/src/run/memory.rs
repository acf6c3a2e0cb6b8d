//! The bytes of all tags, and the steps whose execution would change none of them.
//!
//! A step is a rung or a statement of a program's routine. A step that was executed without any change of the memory, and whose result depends on the
//! memory alone, would change nothing the next time either, until one of its operands changes: it is *settled*, and the scan passes over it. A scan
//! therefore takes time only for steps that are not settled. Every write to the memory goes through [`Memory`], which unsettles the steps that have a
//! changed bit among their operands.
//!
//! A rung that would change nothing but the time of its running timer is settled too, and *timing*: the scan only brings the timer forward.

use std::ops::Deref;
use std::sync::Arc;

use arcline_instruction_set::MotionControl;

use crate::readers::{Readers, WORD};

/// The bytes of all tags of a project; a tag begins at [`Tag::at`](crate::Tag::at). It is read as a slice. Writes outside of it do nothing.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    bytes: Vec<u8>,
    readers: Arc<Readers>,
    /// A bit for each step.
    settled: Vec<u64>,
    /// A bit for each step, which counts while it is settled.
    timing: Vec<u64>,
    /// Writes that have changed a byte.
    changes: u64,
}

impl Deref for Memory {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

impl Memory {
    pub(crate) fn new(bytes: Vec<u8>) -> Self {
        Memory {
            bytes,
            ..Memory::default()
        }
    }

    /// Takes the readers of a project's steps; none is settled.
    pub(crate) fn set_readers(&mut self, readers: Readers) {
        self.settled = vec![0; (readers.steps as usize).div_ceil(64)];
        self.timing = self.settled.clone();
        self.readers = Arc::new(readers);
    }

    /// Writes that have changed a byte so far.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Writes some bytes.
    pub(crate) fn put<const N: usize>(&mut self, at: usize, new: [u8; N]) {
        self.put_except(at, new, u32::MAX);
    }

    /// The same without unsettling one step.
    pub(crate) fn put_except<const N: usize>(&mut self, at: usize, new: [u8; N], step: u32) {
        let Some(old) = self.replace(at, new) else { return };
        match (<[u8; WORD]>::try_from(&old[..]), <[u8; WORD]>::try_from(&new[..])) {
            (Ok(old), Ok(new)) if at.is_multiple_of(WORD) => {
                self.unsettle(at / WORD, u32::from_le_bytes(old) ^ u32::from_le_bytes(new), step);
            }
            _ => {
                for ((old, new), at) in old.into_iter().zip(new).zip(at..) {
                    self.unsettle(at / WORD, u32::from(old ^ new) << (8 * (at % WORD)), step);
                }
            }
        }
    }

    /// Writes some bytes without unsettling any step; returns those before, if they were others.
    pub(crate) fn replace<const N: usize>(&mut self, at: usize, new: [u8; N]) -> Option<[u8; N]> {
        let place = self.bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut)?;
        let old = std::mem::replace(place, new);
        let is_changed = old != new;
        self.changes += u64::from(is_changed);
        is_changed.then_some(old)
    }

    /// Writes those bits of a byte that a mask has, from a value.
    pub fn put_bits(&mut self, at: usize, mask: u8, value: u8) {
        if let Some(old) = self.bytes.get(at).copied() {
            self.put(at, [old & !mask | value & mask]);
        }
    }

    /// Sets or clears the bits of a mask.
    pub(crate) fn set(&mut self, at: usize, mask: u8, on: bool) {
        self.put_bits(at, mask, if on { mask } else { 0 });
    }

    /// Writes bytes; none, if they do not fit.
    pub fn write(&mut self, at: usize, new: &[u8]) {
        let Some(place) = self.bytes.get_mut(at..at.saturating_add(new.len())) else {
            return;
        };
        if place == new {
            return;
        }
        // Word by word: an equal word between two different ones unsettles no step.
        for (number, part) in new.chunks(WORD).enumerate() {
            let at = at + number * WORD;
            match <[u8; WORD]>::try_from(part) {
                Ok(part) => self.put(at, part),
                Err(_) => part.iter().zip(at..).for_each(|(byte, at)| self.put(at, [*byte])),
            }
        }
    }

    /// Writes the same byte to a range.
    pub(crate) fn fill(&mut self, range: std::ops::Range<usize>, byte: u8) {
        range.for_each(|at| self.put(at, [byte]));
    }

    /// Changes a motion control tag.
    pub fn change_control(&mut self, at: usize, change: impl FnOnce(&mut MotionControl)) {
        let Some(bytes) = self.bytes.get(at..).and_then(<[u8]>::first_chunk) else {
            return;
        };
        let mut control = MotionControl::from_bytes(*bytes);
        change(&mut control);
        self.put(at, control.to_bytes());
    }

    /// Copies bytes; the ranges may overlap. Both must lie within the memory.
    pub(crate) fn copy(&mut self, from: usize, to: usize, count: usize) {
        if self.bytes.get(from..from + count) == self.bytes.get(to..to + count) {
            return;
        }
        self.bytes.copy_within(from..from + count, to);
        self.changes += 1;
        for word in to / WORD..(to + count).div_ceil(WORD) {
            self.unsettle(word, u32::MAX, u32::MAX);
        }
    }

    /// Unsettles the steps that have one of these bits among their operands, except one.
    fn unsettle(&mut self, word: usize, bits: u32, except: u32) {
        if bits == 0 {
            return;
        }
        let Self { readers, settled, .. } = self;
        readers.each(word, bits, |step| {
            if step != except
                && let Some(settled) = settled.get_mut(step as usize / 64)
            {
                *settled &= !(1 << (step % 64));
            }
        });
    }

    /// A step would change nothing, or nothing but the time of its timer.
    pub(crate) fn settle(&mut self, step: u32, timing: bool) {
        let (place, bit) = (step as usize / 64, 1 << (step % 64));
        if let (Some(settled), Some(word)) = (self.settled.get_mut(place), self.timing.get_mut(place)) {
            *settled |= bit;
            *word = if timing { *word | bit } else { *word & !bit };
        }
    }

    /// The settled steps from one on, as far as they have a word in common: bits from that step on, and the timing ones among them.
    pub(crate) fn settled(&self, step: u32) -> (u64, u64) {
        let place = step as usize / 64;
        let (Some(settled), Some(timing)) = (self.settled.get(place), self.timing.get(place)) else {
            return (0, 0);
        };
        (settled >> (step % 64), (settled & timing) >> (step % 64))
    }
}
