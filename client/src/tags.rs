//! The server's tags: browsing, creating, deleting. Their types are fetched by `fetch`.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytes::Bytes;

use arcline_instruction_set::Object;
use arcline_proto::cip::{class, encode_attribute_ids, service};
use arcline_proto::epath::{Epath, Segment};
use arcline_proto::logix::{self, CreateSymbol, Symbol, template_instance};
use arcline_tag::{DataType, TagType, Template};

use crate::{Client, ClientError};

/// Most tags that are listed.
const MAX_TAGS: usize = 65_535;
/// The requested attributes of a symbol: name, type, dimensions, access.
const ATTRIBUTES: [u16; 4] = [1, 2, 8, 10];
/// Bit 12 of a symbol type: not for users.
const SYSTEM: u16 = 0x1000;
/// The symbol type of a program, the scope of other tags.
const PROGRAM: u16 = 0x1068;

/// A tag of the server.
#[derive(Clone, PartialEq, Debug)]
pub struct Tag {
    /// Name.
    pub name: String,
    /// Symbol instance.
    pub instance: u32,
    /// Type, with the templates of structures.
    pub tag_type: TagType,
    /// The access of clients.
    pub access: Access,
}

impl Tag {
    /// The type as it is printed: `REAL[9]`, `COORDINATE_SYSTEM`.
    pub fn type_name(&self) -> String {
        self.tag_type.to_string()
    }

    /// The motion object that the tag stands for, by its type.
    pub fn object(&self) -> Option<Object> {
        match &self.tag_type.data_type {
            DataType::Structure(template) if self.tag_type.rank() == 0 => object_of(&template.name),
            _ => None,
        }
    }
}

/// The access of clients to a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Access {
    /// Read and write.
    ReadWrite,
    /// Read.
    ReadOnly,
    /// No access.
    None,
}

/// The object of a predefined type.
fn object_of(type_name: &str) -> Option<Object> {
    match type_name {
        "COORDINATE_SYSTEM" => Some(Object::CoordinateSystem),
        "MOTION_GROUP" => Some(Object::MotionGroup),
        name if name.starts_with("AXIS_") => Some(Object::Axis),
        _ => None,
    }
}

/// The tags and types that are known so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct TagTable {
    /// The symbols by lower-case name.
    symbols: BTreeMap<String, Symbol>,
    templates: BTreeMap<u16, Arc<Template>>,
}

impl TagTable {
    /// The type of a tag, as far as its template is known.
    fn tag_type(&self, symbol: &Symbol) -> Option<TagType> {
        let data_type = logix::data_type(symbol.symbol_type, |instance| self.templates.get(&instance).cloned())?;
        Some(TagType {
            data_type,
            dimensions: symbol.dimensions,
        })
    }

    /// The tag of a name, case ignored, if its type is known.
    pub(crate) fn tag(&self, name: &str) -> Option<Tag> {
        let symbol = self.symbols.get(&name.to_ascii_lowercase())?;
        let access = match symbol.access {
            2 => Access::ReadOnly,
            3 => Access::None,
            _ => Access::ReadWrite,
        };
        let tag_type = self.tag_type(symbol)?;
        Some(Tag {
            name: symbol.name.clone(),
            instance: symbol.instance,
            tag_type,
            access,
        })
    }

    /// All names.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.symbols.values().map(|symbol| symbol.name.as_str())
    }

    /// All tags whose types are known, by instance.
    pub(crate) fn tags(&self) -> Vec<Tag> {
        let mut tags: Vec<Tag> = self.symbols.keys().filter_map(|name| self.tag(name)).collect();
        tags.sort_by_key(|tag| tag.instance);
        tags
    }
}

impl Client {
    /// The controller's tags with their types, in the order of their instances. Tags of types that are not known here
    /// are left out. Always asks the server anew.
    ///
    /// # Errors
    /// The errors of the connection; [`ClientError::TooLarge`] for more tags or larger types than are accepted.
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// for tag in client.browse().await? {
    ///     println!("{:20} {}", tag.name, tag.type_name());
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub async fn browse(&self) -> Result<Vec<Tag>, ClientError> {
        let table = self.refresh_symbols().await?;
        let structures = table.symbols.values().map(|symbol| symbol.symbol_type);
        let wanted: Vec<u16> = structures.filter_map(template_instance).collect();
        let mut templates = table.templates.clone();
        for instance in wanted {
            self.fetch_template(instance, &mut templates).await?;
        }
        let table = self.set_table(TagTable {
            symbols: table.symbols.clone(),
            templates,
        });
        Ok(table.tags())
    }

    /// The tag of a name, case ignored, as known, else from a new request.
    ///
    /// # Errors
    /// [`ClientError::UnknownTag`] with the nearest name there is.
    pub async fn tag(&self, name: &str) -> Result<Tag, ClientError> {
        let known = self.table();
        let table = if known.symbols.contains_key(&name.to_ascii_lowercase()) {
            known
        } else {
            self.refresh_symbols().await?
        };
        let Some(symbol) = table.symbols.get(&name.to_ascii_lowercase()) else {
            return Err(ClientError::unknown_tag(name, table.names()));
        };
        if let Some(tag) = table.tag(name) {
            return Ok(tag);
        }
        let mut templates = table.templates.clone();
        if let Some(instance) = template_instance(symbol.symbol_type) {
            self.fetch_template(instance, &mut templates).await?;
        }
        let table = self.set_table(TagTable {
            symbols: table.symbols.clone(),
            templates,
        });
        table.tag(name).ok_or(ClientError::Malformed {
            what: "a tag has an unknown type",
        })
    }

