//! A trace as MCAP, read by the package of the format's makers.

use arcline_system_tests::command_line::arcline;
use arcline_system_tests::not_run;
use arcline_system_tests::python::Python;
use arcline_system_tests::server::Server;

#[test]
fn mcap_is_read_by_the_package_of_its_makers() {
    let python = match Python::with("mcap") {
        Ok(python) => python,
        Err(why) => return not_run("reading MCAP with Python", &why),
    };
    let server = Server::start();
    let at = server.address();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("t.mcap");
    let file = file.to_str().expect("the path is UTF-8");
    let _ = arcline(at, &["trace", "X", "CS1", "--for", "2", "-o", file]).expect(0);
    let told: serde_json::Value = serde_json::from_str(&python.run("mcap_read.py", &[file])).expect("JSON");
    assert_eq!(told["messages"], 4000, "{told}");
    for (topic, members) in [("/X", 4), ("/CS1", 2)] {
        let topic = &told["topics"][topic];
        assert_eq!(
            (&topic["count"], &topic["schema"]),
            (&2000.into(), &"jsonschema".into()),
            "{told}"
        );
        let times = [&topic["first"], &topic["last"]].map(|time| time.as_u64().expect("a time"));
        assert_eq!(times[1] - times[0], 1_999_000_000, "{told}");
        assert_eq!(
            topic["sample"].as_object().map(serde_json::Map::len),
            Some(members),
            "{told}"
        );
    }
    let later = told["later"].as_u64().expect("a count");
    assert!((1990..=2010).contains(&later), "half of it by the index: {later}");
}
