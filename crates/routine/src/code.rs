//! Compiled routines: names are places in the memory, types are known, nothing is looked up while it runs.
//!
//! A place is a byte of the memory, or an offset from a base of the add-on instruction that runs: base 0 is the memory
//! itself, base 1 the instance, the others are parameters that are passed by reference.

use arcline_instruction_set::Call;
use arcline_tag::{DataType, Elementary};

use crate::error::Line;
use crate::table::Op;

/// Index of a text for messages.
pub(crate) type TextId = u32;

/// Texts that every project has, by their index.
pub(crate) const FIRST_TEXTS: [&str; 5] = ["", "PRE", "ACC", "LEN", "POS"];
pub(crate) const PRE: TextId = 1;
pub(crate) const ACC: TextId = 2;
pub(crate) const LEN: TextId = 3;
pub(crate) const POS: TextId = 4;

/// A byte in the memory, with subscripts that are calculated.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) base: u8,
    pub(crate) at: u32,
    pub(crate) index: Box<[Index]>,
}

impl Place {
    /// Its byte, if it is known before the project runs.
    pub(crate) fn fixed(&self) -> Option<u32> {
        (self.base == 0 && self.index.is_empty()).then_some(self.at)
    }
}

/// A subscript that is calculated.
#[derive(Clone, Debug)]
pub(crate) struct Index {
    pub(crate) value: Ex,
    /// Elements.
    pub(crate) size: u32,
    /// Bytes from one element to the next.
    pub(crate) stride: u32,
    /// The dimension of a parameter by reference: the operand of the call gives its size, and `stride` is that of the last dimension.
    pub(crate) of_operand: Option<u8>,
    /// The subscript as it is written.
    pub(crate) text: TextId,
}

/// A number in the memory.
#[derive(Clone, Debug)]
pub(crate) struct Cellular {
    pub(crate) place: Place,
    pub(crate) kind: Elementary,
}

/// A bit in the memory.
#[derive(Clone, Debug)]
pub(crate) struct Bit {
    pub(crate) place: Place,
    pub(crate) select: Select,
}

/// The reference that a call passes: an address, and the bit there for a BOOL.
#[derive(Clone, Debug)]
pub(crate) struct Referenced {
    pub(crate) place: Place,
    pub(crate) bit: Option<Select>,
    /// Its sizes; `None`: it is an array that the caller has by reference itself, with the sizes of that operand.
    pub(crate) sizes: Option<Sizes>,
}

impl Referenced {
    /// The operand of a parameter whose data nothing reads.
    pub(crate) fn nothing() -> Self {
        Referenced {
            place: Place {
                base: 0,
                at: 0,
                index: Box::default(),
            },
            bit: None,
            sizes: Some(Sizes::default()),
        }
    }
}

/// The sizes of the operand of a parameter by reference. An array may be longer than the definition says.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sizes {
    /// Elements of each dimension; 0: there is no such dimension.
    pub(crate) dimensions: [u32; 3],
    /// Bits of an array of BOOLs.
    pub(crate) bits: u32,
    /// Bytes of the whole operand.
    pub(crate) bytes: u32,
}

/// Which bit behind a place.
#[derive(Clone, Debug)]
pub(crate) enum Select {
    /// A mask of the byte there.
    Mask(u8),
    /// The bit that the call gave by reference.
    Referenced,
    /// A number below the count of bits; outside it is that fault of type 4.
    Number {
        value: Ex,
        /// `None`: those of the operand of a parameter by reference.
        bits: Option<u32>,
        text: TextId,
        fault: u16,
    },
}

/// A structure, an element or an array, as a range of bytes.
#[derive(Clone, Debug)]
pub(crate) struct Area {
    pub(crate) place: Place,
    /// The type of one element.
    pub(crate) data_type: DataType,
    /// Bytes of one element.
    pub(crate) size: u32,
    /// Elements of the innermost array; 1 for a scalar.
    pub(crate) length: u32,
    /// Dimensions of that array.
    pub(crate) dimensions: [u32; 3],
    /// Whether the array is a parameter by reference: the operand of the call gives length and dimensions.
    pub(crate) is_of_operand: bool,
    /// Whether the operand names the whole array, without subscript.
    pub(crate) is_whole: bool,
    /// Bytes from the array's beginning that constant subscripts skip.
    pub(crate) skipped: u32,
    /// The subscripts of `place` that belong to the innermost array, at its end.
    pub(crate) inner: usize,
    /// The end of the tag, from the base.
    pub(crate) end: u32,
}