    /// The names of the objects of a kind, in the order of their tags.
    ///
    /// # Errors
    /// As [`Client::browse`].
    pub async fn objects(&self, object: Object) -> Result<Vec<String>, ClientError> {
        let tags = self.browse().await?;
        Ok(tags
            .into_iter()
            .filter(|tag| tag.object() == Some(object))
            .map(|tag| tag.name)
            .collect())
    }

    /// The instance of an object in its class: they count from 1, in the order of their tags.
    ///
    /// # Errors
    /// [`ClientError::UnknownObject`] with the nearest name there is; otherwise as [`Client::browse`].
    pub(crate) async fn instance(&self, object: Object, name: &str) -> Result<u32, ClientError> {
        let names = self.objects(object).await?;
        let index = names.iter().position(|known| known.eq_ignore_ascii_case(name));
        let index = index.ok_or_else(|| ClientError::unknown_object(object, name, &names))?;
        Ok(u32::try_from(index).unwrap_or(u32::MAX).saturating_add(1))
    }

    /// Creates a plain tag, in a program's scope when its name begins with `Program:Main.`; `data_type` is written as in a
    /// configuration: `DINT[2,3]`. Gives its instance.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: 0x20 for an impossible name or type, 0x0D when there is a tag of that name, 0x02 when there
    /// is no room.
    pub async fn create_tag(&self, name: &str, data_type: &str, access: Access) -> Result<u32, ClientError> {
        let (path, name) = symbol_path(name, 0);
        let create = CreateSymbol {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            access: match access {
                Access::ReadWrite => 0,
                Access::ReadOnly => 2,
                Access::None => 3,
            },
        };
        let reply = self.ask(name, service::CREATE, path, create.to_bytes()).await?;
        self.refresh_symbols().await?;
        let instance = reply.data.first_chunk().copied().map(u32::from_le_bytes);
        instance.ok_or(ClientError::Malformed {
            what: "a created tag has no instance",
        })
    }

    /// Deletes a plain tag.
    ///
    /// # Errors
    /// [`ClientError::UnknownTag`]; [`ClientError::Refused`]: 0x0F for another tag than a plain one, 0x0C for one that an
    /// alias stands for.
    pub async fn delete_tag(&self, name: &str) -> Result<(), ClientError> {
        // Refresh first: the instance may belong to another tag by now.
        self.refresh_symbols().await?;
        let tag = self.tag(name).await?;
        let (path, _) = symbol_path(&tag.name, tag.instance);
        self.ask(name, service::DELETE, path, Bytes::new()).await?;
        self.refresh_symbols().await?;
        Ok(())
    }

    async fn refresh_symbols(&self) -> Result<Arc<TagTable>, ClientError> {
        let mut symbols = BTreeMap::new();
        let mut scopes: Vec<Option<String>> = vec![None];
        while let Some(scope) = scopes.pop() {
            for mut symbol in self.list_symbols(scope.as_deref()).await? {
                if scope.is_none() && symbol.symbol_type == PROGRAM {
                    scopes.push(Some(symbol.name));
                } else if symbol.symbol_type & SYSTEM == 0 {
                    if let Some(program) = &scope {
                        symbol.name = format!("{program}.{}", symbol.name);
                    }
                    symbols.insert(symbol.name.to_ascii_lowercase(), symbol);
                }
            }
            check_count(symbols.len() + scopes.len())?;
        }
        let templates = self.table().templates.clone();
        Ok(self.set_table(TagTable { symbols, templates }))
    }

    /// The tags of the controller's scope or of a program's, such as `Program:Main`.
    async fn list_symbols(&self, scope: Option<&str>) -> Result<Vec<Symbol>, ClientError> {
        let mut symbols = Vec::new();
        let mut start = 0;
        loop {
            let mut path = Epath::object(class::SYMBOL, start);
            if let Some(scope) = scope {
                path.0.insert(0, Segment::Symbol(scope.into()));
            }
            let data = encode_attribute_ids(&ATTRIBUTES);
            let reply = self
                .ask("the tag list", service::GET_INSTANCE_ATTRIBUTE_LIST, path, data)
                .await?;
            let page = Symbol::decode_list(&reply.data, &ATTRIBUTES);
            let page = page.ok_or(ClientError::Malformed {
                what: "a page of the tag list is cut",
            })?;
            let last = page.iter().map(|symbol| symbol.instance).max();
            symbols.extend(page);
            check_count(symbols.len())?;
            if reply.status.is_success() {
                return Ok(symbols);
            }
            // Partial: the next page begins behind the last symbol, which must be behind the one before.
            start = last
                .and_then(|last| last.checked_add(1))
                .filter(|next| *next > start)
                .ok_or(STUCK)?;
        }
    }
}

/// The path of a symbol, behind its program if its name has one, and the name in that scope.
fn symbol_path(name: &str, instance: u32) -> (Epath, &str) {
    let mut path = Epath::object(class::SYMBOL, instance);
    let scoped = name
        .split_once('.')
        .filter(|(program, _)| program.to_ascii_lowercase().starts_with("program:"));
    match scoped {
        Some((program, name)) => {
            path.0.insert(0, Segment::Symbol(program.into()));
            (path, name)
        }
        None => (path, name),
    }
}

fn check_count(claimed: usize) -> Result<(), ClientError> {
    if claimed > MAX_TAGS {
        return Err(ClientError::TooLarge {
            what: "the number of tags",
            claimed,
            limit: MAX_TAGS,
        });
    }
    Ok(())
}

const STUCK: ClientError = ClientError::Malformed {
    what: "the tag list does not go on",
};
