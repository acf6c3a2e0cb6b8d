//! Every key of the configuration (spec/contract.md §2): name, kind, default and meaning.

use super::{Default, Key, Keys, Kind, NETWORKS, Range, TextRule};
use crate::read::{MAX_MEMBERS, MAX_TYPES};
use arcline_controller::image::MAX_PLAIN_TAGS;
use arcline_controller::machine::{MAX_AXES, MAX_SYSTEMS, MAX_TRANSFORMS};

/// The tables of a file.
pub(crate) static ROOT: Keys = Keys {
    heading: "",
    expected: "",
    keys: &[
        Key {
            name: "server",
            kind: Kind::Table(&SERVER),
            default: Default::Prose(""),
            meaning: "the network side",
        },
        Key {
            name: "security",
            kind: Kind::Table(&SECURITY),
            default: Default::Prose(""),
            meaning: "roles and limits",
        },
        Key {
            name: "controller",
            kind: Kind::Table(&CONTROLLER),
            default: Default::Prose(""),
            meaning: "the program of the controller",
        },
        Key {
            name: "motion_group",
            kind: Kind::Table(&MOTION_GROUP),
            default: Default::Prose(""),
            meaning: "the motion group",
        },
        Key {
            name: "axis",
            kind: Kind::Tables(&AXIS, MAX_AXES),
            default: Default::Prose(""),
            meaning: "an axis",
        },
        Key {
            name: "coordinate_system",
            kind: Kind::Tables(&COORDINATE_SYSTEM, MAX_SYSTEMS),
            default: Default::Prose(""),
            meaning: "a coordinate system",
        },
        Key {
            name: "transform",
            kind: Kind::Tables(&TRANSFORM, MAX_TRANSFORMS),
            default: Default::Prose(""),
            meaning: "a transform between two coordinate systems",
        },
        Key {
            name: "instruction",
            kind: Kind::Tables(&INSTRUCTION, MAX_INSTRUCTION_TAGS),
            default: Default::Prose(""),
            meaning: "an instruction as a tag",
        },
        Key {
            name: "data_type",
            kind: Kind::Tables(&DATA_TYPE, MAX_TYPES),
            default: Default::Prose(""),
            meaning: "a structure type for tags",
        },
        Key {
            name: "tag",
            kind: Kind::Tables(&TAG, MAX_PLAIN_TAGS),
            default: Default::Prose(""),
            meaning: "a tag of plain data",
        },
    ],
};

pub(crate) static SERVER: Keys = Keys {
    heading: "## `[server]`",
    expected: "a table, [server]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Text(&PRODUCT_NAME),
            default: Default::Text("Arcline"),
            meaning: "Product Name of the CIP Identity object: 1 to 32 printable ASCII characters",
        },
        Key {
            name: "listen",
            kind: Kind::Addresses(16),
            default: Default::Text("127.0.0.1:44818"),
            meaning: r#"where EtherNet/IP listens, TCP and UDP; port 0 picks a free one; or a list of up to 16 such as `["127.0.0.1:44818", "[::1]:44818"]`"#,
        },
        Key {
            name: "hmi",
            kind: Kind::AddressOrOff("127.0.0.1:8080"),
            default: Default::Text("127.0.0.1:8080"),
            meaning: r#"where the HMI listens, or `"off"`"#,
        },
        Key {
            name: "io",
            kind: Kind::AddressOrOff("127.0.0.1:2222"),
            default: Default::Prose("beside `listen`"),
            meaning: r#"where class 0 and 1 connections (implicit I/O, see [IO.md](IO.md)) listen, UDP: an address and port, or `"off"`; port 0 picks a free one. Absent: the address of `listen`, and port 2222 if that listens on 44818, otherwise a free port"#,
        },
        Key {
            name: "io_loss",
            kind: Kind::Word(&["stop", "hold", "finish"]),
            default: Default::Text("stop"),
            meaning: r#"what motion does when the owner of the outputs is silent for too long, closes its connection or goes idle: `"stop"` stops everything that moves, `"hold"` sets the feed override of every coordinate system to 0, `"finish"` lets it come to its end"#,
        },
        Key {
            name: "connection_loss",
            kind: Kind::Word(&["jogs", "stop", "hold", "finish"]),
            default: Default::Text("jogs"),
            meaning: r#"what becomes of motion when the class 3 connection or the session over which it was begun ends without a Forward Close or UnRegisterSession (silence, a closed socket): `"jogs"` stops its jogs and lets everything else come to its end, `"stop"` stops all of it, `"hold"` sets the feed override of the coordinate systems it moves to 0 and stops its jogs, `"finish"` lets it go on. What others began is not touched. A connection can choose for itself: attribute 100 of class 0x06, USINT, in this order from 0"#,
        },
        Key {
            name: "max_clients",
            kind: Kind::Integer(1..=65535, ""),
            default: Default::Integer(2048),
            meaning: "TCP connections at a time; beyond, the oldest without a session is closed, else the new one",
        },
        Key {
            name: "max_clients_per_address",
            kind: Kind::Integer(1..=65535, ""),
            default: Default::Prose("`max_clients`"),
            meaning: "the same from one address",
        },
        Key {
            name: "max_connections",
            kind: Kind::Integer(1..=65535, ""),
            default: Default::Integer(4096),
            meaning: "class 3 connections at a time; beyond, a Forward Open is refused with 0x01/0x0113",
        },
        Key {
            name: "max_connections_per_address",
            kind: Kind::Integer(1..=65535, ""),
            default: Default::Prose("`max_connections`"),
            meaning: "the same of all clients at one address",
        },
        Key {
            name: "inactivity_timeout_s",
            kind: Kind::Integer(0..=3600, "s"),
            default: Default::Integer(120),
            meaning: "silence after which a TCP connection is closed, s, at most 3600; 0: never",
        },
        Key {
            name: "jog_silence_ms",
            kind: Kind::ZeroOr(100..=60_000, "ms"),
            default: Default::Integer(2000),
            meaning: r#"silence after which the jogs (MAJ) of a client are stopped though its TCP connection stays open, ms, 100 to 60000; 0: never. It is measured per TCP connection: any message of the client counts, on any of its class 3 connections or without one, and so does any message of a page. A client that hangs, or whose cable was pulled, stops its jogs so. With `connection_loss = "finish"` they go on. A client that sleeps for longer while it jogs needs a larger value, or reads any tag meanwhile"#,
        },
    ],
};