/// An expression with types. Whole numbers are calculated with 64 bits; REAL is rounded after each operation.
#[derive(Clone, Debug)]
pub(crate) enum Ex {
    Integer(i64),
    Real(f64),
    /// A DINT of the memory.
    Dint(u32),
    Load(Box<Cellular>),
    Bit(Box<Bit>),
    Status(Status),
    ToReal(Box<Ex>, Width),
    ToInteger(Box<Ex>),
    Negate(Box<Ex>),
    NegateReal(Box<Ex>),
    /// Bit by bit.
    Invert(Box<Ex>),
    /// 0 becomes 1, everything else 0.
    IsZero(Box<Ex>),
    Whole(Whole, Box<(Ex, Ex)>),
    Float(Float, Width, Box<(Ex, Ex)>),
    Compare(Compare, Box<(Ex, Ex)>),
    CompareReal(Compare, Box<(Ex, Ex)>),
    CompareText(Compare, Box<(TextPart, TextPart)>),
    /// Zero-extended to the width of the source.
    Unsigned(Box<Ex>, u8),
    Function(Function, Width, Box<Ex>),
}

/// Precision of a number with a point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Width {
    Single,
    Double,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Whole {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Power,
    And,
    Or,
    Xor,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Float {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Power,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Compare {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

/// A function of one number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Function {
    /// The absolute value of whole numbers; the other functions take numbers with a point.
    AbsoluteWhole,
    Absolute,
    Sine,
    Cosine,
    Tangent,
    ArcSine,
    ArcCosine,
    ArcTangent,
    Ln,
    Log,
    Degrees,
    Radians,
    Root,
    Truncate,
    /// Whole numbers to and from BCD.
    ToBcd,
    FromBcd,
}

/// A status bit of the task or the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Status {
    FirstScan,
    Overflow,
    Zero,
    Negative,
    Carry,
    Minor,
}

/// A text: a tag or a literal.
#[derive(Clone, Debug)]
pub(crate) enum TextPart {
    Literal(Box<[u8]>),
    /// LEN, then DATA at an offset with a capacity.
    Tag {
        place: Place,
        data: u32,
        capacity: u32,
    },
}

/// An element of a rung.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    Xic(u32, u8),
    Xio(u32, u8),
    Ote(u32, u8),
    Otl(u32, u8),
    Otu(u32, u8),
    /// Arithmetic of two DINTs; the DINT at that byte has the result.
    Compute(Whole, DintOperand, DintOperand, u32),
    /// A DINT to the DINT at that byte.
    Move(DintOperand, u32),
    Compare(Compare, DintOperand, DintOperand),
    /// Arithmetic of two REALs; the REAL at that byte has the result.
    ComputeReal(Float, RealOperand, RealOperand, u32),
    /// A REAL to the REAL at that byte.
    MoveReal(RealOperand, u32),
    CompareReal(Compare, RealOperand, RealOperand),
    Ons(u32, u8),
    /// CTU or CTD of the counter at that byte.
    Count(Op, u32),
    Branch(Box<[Box<[Node]>]>),
    Instruction(Box<Instruction>),
}

/// A number that does not change, or the one at a byte of the memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum NumberOperand<T> {
    Number(T),
    At(u32),
}

pub(crate) type DintOperand = NumberOperand<i32>;
pub(crate) type RealOperand = NumberOperand<f32>;

/// An instruction with its operands.
#[derive(Clone, Debug)]
pub(crate) struct Instruction {
    pub(crate) op: Op,
    /// The mnemonic as it is written.
    pub(crate) name: TextId,
    pub(crate) arguments: Box<[Argument]>,
    /// Whether the scan evaluates the operands' subscripts with a false rung too.
    pub(crate) is_edge: bool,
}

/// An operand.
#[derive(Clone, Debug)]
pub(crate) enum Argument {
    /// `?`, or a first value that the memory has already.
    Shown,
    Bit(Bit),
    /// A whole number or a truth value.
    Integer(Ex),
    /// A number with a point.
    Real(Ex),
    /// A status bit that is written.
    Status(Status),
    /// A number that is written.
    Target(Cellular),
    Area(Area),
    Text(TextPart),
    Word(i32),
    /// Index of the answer to a message.
    Reply(u32),
    Routine(u32),
    /// Index of a rung.
    Label(u32),
    Task(u32),
    Motion(Box<MotionCall>),
    AddOn(Box<AddOnCall>),
    Transfer(Box<Transfer>),
    System(Box<System>),
}

/// Values that a call gives to a routine and takes from it.
#[derive(Clone, Debug)]
pub(crate) struct Transfer {
    pub(crate) routine: u32,
    pub(crate) inputs: Box<[Argument]>,
    /// The parameters of the routine's SBR.
    pub(crate) parameters: Box<[Argument]>,
    pub(crate) returns: Box<[Argument]>,
}

/// An instruction of motion.
#[derive(Clone, Debug)]
pub(crate) struct MotionCall {
    /// The call with all operands that do not change.
    pub(crate) call: Call,
    pub(crate) target: Option<Place>,
    pub(crate) control: Place,
    /// Operands that are read at execution: the index of each in the call, and its source.
    pub(crate) operands: Box<[(u8, MotionOperand)]>,
    /// Whether the instruction is in Structured Text: it sets DN or ER in the same scan.
    pub(crate) is_text: bool,
}

