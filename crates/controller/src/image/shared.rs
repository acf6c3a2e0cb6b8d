//! Memory that copies of an image share until one of them changes it: a copy is cheap, whatever its tags hold.
//!
//! Sizes are bytes.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A value that clones share. Changing a shared value makes a copy first.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Shared<T>(Arc<T>);

impl<T> Shared<T> {
    pub(super) fn new(value: T) -> Self {
        Self(Arc::new(value))
    }

    /// Both share the same value, so there is no difference.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Clone> DerefMut for Shared<T> {
    fn deref_mut(&mut self) -> &mut T {
        Arc::make_mut(&mut self.0)
    }
}

/// Data that the machine uses, which the image frees when it holds the last reference. Copies of the image are only read: they hold no such
/// data, and so do not keep them from being freed.
#[derive(Debug)]
pub(super) struct Unshared<T>(Vec<T>);

impl<T> Default for Unshared<T> {
    fn default() -> Self {
        Unshared(Vec::new())
    }
}

impl<T> Clone for Unshared<T> {
    fn clone(&self) -> Self {
        Unshared::default()
    }
}

impl<T> Deref for Unshared<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T> DerefMut for Unshared<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}

/// The bytes of one tag.
pub(super) type TagBytes = Shared<Vec<u8>>;

/// The bytes of tags by index, in groups: a change copies the bytes of one tag and the list of one group.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Memory(Vec<Shared<Vec<TagBytes>>>);

impl Memory {
    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        let bytes = self.0.get(index / GROUP)?.get(index % GROUP)?;
        Some(bytes.as_slice())
    }

    pub(super) fn get_mut(&mut self, index: usize) -> Option<&mut Vec<u8>> {
        let bytes = self.0.get_mut(index / GROUP)?.get_mut(index % GROUP)?;
        Some(bytes)
    }

    /// Calls `note` with every index whose bytes differ from those of a memory with the same indices.
    pub(super) fn for_each_difference(&self, before: &Self, mut note: impl FnMut(usize)) {
        for (number, (now, before)) in self.0.iter().zip(&before.0).enumerate() {
            if now.is_same(before) {
                continue;
            }
            for (index, (now, before)) in now.iter().zip(before.iter()).enumerate() {
                if !now.is_same(before) && **now != **before {
                    note(number * GROUP + index);
                }
            }
        }
    }

    /// Inserts bytes at an index; those at it and behind it move up.
    ///
    /// # Panics
    /// If the index is neither among the others nor directly behind them.
    pub(super) fn insert(&mut self, index: usize, bytes: Vec<u8>) {
        let bytes = TagBytes::new(bytes);
        let in_the_last = index / GROUP + 1 == self.0.len();
        let at_the_end = index == self.len();
        match self.0.last_mut() {
            Some(last) if in_the_last && last.len() < GROUP => last.insert(index % GROUP, bytes),
            _ if at_the_end => self.0.push(Shared::new(vec![bytes])),
            _ => {
                let mut all = self.all();
                all.insert(index, bytes);
                *self = Self::of(all);
            }
        }
    }

    pub(super) fn remove(&mut self, index: usize) {
        let mut all = self.all();
        all.remove(index);
        *self = Self::of(all);
    }

    fn len(&self) -> usize {
        match self.0.split_last() {
            Some((last, others)) => others.len() * GROUP + last.len(),
            None => 0,
        }
    }

    fn all(&self) -> Vec<TagBytes> {
        self.0.iter().flat_map(|group| group.iter().cloned()).collect()
    }

    fn of(all: Vec<TagBytes>) -> Self {
        Self(all.chunks(GROUP).map(|group| Shared::new(group.to_vec())).collect())
    }
}

/// Tags of a group. Axes and coordinate systems, which change with every tick, are in the first groups.
const GROUP: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_a_list_whatever_is_put_in_and_taken_out() {
        let mut memory = Memory::default();
        let mut list: Vec<Vec<u8>> = Vec::new();
        // Indices over all groups, in steps that have no common factor with any length here.
        for step in 0..400_usize {
            let number = step.to_le_bytes().to_vec();
            let index = if step % 3 == 0 {
                list.len()
            } else {
                step * 7919 % (list.len() + 1)
            };
            list.insert(index, number.clone());
            memory.insert(index, number);
            if step % 5 == 4 {
                let gone = step * 104_729 % list.len();
                list.remove(gone);
                memory.remove(gone);
            }
            assert_eq!(memory.len(), list.len());
        }
        let held: Vec<Vec<u8>> = (0..=list.len())
            .map_while(|index| memory.get(index).map(<[u8]>::to_vec))
            .collect();
        assert_eq!(held, list);
    }

    #[test]
    fn a_copy_keeps_its_values() {
        let mut memory = Memory::default();
        (0..100).for_each(|byte| memory.insert(usize::from(byte), vec![byte]));
        let copy = memory.clone();
        memory.get_mut(70).expect("there are a hundred")[0] = 1;
        memory.remove(3);
        assert_eq!((memory.get(69), memory.get(3)), (Some(&[1][..]), Some(&[4][..])));
        assert_eq!((copy.get(70), copy.get(3)), (Some(&[70][..]), Some(&[3][..])));
    }
}
