//! Step lengths of the optimisation, node by node.

use crate::tuning::TUNING;

/// Step lengths by node that nowhere exceed the wanted ones and change slowly from node to node: a kink would cause a jerk.
pub(crate) fn smooth_lengths(wanted: &[f64], lengths: &mut [f64]) {
    let count = wanted.len();
    if wanted.iter().all(|&w| w >= 1.0) {
        lengths.fill(1.0);
        return;
    }
    // The least within reach, from blocks: a little wider than needed.
    let blocks: Vec<f64> = wanted
        .chunks(TUNING.barrier.spread_nodes)
        .map(|chunk| chunk.iter().copied().fold(f64::INFINITY, f64::min))
        .collect();
    for (i, length) in lengths.iter_mut().enumerate() {
        let block = i / TUNING.barrier.spread_nodes;
        let near = &blocks[block.saturating_sub(1)..(block + 2).min(blocks.len())];
        *length = near.iter().copied().fold(f64::INFINITY, f64::min);
    }
    // Two moving averages, together no wider than the reach.
    for _ in 0..2 {
        let half = TUNING.barrier.spread_nodes / 2;
        let mut sums = Vec::with_capacity(count + 1);
        let mut sum = 0.0;
        sums.push(0.0);
        for &length in lengths.iter() {
            sum += length;
            sums.push(sum);
        }
        for (i, length) in lengths.iter_mut().enumerate() {
            let (from, to) = (i.saturating_sub(half), (i + half + 1).min(count));
            *length = (sums[to] - sums[from]) / (to - from) as f64;
        }
    }
}
