//! Hashes of passwords: Argon2id with 19 MiB, two passes, one lane (OWASP; the crate's defaults), as PHC strings.

use std::sync::OnceLock;

use argon2::password_hash::phc::PasswordHash;
use argon2::password_hash::{PasswordHasher as _, PasswordVerifier as _};
use argon2::{Algorithm, Argon2, Params};

/// Characters that a new password has at least.
pub(crate) const LEAST: usize = 12;
/// Bytes that a password has at most: a longer one is refused before it is hashed.
pub(crate) const MOST: usize = 256;
/// Memory that the check of a stored hash may take, KiB.
const MOST_MEMORY: u32 = 64 * 1024;
/// Passes and lanes that it may take.
const MOST_PASSES: u32 = 16;
const MOST_LANES: u32 = 4;

/// A hash of a password that can be checked at a bounded cost.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Stored(String);

impl std::fmt::Debug for Stored {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("…")
    }
}

impl Stored {
    /// Reads a PHC string.
    ///
    /// # Errors
    /// It is none, of another function, or needs too much memory or time.
    pub(crate) fn parse(text: &str) -> Result<Self, &'static str> {
        const EXPECTED: &str = "password: expected an Argon2id hash of at most 64 MiB, as `users passwd` makes it";
        let hash = PasswordHash::new(text).map_err(|_| EXPECTED)?;
        let params = Params::try_from(&hash).map_err(|_| EXPECTED)?;
        let fits = hash.algorithm == Algorithm::Argon2id.ident()
            && hash.hash.is_some()
            && params.m_cost() <= MOST_MEMORY
            && params.t_cost() <= MOST_PASSES
            && params.p_cost() <= MOST_LANES;
        if fits { Ok(Self(text.to_owned())) } else { Err(EXPECTED) }
    }

    /// The PHC string.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// Whether a password has this hash. The check takes some 20 ms and the memory of the hash.
    pub(crate) fn is_of(&self, password: &str) -> bool {
        let hash = PasswordHash::new(&self.0);
        password.len() <= MOST
            && hash.is_ok_and(|hash| Argon2::default().verify_password(password.as_bytes(), &hash).is_ok())
    }
}

/// The hash of a password, with a salt of its own.
///
/// # Errors
/// The system has no random numbers.
pub(crate) fn hash(password: &str) -> Result<Stored, argon2::password_hash::Error> {
    let hash: PasswordHash = Argon2::default().hash_password(password.as_bytes())?;
    Ok(Stored(hash.to_string()))
}

/// Takes as long as the check of a user's password: for a user who does not exist.
pub(crate) fn check_unknown_user(password: &str) {
    static UNKNOWN: OnceLock<Option<Stored>> = OnceLock::new();
    // Without random numbers there is no hash to check, and every log-in fails either way.
    if let Some(unknown) = UNKNOWN.get_or_init(|| hash("nobody has this password").ok()) {
        unknown.is_of(password);
    }
}

/// Makes the hash of [`check_unknown_user`], so that the first check does not take longer than others.
pub(crate) fn prepare() {
    check_unknown_user("");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_is_of_its_password_only() {
        let stored = hash("correct horse battery").expect("it is hashed");
        assert!(
            stored.text().starts_with("$argon2id$v=19$m=19456,t=2,p=1$"),
            "{}",
            stored.text()
        );
        assert!(stored.is_of("correct horse battery"));
        for other in [
            "",
            "correct horse batterz",
            "Correct horse battery",
            "correct horse battery ",
        ] {
            assert!(!stored.is_of(other), "{other:?}");
        }
        assert_ne!(
            hash("correct horse battery").expect("it is hashed"),
            stored,
            "a salt of its own"
        );
        assert!(!format!("{stored:?}").contains("argon2"), "not shown");
    }
}
