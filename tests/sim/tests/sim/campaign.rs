//! The file of a campaign, from which the figures of docs/RELIABILITY.md and README.md are written (`tests/tests/repository/campaign.rs`).

use std::fmt::Write as _;
use std::process::Command;

/// The numbers of a campaign without a finding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Campaign {
    pub(crate) first_seed: u64,
    pub(crate) scenarios: u64,
    /// Every 50th of them is run four times.
    pub(crate) runs: u64,
    /// Virtual seconds of all runs.
    pub(crate) simulated_s: u64,
    /// States of the list, all of them reached.
    pub(crate) states: usize,
}

impl Campaign {
    /// Writes the file, if `ARCLINE_CAMPAIGN` names one. A campaign of the same commit that goes on behind the seeds of the file is added to it.
    pub(crate) fn write(self) {
        let Some(file) = std::env::var_os("ARCLINE_CAMPAIGN") else {
            return;
        };
        let commit = git(&["rev-parse", "--short=8", "HEAD"]);
        let before = std::fs::read_to_string(&file).unwrap_or_default();
        let text = self.text(&commit, &before, processor_seconds());
        std::fs::write(file, text).expect("the file of the campaign can be written");
    }

    fn text(self, commit: &str, before: &str, processor_s: u64) -> String {
        let commit = format!("commit = \"{commit}\"");
        let is_same = before.lines().any(|line| line == commit);
        let of = |key: &str| number(before, key).filter(|_| is_same);
        let follows = of("first_seed").zip(of("scenarios"));
        let first_seed = match follows {
            Some((first, count)) if first + count == self.first_seed => first,
            _ => self.first_seed,
        };
        let sum = |key, own| own + of(key).filter(|_| first_seed != self.first_seed).unwrap_or_default();
        let mut text = String::from("# Written by tests/simulation with ARCLINE_CAMPAIGN.\n");
        let numbers = [
            ("first_seed", first_seed),
            ("scenarios", sum("scenarios", self.scenarios)),
            ("runs", sum("runs", self.runs)),
            ("simulated_s", sum("simulated_s", self.simulated_s)),
            ("processor_s", sum("processor_s", processor_s)),
            ("states", self.states as u64),
        ];
        let _ = writeln!(text, "{commit}");
        let _ = writeln!(text, "date = \"{}\"", git(&["show", "-s", "--format=%cs", "HEAD"]));
        for (name, number) in numbers {
            let _ = writeln!(text, "{name} = {number}");
        }
        text
    }
}

fn number(text: &str, key: &str) -> Option<u64> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
    line?.parse().ok()
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

/// The output of git.
pub(crate) fn git(arguments: &[&str]) -> String {
    let output = Command::new("git").args(arguments).output();
    output.map_or_else(
        |_| String::new(),
        |output| String::from_utf8_lossy(&output.stdout).trim().to_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_campaign_is_added_to_the_one_before_it() {
        let campaign = |first_seed| Campaign {
            first_seed,
            scenarios: 200,
            runs: 212,
            simulated_s: 4000,
            states: 48,
        };
        let first = campaign(0).text("abc", "", 40);
        #[rustfmt::skip]
        let cases = [
            ("it goes on",         campaign(200), "abc", [0,   400, 8000, 90]),
            ("there is a gap",     campaign(300), "abc", [300, 200, 4000, 50]),
            ("it begins anew",     campaign(0),   "abc", [0,   200, 4000, 50]),
            ("of another commit",  campaign(200), "abd", [200, 200, 4000, 50]),
        ];
        for (why, campaign, commit, expected) in cases {
            let text = campaign.text(commit, &first, 50);
            let found = ["first_seed", "scenarios", "simulated_s", "processor_s"].map(|key| number(&text, key));
            assert_eq!(found, expected.map(Some), "{why}: {text}");
        }
    }
}
