//! Motion instructions as CIP services, and their status.

use std::time::Duration;

use bytes::{Bytes, BytesMut};
use tokio::time::Instant;

use arcline_instruction_set::{BindError, Flag, Kind, Mnemonic, MotionControl, Operand, OperandIndex, UnboundOperand};
use arcline_proto::arcline::{execution, motion::Accepted};
use arcline_proto::cip::{CipStatus, Reply, Request, service};
use arcline_proto::epath::Epath;
use arcline_proto::logix::{Typed, encode_operands};
use arcline_proto::wire::Reader;
use arcline_tag::{Elementary, Value};

use crate::{Client, ClientError, TagValue};

/// The status bits of an axis in motion.
const AXIS_MOVES: &[&str] = &[
    "MoveStatus",
    "JogStatus",
    "HomingStatus",
    "StoppingStatus",
    "CoordinatedMotionStatus",
];
/// The status bits of a coordinate system in motion.
const SYSTEM_MOVES: &[&str] = &["MotionStatus", "MoveStatus", "MoveTransitionStatus", "StoppingStatus"];
/// Time between two reads of an instruction's status.
const POLL: Duration = Duration::from_millis(5);

/// An instruction that the server has executed.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Execution {
    /// The instruction.
    pub mnemonic: Mnemonic,
    /// The motion object it acts on.
    pub target: String,
    /// Its motion control tag; empty: none.
    pub tag: String,
    /// Instance of class 0x0303; the server keeps the newest 4,096, and older ones that run.
    pub instance: u32,
    /// Its status when the server answered.
    pub control: MotionControl,
}

impl Execution {
    /// Whether the instruction has a PC, which comes unless the instruction is stopped.
    pub fn completes(&self) -> bool {
        self.mnemonic.instruction().bits.contains(&Flag::Pc)
    }
}

/// The operands of an instruction behind target and motion control, by name.
#[derive(Clone, PartialEq, Debug)]
pub struct Operands {
    mnemonic: Mnemonic,
    operands: Vec<UnboundOperand>,
}

impl Operands {
    /// The first values of an instruction tag: for moves a full-speed S-curve.
    ///
    /// ```
    /// use arcline_client::{Mnemonic, Operands};
    ///
    /// let operands = Operands::full_speed(Mnemonic::Mclm).with("Position", vec![10.0, 0.0, 0.0])?.with("Speed", 50.0)?;
    /// assert_eq!(operands.as_slice().len(), 20);
    /// # Ok::<(), arcline_client::ClientError>(())
    /// ```
    pub fn full_speed(mnemonic: Mnemonic) -> Self {
        let instruction = mnemonic.instruction();
        let operands = instruction
            .operands_behind_control()
            .filter_map(|index| instruction.operands.get(index));
        let operands = operands.map(|operand| match operand.kind {
            Kind::Array(_) | Kind::Object(_) | Kind::Structure(_) | Kind::StructureOrNone(_) => UnboundOperand::Missing,
            _ => UnboundOperand::Number(operand.initial.into()),
        });
        Self {
            mnemonic,
            operands: operands.collect(),
        }
    }

    /// Sets an operand, by its name on the faceplate or its member name, case and blanks ignored.
    ///
    /// # Errors
    /// [`ClientError::UnknownOperand`].
    pub fn with(mut self, name: &str, value: impl Into<UnboundOperand>) -> Result<Self, ClientError> {
        let instruction = self.mnemonic.instruction();
        let unknown = || ClientError::UnknownOperand {
            mnemonic: self.mnemonic,
            name: name.to_owned(),
            suggestion: crate::nearest(name, instruction.operands.iter().map(Operand::member)),
        };
        let index = instruction.operand(name).ok_or_else(unknown)?;
        let index = instruction
            .operands_behind_control()
            .position(|place| place == index)
            .ok_or_else(unknown)?;
        if let Some(slot) = self.operands.get_mut(index) {
            *slot = value.into();
        }
        Ok(self)
    }

    /// The instruction.
    pub fn mnemonic(&self) -> Mnemonic {
        self.mnemonic
    }

    /// In faceplate order, for [`Client::execute`].
    pub fn as_slice(&self) -> &[UnboundOperand] {
        &self.operands
    }
}

