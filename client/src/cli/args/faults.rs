//! `fault` and its commands.

use clap::{Args, Subcommand};

use arcline_client::FaultKind;

use super::common::Axis;
use super::values::fault_parser;

#[derive(Subcommand, Debug)]
pub(crate) enum FaultCommand {
    /// Inject the cause of a fault into an axis; it stays until it is cleared
    #[command(after_help = "Example: arcline fault inject X overcurrent")]
    Inject(FaultInject),
    /// Remove injected causes and clear the faults of an axis (MAFR)
    #[command(
        after_help = "The axis is then stopped; `arcline servo on` enables it. MASR ends a shutdown.\n\
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
    /// The kind of fault
    #[arg(value_name = "KIND", value_parser = fault_parser())]
    pub(crate) kind: FaultKind,
}

#[derive(Args, Debug)]
pub(crate) struct FaultClear {
    #[command(flatten)]
    pub(crate) axis: Axis,
    /// The cause to remove; all causes by default
    #[arg(value_name = "KIND", value_parser = fault_parser())]
    pub(crate) kind: Option<FaultKind>,
}

#[derive(Args, Debug)]
pub(crate) struct FaultList {
    /// Axes; all by default
    #[arg(value_name = "AXIS")]
    pub(crate) axes: Vec<String>,
}
