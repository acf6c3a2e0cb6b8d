//! A real browser on the HMI of a real server. What must hold is in `tests/browser/cases.mjs`; this finds what it needs.

use std::path::{Path, PathBuf};

use crate::foreign::Store;
use crate::node::Node;
use crate::server::Server;

/// Debian's Chromium; the environment variable `CHROMIUM` names another one.
const CHROMIUM: &str = "/usr/bin/chromium";

/// Runs a case of `tests/browser/cases.mjs` against a server of its own. One browser runs at a time, whatever runs
/// beside: two of them would take the cores from the server.
///
/// # Panics
/// When the case does not hold; in CI also when something needed is missing.
pub fn case(name: &str) {
    on(name, &[]);
}

/// The same with the configuration of `tests/config` that is named so.
///
/// # Panics
/// As [`case`].
pub fn case_on(name: &str, configuration: &str) {
    let file = crate::fixture(&format!("config/{configuration}"));
    on(
        name,
        &["--config", file.to_str().expect("the project's paths are UTF-8")],
    );
}

fn on(name: &str, arguments: &[&str]) {
    let found = find().and_then(|node| Ok((node, Store::open("browser-turn")?)));
    let (node, _turn) = match found {
        Ok(found) => found,
        Err(why) => return crate::not_run(name, &why),
    };
    let server = Server::start_with(&[&["--hmi", "127.0.0.1:0"], arguments].concat());
    let address = server.hmi().expect("the server was started with an HMI");
    let url = format!("http://{address}");
    let pictures = pictures();
    let pictures = pictures.to_str().expect("the project's paths are UTF-8");
    print!(
        "{}",
        node.run("run.mjs", &[name, &url, pictures, &server.process().to_string()])
    );
}

/// Where the pictures of the views are left: `target/hmi-pictures`.
#[must_use]
pub fn pictures() -> PathBuf {
    crate::programs::target_directory().join("hmi-pictures")
}

fn find() -> Result<Node, String> {
    let chromium = std::env::var_os("CHROMIUM").map_or_else(|| CHROMIUM.into(), PathBuf::from);
    if !Path::new(&chromium).exists() {
        return Err(format!(
            "{} is missing (Debian: apt-get install chromium)",
            chromium.display()
        ));
    }
    Node::with("browser")
}
