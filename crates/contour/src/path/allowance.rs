//! The permitted deviation of the curve from the reference path, by arc length: all of the tolerance at corners and on the chords of a curve, a
//! hundredth of it on other long pieces between the roundings of their corners ([`Deviation::Corners`], spec/motion-core.md §6.4).
//! Lengths in position units.

use crate::limits::Smoothness;
use crate::path::reach::{MOST_REACH_TOLERANCES, most_reach};
use crate::path::reference::{ReferencePath, along, nearest};
use crate::solve::stages::Quality;
use crate::timing::grid::Spacing;
use crate::tolerance::{BESIDE_SHARE, COLLINEAR_RAD};
use crate::tuning::TUNING;
use crate::{Deviation, Point};
use arcline_geometry::Path;

/// The start of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SectionStart {
    /// At rest.
    Rest,
    /// On a running motion: the corner at its start is rounded in any case.
    Running,
}

/// The permitted deviation of the curve from each piece of a reference path.
#[derive(Clone, Debug)]
pub(crate) struct Allowance {
    /// The tolerances of the corners at the ends of the pieces.
    tolerances: Vec<f64>,
    /// The length of the rounding of that corner along the pieces on both sides of it.
    reaches: Vec<f64>,
    /// The curve may use all of the tolerance on the whole piece.
    anywhere: Vec<bool>,
    start: SectionStart,
    /// The plan for which it is.
    quality: Quality,
    spacing: Spacing,
}

impl Allowance {
    /// `tolerances` and `deviations` belong to the pieces of the reference path; a tolerance to the corner at the end of its piece.
    pub(crate) fn new(
        reference: &ReferencePath,
        tolerances: Vec<f64>,
        deviations: impl Iterator<Item = Deviation>,
        smoothness: Smoothness,
        start: SectionStart,
        quality: Quality,
    ) -> Allowance {
        let reaches = reference.pieces.windows(2).zip(&tolerances);
        let mut reaches: Vec<f64> = reaches
            .map(|(pair, &tolerance)| most_reach(&pair[0], &pair[1], tolerance, smoothness))
            .collect();
        reaches.push(0.0);
        let turns: Vec<f64> = (0..reference.pieces.len())
            .map(|piece| turn(reference, piece))
            .collect();
        let chords = chords(reference, &tolerances, &turns);
        let anywhere = deviations
            .zip(chords)
            .map(|(deviation, chord)| chord || deviation == Deviation::Anywhere);
        Allowance {
            anywhere: anywhere.collect(),
            spacing: spacing(reference, &tolerances, &turns, quality),
            tolerances,
            reaches,
            start,
            quality,
        }
    }

    /// The distance of two nodes where the motion changes much.
    pub(crate) fn spacing(&self) -> Spacing {
        self.spacing
    }

