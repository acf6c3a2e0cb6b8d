//! `status` and `identify`: the machine and the server at a glance.

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::{Value as Json, json};

use arcline_client::{Client, ClientError, Identity, Object, Reading, Tag, discover as ask_everybody, nearest};

use super::output::table;
use super::{Failure, Output};

/// Tag of the real-time thread.
const REAL_TIME: &str = "RealTime";
/// Tag of the feed overrides.
const FEED_OVERRIDE: &str = "FeedOverride";

/// What is shown of an object: a row of its table, and a JSON object.
struct Shown {
    kind: Kind,
    row: Vec<String>,
    object: Json,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Axis,
    System,
    Group,
    RealTime,
}

impl Kind {
    const ALL: [Kind; 4] = [Self::Axis, Self::System, Self::Group, Self::RealTime];

    fn header(self) -> &'static [&'static str] {
        match self {
            Self::Axis => &["axis", "position", "command", "velocity", "servo", "homed", "state"],
            Self::System => &["coordinate system", "position", "state"],
            Self::Group => &["motion group", "synced", "faults"],
            Self::RealTime => &[
                "real time",
                "period ms",
                "ticks",
                "overruns",
                "lateness mean µs",
                "p99 µs",
                "max µs",
                "scheduling",
            ],
        }
    }
}

/// `status`.
pub(crate) async fn status(client: &Client, names: &[String], output: &Output) -> Result<(), Failure> {
    let tags = client.browse().await?;
    let shown: Vec<(Tag, Kind)> = tags
        .into_iter()
        .filter_map(|tag| kind(&tag).map(|kind| (tag, kind)))
        .collect();
    for name in names {
        if !shown.iter().any(|(tag, _)| tag.name.eq_ignore_ascii_case(name)) {
            let suggestion = nearest(name, shown.iter().map(|(tag, _)| tag.name.as_str()));
            return Err(ClientError::UnknownTag {
                name: name.clone(),
                suggestion,
            }
            .into());
        }
    }
    let asked = |tag: &Tag| names.is_empty() || names.iter().any(|name| name.eq_ignore_ascii_case(&tag.name));
    let shown: Vec<(Tag, Kind)> = shown.into_iter().filter(|(tag, _)| asked(tag)).collect();
    let paths: Vec<&str> = shown.iter().map(|(tag, _)| tag.name.as_str()).collect();
    let overrides = overrides(client).await?;
    let mut rows = Vec::new();
    for ((tag, kind), reading) in shown.iter().zip(client.read_many(&paths).await?) {
        let reading = reading?;
        rows.push(match kind {
            Kind::Axis => axis(tag, &reading),
            Kind::System => system(tag, &reading, overrides.get(&tag.name).copied()),
            Kind::Group => group(tag, &reading),
            Kind::RealTime => real_time(tag, &reading),
        });
    }
    if output.is_json() {
        rows.into_iter().for_each(|shown| output.result("", || shown.object));
        return Ok(());
    }
    let mut tables = Vec::new();
    for kind in Kind::ALL {
        let rows: Vec<Vec<String>> = rows
            .iter()
            .filter(|shown| shown.kind == kind)
            .map(|s| s.row.clone())
            .collect();
        if !rows.is_empty() {
            tables.push(table(kind.header(), &rows));
        }
    }
    output.result(tables.join("\n\n"), || Json::Null);
    Ok(())
}

/// The feed override of every coordinate system, percent; none where the server has no such tag.
async fn overrides(client: &Client) -> Result<BTreeMap<String, f64>, Failure> {
    let values = match client.read(FEED_OVERRIDE).await {
        Ok(reading) => reading.numbers().unwrap_or_default(),
        Err(error) if error.is_connection() => return Err(error.into()),
        Err(_) => Vec::new(),
    };
    let systems = client.objects(Object::CoordinateSystem).await?;
    Ok(systems.into_iter().zip(values).collect())
}

fn kind(tag: &Tag) -> Option<Kind> {
    match tag.object() {
        Some(Object::Axis) => Some(Kind::Axis),
        Some(Object::CoordinateSystem) => Some(Kind::System),
        Some(Object::MotionGroup) => Some(Kind::Group),
        None => (tag.name == REAL_TIME).then_some(Kind::RealTime),
    }
}

