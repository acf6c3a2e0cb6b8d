//! Rests of planned contours between moves that go on, as `status` and `watch` show them.

use serde_json::{Value as Json, json};

use arcline_client::{Client, TagValue};

use super::Failure;
use super::output::counted;

/// The tag that counts them, an element for each coordinate system.
const CONTOUR_RESTS: &str = "ContourRests";

/// The rests of one coordinate system since the start of the server.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct Rests {
    /// The program sent its next move too late.
    starved: u64,
    /// The plan of the moves that waited was not ready in time.
    unplanned: u64,
}

impl Rests {
    /// The rests of every coordinate system; none if the server has no such tag.
    pub(super) async fn read(client: &Client) -> Result<Vec<Self>, Failure> {
        match client.read(CONTOUR_RESTS).await {
            Ok(TagValue::Array(elements)) => Ok(elements.iter().map(Self::of).collect()),
            Err(error) if error.is_connection() => Err(error.into()),
            Ok(one) => Ok(vec![Self::of(&one)]),
            Err(_) => Ok(Vec::new()),
        }
    }

    fn of(element: &TagValue) -> Self {
        let count = |name| element.member(name).and_then(TagValue::as_f64).unwrap_or_default() as u64;
        Rests {
            starved: count("Starved"),
            unplanned: count("Unplanned"),
        }
    }

    /// `2 rests (program too slow)`; empty where there are none.
    pub(super) fn text(self) -> String {
        let causes = [(self.starved, "program"), (self.unplanned, "planner")];
        let some = causes.into_iter().filter(|(count, _)| *count > 0);
        let texts: Vec<String> = some
            .map(|(count, slow)| format!("{} ({slow} too slow)", counted(count, "rest")))
            .collect();
        texts.join(", ")
    }

    /// The fields of JSON.
    pub(super) fn json(self) -> Json {
        json!({"program_too_slow": self.starved, "planner_too_slow": self.unplanned})
    }
}

#[cfg(test)]
mod tests {
    use super::Rests;

    #[test]
    fn a_slow_program_is_told_from_a_slow_planner() {
        let text = |starved, unplanned| Rests { starved, unplanned }.text();
        assert_eq!(text(0, 0), "");
        assert_eq!(text(1, 0), "1 rest (program too slow)");
        assert_eq!(text(0, 2), "2 rests (planner too slow)");
        assert_eq!(text(3, 1), "3 rests (program too slow), 1 rest (planner too slow)");
    }
}
