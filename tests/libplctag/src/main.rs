//! Drives an Arcline server with an unmodified libplctag: arcline-libplctag HOST:PORT; or jogs the axis S by its instruction tag `Jog1`
//! until it is killed: arcline-libplctag HOST:PORT jog.
//!
//! One line for each check; the first failure ends the program with a panic, whose message has the expected value.
#![forbid(unsafe_code)]

use std::time::{Duration, Instant};

use plctag_core::{RawTag, Status};

/// Milliseconds that one request may take.
const TIMEOUT: u32 = 10_000;
/// The longest time for a move.
const MOVE: Duration = Duration::from_secs(30);

/// libplctag's status codes for refusals of a controller.
const NOT_FOUND: i32 = -19;
const NOT_ALLOWED: i32 = -18;
const BAD_PARAM: i32 = -7;

struct Plc(String);

impl Plc {
    fn open(&self, name: &str, elements: usize) -> Result<RawTag, Status> {
        RawTag::new(format!("{}&name={name}&elem_count={elements}", self.0), TIMEOUT)
    }

    fn tag(&self, name: &str, elements: usize) -> RawTag {
        match self.open(name, elements) {
            Ok(tag) => tag,
            Err(status) => panic!("FAILED {name}: {}", status.decode()),
        }
    }

    /// Reads the bytes of a number of elements.
    fn read(&self, name: &str, elements: usize) -> Vec<u8> {
        let tag = self.tag(name, elements);
        ok(name, tag.read(TIMEOUT));
        bytes(&tag)
    }

    /// Writes and reads back.
    fn write(&self, name: &str, elements: usize, data: &[u8]) {
        let tag = self.tag(name, elements);
        equal(
            &format!("size of {name}"),
            tag.size().expect("a size") as usize,
            data.len(),
        );
        tag.set_bytes(0, data).expect("it fits");
        ok(name, tag.write(TIMEOUT));
        equal(name, self.read(name, elements), data.to_vec());
    }

    fn real(&self, name: &str) -> f32 {
        f32::from_le_bytes(self.read(name, 1).try_into().expect("four bytes"))
    }

    /// Sends a message to any object and gives its reply, from the service on.
    fn message(&self, request: &[u8]) -> Vec<u8> {
        let tag = RawTag::new(format!("{}&name=@raw", self.0), TIMEOUT).expect("no request yet");
        tag.set_size(request.len() as u32).expect("a size");
        tag.set_bytes(0, request).expect("it fits");
        ok("@raw", tag.write(TIMEOUT));
        bytes(&tag)
    }
}

fn bytes(tag: &RawTag) -> Vec<u8> {
    let mut bytes = vec![0; tag.size().expect("a size") as usize];
    tag.get_bytes(0, &mut bytes).expect("within the tag");
    bytes
}

fn ok(what: &str, status: Status) {
    assert!(status.is_ok(), "FAILED {what}: {}", status.decode());
}

fn equal<T: PartialEq + std::fmt::Debug>(what: &str, found: T, expected: T) {
    assert!(
        found == expected,
        "FAILED {what}: found {found:?}, expected {expected:?}"
    );
    println!("ok  {what}");
}

fn refused(what: &str, status: Status, code: i32) {
    match status {
        Status::Err(found) => equal(what, found, code),
        other => panic!("FAILED {what}: {}", other.decode()),
    }
}

fn numbers<const N: usize, T: Copy>(values: &[T], to_bytes: fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|value| to_bytes(*value)).collect()
}

