//! The faults of a scenario, and their end.

use std::sync::atomic::Ordering;

use arcline_state::recording::{Kind, Rules};

use tokio::runtime::Runtime;

use super::computer::Computer;
use super::{WALL, World};
use crate::plan::{Failing, Fault};

impl World<'_> {
    pub(super) fn strike(&mut self, fault: Fault) {
        self.common.record.note("fault", &format!("{fault:?}"));
        let now = self.now;
        match fault {
            Fault::Late(ms) => self.late_until = now + ms,
            Fault::Planner(ms) => self.planner_until = now + ms,
            Fault::Partition(ms) => {
                self.common.record.sometimes("a partition");
                let until = (now + ms).min(self.scenario.quiet_from());
                self.common.network.hold(until);
                self.common.post.hold(until);
            }
            Fault::Reset => {
                self.common.record.sometimes("connections are reset");
                self.common.network.reset();
            }
            Fault::SlowDisk(ms) => self.sync_takes = ms,
            Fault::Disk(failing, ms) => {
                let bit = match failing {
                    Failing::Writes => 1,
                    Failing::Syncs => 2,
                    Failing::Renames => 4,
                    Failing::All => 7,
                };
                self.failing.store(bit, Ordering::Relaxed);
                self.failing_until = now + ms;
            }
            Fault::Kill(ms) => self.kill(ms, None),
            Fault::Power(ms, rules) => self.kill(ms, Some(rules)),
            Fault::Reload => self.reload(),
            Fault::NoSockets => {
                if let Some(running) = &self.running {
                    self.common.record.sometimes("no sockets are left");
                    running
                        .server
                        .refuse(std::io::Error::other("too many open files, by design"));
                }
            }
            Fault::Stall(ms) => {
                self.common.record.sometimes("a stall beside the tick");
                self.stalled_until = now + ms;
                self.common.stalled_until.store(now + ms, Ordering::Relaxed);
            }
            Fault::Wall(ms) => {
                self.common.record.sometimes("the clock on the wall is set");
                WALL.set(WALL.get().saturating_add_signed(ms));
            }
            Fault::KillStart(ms, call) => {
                self.kill(ms, None);
                self.start_killed = Some((1 + ms / 2, call));
            }
            Fault::Second => self.start_second(),
        }
    }

    fn kill(&mut self, ms: u64, power: Option<Rules>) {
        let Some(running) = &self.running else {
            return;
        };
        if running.task.is_some() {
            self.common.record.sometimes("an end during a synchronisation");
        }
        if self.watch.moving {
            self.common.record.sometimes("an end during motion");
        }
        match power {
            None => {
                self.common.record.sometimes("a kill");
                // All answered writes, also those that the disk does not have.
                self.durable = u64::MAX;
            }
            Some(rules) => {
                self.common.record.sometimes("a power loss");
                self.common.network.lose_server(self.now + ms);
                self.probe();
                let draw = &mut self.draw;
                self.disk = self.disk.crashed(rules, &mut |below| draw.below(below as u64) as usize);
                self.computer = Computer::new(self.disk.clone());
                self.fail_disk();
            }
        }
        self.end_server();
        self.start_at = self.now + ms;
    }

    /// A start whose process is killed at a call of the disk: none behind it has an effect.
    pub(super) fn kill_start(&mut self, runtime: &Runtime, again: u64, call: usize) {
        self.disk.fail(Box::new(move |number, _| number >= call));
        let before = self.disk.count();
        drop(self.server(runtime));
        if self.disk.count() > before {
            self.common.record.sometimes("a kill during a start that writes");
        }
        self.common.record.sometimes("a kill during a start");
        self.common.record.note("world", "is killed while it starts");
        self.fail_disk();
        self.start_at = self.now + again;
    }

    /// Another server with the file of the one that runs: it does not start, and changes nothing.
    fn start_second(&mut self) {
        if self.running.is_none() {
            return;
        }
        let before = self.disk.count();
        let (runtime, record) = (super::runtime(), &self.common.record);
        record.sometimes("a second server");
        match self.server(&runtime) {
            Ok(_) => record.violated("W2", "a second server has started with the same file"),
            Err(_) if self.disk.count() != before => record.violated("W2", "a second server has changed the disk"),
            Err(error) => record.note("a second server", &error.to_string()),
        }
    }

    fn reload(&mut self) {
        let Some(running) = &mut self.running else { return };
        let before = running.configured;
        running.configured = 1 - before;
        let (old, new) = (
            self.projects.0[before].clone(),
            self.projects.0[running.configured].clone(),
        );
        let (plant, record) = (running.server.plant().clone(), self.common.record.clone());
        drop(running.runtime.spawn(async move {
            match plant.reload(&old, &new).await {
                Ok(()) => record.sometimes("a reload"),
                Err(error) => record.note("reload", &error.to_string()),
            }
        }));
    }

    /// Ends all faults.
    pub(super) fn calm(&mut self) {
        self.failing.store(0, Ordering::Relaxed);
        self.sync_takes = 2;
        self.late_until = self.late_until.min(self.now);
        self.planner_until = 0;
        self.stalled_until = self.stalled_until.min(self.now);
        self.common.network.hold(0);
        // A synchronisation that waits for a slow disk waits no longer.
        if let Some((due, _, _)) = self.running.as_mut().and_then(|running| running.task.as_mut()) {
            *due = self.now;
        }
    }

    /// The disk fails as the present bits say.
    pub(super) fn fail_disk(&self) {
        let failing = self.failing.clone();
        self.disk.fail(Box::new(move |_, kind| {
            let bits = failing.load(Ordering::Relaxed);
            match kind {
                Kind::Write | Kind::Create => bits & 1 != 0,
                Kind::Sync => bits & 2 != 0,
                Kind::Rename | Kind::SyncFolder => bits & 4 != 0,
            }
        }));
    }
}