/// An operand of an instruction of motion that is read at execution.
#[derive(Clone, Debug)]
pub(crate) enum MotionOperand {
    Number(Ex),
    Array(Area),
    Object(Place),
    Tag(Area),
    Written(Area),
}

/// The answer to a message.
#[derive(Clone, Debug)]
pub(crate) struct Reply {
    /// ns from the request on.
    pub(crate) delay: u64,
    /// ERR and EXERR; ERR 0: it is answered well.
    pub(crate) error: (u16, u32),
    pub(crate) data: Box<[u8]>,
    pub(crate) destination: Option<Area>,
}

/// A call of an add-on instruction.
#[derive(Clone, Debug)]
pub(crate) struct AddOnCall {
    pub(crate) definition: u32,
    pub(crate) instance: Place,
    /// Bytes of the instance.
    pub(crate) size: u32,
    /// Copies into parameters, and out of them.
    pub(crate) inputs: Box<[Copy]>,
    pub(crate) outputs: Box<[Copy]>,
    /// Parameters by reference, in order.
    pub(crate) references: Box<[Referenced]>,
}

/// A value that a call copies. Parameters are places from base 1, in the callee.
#[derive(Clone, Debug)]
pub(crate) struct Copy {
    pub(crate) from: Argument,
    pub(crate) to: Argument,
}

/// An attribute of GSV or SSV.
#[derive(Clone, Debug)]
pub(crate) struct System {
    pub(crate) attribute: Attribute,
    /// The memory that the instruction reads or writes.
    pub(crate) area: Area,
}

/// An attribute of the controller that GSV reads.
#[derive(Clone, Debug)]
pub(crate) enum Attribute {
    WallClock(WallClock),
    Task(u32, TaskAttribute),
    /// The fault record of a program.
    Record(u32),
    DisableFlag(u32),
    /// A name, and the text that it goes into; `None`: LEN and characters go into other data.
    Name(NameOf, Option<TextPart>),
    /// A constant.
    Constant(Box<[u8]>),
    /// A number that does not change while the machine runs.
    Number(f64),
    /// A member of the tag of a motion object.
    Member(Cellular),
    MinorFaults,
    MajorFaults,
    /// The number of minor (0) or major (1) faults.
    Events(u8),
    /// An attribute that Arcline does not have; the instruction passes over it.
    Missing,
    /// An attribute of a motion object, by its number at the host.
    Host(u32),
}

/// The part of a project whose name GSV reads.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum NameOf {
    /// A program; `None`: the one that runs, also in an add-on instruction.
    Program(Option<u32>),
    /// A task, or that of the program that runs.
    Task(Option<u32>),
    /// The routine that runs.
    Routine,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum WallClock {
    DateTime,
    Microseconds,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TaskAttribute {
    Rate,
    Watchdog,
    Priority,
    Instance,
    OverlapCount,
    InhibitTask,
    Status,
    LastScanTime,
    MaxScanTime,
}

/// A routine.
#[derive(Clone, Debug)]
pub(crate) struct Routine {
    pub(crate) name: TextId,
    /// The program or add-on instruction.
    pub(crate) program: TextId,
    /// The number of the program; `None`: of an add-on instruction.
    pub(crate) of_program: Option<u32>,
    /// The number of its first step, a rung or statement; `None`: of an add-on instruction, whose steps have no operands of their own.
    pub(crate) first_step: Option<u32>,
    pub(crate) body: Body,
}

#[derive(Clone, Debug)]
pub(crate) enum Body {
    Ladder(Box<[Rung]>),
    Text(Box<[Statement]>),
}

#[derive(Clone, Debug)]
pub(crate) struct Rung {
    pub(crate) number: u32,
    pub(crate) nodes: Box<[Node]>,
    /// Whether all its instructions are of bits, numbers and counters with known places, so that they call nothing and cannot fault.
    pub(crate) is_simple: bool,
    /// Whether it can settle.
    pub(crate) settles: bool,
    /// Its only timer, if no other operand depends on the timer's time.
    pub(crate) timer: Option<RungTimer>,
    /// Instructions of the routine up to its end.
    pub(crate) behind: u32,
}

/// The timer of a rung.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RungTimer {
    /// Its first byte.
    pub(crate) at: u32,
    /// Whether other steps depend on its time.
    pub(crate) is_read: bool,
}

