//! The client against a server in memory: fragments, fallbacks, timeouts, cancelled requests, and servers that lie.
#![allow(clippy::unwrap_used)]

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use arcline_client::{Client, ClientError, Flag, Mnemonic, Options};
use arcline_proto::cip::{CipStatus, MultipleReplies, Reply, Request, class, service, split_multiple};
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, RegisterSession, SessionHandle};
use arcline_proto::epath::{Epath, Segment, Target};
use arcline_proto::identity::Identity;
use arcline_proto::logix::{
    Definition, ReadTag, ReadTemplate, Symbol, TemplateAttributes, WireType, WriteTag, instance_list_reply,
};
use arcline_proto::session::{Draws, Event, ServerSession, Settings, TestHost};
use arcline_tag::{Elementary, TagType, Template, TemplateBuilder, string_template};
use bytes::{Bytes, BytesMut};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};

/// Answers requests; `None` never answers.
type Handler = Box<dyn FnMut(&Request, usize) -> Option<Reply> + Send>;

async fn serve(stream: DuplexStream, settings: Settings, handler: Handler) {
    serve_losing(stream, settings, handler, Arc::default()).await;
}

/// Serves, and loses the next reply when `lose` is set.
async fn serve_losing(mut stream: DuplexStream, settings: Settings, mut handler: Handler, lose: Arc<AtomicBool>) {
    let mut host = TestHost {
        identity: Identity::new("Fake", 1),
        ..TestHost::new(Draws::Mixed(7))
    };
    let local = "127.0.0.1:44818".parse().unwrap();
    let mut session = ServerSession::new(Arc::new(settings), local, Duration::ZERO);
    let mut input = BytesMut::new();
    loop {
        session.handle_input(&mut input, Duration::ZERO, &mut host);
        while let Some(event) = session.poll_event() {
            match event {
                Event::Outgoing(_) if lose.swap(false, Ordering::Relaxed) => {}
                Event::Outgoing(bytes) => {
                    if stream.write_all(&bytes).await.is_err() {
                        return;
                    }
                }
                Event::Request {
                    id,
                    request,
                    reply_budget,
                    ..
                } => {
                    if let Some(reply) = handler(&request, reply_budget) {
                        session.reply(id, &reply, Duration::ZERO);
                    }
                }
                Event::IoReady(_) => {}
                Event::Close(_) => return,
            }
        }
        if stream.read_buf(&mut input).await.unwrap_or(0) == 0 {
            return;
        }
    }
}

async fn connect_with(settings: Settings, handler: Handler) -> Result<Client, ClientError> {
    let (ours, theirs) = duplex(1 << 16);
    tokio::spawn(serve(theirs, settings, handler));
    Client::over(ours, &Options::default()).await
}

/// A controller with a few tags in plain memory.
struct Memory {
    tags: Vec<(Symbol, TagType, Vec<u8>)>,
    templates: Vec<Arc<Template>>,
}

impl Memory {
    fn new() -> Self {
        let part = TemplateBuilder::new("Part", 0x123)
            .member("Ready", Elementary::Bool)
            .array("Position", Elementary::Real, 3)
            .member("Name", string_template())
            .build();
        let types = [
            ("Speed", TagType::scalar(Elementary::Real)),
            ("Count", TagType::scalar(Elementary::Int)),
            ("Big", TagType::array(Elementary::Dint, 5000)),
            ("Part1", TagType::scalar(part.clone())),
            ("Label", TagType::scalar(string_template())),
        ];
        let tags = types.into_iter().enumerate().map(|(place, (name, tag_type))| {
            let symbol = Symbol {
                instance: place as u32 + 1,
                name: name.to_owned(),
                symbol_type: tag_type.symbol_type(),
                dimensions: tag_type.dimensions,
                ..Symbol::default()
            };
            let size = tag_type.size();
            (symbol, tag_type, vec![0; size])
        });
        Self {
            tags: tags.collect(),
            templates: vec![part, string_template()],
        }
    }