pub(crate) static SECURITY: Keys = Keys {
    heading: "## `[security]`",
    expected: "a table, [security]",
    keys: &[
        Key {
            name: "tls",
            kind: Kind::AddressOrOff("0.0.0.0:2221"),
            default: Default::Text("off"),
            meaning: r#"where EtherNet/IP over TLS listens, TCP, or `"off"`; the port of the standard is 2221. `arcline-server certs init` makes the files"#,
        },
        Key {
            name: "certificate",
            kind: Kind::Text(&FILE),
            default: Default::Text("server.pem"),
            meaning: "the file with the certificate of the server and those between it and the authority, PEM; relative to the folder of the configuration",
        },
        Key {
            name: "key",
            kind: Kind::Text(&FILE),
            default: Default::Text("server.key"),
            meaning: "the file with the private key of that certificate, PEM, readable by its owner only",
        },
        Key {
            name: "clients",
            kind: Kind::Text(&FILE),
            default: Default::Text("ca.pem"),
            meaning: "the file with the authorities whose certificates clients show, PEM",
        },
        Key {
            name: "revoked",
            kind: Kind::Text(&FILE),
            default: Default::Prose("none"),
            meaning: "the file with the lists of revoked certificates, PEM",
        },
        Key {
            name: "check_expiration",
            kind: Kind::Boolean,
            default: Default::Boolean(true),
            meaning: "whether a certificate holds from its first to its last day only; `false` is for a plant without a clock",
        },
        Key {
            name: "plain",
            kind: Kind::Word(&["on", "discovery", "off"]),
            default: Default::Text("on"),
            meaning: r#"EtherNet/IP without TLS on `listen`: `"on"`; `"discovery"` answers ListIdentity, ListServices and ListInterfaces and refuses sessions with encapsulation status 0x006A; `"off"` does not listen there on TCP, discovery over UDP stays"#,
        },
        Key {
            name: "io_over_tls",
            kind: Kind::Word(&["refuse", "plain"]),
            default: Default::Text("refuse"),
            meaning: r#"a Forward Open of class 0 or 1 that comes through TLS: `"refuse"` answers 0x0F, since its data would travel in the clear; `"plain"` lets it do so"#,
        },
        Key {
            name: "default_role",
            kind: Kind::Word(&["viewer", "operator", "engineer"]),
            default: Default::Text("viewer"),
            meaning: "the role of a client whose certificate has no row",
        },
        Key {
            name: "certificates",
            kind: Kind::Tables(&CERTIFICATE, 256),
            default: Default::Prose("none"),
            meaning: "the roles of certificates, a row each",
        },
        Key {
            name: "loopback",
            kind: Kind::Word(&["viewer", "operator", "engineer"]),
            default: Default::Text("engineer"),
            meaning: "the role of clients on this computer ([SECURITY.md](SECURITY.md)). A proxy, the server side of a tunnel and the port map of a container make their peers such clients",
        },
        Key {
            name: "remote_plain",
            kind: Kind::Word(&["viewer", "operator", "engineer"]),
            default: Default::Text("viewer"),
            meaning: "the role of clients elsewhere whose connection is not encrypted",
        },
        Key {
            name: "hmi_tls",
            kind: Kind::AddressOrOff("0.0.0.0:8443"),
            default: Default::Text("off"),
            meaning: r#"where the web page listens over HTTPS, or `"off"`; it shows the certificate above"#,
        },
        Key {
            name: "hmi_names",
            kind: Kind::Names(1..=32, "a list of 1 to 32 names of the host"),
            default: Default::Prose("none"),
            meaning: "names of the host by which browsers reach the page, beside `localhost`, addresses, and those of the certificate",
        },
        Key {
            name: "login_notice",
            kind: Kind::Text(&NOTICE),
            default: Default::Prose("none"),
            meaning: "a text that the page shows beside its log-in, such as who may use the machine",
        },
        Key {
            name: "users",
            kind: Kind::Text(&FILE),
            default: Default::Prose("none"),
            meaning: "the file with the users of the page and the tokens of scripts, which `arcline-server users` and `arcline-server tokens` write; relative to the folder of the configuration. Without it there are no log-ins",
        },
        Key {
            name: "idle_s",
            kind: Kind::Integer(60..=86_400, "s"),
            default: Default::Integer(1800),
            meaning: "time without input from a person after which a session of the page is locked",
        },
        Key {
            name: "session_s",
            kind: Kind::Integer(300..=604_800, "s"),
            default: Default::Integer(43_200),
            meaning: "the longest session of the page",
        },
        Key {
            name: "plain_allow",
            kind: Kind::Names(1..=64, NETWORKS),
            default: Default::Prose("all"),
            meaning: "the networks and addresses whose clients reach EtherNet/IP without TLS, over TCP and UDP, such as `[\"10.1.2.0/24\"]`; others are closed before anything is read. This computer always does",
        },
        Key {
            name: "tls_allow",
            kind: Kind::Names(1..=64, NETWORKS),
            default: Default::Prose("all"),
            meaning: "the same of EtherNet/IP over TLS: others are closed before the handshake",
        },
        Key {
            name: "hmi_allow",
            kind: Kind::Names(1..=64, NETWORKS),
            default: Default::Prose("all"),
            meaning: "the same of the web page, over HTTP and HTTPS",
        },
        Key {
            name: "max_requests_per_s_viewer",
            kind: Kind::Integer(0..=1_000_000, "1/s"),
            default: Default::Integer(0),
            meaning: "the most requests a second of an EtherNet/IP client that is a viewer; beyond, the answer is 0x02; 0: any number. Stops are not counted",
        },
        Key {
            name: "max_requests_per_s_operator",
            kind: Kind::Integer(0..=1_000_000, "1/s"),
            default: Default::Integer(0),
            meaning: "the same of an operator",
        },
        Key {
            name: "max_requests_per_s_engineer",
            kind: Kind::Integer(0..=1_000_000, "1/s"),
            default: Default::Integer(0),
            meaning: "the same of an engineer or administrator",
        },
    ],
};

