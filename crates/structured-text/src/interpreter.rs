//! Runs a program, one request at a time. No clock, no tag and no network: its driver answers.

use arcline_instruction_set::{Mnemonic, UnboundOperand};
use arcline_tag::{PathSegment, TagPath, Value};

use crate::code::{Binary, Op, Part};
use crate::error::{RuntimeError, RuntimeProblem};
use crate::program::{ObjectAttribute, Program};

/// Statements and turns of loops that run within one tick at most; then the rest waits for the next one,
/// so that `WHILE TRUE DO END_WHILE;` hangs nothing.
pub const STATEMENTS_PER_TICK: u32 = 100_000;

/// Operations of expressions and statements within one tick: the statement that exceeds them is the last one of the tick. An
/// expression may be long, so that the number of statements alone does not bound the time that a tick computes.
pub const OPERATIONS_PER_TICK: u32 = 1_000_000;

/// The next request of the program.
#[derive(Clone, PartialEq, Debug)]
pub enum Request {
    /// The value of a tag, answered with [`Answer::Value`]. A motion control tag that has not been made yet
    /// reads as zeros.
    Read(TagPath),
    /// The numbers of an array from that element on, answered with [`Answer::Array`]; a tag that is no array
    /// is an array of one.
    ReadArray(TagPath),
    /// A tag is to be written, answered with [`Answer::Done`]. The value is a BOOL or an LREAL, which the driver converts to the
    /// type of the tag.
    Write(TagPath, Value),
    /// An instruction is to be executed in this tick, as a false-to-true transition of its rung; answered
    /// with [`Answer::Done`], erred or not, or with [`Answer::QueueFull`].
    Call(EvaluatedCall),
    /// The value of an attribute, answered with [`Answer::Value`].
    GetAttribute(ObjectAttribute),
    /// An attribute is to be set, answered with [`Answer::Done`].
    SetAttribute(ObjectAttribute, f64),
    /// The program goes on in the next tick, answered with [`Answer::Done`].
    NextTick,
    /// The program goes on after that many seconds, 0 or more, answered with [`Answer::Done`].
    Delay(f64),
    /// The last statement has run.
    End,
}

/// The answer to a [`Request`].
#[derive(Clone, PartialEq, Debug)]
pub enum Answer {
    /// There was no request yet: the first call of [`Interpreter::resume`].
    Start,
    /// The value that was read.
    Value(Value),
    /// The value that was read, which cannot change any more, such as a bit of an instruction that has ended.
    Settled(Value),
    /// The numbers that were read.
    Array(Vec<f64>),
    /// The request is done.
    Done,
    /// There is no room for the move: the interpreter asks for the next tick, then for the same call again.
    QueueFull,
}

/// A call with the operands that it has at this moment.
#[derive(Clone, PartialEq, Debug)]
pub struct EvaluatedCall {
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// Name of the object it acts on.
    pub target: String,
    /// The motion control tag; `None`: an unnamed one.
    pub control: Option<String>,
    /// The operands behind target and motion control, in faceplate order; trailing ones may be missing.
    pub operands: Vec<UnboundOperand>,
    /// Line of the call, from 1.
    pub line: usize,
}

/// A program on its way.
///
/// All arithmetic is in 64-bit floating point: `7 / 2` is 3.5, `7 MOD 2` is 1 with the sign of the dividend,
/// a division by 0 is infinite or not a number. Integers beyond 2^53 lose their low digits. A comparison
/// takes a BOOL for 0 or 1; `=` is exact. A condition holds when it is TRUE or a number other than 0. AND,
/// OR, XOR and NOT work on the bits of two integers, else on truth.
#[derive(Clone, Debug)]
pub struct Interpreter {
    program: Program,
    at: usize,
    stack: Vec<Entry>,
    operands: Vec<UnboundOperand>,
    variables: Vec<Cell>,
    line: u32,
    budget: Budget,
    pending: Pending,
    /// Whether the program has read a settled value since time last passed.
    read_settled: bool,
    /// Whether the condition of the last WAIT did not hold and cannot hold any more.
    is_hopeless: bool,
}

/// The statements and operations that a program may still execute within the present tick.
#[derive(Clone, Copy, Debug)]
struct Budget {
    statements: u32,
    operations: u32,
}

impl Budget {
    const TICK: Budget = Budget {
        statements: STATEMENTS_PER_TICK,
        operations: OPERATIONS_PER_TICK,
    };

    /// Takes a statement from the budget, unless there is none left.
    fn statement(&mut self) -> bool {
        if self.statements == 0 || self.operations == 0 {
            return false;
        }
        self.statements -= 1;
        true
    }
}

