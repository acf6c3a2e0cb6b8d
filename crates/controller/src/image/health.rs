//! The health of the real-time thread, and the structure of the tag that shows it.
//!
//! Plain numbers: who measures them is `arcline-realtime`. Times are microseconds unless named.

use std::sync::{Arc, LazyLock};

use arcline_tag::{Elementary, Template, TemplateBuilder, Value};

/// Name of the tag.
pub const REAL_TIME_TAG: &str = "RealTime";

/// Classes of a histogram: one below each edge, and one for the rest.
pub const HISTOGRAM_LEN: usize = HISTOGRAM_EDGES_US.len() + 1;

/// Upper edges of the classes, µs.
pub const HISTOGRAM_EDGES_US: [u32; 15] =
    [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000];

/// What the real-time thread measured since it began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// Ticks executed.
    pub ticks: u64,
    /// Ticks that were still running when the next one was due.
    pub overruns: u64,
    /// Ticks executed late, one after another without sleeping, to catch up.
    pub caught_up: u64,
    /// Times the thread was so late that it gave up catching up and moved its time base.
    pub resynchronised: u64,
    /// Whether the latest tick overran.
    pub overlapping: bool,
    /// Wake-up after the due time.
    pub lateness: Measured,
    /// Execution of a tick.
    pub compute: Measured,
    /// Events that found no room on their way out.
    pub lost_events: u64,
    /// Answers that found no room on their way out.
    pub lost_answers: u64,
    /// Whether the thread has a real-time scheduling class.
    pub real_time_scheduling: bool,
    /// Whether memory is locked.
    pub memory_locked: bool,
    /// The core it is pinned to.
    pub core: Option<u16>,
}

/// A measured time, µs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The latest.
    pub last: f64,
    /// The largest.
    pub max: f64,
    /// Mean with a time constant of 250 ticks.
    pub average: f64,
    /// How many fell in each class of [`HISTOGRAM_EDGES_US`].
    pub histogram: [u64; HISTOGRAM_LEN],
}

/// The REAL_TIME type.
pub fn real_time_template() -> Arc<Template> {
    static TEMPLATE: LazyLock<Arc<Template>> = LazyLock::new(|| {
        let mut builder = TemplateBuilder::new("REAL_TIME", TEMPLATE_INSTANCE)
            .member("RealTimeScheduling", Elementary::Bool)
            .member("MemoryLocked", Elementary::Bool)
            .member("Pinned", Elementary::Bool)
            .member("Core", Elementary::Dint)
            .member("Ticks", Elementary::Lint)
            .member("Overruns", Elementary::Dint)
            .member("CaughtUp", Elementary::Dint)
            .member("Resynchronised", Elementary::Dint)
            .member("LostEvents", Elementary::Dint);
        for name in ["Lateness", "Compute"] {
            builder = builder
                .member(format!("{name}Last"), Elementary::Real)
                .member(format!("{name}Average"), Elementary::Real)
                .member(format!("{name}Max"), Elementary::Real)
                .array(format!("{name}Histogram"), Elementary::Dint, HISTOGRAM_LEN as u16);
        }
        builder.array("HistogramEdges", Elementary::Dint, HISTOGRAM_EDGES_US.len() as u16).build()
    });
    TEMPLATE.clone()
}

impl Health {
    /// Writes the structure.
    pub(super) fn encode(&self, bytes: &mut [u8]) {
        let template = real_time_template();
        let mut put = |name: &str, element: usize, value: Value| {
            let Some(member) = template.member(name) else { return };
            let offset = member.offset as usize;
            match (member.bit, value) {
                (Some(bit), Value::Bool(on)) => super::put_bit(&mut bytes[offset], 1 << bit, on),
                _ => {
                    let size = member.data_type.size();
                    value.write(&mut bytes[offset + element * size..]);
                }
            }
        };
        put("RealTimeScheduling", 0, Value::Bool(self.real_time_scheduling));
        put("MemoryLocked", 0, Value::Bool(self.memory_locked));
        put("Pinned", 0, Value::Bool(self.core.is_some()));
        put("Core", 0, Value::Dint(self.core.map_or(-1, i32::from)));
        put("Ticks", 0, Value::Lint(self.ticks as i64));
        put("Overruns", 0, count(self.overruns));
        put("CaughtUp", 0, count(self.caught_up));
        put("Resynchronised", 0, count(self.resynchronised));
        put("LostEvents", 0, count(self.lost_events));
        for (name, measured) in [("Lateness", &self.lateness), ("Compute", &self.compute)] {
            put(&format!("{name}Last"), 0, Value::Real(measured.last as f32));
            put(&format!("{name}Average"), 0, Value::Real(measured.average as f32));
            put(&format!("{name}Max"), 0, Value::Real(measured.max as f32));
            for (element, number) in measured.histogram.iter().enumerate() {
                put(&format!("{name}Histogram"), element, count(*number));
            }
        }
        for (element, edge) in HISTOGRAM_EDGES_US.iter().enumerate() {
            put("HistogramEdges", element, Value::Dint(*edge as i32));
        }
    }
}

/// A counter as a DINT, at most its largest.
fn count(number: u64) -> Value {
    Value::Dint(i32::try_from(number).unwrap_or(i32::MAX))
}

/// A user type, the last that there can be.
const TEMPLATE_INSTANCE: u16 = 0xEFF;
