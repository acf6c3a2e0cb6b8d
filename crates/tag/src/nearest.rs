//! "Did you mean": of the known names, the nearest to an unknown one. The one measure for tags, members, objects, words
//! and keys; the caller supplies the known names.

/// Characters that are compared: a slip is one of a short name, and a peer may send kilobytes.
const COMPARED: usize = 60;
/// Least similarity of a slip, by Jaro and Winkler: 0 nothing in common, 1 the same.
const NEAR: f64 = 0.75;

/// The candidate nearest to a name, case ignored, when it is near enough to be a slip.
///
/// ```
/// use arcline_tag::nearest;
///
/// assert_eq!(nearest("ActualPositon", ["ActualPosition", "ActualVelocity"]).as_deref(), Some("ActualPosition"));
/// assert_eq!(nearest("Recipe", ["X", "CS1"]), None);
/// ```
pub fn nearest<S: AsRef<str>>(name: &str, candidates: impl IntoIterator<Item = S>) -> Option<String> {
    let name = name.chars().take(COMPARED).collect::<String>().to_ascii_lowercase();
    let similarity = |candidate: &S| strsim::jaro_winkler(&name, &candidate.as_ref().to_ascii_lowercase());
    candidates
        .into_iter()
        .map(|candidate| (similarity(&candidate), candidate))
        .filter(|(similarity, _)| *similarity >= NEAR)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.as_ref().to_owned())
}
