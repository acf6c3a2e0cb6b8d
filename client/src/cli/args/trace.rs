//! `trace`: which signals, from when on, and for how long.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use arcline_client::{Flag, Trigger};

use super::values::seconds;

#[derive(Args, Debug)]
pub(crate) struct Trace {
    /// Axes (command position, velocity, acceleration, actual position), coordinate systems (path speed and position), or
    /// single signals such as `X.PositionError`; by default every axis
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Duration from the trigger on; by default until Ctrl-C
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) duration: Option<f64>,
    /// The file to write; `-`: CSV on the standard output
    #[arg(short, long, value_name = "OUT.csv|.mcap|-")]
    pub(crate) output: PathBuf,
    /// Only every nth tick
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) every: u16,
    /// Begin when a signal rises to (X.PositionError>=0.1) or falls to a level (<=), a bit becomes true (X.MoveStatus) or
    /// false (!X.MoveStatus), or a bit of an instruction is set (Move1:AC, MCLM:ER)
    #[arg(long, value_name = "TRIGGER")]
    pub(crate) trigger: Option<TriggerText>,
    /// Seconds in front of the trigger
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "trigger")]
    pub(crate) before: Option<f64>,
}

/// A trigger as it is written.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct TriggerText(pub(crate) Trigger);

impl FromStr for TriggerText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let wrong =
            || format!("{text:?} is no trigger, expected such as X.PositionError>=0.1, !X.MoveStatus or Move1:AC");
        if let Some((signal, level)) = text.split_once(['>', '<']) {
            let level = level.strip_prefix('=').unwrap_or(level).trim();
            let level = level
                .parse()
                .ok()
                .filter(|level: &f64| level.is_finite())
                .ok_or_else(wrong)?;
            let signal = signal.trim().to_owned();
            return Ok(Self(if text.contains('>') {
                Trigger::Rises { signal, level }
            } else {
                Trigger::Falls { signal, level }
            }));
        }
        if let Some((name, flag)) = text.split_once(':') {
            let flag = Flag::ALL
                .iter()
                .find(|known| known.name().eq_ignore_ascii_case(flag.trim()));
            let flags = flag.ok_or_else(wrong)?.mask();
            let name = name.trim().to_owned();
            return Ok(Self(Trigger::Instruction { name, flags }));
        }
        let (signal, becomes) = match text.strip_prefix('!') {
            Some(signal) => (signal, false),
            None => (text, true),
        };
        if !signal.contains('.') {
            return Err(wrong());
        }
        let signal = signal.trim().to_owned();
        Ok(Self(if becomes {
            Trigger::BecomesTrue { signal }
        } else {
            Trigger::BecomesFalse { signal }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triggers_are_read() {
        let signal = || "X.PositionError".to_owned();
        let instruction = |name: &str, flag: Flag| Trigger::Instruction {
            name: name.to_owned(),
            flags: flag.mask(),
        };
        for (text, expected) in [
            (
                "X.PositionError>=0.1",
                Some(Trigger::Rises {
                    signal: signal(),
                    level: 0.1,
                }),
            ),
            (
                "X.PositionError > -2",
                Some(Trigger::Rises {
                    signal: signal(),
                    level: -2.0,
                }),
            ),
            (
                "X.PositionError<=5",
                Some(Trigger::Falls {
                    signal: signal(),
                    level: 5.0,
                }),
            ),
            ("X.PositionError", Some(Trigger::BecomesTrue { signal: signal() })),
            ("!X.PositionError", Some(Trigger::BecomesFalse { signal: signal() })),
            ("Move1:ac", Some(instruction("Move1", Flag::Ac))),
            ("MCLM:ER", Some(instruction("MCLM", Flag::Er))),
            ("MCLM:XX", None),
            ("X>=a", None),
            ("X", None),
        ] {
            assert_eq!(text.parse::<TriggerText>().ok().map(|text| text.0), expected, "{text}");
        }
    }
}
