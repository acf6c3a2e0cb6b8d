//! The configurations of the simulated machine.

use arcline_config::Project;

const CONFIG: &str = r#"
[security]
remote_plain = "engineer"
loopback = "viewer"
[[instruction]]
tag = "StepA"
type = "MAM"
target = "A"
[[axis]]
name = "P"
type = "servo"
units = "mm"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
max_acceleration_jerk = 200000.0
max_deceleration_jerk = 200000.0
[[tag]]
name = "PageRun"
type = "DINT"
[[tag]]
name = "D0"
type = "DINT"
[[tag]]
name = "D1"
type = "DINT"
[[tag]]
name = "D2"
type = "DINT"
[[tag]]
name = "D3"
type = "DINT"
[[tag]]
name = "P0"
type = "DINT"
[[tag]]
name = "P1"
type = "DINT"
[[tag]]
name = "Big"
type = "DINT[100]"
"#;

const EXTRA: &str = r#"
[[tag]]
name = "Extra1"
type = "DINT"
[[tag]]
name = "Extra2"
type = "DINT"
"#;

/// The configurations between which a reload changes: without the extra tags and with them.
pub(super) struct Projects(pub(super) [Project; 2]);

impl Projects {
    pub(super) fn new() -> Self {
        let server = "[server]\njog_silence_ms = 500\nmax_clients_per_address = 8\n";
        let base = arcline_config::DEFAULT.replacen("[server]\n", server, 1) + CONFIG;
        let load = |text: &str| arcline_config::load(text, "sim.toml").unwrap_or_else(|error| panic!("{error}"));
        Projects([load(&base), load(&(base.clone() + EXTRA))])
    }
}