impl Rung {
    pub(crate) fn new(number: u32, nodes: Box<[Node]>) -> Self {
        let is_simple = |node: &Node| !matches!(node, Node::Branch(_) | Node::Instruction(_));
        Rung {
            number,
            is_simple: nodes.iter().all(is_simple),
            settles: false,
            timer: None,
            behind: 0,
            nodes,
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Statement {
    pub(crate) line: u32,
    /// Whether it can settle.
    pub(crate) settles: bool,
    pub(crate) action: Action,
}

#[derive(Clone, Debug)]
pub(crate) enum Action {
    /// Retentive or not.
    Assign(Argument, Argument, bool),
    If(Box<[(Ex, Box<[Statement]>)]>, Box<[Statement]>),
    Case(Ex, Box<[Arm]>, Box<[Statement]>),
    For(Box<Loop>),
    While(Ex, Box<[Statement]>),
    Repeat(Box<[Statement]>, Ex),
    Exit,
    Return,
    Call(Instruction),
}

#[derive(Clone, Debug)]
pub(crate) struct Loop {
    pub(crate) variable: Cellular,
    pub(crate) from: Ex,
    pub(crate) to: Ex,
    pub(crate) by: Ex,
    pub(crate) body: Box<[Statement]>,
}

#[derive(Clone, Debug)]
pub(crate) struct Arm {
    pub(crate) ranges: Box<[(Ex, Ex)]>,
    pub(crate) body: Box<[Statement]>,
}

/// An add-on instruction.
#[derive(Clone, Debug, Default)]
pub(crate) struct AddOn {
    pub(crate) logic: Option<u32>,
    pub(crate) prescan: Option<u32>,
    pub(crate) enable_in_false: Option<u32>,
    /// Byte and mask of EnableIn and EnableOut in the instance.
    pub(crate) enable_in: (u32, u8),
    pub(crate) enable_out: (u32, u8),
}

/// A program.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) name: TextId,
    pub(crate) main: Option<u32>,
    pub(crate) fault: Option<u32>,
    pub(crate) is_disabled: bool,
    /// The routines that copy Input parameters before each scan, and Output parameters behind it.
    pub(crate) before: Option<u32>,
    pub(crate) behind: Option<u32>,
}

/// A task.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    pub(crate) name: TextId,
    pub(crate) when: When,
    /// Time without its event after which an event task runs, ns.
    pub(crate) timeout: Option<u64>,
    pub(crate) priority: u32,
    pub(crate) watchdog_us: i32,
    pub(crate) is_inhibited: bool,
    pub(crate) programs: Box<[u32]>,
}

/// When a task runs, ns.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum When {
    Continuous,
    Periodic(u64),
    /// Each coarse update.
    Motion,
    /// The instruction EVENT alone triggers the task.
    Triggered,
    /// When this bit of the memory becomes true.
    Bit {
        at: u32,
        mask: u8,
    },
    /// When one of these bytes of the memory has changed.
    Change {
        from: u32,
        to: u32,
    },
}

/// A bit that always stands at the same place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct FixedBit {
    pub(crate) at: u32,
    pub(crate) mask: u8,
}

/// A wire.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wire {
    pub(crate) from: FixedBit,
    pub(crate) to: End,
    /// ns.
    pub(crate) delay: u64,
}

/// The end of a wire.
#[derive(Clone, Copy, Debug)]
pub(crate) enum End {
    /// A bit, and the one that says that the connection of its module is lost.
    Bit(FixedBit, Option<FixedBit>),
    /// An input of an axis, by its number at the host.
    Input(u32),
}

/// Everything compiled.
#[derive(Clone, Debug, Default)]
pub(crate) struct Code {
    pub(crate) routines: Vec<Routine>,
    pub(crate) add_ons: Vec<AddOn>,
    pub(crate) programs: Vec<Program>,
    pub(crate) tasks: Vec<Task>,
    pub(crate) fault_handler: Option<u32>,
    pub(crate) replies: Vec<Reply>,
    pub(crate) wires: Vec<Wire>,
    pub(crate) texts: Vec<String>,
    /// Whether a routine names a status bit of arithmetic.
    pub(crate) uses_flags: bool,
}

impl Task {
    /// The longest time of a run, µs: that of a continuous task without one is longer (spec/programs.md §8).
    pub(crate) fn longest_us(&self) -> i32 {
        if self.watchdog_us == 0 && self.when == When::Continuous {
            LONGEST_CONTINUOUS_US
        } else {
            self.watchdog_us
        }
    }
}

/// The watchdog of a continuous task without one, µs.
const LONGEST_CONTINUOUS_US: i32 = 5_000_000;

impl Code {
    pub(crate) fn text(&self, id: TextId) -> &str {
        self.texts.get(id as usize).map_or("", String::as_str)
    }

    /// The place in a routine in the words of its language.
    pub(crate) fn line(&self, routine: u32, number: u32) -> Line {
        match self.routines.get(routine as usize).map(|routine| &routine.body) {
            Some(Body::Text(_)) => Line::Text(number),
            _ => Line::Rung(number),
        }
    }
}