impl Client {
    /// Executes an instruction on the group, axis or coordinate system `target` (empty: an instruction without a target, as MCCP), under the
    /// motion control tag `control` (made on first use; empty: none). `operands` are the operands behind target and motion control in faceplate order,
    /// trailing ones may be missing; numbers travel as LREAL.
    ///
    /// The answer comes when DN or ER is set, of homing when it is in process: its DN is its end.
    ///
    /// # Errors
    /// [`ClientError::Motion`] with ERR and EXERR, [`ClientError::Operand`] for a word or type that the operand does not
    /// have, [`ClientError::UnknownObject`]; otherwise an error of the connection. After a timeout the caller does not know whether
    /// the instruction has been executed.
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// use arcline_client::{UnboundOperand, Mnemonic};
    ///
    /// client.execute(Mnemonic::Mso, "X", "", &[]).await?;
    /// client.execute(Mnemonic::Mcs, "CS1", "Stop1", &[UnboundOperand::Word("All".into())]).await?;
    /// # Ok(())
    /// # }
    /// ```
    pub async fn execute(
        &self,
        mnemonic: Mnemonic,
        target: &str,
        control: &str,
        operands: &[UnboundOperand],
    ) -> Result<Execution, ClientError> {
        self.check_target(mnemonic, target).await?;
        let reply = self.request(request_of(mnemonic, target, control, operands)?).await?;
        if !reply.status.is_success() {
            let refusal = self.refusal(mnemonic, target, &reply).await;
            return Err(name_missing_operand(refusal, mnemonic, operands));
        }
        let accepted = Accepted::decode(&reply.data).ok_or(ClientError::Malformed {
            what: "the answer to an instruction is cut",
        })?;
        let status = MotionControl::from_bytes(accepted.control);
        check(&status, Some(mnemonic)).map_err(|error| name_missing_operand(error, mnemonic, operands))?;
        let (target, tag) = (target.to_owned(), control.to_owned());
        Ok(Execution {
            mnemonic,
            target,
            tag,
            instance: accepted.instance,
            control: status,
        })
    }

    /// The status of an executed instruction.
    ///
    /// # Errors
    /// [`ClientError::Refused`] with 0x16 when the server has dropped it, long after its end; otherwise an error of the connection.
    pub async fn instruction(&self, instance: u32) -> Result<MotionControl, ClientError> {
        let path = Epath::object(execution::CLASS, instance);
        let what = "the instruction's status";
        let reply = self.ask(what, service::GET_ATTRIBUTES_ALL, path, Bytes::new()).await?;
        let bytes = Reader::new(&reply.data).array::<{ MotionControl::SIZE }>();
        bytes.map(MotionControl::from_bytes).ok_or(ClientError::Malformed {
            what: "an instruction's status is cut",
        })
    }

    /// Waits until a bit of an executed instruction is set.
    ///
    /// # Errors
    /// [`ClientError::Motion`] when the instruction errs, [`ClientError::Ended`] when the motion ends without the bit,
    /// [`ClientError::Deadline`], [`ClientError::Forgotten`]; otherwise as [`Client::instruction`].
    pub async fn wait_for(
        &self,
        execution: &Execution,
        flag: Flag,
        deadline: Duration,
    ) -> Result<MotionControl, ClientError> {
        let end = Instant::now() + deadline;
        loop {
            let control = match self.instruction(execution.instance).await {
                Err(ClientError::Refused { status, .. }) if status.is(CipStatus::OBJECT_DOES_NOT_EXIST) => {
                    let (mnemonic, target) = (execution.mnemonic, execution.target.clone());
                    return Err(ClientError::Forgotten { mnemonic, target });
                }
                control => control?,
            };
            if let Some(result) = outcome(&control, flag, Some(execution.mnemonic)) {
                return match result {
                    Err(ClientError::Ended { flag, control, .. }) => {
                        let ended = self.ending(execution.instance).await?.map(Box::new);
                        Err(ClientError::Ended { flag, control, ended })
                    }
                    result => result,
                };
            }
            if Instant::now() >= end {
                return Err(ClientError::Deadline { flag, after: deadline });
            }
            tokio::time::sleep(POLL).await;
        }
    }

    /// Whether an axis or a coordinate system moves, is in the process of an instruction, or is being stopped, as its tag shows.
    ///
    /// # Errors
    /// As [`Client::read`].
    pub async fn is_moving(&self, target: &str) -> Result<bool, ClientError> {
        let reading = self.read(target).await?;
        let bits = match reading.member("CommandVelocity").and_then(TagValue::as_f64) {
            Some(velocity) if velocity != 0.0 => return Ok(true),
            Some(_) => AXIS_MOVES,
            None => SYSTEM_MOVES,
        };
        Ok(bits.iter().any(|bit| reading.flag(bit)))
    }

    /// Refuses a target of another kind than the instruction acts on: the service of one instruction on axes is that of another
    /// instruction on coordinate systems, so the kind is looked up before the request leaves.
    pub(crate) async fn check_target(&self, mnemonic: Mnemonic, target: &str) -> Result<(), ClientError> {
        match self.tag(target).await.ok().and_then(|tag| tag.object()) {
            Some(is) if is != mnemonic.instruction().object => {
                let name = target.to_owned();
                Err(ClientError::WrongObject { mnemonic, name, is })
            }
            Some(_) | None => Ok(()),
        }
    }

