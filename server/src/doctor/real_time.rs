//! A test run of the real-time thread for a few seconds: the priority and memory lock that the system grants it, and the lateness of its ticks.

use std::time::Duration;

use arcline_controller::machine::Machine;
use arcline_realtime::{Options, Report};

use super::{Finding, Grade};
use crate::cli::Failure;

/// Runs the machine at rest for a number of seconds.
pub(super) fn measure(machine: &Machine, seconds: f64) -> Result<Vec<Finding>, Failure> {
    let (link, handle) =
        arcline_realtime::spawn(machine, Options::default()).map_err(|error| Failure::new(2, error.to_string()))?;
    std::thread::sleep(Duration::from_secs_f64(seconds));
    let health = link.meter.health();
    let report = handle.report().clone();
    handle.stop();
    Ok(vec![
        scheduling(&report),
        memory(&report),
        lateness(
            machine.period_ns as f64 / 1000.0,
            health.lateness.max,
            health.lateness.mean,
            health.ticks,
            health.overruns,
        ),
    ])
}

fn why(report: &Report, what: &str) -> String {
    let shortfall = report.shortfalls.iter().find(|shortfall| shortfall.what == what);
    shortfall.map_or_else(String::new, |shortfall| format!(": {}", shortfall.why))
}

pub(super) fn scheduling(report: &Report) -> Finding {
    if report.fifo {
        let core = report
            .core
            .map_or_else(String::new, |core| format!(", on processor {core}"));
        return Finding::ok("scheduling", format!("SCHED_FIFO{core}"));
    }
    let found = format!("no SCHED_FIFO{}", why(report, "SCHED_FIFO"));
    let remedy = "Under systemd LimitRTPRIO=80 in the unit (the package has it); in a shell `ulimit -r 80` after a line `USER - rtprio 80` in \
                  /etc/security/limits.conf; in a container --ulimit rtprio=80. With CONFIG_RT_GROUP_SCHED the kernel refuses it outside the root group.";
    Finding::new("scheduling", Grade::Warning, found, remedy)
}

pub(super) fn memory(report: &Report) -> Finding {
    if report.memory_locked {
        return Finding::ok("memory lock", "memory is locked");
    }
    let found = format!("memory is not locked{}", why(report, "memory lock"));
    let remedy = "Under systemd LimitMEMLOCK=infinity in the unit (the package has it); in a shell `ulimit -l unlimited` after a line `USER - memlock \
                  unlimited` in /etc/security/limits.conf; in a container --ulimit memlock=-1.";
    Finding::new("memory lock", Grade::Warning, found, remedy)
}

/// Times in us.
pub(super) fn lateness(period: f64, max: f64, mean: f64, ticks: u64, overruns: u64) -> Finding {
    let found = format!(
        "{ticks} ticks of {period} us: late by {max:.0} us at most, {mean:.0} us in the mean, {overruns} overruns"
    );
    if ticks > 0 && overruns == 0 && max < period / 2.0 {
        return Finding::ok("ticks", found);
    }
    let remedy = "A tick begins late when the system does something else: see the warnings above, stop other work on this computer, use a kernel with \
                  PREEMPT_RT, keep a processor free (isolcpus), or make coarse_update_period_ms longer.";
    Finding::new("ticks", Grade::Warning, found, remedy)
}
