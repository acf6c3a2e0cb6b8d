//! A real browser on the HMI of a real server. The cases are in `tests/browser/cases.mjs`; this module finds the browser and its packages.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use arcline_client::{Client, ClientError, Identification, Mnemonic, Operands, UnboundOperand};

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

/// The same against a server with users, optionally over HTTPS: `anna` is an operator, `bert` an administrator, another user an engineer,
/// and a page without a log-in a viewer. The password is that of `tests/browser/login.mjs`.
///
/// # Panics
/// As [`case`].
pub fn case_with_users(name: &str, over_https: bool) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |file: &str| folder.path().join(file).to_str().expect("UTF-8").to_owned();
    let run = |arguments: &[&str]| {
        let mut child = Command::new(crate::programs::arcline_server())
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("the server was just built");
        let mut password = child.stdin.take().expect("piped");
        // A command that asks for no password may have ended.
        let _ = password.write_all(b"a long password\n");
        drop(password);
        assert!(child.wait().is_ok_and(|status| status.success()), "{arguments:?}");
    };
    let users = at("users.toml");
    run(&["users", "add", &users, "anna", "--role", "operator"]);
    run(&["users", "add", &users, "bert", "--role", "administrator"]);
    run(&[
        "users",
        "add",
        &users,
        "<img src=x onerror=alert(1)>",
        "--role",
        "engineer",
    ]);
    run(&["certs", "init", &at("")]);
    let cell = std::fs::read_to_string(crate::fixture("config/cell.toml")).expect("a file of the project");
    let security = "login_notice = \"Trained staff only. <img src=x onerror=alert(1)>\"\nusers = \"users.toml\"\nloopback = \"viewer\"\nhmi_tls = \"127.0.0.1:0\"";
    std::fs::write(at("cell.toml"), format!("{cell}\n[security]\n{security}\n")).expect("a writable folder");
    run_on(name, &["--config", &at("cell.toml")], over_https);
}

/// The same against a server with the program of `tests/config/ladder.L5X`, of which every text that may be any text is markup, while a
/// client of EtherNet/IP jogs the axis X that tells of itself, in its own words, that it is an element of a page.
///
/// # Panics
/// As [`case`].
pub fn case_among_strangers(name: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let project = "<img src=x onerror=alert(10)>.L5X";
    std::fs::write(folder.path().join(project), marked_up(&config("ladder.L5X"))).expect("a writable folder");
    let file = folder.path().join("ladder.toml");
    // The client says nothing while the browser looks.
    let patient = replaced(&config("ladder.toml"), "[server]\n", "[server]\njog_silence_ms = 0\n");
    let marked = replaced(&patient, "\"ladder.L5X\"", &format!("{project:?}"));
    std::fs::write(&file, marked).expect("a writable folder");
    let arguments = ["--config", file.to_str().expect("UTF-8")];
    run_beside(name, &arguments, false, |server| {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .expect("a runtime");
        let client = runtime.block_on(jog(&server.address().to_string()));
        (client.expect("the machine is at rest and has no owner"), runtime)
    });
}

/// The same against a server with the machine of `tests/config/ladder.toml` and a routine of this number of rungs, of which every second one changes in
/// each scan of 2 ms.
///
/// # Panics
/// As [`case`].
pub fn case_of_rungs(name: &str, rungs: usize) {
    let rows = (0..rungs).map(|number| {
        let rung = match number % 2 {
            0 => format!(
                "ADD(D[{number}],1,D[{number}])MOD(D[{number}],7,D[{number}])EQU(D[{number}],3)OTE(B[{number}]);"
            ),
            _ => format!("XIC(B[{}])[XIO(B[{number}]) ,XIC(B[0]) ]OTE(B[{number}]);", number - 1),
        };
        format!("<Rung Number=\"{number}\" Type=\"N\"><Text><![CDATA[{rung}]]></Text></Rung>")
    });
    let rows: String = rows.collect();
    let project = config("ladder.L5X");
    let place = "<Routine Name=\"Go\" Type=\"RLL\"><RLLContent>";
    let (before, rest) = project.split_once(place).expect("the routine of the fixture");
    let (_, after) = rest.split_once("</RLLContent>").expect("its end");
    let project = format!("{before}{place}{rows}</RLLContent>{after}");
    let tag = |name: &str, kind: &str| {
        format!("<Tag Name=\"{name}\" TagType=\"Base\" DataType=\"{kind}\" Dimensions=\"1024\"/><Tag Name=\"Stop\"")
    };
    let project = replaced(&project, "<Tag Name=\"Stop\"", &tag("B", "BOOL"));
    let project = replaced(&project, "<Tag Name=\"Stop\"", &tag("D", "DINT"));
    let project = replaced(&project, "Rate=\"10\"", "Rate=\"2\"");
    on_project(name, &project, &config("ladder.toml"));
}

/// The same against a server with the program of `tests/config/ladder.L5X`, of which rung 3 and line 7 name tags that are not there.
///
/// # Panics
/// As [`case`].
pub fn case_with_missing_parts(name: &str) {
    let project = replaced(&config("ladder.L5X"), "[MOV(Count,", "[XIC(Loop.Auto)MOV(Count,");
    let project = replaced(&project, "[  High := 1;", "[  Peak := 1;");
    let allowed = replaced(
        &config("ladder.toml"),
        "[controller]\n",
        "[controller]\nallow_missing = true\n",
    );
    on_project(name, &project, &allowed);
}

