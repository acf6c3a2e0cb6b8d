//! The state of `watch` between two updates: trails, speeds, and the choices of the keys.

use std::collections::{BTreeMap, VecDeque};

use crate::cli::status::{Kind, ObjectStatus};

/// Points of a trail that are points, and speeds.
const TRAIL_POINTS: usize = 2000;
/// Points nearer than this part of the trail's extent to the last one are left out.
const NEAR: f64 = 1e-4;

/// The state of the screen.
#[derive(Debug, Default)]
pub(super) struct View {
    /// The newest look.
    pub(super) shown: Vec<ObjectStatus>,
    /// Seconds since the first look.
    pub(super) time: f64,
    /// STOP holds.
    pub(super) is_inhibited: bool,
    /// The view takes no new data.
    pub(super) paused: bool,
    /// The answer to the last key.
    pub(super) note: String,
    selected: usize,
    /// Actual positions of each coordinate system, the first two axes, position units.
    trails: BTreeMap<String, VecDeque<(f64, f64)>>,
    /// Path speed of each coordinate system, position units per second.
    speeds: BTreeMap<String, VecDeque<f64>>,
}

impl View {
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// Takes a look, `time` seconds after the first.
    pub(super) fn take(&mut self, shown: Vec<ObjectStatus>, time: f64) {
        let passed = time - self.time;
        for system in shown.iter().filter(|one| one.kind == Kind::System) {
            let before = self.shown.iter().find(|one| one.name == system.name);
            if let Some(before) = before.filter(|_| passed > 0.0) {
                let squares = before
                    .position
                    .iter()
                    .zip(&system.position)
                    .map(|(a, b)| (b - a).powi(2));
                let speeds = self.speeds.entry(system.name.clone()).or_default();
                push(speeds, squares.sum::<f64>().sqrt() / passed);
            }
            let trail = self.trails.entry(system.name.clone()).or_default();
            let point = |index: usize| system.position.get(index).copied().unwrap_or_default();
            let here = (point(0), point(1));
            if trail.back().is_none_or(|last| is_apart(trail, *last, here)) {
                push(trail, here);
            }
        }
        self.shown = shown;
        self.time = time;
    }

    /// The movers, each with the names of the objects that it moves.
    pub(super) fn movers(&self) -> Vec<(&str, String)> {
        let mut movers: Vec<(&str, String)> = Vec::new();
        for one in &self.shown {
            let Some(mover) = one.mover.as_deref() else { continue };
            match movers.iter_mut().find(|(known, _)| *known == mover) {
                Some((_, names)) => names.push_str(&format!(" {}", one.name)),
                None => movers.push((mover, one.name.clone())),
            }
        }
        movers
    }

    /// Forgets trails and speeds.
    pub(super) fn clear(&mut self) {
        self.trails.clear();
        self.speeds.clear();
    }

    pub(super) fn next_system(&mut self) {
        self.selected += 1;
    }

    /// The coordinate system whose path is drawn.
    pub(super) fn system(&self) -> Option<&ObjectStatus> {
        let systems: Vec<&ObjectStatus> = self.shown.iter().filter(|one| one.kind == Kind::System).collect();
        systems.get(self.selected.checked_rem(systems.len())?).copied()
    }

    /// Its trail.
    pub(super) fn trail(&self) -> Vec<(f64, f64)> {
        let trail = self.system().and_then(|system| self.trails.get(&system.name));
        trail.into_iter().flatten().copied().collect()
    }

    /// Its path speeds, the newest `count`.
    pub(super) fn speeds(&self, count: usize) -> Vec<f64> {
        let speeds = self.system().and_then(|system| self.speeds.get(&system.name));
        let speeds: Vec<f64> = speeds.into_iter().flatten().copied().collect();
        speeds
            .get(speeds.len().saturating_sub(count)..)
            .unwrap_or_default()
            .to_vec()
    }
}

fn push<T>(points: &mut VecDeque<T>, one: T) {
    if points.len() == TRAIL_POINTS {
        points.pop_front();
    }
    points.push_back(one);
}

fn is_apart(trail: &VecDeque<(f64, f64)>, last: (f64, f64), here: (f64, f64)) -> bool {
    let first = trail.front().copied().unwrap_or(last);
    let extent = (last.0 - first.0).hypot(last.1 - first.1).max(1.0);
    (here.0 - last.0).hypot(here.1 - last.1) > NEAR * extent
}
