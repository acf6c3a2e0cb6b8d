//! The command line under test.

fn main() -> std::process::ExitCode {
    arcline_client::cli::main()
}
