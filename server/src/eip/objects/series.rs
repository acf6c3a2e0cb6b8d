//! Execute Series, a service of the Machine: moves of coordinate systems, sent together and executed in their order (docs/spec/contract.md §4).

use arcline_controller::image::Image;
use arcline_proto::arcline::machine::{self, SeriesReply};
use arcline_proto::cip::{self, CipStatus, Reply};

use super::motion::{self, MotionRequest, accepted};
use crate::eip::action::{Action, ParsedRequest};
use crate::eip::context::Context;
use crate::plant::{LONGEST_SERIES, SeriesEnd};

/// Moves that a client asks to execute one after the other.
#[derive(Debug)]
pub(crate) struct SeriesRequest {
    service: u8,
    /// The moves in front of the first unreadable one.
    moves: Vec<MotionRequest>,
    /// The reply to that one.
    unreadable: Option<Reply>,
}

/// Reads the data of the service: as many moves as are executed at a time, and as the reply has room for.
///
/// # Errors
/// 0x08 on the class, 0x05 for an instance there is not, and the statuses of a Multiple Service Packet.
pub(crate) fn parse(
    context: &Context<'_>,
    image: &Image,
    parsed: &ParsedRequest<'_>,
) -> Result<SeriesRequest, CipStatus> {
    match parsed.target.instance {
        None | Some(0) => return Err(CipStatus::SERVICE_NOT_SUPPORTED),
        Some(machine::INSTANCE) => {}
        Some(_) => return Err(crate::eip::status::unknown()),
    }
    let room = SeriesReply::room(context.budget).min(LONGEST_SERIES);
    if room == 0 {
        return Err(CipStatus::REPLY_TOO_LARGE);
    }
    let mut series = SeriesRequest {
        service: parsed.request.service,
        moves: Vec::with_capacity(room),
        unreadable: None,
    };
    for request in cip::split_multiple(&parsed.request.data)?.iter().take(room) {
        let read = request.as_ref().map_err(|error| error.reply()).and_then(|request| {
            let refuse = |status| Reply::error(request.service, status);
            let parsed = ParsedRequest::new(request, context.device.objects);
            match parsed.action {
                Action::Motion => motion::parse(context, image, request, &parsed.target).map_err(refuse),
                Action::Refused(status) => Err(refuse(status)),
                _ => Err(refuse(CipStatus::SERVICE_NOT_SUPPORTED)),
            }
        });
        match read {
            Ok(request) => series.moves.push(request),
            Err(reply) => {
                series.unreadable = Some(reply);
                break;
            }
        }
    }
    Ok(series)
}

impl SeriesRequest {
    /// Executes the moves and waits until they are verified.
    pub(crate) async fn execute(self, context: &Context<'_>) -> Reply {
        let plant = &context.device.plant;
        let moves = self.moves.iter().map(|request| (context.principal, request.call()));
        let outcome = plant.execute_series(&moves.collect::<Vec<_>>()).await;
        let next = self.moves.get(outcome.executed.len());
        let (mut full, mut failed) = (None, None);
        match (outcome.end, next) {
            (SeriesEnd::Sent, None) => failed = self.unreadable,
            (SeriesEnd::Erred(control), Some(next)) => failed = Some(next.erred(&control)),
            (SeriesEnd::Refused(refused), Some(next)) => failed = Some(next.refused(&refused)),
            (SeriesEnd::NoRoom { system }, _) => {
                let depth = plant
                    .machine()
                    .systems
                    .get(usize::from(system))
                    .map_or(0, |system| system.queue_depth);
                full = Some(u16::try_from(depth).unwrap_or(u16::MAX));
            }
            (SeriesEnd::Sent, Some(_)) | (SeriesEnd::Erred(_) | SeriesEnd::Refused(_), None) => {}
        }
        let reply = SeriesReply {
            accepted: outcome.executed.iter().map(accepted).collect(),
            full,
            failed,
        };
        Reply::success(self.service, reply.to_bytes())
    }
}
