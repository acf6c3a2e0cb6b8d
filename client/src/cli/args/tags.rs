//! `tags`, `read` and `write`.

use std::str::FromStr;

use clap::{Args, Subcommand, ValueEnum};

use arcline_client::WriteValue;

#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Tags {
    #[command(subcommand)]
    pub(crate) change: Option<TagsChange>,
    /// Part of the name, or a pattern with * and ?
    pub(crate) pattern: Option<String>,
}

/// A change of the server's tags.
#[derive(Subcommand, Debug)]
pub(crate) enum TagsChange {
    /// Create a plain tag; clients notice it as they notice a download
    #[command(after_help = "Example: arcline tags create Recipe REAL[16] --program Main")]
    Create(CreateTag),
    /// Delete a plain tag
    #[command(after_help = "Example: arcline tags delete Recipe")]
    Delete(DeleteTag),
}

/// The tag to create.
#[derive(Args, Debug)]
pub(crate) struct CreateTag {
    /// The name: 1 to 40 letters, digits and underscores, no digit first
    pub(crate) name: String,
    /// Such as DINT, `REAL[16]`, `DINT[2,3]`, or a structure of the server's configuration
    #[arg(value_name = "TYPE")]
    pub(crate) data_type: String,
    /// The program that has the tag in its scope
    #[arg(long)]
    pub(crate) program: Option<String>,
    /// Access of clients
    #[arg(long, value_enum, default_value = "read_write")]
    pub(crate) access: TagAccess,
}

/// The tag to delete.
#[derive(Args, Debug)]
pub(crate) struct DeleteTag {
    /// The tag
    pub(crate) name: String,
    /// The program that has the tag in its scope
    #[arg(long)]
    pub(crate) program: Option<String>,
}

/// The access of clients to a tag.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TagAccess {
    /// Clients read and write it
    #[value(name = "read_write")]
    ReadWrite,
    /// Clients read it
    #[value(name = "read_only")]
    ReadOnly,
}

#[derive(Args, Debug)]
pub(crate) struct Read {
    /// Such as `X.ActualPosition`, `Move1.Position[0]`, `Word.5`
    #[arg(value_name = "TAG", required = true)]
    pub(crate) tags: Vec<String>,
}

#[derive(Args, Debug)]
pub(crate) struct Write {
    /// Such as Move1.Speed
    pub(crate) tag: String,
    /// A number, true or false, a text, or `[1,2,3]`
    #[arg(allow_hyphen_values = true, value_parser = WriteValue::from_str)]
    pub(crate) value: WriteValue,
}
