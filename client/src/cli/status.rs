//! `status`: the machine at a glance, for `watch` too.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use arcline_client::{
    Client, ClientError, CommandCount, FaultSet, Mover, Object, Progress, Tag, TagValue, shown_faults,
};
use arcline_instruction_set::Ending;

use super::output::table;
use super::rests::Rests;
use super::{Failure, Output};

/// Tag of the real-time thread.
const REAL_TIME: &str = "RealTime";
/// Axes of a coordinate system on a server without that attribute.
const PRIMARY_AXES: usize = 3;
/// Tag of the feed overrides.
const FEED_OVERRIDE: &str = "FeedOverride";

/// The status of an object: a row of its table, and a JSON object.
#[derive(Clone, Debug)]
pub(super) struct ObjectStatus {
    pub(super) kind: Kind,
    pub(super) name: String,
    pub(super) row: Vec<String>,
    pub(super) object: Json,
    /// The client, page or program that moves the object.
    pub(super) mover: Option<String>,
    /// Actual position of an axis, or of each axis of a coordinate system, position units.
    pub(super) position: Vec<f64>,
}

impl ObjectStatus {
    /// Adds the client, page or program that moves the object.
    fn moved_by(mut self, mover: Option<&Mover>) -> Self {
        if let Some(object) = self.object.as_object_mut() {
            let moved_by = mover.map(|mover| {
                json!({
                    "text": mover.to_string(), "address": mover.address, "product": mover.identification.product, "user": mover.identification.user,
                    "program": mover.identification.program, "line": (mover.line > 0).then_some(mover.line),
                })
            });
            object.insert("moved_by".to_owned(), moved_by.unwrap_or_default());
        }
        self.mover = mover.map(ToString::to_string);
        self
    }

    /// The row, with the mover behind the state.
    pub(super) fn row_with_mover(&self) -> Vec<String> {
        let mut row = self.row.clone();
        if let (Some(mover), Some(state)) = (&self.mover, row.last_mut()) {
            state.push_str(&format!(", moved by {mover}"));
        }
        row
    }

    /// Adds the rests of planned contours on the way, on a server that counts them.
    fn rested(mut self, rests: Option<&Rests>) -> Self {
        let Some(rests) = rests else { return self };
        if let Some(object) = self.object.as_object_mut() {
            object.insert("rests".to_owned(), rests.json());
        }
        let text = rests.text();
        if let Some(state) = self.row.last_mut().filter(|_| !text.is_empty()) {
            state.push_str(&format!(", {text}"));
        }
        self
    }
}

/// The kind of an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Axis,
    System,
    Group,
    RealTime,
}

impl Kind {
    pub(super) const ALL: [Kind; 4] = [Self::Axis, Self::System, Self::Group, Self::RealTime];

