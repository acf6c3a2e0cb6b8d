//! Bugs that are built in on purpose, to try whether the simulation (`tests/sim`) finds them. Only with the feature `planted`, which no
//! program is built with.

/// Whether a bug is switched on, by the variable `ARCLINE_PLANTED`.
#[cfg(feature = "planted")]
pub fn is_planted(bug: &str) -> bool {
    static PLANTED: std::sync::OnceLock<Option<String>> = std::sync::OnceLock::new();
    PLANTED
        .get_or_init(|| std::env::var("ARCLINE_PLANTED").ok())
        .as_deref()
        .is_some_and(|planted| planted == bug)
}

/// No bug is switched on.
#[cfg(not(feature = "planted"))]
pub const fn is_planted(_: &str) -> bool {
    false
}

#[cfg(all(feature = "planted", not(debug_assertions)))]
compile_error!("no release has planted bugs");
