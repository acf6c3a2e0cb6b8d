//! The plan of a seed before a scenario begins: its actors, its faults and their times.

use std::collections::BTreeSet;

use arcline_controller::MAX_COMMANDS_PER_TICK;
use arcline_server::stepped::{Conditions, Room};
use arcline_state::recording::Rules;
use arcline_tests::random::Random;

use crate::actors::ACTORS;
use crate::record::Fnv;

/// A scenario: the seed, and the parts that are left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Scenario {
    pub(crate) seed: u64,
    /// ms; the last third is quiet.
    pub(crate) ticks: u64,
    /// Actors and kinds of faults that are left out.
    pub(crate) without: BTreeSet<String>,
}

/// Length of a scenario, ms.
pub(crate) const TICKS: u64 = 20_000;

/// A fault.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Fault {
    /// The tick, ms: the ticks are caught up then.
    Late(u64),
    /// The contour planner, ms.
    Planner(u64),
    /// No bytes arrive for this time, ms.
    Partition(u64),
    /// Every connection is cut.
    Reset,
    /// Each synchronisation takes this time from now on, ms.
    SlowDisk(u64),
    /// Calls of these kinds fail for this time, ms.
    Disk(Failing, u64),
    /// The process is killed and starts again after this time, ms.
    Kill(u64),
    /// The power fails; by these rules.
    Power(u64, Rules),
    /// The tags of another configuration are taken over.
    Reload,
    /// The system refuses to accept a client.
    NoSockets,
    /// All threads beside the tick stand still, ms: the rings from and to the tick fill up.
    Stall(u64),
    /// The clock on the wall is set, by ms.
    Wall(i64),
    /// The process is killed, starts after this time, ms, is killed again at this call of the disk, and starts once more.
    KillStart(u64, usize),
    /// Another server is started with the same file.
    Second,
}

/// The calls of the disk that fail.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Failing {
    Writes,
    Syncs,
    Renames,
    All,
}

/// Kinds of faults, as they can be left out, and how many a scenario has at most.
pub(crate) const FAULTS: &[(&str, u64)] = &[
    ("late ticks", 12),
    ("late planner", 4),
    ("partition", 2),
    ("resets", 3),
    ("slow disk", 3),
    ("disk errors", 3),
    ("kill", 2),
    ("power loss", 2),
    ("reload", 5),
    ("no sockets", 2),
    ("stalls", 4),
    ("wall clock", 4),
    ("kill during start", 2),
    ("second server", 2),
    // These faults last for the whole scenario.
    ("small rings", 0),
    ("counters near their end", 0),
];

impl Scenario {
    pub(crate) fn of(seed: u64) -> Self {
        Scenario {
            seed,
            ticks: TICKS,
            without: BTreeSet::new(),
        }
    }

    /// The names of the actors in it.
    pub(crate) fn actors(&self) -> Vec<&'static str> {
        let all = ACTORS.iter().map(|actor| actor.name);
        all.filter(|name| self.has(name, 75)).collect()
    }

    /// The faults in it, by their time, ms.
    pub(crate) fn faults(&self) -> Vec<(u64, Fault)> {
        let mut faults = Vec::new();
        for (kind, most) in FAULTS {
            if !self.has(kind, 50) {
                continue;
            }
            let mut random = self.random(kind);
            // Times do not depend on the length of the scenario, so that a shorter one has the first of them.
            for _ in 0..random.below(most + 1) {
                let at = 200 + random.below(TICKS * 2 / 3 - 200);
                faults.push((at, draw(kind, &mut random)));
            }
        }
        faults.retain(|(at, _)| *at < self.quiet_from());
        faults.sort_by_key(|(at, _)| *at);
        faults
    }

    /// The conditions under which its servers run.
    pub(crate) fn conditions(&self) -> Conditions {
        let mut conditions = Conditions {
            wall: crate::world::wall,
            ..Conditions::default()
        };
        if self.has("small rings", 25) {
            conditions.room = Room {
                // The plant keeps two ticks of commands free of calls.
                commands: 2 * MAX_COMMANDS_PER_TICK + 1,
                stops: 4,
                events: 1,
                samples_ns: 200_000_000,
            };
        }
        if self.has(NEAR_END, 30) {
            // The 32 bits of a counter of ticks are over within the scenario.
            conditions.first_tick = (1 << 32) - TICKS / 2;
        }
        conditions
    }

    /// Whether counters begin near their end.
    pub(crate) fn is_near_end(&self) -> bool {
        self.has(NEAR_END, 30)
    }

    /// The time from which on no fault begins, ms.
    pub(crate) fn quiet_from(&self) -> u64 {
        self.ticks * 2 / 3
    }

    /// A generator for each name, so that a scenario can leave one out without a change of the others.
    pub(crate) fn random(&self, name: &str) -> Random {
        let mut hash = Fnv::default();
        hash.add(name.as_bytes());
        hash.add(&self.seed.to_le_bytes());
        // Mixed once more: FNV leaves the last bytes in few bits.
        Random(Random(hash.0).bits())
    }

    fn has(&self, name: &str, percent: u64) -> bool {
        let drawn = self.random(&format!("whether {name}")).below(100) < percent;
        drawn && !self.without.contains(name)
    }

    /// The command that runs it alone.
    pub(crate) fn command(&self) -> String {
        let mut command = format!("ARCLINE_SEED={} ARCLINE_TICKS={}", self.seed, self.ticks);
        if !self.without.is_empty() {
            let without: Vec<&str> = self.without.iter().map(String::as_str).collect();
            command += &format!(" ARCLINE_WITHOUT='{}'", without.join(","));
        }
        let features = match std::env::var("ARCLINE_PLANTED") {
            Ok(planted) => {
                command += &format!(" ARCLINE_PLANTED='{planted}'");
                " --features planted"
            }
            Err(_) => "",
        };
        command + &format!(" cargo test -p arcline-sim{features} --test sim one -- --nocapture")
    }
}

fn draw(kind: &str, random: &mut Random) -> Fault {
    let failing = [Failing::Writes, Failing::Syncs, Failing::Renames, Failing::All];
    match kind {
        "late ticks" if random.below(20) == 0 => Fault::Late(1200),
        "late ticks" => Fault::Late(1 + random.below(50)),
        "late planner" => Fault::Planner(random.below(200)),
        "partition" => Fault::Partition(random.below(4000)),
        "resets" => Fault::Reset,
        "slow disk" => Fault::SlowDisk(random.below(4000)),
        "disk errors" => Fault::Disk(*random.one_of(&failing), random.below(2500)),
        "kill" => Fault::Kill(1 + random.below(400)),
        "power loss" => Fault::Power(1 + random.below(400), *random.one_of(&[Rules::Ordered, Rules::Weak])),
        "reload" => Fault::Reload,
        "stalls" => Fault::Stall(random.below(2000)),
        "wall clock" => Fault::Wall(random.below(7_200_000) as i64 - 3_600_000),
        "kill during start" => Fault::KillStart(1 + random.below(400), random.below(12) as usize),
        "second server" => Fault::Second,
        _ => Fault::NoSockets,
    }
}

const NEAR_END: &str = "counters near their end";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_and_each_seed_draws_a_sequence_of_its_own() {
        let mut sequences = BTreeSet::new();
        for seed in 0..100 {
            for actor in ACTORS {
                let mut random = Scenario::of(seed).random(actor.name);
                sequences.extend((0..4).map(|_| random.bits()));
            }
        }
        assert_eq!(sequences.len(), 100 * ACTORS.len() * 4, "no number twice");
    }
}