pub(crate) static CERTIFICATE: Keys = Keys {
    heading: "### `[[security.certificates]]`",
    expected: "tables, [[security.certificates]]",
    keys: &[
        Key {
            name: "cn",
            kind: Kind::Text(&DISTINGUISHED_NAME),
            default: Default::Prose("none"),
            meaning: "the Common Name of the certificate's subject, with `issuer`",
        },
        Key {
            name: "issuer",
            kind: Kind::Text(&DISTINGUISHED_NAME),
            default: Default::Prose("none"),
            meaning: "the name of its issuer such as `CN=Plant CA,O=Plant`, as `arcline-server certs show` prints it",
        },
        Key {
            name: "sha256",
            kind: Kind::Text(&SHA256),
            default: Default::Prose("none"),
            meaning: "in place of both: SHA-256 over its SubjectPublicKeyInfo, 64 hexadecimal digits, as `arcline-server certs show` prints it",
        },
        Key {
            name: "role",
            kind: Kind::Word(&["viewer", "operator", "engineer", "administrator"]),
            default: Default::Required,
            meaning: "its role",
        },
    ],
};

pub(crate) static CONTROLLER: Keys = Keys {
    heading: "## `[controller]`",
    expected: "a table, [controller]",
    keys: &[
        Key {
            name: "program",
            kind: Kind::Text(&FILE),
            default: Default::Prose("none"),
            meaning: "the L5X file of a project whose tasks run beside the motion, with its tags and programs; relative to the folder of the configuration. Its axes and coordinate systems are those of the configuration with the same names",
        },
        Key {
            name: "mode",
            kind: Kind::Word(&["run", "program"]),
            default: Default::Text("run"),
            meaning: r#"the mode at the start: `"run"` or `"program"`, in which the tasks do not run"#,
        },
        Key {
            name: "allow_missing",
            kind: Kind::Boolean,
            default: Default::Boolean(false),
            meaning: "whether parts of the project that are missing or not supported are passed over; otherwise the project is refused",
        },
        Key {
            name: "messages",
            kind: Kind::Tables(&MESSAGE, 256),
            default: Default::Prose("none"),
            meaning: "the answers to MSG instructions, a row each; the first row that fits answers. A MSG without a row errs after its timeout",
        },
        Key {
            name: "wire",
            kind: Kind::Tables(&WIRE, 1024),
            default: Default::Prose("none"),
            meaning: "wires between the tags of modules and axes, a row each",
        },
    ],
};

pub(crate) static WIRE: Keys = Keys {
    heading: "### `[[controller.wire]]`",
    expected: "tables, [[controller.wire]]",
    keys: &[
        Key {
            name: "from",
            kind: Kind::Text(&WIRE_END),
            default: Default::Required,
            meaning: "a BOOL or a bit: of a tag of the program (`Local:2:O.Data.3`), of an axis (`X.ServoActionStatus`), or the home switch of an axis (`X.home_switch`)",
        },
        Key {
            name: "to",
            kind: Kind::Text(&WIRE_END),
            default: Default::Required,
            meaning: "what follows it: a BOOL or a bit of a tag (`Local:1:I.Data.0`), or an input of a servo axis: `X.home_switch`, `X.enable`, `X.registration_1`, `X.registration_2`. The drive of an axis whose `enable` is wired switches off while it is 0. Names are looked up when the program is loaded; one that is not there keeps it from running",
        },
        Key {
            name: "delay_ms",
            kind: Kind::Integer(0..=3_600_000, "ms"),
            default: Default::Integer(0),
            meaning: "how long `from` has a value until `to` takes it; a shorter pulse does not pass",
        },
    ],
};

pub(crate) static MESSAGE: Keys = Keys {
    heading: "### `[[controller.messages]]`",
    expected: "tables, [[controller.messages]]",
    keys: &[
        Key {
            name: "service",
            kind: Kind::Integer(1..=127, ""),
            default: Default::Required,
            meaning: "the service code of a MSG of the type CIP Generic",
        },
        Key {
            name: "class",
            kind: Kind::Integer(0..=65535, ""),
            default: Default::Required,
            meaning: "the class",
        },
        Key {
            name: "instance",
            kind: Kind::Integer(0..=4_294_967_295, ""),
            default: Default::Prose("any"),
            meaning: "the instance",
        },
        Key {
            name: "attribute",
            kind: Kind::Integer(0..=65535, ""),
            default: Default::Prose("any"),
            meaning: "the attribute",
        },
        Key {
            name: "answer",
            kind: Kind::Text(&HEX_BYTES),
            default: Default::Prose("no data"),
            meaning: "the data that comes to the destination, bytes in hexadecimal, such as `\"01 00 2A\"`; what the destination has no room for is lost",
        },
        Key {
            name: "delay_ms",
            kind: Kind::Integer(0..=3_600_000, "ms"),
            default: Default::Integer(0),
            meaning: "time from the request to the answer; the answer comes with the next tick at the earliest",
        },
        Key {
            name: "err",
            kind: Kind::Integer(0..=65535, ""),
            default: Default::Integer(0),
            meaning: "ERR; other than 0 the MSG errs",
        },
        Key {
            name: "exerr",
            kind: Kind::Integer(0..=4_294_967_295, ""),
            default: Default::Integer(0),
            meaning: "EXERR",
        },
    ],
};

static HEX_BYTES: TextRule = TextRule {
    expected: "up to 500 bytes in hexadecimal, such as \"01 00 2A\"",
    holds: |text| crate::read::hex_bytes(text).is_some_and(|bytes| bytes.len() <= 500),
    pattern: "^([0-9A-Fa-f]{2} *)*$",
};