    pub(super) fn header(self) -> &'static [&'static str] {
        match self {
            Self::Axis => &["axis", "position", "command", "velocity", "servo", "homed", "state"],
            Self::System => &["coordinate system", "position", "active move", "state"],
            Self::Group => &["motion group", "synced", "motion", "faults"],
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
    let shown = StatusQuery::find(client, names).await?.read(client).await?;
    let counts = if names.is_empty() {
        command_counts(client).await?
    } else {
        Vec::new()
    };
    if output.is_json() {
        shown.into_iter().for_each(|shown| output.result("", || shown.object));
        for CommandCount { kind, done, refused } in counts {
            output.result(
                "",
                || json!({"kind": "commands", "name": kind, "executed": done, "refused": refused}),
            );
        }
        return Ok(());
    }
    let mut text = tables(&shown);
    if !counts.is_empty() {
        text.push_str(&format!("\n\n{}", table_of_counts(&counts)));
    }
    output.result(text, || Json::Null);
    Ok(())
}

/// The commands of all clients by their kind; none on a server that does not count them.
async fn command_counts(client: &Client) -> Result<Vec<CommandCount>, Failure> {
    match client.command_counts().await {
        Err(error) if error.is_connection() => Err(error.into()),
        counts => Ok(counts.unwrap_or_default()),
    }
}

fn table_of_counts(counts: &[CommandCount]) -> String {
    let row = |count: &CommandCount| vec![count.kind.clone(), count.done.to_string(), count.refused.to_string()];
    table(
        &["commands", "executed", "refused"],
        &counts.iter().map(row).collect::<Vec<_>>(),
    )
}

/// A table for each kind, with blank lines between them.
pub(super) fn tables(shown: &[ObjectStatus]) -> String {
    let mut tables = Vec::new();
    for kind in Kind::ALL {
        let rows = shown.iter().filter(|shown| shown.kind == kind);
        let rows: Vec<Vec<String>> = rows.map(ObjectStatus::row_with_mover).collect();
        if !rows.is_empty() {
            tables.push(table(kind.header(), &rows));
        }
    }
    tables.join("\n\n")
}

/// The objects whose status a command shows, found once.
#[derive(Debug)]
pub(super) struct StatusQuery {
    objects: Vec<(Tag, Kind)>,
    /// Every coordinate system, in the order of the feed overrides.
    systems: Vec<String>,
    /// The number of axes of each of its coordinate systems.
    axes: BTreeMap<String, usize>,
    /// Instances of the axes and coordinate systems: they count from 1 in the order of their tags.
    instances: BTreeMap<String, u32>,
}

impl StatusQuery {
    /// The objects of these names, case ignored; without names all objects.
    pub(super) async fn find(client: &Client, names: &[String]) -> Result<Self, Failure> {
        let tags = client.browse().await?;
        for name in names {
            match tags.iter().find(|tag| tag.name.eq_ignore_ascii_case(name)) {
                Some(tag) if kind(tag).is_some() => {}
                Some(tag) => {
                    return Err(Failure::WrongType {
                        name: tag.name.clone(),
                        type_name: tag.type_name(),
                        expected: "an axis, a coordinate system or the motion group; `arcline read` shows any tag",
                    });
                }
                None => {
                    let shown = tags.iter().filter(|tag| kind(tag).is_some());
                    return Err(ClientError::unknown_tag(name, shown.map(|tag| &tag.name)).into());
                }
            }
        }
        let all: Vec<(Tag, Kind)> = tags
            .into_iter()
            .filter_map(|tag| kind(&tag).map(|kind| (tag, kind)))
            .collect();
        let asked = |tag: &Tag| names.is_empty() || names.iter().any(|name| name.eq_ignore_ascii_case(&tag.name));
        let systems = all.iter().filter(|(_, kind)| *kind == Kind::System);
        let systems: Vec<String> = systems.map(|(tag, _)| tag.name.clone()).collect();
        let mut instances = BTreeMap::new();
        for of in [Kind::Axis, Kind::System] {
            let names = all.iter().filter(|(_, kind)| *kind == of);
            instances.extend(names.map(|(tag, _)| tag.name.clone()).zip(1..));
        }
        let objects: Vec<(Tag, Kind)> = all.into_iter().filter(|(tag, _)| asked(tag)).collect();
        let mut axes = BTreeMap::new();
        for (name, instance) in systems.iter().zip(1..) {
            if objects.iter().any(|(tag, _)| tag.name == *name) {
                match client.axis_count(instance).await {
                    Err(error) if error.is_connection() => return Err(error.into()),
                    count => axes.insert(name.clone(), count.unwrap_or(PRIMARY_AXES)),
                };
            }
        }
        Ok(Self {
            objects,
            systems,
            axes,
            instances,
        })
    }

    /// Reads their status, as far as possible at the same instant.
    pub(super) async fn read(&self, client: &Client) -> Result<Vec<ObjectStatus>, Failure> {
        let paths: Vec<&str> = self.objects.iter().map(|(tag, _)| tag.name.as_str()).collect();
        let (overrides, rests) = if self.objects.iter().any(|(_, kind)| *kind == Kind::System) {
            (self.overrides(client).await?, Rests::read(client).await?)
        } else {
            (BTreeMap::new(), Vec::new())
        };
        let mut shown = Vec::new();
        for ((tag, kind), reading) in self.objects.iter().zip(client.read_many(&paths).await?) {
            let reading = reading?;
            shown.push(match kind {
                Kind::Axis => {
                    let kinds = self.kinds_of_faults(client, tag, &reading).await?;
                    let mover = self.mover(client, tag, Object::Axis).await?;
                    axis(tag, &reading, kinds).moved_by(mover.as_ref())
                }
                Kind::System => {
                    let axes = self.axes.get(&tag.name).copied().unwrap_or(PRIMARY_AXES);
                    let progress = match self.instances.get(&tag.name) {
                        Some(instance) => client.progress(*instance).await?,
                        None => None,
                    };
                    let mover = self.mover(client, tag, Object::CoordinateSystem).await?;
                    let percent = overrides.get(&tag.name).copied();
                    let place = self.systems.iter().position(|name| *name == tag.name);
                    let status = system(tag, &reading, axes, percent, progress);
                    let status = status.rested(place.and_then(|place| rests.get(place)));
                    status.moved_by(mover.as_ref())
                }
                Kind::Group => group(tag, &reading, self.is_inhibited(client).await?),
                Kind::RealTime => real_time(tag, &reading),
            });
        }
        Ok(shown)
    }

    /// The mover of an axis or coordinate system.
    async fn mover(&self, client: &Client, tag: &Tag, object: Object) -> Result<Option<Mover>, Failure> {
        match self.instances.get(&tag.name) {
            Some(instance) => Ok(client.mover(object, *instance).await?),
            None => Ok(None),
        }
    }

    /// The words of an axis's faults; none where it has none, or the server does not show their kinds.
    async fn kinds_of_faults(
        &self,
        client: &Client,
        tag: &Tag,
        reading: &TagValue,
    ) -> Result<Vec<&'static str>, Failure> {
        let shown = shown_faults(reading);
        let faults = match self.instances.get(&tag.name) {
            // The tag of a virtual axis has no words for them.
            Some(instance) if shown == FaultSet::default() && !words(reading, AXIS_FAULTS).is_empty() => {
                client.faults_of(*instance).await?
            }
            _ => shown,
        };
        Ok(Ending::words(faults))
    }

    /// The feed override of every coordinate system, percent; none where the server has no such tag.
    async fn overrides(&self, client: &Client) -> Result<BTreeMap<String, f64>, Failure> {
        let values = match client.read(FEED_OVERRIDE).await {
            Ok(reading) => reading.numbers().unwrap_or_default(),
            Err(error) if error.is_connection() => return Err(error.into()),
            Err(_) => Vec::new(),
        };
        Ok(self.systems.iter().cloned().zip(values).collect())
    }

    /// Whether STOP inhibits motion; always false on a server without STOP.
    pub(super) async fn is_inhibited(&self, client: &Client) -> Result<bool, Failure> {
        match client.is_motion_inhibited().await {
            Err(error) if error.is_connection() => Err(error.into()),
            inhibited => Ok(inhibited.unwrap_or(false)),
        }
    }

    /// The names of the axes or coordinate systems among them.
    pub(super) fn of(&self, wanted: Kind) -> impl Iterator<Item = &str> {
        let of_kind = self.objects.iter().filter(move |(_, kind)| *kind == wanted);
        of_kind.map(|(tag, _)| tag.name.as_str())
    }
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
pub(super) fn words(reading: &TagValue, members: &[(&str, &str)]) -> String {
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

const AXIS_STATUS: &[(&str, &str)] = &[("ShutdownStatus", "shutdown"), ("InhibitStatus", "inhibited")];

/// Bits of MotionStatus for the cause of motion, and their words.
const AXIS_MOTION: &[(&str, &str)] = &[
    ("CoordinatedMotionStatus", "coordinated"),
    ("ControlledByTransformStatus", "transformed"),
    ("MoveStatus", "moving"),
    ("JogStatus", "jogging"),
    ("GearingStatus", "geared"),
    ("PositionCamStatus", "camming"),
    ("TimeCamStatus", "time-camming"),
    ("MasterOffsetMoveStatus", "offset-moving"),
    ("HomingStatus", "homing"),
    ("DirectVelocityControlStatus", "velocity-controlled"),
    ("DirectTorqueControlStatus", "torque-controlled"),
    ("StoppingStatus", "stopping"),
    ("MaximumSpeedExceeded", "too-fast"),
];

/// Bits of MotionStatus that are no cause of motion: phases, locks, waits, the state of the axis.
#[cfg(test)]
const NO_MOTION: &[&str] = &[
    "AccelStatus",
    "DecelStatus",
    "AxisHomedStatus",
    "PositionCamPendingStatus",
    "TimeCamPendingStatus",
    "GearingLockStatus",
    "PositionCamLockStatus",
    "TimeCamLockStatus",
    "TransformStateStatus",
    "MoveLockStatus",
    "JogLockStatus",
    "MasterOffsetMoveLockStatus",
];

fn axis(tag: &Tag, reading: &TagValue, kinds: Vec<&str>) -> ObjectStatus {
    let (position, command) = (reading.number("ActualPosition"), reading.number("CommandPosition"));
    let velocity = reading.number("CommandVelocity");
    let (servo, homed) = (reading.flag("ServoActionStatus"), reading.flag("AxisHomedStatus"));
    let faults = words(reading, AXIS_FAULTS);
    let motion = format!("{} {}", words(reading, AXIS_STATUS), words(reading, AXIS_MOTION));
    // An axis that moves for a reason without a word is not at rest.
    let otherwise = if velocity == 0.0 { "at rest" } else { "moving" };
    let told = if kinds.is_empty() {
        faults.clone()
    } else {
        format!("fault: {}", kinds.join(", "))
    };
    let state = [motion.trim(), told.as_str()].join(" ");
    let state = or(state.trim().to_owned(), otherwise);
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
        "faults": faults.split_whitespace().collect::<Vec<_>>(), "fault_kinds": kinds,
    });
    ObjectStatus {
        kind: Kind::Axis,
        name: tag.name.clone(),
        row,
        object,
        mover: None,
        position: vec![position],
    }
}