    /// The error that a refusal of an instruction means.
    pub(crate) async fn refusal(&self, mnemonic: Mnemonic, target: &str, reply: &Reply) -> ClientError {
        let object = mnemonic.instruction().object;
        match (reply.status.general(), reply.status.additional()) {
            (general, [err, exerr, ..]) if general == CipStatus::VENDOR_SPECIFIC.general() => ClientError::Motion {
                mnemonic: Some(mnemonic),
                err: err.cast_signed(),
                // The word is the sign-extended byte.
                exerr: exerr.cast_signed() as i8,
            },
            (general, _) if general == CipStatus::PATH_DESTINATION_UNKNOWN.general() => {
                let names = self.objects(object).await.unwrap_or_default();
                ClientError::unknown_object(object, target, names)
            }
            _ => match self.tag(target).await.ok().and_then(|tag| tag.object()) {
                Some(is) if is != object => ClientError::WrongObject {
                    mnemonic,
                    name: target.to_owned(),
                    is,
                },
                _ => ClientError::refused(format!("{mnemonic} on {target}"), reply.status),
            },
        }
    }
}

/// The result of waiting for a flag, if there is one yet.
pub(crate) fn outcome(
    control: &MotionControl,
    flag: Flag,
    mnemonic: Option<Mnemonic>,
) -> Option<Result<MotionControl, ClientError>> {
    if control.has(flag) {
        return Some(Ok(*control));
    }
    if let Err(error) = check(control, mnemonic) {
        return Some(Err(error));
    }
    let over = control.has(Flag::Dn) && !control.has(Flag::Ip);
    (over && flag != Flag::Dn).then_some(Err(ClientError::Ended {
        flag,
        control: *control,
        ended: None,
    }))
}

/// Says so where the operand at fault was left out.
pub(crate) fn name_missing_operand(error: ClientError, mnemonic: Mnemonic, operands: &[UnboundOperand]) -> ClientError {
    let Some((err, exerr)) = error.motion() else {
        return error;
    };
    match mnemonic.instruction().left_out(err, exerr, operands) {
        Some(operand) => ClientError::MissingOperand {
            mnemonic,
            operand,
            err,
            exerr,
        },
        None => error,
    }
}

/// ER is an error.
fn check(control: &MotionControl, mnemonic: Option<Mnemonic>) -> Result<(), ClientError> {
    if control.has(Flag::Er) {
        Err(ClientError::Motion {
            mnemonic,
            err: control.err,
            exerr: control.exerr,
        })
    } else {
        Ok(())
    }
}

/// The request to execute an instruction.
pub(crate) fn request_of(
    mnemonic: Mnemonic,
    target: &str,
    control: &str,
    operands: &[UnboundOperand],
) -> Result<Request, ClientError> {
    let instruction = mnemonic.instruction();
    let (class, service) = instruction.service();
    let data = encode(mnemonic, control, operands)?;
    // An instruction without a target is one of the motion group, which is instance 1.
    let path = match (target, instruction.has_target()) {
        ("", false) => Epath::object(class, 1),
        _ => Epath::symbol(target),
    };
    Ok(Request::new(service, path, data))
}

/// The request data of an instruction.
fn encode(mnemonic: Mnemonic, control: &str, operands: &[UnboundOperand]) -> Result<BytesMut, ClientError> {
    let instruction = mnemonic.instruction();
    let indices: Vec<usize> = instruction.operands_behind_control().collect();
    let used = operands
        .iter()
        .rposition(|operand| *operand != UnboundOperand::Missing)
        .map_or(0, |last| last + 1);
    let operands = operands.get(..used).unwrap_or_default();
    if operands.len() > indices.len() {
        return Err(BindError::TooMany {
            mnemonic,
            count: operands.len(),
            most: indices.len(),
        }
        .into());
    }
    let mut typed_operands = vec![Typed::ShortString(control.to_owned())];
    for (value, index) in operands.iter().zip(indices) {
        let kind = instruction
            .operands
            .get(index)
            .map_or(&Kind::MotionControl, |operand| &operand.kind);
        typed_operands.push(typed(value, kind).ok_or_else(|| {
            let operand = OperandIndex(u8::try_from(index).unwrap_or(u8::MAX));
            match (value, kind) {
                (UnboundOperand::Word(word) | UnboundOperand::Name(word), Kind::Word(_)) => BindError::UnknownWord {
                    mnemonic,
                    operand,
                    word: word.chars().take(60).collect(),
                },
                (value, _) => BindError::WrongType {
                    mnemonic,
                    operand,
                    value: value.clone(),
                    expected: "a number",
                },
            }
        })?);
    }
    let mut data = BytesMut::new();
    encode_operands(&typed_operands, &mut data);
    Ok(data)
}

