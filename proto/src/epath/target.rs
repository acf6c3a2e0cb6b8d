//! The meaning of a request's path: a name, an object, or an object within the scope of a name (spec/ethernet-ip.md §5).
//!
//! Not here: the check that such an object or tag exists.

use arcline_tag::{PathSegment, TagPath, split};

use super::{Epath, PathError, Segment};

/// The deepest nesting of names that is followed.
pub const MAX_SYMBOLS: usize = 32;

/// The target of a request: a name, an object, or an object within the scope of a name.
///
/// `91 "A" 28 03 91 "B"` is `symbols` A, 3, B. `20 6B 25 iiii 28 03` is class 0x6B, that instance, `members` 3.
/// `91 "Program:P" 20 6B 24 00` is `symbols` Program:P and class 0x6B. `91 "A" 30 02` is attribute 2 of the object with that name.
///
/// Names stay where the path has them.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Target<'p> {
    /// Names and indices in front of any class.
    pub symbols: Vec<PathSegment<&'p str>>,
    /// Class.
    pub class: Option<u16>,
    /// Instance; 0 is the class itself.
    pub instance: Option<u32>,
    /// Attribute.
    pub attribute: Option<u16>,
    /// Connection points, in order.
    pub connection_points: Vec<u32>,
    /// Names and indices behind the instance.
    pub members: Vec<PathSegment<&'p str>>,
}

impl<'p> Target<'p> {
    /// Reads the meaning of a request path. A name such as `A.B[3]` in one symbol segment is split. Port segments, keys,
    /// network and data segments are skipped: they belong to routes and connections.
    ///
    /// # Errors
    /// `Order`, `OutOfRange`, `Symbol` and `TooDeep`; see [`PathError::status`].
    pub fn new(path: &'p Epath) -> Result<Self, PathError> {
        let mut this = Self::default();
        let mut depth = 0;
        for segment in &path.0 {
            match segment {
                Segment::Class(id) if this.class.is_none() => this.class = Some(narrow(*id)?),
                Segment::Instance(id) if this.class.is_some() && this.instance.is_none() => this.instance = Some(*id),
                Segment::Attribute(id)
                    if (this.class.is_some() || !this.symbols.is_empty()) && this.attribute.is_none() =>
                {
                    this.attribute = Some(narrow(*id)?);
                }
                Segment::Class(_) | Segment::Instance(_) | Segment::Attribute(_) => {
                    return Err(PathError::Order);
                }
                Segment::ConnectionPoint(id) => this.connection_points.push(*id),
                Segment::Member(index) => this.names().push(PathSegment::Element(*index)),
                Segment::Symbol(name) => depth += this.take_symbol(name)?,
                Segment::Key(_) | Segment::Port(_) | Segment::Network { .. } | Segment::Data(_) => {}
            }
            if depth > MAX_SYMBOLS {
                return Err(PathError::TooDeep { limit: MAX_SYMBOLS });
            }
        }
        if matches!(
            this.symbols.first(),
            Some(PathSegment::Element(_) | PathSegment::Bit(_))
        ) {
            return Err(PathError::Order);
        }
        Ok(this)
    }

    /// The tag meant by name alone; `None` if the path goes by class or is empty.
    pub fn tag_path(&self) -> Option<TagPath> {
        (self.class.is_none() && !self.symbols.is_empty()).then(|| {
            let owned = self.symbols.iter().copied().map(PathSegment::into_owned);
            TagPath(owned.collect())
        })
    }

    /// The first name, if the path begins with one.
    pub fn first_symbol(&self) -> Option<&'p str> {
        match self.symbols.first() {
            Some(PathSegment::Symbol(name)) => Some(*name),
            _ => None,
        }
    }

    /// A plain name stays as it is; only one with dots or brackets is taken apart. Gives how many names that were.
    fn take_symbol(&mut self, name: &'p str) -> Result<usize, PathError> {
        if !name.contains(['.', '[']) {
            self.names().push(PathSegment::Symbol(name));
            return Ok(1);
        }
        let names = split(name).map_err(|_| PathError::Symbol)?;
        let depth = names
            .iter()
            .filter(|name| matches!(name, PathSegment::Symbol(_)))
            .count();
        self.names().extend(names);
        Ok(depth)
    }

    fn names(&mut self) -> &mut Vec<PathSegment<&'p str>> {
        if self.class.is_some() {
            &mut self.members
        } else {
            &mut self.symbols
        }
    }
}

fn narrow(value: u32) -> Result<u16, PathError> {
    u16::try_from(value).map_err(|_| PathError::OutOfRange { value })
}
