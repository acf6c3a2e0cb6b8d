//! MSG (spec/programs.md §10.8): the row of the table of answers that fits the parameters of the message's tag.

use super::{Compiler, Owner};
use crate::code::{Argument, Reply};
use crate::expression::Expression;
use crate::memory::number;
use crate::source::TagSource;

impl Compiler<'_> {
    /// The answer to a message; `None`: it has none, and errs after its timeout. The message is a tag by its name: parameters of an add-on
    /// instruction and elements of arrays have no answer.
    pub(crate) fn reply(&mut self, message: &str) -> Option<Argument> {
        let Owner::Program(program) = self.owner else {
            return None;
        };
        let project = self.project;
        let named = |tags: &'_ [TagSource]| tags.iter().position(|tag| tag.name.eq_ignore_ascii_case(message));
        let own = project.programs.get(program)?.tags.as_slice();
        let tag = match named(own) {
            Some(place) => own.get(place)?,
            None => project.tags.get(named(&project.tags)?)?,
        };
        let parameter = |name: &str| tag.attributes.get(name).map(|text| number(text).0);
        let service = parameter("ServiceCode")?;
        let (class, instance) = (
            parameter("ObjectType").unwrap_or(0),
            parameter("TargetObject").unwrap_or(0),
        );
        let attribute = parameter("AttributeNumber").unwrap_or(0);
        let answer = project.answers.iter().find(|row| {
            i64::from(row.service) == service
                && i64::from(row.class) == class
                && row.instance.is_none_or(|wanted| i64::from(wanted) == instance)
                && row.attribute.is_none_or(|wanted| i64::from(wanted) == attribute)
        })?;
        let destination = tag.attributes.get("DestinationTag").filter(|name| !name.is_empty());
        let destination = destination.and_then(|name| {
            let reference = Expression::parse_reference(name).ok()?;
            let found = self.resolve(&reference).ok()?;
            found.bit.is_none().then(|| found.area())
        });
        let place = u32::try_from(self.code.replies.len()).ok()?;
        self.code.replies.push(Reply {
            delay: u64::from(answer.delay_ms) * 1_000_000,
            error: answer.error,
            data: answer.data.clone().into(),
            destination,
        });
        Some(Argument::Reply(place))
    }
}
