//! The cost of viewers: a trace beside them has no gap, and they do not delay the tick.

use arcline_controller::image::MeasuredTime;

use super::*;

/// The length of the traces that ten viewers watch, s: `ARCLINE_TRACE_SECONDS`, or 2 by default.
fn trace_seconds() -> u64 {
    let given = std::env::var("ARCLINE_TRACE_SECONDS").ok();
    given.and_then(|text| text.parse().ok()).unwrap_or(2)
}

/// Ten viewers that get everything and watch no routine, until they are dropped.
struct Audience(Vec<JoinHandle<()>>);

impl Audience {
    async fn of_ten(bench: &Bench) -> Self {
        let mut looking = Vec::new();
        for _ in 0..10 {
            let mut viewer = bench.viewer().await;
            viewer.ask(json!({"do": "trace", "on": true})).await.expect("frames");
            looking.push(tokio::spawn(
                async move { while viewer.socket.next().await.is_some() {} },
            ));
        }
        Audience(looking)
    }
}

impl Drop for Audience {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// Records 32 signals for a number of ticks and checks that no row is missing.
async fn trace_without_a_gap(bench: &Bench, ticks: u64) {
    let signals = crate::trace::history::columns(bench.plant.machine());
    assert_eq!(signals.len(), 32);
    let trace = bench.plant.trace();
    let config = crate::trace::Config {
        signals,
        before: 0,
        length: ticks as u32,
        every: 1,
        trigger: crate::trace::Trigger::None,
    };
    let instance = trace.create(config).expect("room");
    let (mut next, mut rows) = (None, 0u64);
    while rows < ticks {
        let block = trace.read(instance, next.unwrap_or(0), 500).expect("it is there");
        if block.rows == 0 {
            tokio::time::sleep(Duration::from_millis(20)).await;
            continue;
        }
        assert!(
            next.is_none_or(|next| next == block.first),
            "a gap before {}",
            block.first
        );
        assert_eq!(block.values.len(), 32 * block.rows);
        rows += block.rows as u64;
        next = Some(block.first + block.rows as u64);
    }
    assert_eq!(trace.standing(instance).map(|standing| standing.missing), Some(0));
    trace.delete(instance);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_trace_has_no_gap_while_ten_viewers_look() {
    let bench = Bench::start().await;
    let _audience = Audience::of_ten(&bench).await;
    trace_without_a_gap(&bench, 1000 * trace_seconds()).await;
}

/// Ticks that were measured between two moments: how many, and how late, in µs.
struct Late {
    ticks: u64,
    late: MeasuredTime,
    compute: MeasuredTime,
    cpu: f64,
}

impl Late {
    fn begin(bench: &Bench) -> Self {
        let health = bench.plant.health();
        Late {
            ticks: health.ticks,
            late: health.lateness,
            compute: health.compute,
            cpu: cpu_seconds(),
        }
    }

    /// Adds the measurements since an earlier moment.
    fn add(&mut self, bench: &Bench, since: &Late) {
        let now = Late::begin(bench);
        self.ticks += now.ticks - since.ticks;
        self.cpu += now.cpu - since.cpu;
        let each = |sum: &mut MeasuredTime, now: &MeasuredTime, since: &MeasuredTime| {
            sum.max = now.max;
            for (bucket, count) in sum.histogram.iter_mut().enumerate() {
                *count += now.histogram[bucket] - since.histogram[bucket];
            }
        };
        each(&mut self.late, &now.late, &since.late);
        each(&mut self.compute, &now.compute, &since.compute);
    }

    fn told(&self) -> String {
        format!(
            "late p50 {} p99 {} us, compute p50 {} p99 {} us, {:.1} % of a core with all clients, in {} ticks",
            self.late.p50(),
            self.late.p99(),
            self.compute.p50(),
            self.compute.p99(),
            1e5 * self.cpu / self.ticks as f64,
            self.ticks
        )
    }
}

/// Measures in turns: without viewers, and with ten viewers and a trace of 32 signals; viewers do not delay the tick. The halves of
/// `ARCLINE_TRACE_SECONDS` are cut into pieces, so that other load of the machine falls on both.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tick_is_not_later_for_viewers() {
    let bench = Bench::start().await;
    let none = || Late {
        ticks: 0,
        late: MeasuredTime::default(),
        compute: MeasuredTime::default(),
        cpu: 0.0,
    };
    let (mut alone, mut watched) = (none(), none());
    let turns = (trace_seconds() / 10).max(2);
    let piece = Duration::from_secs(trace_seconds()) / turns as u32 / 2;
    for _ in 0..turns {
        let since = Late::begin(&bench);
        tokio::time::sleep(piece).await;
        alone.add(&bench, &since);
        let audience = Audience::of_ten(&bench).await;
        let since = Late::begin(&bench);
        trace_without_a_gap(&bench, piece.as_millis() as u64).await;
        watched.add(&bench, &since);
        drop(audience);
    }
    println!("alone:                  {}", alone.told());
    println!("ten viewers and a trace: {}", watched.told());
    // Buckets are a factor of two wide, and a busy machine adds latency of its own.
    let bound = 8.0 * alone.late.p50() + 500.0;
    assert!(watched.late.p50() <= bound, "{} above {bound} us", watched.late.p50());
}

/// CPU time of this process, s.
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 / 1e9
}