/// The pending request to the driver.
#[derive(Clone, Debug)]
enum Pending {
    Start,
    Value,
    Array,
    Write,
    Time,
    Call(EvaluatedCall),
    /// The queue was full: the call comes again when the tick has passed.
    Again(EvaluatedCall),
    Ended,
}

/// A value on the stack, and whether it would be the same if it were computed later.
#[derive(Clone, Copy, Debug)]
struct Entry {
    cell: Cell,
    settled: bool,
}

/// A value.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Cell {
    Number(f64),
    Bool(bool),
}

impl Interpreter {
    /// The program in front of its first statement. Names that [`Program::check`] has not made variables are
    /// tags.
    pub fn new(program: Program) -> Self {
        let variables = vec![Cell::Number(0.0); program.variables as usize];
        Self {
            program,
            at: 0,
            stack: Vec::new(),
            operands: Vec::new(),
            variables,
            line: 1,
            budget: Budget::TICK,
            pending: Pending::Start,
            read_settled: false,
            is_hopeless: false,
        }
    }

    /// A program without a statement.
    pub fn empty() -> Self {
        Self::new(Program::empty(""))
    }

    /// Line of the statement that runs, from 1.
    pub fn line(&self) -> usize {
        self.line as usize
    }

    /// Whether the program waits for the next tick because the condition of a WAIT did not hold. In the next tick it then only evaluates
    /// the condition again.
    pub fn is_waiting(&self) -> bool {
        let last = self.at.checked_sub(1).and_then(|last| self.program.ops.get(last));
        matches!((&self.pending, last), (Pending::Time, Some(Op::Tick)))
    }

    /// Whether the program waits ([`Interpreter::is_waiting`]) for a condition that can never hold: the values that were answered as
    /// settled ([`Answer::Settled`]) decide it.
    pub fn is_hopeless(&self) -> bool {
        self.is_hopeless && self.is_waiting()
    }

    /// Goes on to the next request. Behind the end, and after an error, it is [`Request::End`] for good.
    ///
    /// # Errors
    /// An operation that has no result, with the line; or an answer to something else than was asked.
    pub fn resume(&mut self, answer: Answer) -> Result<Request, RuntimeError> {
        let result = self.accept(answer).and_then(|request| match request {
            Some(request) => Ok(request),
            None => self.run(),
        });
        result.map_err(|problem| {
            self.pending = Pending::Ended;
            RuntimeError {
                line: self.line(),
                problem,
            }
        })
    }

    /// Takes the answer; some answers lead to a request at once.
    fn accept(&mut self, answer: Answer) -> Result<Option<Request>, RuntimeProblem> {
        let pending = std::mem::replace(&mut self.pending, Pending::Ended);
        match (pending, answer) {
            (Pending::Start, Answer::Start) | (Pending::Write | Pending::Call(_), Answer::Done) => Ok(None),
            (Pending::Value, Answer::Value(value)) => {
                self.push(Cell::from(value), false);
                Ok(None)
            }
            (Pending::Value, Answer::Settled(value)) => {
                self.read_settled = true;
                self.push(Cell::from(value), true);
                Ok(None)
            }
            (Pending::Array, Answer::Array(numbers)) => {
                self.operands.push(UnboundOperand::Array(numbers));
                Ok(None)
            }
            (Pending::Time, Answer::Done) => {
                self.budget = Budget::TICK;
                self.read_settled = false;
                Ok(None)
            }
            (Pending::Call(call), Answer::QueueFull) => {
                self.pending = Pending::Again(call);
                Ok(Some(Request::NextTick))
            }
            (Pending::Again(call), Answer::Done) => {
                self.budget = Budget::TICK;
                self.pending = Pending::Call(call.clone());
                Ok(Some(Request::Call(call)))
            }
            (Pending::Ended, _) => Ok(Some(Request::End)),
            (pending, _) => Err(RuntimeProblem::Answer { asked: pending.name() }),
        }
    }

