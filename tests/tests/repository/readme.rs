//! The table of instructions in README.md: every instruction of the catalogue, by group, with its status.
//! `UPDATE_EXPECT=1 cargo test -p arcline-tests --test repository` rewrites the table.

use std::fmt::Write;

use arcline_instruction_set::Mnemonic;
use arcline_tests::workspace;

const BEGIN: &str =
    "<!-- A test writes the table to the next mark from the catalogue (tests/tests/repository/readme.rs). -->\n\n";
const END: &str = "\n<!-- The end of what the test writes. -->\n";

/// A row of the table.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Group {
    CoordinatedMoves,
    CoordinatedStops,
    Robots,
    Axes,
    Masters,
    Outputs,
    WholeMachine,
}

impl Group {
    const ALL: [Self; 7] = [
        Self::CoordinatedMoves,
        Self::CoordinatedStops,
        Self::Robots,
        Self::Axes,
        Self::Masters,
        Self::Outputs,
        Self::WholeMachine,
    ];

    const fn title(self) -> &'static str {
        match self {
            Self::CoordinatedMoves => "coordinated moves",
            Self::CoordinatedStops => "stops and resets of coordinate systems",
            Self::Robots => "robots and transforms",
            Self::Axes => "single axes",
            Self::Masters => "gears, cams and masters",
            Self::Outputs => "output cams, registration, watched positions",
            Self::WholeMachine => "motion group",
        }
    }

    const fn status(self) -> &'static str {
        match self {
            Self::CoordinatedMoves => {
                "complete: lines, arcs and circles in two and three dimensions, trapezoids and S-curves, all termination types with the \
                 superposed blends of Logix, merging, queues of up to 1,000 moves, changes of dynamics during a move. Optional: corners \
                 within a tolerance at the highest speed that the axes allow (`corner = \"precise\"`), limits of single axes (`axis_limits`)"
            }
            Self::Robots => {
                "articulated, SCARA, delta and six-axis arms, tool orientation, joint limits ([docs/TRANSFORMS.md](docs/TRANSFORMS.md)). \
                 MCPM interpolates linearly and ends with termination type 0, 1 or 6"
            }
            Self::Axes => "complete, rotary axes too; homing on simulated switches, markers and mechanical stops",
            Self::Masters => "complete: moves and jogs as functions of a master's position too",
            Self::CoordinatedStops | Self::Outputs | Self::WholeMachine => "complete",
        }
    }
}

/// The group of an instruction. A new instruction does not compile until it has one.
const fn group(mnemonic: Mnemonic) -> Group {
    use Mnemonic::*;
    match mnemonic {
        Mclm | Mccm | Mccd => Group::CoordinatedMoves,
        Mcs | Mcsd | Mcsr => Group::CoordinatedStops,
        Mct | Mctp | Mcto | Mctpo | Mcpm => Group::Robots,
        Mso | Msf | Mam | Maj | Mcd | Mas | Mah | Mrp | Masd | Masr | Mafr => Group::Axes,
        Mag | Mapc | Matc | Mccp | Mcsv | Mdac | Mdcc => Group::Masters,
        Maoc | Mdoc | Mar | Mdr | Maw | Mdw => Group::Outputs,
        Mgs | Mgsd | Mgsr | Mgsp => Group::WholeMachine,
    }
}

/// The heading of an instruction in docs/INSTRUCTIONS.md as the fragment of a link.
fn fragment(mnemonic: Mnemonic) -> String {
    let heading = format!("{mnemonic} {}", mnemonic.title()).to_lowercase();
    let plain = heading
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-'));
    plain.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn table() -> String {
    let mut table = String::from("| group | instructions | status |\n|---|---|---|\n");
    for row in Group::ALL {
        let members = Mnemonic::ALL.iter().filter(|mnemonic| group(**mnemonic) == row);
        let links: Vec<_> = members
            .map(|mnemonic| format!("[{mnemonic}](docs/INSTRUCTIONS.md#{})", fragment(*mnemonic)))
            .collect();
        writeln!(table, "| {} | {} | {} |", row.title(), links.join(", "), row.status())
            .expect("a text takes every line");
    }
    table
}

#[test]
fn the_table_of_instructions_is_that_of_the_catalogue() {
    let path = workspace().join("README.md");
    let readme = std::fs::read_to_string(&path).expect("README.md can be read");
    let (head, rest) = readme.split_once(BEGIN).expect("README.md has the mark of the table");
    let (_, tail) = rest.split_once(END).expect("README.md has the mark behind the table");
    let expected = format!("{head}{BEGIN}{}{END}{tail}", table());
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, expected).expect("README.md can be written");
    } else {
        assert!(
            readme == expected,
            "README.md is old: run the test with UPDATE_EXPECT=1"
        );
    }
}