fn types(plc: &Plc) {
    plc.write("ABool", 1, &[1]);
    plc.write("ASint", 1, &[0x80]);
    plc.write("AnInt", 1, &i16::MIN.to_le_bytes());
    plc.write("ADint", 1, &i32::MIN.to_le_bytes());
    plc.write("ALint", 1, &i64::MIN.to_le_bytes());
    plc.write("AUsint", 1, &[0xFF]);
    plc.write("AUint", 1, &[0xFF; 2]);
    plc.write("AUdint", 1, &[0xFF; 4]);
    plc.write("AUlint", 1, &[0xFF; 8]);
    plc.write("AReal", 1, &1.5_f32.to_le_bytes());
    plc.write("AnLreal", 1, &0.1_f64.to_le_bytes());

    let string = plc.tag("AString", 1);
    string.set_string(0, "feed rate").expect("it fits");
    ok("AString", string.write(TIMEOUT));
    let read = plc.read("AString", 1);
    equal(
        "a STRING",
        (&read[..4], &read[4..13]),
        (&[9, 0, 0, 0][..], &b"feed rate"[..]),
    );

    // Arrays of one to three dimensions, in fragments, of BOOLs.
    plc.write(
        "Dints",
        10,
        &numbers(&[7, -6, 5, -4, 3, -2, 1, 0, -1, 2], i32::to_le_bytes),
    );
    plc.write("Sints", 1001, &(0..1001).map(|i| i as u8).collect::<Vec<_>>());
    plc.write("Lints", 5, &numbers(&[i64::MIN, -1, 0, 1, i64::MAX], i64::to_le_bytes));
    plc.write("Lreals", 5, &numbers(&[0.1, -0.1, 1e300, 0.0, 3.0], f64::to_le_bytes));
    plc.write("Grid", 6, &numbers(&[1, 2, 3, 4, 5, 6], i16::to_le_bytes));
    equal("Grid[1,2]", plc.read("Grid[1,2]", 1), vec![6, 0]);
    equal("an alias", plc.read("Corner", 1), vec![6, 0]);
    plc.write("Cube", 24, &numbers(&(0..24).collect::<Vec<_>>(), i32::to_le_bytes));
    plc.write("Cube[1,0,2]", 1, &99_i32.to_le_bytes());
    equal("its place", plc.read("Cube", 24)[56..60].to_vec(), vec![99, 0, 0, 0]);
    let recipe = numbers(&(0..3000).map(|i| i as f32 / 8.0).collect::<Vec<_>>(), f32::to_le_bytes);
    plc.write("Recipe", 3000, &recipe);
    plc.write("Bools", 2, &[1, 0, 0, 0x80, 0x55, 0, 0, 0]);
    plc.write(
        "Strings[1]",
        1,
        &[vec![3, 0, 0, 0], b"two".to_vec(), vec![0; 81]].concat(),
    );

    // A bit of an integer.
    let bit = plc.tag("ADint.3", 1);
    bit.set_bit(0, true).expect("a bit");
    ok("a bit", bit.write(TIMEOUT));
    equal(
        "only that bit",
        plc.read("ADint", 1),
        (i32::MIN + 8).to_le_bytes().to_vec(),
    );

    // Structures and their members, programs.
    let point = [
        &1.5_f32.to_le_bytes()[..],
        &(-2.5_f32).to_le_bytes(),
        &[0b10, 0xFD, 0, 0],
    ]
    .concat();
    plc.write("APoint", 1, &point);
    plc.write("Routes[2].Points[1]", 1, &point);
    plc.write("PointGrid", 4, &point.repeat(4));
    plc.write("Program:Main.Points[1]", 1, &point);
    let route = plc.read("Routes[2]", 1);
    plc.write("Routes", 4, &route.repeat(4));
    equal("a nested member", plc.read("Routes[3].Points[1].Id", 1), vec![0xFD]);
    plc.write("Routes[3].Points[2].At[1]", 1, &0.25_f32.to_le_bytes());
    plc.write("Routes[0].Home.Valid", 1, &[1]);
    plc.write("Program:Main.Count", 1, &75_i32.to_le_bytes());
    plc.write("Program:Main.ADint", 1, &(1_i64 << 40).to_le_bytes());
    equal("an axis", plc.read("X", 1).len(), 1040);

    // Requests that the server must refuse.
    let Err(unknown) = plc.open("Nothing", 1) else {
        panic!("FAILED unknown tag: it is there");
    };
    assert!(
        matches!(unknown, Status::Err(NOT_FOUND | BAD_PARAM)),
        "FAILED unknown tag: {}",
        unknown.decode()
    );
    let fixed = plc.tag("Fixed", 1);
    fixed.set_i32(0, 1).expect("it fits");
    refused("read-only", fixed.write(TIMEOUT), NOT_ALLOWED);
    equal("unchanged", plc.read("Fixed", 1), vec![42, 0, 0, 0]);
}

/// Instance, type word, element length, three dimensions, name.
fn list(plc: &Plc, name: &str) -> Vec<(u16, u16, [u32; 3], String)> {
    let data = plc.read(name, 1);
    let mut rest = &data[..];
    let word = |at: usize, rest: &[u8]| u16::from_le_bytes([rest[at], rest[at + 1]]);
    let mut tags = Vec::new();
    while !rest.is_empty() {
        let dimension = |i: usize| u32::from(word(8 + 4 * i, rest));
        let end = 22 + usize::from(word(20, rest));
        let name = String::from_utf8_lossy(&rest[22..end]).into_owned();
        tags.push((
            word(4, rest),
            word(6, rest),
            [dimension(0), dimension(1), dimension(2)],
            name,
        ));
        rest = &rest[end..];
    }
    tags
}

fn browse(plc: &Plc) {
    let tags = list(plc, "@tags");
    let pages = tags.iter().filter(|tag| tag.3.starts_with("Page")).count();
    equal("all pages", pages, 300);
    let find = |name: &str| {
        tags.iter()
            .find(|tag| tag.3 == name)
            .map(|tag| (tag.0, tag.1, tag.2))
            .expect("a tag")
    };
    equal("Grid in the list", find("Grid"), (0x40C3, 2, [2, 3, 0]));
    equal("Cube in the list", find("Cube"), (0x60C4, 4, [2, 3, 4]));
    let main = list(plc, "Program:Main.@tags");
    let names: Vec<&str> = main.iter().map(|tag| tag.3.as_str()).collect();
    equal("tags of a program", names, vec!["Count", "ADint", "Points"]);
    let (word, size, _) = find("Routes");
    // Type, member description words, size, members, handle; then the members.
    let template = plc.read(&format!("@udt/{}", word & 0x0FFF), 1);
    let long = u32::from_le_bytes([template[6], template[7], template[8], template[9]]);
    equal("size of a template's structure", long, u32::from(size));
    let text = String::from_utf8_lossy(&template).into_owned();
    for name in ["Route;", "Name\0", "Count\0", "Points\0", "Flags\0", "Home\0"] {
        equal(&format!("{name:?} in it"), text.contains(name), true);
    }
}

