//! The message router: one CIP message in, one reply out.
//!
//! The router knows the object of a path and the order of actions. The actions themselves are in [`tags`](super::tags), in
//! [`objects`](super::objects), and for instructions in the plant. Every request gets a reply.

use std::net::SocketAddrV4;
use std::sync::Arc;
use std::time::Duration;

use arcline_proto::arcline::machine;
use arcline_proto::cip::{self, CipStatus, MultipleReplies, REPLY_HEAD, Reply, Request, class, service};
use arcline_proto::session::Transport;
use tokio::time::Instant;
use tracing::{debug, debug_span};

use super::action::{Action, ParsedRequest};
use super::context::{Context, Memory};
use super::device::Device;
use super::objects::motion::{self, MotionRequest};
use super::objects::series::{self, SeriesRequest};
use super::objects::{self, Access, Object, ObjectContext};
use super::tags;
use super::turns::SHORT;
use crate::plant::Principal;
use crate::retained::NotPersisted;

/// The longest work on a packet of requests before other connections have their turn.
const TURN: Duration = Duration::from_micros(500);

/// Routes the messages of one connection.
pub(crate) struct Router {
    device: Arc<Device>,
    local: SocketAddrV4,
    /// The session's number.
    session: u64,
}

/// A request that has been answered from memory, or one that cannot be while the memory is held.
enum Step<'p, 'r> {
    Done(Reply),
    /// Executes an instruction.
    Motion(MotionRequest),
    /// Executes a series of moves.
    Series(SeriesRequest),
    /// Asks an object for which the memory must not be held.
    Late(&'static dyn Object, &'p ParsedRequest<'r>),
}

impl Router {
    pub(crate) fn new(device: Arc<Device>, local: SocketAddrV4, session: u64) -> Self {
        Self { device, local, session }
    }

    /// Answers a message within `budget` bytes.
    pub(crate) async fn handle(&self, request: &Request, budget: usize, transport: Transport) -> Reply {
        let reply = if is_multiple(request) {
            self.multiple(request, budget, transport).await
        } else {
            self.single(request, budget, transport).await
        };
        if !reply.status.is_success() {
            debug_span!("request", service = request.service).in_scope(|| debug!(status = %reply.status, "refused"));
        }
        reply
    }

    /// Whether a message is a stop, or a short packet with one. The server processes such a message without delay.
    pub(crate) fn is_stop(&self, message: &Request) -> bool {
        if message.data.len() > SHORT {
            return false;
        }
        let context = self.context(0, Transport::Unconnected);
        let plant = &self.device.plant;
        let is_one = |request: &Request| {
            let parsed = ParsedRequest::new(request, self.device.objects);
            match parsed.action {
                Action::Motion => {
                    plant.with_published(|image| motion::is_stop(&context, image, request, &parsed.target))
                }
                Action::WriteTag(_) => plant.with_published(|image| tags::is_of_stop(image, &parsed.target)),
                Action::Object(..) => {
                    parsed.target.class == Some(machine::CLASS) && request.service == machine::service::STOP
                }
                Action::ReadTag(_) | Action::Named(_) | Action::Refused(_) => false,
            }
        };
        if !is_multiple(message) {
            return is_one(message);
        }
        let requests = cip::split_multiple(&message.data).unwrap_or_default();
        requests.iter().flatten().any(is_one)
    }

    async fn single(&self, request: &Request, budget: usize, transport: Transport) -> Reply {
        let parsed = ParsedRequest::new(request, self.device.objects);
        let context = self.context(budget, transport);
        let mut step = None;
        let kept = self
            .with_memory(context.principal, parsed.action.writes(), |memory| {
                step = Some(answer(&context, memory, &parsed));
            })
            .await;
        let reply = match step {
            Some(step) => self.finish(step, &parsed, kept, &context).await,
            None => Reply::error(request.service, CipStatus::RESOURCE_UNAVAILABLE),
        };
        self.count(&parsed, &reply);
        reply
    }

    fn count(&self, parsed: &ParsedRequest<'_>, reply: &Reply) {
        // Part of a value is an answer.
        let is_done = reply.status.is_success() || reply.status.is(CipStatus::PARTIAL_TRANSFER);
        self.device.plant.count_request(parsed.action.request_kind(), is_done);
    }

    /// A write succeeds only if the file of the retained state has it.
    async fn finish(
        &self,
        step: Step<'_, '_>,
        parsed: &ParsedRequest<'_>,
        kept: Result<(), NotPersisted>,
        context: &Context<'_>,
    ) -> Reply {
        match step {
            Step::Done(reply) if reply.status.is_success() && parsed.action.must_be_kept() && kept.is_err() => {
                Reply::error(reply.service, CipStatus::STORE_FAILURE)
            }
            Step::Done(reply) => reply,
            Step::Motion(motion) => motion.execute(&self.device.plant, context.principal).await,
            Step::Series(series) => series.execute(context).await,
            Step::Late(object, parsed) => self.device.plant.with_image(|image| {
                let memory = Memory::Read(image);
                objects::serve(object, object_context(context, memory, parsed))
            }),
        }
    }

