//! What a session shares with the others of its server: randomness, limits, counters and the identity.
//!
//! Not how they are kept; the server implements [`Host`].

use crate::connection::Count;
use crate::identity::Identity;

/// What a session shares with the others of its server.
pub trait Host {
    /// An unpredictable number, for session handles and connection ids. Zero is asked again; so is one that this session
    /// uses. Values should not repeat among live sessions. `None` when the source of randomness fails: the session
    /// refuses then what needs a number, rather than give out one that can be guessed.
    fn random(&mut self) -> Option<u32>;
    /// Whether one more class 3 connection may open; counts it if so.
    fn acquire_connection(&mut self) -> bool;
    /// `count` connections have gone.
    fn release_connections(&mut self, count: usize);
    /// Counts for the Connection Manager's attributes.
    fn count(&mut self, count: Count);
    /// Who the device is at present.
    fn identity(&self) -> &Identity;
}

/// A number that is not zero and that `free` accepts; a host that always draws the same gets it counted up. `None` when
/// the host cannot draw.
pub(super) fn nonzero(host: &mut dyn Host, free: impl Fn(u32) -> bool) -> Option<u32> {
    let mut number = host.random()?;
    while number == 0 || !free(number) {
        number = number.wrapping_add(1).wrapping_add(host.random()? & 0xFFFF);
    }
    Some(number)
}
