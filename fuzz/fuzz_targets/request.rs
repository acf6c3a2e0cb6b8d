//! Any bytes as a message: every decoder; what decodes to a request or path must survive a round trip.
#![no_main]

use arcline_fuzz::timed;
use arcline_proto::cip::{self, Reply, Request};
use arcline_proto::connection::{ForwardClose, ForwardOpen, ForwardOpenReply, UnconnectedSend};
use arcline_proto::cpf::Packet;
use arcline_proto::epath::{Epath, Target};
use arcline_proto::identity::Identity;
use arcline_proto::logix::{
    ReadModifyWrite, ReadReply, ReadTag, ReadTemplate, Symbol, TemplateAttributes, WriteTag, decode_operands,
};
use bytes::Bytes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| timed(|| run(data)));

fn run(data: &[u8]) {
    let data = Bytes::copy_from_slice(data);
    if let Ok(path) = Epath::decode(&data) {
        assert_eq!(Epath::decode(&path.to_bytes()), Ok(path));
    }
    let _ = (
        Reply::decode(&data),
        Packet::decode(&data),
        Identity::decode_all(&data),
        Identity::decode_item(&data),
    );
    let _ = (
        ReadReply::decode(&data),
        ForwardOpenReply::decode(&data),
        TemplateAttributes::decode(&data),
    );
    let _ = (
        Symbol::decode_list(&data, &[1, 2, 8]),
        cip::split_multiple_replies(&data),
    );
    let Ok(request) = Request::decode(&data) else {
        return;
    };
    let _ = Target::new(&request.path).map(|target| target.tag_path().map(|path| path.to_string()));
    let data = &request.data;
    let _ = (
        ReadTag::decode(data),
        ReadTag::decode_fragmented(data),
        WriteTag::decode(data),
    );
    let _ = (
        WriteTag::decode_fragmented(data),
        ReadModifyWrite::decode(data),
        ReadTemplate::decode(data),
    );
    let _ = (
        cip::decode_attribute_ids(data),
        cip::split_multiple(data),
        UnconnectedSend::decode(data),
    );
    let _ = (
        ForwardOpen::decode(data, true),
        ForwardOpen::decode(data, false),
        ForwardClose::decode(data),
    );
    let _ = decode_operands(data);
}