fn run_a_move(plc: &Plc, end: [f32; 3]) {
    plc.write("Move1.EnableIn", 1, &[0]);
    plc.write("Move1.Position", 3, &numbers(&end, f32::to_le_bytes));
    plc.write("Move1.EnableIn", 1, &[1]);
    eventually("Move1 ends", || plc.read("Move1.MotionControl.PC", 1) == [1]);
    let positions = ["X", "Y", "Z"].map(|axis| plc.real(&format!("{axis}.CommandPosition")));
    equal("end of the move, exactly", positions, end);
}

fn eventually(what: &str, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + MOVE;
    while !condition() {
        assert!(Instant::now() < deadline, "FAILED {what}: not within {MOVE:?}");
    }
    println!("ok  {what}");
}

/// The operands of MCLM behind the coordinate system (contract, section 4).
fn mclm(control: &str, position: [f32; 3], speed: f32) -> Vec<u8> {
    let dint = |value: i32| [&[0xC4, 0, 1, 0][..], &value.to_le_bytes()].concat();
    let reals = |values: &[f32]| {
        [
            &[0xCA, 0, values.len() as u8, 0][..],
            &numbers(values, f32::to_le_bytes),
        ]
        .concat()
    };
    let name = [&[0xDA, 0, 1, 0, control.len() as u8][..], control.as_bytes()].concat();
    let request = vec![0x32, 4, 0x21, 0, 0x02, 0x03, 0x25, 0, 1, 0];
    [
        request,
        name,
        dint(0),
        reals(&position),
        reals(&[speed]),
        dint(0),
        reals(&[2000.0]),
        dint(0),
        reals(&[2000.0]),
        dint(0),
        dint(1),
        reals(&[100.0]),
        reals(&[100.0]),
        dint(2),
        dint(1),
    ]
    .concat()
}

fn service(plc: &Plc, control: &str) {
    let reply = plc.message(&mclm(control, [0.0; 3], 400.0));
    equal("MCLM", reply[..4].to_vec(), vec![0xB2, 0, 0, 0]);
    equal("DN, no ER", reply[11] & 0x30, 0x20);
    eventually("PC", || plc.read(&format!("{control}.PC"), 1) == [1]);
    equal("at the end", plc.real("X.CommandPosition"), 0.0);
    let reply = plc.message(&mclm(control, [9.0; 3], -1.0));
    equal("ERR 13, EXERR 4", reply, vec![0xB2, 0, 0x1F, 2, 13, 0, 4, 0]);
}

fn jog(plc: &Plc) -> ! {
    // A tag that stays open: with its last one libplctag closes the connection in order, and the jog would go on without an owner.
    let speed = plc.tag("S.CommandVelocity", 1);
    for (member, value) in [("Speed", 50.0), ("AccelRate", 5000.0), ("DecelRate", 5000.0)] {
        plc.write(&format!("Jog1.{member}"), 1, &f32::to_le_bytes(value));
    }
    for member in ["SpeedUnits", "AccelUnits", "DecelUnits"] {
        plc.write(&format!("Jog1.{member}"), 1, &[0; 4]);
    }
    plc.write("Jog1.EnableIn", 1, &[1]);
    loop {
        ok("S.CommandVelocity", speed.read(TIMEOUT));
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn main() {
    let gateway = std::env::args().nth(1).expect("HOST:PORT as the argument");
    let address = format!("protocol=ab-eip&gateway={gateway}&path=1,0&plc=controllogix");
    let connected = Plc(address.clone());
    if std::env::args().nth(2).as_deref() == Some("jog") {
        jog(&connected);
    }
    types(&connected);
    browse(&connected);
    run_a_move(&connected, [40.0, 20.0, 10.0]);
    service(&connected, "Generic8");
    // Without a connection this version only reads: it takes the replies to its writes for others. And it shares a session
    // among tags with and without a connection, with connection 0 for those that need one: so they have a group of their own.
    let unconnected = Plc(format!("{address}&use_connected_msg=0&connection_group_id=1"));
    equal(
        "12,000 bytes, unconnected",
        unconnected.read("Recipe", 3000),
        connected.read("Recipe", 3000),
    );
    equal(
        "a structure, unconnected",
        unconnected.read("Routes[2]", 1),
        connected.read("Routes[2]", 1),
    );
    equal(
        "a program's tag, unconnected",
        unconnected.read("Program:Main.Count", 1),
        vec![75, 0, 0, 0],
    );
    println!("libplctag: all as expected");
}
