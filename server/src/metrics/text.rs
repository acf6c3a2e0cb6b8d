//! The text format 0.0.4 of Prometheus: a head of each family, then its values.

use std::fmt::Write as _;

/// A text under way.
#[derive(Debug, Default)]
pub(super) struct Text {
    out: String,
    /// The name of the present family.
    name: String,
}

impl Text {
    /// Begins a family.
    pub(super) fn family(&mut self, name: &str, kind: &str, help: &str) {
        name.clone_into(&mut self.name);
        // Writing to a String cannot fail.
        let _ = writeln!(self.out, "# HELP {name} {help}\n# TYPE {name} {kind}");
    }

    /// A family with one value.
    pub(super) fn single(&mut self, name: &str, kind: &str, help: &str, value: f64) {
        self.family(name, kind, help);
        self.value(&[], value);
    }

    /// A value of the family.
    pub(super) fn value(&mut self, labels: &[(&str, &str)], value: f64) {
        self.part("", labels, value);
    }

    /// A value whose name has an ending, as histograms have them.
    pub(super) fn part(&mut self, ending: &str, labels: &[(&str, &str)], value: f64) {
        self.out.push_str(&self.name);
        self.out.push_str(ending);
        for (place, (label, text)) in labels.iter().enumerate() {
            self.out.push(if place == 0 { '{' } else { ',' });
            let text = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            let _ = write!(self.out, "{label}=\"{text}\"");
        }
        if !labels.is_empty() {
            self.out.push('}');
        }
        let value = match value {
            value if value.is_nan() => "NaN".to_owned(),
            f64::INFINITY => "+Inf".to_owned(),
            f64::NEG_INFINITY => "-Inf".to_owned(),
            value => value.to_string(),
        };
        let _ = writeln!(self.out, " {value}");
    }

    pub(super) fn finish(self) -> String {
        self.out
    }
}

#[cfg(test)]
mod tests {
    use super::Text;

    #[test]
    fn a_family_has_its_head_and_escaped_labels() {
        let mut text = Text::default();
        text.family("a_total", "counter", "Help.");
        text.value(&[("x", "a\"b\\c\nd"), ("y", "")], 1.5);
        text.part("_sum", &[], f64::INFINITY);
        text.value(&[], f64::NAN);
        let expected = "# HELP a_total Help.\n# TYPE a_total counter\na_total{x=\"a\\\"b\\\\c\\nd\",y=\"\"} 1.5\na_total_sum +Inf\na_total NaN\n";
        assert_eq!(text.finish(), expected);
    }
}