/// A file of `tests/config`.
fn config(file: &str) -> String {
    std::fs::read_to_string(crate::fixture(&format!("config/{file}"))).expect("a file of the project")
}

/// Runs a case against a server with a configuration whose program is `ladder.L5X`, and with that project.
fn on_project(name: &str, project: &str, configuration: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("ladder.L5X"), project).expect("a writable folder");
    let file = folder.path().join("ladder.toml");
    std::fs::write(&file, configuration).expect("a writable folder");
    on(name, &["--config", file.to_str().expect("UTF-8")]);
}

/// A project with markup in its comments, descriptions, names, lines and values. Names of tags that are markup are in no rung, but they are in the project.
fn marked_up(project: &str) -> String {
    let img = |number: u32| format!("<img src=x onerror=alert({number})>");
    let escaped = |number: u32| img(number).replace('<', "&lt;").replace('>', "&gt;");
    let described = |number: u32| format!("<Description><![CDATA[{}]]></Description>", img(number));
    let named = |element: &str, name: &str, number: u32| {
        let with = |name: &str| format!("<{element} Name=\"{name}\"");
        (with(name), with(&escaped(number)))
    };
    let after = |place: &str, added: String| (place.to_owned(), format!("{place}{added}"));
    let start = "<Tag Name=\"Start\" TagType=\"Base\" DataType=\"BOOL\" ExternalAccess=\"Read/Write\">";
    let words = "<Tag Name=\"Words\" TagType=\"Base\" DataType=\"STRING\" ExternalAccess=\"Read/Write\"><Data Format=\"String\"";
    let unnamed = format!("<Tag Name=\"{}\" TagType=\"Base\" DataType=\"BOOL\"/>", escaped(11));
    let value = format!(
        "{words} Length=\"{}\"><![CDATA['{}']]></Data></Tag><Tag Name=\"Copy\" TagType=\"Base\" DataType=\"STRING\"/>",
        img(12).len(),
        img(12)
    );
    let copy = "<Rung Number=\"9\" Type=\"N\"><Text><![CDATA[COP(Words,Copy,1);]]></Text></Rung>";
    let first = "<Routine Name=\"Go\" Type=\"RLL\"><RLLContent>";
    #[rustfmt::skip]
    let changes = [
        after(first, copy.to_owned()),
        after("<Comment><![CDATA[", format!("{} ", img(5))),
        after(start, described(6)),
        ("<Tag Name=\"Stop\"".to_owned(), format!("{unnamed}{value}<Tag Name=\"Stop\"")),
        named("Task", "Cyclic", 13),
        named("Program", "Main", 14),
        named("ScheduledProgram", "Main", 14),
        named("Routine", "Go", 15),
        ("MainRoutineName=\"Go\"".to_owned(), format!("MainRoutineName=\"{}\"", escaped(15))),
        after("// The average of the recipe", format!(" {}", img(16))),
        after("ExecuteEnableInFalse=\"false\">", described(17)),
    ];
    changes
        .iter()
        .fold(project.to_owned(), |project, (old, new)| replaced(&project, old, new))
}

/// A text with another part in place of each that is the old one, of which there is one or more.
fn replaced(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "the fixture has no {old}");
    text.replace(old, new)
}

/// A client that jogs the axis X slowly as long as it is there.
async fn jog(server: &str) -> Result<Client, ClientError> {
    let client = Client::connect(server).await?;
    let identification = Identification {
        product: "<img src=x onerror=alert(7)>".to_owned(),
        user: "<img src=x onerror=alert(8)>".to_owned(),
        program: "<img src=x onerror=alert(9)>".to_owned(),
    };
    client.introduce(&identification).await?;
    for axis in ["X", "Y"] {
        client.execute(Mnemonic::Mso, axis, "", &[]).await?;
    }
    let slow = Operands::full_speed(Mnemonic::Maj).with("Speed", UnboundOperand::Number(1.0))?;
    client.execute(Mnemonic::Maj, "X", "Jog", slow.as_slice()).await?;
    Ok(client)
}

fn on(name: &str, arguments: &[&str]) {
    run_on(name, arguments, false);
}

fn run_on(name: &str, arguments: &[&str], over_https: bool) {
    run_beside(name, arguments, over_https, |_| ());
}

/// Runs a case while the clients or files from `beside` exist.
fn run_beside<B>(name: &str, arguments: &[&str], over_https: bool, beside: impl FnOnce(&Server) -> B) {
    let found = find().and_then(|node| Ok((node, Store::open("browser-turn")?)));
    let (node, _turn) = match found {
        Ok(found) => found,
        Err(why) => return crate::not_run(name, &why),
    };
    let server = Server::start_with(&[&["--hmi", "127.0.0.1:0"], arguments].concat());
    let url = match over_https {
        false => format!("http://{}", server.hmi().expect("the server was started with an HMI")),
        true => format!("https://{}", server.hmi_tls().expect("the configuration has HTTPS")),
    };
    let _beside = beside(&server);
    let pictures = pictures();
    let pictures = pictures.to_str().expect("the project's paths are UTF-8");
    print!(
        "{}",
        node.run("run.mjs", &[name, &url, pictures, &server.process().to_string()])
    );
}

/// The folder for the pictures of the views: `target/hmi-pictures`.
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
