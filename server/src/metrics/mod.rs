//! The measurements of a running server as Prometheus reads them (text format 0.0.4), made when they are asked for: GET /metrics of the page.
//!
//! Base units, closed lists of labels: the series are bounded by the machine. The tick takes no part in it.

mod text;

use std::time::Duration;

use arcline_controller::image::MeasuredTime;
use arcline_instruction_set::SystemId;
use arcline_instruction_set::predefined::{axis_status, histogram_edge};

use self::text::Text;
use crate::plant::{Counter, Plant, RequestKind};

/// The content type of the text.
pub(crate) const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// All metrics at this moment.
pub(crate) fn metrics(plant: &Plant) -> String {
    let mut text = Text::default();
    of_thread(&mut text, plant);
    of_machine(&mut text, plant);
    let commands = Counter::ALL.map(|counter| (counter.name(), plant.count(counter)));
    text.family(
        "arcline_commands_total",
        "counter",
        "Commands of all clients since the start, by kind and outcome.",
    );
    for (kind, count) in &commands {
        text.value(&[("kind", kind), ("outcome", "done")], count.done as f64);
        text.value(&[("kind", kind), ("outcome", "refused")], count.refused as f64);
    }
    text.family(
        "arcline_requests_total",
        "counter",
        "Requests of all EtherNet/IP clients since the start, by kind and outcome; those of a packet of requests one by one.",
    );
    for kind in RequestKind::ALL {
        let count = plant.requests(kind);
        text.value(&[("kind", kind.name()), ("outcome", "done")], count.done as f64);
        text.value(&[("kind", kind.name()), ("outcome", "refused")], count.refused as f64);
    }
    text.family(
        "arcline_sessions",
        "gauge",
        "Clients with a session, and viewers of the page.",
    );
    for (interface, count) in ["ethernet_ip", "page"].into_iter().zip(plant.guard().count()) {
        text.value(&[("door", interface)], count as f64);
    }
    if let Some(lost) = plant.audit_lost() {
        text.single(
            "arcline_audit_lost_total",
            "counter",
            "Events that are in no line of the audit: there was no room, or the disk failed.",
            lost as f64,
        );
    }
    if let Some(line) = plant.audit_line() {
        text.single(
            "arcline_audit_line",
            "gauge",
            "The number of the newest line of the audit whose hash the log has; it grows once a minute.",
            line as f64,
        );
    }
    if let Some(ends) = plant.certificate_end() {
        text.single(
            "arcline_certificate_expires_timestamp_seconds",
            "gauge",
            "When the certificate of the server ends, Unix time.",
            ends as f64,
        );
    }
    text.family("arcline_build_info", "gauge", "The version, 1.");
    text.value(&[("version", env!("CARGO_PKG_VERSION"))], 1.0);
    of_process(&mut text);
    text.finish()
}

fn of_thread(text: &mut Text, plant: &Plant) {
    let health = plant.health();
    text.single(
        "arcline_tick_period_seconds",
        "gauge",
        "The coarse update period.",
        plant.machine().period(),
    );
    #[rustfmt::skip]
    let counters = [
        ("arcline_ticks_total",               "Ticks since the start.",                                          health.ticks),
        ("arcline_tick_overruns_total",       "Ticks that ended after the next one was due.",                    health.overruns),
        ("arcline_ticks_caught_up_total",     "Ticks that were executed late, one after another.",               health.caught_up),
        ("arcline_tick_resynchronised_total", "Times the thread was too late to catch up.",                      health.resynchronised),
    ];
    for (name, help, value) in counters {
        text.single(name, "counter", help, value as f64);
    }
    text.family(
        "arcline_realtime_lost_total",
        "counter",
        "What found no room on its way out of the tick.",
    );
    for (what, lost) in [
        ("events", health.lost_events),
        ("answers", health.lost_answers),
        ("samples", health.lost_samples),
    ] {
        text.value(&[("what", what)], lost as f64);
    }
    histogram(
        text,
        "arcline_tick_lateness_seconds",
        "The begin of ticks after their due times.",
        &health.lateness,
    );
    histogram(
        text,
        "arcline_tick_compute_seconds",
        "The execution of ticks.",
        &health.compute,
    );
    let yes = |on: bool| if on { "true" } else { "false" };
    let core = health.core.map_or_else(|| "none".to_owned(), |core| core.to_string());
    text.family(
        "arcline_realtime_info",
        "gauge",
        "What the system granted the thread of the tick, 1.",
    );
    let labels = [
        ("fifo", yes(health.fifo)),
        ("memory_locked", yes(health.memory_locked)),
        ("core", core.as_str()),
    ];
    text.value(&labels, 1.0);
}

