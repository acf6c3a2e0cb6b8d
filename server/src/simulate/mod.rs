//! `simulate`: a program, or the tasks of a project (`cell`), on the controller with a virtual clock, in one thread, as fast as it goes.
//!
//! No network, no real clock: the tick is the only time, so two runs give the same bytes. A tick does nothing but
//! tick the controller, unless an event came or the program has work to do.

mod args;
mod batch;
mod cell;
mod output;
mod outside;
mod pieces;
mod summary;

use std::io::{self, BufReader, BufWriter};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use arcline_cases::Outcome;
use arcline_simulation::{End, Options, Refused, Runner};
use arcline_structured_text::{Interpreter, RunError};

use crate::cli::{Failure, read};
pub(crate) use args::SimulateArgs;
pub(crate) use cell::findings;
use output::Files;
use outside::Outside;
use pieces::Pieces;
use summary::Summary;

/// Runs a program to its end, or many cases.
pub(crate) fn simulate(args: &SimulateArgs) -> Result<ExitCode, Failure> {
    if let Some(cases) = &args.batch.cases {
        return batch::run(args, cases);
    }
    if is_l5x(args.program()) {
        return cell::simulate(args);
    }
    if let Some(flag) = args.of_projects() {
        return Err(Failure::usage(format!("{flag} is for projects (.L5X)")));
    }
    args.check_step()?;
    let began = Instant::now();
    let (text, name) = read(args.config.as_deref())?;
    let invalid = |error: arcline_cases::Invalid| Failure::usage(error.to_string());
    let prepared = arcline_cases::prepared(&text, &name, &args.sets()?).map_err(invalid)?;
    let machine = prepared.machine.clone();
    let file = args.program().display();
    let mut pieces = if args.lines {
        Pieces::of_lines(args.program())?
    } else {
        Pieces::whole(args.program())?
    };
    let program = pieces.hash().filter(|_| args.json);
    let first = pieces
        .next(&prepared.image)?
        .map_or_else(Interpreter::empty, |piece| piece.interpreter);
    let mut files = Files::create(args, &machine)?;
    let options = Options {
        until: args.seconds()?,
        policy: args.policy(),
    };
    let simulation = if args.step {
        let outside = Outside::new(
            &machine,
            Box::new(BufReader::new(io::stdin())),
            Box::new(BufWriter::new(io::stdout())),
        );
        files.outside = Some(outside.reason());
        let axes = outside.axes();
        prepared.simulation_with(Box::new(outside), &axes)
    } else {
        prepared.simulation()
    };
    let mut runner = Runner::of(simulation.map_err(invalid)?);
    let end = runner.run_pieces(first, options, &mut files, |image| pieces.next(image));
    let measures = files.measures.take();
    let outside = files.outside.take().and_then(|reason| reason.take());
    let mut summary = files.finish(args)?;
    let simulation = runner.simulation();
    summary.stopped = simulation.stopped();
    summary.executed = simulation.executed();
    eprint!(
        "{}",
        summary.text(&file.to_string(), &machine, matches!(end, Ok(End::Finished)))
    );
    let end = end?;
    if let Some(why) = outside {
        return Err(Failure::new(2, why));
    }
    if let Some(measures) = measures {
        let outcome = Outcome {
            instructions: Some(simulation.executed()),
            seed: Some(args.seed.unwrap_or_default()),
            program,
            config: Some(prepared.hash.clone()),
            wall_s: Some(began.elapsed().as_secs_f64()),
            ..Outcome::of(&end, &measures, &machine)
        };
        crate::cli::print(&format!("{}\n", outcome.line()))?;
    }
    match end {
        End::Finished => Ok(ExitCode::SUCCESS),
        End::Erred(error) => Err(Failure::new(1, format!("{file}: {error}"))),
        End::Wrong(
            error @ (RunError::Hopeless(_)
            | RunError::Driver {
                error: Refused::Still, ..
            }),
        ) => Err(Failure::new(1, format!("{file}: {error}"))),
        End::Wrong(error) => Err(Failure::new(2, format!("{file}: {error}"))),
        End::TooLong(seconds) => Err(Failure::new(
            3,
            format!("{file}: not at its end after {seconds} s of simulated time (--until)"),
        )),
        // Files take everything, and a plant that left has said why.
        End::Left => Ok(ExitCode::SUCCESS),
    }
}

/// Whether a program is a project of a controller.
fn is_l5x(program: &Path) -> bool {
    program
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("l5x"))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(2, format!("{}: cannot be written: {error}", path.display()))
}
