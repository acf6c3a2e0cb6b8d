//! Any bytes as a message: every decoder; what decodes to a request or path must survive a round trip.
#![no_main]

use arcline_fuzz::timed;
use arcline_proto::arcline::execution::Ending;
use arcline_proto::arcline::motion::{Accepted, decode_instances};
use arcline_proto::arcline::trace::{ListSignals, ReadRows, Rows, SignalList, TraceRequest};
use arcline_proto::cip::{self, Reply, Request};
use arcline_proto::connection::{ForwardClose, ForwardOpen, ForwardOpenReply, UnconnectedSend};
use arcline_proto::cpf::Packet;
use arcline_proto::epath::{Epath, Target};
use arcline_proto::identity::Identity;
use arcline_proto::logix::{
    CreateSymbol, Definition, ReadModifyWrite, ReadReply, ReadTag, ReadTemplate, Symbol, TemplateAttributes, WriteTag,
    decode_operands,
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
    let definition = Definition::decode(&data, 3);
    let _ = definition.and_then(|definition| definition.build(1, TemplateAttributes::default(), |_| None));
    let _ = (Rows::decode(&data), SignalList::decode(&data), Ending::decode(&data));
    let _ = (Accepted::decode(&data), decode_instances(&data));
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
    let _ = (
        TraceRequest::decode(data),
        ListSignals::decode(data),
        ReadRows::decode(data),
    );
    let _ = (decode_operands(data), CreateSymbol::decode(data));
}
