//! Requests about tags: lists, values, watched values, writes.

use super::Viewer;
use super::sending::Outgoing;
use crate::hmi::protocol::{Answer, Asks as _, Done, Read, Refusal, Tags, Watch, Write};
use crate::hmi::tags;
use crate::plant::Principal;

impl Viewer {
    pub(super) async fn list_tags(&self, request: Tags) -> Result<Answer, Refusal> {
        self.computed(true, move |plant| {
            request.answer(tags::list(plant, &request.pattern, request.after.as_deref()))
        })
        .await
    }

    pub(super) async fn read_tags(&self, request: Read) -> Result<Answer, Refusal> {
        self.computed(tags::are_many(&self.shared.plant, &request.names), move |plant| {
            request.answer(tags::values(plant, &request.names))
        })
        .await
    }

    pub(super) async fn watch_tags(&self, request: Watch) -> Result<Answer, Refusal> {
        let names = request.names.clone();
        let values = self.computed(tags::are_many(&self.shared.plant, &names), move |plant| {
            request.answer(tags::values(plant, &request.names))
        });
        let values = values.await?;
        self.send(Outgoing::Watch(names))?;
        Ok(values)
    }

    pub(super) async fn write_tag(&self, request: &Write) -> Result<Done, Refusal> {
        let by = Principal::Viewer(self.id);
        tags::write(&self.shared.plant, by, &request.tag, &request.value).await
    }
}
