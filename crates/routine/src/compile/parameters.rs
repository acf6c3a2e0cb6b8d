//! The connections of the parameters of programs: rungs that copy Input parameters before the scan of their program, and Output parameters
//! behind it (spec/programs.md §8).

use arcline_tag::DataType;

use super::reference::Found;
use super::{Compiler, Owner};
use crate::code::{Body, Routine, Rung};
use crate::error::{Finding, FindingKind};
use crate::expression::Expression;
use crate::rll;
use crate::source::Connection;

impl Compiler<'_> {
    pub(super) fn connections(&mut self) {
        let project = self.project;
        for (number, program) in project.programs.iter().enumerate() {
            for is_before in [true, false] {
                let of_program = project
                    .connections
                    .iter()
                    .filter(|one| one.is_before == is_before && one.program.eq_ignore_ascii_case(&program.name));
                let mut rungs = Vec::new();
                for (place, connection) in of_program.enumerate() {
                    if let Some(rung) = self.copy(connection, place as u32) {
                        rungs.push(rung);
                    }
                }
                if rungs.is_empty() {
                    continue;
                }
                let id = self.code.routines.len() as u32;
                let (name, of) = (self.text("(connections)"), self.text(&program.name));
                self.code.routines.push(Routine {
                    name,
                    program: of,
                    of_program: u32::try_from(number).ok(),
                    first_step: None,
                    body: Body::Ladder(rungs.into()),
                });
                if let Some(program) = self.code.programs.get_mut(number) {
                    let routine = if is_before {
                        &mut program.before
                    } else {
                        &mut program.behind
                    };
                    *routine = Some(id);
                }
            }
        }
    }

    /// The rung of a connection, whose ends stand in the controller's scope.
    fn copy(&mut self, connection: &Connection, number: u32) -> Option<Rung> {
        (self.owner, self.is_text, self.place) = (Owner::Program(usize::MAX), false, None);
        self.routine.clear();
        let Connection { from, to, .. } = connection;
        let text = self.copy_text(from, to);
        let rung = text.and_then(|text| rll::Rung::parse(&text).map_err(|error| error.to_string()));
        match rung {
            Ok(rung) => Some(Rung::new(number, self.nodes(&rung.elements))),
            Err(reason) => {
                let reason = format!("its connection with {from} does not take place: {reason}");
                self.findings.push(Finding::new(FindingKind::Tag, to, reason));
                None
            }
        }
    }

    fn copy_text(&mut self, from: &str, to: &str) -> Result<String, String> {
        let mut found = |text: &str| {
            let reference = Expression::parse_reference(text).map_err(|error| error.to_string())?;
            self.resolve(&reference)
        };
        let (source, destination) = (found(from)?, found(to)?);
        let is_number = |found: &Found| matches!(found.data_type, DataType::Elementary(_)) && !found.is_array();
        Ok(match (source.as_bit(), destination.as_bit()) {
            (Some(_), Some(_)) => format!("XIC({from})OTE({to});"),
            (None, None) if is_number(&source) && is_number(&destination) => format!("MOVE({from},{to});"),
            (None, None) if source.area().data_type == destination.area().data_type => {
                let sizes: Vec<u32> = destination.dimensions.into_iter().filter(|size| *size > 0).collect();
                let first = match sizes.len() {
                    0 => String::new(),
                    count => format!("[{}]", vec!["0"; count].join(",")),
                };
                format!("COP({from}{first},{to}{first},{});", sizes.iter().product::<u32>())
            }
            _ => return Err("their types differ".to_owned()),
        })
    }
}
