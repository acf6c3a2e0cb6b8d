//! The times of a motion's knots: close where the motion changes much, far apart where it does not. Seconds.

use crate::tuning::TUNING;

/// The positions of the control points for an even motion along a line, on a grid of knots: the means of three neighbours.
pub(crate) fn sites(grid: &[f64]) -> impl Iterator<Item = f64> + '_ {
    (0..grid.len()).map(|i| match (i.checked_sub(1).map(|k| grid[k]), grid.get(i + 1)) {
        (Some(before), Some(behind)) => (before + grid[i] + behind) / 3.0,
        _ => grid[i],
    })
}

/// The distance of two nodes in busy stretches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spacing {
    /// Seconds between two nodes.
    pub(crate) node_s: f64,
    /// The least number of nodes of a whole motion, for which they are closer.
    pub(crate) least_nodes: f64,
}

/// The density of nodes.
pub(crate) struct Density {
    /// Stretches of time in which the motion changes much, ascending.
    pub(crate) busy: Vec<(f64, f64)>,
    /// Those of them with a number of nodes of their own, ascending.
    pub(crate) fine: Vec<(f64, f64)>,
    /// Pieces of the reference path.
    pub(crate) pieces: usize,
    /// In busy stretches.
    pub(crate) spacing: Spacing,
}

impl Density {
    /// Seconds between two nodes in busy stretches of a motion of duration `whole`.
    fn least_step(&self, whole: f64) -> f64 {
        let tuning = &TUNING.grid;
        let busy: f64 = self.busy.iter().map(|(from, to)| to - from).sum();
        let beside = tuning.quiet_s * self.busy.len().min(tuning.most_quiet) as f64;
        // An arc is busy over its whole length; a corner needs few nodes.
        let most_busy = tuning.most_nodes_alone + tuning.most_nodes_each * self.pieces as f64;
        let Spacing { node_s, least_nodes } = self.spacing;
        node_s
            .max(busy / most_busy.min(tuning.most_nodes))
            .max((busy + beside).min(whole) / tuning.most_nodes)
            .min(whole / least_nodes)
    }
}

/// Times of the nodes from 0 to `whole`: close within and near busy stretches, farther and farther apart elsewhere.
pub(crate) fn grid(whole: f64, density: &Density) -> Vec<f64> {
    let Density { busy, fine, .. } = density;
    let least = density.least_step(whole);
    let mut times = vec![0.0];
    let mut t = 0.0;
    let (mut next, mut finer) = (0, 0);
    while t < whole {
        while next < busy.len() && busy[next].1 < t {
            next += 1;
        }
        let since = if next > 0 { t - busy[next - 1].1 } else { t };
        let until = busy.get(next).map_or(whole, |stretch| stretch.0.min(whole)) - t;
        let far = since.min(until) - TUNING.grid.quiet_s;
        let mut step = least + TUNING.grid.growth * far.max(0.0);
        while finer + 1 < fine.len() && fine[finer + 1].0 < t {
            finer += 1;
        }
        for &(from, to) in fine.iter().skip(finer).take(2) {
            let off = (from - t).max(t - to).max(0.0);
            step = step.min(
                ((to - from) / TUNING.grid.rounding_nodes).clamp(TUNING.grid.finest_s.min(least), least)
                    + TUNING.grid.spread * off,
            );
        }
        t += step;
        times.push(t);
    }
    // Fitted to the whole duration, which moves every node by less than one of the last steps.
    let scale = whole / t;
    for time in &mut times {
        *time *= scale;
    }
    let last = times.len() - 1;
    times[last] = whole;
    times
}

/// Knots of a continuation after the given `knots` (at least `GIVEN + 1`, ascending) until `whole`, close in busy stretches. The last span is
/// left out: in it the motion comes to rest.
pub(crate) fn continued_grid(mut knots: Vec<f64>, whole: f64, density: &Density) -> Vec<f64> {
    let from = knots[knots.len() - 1];
    let mut busy = vec![(0.0, density.spacing.node_s)];
    let later = density.busy.iter().filter(|(_, to)| *to > from);
    busy.extend(later.map(|(begin, end)| ((begin - from).max(0.0), end - from)));
    let ahead = density.fine.iter().filter(|(_, to)| *to > from);
    let ahead = Density {
        busy,
        fine: ahead.map(|(begin, end)| (begin - from, end - from)).collect(),
        pieces: density.pieces,
        spacing: density.spacing,
    };
    let behind = grid(whole - from, &ahead).into_iter().skip(1);
    knots.extend(behind.map(|time| time + from));
    knots.pop();
    knots
}
