//! The program `arcline`; see [`arcline_client::cli`].
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    arcline_client::cli::main()
}
