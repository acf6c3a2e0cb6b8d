use arcline_contour::*;
use std::time::Instant;
fn rot(v: Point, n: Point, a: f64) -> Point { v*a.cos() + n.cross(&v)*a.sin() + n*(n.dot(&v)*(1.0-a.cos())) }
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (name, scurve, first, add) = (&args[1], args[2] == "s", args[3].parse::<usize>().unwrap(), args[4].parse::<usize>().unwrap());
    let j: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(format!("/work/shared/check/paths/{name}.json")).unwrap()).unwrap();
    let p = |v: &serde_json::Value| Point::new(v[0].as_f64().unwrap(), v[1].as_f64().unwrap(), v[2].as_f64().unwrap());
    let lim = &j["limits"]; let l = |k: &str| lim[k].as_f64().unwrap();
    let limits = AxisLimits { speed: Point::repeat(l("v")), acceleration: Point::repeat(l("a")), jerk: Some(Point::repeat(l("j"))) };
    let mut at = p(&j["start"]);
    let mut moves = vec![];
    for m in j["moves"].as_array().unwrap() {
        let to = p(&m["to"]);
        let path = if m["t"] == "L" { Path::line(at, to) } else {
            let c = p(&m["c"]); let via = c + rot(at - c, p(&m["n"]), m["ang"].as_f64().unwrap()/2.0);
            Path::Arc(arcline_geometry::Arc::new(arcline_geometry::Dimension::Three, at, to, arcline_geometry::CirclePoint::Via(via), arcline_geometry::Direction::from_word(0).unwrap()).unwrap())
        };
        moves.push(ContourMove { path, speed: j["F"].as_f64().unwrap(), acceleration: 2.0*l("a"), deceleration: 2.0*l("a"), jerk: scurve.then_some(2.0*l("j")), tolerance: j["tol"].as_f64().unwrap() });
        at = to;
    }
    let t = Instant::now();
    let whole = plan(&moves, &limits);
    println!("whole {:.4} s, planned in {:.2} s", whole.duration(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let mut n = first.min(moves.len());
    let mut run = plan(&moves[..n], &limits);
    let (mut fails, mut count) = (0, 0);
    let mut passed = 0;
    let mut rests = 0;
    let mut slow: f64 = 0.0;
    while n < moves.len() {
        // arrives while the motion is well before its end
        let more = (n + add).min(moves.len());
        let now = (run.duration() - 0.5).max(0.0);
        let now = run_start(&run).max(now);
        let before = run.move_at(now);
        passed += before;
        count += 1;
        let tt = Instant::now();
        let r = extend(&run, before, &moves[passed..more], &limits, now, now + 0.05);
        slow = slow.max(tt.elapsed().as_secs_f64());
        match r {
            Some(e) => { run = e; }
            None => {
                fails += 1; rests += 1;
                // goes on to rest, then from rest
                println!("  fail at {n} t={now:.3}");
                let left = run.moves() - before;
                let mut w = run.clone();
                w.append(plan(&moves[passed + left..more], &limits));
                run = w; passed -= before; 
            }
        }
        n = more;
    }
    let pk = run.peaks();
    println!("windows {:.4} s, {} extensions, {} failed, {rests} rests, planned in {:.2} s, slowest {slow:.3} s; peaks (tail) v {:?} a {:?} j {:?}", run.duration(), count, fails, t.elapsed().as_secs_f64(), pk.velocity.max(), pk.acceleration.max(), pk.jerk.max());
}
fn run_start(t: &Trajectory) -> f64 { let _ = t; 0.0 }
