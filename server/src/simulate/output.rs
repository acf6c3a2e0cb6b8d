//! The files of a simulation.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use arcline_cases::{Measures, TraceFile};
use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Controller, Event, FaultChange};
use arcline_simulation::{Observer, Record};

use super::outside::Reason;
use super::{SimulateArgs, Summary, cannot_write};
use crate::cli::Failure;

/// The outputs of a simulation.
pub(super) struct Files {
    pub(super) trace: Option<TraceFile>,
    pub(super) events: Option<Record>,
    pub(super) faults: Option<Record>,
    pub(super) summary: Summary,
    /// The measures for --json.
    pub(super) measures: Option<Measures>,
    /// The reason for which the plant of --step cannot go on.
    pub(super) outside: Option<Reason>,
}

impl Files {
    /// Creates the files of the command line.
    ///
    /// # Errors
    /// A file that cannot be created, or more than one to standard output.
    pub(super) fn create(args: &SimulateArgs, machine: &Machine) -> Result<Self, Failure> {
        let create = |path: &Path| open(path).map_err(|error| cannot_write(path, &error));
        let outputs = [&args.trace, &args.events, &args.faults, &args.tags];
        let to_output = outputs.into_iter().flatten().filter(|path| is_standard_output(path));
        if to_output.count() + usize::from(args.json) > 1 {
            return Err(Failure::usage(
                "only one of --trace, --events, --faults, --tags and --json can be written to standard output",
            ));
        }
        let trace = |path: &PathBuf| {
            let file = TraceFile::create(path, machine, &args.signals, args.every);
            file.map_err(|error| Failure::usage(error.to_string()))
        };
        Ok(Files {
            trace: args.trace.as_ref().map(trace).transpose()?,
            events: args.events.as_deref().map(create).transpose()?,
            faults: args.faults.as_deref().map(create).transpose()?,
            summary: Summary::default(),
            measures: args.json.then(Measures::default),
            outside: None,
        })
    }

    /// Ends the files and returns the summary of the run. It takes the measures first.
    ///
    /// # Errors
    /// A file that could not be written.
    pub(super) fn finish(self, args: &SimulateArgs) -> Result<Summary, Failure> {
        if let (Some(trace), Some(path)) = (self.trace, &args.trace) {
            trace.finish().map_err(|error| cannot_write(path, &error))?;
        }
        let outputs = [(self.events, &args.events), (self.faults, &args.faults)];
        for (output, path) in outputs {
            if let (Some(output), Some(path)) = (output, path) {
                output.finish().map_err(|error| cannot_write(path, &error))?;
            }
        }
        Ok(self.summary)
    }
}

impl Observer for Files {
    fn needs_every_tick(&self) -> bool {
        self.trace.is_some() || self.measures.is_some() || self.outside.is_some()
    }

    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        if let Some(trace) = &mut self.trace {
            trace.tick(tick, machine, controller);
        }
        if let Some(measures) = &mut self.measures {
            measures.tick(tick, controller);
        }
        self.summary.tick(tick, machine, controller);
        !self.outside.as_ref().is_some_and(Reason::is_given)
    }

    fn fault(&mut self, change: &FaultChange, time: f64, machine: &Machine) {
        if let Some(measures) = &mut self.measures {
            measures.fault(change, time, machine);
        }
        let axis = machine.axes.get(usize::from(change.axis));
        let axis = axis.map_or("", |axis| axis.name.as_str());
        self.summary.fault(change, time, axis);
        if let Some(faults) = &mut self.faults {
            faults.fault(change, time, axis);
        }
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        if let Some(events) = &mut self.events {
            events.event(event, time, image.control_name(event.control));
        }
    }
}

fn open(path: &Path) -> io::Result<Record> {
    let file: Box<dyn Write + Send> = if is_standard_output(path) {
        Box::new(io::stdout())
    } else {
        Box::new(File::create(path)?)
    };
    Ok(Record::new(file))
}

/// Whether a file is standard output.
pub(super) fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}