static WIRE_END: TextRule = TextRule {
    expected: "a BOOL or a bit, such as \"Local:1:I.Data.0\" or \"X.home_switch\"",
    holds: |text| (1..=500).contains(&text.len()) && !text.contains(char::is_whitespace),
    pattern: "^\\S{1,500}$",
};

static FILE: TextRule = TextRule {
    expected: "the name of a file",
    holds: |text| !text.is_empty() && !text.contains('\0'),
    pattern: "^[^\\u0000]+$",
};

static NOTICE: TextRule = TextRule {
    expected: "a text of 1 to 1000 characters",
    holds: |text| (1..=1000).contains(&text.chars().count()) && !text.chars().any(|c| c.is_control() && c != '\n'),
    pattern: "^[^\\x00-\\x09\\x0B-\\x1F]{1,1000}$",
};

static DISTINGUISHED_NAME: TextRule = TextRule {
    expected: "a name of 1 to 1024 characters",
    holds: |text| (1..=1024).contains(&text.chars().count()),
    pattern: "^[\\s\\S]{1,1024}$",
};

static SHA256: TextRule = TextRule {
    expected: "64 hexadecimal digits",
    holds: |text| text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit()),
    pattern: "^[0-9A-Fa-f]{64}$",
};

pub(crate) static MOTION_GROUP: Keys = Keys {
    heading: "## `[motion_group]`",
    expected: "a table, [motion_group]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Text(crate::DEFAULT_GROUP),
            meaning: "the group's tag",
        },
        Key {
            name: "coarse_update_period_ms",
            kind: Kind::Number(Range::Within(0.25, 32.0), "ms"),
            default: Default::Number(1.0),
            meaning: "length of a tick: 0.25 to 32 ms",
        },
    ],
};

pub(crate) static AXIS: Keys = Keys {
    heading: "## `[[axis]]`",
    expected: "tables, [[axis]]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "the axis's tag",
        },
        Key {
            name: "type",
            kind: Kind::Word(&["servo", "virtual", "feedback"]),
            default: Default::Required,
            meaning: r#"`"servo"`: a simulated drive, AXIS_CIP_DRIVE; `"virtual"`: ideal, AXIS_VIRTUAL; `"feedback"`: an encoder whose position is written to a tag, AXIS_CIP_DRIVE, which can be a master and cannot be moved"#,
        },
        Key {
            name: "units",
            kind: Kind::Text(&UNITS),
            default: Default::Text("Position Units"),
            meaning: "a label",
        },
        Key {
            name: "max_speed",
            kind: Kind::Number(Range::Above(0.0), "units/s"),
            default: Default::Required,
            meaning: "100 % of speed",
        },
        Key {
            name: "max_acceleration",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Required,
            meaning: "100 % of acceleration",
        },
        Key {
            name: "max_deceleration",
            kind: Kind::Number(Range::From(0.0), "units/s²"),
            default: Default::Prose("`max_acceleration`"),
            meaning: "100 % of deceleration, and the rate of stops; 0: every move errs with 54",
        },
        Key {
            name: "max_acceleration_jerk",
            kind: Kind::Number(Range::Above(0.0), "units/s³"),
            default: Default::Prose("rate² / speed"),
            meaning: "100 % of acceleration jerk",
        },
        Key {
            name: "max_deceleration_jerk",
            kind: Kind::Number(Range::From(0.0), "units/s³"),
            default: Default::Prose("rate² / speed"),
            meaning: "100 % of deceleration jerk; 0: every S-curve errs with 76",
        },
        Key {
            name: "dynamics_configuration_bits",
            kind: Kind::Integer(0..=7, ""),
            default: Default::Integer(7),
            meaning: "Dynamics Configuration Bits: the bounds of S-curves whose dynamics change while they accelerate or brake, a sum of: 1 Reduce S-Curve Stop Delay (a stop takes an acceleration away with the larger of both jerks), 2 Prevent S-Curve Velocity Reversals (a stop that begins while an S-curve brakes does not reverse), 4 Reduced Extreme Velocity Overshoot (a change of dynamics or a merge overshoots the programmed speeds by at most half); 0: none, speeds may overshoot without bound. Clients change them [at run time](#attributes-at-run-time)",
        },
        Key {
            name: "travel",
            kind: Kind::Table(&TRAVEL),
            default: Default::Prose("unchecked"),
            meaning: "`{ min, max }`: soft travel limits of a linear axis",
        },
        Key {
            name: "unwind",
            kind: Kind::Number(Range::Above(0.0), "position units"),
            default: Default::Prose("linear"),
            meaning: "length of one turn; makes the axis rotary",
        },
        Key {
            name: "start",
            kind: Kind::Table(&START),
            default: Default::Prose("see below"),
            meaning: "the state of the axis at start-up",
        },
        Key {
            name: "drive",
            kind: Kind::Table(&DRIVE),
            default: Default::Prose("see below"),
            meaning: "the simulated drive; only of a servo",
        },
        Key {
            name: "home",
            kind: Kind::Table(&HOME),
            default: Default::Prose("immediate, to 0"),
            meaning: "how MAH homes the axis",
        },
        Key {
            name: "programmed_stop_mode",
            kind: Kind::Word(&[
                "fast_stop",
                "fast_disable",
                "hard_disable",
                "fast_shutdown",
                "hard_shutdown",
            ]),
            default: Default::Text("fast_stop"),
            meaning: r#"what MGS in mode Programmed does: `"fast_stop"` decelerates, `"fast_disable"` then switches the servo off, `"fast_shutdown"` then shuts the axis down; `"hard_disable"` and `"hard_shutdown"` do so at once"#,
        },
        Key {
            name: "exception_actions",
            kind: Kind::Table(&EXCEPTION_ACTIONS),
            default: Default::Prose("see below"),
            meaning: "what each fault does",
        },
        Key {
            name: "average_velocity_timebase",
            kind: Kind::Number(Range::AboveTo(0.0, 1.0), "seconds"),
            default: Default::Number(0.25),
            meaning: "time over which AverageVelocity is taken, above 0, at most 1 s",
        },
        Key {
            name: "command_limits",
            kind: Kind::Table(&COMMAND_LIMITS),
            default: Default::Prose("see below"),
            meaning: "what its set-points may ask of the axis",
        },
        Key {
            name: "output_cam_execution_targets",
            kind: Kind::Integer(0..=32, ""),
            default: Default::Integer(0),
            meaning: "output cams that MAOC can arm on the axis at once, 0 to 32",
        },
        Key {
            name: "feed",
            kind: Kind::Table(&FEED),
            default: Default::Prose("none"),
            meaning: "the tag that the position is written to; only of a feedback axis, which must have it",
        },
        Key {
            name: "registration",
            kind: Kind::Table(&REGISTRATION),
            default: Default::Prose("none"),
            meaning: "the tags of the inputs that MAR waits for",
        },
    ],
};

