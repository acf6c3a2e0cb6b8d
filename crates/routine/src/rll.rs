//! Neutral text of ladder (spec/programs.md §5): a rung from text and back.
//!
//! Operands stay as text, since their meaning depends on the instruction: an expression, a word such as
//! `Units per sec` or `?`. Printing gives the text back but for blanks outside of operands.

use std::fmt;

use crate::SyntaxError;

/// A rung.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Rung {
    /// The elements from left to right.
    pub elements: Vec<Element>,
}

/// An element of a rung.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Element {
    /// An instruction.
    Instruction(Instruction),
    /// Legs from top to bottom; an empty leg is a wire.
    Branch(Vec<Vec<Element>>),
}

/// An instruction with its operands.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Instruction {
    /// The mnemonic, or the name of an add-on instruction, as it is written.
    pub name: String,
    /// Byte of the mnemonic in the rung's text.
    pub at: usize,
    /// The operands; `None`: there are no brackets.
    pub operands: Option<Vec<Operand>>,
}

/// An operand.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Operand {
    /// The text without blanks around it.
    pub text: String,
    /// Its first byte in the rung's text.
    pub at: usize,
}

impl Instruction {
    /// The operands; those of `NOP` and `NOP()` are the same.
    pub fn operands(&self) -> &[Operand] {
        self.operands.as_deref().unwrap_or_default()
    }
}

impl Rung {
    /// Reads a rung, which ends with a semicolon.
    ///
    /// # Errors
    /// The error, with its byte in the text.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        if text.len() > MAX_RUNG {
            return Err(SyntaxError::TooLong { limit: MAX_RUNG });
        }
        let mut reader = RungReader { text, at: 0, depth: 0 };
        let elements = reader.elements()?;
        reader.expect(b';', "; at the end of the rung")?;
        reader.skip();
        if reader.at < text.len() {
            return Err(reader.unexpected("the end of the rung"));
        }
        Ok(Rung { elements })
    }

    /// Calls `visit` with every instruction, in the order of execution.
    pub fn visit<'r>(&'r self, visit: &mut impl FnMut(&'r Instruction)) {
        visit_all(&self.elements, visit);
    }
}

fn visit_all<'r>(elements: &'r [Element], visit: &mut impl FnMut(&'r Instruction)) {
    for element in elements {
        match element {
            Element::Instruction(instruction) => visit(instruction),
            Element::Branch(legs) => legs.iter().for_each(|leg| visit_all(leg, visit)),
        }
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print(&self.elements, f)?;
        f.write_str(";")
    }
}

fn print(elements: &[Element], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let mut is_bare = false;
    for element in elements {
        // Names without brackets need a blank between them.
        if is_bare && matches!(element, Element::Instruction(_)) {
            f.write_str(" ")?;
        }
        is_bare = matches!(element, Element::Instruction(one) if one.operands.is_none());
        match element {
            Element::Instruction(instruction) => {
                f.write_str(&instruction.name)?;
                if let Some(operands) = &instruction.operands {
                    let texts: Vec<&str> = operands.iter().map(|operand| operand.text.as_str()).collect();
                    write!(f, "({})", texts.join(","))?;
                }
            }
            Element::Branch(legs) => {
                f.write_str("[")?;
                for (number, leg) in legs.iter().enumerate() {
                    if number > 0 {
                        f.write_str(",")?;
                    }
                    print(leg, f)?;
                    if !leg.is_empty() {
                        f.write_str(" ")?;
                    }
                }
                f.write_str("]")?;
            }
        }
    }
    Ok(())
}

struct RungReader<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
}

