//! Plans the benchmark paths: `paths DIR OUT [NAME]` reads `DIR/*.json`, plans both profile classes and writes a
//! trace at 1 ms of each to `OUT/NAME.PROFILE.csv`.
#![allow(clippy::disallowed_methods, reason = "an example may read the clock")]

use arcline_contour::{AxisLimits, ContourMove, Deviation, Path, Point, plan};
use arcline_geometry::{Arc, CirclePoint, Dimension, Direction};
use serde::Deserialize;
use std::error::Error;
use std::io::Write;

#[derive(Deserialize)]
struct Contour {
    name: String,
    #[serde(rename = "F")]
    speed: f64,
    tol: f64,
    limits: Bounds,
    start: [f64; 3],
    moves: Vec<Move>,
}

#[derive(Deserialize)]
struct Bounds {
    v: f64,
    a: f64,
    j: f64,
}

#[derive(Deserialize)]
struct Move {
    t: String,
    to: [f64; 3],
    c: Option<[f64; 3]>,
    n: Option<[f64; 3]>,
    ang: Option<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let directory = arguments.next().ok_or("which directory?")?;
    let out = arguments.next().ok_or("where to?")?;
    let only = arguments.next().unwrap_or_default();
    let reference: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{directory}/reference.json"))?)?;
    for name in ["adept", "arcline", "cone3d", "flower", "square100", "zigzag1000"] {
        if !name.contains(&only) {
            continue;
        }
        let contour: Contour = serde_json::from_str(&std::fs::read_to_string(format!("{directory}/{name}.json"))?)?;
        for (profile, jerk) in [("trapezoid", None), ("scurve", Some(contour.limits.j))] {
            let moves = moves(&contour, jerk)?;
            let limits = AxisLimits {
                speed: Point::repeat(contour.limits.v),
                acceleration: Point::repeat(contour.limits.a),
                jerk: jerk.map(Point::repeat),
            };
            let begun = std::time::Instant::now();
            let trajectory = plan(&moves, &limits);
            let took = begun.elapsed().as_secs_f64();
            let number = |key: &str| reference[&contour.name][profile][key].as_f64().unwrap_or(f64::NAN);
            let time = trajectory.duration();
            println!(
                "{name:12} {profile:9} {time:8.4} target {:7.3} ({:6.3}) best {:7.3} ({:6.3}) planned in {took:.3} s",
                number("target"),
                time / number("target"),
                number("best"),
                time / number("best"),
            );
            let mut file = std::io::BufWriter::new(std::fs::File::create(format!("{out}/{name}.{profile}.csv"))?);
            let ticks = (time / 0.001).ceil() as usize + 3;
            for tick in 0..ticks {
                let q = trajectory.at(tick as f64 * 0.001).position;
                writeln!(file, "{},{},{}", q.x, q.y, q.z)?;
            }
        }
    }
    Ok(())
}

fn moves(contour: &Contour, jerk: Option<f64>) -> Result<Vec<ContourMove>, Box<dyn Error>> {
    let mut moves = Vec::new();
    let mut from = Point::from(contour.start);
    for one in &contour.moves {
        let to = Point::from(one.to);
        let path = if one.t == "L" {
            Path::line(from, to)
        } else {
            let (c, n) = (Point::from(one.c.ok_or("c")?), Point::from(one.n.ok_or("n")?));
            let half = one.ang.ok_or("ang")? / 2.0;
            let r = from - c;
            let via = c + r * half.cos() + n.cross(&r) * half.sin() + n * (n.dot(&r) * (1.0 - half.cos()));
            Path::Arc(Arc::new(
                Dimension::Three,
                from,
                to,
                CirclePoint::Via(via),
                Direction::from_word(0).ok_or("direction")?,
            )?)
        };
        moves.push(ContourMove {
            path,
            speed: contour.speed,
            acceleration: 2.0 * contour.limits.a,
            deceleration: 2.0 * contour.limits.a,
            jerk: jerk.map(|j| 2.0 * j),
            tolerance: contour.tol,
            deviation: Deviation::Anywhere,
        });
        from = to;
    }
    Ok(moves)
}