pub(crate) static START: Keys = Keys {
    heading: "### `start = { … }`",
    expected: "a table such as { position = 0.0, servo_on = true }",
    keys: &[
        Key {
            name: "position",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Number(0.0),
            meaning: "position at start-up; of a rotary axis within one turn",
        },
        Key {
            name: "servo_on",
            kind: Kind::Boolean,
            default: Default::Boolean(true),
            meaning: "whether the drive is on at start-up",
        },
        Key {
            name: "homed",
            kind: Kind::Boolean,
            default: Default::Boolean(true),
            meaning: "whether the axis counts as homed",
        },
    ],
};

pub(crate) static DRIVE: Keys = Keys {
    heading: "### `drive = { … }`",
    expected: "a table such as { position_bandwidth_hz = 40.0 }",
    keys: &[
        Key {
            name: "position_bandwidth_hz",
            kind: Kind::Number(Range::AboveTo(0.0, 10_000.0), "Hz"),
            default: Default::Number(40.0),
            meaning: "bandwidth of the position loop, Hz",
        },
        Key {
            name: "velocity_feedforward",
            kind: Kind::Number(Range::Within(0.0, 1.0), ""),
            default: Default::Number(1.0),
            meaning: "share of the command velocity that is fed forward, 0 to 1: the axis lags by (1 - share) × speed / (2π × bandwidth)",
        },
        Key {
            name: "position_error_tolerance",
            kind: Kind::Number(Range::From(0.0), "position units"),
            default: Default::Number(5.0),
            meaning: "following error above which the axis faults; 0: unchecked",
        },
        Key {
            name: "position_error_tolerance_time",
            kind: Kind::Number(Range::From(0.0), "s"),
            default: Default::Number(0.0),
            meaning: "how long the following error must stay above it, s",
        },
        Key {
            name: "speed_limit",
            kind: Kind::Number(Range::Above(0.0), "units/s"),
            default: Default::Prose("unlimited"),
            meaning: "highest speed of the motor, u/s",
        },
        Key {
            name: "torque_limit",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Prose("unlimited"),
            meaning: "acceleration of the axis under the highest torque of the motor, u/s²",
        },
        Key {
            name: "encoder_resolution",
            kind: Kind::Number(Range::Above(0.0), "counts per position unit"),
            default: Default::Prose("exact"),
            meaning: "counts per unit: the actual position is seen in whole counts",
        },
    ],
};

pub(crate) static FEED: Keys = Keys {
    heading: "### `feed = { … }`",
    expected: "{ tag = \"TAG\" }, the tag that its position is written to",
    keys: &[
        Key {
            name: "tag",
            kind: Kind::Text(&NUMBER_TAG),
            default: Default::Required,
            meaning: r#"path of a number of a `[[tag]]`, such as `"Encoder"` or `"Line.Position"`: the position of the axis, in its units; of a rotary axis on any turn"#,
        },
        Key {
            name: "interval_ms",
            kind: Kind::Number(Range::Within(0.0, 10_000.0), "ms"),
            default: Default::Number(10.0),
            meaning: "how often it is written: the axis goes from one written position to the next in that time, in a straight line, so it lags by as much",
        },
        Key {
            name: "timeout_ms",
            kind: Kind::Number(Range::AboveTo(0.0, 3_600_000.0), "ms"),
            default: Default::Number(100.0),
            meaning: "how old a position may become: then the axis has the fault `feedback_loss`",
        },
    ],
};

pub(crate) static REGISTRATION: Keys = Keys {
    heading: "### `registration = { … }`",
    expected: "a table such as { input_1 = \"Mark\" }",
    keys: &[
        Key {
            name: "input_1",
            kind: Kind::Text(&BIT_TAG),
            default: Default::Prose("none"),
            meaning: r#"path of a BOOL or of a bit of a `[[tag]]`, such as `"Marks.3"`; MAR waits for it to be written"#,
        },
        Key {
            name: "input_2",
            kind: Kind::Text(&BIT_TAG),
            default: Default::Prose("none"),
            meaning: r#"path of a BOOL or of a bit of a `[[tag]]`, such as `"Marks.3"`; MAR waits for it to be written"#,
        },
    ],
};

pub(crate) static EXCEPTION_ACTIONS: Keys = Keys {
    heading: "### `exception_actions = { … }`",
    expected: "a table such as { position_error = \"stop_drive\" }",
    keys: &[
        Key {
            name: "soft_travel_positive",
            kind: ACTION,
            default: Default::Text("stop_planner"),
            meaning: "a homed axis leaves `travel`",
        },
        Key {
            name: "soft_travel_negative",
            kind: ACTION,
            default: Default::Text("stop_planner"),
            meaning: "a homed axis leaves `travel`",
        },
        Key {
            name: "position_error",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "the following error is above its tolerance",
        },
        Key {
            name: "drive",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "the drive switches off by itself",
        },
        Key {
            name: "overcurrent",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "injected only",
        },
        Key {
            name: "overspeed",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "injected only",
        },
        Key {
            name: "overtravel_positive",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "injected only",
        },
        Key {
            name: "overtravel_negative",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "injected only",
        },
        Key {
            name: "feedback_loss",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "injected only",
        },
        Key {
            name: "command_limit",
            kind: ACTION,
            default: Default::Text("stop_planner"),
            meaning: "a command beyond `command_limits` did not go out; the axis stops in any case: no weaker action",
        },
        Key {
            name: "drive_communication",
            kind: ACTION,
            default: Default::Text("stop_drive"),
            meaning: "the drive does not answer",
        },
    ],
};

