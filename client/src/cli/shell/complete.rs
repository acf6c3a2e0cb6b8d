//! Completions within a line of the shell: commands, options and their values from the definition of the
//! arguments; operands and words of an instruction from the catalogue; names from the server.
//!
//! A pure function from a line and the known names to candidates. No terminal here.

use clap::{Arg, Command};

use arcline_client::{Mnemonic, Object, Tag, TagType};
use arcline_instruction_set::{FAULTS, Kind, Words, enumerations};
use arcline_tag::DataType;

/// Words that begin a line and are no command.
pub(super) const OWN: [&str; 2] = ["exit", "help"];
/// Operands that are hinted at a time.
const HINTED: usize = 4;
/// Deepest member that is offered.
const DEEPEST: usize = 6;

/// The names on the server, and the arguments of the commands.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) command: Command,
    pub(super) tags: Vec<Tag>,
}

/// The byte at which the candidates begin, and the candidates.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Found {
    pub(super) start: usize,
    pub(super) candidates: Vec<String>,
    /// A file name; the caller completes it.
    pub(super) is_file: bool,
}

impl Known {
    /// The candidates at the end of `line`, which is the text in front of the cursor.
    pub(super) fn complete(&self, line: &str) -> Found {
        match Call::of(line) {
            Some(call) => self.operand(&call),
            None => self.word(line),
        }
    }

    /// The operands that are still to come, at the end of a call: `MoveType, Position, …`.
    pub(super) fn hint(&self, line: &str) -> Option<String> {
        let call = Call::of(line)?;
        let operands = call.mnemonic.instruction().operands;
        let given = !call.text.trim().is_empty();
        let rest = operands
            .get(call.index + usize::from(given)..)
            .filter(|rest| !rest.is_empty())?;
        let mut names: Vec<String> = rest.iter().take(HINTED).map(|operand| operand.member()).collect();
        names.extend((rest.len() > HINTED).then(|| "…".to_owned()));
        Some(format!("{}{}", if given { ", " } else { "" }, names.join(", ")))
    }

    fn operand(&self, call: &Call<'_>) -> Found {
        let operand = call.mnemonic.instruction().operands.get(call.index);
        let candidates = match operand.map(|operand| &operand.kind) {
            Some(Kind::Target(object) | Kind::Object(object)) => self.objects(Some(*object)),
            Some(Kind::MotionControl) => self.of_type("MOTION_INSTRUCTION"),
            Some(Kind::Structure(name)) => self.of_type(name),
            Some(Kind::Word(words)) => keywords(words),
            Some(_) => self.paths(call.text.trim_start()),
            None => Vec::new(),
        };
        let text = call.text.trim_start();
        Found {
            start: call.end - text.len(),
            candidates: beginning(text, candidates),
            is_file: false,
        }
    }

    fn word(&self, line: &str) -> Found {
        let start = line.rfind(char::is_whitespace).map_or(0, |blank| blank + 1);
        let (before, word) = line.split_at(start);
        let mut words = before.split_whitespace();
        let Some(first) = words.next() else {
            return self.first(word);
        };
        let Some(mut command) = self.command.find_subcommand(first) else {
            return Found::none(start);
        };
        let (mut index, mut option) = (0, None);
        for word in words {
            if option.take().is_some() {
                continue;
            }
            if let Some(name) = word.strip_prefix("--") {
                option = command
                    .get_arguments()
                    .find(|arg| arg.get_long() == Some(name) && takes_value(arg));
            } else if let Some(child) = command.find_subcommand(word) {
                command = child;
            } else {
                index += 1;
            }
        }
        let mut candidates = Vec::new();
        let arg = match option {
            Some(option) => Some(option),
            None if word.starts_with('-') => {
                let longs = command
                    .get_arguments()
                    .chain(self.command.get_arguments())
                    .filter_map(Arg::get_long);
                candidates.extend(longs.map(|long| format!("--{long}")));
                None
            }
            None => {
                candidates.extend(command.get_subcommands().map(|child| child.get_name().to_owned()));
                let positionals: Vec<&Arg> = command.get_positionals().collect();
                let last = positionals.last().filter(|last| is_many(last)).copied();
                positionals.get(index).copied().or(last)
            }
        };
        let mut is_file = false;
        if let Some(arg) = arg {
            is_file = value_name(arg).contains("FILE") || arg.get_id() == "output";
            candidates.extend(self.values(arg, word));
        }
        Found {
            start,
            candidates: beginning(word, candidates),
            is_file,
        }
    }

    /// A command, or an instruction with its parenthesis.
    fn first(&self, word: &str) -> Found {
        let commands = self
            .command
            .get_subcommands()
            .map(|command| command.get_name().to_owned());
        let own = OWN.iter().map(|own| (*own).to_owned());
        let calls = Mnemonic::ALL.iter().map(|mnemonic| format!("{mnemonic}("));
        Found {
            start: 0,
            candidates: beginning(word, commands.chain(own).chain(calls).collect()),
            is_file: false,
        }
    }

