//! The figures of the campaigns: docs/RELIABILITY.md and README.md show those of the files that the campaigns have written.

use std::collections::BTreeMap;
use std::path::Path;

use arcline_tests::workspace;

const BEGIN: &str =
    "<!-- A test writes the table to the next mark from docs/campaigns (tests/tests/repository/campaign.rs). -->\n\n";
const END: &str = "\n<!-- End of the table of campaigns. -->";
/// The beginning of the row in README.md.
const ROW: &str = "| [the whole server simulated from a seed](docs/RELIABILITY.md#the-whole-server) |";

/// A file of docs/campaigns.
fn file(name: &str) -> String {
    let path = workspace().join("docs/campaigns").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The file of the simulation: keys and values.
struct Simulation(BTreeMap<String, String>);

impl Simulation {
    fn read() -> Self {
        let text = file("simulation.toml");
        let lines = text.lines().filter_map(|line| line.split_once(" = "));
        Simulation(
            lines
                .map(|(key, value)| (key.to_owned(), value.trim_matches('"').to_owned()))
                .collect(),
        )
    }

    fn text(&self, key: &str) -> &str {
        let value = self.0.get(key);
        value.unwrap_or_else(|| panic!("docs/campaigns/simulation.toml has no {key}"))
    }

    fn number(&self, key: &str) -> u64 {
        let text = self.text(key);
        text.parse().unwrap_or_else(|_| panic!("{key} is no number: {text}"))
    }

    /// Simulated seconds in a second of one processor.
    fn speed(&self) -> u64 {
        self.number("simulated_s") / self.number("processor_s")
    }

    /// The number of runs, if the file has it: some scenarios are run several times.
    fn runs(&self) -> String {
        match self.0.get("runs") {
            Some(runs) => format!(" in {runs} runs"),
            None => String::new(),
        }
    }

    fn hours(&self) -> f64 {
        self.number("simulated_s") as f64 / 3600.0
    }
}

/// The lines of a file whose first one has the commit and the date of its campaign, and that first one.
fn dated(name: &str) -> (String, Vec<String>) {
    let text = file(name);
    let mut lines = text.lines().map(str::to_owned);
    let first = lines.next().unwrap_or_default();
    let parts: Vec<&str> = first.split(' ').collect();
    assert!(
        matches!(parts[..], ["commit", commit, "of", date] if commit.len() >= 8 && date.len() == 10),
        "docs/campaigns/{name} begins with `commit … of YYYY-MM-DD`, not with {first:?}"
    );
    (first, lines.collect())
}

/// Bugs that were planted, and the seed that found each; `None`: it was not found.
fn planted() -> Vec<(String, Option<u64>)> {
    let (_, lines) = dated("planted.txt");
    let lines = lines.iter().map(|line| match line.split_once(" found by seed ") {
        Some((bug, seed)) => {
            let seed = seed.trim().parse().expect("the seed is a number");
            (bug.trim().to_owned(), Some(seed))
        }
        None => (line.clone(), None),
    });
    lines.collect()
}

fn table() -> String {
    let simulation = Simulation::read();
    let planted = planted();
    let seeds: Vec<u64> = planted.iter().filter_map(|(_, seed)| *seed).collect();
    let (kills, campaign) = dated("kills.txt");
    format!(
        "| campaign | figures |\n|---|---|\n\
         | scenarios, commit {} of {} | {} of 20 s from seed {}{}: {:.1} hours simulated, {} times real time on one core; all {} states reached, no \
         invariant broken |\n\
         | planted bugs, {} | {} of {} found, the last by seed {} |\n\
         | kills, {} | {} |\n",
        simulation.text("commit"),
        simulation.text("date"),
        simulation.number("scenarios"),
        simulation.number("first_seed"),
        simulation.runs(),
        simulation.hours(),
        simulation.speed(),
        simulation.number("states"),
        dated("planted.txt").0,
        seeds.len(),
        planted.len(),
        seeds.iter().max().copied().unwrap_or_default(),
        kills,
        campaign.join(" ")
    )
}

/// Compares a file with the expected text, or writes it.
fn hold(path: &Path, found: &str, expected: &str) {
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(path, expected).expect("the file can be written");
    } else {
        assert!(
            found == expected,
            "{} is old: run the test with UPDATE_EXPECT=1",
            path.display()
        );
    }
}

#[test]
fn the_figures_of_reliability_are_those_of_the_campaigns() {
    let path = workspace().join("docs/RELIABILITY.md");
    let page = std::fs::read_to_string(&path).expect("it can be read");
    let (head, rest) = page
        .split_once(BEGIN)
        .expect("RELIABILITY.md has the mark of the table");
    let (_, tail) = rest
        .split_once(END)
        .expect("RELIABILITY.md has the mark behind the table");
    hold(&path, &page, &format!("{head}{BEGIN}{}{END}{tail}", table()));
}

#[test]
fn the_row_of_the_simulation_is_that_of_the_campaign() {
    let path = workspace().join("README.md");
    let readme = std::fs::read_to_string(&path).expect("it can be read");
    let simulation = Simulation::read();
    let row = format!(
        "{ROW} {:.1} hours simulated, {} times real time on one core, none of its invariants broken; {} of {} planted bugs found |",
        simulation.hours(),
        simulation.speed(),
        planted().iter().filter(|(_, seed)| seed.is_some()).count(),
        planted().len()
    );
    let rows = readme.lines().filter(|line| line.starts_with(ROW)).count();
    assert_eq!(rows, 1, "README.md has one such row");
    let lines = readme
        .lines()
        .map(|line| if line.starts_with(ROW) { row.as_str() } else { line });
    hold(&path, &readme, &(lines.collect::<Vec<_>>().join("\n") + "\n"));
}

/// The least size of a valid campaign by the standards.
#[test]
fn the_campaigns_are_of_the_size_that_is_asked() {
    let simulation = Simulation::read();
    assert!(simulation.number("scenarios") >= 200, "as many as a run of CI");
    assert!(planted().len() >= 16, "16 bugs");
    for (bug, seed) in planted() {
        assert!(
            seed.is_some_and(|seed| seed < 1000),
            "{bug}: not found within 1,000 seeds"
        );
    }
    let (_, kills) = dated("kills.txt");
    assert!(kills.iter().any(|line| line.starts_with("1000 kills")), "1,000 kills");
}