/// Names of the members that are true, in the words of the table.
pub(super) fn words(reading: &Reading, members: &[(&str, &str)]) -> String {
    let set: Vec<&str> = members
        .iter()
        .filter(|(member, _)| reading.flag(member))
        .map(|(_, word)| *word)
        .collect();
    set.join(" ")
}

fn or(text: String, otherwise: &str) -> String {
    if text.is_empty() { otherwise.to_owned() } else { text }
}

pub(super) const AXIS_FAULTS: &[(&str, &str)] = &[
    ("PhysicalAxisFault", "axis-fault"),
    ("ModuleFault", "module-fault"),
    ("ConfigFault", "configuration-fault"),
    ("GroupFault", "group-fault"),
    ("MotionFault", "motion-fault"),
    ("GuardFault", "guard-fault"),
    ("InitializationFault", "initialization-fault"),
    ("APRFault", "apr-fault"),
    ("SafetyFault", "safety-fault"),
];

fn axis(tag: &Tag, reading: &Reading) -> Shown {
    let (position, command) = (reading.number("ActualPosition"), reading.number("CommandPosition"));
    let velocity = reading.number("CommandVelocity");
    let (servo, homed) = (reading.flag("ServoActionStatus"), reading.flag("AxisHomedStatus"));
    let faults = words(reading, AXIS_FAULTS);
    let motion = words(
        reading,
        &[
            ("ShutdownStatus", "shutdown"),
            ("InhibitStatus", "inhibited"),
            ("CoordinatedMotionStatus", "coordinated"),
            ("MoveStatus", "moving"),
            ("JogStatus", "jogging"),
            ("GearingStatus", "geared"),
            ("HomingStatus", "homing"),
            ("StoppingStatus", "stopping"),
        ],
    );
    let state = or(format!("{motion} {faults}").trim().to_owned(), "at rest");
    let row = vec![
        tag.name.clone(),
        fixed(position),
        fixed(command),
        fixed(velocity),
        yes_no(servo, "on", "off"),
        yes_no(homed, "yes", "no"),
        state.clone(),
    ];
    let object = json!({
        "kind": "axis", "name": tag.name, "type": tag.type_name(), "position": position, "command": command,
        "velocity": velocity, "servo": servo, "homed": homed, "state": state,
        "faults": faults.split_whitespace().collect::<Vec<_>>(),
    });
    Shown {
        kind: Kind::Axis,
        row,
        object,
    }
}

fn system(tag: &Tag, reading: &Reading, percent: Option<f64>) -> Shown {
    let position = reading
        .member("ActualPosition")
        .and_then(Reading::numbers)
        .unwrap_or_default();
    let motion = words(
        reading,
        &[
            ("ShutdownStatus", "shutdown"),
            ("AxisInhibitStatus", "inhibited"),
            ("MoveStatus", "moving"),
            ("MoveTransitionStatus", "blending"),
            ("StoppingStatus", "stopping"),
            ("MovePendingStatus", "pending"),
            ("MovePendingQueueFullStatus", "queue-full"),
            ("TransformSourceStatus", "transform-source"),
            ("TransformTargetStatus", "transform-target"),
        ],
    );
    let faults = words(reading, AXIS_FAULTS);
    let otherwise = if reading.flag("ReadyStatus") {
        "at rest"
    } else {
        "not ready"
    };
    let mut state = or(format!("{motion} {faults}").trim().to_owned(), otherwise);
    match percent {
        Some(0.0) => state.push_str(", held"),
        Some(percent) if percent != 100.0 => state.push_str(&format!(", override {percent}%")),
        _ => {}
    }
    // At most three axes; the others are unused and 0.
    let shown: Vec<String> = position.iter().take(3).map(|axis| fixed(*axis)).collect();
    let object = json!({
        "kind": "coordinate system", "name": tag.name, "position": position, "ready": reading.flag("ReadyStatus"),
        "state": state, "faults": faults.split_whitespace().collect::<Vec<_>>(), "override": percent,
    });
    Shown {
        kind: Kind::System,
        row: vec![tag.name.clone(), shown.join(", "), state],
        object,
    }
}