    /// The least tolerance of all corners.
    pub(crate) fn least(&self) -> f64 {
        self.tolerances.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The tolerance of the corner at the end of a piece.
    pub(crate) fn corner(&self, piece: usize) -> f64 {
        self.tolerances[piece]
    }

    /// The tolerance at an arc length: that of the nearer corner; a single piece has none.
    pub(crate) fn tolerance(&self, reference: &ReferencePath, piece: usize, s: f64) -> f64 {
        let middle = 0.5 * (reference.starts[piece] + reference.starts[piece + 1]);
        let (first, last) = (piece == 0, piece + 1 == reference.pieces.len());
        if first && last {
            0.0
        } else if first || (!last && s >= middle) {
            self.tolerances[piece]
        } else {
            self.tolerances[piece - 1]
        }
    }

    /// The permitted deviation of the curve from a piece at an arc length.
    pub(crate) fn at(&self, reference: &ReferencePath, piece: usize, s: f64) -> f64 {
        self.within(reference, piece, s, [STRAIGHT_SHARE, 1.0])
    }

    /// The deviation that the optimisation permits: beside corners somewhat less, as it does not examine the curve between the nodes.
    pub(crate) fn aim(&self, reference: &ReferencePath, piece: usize, s: f64) -> f64 {
        self.within(
            reference,
            piece,
            s,
            [TUNING.corridor.aim_straight_share, TUNING.corridor.aim_reach_share],
        )
    }

    /// With a share of the tolerance for the straight part, and one of the length of a rounding.
    fn within(&self, reference: &ReferencePath, piece: usize, s: f64, [straight, share]: [f64; 2]) -> f64 {
        let tolerance = self.tolerance(reference, piece, s);
        if !self.keeps_close(reference, piece, tolerance) {
            return tolerance;
        }
        let (from, to) = (s - reference.starts[piece], reference.starts[piece + 1] - s);
        let behind = self.reach_behind(piece, tolerance);
        let open = opened(from, share * behind).max(opened(to, share * self.reaches[piece]));
        tolerance * (straight + (1.0 - straight) * open)
    }

    /// The length of the rounding at the start of a piece along it.
    fn reach_behind(&self, piece: usize, tolerance: f64) -> f64 {
        match (piece.checked_sub(1), self.start) {
            (Some(corner), _) => self.reaches[corner],
            (None, SectionStart::Running) => MOST_REACH_TOLERANCES * tolerance,
            (None, SectionStart::Rest) => 0.0,
        }
    }

    /// The curve must keep close to a piece between the roundings of its corners, for this tolerance.
    fn keeps_close(&self, reference: &ReferencePath, piece: usize, tolerance: f64) -> bool {
        !self.anywhere[piece] && reference.pieces[piece].length() > LONG_TOLERANCES * tolerance
    }

    /// The curve must keep close to some piece.
    pub(crate) fn keeps_close_anywhere(&self) -> bool {
        self.anywhere.iter().any(|&anywhere| !anywhere)
    }

    /// The curve must keep close to a piece on this side of its middle.
    pub(crate) fn keeps_close_at(&self, reference: &ReferencePath, piece: usize, s: f64) -> bool {
        self.keeps_close(reference, piece, self.tolerance(reference, piece, s))
    }

    /// A point of a piece is near the rounding of one of its corners, or on an arc.
    pub(crate) fn is_near_rounding(&self, reference: &ReferencePath, piece: usize, s: f64) -> bool {
        let (from, to) = (s - reference.starts[piece], reference.starts[piece + 1] - s);
        let behind = piece.checked_sub(1).map_or(0.0, |corner| self.reaches[corner]);
        from < TUNING.corridor.near_reaches * behind
            || to < TUNING.corridor.near_reaches * self.reaches[piece]
            || matches!(reference.pieces[piece], Path::Arc(_))
    }

    /// The times at which the motion rounds corners beside pieces that it keeps close to, from and until, by the times of arc lengths. Nodes are
    /// closer there.
    pub(crate) fn roundings(&self, reference: &ReferencePath, time_at: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let joints = (0..reference.pieces.len()).filter(|&piece| piece + 1 < reference.pieces.len());
        joints
            .filter(|&piece| self.reaches[piece] > 0.0)
            .filter(|&piece| self.room(reference, piece).is_finite() || self.is_sharp(reference, piece))
            .map(|piece| {
                let (s, reach) = (reference.starts[piece + 1], self.reaches[piece]);
                (time_at(s - reach), time_at(s + reach))
            })
            .collect()
    }

    /// The corner at the end of a piece has nodes of its own on a smooth curve.
    fn is_sharp(&self, reference: &ReferencePath, piece: usize) -> bool {
        self.quality == Quality::Smooth && turn(reference, piece) > TUNING.smooth.sharp
    }

    /// The permitted deviation at a joint if the curve keeps close to one of its pieces; otherwise `None`.
    pub(crate) fn at_joint(&self, reference: &ReferencePath, joint: usize) -> Option<f64> {
        let tolerance = self.tolerances[joint - 1];
        let is_close =
            self.keeps_close(reference, joint - 1, tolerance) || self.keeps_close(reference, joint, tolerance);
        let s = reference.starts[joint];
        is_close.then(|| self.aim(reference, joint - 1, s).min(self.aim(reference, joint, s)))
    }

    /// Points at which the corridor stops narrowing or jumps, each with its piece, ascending: the outer ends of roundings on pieces
    /// that the curve keeps close to, and the middles of pieces between different tolerances. A curve that is inside on both sides of
    /// such a point may be outside at it.
    pub(crate) fn edges(&self, reference: &ReferencePath) -> Vec<(usize, f64)> {
        let mut edges = Vec::new();
        for piece in 0..reference.pieces.len() {
            let (from, to) = (reference.starts[piece], reference.starts[piece + 1]);
            let behind = self.reach_behind(piece, self.tolerance(reference, piece, from));
            let middle = 0.5 * (from + to);
            let beside = middle - BESIDE_SHARE * (to - from);
            if self.keeps_close_at(reference, piece, from) && behind > 0.0 {
                edges.push((piece, from + behind));
            }
            if self.tolerance(reference, piece, beside) != self.tolerance(reference, piece, middle) {
                edges.extend([(piece, beside), (piece, middle)]);
            }
            if self.keeps_close_at(reference, piece, to) && self.reaches[piece] > 0.0 {
                edges.push((piece, to - self.reaches[piece]));
            }
        }
        edges
    }

    /// Half the largest length of a curve that rounds the corner at the end of a piece.
    pub(crate) fn room(&self, reference: &ReferencePath, piece: usize) -> f64 {
        let tolerance = self.tolerances[piece];
        let is_close =
            self.keeps_close(reference, piece, tolerance) || self.keeps_close(reference, piece + 1, tolerance);
        if is_close { self.reaches[piece] } else { f64::INFINITY }
    }

    /// The length of the rounding of the corner at the end of a piece to either side: at most half a piece.
    pub(crate) fn rounding(&self, reference: &ReferencePath, piece: usize) -> [f64; 2] {
        let Some(next) = reference.pieces.get(piece + 1) else {
            return [0.0; 2];
        };
        let before = &reference.pieces[piece];
        let turn = (before.end_tangent() - next.start_tangent()).norm();
        if turn <= COLLINEAR_RAD || self.tolerances[piece] <= 0.0 {
            return [0.0; 2];
        }
        [before, next].map(|piece_| self.reaches[piece].min(0.5 * piece_.length()))
    }

    /// The distance of a curve point from the reference path as a share of the permitted deviation at its piece and arc length `s`. 0 without a
    /// permitted deviation. `near`: a piece near the point, which becomes the nearest one.
    pub(crate) fn used(&self, reference: &ReferencePath, q: &Point, (piece, s): (usize, f64), near: &mut usize) -> f64 {
        let tolerance = self.tolerance(reference, piece, s);
        let foot;
        (foot, *near) = reference.foot(q, *near);
        let off = (foot - q).norm();
        if tolerance <= 0.0 {
            return 0.0;
        }
        let near = piece.saturating_sub(TUNING.corridor.near_pieces)
            ..=(piece + TUNING.corridor.near_pieces).min(reference.pieces.len() - 1);
        if !near.clone().any(|near| self.keeps_close(reference, near, tolerance)) {
            return off / tolerance;
        }
        near.map(|near| {
            let path = &reference.pieces[near];
            let s = reference.starts[near] + along(path, q);
            (nearest(path, q) - q).norm() / self.at(reference, near, s)
        })
        .fold(f64::INFINITY, f64::min)
    }
}

/// The change of direction at the end of a piece, as the length of the change of a unit vector.
pub(crate) fn turn(reference: &ReferencePath, piece: usize) -> f64 {
    let next = reference.pieces.get(piece + 1);
    next.map_or(0.0, |next| {
        (next.start_tangent() - reference.pieces[piece].end_tangent()).norm()
    })
}

/// Nodes are farther apart on a smooth curve of chords that are far shorter than their tolerance requires. `turns`: see [`turn`], of each piece.
fn spacing(reference: &ReferencePath, tolerances: &[f64], turns: &[f64], quality: Quality) -> Spacing {
    if quality != Quality::Smooth {
        return Spacing {
            node_s: TUNING.grid.node_s,
            least_nodes: TUNING.grid.least_nodes,
        };
    }
    let lengths = reference
        .pieces
        .windows(2)
        .map(|pair| pair[0].length().min(pair[1].length()));
    // The distance of a corner from an arc through the middles of its pieces, in tolerances.
    let bend = |(piece, shorter): (usize, f64)| shorter * turns[piece] / (8.0 * tolerances[piece]);
    let is_flat = lengths.enumerate().map(bend).all(|bend| bend <= TUNING.smooth.flat);
    Spacing {
        node_s: if is_flat {
            TUNING.smooth.flat_node_s
        } else {
            TUNING.smooth.node_s
        },
        least_nodes: TUNING.smooth.least_nodes,
    }
}

/// The pieces that are chords of a curve: short lines between corners so flat that an arc with the same change of direction would be within
/// half of the tolerance, and lines among short ones with small changes of direction.
fn chords(reference: &ReferencePath, tolerances: &[f64], turns: &[f64]) -> Vec<bool> {
    let last = reference.pieces.len() - 1;
    let most = |piece: usize| turns[piece].max(piece.checked_sub(1).map_or(0.0, |before| turns[before]));
    // Length in tolerances, the lesser of those of both corners.
    let long_of = |piece: usize| {
        let before = piece.checked_sub(1).map_or(f64::INFINITY, |before| tolerances[before]);
        let behind = if piece < last { tolerances[piece] } else { f64::INFINITY };
        let is_line = matches!(reference.pieces[piece], Path::Line(_));
        let length = reference.pieces[piece].length() / before.min(behind);
        if is_line { length } else { f64::INFINITY }
    };
    let is_short = |piece: usize| long_of(piece) <= LONGEST_CHORD_TOLERANCES;
    let is_chord = |piece: usize| {
        let (most, long) = (most(piece), long_of(piece));
        let flat = long <= LONGEST_FLAT_CHORD_TOLERANCES && long * most / 8.0 <= 0.5;
        // The neighbours of the first and the last piece are unknown.
        let inner = piece > 0 && piece < last;
        let among = inner && most <= TUNING.smooth.sharp && (piece - 1..=piece + 1).all(is_short);
        most > 0.0 && (flat || among)
    };
    (0..=last).map(is_chord).collect()
}

/// 0 outside of the rounding, 1 from half of its length on.
fn opened(distance: f64, reach: f64) -> f64 {
    if distance < reach {
        (2.0 * (reach - distance) / reach).min(1.0)
    } else {
        0.0
    }
}

/// The curve keeps close to a piece longer than this number of tolerances, unless it is a chord of a curve ([`Deviation::Corners`],
/// spec/motion-core.md §6.4).
const LONG_TOLERANCES: f64 = 50.0;
/// Most tolerances of a chord's length: between flat corners, and among others with small changes of direction (spec/motion-core.md §6.4).
const LONGEST_FLAT_CHORD_TOLERANCES: f64 = 100.0;
const LONGEST_CHORD_TOLERANCES: f64 = 250.0;
/// Share of the tolerance on pieces that the curve keeps close to (spec/motion-core.md §6.4).
const STRAIGHT_SHARE: f64 = 0.01;
