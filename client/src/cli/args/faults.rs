//! `fault` and its commands.

use clap::{Args, Subcommand};

use arcline_client::FaultKind;

use super::common::Axis;
use super::values::fault_parser;

#[derive(Subcommand, Debug)]
pub(crate) enum FaultCommand {
    /// Put the cause of a fault on an axis; it is there until it is cleared
    #[command(after_help = "Example: arcline fault inject X overcurrent")]
    Inject(FaultInject),
    /// Take injected causes away and clear the faults of an axis (MAFR)
    #[command(
        after_help = "A faulted axis is then stopped: servo on. One that is shut down stays so: MASR.\n\
        Example: arcline fault clear X"
    )]
    Clear(FaultClear),
    /// Show the faults of axes
    #[command(after_help = "Example: arcline fault list")]
    List(FaultList),
}

#[derive(Args, Debug)]
pub(crate) struct FaultInject {
    #[command(flatten)]
    pub(crate) axis: Axis,
    /// Which fault
    #[arg(value_name = "KIND", value_parser = fault_parser())]
    pub(crate) kind: FaultKind,
}

#[derive(Args, Debug)]
pub(crate) struct FaultClear {
    #[command(flatten)]
    pub(crate) axis: Axis,
    /// The cause that is taken away; all of them unless given
    #[arg(value_name = "KIND", value_parser = fault_parser())]
    pub(crate) kind: Option<FaultKind>,
}

#[derive(Args, Debug)]
pub(crate) struct FaultList {
    /// Axes; all of them unless given
    #[arg(value_name = "AXIS")]
    pub(crate) axes: Vec<String>,
}
