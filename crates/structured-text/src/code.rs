//! The compiled form: a flat list of operations on a stack of numbers and truth values. No text, no
//! recursion; built by `parser`, run by `interpreter`.

use arcline_instruction_set::Object;
use arcline_tag::{PathSegment, TagPath};

/// One operation. Numbers are places in the lists of [`Code`], or in `ops` for jumps.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Op {
    /// A statement or a turn of a loop begins; its line. Counts towards the budget of the tick.
    Statement(u32),
    /// Pushes a number.
    Number(f64),
    /// Pushes a truth value.
    Bool(bool),
    /// Pops the path's computed indices, pushes its value.
    Read(u32),
    /// Pops a value, then the path's computed indices, and writes the value.
    Store(u32),
    /// Pushes a variable.
    Variable(u32),
    /// Pops into a variable.
    SetVariable(u32),
    Negate,
    Not,
    Binary(Binary),
    Jump(u32),
    /// Pops a condition.
    JumpIfFalse(u32),
    /// Pops a condition.
    JumpIfTrue(u32),
    /// Pops step, limit and value of a FOR, pushes whether the loop goes on.
    ForTest,
    /// Asks for the next tick.
    Tick,
    /// Pops seconds and asks for that delay.
    Delay,
    /// Pops a number: the next operand of the call.
    OperandNumber,
    /// Pops the path's computed indices; the next operand of the call is the path as a name.
    OperandName(u32),
    /// Pops this number of numbers: the next operand of the call is the array of them.
    OperandArray(u32),
    /// Pops the path's computed indices; the next operand of the call is the array from that element on.
    OperandRead(u32),
    /// Calls with these operands.
    Call(u32),
    /// Pushes the value of an attribute.
    GetAttribute(u32),
    /// Pops a number and sets an attribute to it.
    SetAttribute(u32),
    End,
}

/// A binary operator.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Equal,
    NotEqual,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
    And,
    Xor,
    Or,
}

/// A tag path whose indices may be computed.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Path {
    pub(crate) parts: Vec<Part>,
    /// Byte offset in the program.
    pub(crate) offset: usize,
    /// The variable of that name, when no tag has it: set by the check.
    pub(crate) variable: Option<u32>,
}

/// One step of a [`Path`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Part {
    Fixed(PathSegment),
    /// An index that is popped.
    Computed,
}

impl Path {
    /// The path with 0 for every computed index.
    pub(crate) fn sample(&self) -> TagPath {
        let segment = |part: &Part| match part {
            Part::Fixed(segment) => segment.clone(),
            Part::Computed => PathSegment::Element(0),
        };
        TagPath(self.parts.iter().map(segment).collect())
    }

    /// The number of indices to pop.
    pub(crate) fn computed(&self) -> usize {
        self.parts.iter().filter(|part| **part == Part::Computed).count()
    }

    /// The name, when the path is nothing else.
    pub(crate) fn plain_name(&self) -> Option<&str> {
        match self.parts.as_slice() {
            [Part::Fixed(PathSegment::Symbol(name))] => Some(name),
            _ => None,
        }
    }
}

/// A name in the program that must mean something, for the check.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Use {
    pub(crate) offset: usize,
    pub(crate) meaning: Meaning,
    /// The word operand it stands in, for a better message.
    pub(crate) word: Option<WordPlace>,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Meaning {
    /// The name of an object.
    Object(Object, String),
    /// A motion control tag: made when there is none.
    Control(u32),
    /// A tag or variable that is read, as a number or as an array.
    Read(u32),
    /// A tag that an instruction writes: no variable.
    Written(u32),
    /// A tag or variable that is assigned.
    Assigned(u32),
}

/// The position at which a word was expected.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct WordPlace {
    pub(crate) mnemonic: arcline_instruction_set::Mnemonic,
    pub(crate) place: usize,
    /// The text there, without blanks.
    pub(crate) text: String,
    pub(crate) offset: usize,
}
