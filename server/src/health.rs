//! `health`: asks a server for its identity (List Identity), as the health check of a container does.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use arcline_proto::encap::{Command, EncapFrame, EncapStatus, FrameDecoder, SessionHandle};
use arcline_proto::identity::Identity;
use bytes::{Bytes, BytesMut};
use clap::Args;

use crate::cli::{Failure, print};

/// Flags of `health`.
#[derive(Args, Debug)]
pub(crate) struct HealthArgs {
    /// The address of the server.
    #[arg(long, value_name = "ADDR:PORT", default_value = "127.0.0.1:44818")]
    server: SocketAddr,
    /// Time within which the server must answer, s.
    #[arg(long, value_name = "SECONDS", default_value = "3", value_parser = crate::cli::seconds)]
    within: f64,
}

/// Prints the server's name; the exit code is 1 when the server does not answer.
pub(crate) fn run(args: &HealthArgs) -> Result<ExitCode, Failure> {
    let at = args.server;
    let within = Duration::try_from_secs_f64(args.within).unwrap_or(Duration::MAX);
    let identity = identity(at, within).map_err(|why| Failure::new(1, format!("{at}: {why}")))?;
    print(&format!("{at}  {}\n", identity.name()))
}

fn identity(at: SocketAddr, within: Duration) -> Result<Identity, String> {
    let began = Instant::now();
    let left = || {
        let left = within.saturating_sub(began.elapsed());
        if left.is_zero() {
            return Err(format!("no answer within {} s", within.as_secs_f64()));
        }
        Ok(left)
    };
    let failed = |error: std::io::Error| error.to_string();
    let mut stream = TcpStream::connect_timeout(&at, left()?).map_err(failed)?;
    let request = EncapFrame::request(Command::LIST_IDENTITY, SessionHandle::default(), [0; 8], Bytes::new());
    stream.write_all(&request.to_bytes()).map_err(failed)?;
    let mut received = BytesMut::new();
    let mut piece = [0; 512];
    loop {
        let frame = FrameDecoder::default().decode(&mut received);
        if let Some(frame) = frame.map_err(|error| error.to_string())? {
            if frame.header.command != Command::LIST_IDENTITY || frame.header.status != EncapStatus::SUCCESS {
                return Err(frame.header.status.to_string());
            }
            let identity = Identity::decode_list(&frame.data).map(|(_, identity)| identity);
            return identity.ok_or_else(|| "the answer to List Identity is malformed".to_owned());
        }
        stream.set_read_timeout(Some(left()?)).map_err(failed)?;
        match stream.read(&mut piece) {
            Ok(0) => return Err("it closed the connection without an answer".to_owned()),
            Ok(length) => received.extend_from_slice(&piece[..length]),
            // The time is over, which `left` says.
            Err(error)
                if matches!(
                    error.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                ) => {}
            Err(error) => return Err(failed(error)),
        }
    }
}