    fn handle(&mut self, request: &Request, budget: usize) -> Reply {
        let target = Target::new(&request.path).unwrap();
        let unknown = Reply::error(request.service, CipStatus::PATH_DESTINATION_UNKNOWN.with(0));
        match (target.class, request.service) {
            (Some(class::MESSAGE_ROUTER), service::MULTIPLE_SERVICE_PACKET) => {
                let requests = split_multiple(&request.data).unwrap();
                let mut replies = MultipleReplies::new(requests.len(), budget).unwrap();
                for request in requests {
                    let reply = self.handle(&request.unwrap(), replies.budget());
                    replies.push(&reply);
                }
                replies.finish()
            }
            (Some(class::SYMBOL), _) => {
                let ids = arcline_proto::cip::decode_attribute_ids(&request.data).unwrap();
                let start = target.instance.unwrap_or_default();
                // Pages of about two tags.
                instance_list_reply(self.tags.iter().map(|(symbol, ..)| symbol), start, &ids, budget.min(80))
            }
            (Some(class::TEMPLATE), code) => {
                let found = self
                    .templates
                    .iter()
                    .find(|t| Some(u32::from(t.instance)) == target.instance);
                let Some(template) = found else { return unknown };
                if code == service::GET_ATTRIBUTE_LIST {
                    let ids = arcline_proto::cip::decode_attribute_ids(&request.data).unwrap();
                    Definition::of(template).0.reply(&ids, budget)
                } else {
                    ReadTemplate::decode(&request.data)
                        .unwrap()
                        .reply(&Definition::of(template).1.to_bytes(), budget.min(64))
                }
            }
            (None, code) => {
                let Some(path) = target.tag_path() else { return unknown };
                let name = path.tag().unwrap();
                let found = self
                    .tags
                    .iter_mut()
                    .find(|(symbol, ..)| symbol.name.eq_ignore_ascii_case(name));
                let Some((_, tag_type, bytes)) = found else {
                    return unknown;
                };
                let place = tag_type.locate(path.rest()).unwrap();
                let size = place.element_size();
                let wire = match &place.data_type {
                    arcline_tag::DataType::Elementary(elementary) => WireType::from(*elementary),
                    arcline_tag::DataType::Structure(template) => WireType::Structure(template.handle),
                };
                let bytes = &mut bytes[place.offset..];
                match code {
                    service::READ_TAG | service::READ_TAG_FRAGMENTED => {
                        let read = match code {
                            service::READ_TAG => ReadTag::decode(&request.data),
                            _ => ReadTag::decode_fragmented(&request.data),
                        };
                        let read = read.unwrap();
                        let all = bytes[..size * usize::from(read.elements)].to_vec();
                        read.reply(code, wire, size, &all, budget)
                    }
                    _ => {
                        let write = match code {
                            service::WRITE_TAG => WriteTag::decode(&request.data),
                            _ => WriteTag::decode_fragmented(&request.data),
                        };
                        let write = write.unwrap();
                        if write.data_type != wire {
                            return Reply::error(code, CipStatus::GENERAL_ERROR.with(0x2107));
                        }
                        let start = write.offset as usize;
                        bytes[start..start + write.data.len()].copy_from_slice(&write.data);
                        Reply::success(code, Bytes::new())
                    }
                }
            }
            _ => unknown,
        }
    }
}

async fn memory(settings: Settings) -> Client {
    let mut memory = Memory::new();
    connect_with(
        settings,
        Box::new(move |request, budget| Some(memory.handle(request, budget))),
    )
    .await
    .unwrap()
}