    /// A Multiple Service Packet: reads and writes in their order and at one instant, then the edges, then the motion
    /// services in their order.
    async fn multiple(&self, packet: &Request, budget: usize, transport: Transport) -> Reply {
        let refuse = |status| Reply::error(packet.service, status);
        let requests = match cip::split_multiple(&packet.data) {
            Ok(requests) => requests,
            Err(status) => return refuse(status),
        };
        let mut replies = match MultipleReplies::new(requests.len(), budget) {
            Ok(replies) => replies,
            Err(status) => return refuse(status),
        };
        let parse = |request| ParsedRequest::new(request, self.device.objects);
        let parsed: Vec<_> = requests.iter().map(|request| request.as_ref().map(parse)).collect();
        // Room for the motion services and their executions, which are answered last.
        let late = parsed.iter().flatten().filter(|parsed| parsed.action.is_late()).count();
        let mut room = replies.budget().saturating_sub(late * motion::REPLY_DATA);
        let writes = parsed.iter().flatten().any(|parsed| parsed.action.writes());
        // If no request of the packet waits, each reply goes into the packet as soon as it exists.
        let at_once = late == 0 && !writes;
        let mut steps = Vec::with_capacity(if at_once { 0 } else { requests.len() });
        let kept = self
            .with_memory(self.context(room, transport).principal, writes, |memory| {
                if let Memory::Write(transaction) = memory {
                    transaction.of_packet();
                }
                for parsed in &parsed {
                    let context = self.context(room, transport);
                    let step = match parsed {
                        Ok(parsed) => answer(&context, memory, parsed),
                        Err(error) => Step::Done(error.reply()),
                    };
                    if let Step::Done(reply) = &step
                        && reply.len() <= room
                    {
                        room -= reply.len() - REPLY_HEAD;
                    }
                    match step {
                        Step::Done(reply) if at_once => {
                            if let Ok(parsed) = parsed {
                                self.count(parsed, &reply);
                            }
                            replies.push(&reply);
                        }
                        step => steps.push(step),
                    }
                }
            })
            .await;
        let mut began = Instant::now();
        for (step, parsed) in steps.into_iter().zip(&parsed) {
            if began.elapsed() >= TURN {
                // The others have their turn.
                tokio::task::yield_now().await;
                began = Instant::now();
            }
            let context = self.context(replies.budget(), transport);
            let reply = match (parsed, step) {
                (Ok(parsed), step) => {
                    let reply = self.finish(step, parsed, kept, &context).await;
                    self.count(parsed, &reply);
                    reply
                }
                (Err(error), _) => error.reply(),
            };
            replies.push(&reply);
        }
        replies.finish()
    }

    /// Runs `work` on the tag memory, for writing only if it may write, and waits for the instructions and writes that it began.
    ///
    /// # Errors
    /// The tags have the written values, but may not have them after a restart.
    async fn with_memory(
        &self,
        principal: Principal,
        writes: bool,
        work: impl FnOnce(&mut Memory<'_, '_>),
    ) -> Result<(), NotPersisted> {
        let plant = &self.device.plant;
        if writes {
            let ((), pending) = plant.transact(principal, |transaction| work(&mut Memory::Write(transaction)));
            plant.complete(pending).await
        } else {
            plant.with_image(|image| work(&mut Memory::Read(image)));
            Ok(())
        }
    }

    fn context(&self, budget: usize, transport: Transport) -> Context<'_> {
        Context {
            device: &self.device,
            local: self.local,
            budget,
            transport,
            principal: Principal::Client {
                session: self.session,
                connection: match transport {
                    Transport::Unconnected => 0,
                    Transport::Connected(id) => id.0,
                },
            },
        }
    }
}

fn is_multiple(request: &Request) -> bool {
    request.service == service::MULTIPLE_SERVICE_PACKET && request.path.is_object(class::MESSAGE_ROUTER, 1)
}

/// Answers one request that is no packet of requests.
fn answer<'p, 'r>(context: &Context<'_>, memory: &mut Memory<'_, '_>, parsed: &'p ParsedRequest<'r>) -> Step<'p, 'r> {
    let ParsedRequest {
        request,
        target,
        action,
    } = parsed;
    Step::Done(match *action {
        Action::Refused(status) => Reply::error(request.service, status),
        Action::ReadTag(how) => tags::read(context, memory.image(), request, target, how),
        Action::WriteTag(how) => tags::write(memory.reborrow(), request, target, how),
        Action::Motion => match motion::parse(context, memory.image(), request, target) {
            Ok(motion) => return Step::Motion(motion),
            Err(status) => Reply::error(request.service, status),
        },
        Action::Object(_, Access::Series) => match series::parse(context, memory.image(), parsed) {
            Ok(series) => return Step::Series(series),
            Err(status) => Reply::error(request.service, status),
        },
        Action::Object(object, Access::Late) => return Step::Late(object, parsed),
        Action::Object(object, Access::Read | Access::Set | Access::Change) => {
            objects::serve(object, object_context(context, memory.reborrow(), parsed))
        }
        Action::Named(_) => objects::serve_named(context, memory.reborrow(), request, target),
    })
}

fn object_context<'a, 't>(
    context: &'a Context<'a>,
    memory: Memory<'a, 't>,
    parsed: &'a ParsedRequest<'_>,
) -> ObjectContext<'a, 't> {
    ObjectContext {
        context,
        memory,
        request: parsed.request,
        target: &parsed.target,
    }
}
