//! Any bytes as a path of a request, and any text as the name of a tag: what decodes is the same after a round trip, and what
//! leads somewhere in a machine's tags leads to bytes that are there.
#![no_main]

use std::sync::LazyLock;

use arcline_controller::image::{Image, TagId};
use arcline_fuzz::timed;
use arcline_proto::epath::{Epath, Target};
use arcline_tag::{Location, TagPath};
use bytes::Bytes;
use libfuzzer_sys::fuzz_target;

/// Structures in arrays in structures, several dimensions, a program, bits, aliases.
const TAGS: &str = r#"
[[data_type]]
name = "P"
members = [{ name = "A", type = "REAL[2]" }, { name = "V", type = "BOOL" }, { name = "I", type = "SINT" }]
[[data_type]]
name = "R"
members = [{ name = "N", type = "STRING" }, { name = "P", type = "P[2]" }]
[[tag]]
name = "R"
type = "R[2]"
[[tag]]
name = "G"
type = "INT[2,3]"
[[tag]]
name = "Bools"
type = "BOOL[64]"
[[tag]]
name = "C"
program = "M"
type = "DINT"
[[tag]]
name = "V"
alias = "R[1].P[0].V"
"#;

static IMAGE: LazyLock<Image> = LazyLock::new(|| {
    let text = format!("{}{TAGS}", arcline_config::DEFAULT);
    let project = arcline_config::load(&text, "fuzz").expect("a valid configuration");
    Image::new(&project.machine, &project.instruction_tags, &project.tags)
});

fuzz_target!(
    init: {
        // Not within the time of the first input.
        LazyLock::force(&IMAGE);
    },
    |data: &[u8]| timed(|| run(data))
);

fn run(data: &[u8]) {
    if let Ok(path) = Epath::decode(&Bytes::copy_from_slice(data)) {
        assert_eq!(Epath::decode(&path.to_bytes()).as_ref(), Ok(&path));
        if let Ok(target) = Target::new(&path) {
            follow(&target);
        }
    }
    let Some(path) = std::str::from_utf8(data)
        .ok()
        .and_then(|text| text.parse::<TagPath>().ok())
    else {
        return;
    };
    let again: TagPath = path.to_string().parse().expect("what was printed can be read");
    assert_eq!(again, path);
    let (epath, _) = Epath::from_tag(&path);
    let _ = Epath::decode(&epath.to_bytes()).map(|epath| Target::new(&epath).map(|target| follow(&target)));
    if let Ok((tag, place)) = IMAGE.locate(&path) {
        is_there(tag, &place);
    }
}

fn follow(target: &Target) {
    let found = match target.instance {
        None => IMAGE.resolve(&target.symbols).ok(),
        Some(instance) => IMAGE
            .tag(TagId(instance))
            .and_then(|tag| IMAGE.resolve_in(tag, &target.members).ok()),
    };
    if let Some((tag, place)) = found {
        is_there(tag, &place);
    }
    let _ = target.tag_path().map(|path| path.to_string());
}

fn is_there(tag: TagId, place: &Location) {
    let end = match place.bit {
        Some(bit) => place.offset + usize::from(bit / 8) + 1,
        None => place.offset + place.elements as usize * place.element_size(),
    };
    assert!(end <= IMAGE.bytes(tag).len(), "{place:?} of {tag:?}");
}