#[tokio::test]
async fn tags_are_browsed_read_and_written_over_every_kind_of_connection() {
    for (why, settings) in [
        ("a large connection", Settings::default()),
        (
            "a small one",
            Settings {
                max_connection_size: 500,
                ..Settings::default()
            },
        ),
        (
            "none",
            Settings {
                max_connections: 0,
                ..Settings::default()
            },
        ),
    ] {
        let client = memory(settings).await;
        let names: Vec<String> = client
            .browse()
            .await
            .unwrap()
            .iter()
            .map(|t| format!("{} {}", t.name, t.type_name()))
            .collect();
        assert_eq!(
            names,
            [
                "Speed REAL",
                "Count INT",
                "Big DINT[5000]",
                "Part1 Part",
                "Label STRING"
            ],
            "{why}"
        );

        client.write("Speed", 2.5).await.unwrap();
        client.write("count", -7).await.unwrap();
        client.write("Part1.Position[1]", vec![1.5, 2.5]).await.unwrap();
        client.write("Part1.Name", "bolt").await.unwrap();
        let numbers: Vec<i64> = (0..5000).collect();
        client.write("Big", numbers).await.unwrap();
        assert_eq!(client.read("SPEED").await.unwrap().as_f64(), Some(2.5), "{why}");
        let big = client.read("Big").await.unwrap().numbers().unwrap();
        assert!(
            big.iter().enumerate().all(|(place, number)| *number == place as f64) && big.len() == 5000,
            "{why}"
        );
        let part = client.read("Part1").await.unwrap();
        assert_eq!(
            part.to_string(),
            "Part(Ready := false, Position := [0, 1.5, 2.5], Name := 'bolt')",
            "{why}"
        );
        assert_eq!(
            client.read_numbers("Part1.Position[1]").await.unwrap(),
            [1.5, 2.5],
            "{why}"
        );

        let many = client
            .read_many(&["Speed", "Nothing", "Big", "Count", "Part1.Name"])
            .await
            .unwrap();
        let shown: Vec<String> = many
            .iter()
            .map(|r| r.as_ref().map_or_else(ToString::to_string, |r| r.to_string()))
            .collect();
        assert_eq!(shown[0], "2.5", "{why}");
        assert!(
            shown[1].starts_with("there is no tag \"Nothing\""),
            "{why}: {}",
            shown[1]
        );
        assert!(shown[2].ends_with(", 4999]"), "{why}");
        assert_eq!(shown[3..], ["-7", "'bolt'"], "{why}");
        client.close().await;
    }
}

#[tokio::test]
async fn values_that_do_not_fit_are_refused_without_asking() {
    let client = memory(Settings::default()).await;
    for (path, value) in [("Count", 40_000), ("Big", 1), ("Part1", 1), ("Label", 1)] {
        let error = client.write(path, value).await.unwrap_err();
        assert!(matches!(error, ClientError::Value { .. }), "{path}: {error}");
    }
    let long = "x".repeat(83);
    assert!(
        matches!(
            client.write("Label", long.as_str()).await,
            Err(ClientError::Value { .. })
        ),
        "a long text"
    );
    assert!(
        matches!(client.read("Speed.X").await, Err(ClientError::Path { .. })),
        "no member"
    );
    assert!(
        matches!(client.read("Big[5000]").await, Err(ClientError::Path { .. })),
        "beyond the array"
    );
    let error = client.read("Sped").await.unwrap_err();
    assert_eq!(error.to_string(), "there is no tag \"Sped\", did you mean \"Speed\"?");
}

#[tokio::test(start_paused = true)]
async fn a_silent_server_times_out() {
    let client = connect_with(Settings::default(), Box::new(|_, _| None)).await.unwrap();
    let error = client.read("Speed").await.unwrap_err();
    assert!(
        matches!(error, ClientError::Timeout { after } if after == Duration::from_secs(5)),
        "{error}"
    );
    assert!(error.is_connection());
}

/// A client of a controller in memory whose reply to the first request of a service is lost; and the services of all
/// requests that the controller has carried out.
async fn client_losing(lost: u8) -> (Client, Arc<Mutex<Vec<u8>>>) {
    let mut memory = Memory::new();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let lose = Arc::new(AtomicBool::default());
    let (services, loses) = (seen.clone(), lose.clone());
    let handler = move |request: &Request, budget: usize| {
        let mut services = services.lock().unwrap();
        if request.service == lost && !services.contains(&lost) {
            loses.store(true, Ordering::Relaxed);
        }
        services.push(request.service);
        Some(memory.handle(request, budget))
    };
    let (ours, theirs) = duplex(1 << 16);
    tokio::spawn(serve_losing(theirs, Settings::default(), Box::new(handler), lose));
    (Client::over(ours, &Options::default()).await.unwrap(), seen)
}

fn count(seen: &Mutex<Vec<u8>>, code: u8) -> usize {
    seen.lock().unwrap().iter().filter(|service| **service == code).count()
}

