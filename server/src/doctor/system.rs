//! The settings of the system that `/proc` and `/sys` show.

use std::fs;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use rustix::process::{Resource, getrlimit};

use super::{Finding, Grade};
use crate::run::SPARE_DESCRIPTORS;

/// A system, by the root of its files.
#[derive(Debug)]
pub(super) struct System {
    root: PathBuf,
}

impl System {
    pub(super) fn of_this_computer() -> Self {
        Self::at("/")
    }

    pub(super) fn at(root: impl Into<PathBuf>) -> Self {
        System { root: root.into() }
    }

    /// The text of a file, where there is one.
    fn read(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.trim().to_owned())
    }

    pub(super) fn processors(&self) -> Finding {
        let count = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let isolated = self.read("sys/devices/system/cpu/isolated").unwrap_or_default();
        let isolated = if isolated.is_empty() {
            String::new()
        } else {
            format!(", isolated: {isolated}")
        };
        if count > 1 {
            return Finding::ok("processors", format!("{count}{isolated}"));
        }
        let remedy =
            "The ticks share the only processor with the network: give the computer or the container a second one.";
        Finding::new("processors", Grade::Warning, "1", remedy)
    }

    pub(super) fn kernel(&self) -> Finding {
        let release = self
            .read("proc/sys/kernel/osrelease")
            .unwrap_or_else(|| "unknown".to_owned());
        if self.read("sys/kernel/realtime").as_deref() == Some("1") {
            return Finding::ok("kernel", format!("{release}, PREEMPT_RT"));
        }
        // Most tests need none, and the measurement shows the effect.
        Finding::ok("kernel", format!("{release}, without PREEMPT_RT"))
    }

    /// The share of each second that the system allows real-time threads.
    pub(super) fn real_time_share(&self) -> Finding {
        let number = |name: &str| -> Option<i64> { self.read(&format!("proc/sys/kernel/{name}"))?.parse().ok() };
        let (runtime, period) = (number("sched_rt_runtime_us"), number("sched_rt_period_us"));
        match (runtime, period) {
            (Some(runtime), Some(period)) if (0..period / 2).contains(&runtime) => Finding::new(
                "real-time share",
                Grade::Warning,
                format!("{runtime} of {period} us"),
                "Real-time threads have less than half of the time: sysctl kernel.sched_rt_runtime_us=950000.",
            ),
            (Some(-1), _) => Finding::ok("real-time share", "all of the time"),
            (Some(runtime), Some(period)) => Finding::ok("real-time share", format!("{runtime} of {period} us")),
            _ => Finding::ok("real-time share", "not told by this system"),
        }
    }

    pub(super) fn clock_source(&self) -> Finding {
        let folder = "sys/devices/system/clocksource/clocksource0";
        let Some(source) = self.read(&format!("{folder}/current_clocksource")) else {
            return Finding::ok("clock source", "not told by this system");
        };
        let slow = ["hpet", "acpi_pm", "jiffies", "refined-jiffies", "pit"];
        if !slow.contains(&source.as_str()) {
            return Finding::ok("clock source", source);
        }
        let others = self
            .read(&format!("{folder}/available_clocksource"))
            .unwrap_or_default();
        let remedy = format!(
            "Reading this clock takes long. There are: {others}. Where tsc is one: echo tsc > /{folder}/current_clocksource, or clocksource=tsc on the \
             kernel's command line."
        );
        Finding::new("clock source", Grade::Warning, source, remedy)
    }

    pub(super) fn governor(&self) -> Finding {
        let mut governors = Vec::new();
        for processor in 0..1024 {
            let path = format!("sys/devices/system/cpu/cpu{processor}/cpufreq/scaling_governor");
            governors.extend(self.read(&path));
        }
        governors.sort_unstable();
        governors.dedup();
        let found = governors.join(", ");
        if governors.is_empty() {
            return Finding::ok("processor clock", "not changed by this system");
        }
        if governors == ["performance"] {
            return Finding::ok("processor clock", found);
        }
        let remedy = "A processor that slows down wakes late: cpupower frequency-set -g performance.";
        Finding::new("processor clock", Grade::Warning, format!("governor {found}"), remedy)
    }

    pub(super) fn swap(&self) -> Finding {
        let swaps = self.read("proc/swaps").unwrap_or_default();
        let count = swaps.lines().skip(1).count();
        if count == 0 {
            return Finding::ok("swap", "none");
        }
        // Locked memory is not swapped; that it is locked has a check of its own.
        Finding::ok("swap", format!("{count} in use; locked memory stays"))
    }
}

/// The limit of open files, for this number of clients.
pub(super) fn descriptors(clients: usize) -> Finding {
    let wanted = u64::try_from(clients)
        .unwrap_or(u64::MAX)
        .saturating_add(SPARE_DESCRIPTORS);
    match getrlimit(Resource::Nofile).maximum {
        Some(most) if most < wanted => Finding::new(
            "open files",
            Grade::Warning,
            format!("{most} at most, {wanted} wanted for max_clients = {clients}"),
            "LimitNOFILE= in the unit, --ulimit nofile= of a container, or a smaller max_clients: newcomers close silent clients earlier.",
        ),
        Some(most) => Finding::ok("open files", format!("{most} at most, {wanted} wanted")),
        None => Finding::ok("open files", "no limit"),
    }
}
