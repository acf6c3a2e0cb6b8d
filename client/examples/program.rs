//! Runs a Structured Text program on the server's machine: `cargo run -p arcline-client --example program -- 127.0.0.1`.

use arcline_client::{Client, Event, ProgramError, Runner};

/// Two lines with a blend between them, then a wait for the end of the second.
const PROGRAM: &str = "
MCLM(CS1, M1, Absolute, [0, 20, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2,
     Trapezoidal, 100, 100, %ofTime, CommandTolerance);
MCLM(CS1, M2, Absolute, [20, 20, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2,
     Trapezoidal, 100, 100, %ofTime, ActualTolerance);
WAIT(M2.PC);
";

#[tokio::main]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let server = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1".to_owned());
    let client = Client::connect(&server).await?;
    run(&client).await?;
    client.close().await;
    Ok(())
}

/// Prints the events of the program; returns the number of instructions that it executed.
pub(crate) async fn run(client: &Client) -> Result<usize, ProgramError> {
    let mut executed = 0;
    let mut print = |event: Event<'_>| {
        executed += usize::from(matches!(event, Event::Executed { .. }));
        println!("{event:?}");
    };
    let mut runner = Runner::program(client, PROGRAM).await?;
    runner.run(&mut print).await?;
    runner.finish(&mut print).await?;
    Ok(executed)
}