#[tokio::test(start_paused = true)]
async fn a_read_without_a_reply_is_repeated_on_a_new_connection() {
    let (client, seen) = client_losing(service::READ_TAG).await;
    client.write("Count", 7).await.unwrap();
    let start = tokio::time::Instant::now();
    assert_eq!(client.read("Count").await.unwrap().as_f64(), Some(7.0));
    assert_eq!(start.elapsed().as_secs(), 5, "after the time-out of the first one");
    assert_eq!(count(&seen, service::READ_TAG), 2);
    assert_eq!(
        client.read("Count").await.unwrap().as_f64(),
        Some(7.0),
        "and it stays open"
    );
    assert_eq!(count(&seen, service::READ_TAG), 3);
}

#[tokio::test(start_paused = true)]
async fn a_write_without_a_reply_is_never_repeated() {
    let (client, seen) = client_losing(service::WRITE_TAG).await;
    client.browse().await.unwrap();
    let error = client.write("Count", 7).await.unwrap_err();
    assert!(matches!(error, ClientError::Timeout { .. }), "{error}");
    assert_eq!(count(&seen, service::WRITE_TAG), 1, "the controller has carried it out");
    assert_eq!(
        client.read("Count").await.unwrap().as_f64(),
        Some(7.0),
        "the next request opens the connection again"
    );
    client.write("Count", 8).await.unwrap();
    assert_eq!(count(&seen, service::WRITE_TAG), 2, "once more, on purpose");
    assert_eq!(client.read("Count").await.unwrap().as_f64(), Some(8.0));
}

#[tokio::test(start_paused = true)]
async fn a_write_that_waited_behind_a_lost_read_is_sent_once() {
    let (client, seen) = client_losing(service::READ_TAG).await;
    client.browse().await.unwrap();
    let (read, written) = tokio::join!(client.read("Speed"), async {
        // Later than the read, so that its own time is not over.
        tokio::time::sleep(Duration::from_secs(1)).await;
        client.write("Count", 7).await
    });
    read.unwrap();
    written.unwrap();
    assert_eq!(count(&seen, service::WRITE_TAG), 1);
    assert_eq!(client.read("Count").await.unwrap().as_f64(), Some(7.0));
}

#[tokio::test(start_paused = true)]
async fn a_peer_that_never_registers_times_out() {
    let (ours, _theirs) = duplex(64);
    let error = Client::over(ours, &Options::default()).await.unwrap_err();
    assert!(matches!(error, ClientError::Timeout { .. }), "{error}");
}

#[tokio::test(start_paused = true)]
async fn an_abandoned_request_spoils_nothing() {
    let mut memory = Memory::new();
    let client = connect_with(Settings::default(), Box::new(move |r, b| Some(memory.handle(r, b))))
        .await
        .unwrap();
    client.write("Speed", 1.0).await.unwrap();
    client.write("Count", 2).await.unwrap();
    for _ in 0..100 {
        // Polled once, then dropped: the answer arrives after its caller has gone.
        tokio::select! {
            biased;
            _ = client.read("Speed") => {}
            () = tokio::task::yield_now() => {}
        }
        assert_eq!(client.read("Count").await.unwrap().as_f64(), Some(2.0));
    }
}

/// The results of requests to a lying server that puts `data` into every successful reply.
async fn lied_to(data: Bytes, status: CipStatus) -> Vec<Result<(), ClientError>> {
    let handler = move |request: &Request, _| Some(Reply::with_status(request.service, status, data.clone()));
    let client = connect_with(Settings::default(), Box::new(handler)).await.unwrap();
    vec![
        client.browse().await.map(drop),
        client.read("Speed").await.map(drop),
        client.execute(Mnemonic::Mso, "X", "", &[]).await.map(drop),
        client.instruction(1).await.map(drop),
        client.read_many(&["A", "B"]).await.map(drop),
    ]
}

#[tokio::test(start_paused = true)]
async fn hostile_replies_are_errors_and_end() {
    for status in [
        CipStatus::SUCCESS,
        CipStatus::PARTIAL_TRANSFER,
        CipStatus::EMBEDDED_SERVICE_ERROR,
    ] {
        for byte in [0x00, 0x01, 0x7F, 0xFF] {
            for length in [0, 1, 2, 3, 4, 5, 7, 16, 19, 20, 64, 1000] {
                // The calls end without a panic and without a huge allocation.
                let results = lied_to(Bytes::from(vec![byte; length]), status).await;
                assert_eq!(results.len(), 5);
            }
        }
    }
}

