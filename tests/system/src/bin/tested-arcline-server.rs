//! The server under test.

fn main() -> std::process::ExitCode {
    arcline_server::main()
}
