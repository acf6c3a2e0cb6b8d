//! Requests about programs of the page: simulations, checks, and the program that runs.

use std::sync::Arc;

use serde_json::Value;
use tokio::task::JoinSet;

use super::hearing::Heard;
use super::sending::Outgoing;
use super::{SIMULATIONS, Viewer};
use crate::hmi::protocol::{self, Answer, Asks as _, Check, Done, DryRun, Preview, Refusal, Run, Simulated};
use crate::hmi::{Shared, drive, program};
use crate::plant::Plant;

impl Shared {
    /// Reads a program from a text beside, and simulates it when those before have ended.
    async fn simulate(
        &self,
        read: impl FnOnce(&Plant) -> Result<arcline_structured_text::Program, Refusal> + Send + 'static,
    ) -> Result<Simulated, Refusal> {
        let plant = self.plant.clone();
        let program = self.workers.compute(move || read(&plant)).await??;
        self.previews.simulate(&self.plant, program).await
    }
}

impl Viewer {
    /// Simulates one instruction.
    pub(super) fn preview(
        &self,
        id: &Value,
        request: Preview,
        simulations: &mut JoinSet<()>,
    ) -> Option<Result<Answer, Refusal>> {
        let text = request.text.clone();
        let work = async move |shared: Arc<Shared>| {
            request.answer(shared.simulate(move |plant| drive::checked_call(plant, &text)).await)
        };
        self.simulate(id, simulations, work)
    }

    /// Simulates a program.
    pub(super) fn dry_run(
        &self,
        id: &Value,
        request: DryRun,
        simulations: &mut JoinSet<()>,
    ) -> Option<Result<Answer, Refusal>> {
        let text = request.text.clone();
        let work = async move |shared: Arc<Shared>| {
            request.answer(shared.simulate(move |plant| program::checked(plant, &text)).await)
        };
        self.simulate(id, simulations, work)
    }

    /// Begins a simulation, which is answered when it is done; a refusal if too many of this viewer wait.
    fn simulate<W>(
        &self,
        id: &Value,
        simulations: &mut JoinSet<()>,
        work: impl FnOnce(Arc<Shared>) -> W,
    ) -> Option<Result<Answer, Refusal>>
    where
        W: Future<Output = Result<Answer, Refusal>> + Send + 'static,
    {
        if simulations.len() >= SIMULATIONS {
            return Some(Err(Refusal::new(format!(
                "{SIMULATIONS} simulations wait already: let one of them end"
            ))));
        }
        let (id, outbox, work) = (id.clone(), self.outbox.clone(), work(self.shared.clone()));
        simulations.spawn(async move {
            let reply = protocol::reply(&id, work.await);
            // The viewer may just have gone, or read nothing.
            let _ = outbox.try_send(Outgoing::Text(reply.into()));
        });
        None
    }

    pub(super) async fn check(&self, request: Check, heard: &Heard) -> Result<Answer, Refusal> {
        self.computed(heard.is_long(), move |plant| {
            request.answer(Ok(program::check(plant, &request.text)))
        })
        .await
    }

    pub(super) async fn run(&self, request: &Run, heard: &Heard) -> Result<Done, Refusal> {
        let shared = &self.shared;
        let (text, plant) = (request.text.clone(), shared.plant.clone());
        let checked = shared
            .workers
            .compute_if(heard.is_long(), move || program::checked(&plant, &text));
        let program = checked.await??;
        shared.program.run(&shared.plant, self.id, program, request)
    }

    pub(super) fn step(&self) -> Result<Done, Refusal> {
        self.shared.program.step(&self.shared.plant, self.id)
    }

    pub(super) fn pause(&self) -> Result<Done, Refusal> {
        self.shared.program.pause(&self.shared.plant, self.id)
    }

    pub(super) fn go_on(&self) -> Result<Done, Refusal> {
        self.shared.program.go_on(&self.shared.plant, self.id)
    }

    pub(super) fn end(&self) -> Done {
        self.shared.program.end();
        Done {}
    }
}