    /// Runs up to the next request.
    fn run(&mut self) -> Result<Request, RuntimeProblem> {
        loop {
            let op = self.program.ops.get(self.at).copied().unwrap_or(Op::End);
            self.at += 1;
            self.budget.operations = self.budget.operations.saturating_sub(1);
            match op {
                Op::Statement(line) => {
                    self.line = line;
                    if !self.budget.statement() {
                        return Ok(self.ask(Pending::Time, Request::NextTick));
                    }
                }
                Op::Number(number) => self.push(Cell::Number(number), true),
                Op::Bool(truth) => self.push(Cell::Bool(truth), true),
                Op::Read(path) => {
                    if let Some(variable) = self.variable_of(path) {
                        self.push(self.variables[variable], true);
                    } else {
                        let path = self.path(path)?;
                        return Ok(self.ask(Pending::Value, Request::Read(path)));
                    }
                }
                Op::Store(path) => {
                    let value = self.pop().cell;
                    if let Some(variable) = self.variable_of(path) {
                        self.variables[variable] = value;
                    } else {
                        let path = self.path(path)?;
                        return Ok(self.ask(Pending::Write, Request::Write(path, value.value())));
                    }
                }
                Op::Variable(variable) => self.push(self.variables[variable as usize], true),
                Op::SetVariable(variable) => self.variables[variable as usize] = self.pop().cell,
                Op::Negate => {
                    let Entry { cell, settled } = self.pop();
                    self.push(Cell::Number(-cell.number()?), settled);
                }
                Op::Not => {
                    let Entry { cell, settled } = self.pop();
                    let value = match cell {
                        Cell::Bool(truth) => Cell::Bool(!truth),
                        Cell::Number(number) => Cell::Number(!integer(number)? as f64),
                    };
                    self.push(value, settled);
                }
                Op::Binary(operator) => {
                    let right = self.pop();
                    let left = self.pop();
                    let value = binary(operator, left.cell, right.cell)?;
                    let decides = |entry: Entry| {
                        entry.settled
                            && match operator {
                                Binary::And => !entry.cell.holds(),
                                Binary::Or => matches!(value, Cell::Bool(_)) && entry.cell.holds(),
                                _ => false,
                            }
                    };
                    let settled = left.settled && right.settled || decides(left) || decides(right);
                    self.push(value, settled);
                }
                Op::Jump(to) => self.at = to as usize,
                Op::JumpIfFalse(to) => {
                    if !self.pop().cell.holds() {
                        self.at = to as usize;
                    }
                }
                Op::JumpIfTrue(to) => {
                    let Entry { cell, settled } = self.pop();
                    self.is_hopeless = settled && self.read_settled && !cell.holds();
                    if cell.holds() {
                        self.at = to as usize;
                    }
                }
                Op::ForTest => {
                    let step = self.pop_number()?;
                    let limit = self.pop_number()?;
                    let value = self.pop_number()?;
                    if step == 0.0 || step.is_nan() {
                        return Err(RuntimeProblem::Step { step });
                    }
                    let goes_on = if step > 0.0 { value <= limit } else { value >= limit };
                    self.push(Cell::Bool(goes_on), true);
                }
                Op::Tick => return Ok(self.ask(Pending::Time, Request::NextTick)),
                Op::Delay => {
                    let seconds = self.pop_number()?;
                    if !(seconds.is_finite() && seconds >= 0.0) {
                        return Err(RuntimeProblem::Delay { seconds });
                    }
                    return Ok(self.ask(Pending::Time, Request::Delay(seconds)));
                }
                Op::OperandNumber => {
                    let number = self.pop_number()?;
                    self.operands.push(UnboundOperand::Number(number));
                }
                Op::OperandName(path) => {
                    let path = self.path(path)?;
                    self.operands.push(UnboundOperand::Name(path.to_string()));
                }
                Op::OperandArray(count) => {
                    let mut numbers = Vec::with_capacity(count as usize);
                    for _ in 0..count {
                        numbers.push(self.pop_number()?);
                    }
                    numbers.reverse();
                    self.operands.push(UnboundOperand::Array(numbers));
                }
                Op::OperandRead(path) => {
                    if let Some(variable) = self.variable_of(path) {
                        let number = self.variables[variable].number()?;
                        self.operands.push(UnboundOperand::Number(number));
                    } else {
                        let path = self.path(path)?;
                        return Ok(self.ask(Pending::Array, Request::ReadArray(path)));
                    }
                }
                Op::Call(call) => {
                    let operands = std::mem::take(&mut self.operands);
                    let statement = &self.program.calls[call as usize];
                    let call = EvaluatedCall {
                        mnemonic: statement.mnemonic,
                        target: statement.target.clone(),
                        control: statement.control.clone(),
                        operands,
                        line: statement.line,
                    };
                    return Ok(self.ask(Pending::Call(call.clone()), Request::Call(call)));
                }
                Op::GetAttribute(place) => {
                    let attribute = self.program.attributes[place as usize].clone();
                    return Ok(self.ask(Pending::Value, Request::GetAttribute(attribute)));
                }
                Op::SetAttribute(place) => {
                    let value = self.pop_number()?;
                    let attribute = self.program.attributes[place as usize].clone();
                    return Ok(self.ask(Pending::Write, Request::SetAttribute(attribute, value)));
                }
                Op::End => return Ok(self.ask(Pending::Ended, Request::End)),
            }
        }
    }