fn group(tag: &Tag, reading: &Reading) -> Shown {
    let synced = reading.flag("GroupSynced");
    let faults = words(
        reading,
        &[
            ("GroupOverlapFault", "overlap"),
            ("CSTLossFault", "time-lost"),
            ("GroupTaskLoadingFault", "task-loading"),
            ("ClockSyncFault", "clock"),
            ("PhysicalAxisFault", "axis"),
            ("ModuleFault", "module"),
            ("ConfigFault", "configuration"),
        ],
    );
    let object = json!({
        "kind": "motion group", "name": tag.name, "synced": synced,
        "faults": faults.split_whitespace().collect::<Vec<_>>(),
    });
    let row = vec![tag.name.clone(), yes_no(synced, "yes", "no"), or(faults, "none")];
    Shown {
        kind: Kind::Group,
        row,
        object,
    }
}

fn real_time(tag: &Tag, reading: &Reading) -> Shown {
    let (ticks, overruns) = (reading.number("Ticks"), reading.number("Overruns"));
    let period = reading.number("UpdatePeriod");
    let [mean, p99, max] = ["LatenessMean", "LatenessP99", "LatenessMax"].map(|member| reading.number(member));
    let scheduling = [
        ("Fifo", "fifo"),
        ("MemoryLocked", "memory-locked"),
        ("Pinned", "pinned"),
    ];
    let scheduling = or(words(reading, &scheduling), "ordinary");
    let object = json!({
        "kind": "real time", "name": tag.name, "update_period_ms": period, "ticks": ticks, "overruns": overruns, "lateness_mean_us": mean,
        "lateness_p99_us": p99, "lateness_max_us": max, "fifo": reading.flag("Fifo"),
        "memory_locked": reading.flag("MemoryLocked"), "pinned": reading.flag("Pinned"),
    });
    let lateness = [mean, p99, max].map(|time| format!("{time:.1}"));
    let [mean, p99, max] = lateness;
    let row = vec![
        tag.name.clone(),
        format!("{period}"),
        format!("{ticks}"),
        format!("{overruns}"),
        mean,
        p99,
        max,
        scheduling,
    ];
    Shown {
        kind: Kind::RealTime,
        row,
        object,
    }
}

fn fixed(number: f64) -> String {
    format!("{number:.3}")
}

fn yes_no(truth: bool, yes: &str, no: &str) -> String {
    if truth { yes } else { no }.to_owned()
}

/// `identify`.
pub(crate) async fn identify(client: &Client, output: &Output) -> Result<(), Failure> {
    let (address, identity) = client.identify().await?;
    show(&address.to_string(), &identity, output);
    Ok(())
}

/// `identify --broadcast`.
pub(crate) async fn discover(address: &str, seconds: f64, output: &Output) -> Result<(), Failure> {
    let wait = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::from_secs(1));
    let port = arcline_client::DEFAULT_PORT;
    let address = if address.contains(':') {
        address.to_owned()
    } else {
        format!("{address}:{port}")
    };
    let found = ask_everybody(&address, wait).await?;
    for one in &found {
        show(&one.from.to_string(), &one.identity, output);
    }
    if found.is_empty() {
        output.note(&format!("nobody answered at {address} within {seconds} s"));
    }
    Ok(())
}

fn show(address: &str, identity: &Identity, output: &Output) {
    let Identity {
        vendor,
        device_type,
        product_code,
        major,
        minor,
        serial,
        state,
        ..
    } = identity;
    let text = format!(
        "{address}  {}  revision {major}.{minor}  serial {serial:08X}  vendor 0x{vendor:04X}  type 0x{device_type:02X}  \
         product {product_code}  state {state}",
        identity.name()
    );
    output.result(text, || {
        json!({
            "address": address, "name": identity.name(), "revision": format!("{major}.{minor}"), "serial": serial,
            "vendor": vendor, "device_type": device_type, "product_code": product_code, "state": state,
        })
    });
}