pub(crate) static COMMAND_LIMITS: Keys = Keys {
    heading: "### `command_limits = { … }`",
    expected: "a table such as { speed = 4.0, acceleration = 100.0 }",
    keys: &[
        Key {
            name: "enabled",
            kind: Kind::Boolean,
            default: Default::Prose("`true` for a servo, else `false`"),
            meaning: "whether the limits apply",
        },
        Key {
            name: "speed",
            kind: Kind::Number(Range::Within(1.0, 1e6), "times the axis's maximum"),
            default: Default::Number(4.0),
            meaning: "highest speed, times `max_speed`; from 1",
        },
        Key {
            name: "acceleration",
            kind: Kind::Number(Range::Within(1.0, 1e6), "times the axis's maximum"),
            default: Default::Number(100.0),
            meaning: "highest change of velocity, times the higher one of `max_acceleration` and `max_deceleration`; from 1; not of an axis that follows a master",
        },
    ],
};

pub(crate) static TRAVEL: Keys = Keys {
    heading: "### `travel = { … }`",
    expected: "{ min = NUMBER, max = NUMBER }",
    keys: &[
        Key {
            name: "min",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Required,
            meaning: "Soft Travel Limit Negative",
        },
        Key {
            name: "max",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Required,
            meaning: "Soft Travel Limit Positive",
        },
    ],
};

pub(crate) static HOME: Keys = Keys {
    heading: "### `home = { … }`",
    expected: "a table such as { sequence = \"switch\", speed = 50.0 }",
    keys: &[
        Key {
            name: "mode",
            kind: Kind::Word(&["active", "passive"]),
            default: Default::Text("active"),
            meaning: r#"`"active"`: MAH moves the axis; `"passive"`: it waits for the event while others move the axis"#,
        },
        Key {
            name: "sequence",
            kind: Kind::Word(&[
                "immediate",
                "switch",
                "marker",
                "switch-marker",
                "torque",
                "torque-marker",
            ]),
            default: Default::Text("immediate"),
            meaning: r#"`"immediate"`: where the axis stands; `"switch"`, `"marker"`, `"switch-marker"`: the event; `"torque"` and `"torque-marker"`: a mechanical stop at the machine position of the travel limit in that direction; without `travel` MAH errs with 41"#,
        },
        Key {
            name: "direction",
            kind: Kind::Word(&[
                "bidirectional-forward",
                "bidirectional-reverse",
                "unidirectional-forward",
                "unidirectional-reverse",
            ]),
            default: Default::Text("bidirectional-forward"),
            meaning: r#"`"bidirectional-"` comes back to the home point, `"unidirectional-"` does not; then `"forward"` or `"reverse"`"#,
        },
        Key {
            name: "position",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Number(0.0),
            meaning: "Home Position; of a rotary axis within one turn",
        },
        Key {
            name: "offset",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Number(0.0),
            meaning: "Home Offset: how far from the event the Home Position lies",
        },
        Key {
            name: "speed",
            kind: Kind::Number(Range::Above(0.0), "units/s"),
            default: Default::Prose("none"),
            meaning: "Home Speed, of the first leg; needed where the axis moves",
        },
        Key {
            name: "return_speed",
            kind: Kind::Number(Range::Above(0.0), "units/s"),
            default: Default::Prose("`speed`"),
            meaning: "Home Return Speed, of later legs",
        },
        Key {
            name: "acceleration",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Prose("`max_acceleration`"),
            meaning: "of all legs, which are trapezoidal",
        },
        Key {
            name: "deceleration",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Prose("`max_deceleration`"),
            meaning: "of all legs, which are trapezoidal",
        },
        Key {
            name: "switch",
            kind: Kind::Table(&SWITCH),
            default: Default::Prose("none: error 84"),
            meaning: "the home switch; only of a servo",
        },
        Key {
            name: "marker",
            kind: Kind::Table(&MARKER),
            default: Default::Prose("none: error 84"),
            meaning: "the marker of the encoder; only of a servo",
        },
    ],
};

pub(crate) static SWITCH: Keys = Keys {
    heading: "### `switch = { … }`",
    expected: "a table such as { min = 0.0, max = 20.0 }",
    keys: &[
        Key {
            name: "min",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Prose("`0.0`; without end where only `max` is given"),
            meaning: "where it becomes active going forward",
        },
        Key {
            name: "max",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Prose("without end"),
            meaning: "where it becomes active going in reverse",
        },
    ],
};

pub(crate) static MARKER: Keys = Keys {
    heading: "### `marker = { … }`",
    expected: "a table such as { at = 0.0, every = 10.0 }",
    keys: &[
        Key {
            name: "at",
            kind: Kind::Number(Range::Any, "position units"),
            default: Default::Number(0.0),
            meaning: "one marker",
        },
        Key {
            name: "every",
            kind: Kind::Number(Range::Above(0.0), "position units"),
            default: Default::Prose("once; of a rotary axis once a turn"),
            meaning: "the distance from one to the next",
        },
    ],
};