    /// The values of an argument.
    fn values(&self, arg: &Arg, word: &str) -> Vec<String> {
        match arg.get_id().as_str() {
            "termination" => return keywords(&enumerations::TERMINATION_TYPE),
            "merge" if takes_value(arg) => return keywords(&enumerations::MERGE),
            _ => {}
        }
        let possible = arg.get_possible_values();
        if !possible.is_empty() {
            return possible.iter().map(|value| value.get_name().to_owned()).collect();
        }
        match value_name(arg).as_str() {
            "CS" => self.objects(Some(Object::CoordinateSystem)),
            "AXIS" => self.objects(Some(Object::Axis)),
            "NAME" => self.objects(None),
            "INSTRUCTION" => Mnemonic::ALL
                .iter()
                .map(|mnemonic| mnemonic.name().to_owned())
                .collect(),
            "TAG" => self.paths(word),
            "ERR[/EXERR]|FAULT|TAG" => {
                let faults = FAULTS.iter().map(|fault| fault.word.to_owned());
                faults.chain(self.paths(word)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The names of the objects of a kind, or of all of them.
    fn objects(&self, wanted: Option<Object>) -> Vec<String> {
        let tags = self.tags.iter();
        let objects = tags.filter(|tag| {
            tag.object()
                .is_some_and(|object| wanted.is_none_or(|wanted| wanted == object))
        });
        objects.map(|tag| tag.name.clone()).collect()
    }

    fn of_type(&self, name: &str) -> Vec<String> {
        let tags = self.tags.iter().filter(|tag| tag.type_name() == name);
        tags.map(|tag| tag.name.clone()).collect()
    }

    /// Tags, or the members of a complete tag name.
    fn paths(&self, text: &str) -> Vec<String> {
        let Some((front, _)) = text.rsplit_once('.') else {
            return self.tags.iter().map(|tag| tag.name.clone()).collect();
        };
        let members = self.members(front).unwrap_or_default();
        members.into_iter().map(|member| format!("{front}.{member}")).collect()
    }

    fn members(&self, path: &str) -> Option<Vec<String>> {
        let mut parts = path.split('.').take(DEEPEST);
        let name = without_index(parts.next()?);
        let tag = self.tags.iter().find(|tag| tag.name.eq_ignore_ascii_case(name))?;
        let TagType { data_type, .. } = &tag.tag_type;
        let mut data_type = data_type.clone();
        for part in parts {
            let DataType::Structure(template) = &data_type else {
                return None;
            };
            data_type = template.member(without_index(part))?.data_type.clone();
        }
        let DataType::Structure(template) = &data_type else {
            return None;
        };
        let shown = template.members.iter().filter(|member| !member.hidden);
        Some(shown.map(|member| member.name.clone()).collect())
    }
}

impl Found {
    fn none(start: usize) -> Self {
        Self {
            start,
            candidates: Vec::new(),
            is_file: false,
        }
    }
}

/// An instruction whose operands are being written.
struct Call<'l> {
    mnemonic: Mnemonic,
    /// The index of the operand at the end.
    index: usize,
    /// The text of it so far, with the blanks in front.
    text: &'l str,
    /// The end of the call in the line.
    end: usize,
}

impl<'l> Call<'l> {
    fn of(line: &'l str) -> Option<Self> {
        let end = line.len();
        let text = line
            .strip_prefix("exec ")
            .map_or(line, |rest| rest.trim_start().trim_start_matches(['\'', '"']));
        let (name, operands) = text.split_once('(')?;
        let mnemonic = name.trim().parse().ok()?;
        let (mut depth, mut index, mut start) = (0_i32, 0, 0);
        for (at, character) in operands.char_indices() {
            match character {
                '[' | '(' => depth += 1,
                ']' => depth -= 1,
                ')' if depth == 0 => return None,
                ')' => depth -= 1,
                ',' if depth == 0 => {
                    index += 1;
                    start = at + 1;
                }
                _ => {}
            }
        }
        let text = operands.get(start..)?;
        Some(Self {
            mnemonic,
            index,
            text,
            end,
        })
    }
}

fn keywords(words: &Words) -> Vec<String> {
    words.words.iter().map(|word| word.keyword()).collect()
}

fn without_index(part: &str) -> &str {
    part.split_once('[').map_or(part, |(name, _)| name)
}

fn takes_value(arg: &Arg) -> bool {
    arg.get_action().takes_values()
}

fn is_many(arg: &Arg) -> bool {
    arg.get_num_args().is_some_and(|count| count.max_values() > 1)
        || matches!(arg.get_action(), clap::ArgAction::Append)
}

fn value_name(arg: &Arg) -> String {
    let names = arg.get_value_names().unwrap_or_default();
    names.first().map(ToString::to_string).unwrap_or_default()
}

/// The candidates that begin with a text, case ignored, in order and once.
fn beginning(text: &str, candidates: Vec<String>) -> Vec<String> {
    let begins = |candidate: &String| {
        let front = candidate.get(..text.len());
        front.is_some_and(|front| front.eq_ignore_ascii_case(text))
    };
    let mut candidates: Vec<String> = candidates.into_iter().filter(begins).collect();
    candidates.sort_by_key(|candidate| candidate.to_ascii_lowercase());
    candidates.dedup();
    candidates
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_client::Access;
    use arcline_instruction_set::{instruction_tag_template, predefined};
    use arcline_tag::Elementary;

    fn known() -> Known {
        let tag = |name: &str, tag_type| Tag {
            name: name.to_owned(),
            instance: 1,
            tag_type,
            access: Access::ReadWrite,
        };
        let mut command = crate::cli::args::command();
        command.build();
        Known {
            command,
            tags: vec![
                tag("X", TagType::scalar(predefined::axis_cip_drive())),
                tag("Y", TagType::scalar(predefined::axis_virtual())),
                tag("CS1", TagType::scalar(predefined::coordinate_system())),
                tag("Motion", TagType::scalar(predefined::motion_group())),
                tag("M1", TagType::scalar(predefined::motion_instruction())),
                tag("Move1", TagType::scalar(instruction_tag_template(Mnemonic::Mclm))),
                tag("Recipe", TagType::array(Elementary::Real, 16)),
            ],
        }
    }

    #[test]
    fn words_that_fit_the_position_are_offered() {
        let known = known();
        #[rustfmt::skip]
        let cases: &[(&str, &str, &[&str])] = &[
            ("a command",                 "mov",                       &["move", "move-axis"]),
            ("an instruction",            "mcl",                       &["MCLM("]),
            ("a coordinate system",       "move ",                     &["CS1"]),
            ("an axis",                   "jog ",                      &["X", "Y"]),
            ("several axes",              "home X ",                   &["X", "Y"]),
            ("a word of the arguments",   "servo o",                   &["off", "on"]),
            ("an axis behind it",         "servo on ",                 &["X", "Y"]),
            ("an option",                 "move CS1 1,2 --te",         &["--termination"]),
            ("a word of an option",       "move CS1 1,2 --termination no", &["NoDecel", "NoSettle"]),
            ("a value without words",     "move CS1 1,2 --speed ",     &[]),
            ("behind a value",            "jog --accel 5 ",            &["X", "Y"]),
            ("a tag",                     "read m",                    &["M1", "Motion", "Move1"]),
            ("a member",                  "read X.ActualPos",          &["X.ActualPosition"]),
            ("a member of a member",      "read Move1.MotionControl.P", &["Move1.MotionControl.PC"]),
            ("no member",                 "read Recipe.",              &[]),
            ("a subcommand",              "fault i",                   &["inject"]),
            ("its axis",                  "fault inject ",             &["X", "Y"]),
            ("its fault",                 "fault inject X over",       &["overcurrent", "overspeed", "overtravel_negative", "overtravel_positive"]),
            ("a tag to explain",          "explain mov",               &["Move1"]),
            ("the instruction that erred", "explain 13/4 mcl",         &["MCLM"]),
            ("the target of a call",      "MCLM(",                     &["CS1"]),
            ("its control",               "MCLM(CS1, ",                &["M1"]),
            ("a word of an operand",      "MCLM(CS1, M1, ",            &["Absolute", "Incremental"]),
            ("an array",                  "mclm(CS1, M1, 0, Rec",      &["Recipe"]),
            ("behind an array",           "MCLM(CS1, M1, 0, [1,2,3], 5, un", &["UnitsperMasterUnit", "Unitspersec"]),
            ("a member as operand",       "MCLM(CS1, M1, 0, Move1.Pos", &["Move1.Position"]),
            ("in exec",                   "exec 'MSO(",                &["X", "Y"]),
            ("too many operands",         "MSO(X, M1, ",               &[]),
            ("behind the call",           "MSO(X, M1) ",               &[]),
            ("nonsense",                  "dance ",                    &[]),
        ];
        for (why, line, expected) in cases {
            let found = known.complete(line);
            assert_eq!(found.candidates, *expected, "{why}: {line}");
            let begun = line.get(found.start..);
            assert!(
                begun.is_some_and(|begun| found.candidates.iter().all(|one| one.len() >= begun.len())),
                "{why}: {line}: {found:?}"
            );
        }
        assert!(known.complete("run sq").is_file);
    }

    #[test]
    fn operands_to_come_are_hinted() {
        let known = known();
        for (line, expected) in [
            ("MSO(", Some("Axis, MotionControl")),
            ("MCLM(", Some("CoordinateSystem, MotionControl, MoveType, Position, …")),
            ("MSO(X", Some(", MotionControl")),
            ("MSO(X, ", Some("MotionControl")),
            ("MSO(X, M1", None),
            ("MSO(X, M1)", None),
            ("move CS1", None),
        ] {
            assert_eq!(known.hint(line).as_deref(), expected, "{line}");
        }
    }
}