    fn ask(&mut self, pending: Pending, request: Request) -> Request {
        self.pending = pending;
        request
    }

    fn variable_of(&self, path: u32) -> Option<usize> {
        self.program.paths[path as usize]
            .variable
            .map(|variable| variable as usize)
    }

    /// The path with its computed indices, which are popped.
    fn path(&mut self, path: u32) -> Result<TagPath, RuntimeProblem> {
        let path = &self.program.paths[path as usize];
        let mut computed = self.stack.split_off(self.stack.len() - path.computed()).into_iter();
        let mut segments = Vec::with_capacity(path.parts.len());
        for part in &path.parts {
            segments.push(match part {
                Part::Fixed(segment) => segment.clone(),
                Part::Computed => {
                    let index = computed.next().map_or(Ok(0.0), |entry| entry.cell.number())?;
                    if index.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&index) {
                        return Err(RuntimeProblem::Index { index });
                    }
                    PathSegment::Element(index as u32)
                }
            });
        }
        Ok(TagPath(segments))
    }

    fn push(&mut self, cell: Cell, settled: bool) {
        self.stack.push(Entry { cell, settled });
    }

    fn pop(&mut self) -> Entry {
        self.stack
            .pop()
            .expect("every operation finds what the parser had pushed")
    }

    fn pop_number(&mut self) -> Result<f64, RuntimeProblem> {
        self.pop().cell.number()
    }
}

impl Pending {
    fn name(&self) -> &'static str {
        match self {
            Self::Start => "nothing yet",
            Self::Value => "the value of a tag",
            Self::Array => "the numbers of an array",
            Self::Write => "a tag to be written",
            Self::Time | Self::Again(_) => "time to pass",
            Self::Call(_) => "an instruction to be executed",
            Self::Ended => "nothing more",
        }
    }
}

impl From<Value> for Cell {
    fn from(value: Value) -> Self {
        match value {
            Value::Bool(truth) => Self::Bool(truth),
            value => Self::Number(value.as_f64()),
        }
    }
}

impl Cell {
    fn number(self) -> Result<f64, RuntimeProblem> {
        match self {
            Self::Number(number) => Ok(number),
            Self::Bool(_) => Err(RuntimeProblem::NotANumber),
        }
    }

    fn holds(self) -> bool {
        match self {
            Self::Number(number) => number != 0.0,
            Self::Bool(truth) => truth,
        }
    }

    /// A number for comparisons only.
    fn comparable(self) -> f64 {
        match self {
            Self::Number(number) => number,
            Self::Bool(truth) => f64::from(u8::from(truth)),
        }
    }

    fn value(self) -> Value {
        match self {
            Self::Number(number) => Value::Lreal(number),
            Self::Bool(truth) => Value::Bool(truth),
        }
    }
}

fn binary(operator: Binary, left: Cell, right: Cell) -> Result<Cell, RuntimeProblem> {
    let number = |of: fn(f64, f64) -> f64| Ok(Cell::Number(of(left.number()?, right.number()?)));
    let comparison = |of: fn(&f64, &f64) -> bool| Ok(Cell::Bool(of(&left.comparable(), &right.comparable())));
    let logic = |bits: fn(i64, i64) -> i64, truth: fn(bool, bool) -> bool| match (left, right) {
        (Cell::Number(left), Cell::Number(right)) => Ok(Cell::Number(bits(integer(left)?, integer(right)?) as f64)),
        _ => Ok(Cell::Bool(truth(left.holds(), right.holds()))),
    };
    match operator {
        Binary::Add => number(|a, b| a + b),
        Binary::Subtract => number(|a, b| a - b),
        Binary::Multiply => number(|a, b| a * b),
        Binary::Divide => number(|a, b| a / b),
        Binary::Modulo => number(|a, b| a % b),
        Binary::Equal => comparison(f64::eq),
        Binary::NotEqual => comparison(f64::ne),
        Binary::Less => comparison(f64::lt),
        Binary::Greater => comparison(f64::gt),
        Binary::LessEqual => comparison(f64::le),
        Binary::GreaterEqual => comparison(f64::ge),
        Binary::And => logic(|a, b| a & b, |a, b| a & b),
        Binary::Xor => logic(|a, b| a ^ b, |a, b| a ^ b),
        Binary::Or => logic(|a, b| a | b, |a, b| a | b),
    }
}

fn integer(number: f64) -> Result<i64, RuntimeProblem> {
    let whole = Value::Lreal(number).to_integer().filter(|_| number.fract() == 0.0);
    whole.ok_or(RuntimeProblem::NotAnInteger { value: number })
}