/// A histogram of REAL_TIME.
fn histogram(text: &mut Text, name: &str, help: &str, measured: &MeasuredTime) {
    text.family(name, "histogram", help);
    let mut below = 0;
    for (bucket, count) in measured.histogram.iter().enumerate() {
        below += count;
        let edge = histogram_edge(bucket).map_or_else(|| "+Inf".to_owned(), |edge| edge.to_string());
        text.part("_bucket", &[("le", &edge)], below as f64);
    }
    // The counters of a running thread may be those of two neighbouring ticks.
    text.part("_sum", &[], measured.mean * below as f64 / 1e6);
    text.part("_count", &[], below as f64);
}

fn of_machine(text: &mut Text, plant: &Plant) {
    let machine = plant.machine();
    let (snapshot, moves) = plant.view(|view| {
        let moves = (0..machine.systems.len()).map(|system| view.moves.of(system).count());
        (view.snapshot.clone(), moves.collect::<Vec<_>>())
    });
    let axes = || machine.axes.iter().map(|axis| axis.name.as_str()).zip(&snapshot.axes);
    text.family("arcline_axis_fault", "gauge", "Whether the axis has a fault.");
    for (name, axis) in axes() {
        text.value(&[("axis", name)], f64::from(u8::from(!axis.faults.is_empty())));
    }
    text.family("arcline_axis_enabled", "gauge", "Whether the servo of the axis is on.");
    for (name, axis) in axes() {
        let on = axis.status & axis_status::SERVO_ACTION_STATUS != 0;
        text.value(&[("axis", name)], f64::from(u8::from(on)));
    }
    text.family(
        "arcline_axis_following_error",
        "gauge",
        "Command position minus actual position, position units.",
    );
    for (name, axis) in axes() {
        text.value(&[("axis", name)], axis.position_error);
    }
    text.family(
        "arcline_axis_refused_commands_total",
        "counter",
        "Set-points beyond the command limits, which did not go out.",
    );
    for (name, axis) in axes() {
        text.value(&[("axis", name)], f64::from(axis.refused_commands));
    }
    let systems = || {
        machine
            .systems
            .iter()
            .map(|system| system.name.as_str())
            .zip(&snapshot.systems)
    };
    text.family(
        "arcline_queue_room",
        "gauge",
        "Moves that the coordinate system can still take.",
    );
    for (name, system) in systems() {
        text.value(&[("coordinate_system", name)], f64::from(system.queue_room));
    }
    text.family(
        "arcline_moves",
        "gauge",
        "Moves of the coordinate system under way and waiting.",
    );
    for ((name, _), moves) in systems().zip(moves) {
        text.value(&[("coordinate_system", name)], moves as f64);
    }
    text.family(
        "arcline_feed_override_ratio",
        "gauge",
        "The feed override of the coordinate system; 1 is as programmed, 0 holds.",
    );
    for (system, percent) in plant.with_image(|image| image.feed_overrides().enumerate().collect::<Vec<_>>()) {
        if let Some(system) = machine.systems.get(usize::from(SystemId::from_index(system))) {
            text.value(&[("coordinate_system", &system.name)], f64::from(percent) / 100.0);
        }
    }
    text.family(
        "arcline_contour_rests_total",
        "counter",
        "Rests of planned contours between moves that go on, by cause.",
    );
    for (name, system) in systems() {
        let rests = system.contour_rests;
        for (cause, count) in [("starved", rests.starved), ("unplanned", rests.unplanned)] {
            text.value(&[("coordinate_system", name), ("cause", cause)], f64::from(count));
        }
    }
    text.single(
        "arcline_motion_inhibited",
        "gauge",
        "Whether STOP inhibits motion.",
        f64::from(u8::from(plant.is_inhibited())),
    );
}

/// The measurements of the process that the system offers.
fn of_process(text: &mut Text) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let resident = status.lines().find_map(|line| {
        line.strip_prefix("VmRSS:")?
            .trim()
            .strip_suffix(" kB")?
            .parse::<f64>()
            .ok()
    });
    if let Some(resident) = resident {
        text.single(
            "process_resident_memory_bytes",
            "gauge",
            "Resident memory.",
            resident * 1024.0,
        );
    }
    if let Ok(open) = std::fs::read_dir("/proc/self/fd") {
        text.single(
            "process_open_fds",
            "gauge",
            "Open file descriptors.",
            open.count() as f64,
        );
    }
    let cpu = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    let cpu = Duration::try_from(cpu).map_or(0.0, |cpu| cpu.as_secs_f64());
    text.single(
        "process_cpu_seconds_total",
        "counter",
        "Processor time of all threads.",
        cpu,
    );
}
