//! Arcline as an FMU of FMI 3.0, for co-simulation: a machine with one program, on the virtual clock, stepped by another simulator.
//!
//! [`description`] makes the variables and `modelDescription.xml` from a configuration, [`instance`] is a machine that runs, [`abi`] the C interface.
//! Unsafe code is in [`abi`] only. Times are in seconds.

pub mod abi;
pub mod description;
pub mod instance;
