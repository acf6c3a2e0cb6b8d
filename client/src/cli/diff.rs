//! `diff`: whether two traces are the same within a tolerance. Rows are compared by their place, columns by their names; of columns with equal names
//! the first is compared with the first, the second with the second. Ticks and times have no tolerance.

use std::fs::File;
use std::io::{BufRead, BufReader, Lines};
use std::path::Path;

use serde_json::json;

use super::args::Diff;
use super::output::counted;
use super::{Failure, Output};

/// `diff`.
pub(crate) fn diff(command: &Diff, output: &Output) -> Result<(), Failure> {
    let Diff { a, b, tolerance } = command;
    let (mut first, mut second) = (Rows::open(a)?, Rows::open(b)?);
    let pairs = pairs(&first.titles, &second.titles);
    let missing = |of: &Rows<'_>, there: &Rows<'_>, has: &dyn Fn(usize) -> bool| {
        let missing = (0..).zip(&of.titles).find(|(place, _)| !has(*place));
        missing.map(|(place, title)| {
            let again = if of.titles[..place].contains(title) {
                " once more"
            } else {
                ""
            };
            format!(
                "{} has no column {title}{again}, which {} has",
                there.path.display(),
                of.path.display()
            )
        })
    };
    let what = missing(&first, &second, &|place| pairs.iter().any(|pair| pair.0 == place))
        .or_else(|| missing(&second, &first, &|place| pairs.iter().any(|pair| pair.1 == place)));
    let mut found = Found {
        what,
        ..Found::default()
    };
    loop {
        let (one, other) = (first.next()?, second.next()?);
        let (one, other) = match (one, other) {
            (None, None) => break,
            (Some(one), Some(other)) => (one, other),
            (one, _) => {
                let (longer, shorter) = if one.is_some() { (a, b) } else { (b, a) };
                let text = format!(
                    "{} ends after {}, {} goes on",
                    shorter.display(),
                    counted(found.rows, "row"),
                    longer.display()
                );
                found.what.get_or_insert(text);
                break;
            }
        };
        found.rows += 1;
        for (place, other_place) in &pairs {
            let (Some(x), Some(y)) = (one.get(*place), other.get(*other_place)) else {
                continue;
            };
            let title = &first.titles[*place];
            let tolerance = if EXACT.contains(&title.as_str()) {
                0.0
            } else {
                *tolerance
            };
            let differs = match (x.parse::<f64>(), y.parse::<f64>()) {
                (Ok(x), Ok(y)) => found.number(x, y, tolerance),
                _ => x != y,
            };
            if differs {
                found.differences += 1;
                let line = found.rows + 1;
                found
                    .what
                    .get_or_insert_with(|| format!("line {line}, {title}: {x} and {y}"));
            }
        }
    }
    let Found {
        rows,
        differences,
        greatest,
        what,
    } = found;
    match what {
        None => {
            output.result(
                format!("the same: {}, greatest difference {greatest}", counted(rows, "row")),
                || json!({"same": true, "rows": rows, "greatest": greatest}),
            );
            Ok(())
        }
        Some(what) => Err(Failure::Differs {
            what,
            differences,
            greatest,
        }),
    }
}

/// Columns whose numbers are compared exactly: a row of another tick is another row.
const EXACT: [&str; 2] = ["tick", "time_s"];

/// The columns of two files that are compared with each other.
fn pairs(first: &[String], second: &[String]) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(usize, usize)> = Vec::with_capacity(first.len());
    for (place, title) in first.iter().enumerate() {
        let is_free = |other: &usize| pairs.iter().all(|(_, taken)| taken != other);
        let other = (0..second.len()).find(|other| second[*other] == *title && is_free(other));
        pairs.extend(other.map(|other| (place, other)));
    }
    pairs
}

/// The result of a comparison.
#[derive(Default)]
struct Found {
    rows: usize,
    differences: usize,
    /// The greatest difference of two numbers.
    greatest: f64,
    /// The first difference.
    what: Option<String>,
}

impl Found {
    /// Whether two numbers differ by more than the tolerance. Two NaN are equal.
    fn number(&mut self, x: f64, y: f64, tolerance: f64) -> bool {
        let apart = if x == y || x.is_nan() && y.is_nan() {
            0.0
        } else {
            (x - y).abs()
        };
        // The first difference that is no number stays.
        if apart.is_nan() || apart > self.greatest {
            self.greatest = apart;
        }
        apart.is_nan() || apart > tolerance
    }
}

/// The rows of a file.
struct Rows<'p> {
    path: &'p Path,
    lines: Lines<BufReader<File>>,
    titles: Vec<String>,
    line: usize,
}

impl<'p> Rows<'p> {
    fn open(path: &'p Path) -> Result<Self, Failure> {
        let file = File::open(path).map_err(|source| Failure::at(path, source))?;
        let mut rows = Rows {
            path,
            lines: BufReader::new(file).lines(),
            titles: Vec::new(),
            line: 0,
        };
        let header = rows.text()?.unwrap_or_default();
        rows.titles = header.split(',').map(|title| title.trim().to_owned()).collect();
        if !rows.titles.iter().any(|title| title == "time_s") {
            let shown = path.display();
            return Err(Failure::Usage(format!(
                "{shown} is no trace: its first line has no column time_s"
            )));
        }
        Ok(rows)
    }

    /// The cells of the next row; `None` behind the last one.
    fn next(&mut self) -> Result<Option<Vec<String>>, Failure> {
        let Some(text) = self.text()? else { return Ok(None) };
        let cells: Vec<String> = text.split(',').map(|cell| cell.trim().to_owned()).collect();
        if cells.len() == self.titles.len() {
            return Ok(Some(cells));
        }
        let (shown, line, found, expected) = (self.path.display(), self.line, cells.len(), self.titles.len());
        Err(Failure::Usage(format!(
            "{shown}: line {line} has {found} cells, expected {expected}"
        )))
    }

    fn text(&mut self) -> Result<Option<String>, Failure> {
        for text in self.lines.by_ref() {
            self.line += 1;
            let text = text.map_err(|source| Failure::at(self.path, source))?;
            if !text.trim().is_empty() {
                return Ok(Some(text));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_differ_beyond_the_tolerance() {
        #[rustfmt::skip]
        let cases = [
            ("equal",                 1.0, 1.0, 0.0, false), ("both zeros",          0.0, -0.0, 0.0, false),
            ("within",                1.0, 1.5, 0.5, false), ("beyond",              1.0, 1.6, 0.5, true),
            ("no numbers both",  f64::NAN, f64::NAN, 0.0, false), ("one is no number", f64::NAN, 1.0, 9.0, true),
            ("infinite both", f64::INFINITY, f64::INFINITY, 0.0, false), ("one infinite", f64::INFINITY, 1.0, 9.0, true),
        ];
        for (why, x, y, tolerance, differs) in cases {
            assert_eq!(Found::default().number(x, y, tolerance), differs, "{why}");
        }
    }
}
