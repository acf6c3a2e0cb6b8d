//! Every termination type between lines and arcs in space, tangent or not (spec/coordinated-instructions.md §7, spec/motion-core.md §6).

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};

type Vector = [f64; 3];

fn along(from: Vector, direction: Vector, by: f64) -> Vector {
    std::array::from_fn(|k| from[k] + by * direction[k])
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn apart(a: Vector, b: Vector) -> f64 {
    let between = along(a, b, -1.0);
    dot(between, between).sqrt()
}

/// A line, or half a circle of radius [`RADIUS`].
#[derive(Clone, Copy)]
enum Piece {
    Line {
        from: Vector,
        to: Vector,
    },
    /// An arc from `from` in the direction `begins`, about a centre on the side `inner`.
    Arc {
        from: Vector,
        begins: Vector,
        inner: Vector,
    },
}

const RADIUS: f64 = 20.0;
const DYNAMICS: &str = "120, 0, 2000, 0, 1500, 0, 1, 60000, 50000, 0";
const X: Vector = [1.0, 0.0, 0.0];
const BACK: Vector = [-1.0, 0.0, 0.0];
/// Across X, aslant.
const UP: Vector = [0.0, 0.6, 0.8];
const SIDE: Vector = [0.0, -0.8, 0.6];

impl Piece {
    fn end(&self) -> Vector {
        match *self {
            Piece::Line { to, .. } => to,
            Piece::Arc { from, inner, .. } => along(from, inner, 2.0 * RADIUS),
        }
    }

    fn call(&self, tag: &str, termination: &str) -> String {
        let end = self.end();
        match *self {
            Piece::Line { .. } => format!("MCLM(CS1, {tag}, 0, {end:?}, {DYNAMICS}, {termination})"),
            Piece::Arc { from, begins, inner } => {
                let via = along(along(from, inner, RADIUS), begins, RADIUS);
                format!("MCCM(CS1, {tag}, 0, {end:?}, Via, {via:?}, 0, {DYNAMICS}, {termination})")
            }
        }
    }

    /// The distance of a point from the piece.
    fn off(&self, point: Vector) -> f64 {
        match *self {
            Piece::Line { from, to } => {
                let whole = apart(from, to);
                let direction = along([0.0; 3], along(to, from, -1.0), 1.0 / whole);
                let gone = dot(along(point, from, -1.0), direction).clamp(0.0, whole);
                apart(point, along(from, direction, gone))
            }
            Piece::Arc { from, begins, inner } => {
                let at = along(point, along(from, inner, RADIUS), -1.0);
                let (x, y) = (dot(at, begins), dot(at, inner));
                let across = apart(at, along(along([0.0; 3], begins, x), inner, y));
                (x.max(0.0).hypot(y) - RADIUS).hypot(across)
            }
        }
    }
}

/// The name, both pieces, and whether their junction has no corner.
fn pairs() -> [(&'static str, [Piece; 2], bool); 6] {
    let origin = [0.0; 3];
    let corner = along(origin, X, 50.0);
    let line = Piece::Line {
        from: origin,
        to: corner,
    };
    let first = Piece::Arc {
        from: origin,
        begins: X,
        inner: UP,
    };
    let top = first.end();
    [
        (
            "line to line",
            [
                line,
                Piece::Line {
                    from: corner,
                    to: along(corner, UP, 50.0),
                },
            ],
            false,
        ),
        (
            "line to tangent arc",
            [
                line,
                Piece::Arc {
                    from: corner,
                    begins: X,
                    inner: UP,
                },
            ],
            true,
        ),
        (
            "line to arc with a corner",
            [
                line,
                Piece::Arc {
                    from: corner,
                    begins: SIDE,
                    inner: UP,
                },
            ],
            false,
        ),
        (
            "arc to tangent arc of another plane",
            [
                first,
                Piece::Arc {
                    from: top,
                    begins: BACK,
                    inner: SIDE,
                },
            ],
            true,
        ),
        (
            "arc to arc with a corner",
            [
                first,
                Piece::Arc {
                    from: top,
                    begins: UP,
                    inner: SIDE,
                },
            ],
            false,
        ),
        (
            "arc to tangent line",
            [
                first,
                Piece::Line {
                    from: top,
                    to: along(top, BACK, 50.0),
                },
            ],
            true,
        ),
    ]
}

const AXES: [&str; 3] = ["X", "Y", "Z"];

fn point(bench: &Bench) -> Vector {
    AXES.map(|axis| bench.position(axis))
}

#[test]
fn every_type_between_lines_and_arcs() {
    // (type, tolerance of the corner: 0 follows the path, whether a tangent joint preserves the speed)
    let types = [
        ("0", 0.0, false),
        ("1", 0.0, false),
        ("2", 0.5, false),
        ("3", f64::INFINITY, false),
        ("4", 0.0, true),
        ("5", 0.0, true),
        ("6, 0, 0, 3", 3.0, false),
    ];
    for (pair, pieces, tangent) in pairs() {
        let joint = pieces[0].end();
        let mut took = Vec::new();
        for (termination, tolerance, keeps) in types {
            let why = format!("{pair}, type {termination}");
            let mut bench = Bench::new();
            assert_eq!(bench.call(&pieces[0].call("M1", termination)), OK, "{why}");
            assert_eq!(bench.call(&pieces[1].call("M2", "1")), OK, "{why}");
            let (mut off, mut missed) = (0.0_f64, f64::INFINITY);
            // The speed nearest to the joint, where the path is followed.
            let mut at_joint = (f64::INFINITY, 0.0);
            let mut last = AXES.map(|axis| bench.axis(axis).command);
            while !bench.control("M2").has(Flag::Pc) {
                bench.tick();
                let now = AXES.map(|axis| bench.axis(axis).command);
                let place = point(&bench);
                off = off.max(pieces[0].off(place).min(pieces[1].off(place)));
                missed = missed.min(apart(place, joint));
                let speed = now.iter().map(|axis| axis[1] * axis[1]).sum::<f64>().sqrt();
                if apart(place, joint) < at_joint.0 {
                    at_joint = (apart(place, joint), speed);
                }
                let step: Vector = std::array::from_fn(|k| now[k][1] - last[k][1]);
                // Two ramps at once, and the centripetal acceleration of arcs; a corner of types 4 and 5 is passed with a step by definition.
                let declared = if keeps && !tangent { 10.0 * 3.0_f64.sqrt() } else { 0.0 };
                let most = (2000.0 + 1500.0 + 2.0 * 120.0 * 120.0 / RADIUS) * 0.001 + declared;
                assert!(dot(step, step).sqrt() <= most, "{why}: {last:?} to {now:?}");
                last = now;
            }
            assert!(
                apart(point(&bench), pieces[1].end()) < 1e-12,
                "{why}: ends at {:?}",
                point(&bench)
            );
            assert_eq!(
                (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
                ("EN DN PC", "EN DN PC"),
                "{why}"
            );
            if tolerance == 0.0 {
                assert!(off < 1e-9, "{why}: {off} off the path");
            } else {
                // Not before the tolerance, and nearer to the corner than that.
                assert!(missed <= tolerance, "{why}: missed by {missed}");
                assert!(off > 1e-6 && off <= missed.max(1.0), "{why}: {off} off the path");
            }
            let kept = (at_joint.1 - 120.0).abs() < 1e-6;
            match (keeps, tangent) {
                (true, true) => assert!(kept, "{why}: {} at the joint", at_joint.1),
                (true, false) => assert!(at_joint.1 < 20.0, "{why}: {} at the joint", at_joint.1),
                _ if tolerance == 0.0 => assert!(at_joint.1 < 10.0, "{why}: {} at the joint", at_joint.1),
                _ => {}
            }
            took.push(bench.now());
        }
        // Stops take longest, then small and larger tolerances; a joint that is run over at full speed, least.
        let [_, stop, near, free, contour, _, far] = took[..] else {
            unreachable!("seven types")
        };
        assert!(free <= far && far <= near && near <= stop, "{pair}: {took:?}");
        assert!(contour < if tangent { free } else { stop }, "{pair}: {took:?}");
    }
}
