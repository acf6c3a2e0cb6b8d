//! A machine for transforms and gears: five coordinate systems of three axes without drives, and one of servos, with
//! the errors that they can raise.

use crate::bench::Bench;

/// Axes `A1 B1 C1` to `A5 B5 C5` are virtual and make the systems `L1` to `L5`; `P Q R` are servos and make `SERVO`.
/// `FLAT1` and `FLAT2` have two axes, of `L1` and `L2`; `ROUND` has a rotary axis; `ACROSS` has `A1 B2 C3`. Every axis has a
/// Maximum Deceleration of 4000, every system one of 2000 units/s².
pub fn machine(period_ms: f64) -> String {
    let mut text = format!("[motion_group]\nname = \"Motion\"\ncoarse_update_period_ms = {period_ms:?}\n");
    let mut axis = |name: &str, kind: &str, more: &str| {
        text += &format!(
            "[[axis]]\nname = \"{name}\"\ntype = \"{kind}\"\nunits = \"mm\"\nmax_speed = 1000.0\n\
             max_acceleration = 5000.0\nmax_deceleration = 4000.0\nmax_acceleration_jerk = 100000.0\n\
             max_deceleration_jerk = 100000.0\ncommand_limits = {{ enabled = true }}\n{more}"
        );
    };
    for place in 1..=5 {
        for letter in ["A", "B", "C"] {
            axis(&format!("{letter}{place}"), "virtual", "");
        }
    }
    for name in ["P", "Q", "R"] {
        axis(
            name,
            "servo",
            "start = { position = 0.0, servo_on = true, homed = true }\n",
        );
    }
    axis("TURN", "virtual", "unwind = 360.0\n");
    let systems = [
        ("L1", "\"A1\", \"B1\", \"C1\""),
        ("L2", "\"A2\", \"B2\", \"C2\""),
        ("L3", "\"A3\", \"B3\", \"C3\""),
        ("L4", "\"A4\", \"B4\", \"C4\""),
        ("L5", "\"A5\", \"B5\", \"C5\""),
        ("SERVO", "\"P\", \"Q\", \"R\""),
        ("FLAT1", "\"A1\", \"B1\""),
        ("FLAT2", "\"A2\", \"B2\""),
        ("ROUND", "\"A4\", \"TURN\", \"C4\""),
        ("ACROSS", "\"A1\", \"B2\", \"C3\""),
    ];
    for (name, axes) in systems {
        text += &format!(
            "[[coordinate_system]]\nname = \"{name}\"\ntype = \"cartesian\"\naxes = [{axes}]\nmax_speed = 500.0\n\
             max_acceleration = 5000.0\nmax_deceleration = 2000.0\nmax_acceleration_jerk = 100000.0\n\
             max_deceleration_jerk = 100000.0\nactual_tolerance = 0.01\ncommand_tolerance = 0.5\n"
        );
    }
    text
}

/// Tags of a cam: `Cam` rises by 5 units over 5 units of its master, then falls; `Profile` has room for the first two points.
pub const CAM_TAGS: &str = r#"
[[tag]]
name = "Cam"
type = "CAM[4]"
value = [{ Master = 0.0 }, { Master = 5.0, Slave = 5.0 }, { Master = 6.0 }, { Master = 7.0 }]

[[tag]]
name = "Profile"
type = "CAM_PROFILE[2]"
"#;

/// The same machine; masters may lead its virtual axes faster than drives could follow.
#[must_use]
pub fn without_command_limits(period_ms: f64) -> String {
    machine(period_ms).replace("command_limits = { enabled = true }\n", "")
}

/// [`machine`] at 1 ms, at tick 0.
#[must_use]
pub fn bench() -> Bench {
    Bench::with(&machine(1.0))
}