impl RungReader<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn skip(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    fn unexpected(&self, expected: &'static str) -> SyntaxError {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let found = if rest.is_empty() {
            "the end".to_owned()
        } else {
            rest.chars().take(12).collect()
        };
        SyntaxError::Unexpected {
            at: self.at,
            found,
            expected,
        }
    }

    fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), SyntaxError> {
        self.skip();
        if self.peek() != Some(byte) {
            return Err(self.unexpected(expected));
        }
        self.at += 1;
        Ok(())
    }

    fn elements(&mut self) -> Result<Vec<Element>, SyntaxError> {
        let mut elements = Vec::new();
        loop {
            self.skip();
            match self.peek() {
                Some(b'[') => {
                    self.at += 1;
                    elements.push(Element::Branch(self.branch()?));
                }
                Some(byte) if byte.is_ascii_alphabetic() || byte == b'_' => {
                    elements.push(Element::Instruction(self.instruction()?));
                }
                _ => return Ok(elements),
            }
        }
    }

    fn branch(&mut self) -> Result<Vec<Vec<Element>>, SyntaxError> {
        if self.depth >= MAX_NESTING {
            return Err(SyntaxError::TooDeep {
                at: self.at,
                limit: MAX_NESTING,
            });
        }
        self.depth += 1;
        let mut legs = Vec::new();
        loop {
            legs.push(self.elements()?);
            match self.peek() {
                Some(b',') => self.at += 1,
                Some(b']') => {
                    self.at += 1;
                    self.depth -= 1;
                    return Ok(legs);
                }
                _ => return Err(self.unexpected("an instruction, a comma or ] in a branch")),
            }
        }
    }

    fn instruction(&mut self) -> Result<Instruction, SyntaxError> {
        let at = self.at;
        while self
            .peek()
            .is_some_and(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        {
            self.at += 1;
        }
        let name = self.text.get(at..self.at).unwrap_or_default().to_owned();
        let end = self.at;
        self.skip();
        if self.peek() != Some(b'(') {
            self.at = end;
            return Ok(Instruction {
                name,
                at,
                operands: None,
            });
        }
        self.at += 1;
        let operands = Some(self.operands()?);
        Ok(Instruction { name, at, operands })
    }

    /// Operands up to the closing bracket: separated by commas outside of brackets and quotes.
    fn operands(&mut self) -> Result<Vec<Operand>, SyntaxError> {
        let mut operands = Vec::new();
        let mut closing: Vec<u8> = Vec::new();
        let mut from = self.at;
        loop {
            let Some(byte) = self.peek() else {
                return Err(self.unexpected(") behind the operands"));
            };
            match byte {
                b'\'' => {
                    let rest = self.text.as_bytes().get(self.at..).unwrap_or_default();
                    let (_, length) = crate::lexer::quoted(rest).ok_or(SyntaxError::Unended { at: self.at })?;
                    self.at += length;
                    continue;
                }
                b'(' | b'[' => {
                    if closing.len() >= MAX_NESTING {
                        return Err(SyntaxError::TooDeep {
                            at: self.at,
                            limit: MAX_NESTING,
                        });
                    }
                    closing.push(if byte == b'(' { b')' } else { b']' });
                }
                b')' | b']' => match closing.pop() {
                    Some(open) if open == byte => {}
                    None if byte == b')' => {
                        let operand = self.operand(from);
                        self.at += 1;
                        if !(operands.is_empty() && operand.text.is_empty()) {
                            operands.push(operand);
                        }
                        return Ok(operands);
                    }
                    _ => return Err(self.unexpected("brackets in pairs")),
                },
                b',' if closing.is_empty() => {
                    operands.push(self.operand(from));
                    if operands.len() >= MAX_OPERANDS {
                        return Err(SyntaxError::TooLong { limit: MAX_OPERANDS });
                    }
                    from = self.at + 1;
                }
                _ => {}
            }
            self.at += 1;
        }
    }

    fn operand(&self, from: usize) -> Operand {
        let text = self.text.get(from..self.at).unwrap_or_default();
        let at = from + (text.len() - text.trim_start().len());
        Operand {
            text: text.trim().to_owned(),
            at,
        }
    }
}

/// Longest rung, bytes.
pub const MAX_RUNG: usize = 1 << 20;
/// Branches and brackets within one another.
pub const MAX_NESTING: usize = 64;
/// Operands of an instruction.
const MAX_OPERANDS: usize = 256;