pub(crate) static COORDINATE_SYSTEM: Keys = Keys {
    heading: "## `[[coordinate_system]]`",
    expected: "tables, [[coordinate_system]]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "the coordinate system's tag",
        },
        Key {
            name: "type",
            kind: Kind::Word(&[
                "cartesian",
                "articulated_independent",
                "articulated_dependent",
                "scara_independent",
                "scara_delta",
                "delta",
            ]),
            default: Default::Text("cartesian"),
            meaning: r#"the geometry, see [TRANSFORMS.md](TRANSFORMS.md): `"cartesian"`; or a robot whose joints its axes are: `"articulated_independent"`, `"articulated_dependent"`, `"delta"` (2 or 3 axes), `"scara_independent"`, `"scara_delta"` (3 axes)"#,
        },
        Key {
            name: "definition",
            kind: Kind::Word(&["XYZRxRyRz", "J1J2J6", "J1J2J3J6", "J1J2J3J4J5", "J1J2J3J4J5J6"]),
            default: Default::Prose("none"),
            meaning: r#"Coordinate Definition, of a system with orientation: of type `"cartesian"` `"XYZRxRyRz"`; of `"delta"` `"J1J2J6"`, `"J1J2J3J6"` or `"J1J2J3J4J5"`; of `"scara_independent"` `"J1J2J3J6"`; of `"articulated_independent"` `"J1J2J3J4J5J6"`. MCTO links these"#,
        },
        Key {
            name: "axes",
            kind: Kind::Names(1..=6, "a list of 1 to 3 names of axes"),
            default: Default::Required,
            meaning: "its primary axes, 1 to 3 names; with `definition` as many as that names, in its order: Rx, Ry, Rz and joints that turn in degrees",
        },
        Key {
            name: "max_speed",
            kind: Kind::Number(Range::Above(0.0), "units/s"),
            default: Default::Required,
            meaning: "100 % of the vector's speed",
        },
        Key {
            name: "max_acceleration",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Required,
            meaning: "100 % of its acceleration",
        },
        Key {
            name: "max_deceleration",
            kind: Kind::Number(Range::From(0.0), "units/s²"),
            default: Default::Prose("`max_acceleration`"),
            meaning: "100 % of its deceleration; 0: every move errs with 54",
        },
        Key {
            name: "max_acceleration_jerk",
            kind: Kind::Number(Range::Above(0.0), "units/s³"),
            default: Default::Prose("rate² / speed"),
            meaning: "100 % of its acceleration jerk",
        },
        Key {
            name: "max_deceleration_jerk",
            kind: Kind::Number(Range::From(0.0), "units/s³"),
            default: Default::Prose("rate² / speed"),
            meaning: "100 % of its deceleration jerk; 0: every S-curve errs with 76",
        },
        Key {
            name: "dynamics_configuration_bits",
            kind: Kind::Integer(0..=7, ""),
            default: Default::Integer(7),
            meaning: "as of an axis, for coordinated moves",
        },
        Key {
            name: "max_orientation_speed",
            kind: Kind::Number(Range::Above(0.0), "units/s"),
            default: Default::Prose("the least of Rx, Ry, Rz"),
            meaning: r#"100 % of the speed of the turn, degrees/s; only of `"XYZRxRyRz"`"#,
        },
        Key {
            name: "max_orientation_acceleration",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Prose("the least of Rx, Ry, Rz"),
            meaning: "100 % of its acceleration, degrees/s²",
        },
        Key {
            name: "max_orientation_deceleration",
            kind: Kind::Number(Range::Above(0.0), "units/s²"),
            default: Default::Prose("`max_orientation_acceleration`"),
            meaning: "100 % of its deceleration, degrees/s²",
        },
        Key {
            name: "actual_tolerance",
            kind: Kind::Number(Range::From(0.0), "position units"),
            default: Default::Number(0.0),
            meaning: "Actual Position Tolerance: termination type 0 waits for it; 0: that type errs with 51",
        },
        Key {
            name: "command_tolerance",
            kind: Kind::Number(Range::From(0.0), "position units"),
            default: Default::Number(0.0),
            meaning: "Command Position Tolerance of termination type 2",
        },
        Key {
            name: "queue_depth",
            kind: Kind::Integer(1..=1000, ""),
            default: Default::Integer(1),
            meaning: "pending moves behind the active one: 1 as in Logix, up to 1000",
        },
        Key {
            name: "corner",
            kind: Kind::Word(&["logix", "precise"]),
            default: Default::Text("logix"),
            meaning: r#"termination types 2, 3, 6: `"logix"` superposes two moves, `"precise"` plans the queued moves as one contour, which stays within the tolerance of the programmed path and takes its corners at the highest speed"#,
        },
        Key {
            name: "deviation",
            kind: Kind::Word(&["corners", "anywhere"]),
            default: Default::Text("corners"),
            meaning: r#"of `corner = "precise"`: `"corners"` keeps a move longer than 50 tolerances to its path between the roundings of its corners (at most a hundredth of the tolerance off it; a rounding reaches at most 10 tolerances); shorter moves and the chords of a curve (lines of at most 250 tolerances that turn little at their ends, [motion core, section 6.4](spec/motion-core.md#64-optional-precise-corner-geometric-blending)) may deviate anywhere inside the tolerance. With `"anywhere"` all moves may, which is a little faster"#,
        },
        Key {
            name: "axis_limits",
            kind: Kind::Word(&["ignore", "enforce"]),
            default: Default::Text("ignore"),
            meaning: r#"`"enforce"`: the path speed is lowered so that no axis exceeds its own maxima"#,
        },
        Key {
            name: "joint_limits",
            kind: Kind::Word(&["ignore", "enforce"]),
            default: Default::Text("ignore"),
            meaning: r#"`"enforce"`: speed and rates of a move are lowered so that no joint of a robot that MCT links to it exceeds its own maxima"#,
        },
        Key {
            name: "link_lengths",
            kind: Kind::Numbers(2..=2, "two numbers"),
            default: Default::Prose("`[0.0, 0.0]`"),
            meaning: "of a robot: L1 and L2; 0 makes MCT err with 61, 9",
        },
        Key {
            name: "base_offsets",
            kind: Kind::Numbers(3..=3, "a list of three numbers"),
            default: Default::Prose("`[0.0, 0.0, 0.0]`"),
            meaning: "of a robot: X1b, X2b, X3b",
        },
        Key {
            name: "end_effector_offsets",
            kind: Kind::Numbers(3..=3, "a list of three numbers"),
            default: Default::Prose("`[0.0, 0.0, 0.0]`"),
            meaning: "of a robot: X1e, X2e, X3e",
        },
        Key {
            name: "zero_angles",
            kind: Kind::Numbers(3..=6, "a list of three numbers"),
            default: Default::Prose("zeros"),
            meaning: "of a robot: the zero angle orientation of each joint, degrees; three numbers, or one for each joint that `definition` names",
        },
    ],
};