#[tokio::test]
async fn a_server_that_lies_about_its_tags_is_found_out() {
    // (why, symbol type, dimensions)
    for (why, symbol_type, dimensions) in [
        ("a read that stays partial for good", 0x20C4, [1000, 0, 0]),
        ("more elements than can be asked for", 0x20C4, [u32::MAX, 0, 0]),
        ("an endless template", 0x8123, [0, 0, 0]),
    ] {
        let symbol = Symbol {
            instance: 1,
            name: "Tag".to_owned(),
            symbol_type,
            dimensions,
            ..Symbol::default()
        };
        let handler = move |request: &Request, budget: usize| {
            let by_class = |id| request.path.0.first() == Some(&Segment::Class(id));
            Some(if by_class(0x6B) {
                let ids = arcline_proto::cip::decode_attribute_ids(&request.data).unwrap();
                instance_list_reply([&symbol], 0, &ids, budget)
            } else if by_class(0x6C) && request.service == service::GET_ATTRIBUTE_LIST {
                let ids = arcline_proto::cip::decode_attribute_ids(&request.data).unwrap();
                let huge = TemplateAttributes {
                    handle: 1,
                    members: 0xFFFF,
                    definition_words: u32::MAX,
                    size: u32::MAX,
                };
                huge.reply(&ids, budget)
            } else {
                Reply::with_status(
                    request.service,
                    CipStatus::PARTIAL_TRANSFER,
                    Bytes::from_static(&[0xC4, 0, 1, 0, 0, 0]),
                )
            })
        };
        let client = connect_with(Settings::default(), Box::new(handler)).await.unwrap();
        let result = client.read("Tag").await;
        match symbol_type {
            0x20C4 if dimensions[0] == 1000 => assert!(matches!(result, Err(ClientError::Malformed { .. })), "{why}"),
            _ => assert!(matches!(result, Err(ClientError::TooLarge { .. })), "{why}: {result:?}"),
        }
    }
}

#[tokio::test]
async fn a_stream_that_cannot_be_read_ends_the_connection() {
    let (ours, mut theirs) = duplex(1 << 16);
    tokio::spawn(async move {
        let mut input = BytesMut::new();
        loop {
            theirs.read_buf(&mut input).await.unwrap();
            if let Ok(Some(frame)) = FrameDecoder::default().decode(&mut input) {
                let reply = match frame.header.command {
                    Command::REGISTER_SESSION => {
                        let mut header = frame.header;
                        header.session = SessionHandle(5);
                        EncapFrame::reply(&header, RegisterSession::CURRENT.to_bytes()).to_bytes()
                    }
                    // A frame that claims 65,535 bytes.
                    _ => Bytes::from_static(&[
                        0x6F, 0, 0xFF, 0xFF, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                    ]),
                };
                theirs.write_all(&reply).await.unwrap();
            }
        }
    });
    let error = Client::over(ours, &Options::default()).await.unwrap_err();
    assert!(error.is_connection(), "{error}");
}

#[tokio::test]
async fn a_server_that_goes_away_is_a_lost_connection() {
    let (ours, theirs) = duplex(1 << 16);
    let task = tokio::spawn(serve(theirs, Settings::default(), Box::new(|_, _| None)));
    let client = Client::over(ours, &Options::default()).await.unwrap();
    let reading = client.read("Speed");
    let (error, ()) = tokio::join!(reading, async {
        tokio::task::yield_now().await;
        task.abort();
    });
    assert!(matches!(error, Err(ClientError::Closed)), "{error:?}");
    assert!(
        matches!(client.identify().await, Err(ClientError::Closed)),
        "and it stays closed"
    );
}