/// An operand as it travels; `None` when the operand cannot take it.
fn typed(operand: &UnboundOperand, kind: &Kind) -> Option<Typed> {
    let number = |number| Typed::Numbers(Elementary::Lreal, vec![Value::Lreal(number)]);
    let integer = |integer| match i32::try_from(integer) {
        Ok(small) => Typed::Numbers(Elementary::Dint, vec![Value::Dint(small)]),
        Err(_) => Typed::Numbers(Elementary::Lint, vec![Value::Lint(integer)]),
    };
    Some(match (operand, kind) {
        (UnboundOperand::Missing, _) => integer(0),
        (UnboundOperand::Number(value), _) => number(*value),
        (UnboundOperand::Integer(value), _) => integer(*value),
        (UnboundOperand::Array(values), _) if values.is_empty() => return None,
        (UnboundOperand::Array(values), _) => {
            Typed::Numbers(Elementary::Lreal, values.iter().copied().map(Value::Lreal).collect())
        }
        (UnboundOperand::Word(word) | UnboundOperand::Name(word), Kind::Word(words)) => {
            integer(words.parse_word(word)?.into())
        }
        (
            UnboundOperand::Word(name) | UnboundOperand::Name(name),
            Kind::Object(_) | Kind::Structure(_) | Kind::StructureOrNone(_) | Kind::WrittenArray(_),
        ) => {
            if name.eq_ignore_ascii_case("none") {
                integer(0)
            } else {
                Typed::ShortString(name.clone())
            }
        }
        (UnboundOperand::Word(name), Kind::ArrayOrNone) if name.eq_ignore_ascii_case("none") => integer(0),
        (UnboundOperand::Word(_) | UnboundOperand::Name(_), _) => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcline_proto::logix::decode_operands;

    #[test]
    fn operands_travel_by_kind() {
        let operands = [
            UnboundOperand::Word("Absolute".into()),
            UnboundOperand::Array(vec![1.0, 2.5]),
            UnboundOperand::Number(50.0),
            UnboundOperand::Word("Unitspersec".into()),
            UnboundOperand::Missing,
        ];
        let data = encode(Mnemonic::Mclm, "Move1", &operands).expect("encodes");
        let dint = |number| Typed::Numbers(Elementary::Dint, vec![Value::Dint(number)]);
        let lreals =
            |numbers: &[f64]| Typed::Numbers(Elementary::Lreal, numbers.iter().copied().map(Value::Lreal).collect());
        let expected = vec![
            Typed::ShortString("Move1".into()),
            dint(0),
            lreals(&[1.0, 2.5]),
            lreals(&[50.0]),
            dint(0),
        ];
        assert_eq!(
            decode_operands(&data),
            Ok(expected),
            "the last one, missing, is left out"
        );
    }

    #[test]
    fn wrong_operands_are_named() {
        #[rustfmt::skip]
        let cases: &[(&str, &[UnboundOperand], &str)] = &[
            ("an unknown word", &[UnboundOperand::Word("Relative".into())],
             "MCLM: operand 2 (Move Type) is \"Relative\", expected one of Absolute (0), Incremental (1)"),
            ("a name for a number", &[0.0.into(), vec![1.0].into(), UnboundOperand::Name("Fast".into())],
             "MCLM: operand 4 (Speed) is \"Fast\", expected a number"),
        ];
        for (why, operands, expected) in cases {
            let error = encode(Mnemonic::Mclm, "", operands).expect_err(why);
            assert_eq!(error.to_string(), *expected, "{why}");
        }
        let many = vec![UnboundOperand::Integer(0); 30];
        assert!(encode(Mnemonic::Mso, "", &many).is_err(), "too many");
    }

    #[test]
    fn waiting_ends_as_the_bits_say() {
        let control = |flags: &[Flag]| MotionControl {
            flags: flags.iter().map(|flag| flag.mask()).sum(),
            ..MotionControl::default()
        };
        let done = |flags: &[Flag], flag| outcome(&control(flags), flag, None).map(|result| result.is_ok());
        assert_eq!(done(&[Flag::En, Flag::Dn, Flag::Ip], Flag::Pc), None, "runs");
        assert_eq!(done(&[Flag::En], Flag::Dn), None, "not done yet");
        assert_eq!(done(&[Flag::Dn, Flag::Pc], Flag::Pc), Some(true), "complete");
        assert_eq!(done(&[Flag::Dn], Flag::Pc), Some(false), "stopped");
        assert_eq!(
            done(&[Flag::Dn, Flag::Er], Flag::Pc),
            Some(false),
            "failed when it became active"
        );
        assert_eq!(done(&[Flag::En, Flag::Er], Flag::Dn), Some(false), "refused");
    }
}