pub(crate) static TRANSFORM: Keys = Keys {
    heading: "## `[[transform]]`",
    expected: "tables, [[transform]]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "the link's name",
        },
        Key {
            name: "source",
            kind: Kind::Text(&SYSTEM_NAME),
            default: Default::Required,
            meaning: "the coordinate system that MCT transforms from",
        },
        Key {
            name: "target",
            kind: Kind::Text(&SYSTEM_NAME),
            default: Default::Required,
            meaning: "the coordinate system that it transforms to; MCT may link other systems too",
        },
    ],
};

pub(crate) static INSTRUCTION: Keys = Keys {
    heading: "## `[[instruction]]`",
    expected: "tables, [[instruction]]",
    keys: &[
        Key {
            name: "tag",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "an instruction as a tag: what an HMI that only writes tags uses",
        },
        Key {
            name: "type",
            kind: Kind::Mnemonic,
            default: Default::Required,
            meaning: "the instruction's mnemonic",
        },
        Key {
            name: "target",
            kind: Kind::Text(&TARGET),
            default: Default::Prose("the motion group, where the instruction acts on it"),
            meaning: "the coordinate system, axis or group that it acts on",
        },
    ],
};

pub(crate) static DATA_TYPE: Keys = Keys {
    heading: "## `[[data_type]]`",
    expected: "tables, [[data_type]]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "a structure type for tags",
        },
        Key {
            name: "members",
            kind: Kind::Tables(&MEMBER, MAX_MEMBERS),
            default: Default::Required,
            meaning: "a list of tables, see below; at most 512",
        },
    ],
};

pub(crate) static MEMBER: Keys = Keys {
    heading: "### `members = [{ … }]`",
    expected: "a list of tables such as { name = \"Speed\", type = \"REAL\" }",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "the member's name",
        },
        Key {
            name: "type",
            kind: Kind::MemberType,
            default: Default::Required,
            meaning: "as of a tag, but with at most one dimension; a structure must stand above",
        },
    ],
};

pub(crate) static TAG: Keys = Keys {
    heading: "## `[[tag]]`",
    expected: "tables, [[tag]]",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name,
            default: Default::Required,
            meaning: "plain data",
        },
        Key {
            name: "type",
            kind: Kind::TagType,
            default: Default::Prose("that of the `alias`"),
            meaning: "`BOOL`, `SINT`, `INT`, `DINT`, `LINT`, `USINT`, `UINT`, `UDINT`, `ULINT`, `REAL`, `LREAL`, `STRING`, `CAM`, `CAM_PROFILE`, `OUTPUT_CAM`, `OUTPUT_COMPENSATION`, `POSITION_DATA`, `PATH_DATA`, `DYNAMICS_DATA`, `TIMER`, `COUNTER`, `CONTROL` or a `[[data_type]]`, or an array of up to three dimensions such as `REAL[16]` or `DINT[2,3]`; or `MOTION_INSTRUCTION` (no array): a motion control tag, which instructions write and clients read",
        },
        Key {
            name: "program",
            kind: Kind::Name,
            default: Default::Prose("the controller's scope"),
            meaning: "the program in whose scope the tag is: `Program:Main.X`",
        },
        Key {
            name: "access",
            kind: Kind::Word(&["read_write", "read_only"]),
            default: Default::Text("read_write"),
            meaning: r#"`"read_only"`: clients may not write it"#,
        },
        Key {
            name: "write_role",
            kind: Kind::Word(&["operator", "engineer", "administrator"]),
            default: Default::Text("operator"),
            meaning: "the least role that may write it ([security](SECURITY.md))",
        },
        Key {
            name: "min",
            kind: Kind::Number(Range::Any, ""),
            default: Default::Prose("none"),
            meaning: "the least number that clients may write to it or to an element of it; of integers and reals. A write of several elements of which one is outside writes none",
        },
        Key {
            name: "max",
            kind: Kind::Number(Range::Any, ""),
            default: Default::Prose("none"),
            meaning: "the greatest, likewise",
        },
        Key {
            name: "value",
            kind: Kind::Any,
            default: Default::Prose("zeros"),
            meaning: "its first value: a number, `true`, a text, a list of them dimension by dimension, a table of a structure's members",
        },
        Key {
            name: "alias",
            kind: Kind::Text(&ALIAS),
            default: Default::Prose("none"),
            meaning: r#"in place of `type` and `value`: a tag above or a part of one, such as `"Recipe[3].Speed"`"#,
        },
    ],
};

const ACTION: Kind = Kind::Word(&[
    "ignore",
    "alarm",
    "fault_status_only",
    "stop_planner",
    "stop_drive",
    "shutdown",
]);
const MAX_INSTRUCTION_TAGS: usize = 1024;

/// The Identity object's Product Name is a SHORT_STRING of up to 32 characters.
static PRODUCT_NAME: TextRule = TextRule {
    expected: "1 to 32 printable ASCII characters",
    holds: |text| {
        let printable = text.chars().all(|c| c == ' ' || c.is_ascii_graphic());
        !text.trim().is_empty() && text.len() <= 32 && printable
    },
    pattern: "^[ -~]{1,32}$",
};
static UNITS: TextRule = TextRule {
    expected: "a label of up to 40 bytes such as \"mm\"",
    holds: |text| text.len() <= 40 && !text.chars().any(char::is_control),
    pattern: "^[^\\x00-\\x1F]{0,40}$",
};
static NUMBER_TAG: TextRule = TextRule::any("the path of a number of a [[tag]]");
static BIT_TAG: TextRule = TextRule::any("the path of a BOOL or of a bit of a [[tag]]");
static SYSTEM_NAME: TextRule = TextRule::any("the name of a coordinate system");
static TARGET: TextRule =
    TextRule::any("the name of the coordinate system, axis or group that the instruction acts on");
static ALIAS: TextRule = TextRule::any("the path of a tag above or of a part of it, such as \"Recipe[3].Speed\"");
