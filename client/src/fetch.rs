//! Fetches the types of tags that are structures, with those within them. The layout of a definition is
//! [`Definition`]'s.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytes::{Bytes, BytesMut};

use arcline_proto::cip::{CipStatus, class, encode_attribute_ids, service};
use arcline_proto::epath::Epath;
use arcline_proto::logix::{Definition, ReadTemplate, TemplateAttributes};
use arcline_tag::{Template, string_template};

use crate::{Client, ClientError};

/// Most templates that are fetched.
const MAX_TEMPLATES: usize = 512;
/// Longest template definition, bytes.
const MAX_DEFINITION: u32 = 256 * 1024;

impl Client {
    /// Fetches a template and those within it.
    pub(crate) async fn fetch_template(
        &self,
        instance: u16,
        templates: &mut BTreeMap<u16, Arc<Template>>,
    ) -> Result<(), ClientError> {
        templates
            .entry(arcline_tag::STRING_INSTANCE)
            .or_insert_with(string_template);
        let mut fetched: BTreeMap<u16, (TemplateAttributes, Definition)> = BTreeMap::new();
        let mut wanted = vec![instance];
        while let Some(instance) = wanted.pop() {
            if templates.contains_key(&instance) || fetched.contains_key(&instance) {
                continue;
            }
            if templates.len() + fetched.len() >= MAX_TEMPLATES {
                let claimed = MAX_TEMPLATES + 1;
                return Err(ClientError::TooLarge {
                    what: "the number of types",
                    claimed,
                    limit: MAX_TEMPLATES,
                });
            }
            let (attributes, definition) = self.fetch_definition(instance).await?;
            wanted.extend(definition.nested());
            fetched.insert(instance, (attributes, definition));
        }
        // Innermost first; a remaining template contains itself.
        while !fetched.is_empty() {
            let ready = fetched
                .iter()
                .find(|(_, (_, d))| d.nested().all(|inner| templates.contains_key(&inner)));
            let ready = ready.map(|(instance, _)| *instance);
            let found = ready.and_then(|instance| Some((instance, fetched.remove(&instance)?)));
            let (instance, (attributes, definition)) = found.ok_or(BAD_TEMPLATE)?;
            let built = definition.build(instance, attributes, |inner| templates.get(&inner).cloned());
            templates.insert(instance, built.ok_or(BAD_TEMPLATE)?);
        }
        Ok(())
    }

    async fn fetch_definition(&self, instance: u16) -> Result<(TemplateAttributes, Definition), ClientError> {
        let path = Epath::object(class::TEMPLATE, instance.into());
        let ids = encode_attribute_ids(&TemplateAttributes::IDS);
        let reply = self
            .ask("a type", service::GET_ATTRIBUTE_LIST, path.clone(), ids)
            .await?;
        let attributes = TemplateAttributes::decode(&reply.data).ok_or(BAD_TEMPLATE)?;
        // spec/ethernet-ip.md §11: clients read up to 4N − 16 bytes.
        let length = attributes.definition_words.saturating_mul(4).saturating_sub(16);
        if length > MAX_DEFINITION {
            let (claimed, limit) = (length as usize, MAX_DEFINITION as usize);
            return Err(ClientError::TooLarge {
                what: "a type's definition",
                claimed,
                limit,
            });
        }
        let bytes = self.read_definition(&path, length).await?;
        let definition = Definition::decode(&bytes, attributes.members).ok_or(BAD_TEMPLATE)?;
        Ok((attributes, definition))
    }

    async fn read_definition(&self, path: &Epath, length: u32) -> Result<Bytes, ClientError> {
        let mut bytes = BytesMut::new();
        while bytes.len() < length as usize {
            let offset = bytes.len() as u32;
            let part = u16::try_from(length - offset).unwrap_or(u16::MAX);
            let data = ReadTemplate { offset, bytes: part }.to_bytes();
            let reply = self
                .ask("a type's definition", service::READ_TAG, path.clone(), data)
                .await?;
            if reply.data.len() > usize::from(part) {
                return Err(BAD_TEMPLATE);
            }
            bytes.extend_from_slice(&reply.data);
            if reply.data.is_empty() || reply.status.is(CipStatus::SUCCESS) && reply.data.len() < usize::from(part) {
                break;
            }
        }
        Ok(bytes.freeze())
    }
}

const BAD_TEMPLATE: ClientError = ClientError::Malformed {
    what: "a type's definition makes no sense",
};
