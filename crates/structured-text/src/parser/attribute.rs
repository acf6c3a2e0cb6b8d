//! `GSV(Class, Instance, Attribute, Destination)` and `SSV(Class, Instance, Attribute, Source)`: attributes of axes and coordinate
//! systems.

use arcline_instruction_set::{ATTRIBUTES, Attribute, Object};
use arcline_tag::nearest;

use super::{Parser, place_of};
use crate::code::{Meaning, Op};
use crate::error::{SyntaxError, SyntaxProblem};
use crate::lexer::{Kind, Token};
use crate::program::ObjectAttribute;

impl<'t> Parser<'t> {
    /// Whether a statement with that name in front of `(` is GSV or SSV.
    pub(super) fn is_system_value(name: &Token<'t>) -> bool {
        name.is_word("GSV") || name.is_word("SSV")
    }

    /// Everything behind the name GSV or SSV.
    pub(super) fn system_value(&mut self, name: Token<'t>) -> Result<(), SyntaxError> {
        let sets = name.is_word("SSV");
        self.expect("(", "`(` behind GSV or SSV")?;
        let class = self.expect_kind(Kind::Name, CLASSES)?;
        let known = [Object::Axis, Object::CoordinateSystem];
        let object = known.into_iter().find(|object| class.is_word(object.member()));
        let object = object.ok_or_else(|| self.unexpected(&class, CLASSES))?;
        self.expect(",", "`,` behind the class")?;
        let instance = self.expect_kind(Kind::Name, "the name of the axis or coordinate system")?;
        self.uses(instance.offset, Meaning::Object(object, instance.text.to_owned()));
        self.expect(",", "`,` behind the instance")?;
        let token = self.expect_kind(Kind::Name, "the name of the attribute")?;
        let Some(attribute) = Attribute::named(object, token.text) else {
            let names = ATTRIBUTES.iter().filter(|one| one.object == object);
            let problem = SyntaxProblem::UnknownAttribute {
                what: object.name(),
                name: token.text.chars().take(60).collect(),
                suggestion: nearest(token.text, names.map(|one| one.name.to_owned())),
            };
            return Err(self.error(token.offset, problem));
        };
        if sets && !attribute.is_settable() {
            let problem = SyntaxProblem::ReadOnlyAttribute { name: attribute.name };
            return Err(self.error(token.offset, problem));
        }
        let place = place_of(self.program.attributes.len());
        self.program.attributes.push(ObjectAttribute {
            attribute,
            name: instance.text.to_owned(),
        });
        if sets {
            self.expect(",", "`,` and the source behind the attribute")?;
            self.expression()?;
            self.emit(Op::SetAttribute(place));
        } else {
            self.expect(",", "`,` and the destination behind the attribute")?;
            let destination = self.expect_kind(Kind::Name, "the tag or variable of the destination")?;
            let path = self.path(destination)?;
            self.uses(destination.offset, Meaning::Assigned(path));
            self.emit(Op::GetAttribute(place));
            self.emit(Op::Store(path));
        }
        self.expect(")", "`)` at the end of GSV or SSV")
    }
}

const CLASSES: &str = "the class Axis or CoordinateSystem";
