//! The program `arcline-server`; see the library of the same package.

use std::process::ExitCode;

fn main() -> ExitCode {
    arcline_server::main()
}
