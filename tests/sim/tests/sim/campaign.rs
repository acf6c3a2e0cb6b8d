//! The file of a campaign, from which the figures of docs/RELIABILITY.md and README.md are written (`tests/tests/repository/campaign.rs`).

use std::fmt::Write as _;
use std::process::Command;

/// What a campaign that found nothing has done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Campaign {
    pub(crate) first_seed: u64,
    pub(crate) scenarios: u64,
    /// Virtual seconds of all scenarios.
    pub(crate) simulated_s: u64,
    /// States of the list, all of them reached.
    pub(crate) states: usize,
}

impl Campaign {
    /// Writes the file, if `ARCLINE_CAMPAIGN` names one.
    pub(crate) fn write(self) {
        let Some(file) = std::env::var_os("ARCLINE_CAMPAIGN") else {
            return;
        };
        let mut text = String::from("# Written by tests/simulation with ARCLINE_CAMPAIGN.\n");
        let processor_s = processor_seconds();
        let numbers = [
            ("first_seed", self.first_seed),
            ("scenarios", self.scenarios),
            ("simulated_s", self.simulated_s),
            ("processor_s", processor_s),
            ("states", self.states as u64),
        ];
        let _ = writeln!(text, "commit = \"{}\"", git(&["rev-parse", "--short=8", "HEAD"]));
        let _ = writeln!(text, "date = \"{}\"", git(&["show", "-s", "--format=%cs", "HEAD"]));
        for (name, number) in numbers {
            let _ = writeln!(text, "{name} = {number}");
        }
        std::fs::write(file, text).expect("the file of the campaign can be written");
    }
}

/// Seconds that the threads of this process have computed (proc(5): utime and stime, in ticks of 10 ms).
pub(crate) fn processor_seconds() -> u64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The second field may hold blanks; it ends with the last bracket.
    let fields = stat.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks: u64 = ticks.filter_map(|field| field.parse::<u64>().ok()).sum();
    ticks.div_ceil(100).max(1)
}

/// What git prints.
pub(crate) fn git(arguments: &[&str]) -> String {
    let output = Command::new("git").args(arguments).output();
    output.map_or_else(
        |_| String::new(),
        |output| String::from_utf8_lossy(&output.stdout).trim().to_owned(),
    )
}