fn system(
    tag: &Tag,
    reading: &TagValue,
    axes: usize,
    percent: Option<f64>,
    progress: Option<Progress>,
) -> ObjectStatus {
    let mut position = reading
        .member("ActualPosition")
        .and_then(TagValue::numbers)
        .unwrap_or_default();
    // The others are unused and 0.
    position.truncate(axes);
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
    let shown: Vec<String> = position.iter().map(|axis| fixed(*axis)).collect();
    let object = json!({
        "kind": "coordinate system", "name": tag.name, "position": position, "ready": reading.flag("ReadyStatus"),
        "state": state, "faults": faults.split_whitespace().collect::<Vec<_>>(), "override": percent,
        "active_move": progress.map(|progress| json!({
            "share": progress.share(), "remaining": progress.remaining, "length": progress.length,
            "time_left_s": progress.time_left,
        })),
    });
    ObjectStatus {
        kind: Kind::System,
        name: tag.name.clone(),
        row: vec![tag.name.clone(), shown.join(", "), told(progress), state],
        object,
        mover: None,
        position,
    }
}

/// `40 %, 60.0 to go, 0.62 s left`.
fn told(progress: Option<Progress>) -> String {
    let Some(progress) = progress else {
        return "none".to_owned();
    };
    let share = (100.0 * progress.share()).floor();
    let mut text = format!("{share:.0} %, {:.1} to go", progress.remaining);
    if let Some(time) = progress.time_left {
        text.push_str(&format!(", {time:.2} s left"));
    }
    text
}

