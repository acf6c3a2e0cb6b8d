//! The message router: one CIP message in, one reply out.
//!
//! It knows which object a path means and in which order things happen, not what they do: tags are
//! [`tags`](super::tags)'s, objects [`objects`](super::objects)'s, instructions the plant's. Every request gets a reply.

use std::net::SocketAddrV4;
use std::sync::Arc;
use std::time::{Duration, Instant};

use arcline_controller::image::Image;
use arcline_proto::cip::{self, CipStatus, MultipleReplies, REPLY_HEAD, Reply, Request, class, service};
use arcline_proto::epath::{Segment, Target};
use arcline_proto::session::Transport;
use tracing::{debug, debug_span};

use super::adapter::Adapter;
use super::device::Device;
use super::objects::motion::{self, MotionRequest};
use super::{objects, tags};
use crate::plant::{Principal, Transaction};
use crate::retained::NotKept;

/// How long a packet of requests is worked on before others have their turn.
const TURN: Duration = Duration::from_micros(500);

/// Routes the messages of one connection.
pub(crate) struct Router {
    device: Arc<Device>,
    local: SocketAddrV4,
    /// The session's number.
    session: u64,
}

/// What a request needs to be answered.
pub(crate) struct Context<'a> {
    /// The device.
    pub(crate) device: &'a Device,
    /// The local end of the connection.
    pub(crate) local: SocketAddrV4,
    /// The longest reply, bytes with its head.
    pub(crate) budget: usize,
    /// What the message came on.
    pub(crate) transport: Transport,
    /// Who asks, and owns the motion that begins.
    pub(crate) principal: Principal,
}

impl Context<'_> {
    /// The host's adapter through which the message came.
    pub(crate) fn adapter(&self) -> Arc<Adapter> {
        self.device.adapters.of(*self.local.ip())
    }
}

/// The tag memory as one message sees it.
pub(crate) enum Memory<'a, 't> {
    /// Nothing is written.
    Read(&'a Image),
    /// Something may be written.
    Write(&'a mut Transaction<'t>),
}

impl Memory<'_, '_> {
    /// For reading.
    pub(crate) fn image(&self) -> &Image {
        match self {
            Self::Read(image) => image,
            Self::Write(transaction) => transaction.image(),
        }
    }
}

/// A request that has been answered from memory, or one that cannot be while the memory is held.
enum Step<'r> {
    Done(Reply),
    /// Executes an instruction.
    Motion(MotionRequest),
    /// Asks an object for which the memory must not be held.
    Late(&'r Request, Target<'r>),
}

impl<'r> Step<'r> {
    /// A write that is not kept does not succeed.
    fn unless(self, kept: Result<(), NotKept>, request: &Request) -> Step<'r> {
        match (self, kept) {
            (Self::Done(reply), Err(NotKept))
                if reply.status.is_success()
                    && (tags::is_write(request.service) || objects::is_table_change(request.service)) =>
            {
                Self::Done(Reply::error(request.service, CipStatus::STORE_FAILURE))
            }
            (step, _) => step,
        }
    }
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

    async fn single(&self, request: &Request, budget: usize, transport: Transport) -> Reply {
        let context = self.context(budget, transport);
        let mut step = None;
        let kept = self
            .with_memory(context.principal, may_write(request), |memory| {
                step = Some(answer(&context, memory, request))
            })
            .await;
        match step {
            Some(step) => self.finish(step.unless(kept, request), &context).await,
            None => Reply::error(request.service, CipStatus::RESOURCE_UNAVAILABLE),
        }
    }

    async fn finish(&self, step: Step<'_>, context: &Context<'_>) -> Reply {
        match step {
            Step::Done(reply) => reply,
            Step::Motion(motion) => motion.execute(&self.device.plant, context.principal).await,
            Step::Late(request, target) => objects::serve_late(context, request, &target),
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
        // Kept for the motion services and their executions, which are answered last.
        let late = requests.iter().flatten().filter(|request| is_late(request)).count();
        let mut room = replies.budget().saturating_sub(late * motion::REPLY_DATA);
        let writes = requests.iter().flatten().any(may_write);
        // Where nothing is waited for, a reply goes into the packet as soon as it is there.
        let at_once = late == 0 && !writes;
        let mut steps = Vec::with_capacity(if at_once { 0 } else { requests.len() });
        let kept = self
            .with_memory(self.context(room, transport).principal, writes, |memory| {
                for request in &requests {
                    let context = self.context(room, transport);
                    let step = match request {
                        Ok(request) => answer(&context, memory, request),
                        Err(error) => Step::Done(error.reply()),
                    };
                    if let Step::Done(reply) = &step
                        && reply.len() <= room
                    {
                        room -= reply.len() - REPLY_HEAD;
                    }
                    match step {
                        Step::Done(reply) if at_once => replies.push(&reply),
                        step => steps.push(step),
                    }
                }
            })
            .await;
        let mut began = Instant::now();
        for (step, request) in steps.into_iter().zip(&requests) {
            if began.elapsed() >= TURN {
                // The others have their turn.
                tokio::task::yield_now().await;
                began = Instant::now();
            }
            let context = self.context(replies.budget(), transport);
            let step = match request {
                Ok(request) => step.unless(kept, request),
                Err(_) => step,
            };
            replies.push(&self.finish(step, &context).await);
        }
        replies.finish()
    }

    /// Runs `work` on the tag memory, for writing only if it may write, and waits for what it began.
    ///
    /// # Errors
    /// The tags have what was written, but may not have it after a restart.
    async fn with_memory(
        &self,
        principal: Principal,
        writes: bool,
        work: impl FnOnce(&mut Memory<'_, '_>),
    ) -> Result<(), NotKept> {
        let plant = &self.device.plant;
        if writes {
            let ((), pending) = plant.transact(principal, |transaction| work(&mut Memory::Write(transaction)));
            plant.kept(pending).await
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

/// Whether a request may write to the tag memory.
fn may_write(request: &Request) -> bool {
    let code = request.service;
    tags::is_write(code) || objects::is_set(code) || objects::is_table_change(code)
}

/// Whether a request is answered after the memory has been let go.
fn is_late(request: &Request) -> bool {
    motion::is_motion(request)
        || matches!(request.path.0.first(), Some(Segment::Class(class)) if objects::LATE.map(u32::from).contains(class))
}

/// Answers one request that is no packet of requests.
fn answer<'r>(context: &Context<'_>, memory: &mut Memory<'_, '_>, request: &'r Request) -> Step<'r> {
    let refuse = |status| Step::Done(Reply::error(request.service, status));
    let target = match Target::new(&request.path) {
        Ok(target) => target,
        Err(error) => return refuse(error.status()),
    };
    if motion::is_motion(request) {
        return match motion::parse(context, memory.image(), request, &target) {
            Ok(motion) => Step::Motion(motion),
            Err(status) => refuse(status),
        };
    }
    if target.class.is_some_and(|class| objects::LATE.contains(&class)) && target.symbols.is_empty() {
        return Step::Late(request, target);
    }
    Step::Done(match target.class {
        // Only tags are in the scope of a name, a program's.
        Some(code) if !target.symbols.is_empty() && code != class::SYMBOL => {
            Reply::error(request.service, tags::unknown())
        }
        Some(class::SYMBOL) if tags::is_tag_service(request.service) => tags::serve(context, memory, request, &target),
        Some(class) => objects::serve(context, memory, request, class, &target),
        None if tags::is_tag_service(request.service) => tags::serve(context, memory, request, &target),
        None => objects::serve_named(context, memory, request, &target),
    })
}
