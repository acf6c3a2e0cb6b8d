//! Program scopes, structures, several dimensions and aliases, as clients address them.

use arcline_controller::image::ProjectPart;
use arcline_proto::cip::{Request, encode_attribute_ids, service};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::logix::Symbol;
use arcline_tag::Elementary;

use super::*;

/// The list of a scope: name, type word, whether it is no alias.
async fn list(client: &mut Client, scope: Option<&str>) -> Vec<(String, u16, bool)> {
    let attributes = [1, 2, 6];
    let (mut symbols, mut start) = (Vec::new(), 0);
    loop {
        let data = encode_attribute_ids(&attributes);
        let mut request = Request::new(service::GET_INSTANCE_ATTRIBUTE_LIST, Epath::object(0x6B, start), data);
        if let Some(scope) = scope {
            request.path.0.insert(0, Segment::Symbol(scope.into()));
        }
        let reply = client.ask(&request).await;
        assert!(matches!(reply.status.general(), 0 | 6), "{scope:?}: {}", reply.status);
        let page = Symbol::decode_list(&reply.data, &attributes).expect("symbols");
        start = page.last().map_or(start, |last| last.instance + 1);
        let base = |symbol: &Symbol| symbol.software_control == Symbol::BASE_TAG;
        symbols.extend(page.into_iter().map(|symbol| {
            let base = base(&symbol);
            (symbol.name, symbol.symbol_type, base)
        }));
        if reply.status.is_success() {
            return symbols;
        }
    }
}

#[tokio::test]
async fn each_scope_lists_its_own_tags() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let controller = list(&mut client, None).await;
    let has = |name: &str, word: u16, base: bool| controller.contains(&(name.to_owned(), word, base));
    assert!(has("Program:Main", 0x1068, true), "{controller:?}");
    assert!(
        has("Grid", 0x40C3, true) && has("Routes", 0xA201, true),
        "{controller:?}"
    );
    assert!(has("Valid", 0x00C1, false) && has("Row", 0x00C3, false), "aliases");
    assert!(!controller.iter().any(|(name, ..)| name == "Count"));
    let expected = [("Count", 0x00C4), ("aDint", 0x00C5)].map(|(name, word)| (name.to_owned(), word, true));
    assert_eq!(list(&mut client, Some("program:MAIN")).await, expected);
}

#[tokio::test]
async fn the_parts_of_a_project_are_listed() {
    let bench = Bench::new();
    let go = ProjectPart::Routine {
        program: "Main",
        routine: "Go",
    };
    let parts = [ProjectPart::Task("Fast"), ProjectPart::Program("Empty"), go];
    let listed = bench
        .device
        .plant
        .exchange(false, |image| image.list_project(parts.into_iter()).is_ok());
    assert!(listed);
    let mut client = bench.client().await;
    let controller = list(&mut client, None).await;
    for (name, word) in [("Task:Fast", 0x1070), ("Program:Empty", 0x1068)] {
        assert!(
            controller.contains(&(name.to_owned(), word, true)),
            "{name}: {controller:?}"
        );
    }
    let main = list(&mut client, Some("Program:Main")).await;
    assert!(main.contains(&("Routine:Go".to_owned(), 0x106D, true)), "{main:?}");
    assert_eq!(list(&mut client, Some("Program:Empty")).await, []);
}

#[tokio::test]
async fn parts_are_read_and_written_by_every_kind_of_path() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let (int, bool_type) = (Elementary::Int.into(), Elementary::Bool.into());
    assert_eq!(client.read("Grid[1,2]").await.data[..], [6, 0]);
    assert!(client.write("Row", int, &[0x39, 0x30]).await.is_success());
    assert_eq!(client.read("Grid[1,0]").await.data[..], [0x39, 0x30]);
    assert!(client.write("Valid", bool_type, &[1]).await.is_success());
    // A point: two REALs, the host of Valid, Id.
    let point = client.read("Routes[1].Points[0]").await;
    assert_eq!((point.data.len(), point.data[8]), (12, 1));
    assert_eq!(client.read("Routes[1].Points[0].Valid").await.data[..], [1]);
    assert!(
        client
            .write(
                "Routes[1].Points[0].At[1]",
                Elementary::Real.into(),
                &1.5f32.to_le_bytes()
            )
            .await
            .is_success()
    );
    assert_eq!(
        client.read("Routes[1].Points[0].At[1]").await.data[..],
        1.5f32.to_le_bytes()
    );

    assert_eq!(client.read("Program:Main.Count").await.data[..], [7, 0, 0, 0]);
    assert!(
        client
            .write("Program:Main.Count", Elementary::Dint.into(), &[8, 0, 0, 0])
            .await
            .is_success()
    );
    assert_eq!(client.read("Program:Main.Count").await.data[..], [8, 0, 0, 0]);
    let refused = client
        .write("Program:Main.aDint", Elementary::Lint.into(), &[0; 8])
        .await;
    assert_eq!(codes(refused), (0x0F, 0), "read-only");
    assert!(
        client
            .write("aDint", Elementary::Dint.into(), &[1, 0, 0, 0])
            .await
            .is_success(),
        "the other scope's"
    );
}

#[tokio::test]
async fn an_instance_is_found_in_its_own_scope_only() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let id = bench.device.plant.with_image(|image| {
        let count = image.tags().iter().find(|tag| tag.name == "Count");
        count.expect("a tag").id.0
    });
    let read = |scope: Option<&str>| {
        let data = ReadTag { elements: 1, offset: 0 }.to_bytes();
        let mut request = Request::new(service::READ_TAG, Epath::object(0x6B, id), data);
        if let Some(scope) = scope {
            request.path.0.insert(0, Segment::Symbol(scope.into()));
        }
        request
    };
    assert!(client.ask(&read(Some("Program:Main"))).await.status.is_success());
    for scope in [None, Some("Program:Other"), Some("Grid")] {
        assert_eq!(codes(client.ask(&read(scope)).await.status), (0x05, 0), "{scope:?}");
    }
}
