//! Requests about motion: control of objects, instructions and their lines, jogs, stops, overrides.

use std::sync::atomic::Ordering;

use super::Viewer;
use super::hearing::Heard;
use crate::hmi::protocol::{
    Answer, Asks as _, Done, Execute, Executed, Hold, Jog, JogEnd, Keep, Line, Override, Refusal, Release, Resume,
    Stop, Take,
};
use crate::hmi::{drive, line};

impl Viewer {
    /// Input from a person: the session is not idle.
    pub(super) fn active(&self) -> Done {
        if let Some(session) = &self.session {
            self.shared.sessions.active(&session.key);
        }
        Done {}
    }

    pub(super) fn take(&self, request: &Take) -> Result<Done, Refusal> {
        let object = self.object(&request.object)?;
        let machine = self.shared.plant.machine();
        let taken = self
            .shared
            .plant
            .control()
            .take(machine, self.id, object, request.force);
        taken.map_err(|held| Refusal::control(held.object.name(machine), Some(&held.by)))?;
        Ok(Done {})
    }

    pub(super) fn release(&self, request: &Release) -> Result<Done, Refusal> {
        let object = self.object(&request.object)?;
        self.shared.plant.control().release(self.id, object);
        Ok(Done {})
    }

    pub(super) async fn execute(&self, request: &Execute) -> Result<Executed, Refusal> {
        drive::execute(&self.shared.plant, &self.shared.workers, self.id, &request.text).await
    }

    pub(super) async fn line(&self, request: Line, heard: &Heard) -> Result<Answer, Refusal> {
        self.computed(heard.is_long(), move |plant| {
            request.answer(line::line(plant, &request.instruction, &request.operands))
        })
        .await
    }

    pub(super) async fn jog(&self, request: &Jog, heard: &Heard) -> Result<Done, Refusal> {
        let index = usize::from(drive::axis_of(&self.shared.plant, &request.axis)?);
        let is_held = || {
            let releases = self.releases.get(index);
            let now = releases.map(|releases| releases.load(Ordering::Acquire));
            now == heard.releases.get(index).copied()
        };
        let shared = &self.shared;
        shared.jogs.begin(&shared.plant, self.id, request, is_held).await
    }

    pub(super) fn keep(&self, request: &Keep) -> Result<Done, Refusal> {
        self.shared.jogs.keep(&self.shared.plant, self.id, &request.axis)
    }

    pub(super) async fn jog_end(&self, request: &JogEnd) -> Result<Done, Refusal> {
        self.shared.jogs.end(&self.shared.plant, self.id, &request.axis).await
    }

    pub(super) async fn stop(&self, request: &Stop) -> Result<Done, Refusal> {
        self.shared.stop(self.id, request.object.as_deref()).await
    }

    pub(super) async fn set_override(&self, request: &Override) -> Result<Done, Refusal> {
        let (system, percent) = (&request.coordinate_system, request.percent);
        self.shared.set_override(self.id, system, percent).await
    }

    pub(super) async fn hold(&self, request: &Hold) -> Result<Done, Refusal> {
        self.shared.hold(self.id, &request.coordinate_system).await
    }

    pub(super) async fn resume(&self, request: &Resume) -> Result<Done, Refusal> {
        self.shared.resume(self.id, &request.coordinate_system).await
    }
}