fn group(tag: &Tag, reading: &TagValue, inhibited: bool) -> ObjectStatus {
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
        "kind": "motion group", "name": tag.name, "synced": synced, "motion_inhibited": inhibited,
        "faults": faults.split_whitespace().collect::<Vec<_>>(),
    });
    let row = vec![
        tag.name.clone(),
        yes_no(synced, "yes", "no"),
        yes_no(inhibited, "inhibited by STOP", "permitted"),
        or(faults, "none"),
    ];
    ObjectStatus {
        kind: Kind::Group,
        name: tag.name.clone(),
        row,
        object,
        mover: None,
        position: Vec::new(),
    }
}

fn real_time(tag: &Tag, reading: &TagValue) -> ObjectStatus {
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
    ObjectStatus {
        kind: Kind::RealTime,
        name: tag.name.clone(),
        row,
        object,
        mover: None,
        position: Vec::new(),
    }
}

/// Three decimals; a 0 has no sign.
fn fixed(number: f64) -> String {
    let text = format!("{number:.3}");
    if text == "-0.000" { "0.000".to_owned() } else { text }
}

fn yes_no(truth: bool, yes: &str, no: &str) -> String {
    if truth { yes } else { no }.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_instruction_set::predefined;

    #[test]
    fn every_bit_of_motion_status_has_a_word_or_is_no_reason_to_move() {
        for template in [predefined::axis_cip_drive(), predefined::axis_virtual()] {
            let word = template.member("MotionStatus").expect("an axis has it").offset;
            let bits = template
                .members
                .iter()
                .filter(|member| member.bit.is_some() && (word..word + 4).contains(&member.offset));
            let mut count = 0;
            for bit in bits {
                count += 1;
                let name = bit.name.as_str();
                let worded = AXIS_MOTION.iter().any(|(member, _)| *member == name);
                assert!(worded != NO_MOTION.contains(&name), "{name} of {}", template.name);
            }
            assert!(count >= 20, "{count} bits of {}", template.name);
        }
    }
}