#[tokio::test(start_paused = true)]
async fn instructions_execute_err_and_are_waited_for() {
    let mut asked = 0;
    let handler = move |request: &Request, _| {
        let control = |flags: &[Flag]| {
            let flags = flags.iter().map(|flag| flag.mask()).sum();
            arcline_client::MotionControl {
                flags,
                ..Default::default()
            }
            .to_bytes()
        };
        if request.path == Epath::symbol("CS1") {
            let mut data = 77_u32.to_le_bytes().to_vec();
            data.extend(control(&[Flag::En, Flag::Dn, Flag::Ip]));
            return Some(Reply::success(request.service, data));
        }
        if request.path == Epath::symbol("CS2") {
            return Some(Reply::error(request.service, CipStatus::vendor(54, -1)));
        }
        if request.path == Epath::object(0x0303, 77) {
            asked += 1;
            let flags: &[Flag] = if asked < 3 {
                &[Flag::Dn, Flag::Ip]
            } else {
                &[Flag::Dn, Flag::Pc]
            };
            return Some(Reply::success(request.service, control(flags).to_vec()));
        }
        Some(Reply::error(
            request.service,
            CipStatus::PATH_DESTINATION_UNKNOWN.with(0),
        ))
    };
    let client = connect_with(Settings::default(), Box::new(handler)).await.unwrap();
    let execution = client.execute(Mnemonic::Mcs, "CS1", "Stop1", &[]).await.unwrap();
    assert_eq!(execution.instance, 77);
    let control = client
        .wait_for(&execution, Flag::Pc, Duration::from_secs(1))
        .await
        .unwrap();
    assert!(control.has(Flag::Pc));
    let error = client.execute(Mnemonic::Mcs, "CS2", "", &[]).await.unwrap_err();
    assert_eq!(error.motion(), Some((54, -1)));
    assert_eq!(error.to_string(), "ERR 54 Zero Max Decel, coordinate system");
    let error = client.execute(Mnemonic::Mcs, "CS9", "", &[]).await.unwrap_err();
    assert!(matches!(error, ClientError::UnknownObject { .. }), "{error}");
    assert!(
        matches!(client.instruction(5).await, Err(ClientError::Refused { .. })),
        "no such instance"
    );
}

/// A server of another make has no series: a program executes its moves one by one.
#[tokio::test]
async fn moves_are_executed_one_by_one_where_there_are_no_series() {
    let mut memory = Memory::new();
    let system = arcline_instruction_set::predefined::coordinate_system();
    let tag_type = TagType::scalar(system.clone());
    let symbol = Symbol {
        instance: memory.tags.len() as u32 + 1,
        name: "CS1".to_owned(),
        symbol_type: tag_type.symbol_type(),
        ..Symbol::default()
    };
    let bytes = vec![0; tag_type.size()];
    memory.tags.push((symbol, tag_type, bytes));
    memory.templates.push(system);
    let (_, line) = Mnemonic::Mclm.instruction().service();
    let seen: Arc<Mutex<Vec<u8>>> = Arc::default();
    let noted = seen.clone();
    let handler = move |request: &Request, budget| {
        if request.path == Epath::object(0x0305, 1) {
            noted.lock().unwrap().push(request.service);
            return Some(Reply::error(request.service, CipStatus::SERVICE_NOT_SUPPORTED));
        }
        if request.path == Epath::object(0x0303, 7) {
            return Some(Reply::error(request.service, CipStatus::OBJECT_DOES_NOT_EXIST));
        }
        if (request.service, &request.path) != (line, &Epath::symbol("CS1")) {
            return Some(memory.handle(request, budget));
        }
        noted.lock().unwrap().push(request.service);
        let control = arcline_client::MotionControl {
            flags: Flag::Dn.mask() | Flag::Pc.mask(),
            ..Default::default()
        };
        let data = [&7_u32.to_le_bytes()[..], &control.to_bytes()].concat();
        Some(Reply::success(request.service, data))
    };
    let client = connect_with(Settings::default(), Box::new(handler)).await.unwrap();
    let text = "MCLM(CS1, M, 0, [1], 5, 0);\n".repeat(3);
    let mut runner = arcline_client::Runner::program(&client, &text).await.unwrap();
    let (mut executed, mut completed) = (Vec::new(), Vec::new());
    let mut note = |event: arcline_client::Event<'_>| match event {
        arcline_client::Event::Executed { line, .. } => executed.push(line),
        arcline_client::Event::Completed { line } => completed.push(line),
        other => panic!("{other:?}"),
    };
    runner.run(&mut note).await.unwrap();
    // The server has dropped the executions: they have ended.
    runner.finish(&mut note).await.unwrap();
    assert_eq!(
        (executed.as_slice(), completed.as_slice()),
        ([1, 2, 3].as_slice(), [1, 2, 3].as_slice())
    );
    assert_eq!(
        *seen.lock().unwrap(),
        [0x35, line, line, line],
        "a series is tried once"
    );
}
