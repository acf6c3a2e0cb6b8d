//! A scenario that fails: the smallest one that still does, and the command that runs it alone.

use crate::campaign::git;
use crate::plan::{FAULTS, Scenario, TICKS};
use crate::record::Record;
use crate::world;

/// Shows the commands of a failure as it was drawn and of the smallest scenario that still breaks the same invariant.
///
/// # Panics
/// Always: it is a failure.
pub(crate) fn fail(scenario: Scenario, record: &Record) -> ! {
    let drawn = scenario.command();
    let mut smallest = Smallest {
        wanted: invariant(record),
        scenario,
        lines: record.lines(),
        violations: record.violations(),
        ended: record.now(),
    };
    // tests/planted only asks whether a bug is found.
    if std::env::var_os("ARCLINE_SMALLEST").is_none_or(|wanted| wanted != "no") {
        smallest.shorten();
        smallest.leave_out();
        smallest.shorten();
    }
    panic!(
        "{}\n{}\nas drawn: {drawn}\nsmallest: {}\ncommit: {}",
        smallest.lines.join("\n"),
        smallest.violations.join("\n"),
        smallest.scenario.command(),
        git(&["rev-parse", "--short", "HEAD"])
    );
}

struct Smallest {
    /// The invariant that is broken.
    wanted: Option<String>,
    scenario: Scenario,
    lines: Vec<String>,
    violations: Vec<String>,
    /// When it was broken, ms.
    ended: u64,
}

impl Smallest {
    /// Takes the shortest of some lengths with which it still fails. Another length moves the quiet third.
    fn shorten(&mut self) {
        let (ended, ticks) = (self.ended, self.scenario.ticks);
        let lengths = [ended, ended + ended / 4, ended + ended / 2, ended * 2, ended + 5_000];
        let mut lengths = lengths.map(|length| length.min(TICKS));
        lengths.sort_unstable();
        for shorter in lengths {
            if shorter < ticks {
                let scenario = Scenario {
                    ticks: shorter,
                    ..self.scenario.clone()
                };
                if self.fails_with(scenario) {
                    return;
                }
            }
        }
    }

    /// Leaves out actors and kinds of faults, one after another, that it does not need.
    fn leave_out(&mut self) {
        let names = self.scenario.actors().into_iter();
        for name in names.chain(FAULTS.iter().map(|(name, _)| *name)) {
            let mut smaller = self.scenario.clone();
            smaller.without.insert(name.to_owned());
            self.fails_with(smaller);
        }
    }

    /// Runs a smaller scenario, and keeps it when it breaks the same invariant.
    fn fails_with(&mut self, scenario: Scenario) -> bool {
        let record = world::run(&scenario, Record::default()).record;
        let fails = record.is_violated() && invariant(&record) == self.wanted;
        if fails {
            self.scenario = scenario;
            (self.lines, self.violations) = (record.lines(), record.violations());
            self.ended = record.now();
        }
        fails
    }
}

/// The first invariant that a scenario broke.
fn invariant(record: &Record) -> Option<String> {
    let violations = record.violations();
    violations.first()?.split(':').next().map(str::to_owned)
}
