//! The page docs/LADDER.md, written from the table of instructions.

use std::fmt::Write as _;

use crate::table::{Form, ROWS};

/// The page of all instructions of routines.
pub fn ladder_page() -> String {
    let mut page = String::from(HEAD);
    for (form, title) in FORMS {
        let _ = write!(
            page,
            "\n## {title}\n\n| instruction | operands | prescan | false rung | true rung |\n|---|---|---|---|---|\n"
        );
        for row in ROWS.iter().filter(|row| row.form == form) {
            let names = row
                .names
                .iter()
                .map(|name| format!("`{name}`"))
                .collect::<Vec<_>>()
                .join(" ");
            let operands = row
                .operands
                .iter()
                .map(|(name, _)| *name)
                .collect::<Vec<_>>()
                .join(", ");
            let operands = if row.takes_more() {
                format!("{operands} …")
            } else {
                operands
            };
            let [prescan, off, on] = [row.prescan, row.off, row.on].map(|text| {
                let text = text.replace('|', "\\|");
                if text.is_empty() { "–".to_owned() } else { text }
            });
            let _ = writeln!(
                page,
                "| {names} {} | {operands} | {prescan} | {off} | {on} |",
                row.title
            );
        }
    }
    page
}

const FORMS: [(Form, &str); 5] = [
    (Form::Input, "Conditions"),
    (Form::Output, "Outputs"),
    (Form::Edge, "Instructions that act when their rung becomes true"),
    (Form::Control, "Order of execution"),
    (Form::Text, "Structured Text alone"),
];

const HEAD: &str = "\
# Instructions of routines

The instructions that `arcline-server run Project.L5X` and `arcline-server simulate Project.L5X` execute in ladder and in Structured Text;
`arcline-server import Project.L5X --report` lists the parts of a project that they do not execute. A test writes this page from the table by which routines
are compiled and run (`crates/routine/src/table`). The instructions of motion are those of [INSTRUCTIONS.md](INSTRUCTIONS.md), with operands in
the order of the faceplate; add-on instructions are those of the project. How rungs, tasks and faults work is in
[the specification](spec/programs.md).

`out` is the condition that an instruction passes on; without a word of it, it is the condition that came in. `edge` is a scan with a true rung
behind one with a false rung. Instructions with two names accept both.
";

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_is_that_of_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/LADDER.md");
        let page = super::ladder_page();
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(path, &page).expect("docs/LADDER.md can be written");
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(there == page, "docs/LADDER.md is old: UPDATE_EXPECT=1 writes it");
    }
}
