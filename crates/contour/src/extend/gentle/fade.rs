//! An offset from the speed curve that fades out. Position units and seconds.

use crate::extend::gentle::speed_curve::SpeedCurve;
use crate::section::Section;
use crate::tuning::TUNING;
use crate::{AxesState, Point};
use arcline_profile::Profile;

/// An offset that fades out: the polynomial of degree 5 from its state to 0.
pub(super) struct Fade {
    pub(super) duration: f64,
    /// Coefficients by the share of the duration.
    parts: [Point; 6],
}

impl Fade {
    /// From the state of a motion to the speed curve, on which a profile runs: in the shortest time that leaves most of the limits unused and
    /// stays inside the tolerance, otherwise in the time that comes closest to both. Returns also the share of the allowed values that it needs.
    pub(super) fn new(speed_curve: &SpeedCurve<'_>, from: &AxesState, profile: &Profile) -> (Fade, f64) {
        let to = speed_curve.moving(&profile.at(0.0));
        let offset = [
            from.position - to.position,
            from.velocity - to.velocity,
            from.acceleration - to.acceleration,
        ];
        let bound = &speed_curve.section.bounds[0];
        let rate = TUNING.gentle.fade_share * bound.axes.acceleration.min().min(bound.norm_acceleration());
        let jerk = TUNING.gentle.fade_share * bound.least_jerk();
        let [mut duration, most] = TUNING.gentle.fade_s;
        let mut best: Option<(Fade, f64)> = None;
        while duration <= most {
            let fade = Fade::within(duration, offset);
            let (acceleration, most_jerk) = fade.peaks();
            let used = (acceleration / rate)
                .max(most_jerk / jerk)
                .max(fade.off(speed_curve, profile));
            let is_inside = used <= 1.0;
            if best.as_ref().is_none_or(|(_, least)| used < *least) {
                best = Some((fade, used));
            }
            if is_inside {
                break;
            }
            duration *= TUNING.gentle.fade_factor;
        }
        best.unwrap_or((Fade::within(duration, offset), f64::INFINITY))
    }

    /// The largest share of the tolerance that it uses until it has faded out.
    fn off(&self, speed_curve: &SpeedCurve<'_>, profile: &Profile) -> f64 {
        let Section {
            reference, allowance, ..
        } = speed_curve.section;
        let used = |k: u32| {
            let u = f64::from(k) / f64::from(TUNING.gentle.fade_samples);
            let along = profile.at(u * self.duration);
            let point = speed_curve.moving(&along).position + self.at(u)[0];
            let progress = along.position.min(reference.length());
            let mut piece = reference.piece_at(progress);
            allowance.used(reference, &point, (piece, progress), &mut piece)
        };
        (0..=TUNING.gentle.fade_samples).map(used).fold(0.0, f64::max)
    }

    fn within(duration: f64, [p, v, a]: [Point; 3]) -> Fade {
        let (v, a) = (v * duration, a * (duration * duration));
        Fade {
            duration,
            parts: [
                p,
                v,
                a * 0.5,
                p * -10.0 - v * 6.0 - a * 1.5,
                p * 15.0 + v * 8.0 + a * 1.5,
                p * -6.0 - v * 3.0 - a * 0.5,
            ],
        }
    }

    /// Position, velocity, acceleration and jerk at a share of the duration.
    fn at(&self, u: f64) -> [Point; 4] {
        let c = &self.parts;
        let t = self.duration;
        [
            c[0] + (c[1] + (c[2] + (c[3] + (c[4] + c[5] * u) * u) * u) * u) * u,
            (c[1] + (c[2] * 2.0 + (c[3] * 3.0 + (c[4] * 4.0 + c[5] * 5.0 * u) * u) * u) * u) / t,
            (c[2] * 2.0 + (c[3] * 6.0 + (c[4] * 12.0 + c[5] * 20.0 * u) * u) * u) / (t * t),
            (c[3] * 6.0 + (c[4] * 24.0 + c[5] * 60.0 * u) * u) / (t * t * t),
        ]
    }

    /// Largest acceleration and jerk.
    fn peaks(&self) -> (f64, f64) {
        (0..=TUNING.gentle.fade_samples).fold((0.0, 0.0), |(acceleration, jerk): (f64, f64), k| {
            let [_, _, a, j] = self.at(f64::from(k) / f64::from(TUNING.gentle.fade_samples));
            (acceleration.max(a.norm()), jerk.max(j.norm()))
        })
    }

    pub(super) fn added_to(&self, moving: &AxesState, time: f64) -> AxesState {
        if time >= self.duration {
            return *moving;
        }
        let [p, v, a, _] = self.at(time / self.duration);
        AxesState {
            position: moving.position + p,
            velocity: moving.velocity + v,
            acceleration: moving.acceleration + a,
        }
    }
}
