//! The pages of the user guide that show the project's own programs, and the table of contents.

use arcline_system_tests::guide::run;

#[test]
fn the_first_move() {
    run("guide/first-move.md", None);
}

#[test]
fn virtual_commissioning() {
    run("guide/pick-and-place.md", None);
}

#[test]
fn glue_on_a_conveyor() {
    run("guide/glue.md", None);
}

#[test]
fn structured_text() {
    run("STRUCTURED_TEXT.md", None);
}

/// The page of clients names the versions that the tests fetch.
#[test]
fn clients_have_the_versions_of_their_tests() {
    let page = read("docs/CLIENTS.md");
    let mut wrong = Vec::new();
    let mut row = |client: &str, version: &str| {
        let link = format!("| [{client}](");
        let row = page.lines().find(|line| line.starts_with(&link));
        if !row.is_some_and(|row| row.split('|').nth(2).is_some_and(|cell| cell.contains(version))) {
            wrong.push(format!("{client} {version}"));
        }
    };
    for client in ["pycomm3", "pylogix", "cpppo", "cm_ethernetip", "ethernetip"] {
        let requirements = read(&format!("tests/python/requirements/{client}.txt"));
        let name = client.replace('_', "-");
        let version = requirements
            .lines()
            .find_map(|line| line.strip_prefix(&format!("{name}==")));
        row(
            &name,
            version
                .and_then(|rest| rest.split(' ').next())
                .expect("a pinned version"),
        );
    }
    let packages: serde_json::Value = serde_json::from_str(&read("tests/node/package.json")).expect("JSON");
    for (name, version) in packages["dependencies"].as_object().expect("dependencies") {
        row(name, version.as_str().expect("a pinned version"));
    }
    let manifest = read("tests/libplctag/Cargo.toml");
    let (_, version) = manifest
        .split_once("plctag-core = { version = \"=")
        .expect("a pinned version");
    row("libplctag", version.split('"').next().expect("a version ends"));
    assert!(wrong.is_empty(), "docs/CLIENTS.md lacks {wrong:?}");
}

fn read(path: &str) -> String {
    std::fs::read_to_string(arcline_system_tests::workspace().join(path))
        .unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn every_page_is_in_the_book_and_every_link_leads_somewhere() {
    let docs = arcline_system_tests::workspace().join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).expect("the summary can be read");
    let linked: Vec<&str> = summary
        .lines()
        .filter_map(|line| line.split_once("](")?.1.strip_suffix(')'))
        .collect();
    for page in &linked {
        assert!(docs.join(page).is_file(), "{page} is in the summary and not there");
        let text = std::fs::read_to_string(docs.join(page)).expect("pages can be read");
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let target = link.split('#').next().unwrap_or_default();
            let is_file = !target.is_empty() && !target.contains(':') && !target.contains(char::is_whitespace);
            let beside = docs.join(page).with_file_name(target);
            assert!(
                !is_file || beside.exists(),
                "{page} links to {target}, which is not there"
            );
        }
    }
    for folder in ["", "guide/", "spec/"] {
        for file in std::fs::read_dir(docs.join(folder)).expect("the folder can be read") {
            let name = file.expect("an entry").file_name().into_string().expect("UTF-8");
            let page = format!("{folder}{name}");
            assert!(
                !page.ends_with(".md") || page == "SUMMARY.md" || linked.contains(&page.as_str()),
                "{page} is not in SUMMARY.md"
            );
        }
    }
}
