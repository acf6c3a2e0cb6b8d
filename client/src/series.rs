//! Series: moves of coordinate systems that are sent together (docs/spec/contract.md §4).

use arcline_instruction_set::MotionControl;
use arcline_proto::arcline::machine::{CLASS, INSTANCE, SeriesReply, service::EXECUTE_SERIES};
use arcline_proto::cip::{CipStatus, Request, join_multiple};
use arcline_proto::client as session;
use arcline_proto::epath::Epath;
use arcline_structured_text::{EvaluatedCall, Moves, MovesEnd};

use crate::motion::{name_missing_operand, request_of};
use crate::{Client, ClientError, Execution};

/// Bytes of a request in front of the moves: service, path and number of the moves.
const HEAD: usize = 16;
/// Bytes of an offset in front of each move.
const OFFSET: usize = 2;

impl Client {
    /// Executes the first moves of a series, as many as one request has room for, in their order up to the first that fails or finds no
    /// room. `None`: the server has no such service.
    ///
    /// # Errors
    /// The errors of the connection; after a timeout the caller does not know which moves have been executed.
    pub(crate) async fn execute_series(
        &self,
        moves: &[EvaluatedCall],
    ) -> Result<Option<Moves<Execution, ClientError>>, ClientError> {
        let failed = |error| {
            Ok(Some(Moves {
                executed: Vec::new(),
                end: MovesEnd::Failed(error),
            }))
        };
        let mut requests: Vec<Request> = Vec::with_capacity(moves.len());
        let mut length = HEAD;
        for (place, call) in moves.iter().enumerate() {
            match self.request_of_series(call, moves.get(place.wrapping_sub(1))).await {
                Ok(request) => {
                    length += OFFSET + request.to_bytes().map_err(session::ClientError::from)?.len();
                    if length > self.budget() && place > 0 {
                        break;
                    }
                    requests.push(request);
                }
                Err(error) if error.is_connection() => return Err(error),
                // The moves before it are sent first.
                Err(_) if place > 0 => break,
                Err(error) => return failed(error),
            }
        }
        let data = join_multiple(&requests).map_err(session::ClientError::from)?;
        let request = Request::new(EXECUTE_SERIES, Epath::object(CLASS, INSTANCE), data);
        let reply = self.request(request).await?;
        if reply.status.is(CipStatus::SERVICE_NOT_SUPPORTED) || reply.status.is(CipStatus::PATH_DESTINATION_UNKNOWN) {
            return Ok(None);
        }
        if !reply.status.is_success() {
            return failed(ClientError::refused("the series", reply.status));
        }
        let reply = SeriesReply::decode(&reply.data).ok_or(ClientError::Malformed {
            what: "the answer to a series is cut",
        })?;
        if reply.accepted.len() > requests.len() {
            return Err(ClientError::Malformed {
                what: "the answer to a series has more moves than the series",
            });
        }
        let end = match (reply.failed, moves.get(reply.accepted.len())) {
            (Some(failed), Some(call)) => {
                let refusal = self.refusal(call.mnemonic, &call.target, &failed).await;
                MovesEnd::Failed(name_missing_operand(refusal, call.mnemonic, &call.operands))
            }
            _ => match reply.full {
                Some(depth) => MovesEnd::NoRoom { depth: depth.into() },
                None => MovesEnd::Sent,
            },
        };
        let accepted = reply.accepted.iter().zip(moves);
        let executed = accepted.map(|(accepted, call)| Execution {
            mnemonic: call.mnemonic,
            target: call.target.clone(),
            tag: call.control.clone().unwrap_or_default(),
            instance: accepted.instance,
            control: MotionControl::from_bytes(accepted.control),
        });
        Ok(Some(Moves {
            executed: executed.collect(),
            end,
        }))
    }

    /// The request of a move; `before`: the move in front of it.
    async fn request_of_series(
        &self,
        call: &EvaluatedCall,
        before: Option<&EvaluatedCall>,
    ) -> Result<Request, ClientError> {
        let is_known = before.is_some_and(|before| (before.mnemonic, &before.target) == (call.mnemonic, &call.target));
        if !is_known {
            self.check_target(call.mnemonic, &call.target).await?;
        }
        let control = call.control.as_deref().unwrap_or_default();
        request_of(call.mnemonic, &call.target, control, &call.operands)
    }
}
