//! The difference between two copies of an image.

use super::{Image, TagId};

impl Image {
    /// Calls `note` with every tag whose bytes differ from those in an earlier copy, and with every tag that exists in only one of
    /// the two. Shared parts of the copies are not compared.
    pub fn for_each_change(&self, before: &Image, mut note: impl FnMut(TagId)) {
        if self.tags.is_same(&before.tags) {
            self.bytes.for_each_difference(&before.bytes, |row| {
                if let Some(tag) = self.tags.get(row) {
                    note(tag.id);
                }
            });
            return;
        }
        for tag in self.tags.iter() {
            if before.tag(tag.id).is_none_or(|other| other.name != tag.name)
                || before.bytes(tag.id) != self.bytes(tag.id)
            {
                note(tag.id);
            }
        }
        for tag in before.tags.iter().filter(|tag| self.tag(tag.id).is_none()) {
            note(tag.id);
        }
    }
}

#[cfg(test)]
mod tests {
    use arcline_tag::{Elementary, TagType, Value};

    use super::*;
    use crate::image::PlainTag;
    use crate::image::tests::machine;

    /// Names of the tags that differ.
    fn changed(now: &Image, before: &Image) -> Vec<String> {
        let mut names = Vec::new();
        now.for_each_change(before, |id| {
            let tag = now.tag(id).or_else(|| before.tag(id)).expect("one of both has it");
            names.push(tag.name.clone());
        });
        names
    }

    #[test]
    fn differences_are_found() {
        let plain: Vec<PlainTag> = (0..150)
            .map(|number| PlainTag::new(format!("T{number}"), TagType::scalar(Elementary::Dint)))
            .collect();
        let mut image = Image::new(&machine(), &[], &plain);
        let before = image.clone();
        assert_eq!(changed(&image, &before), [""; 0], "a copy");
        for (path, value) in [("T3", 1), ("T140", 2), ("T7", 0)] {
            let path = path.parse().expect(path);
            image.write_value(&path, Value::Dint(value)).expect("a plain tag");
        }
        assert_eq!(
            changed(&image, &before),
            ["T3", "T140"],
            "what was written as it was is no change"
        );
        let written = image.clone();
        image
            .create(&PlainTag::new("New", TagType::scalar(Elementary::Dint)))
            .expect("there is room");
        assert_eq!(changed(&image, &written), ["New"], "it came");
        assert_eq!(changed(&written, &image), ["New"], "it went");
    }
}
