//! Enumerations and their spellings.
//!
//! Keywords are compared without case, blanks, `-`, `_`, and with superscript digits as plain ones, so that
//! `% of Time`, `%ofTime`, `S-curve` and `unitspersec²` are read as the reference pages print them.

/// One value of an enumeration.
#[derive(Debug, PartialEq, Eq)]
pub struct Word {
    /// The number.
    pub value: i32,
    /// As a faceplate shows it.
    pub title: &'static str,
    /// Further spellings in [`normalized`] form; the normalized title always counts.
    pub keywords: &'static [&'static str],
}

/// An enumeration.
#[derive(Debug, PartialEq, Eq)]
pub struct Words {
    /// What it is called.
    pub name: &'static str,
    /// The legal values, ascending.
    pub words: &'static [Word],
    /// Words that are understood and are out of range here: units of other instructions.
    pub reserved: &'static [Word],
}

impl Words {
    /// The value of a word, if it is one of this enumeration, reserved ones included.
    pub fn parse_word(&self, text: &str) -> Option<i32> {
        let text = normalized(text);
        let all = self.words.iter().chain(self.reserved);
        all.into_iter()
            .find(|word| word.keywords.contains(&text.as_str()) || normalized(word.title) == text)
            .map(|word| word.value)
    }

    /// The word of a value, reserved ones included.
    pub fn word(&self, value: i32) -> Option<&'static Word> {
        self.words.iter().chain(self.reserved).find(|word| word.value == value)
    }

    /// Whether the value is legal. Real-time.
    pub fn contains(&self, value: i32) -> bool {
        self.words.iter().any(|word| word.value == value)
    }

    /// The words with their values, for messages and help: `ActualTolerance (0), NoSettle (1)`.
    pub fn choices(&self) -> String {
        let one = |word: &Word| format!("{} ({})", word.keyword(), word.value);
        self.words.iter().map(one).collect::<Vec<_>>().join(", ")
    }
}

impl Word {
    /// The spelling for Structured Text: the title without blanks.
    pub fn keyword(&self) -> String {
        self.title
            .chars()
            .filter(|c| !c.is_whitespace())
            .map(plain_digit)
            .collect()
    }
}

/// The form in which words are compared.
pub fn normalized(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_whitespace() && !matches!(c, '-' | '_'))
        .map(plain_digit)
        .flat_map(char::to_lowercase)
        .collect()
}

fn plain_digit(c: char) -> char {
    match c {
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        other => other,
    }
}

macro_rules! words {
    ($($(#[$doc:meta])* $constant:ident $name:literal { $($value:literal $title:literal $([$($keyword:literal),*])?),* $(,)? }
       $(reserved { $($r_value:literal $r_title:literal),* $(,)? })?;)*) => {
        $($(#[$doc])* pub static $constant: Words = Words {
            name: $name,
            words: &[$(Word { value: $value, title: $title, keywords: &[$($($keyword),*)?] }),*],
            reserved: &[$($(Word { value: $r_value, title: $r_title, keywords: &[] }),*)?],
        };)*

        /// Every enumeration.
        pub static ALL: &[&Words] = &[$(&$constant),*];
    };
}

/// The enumerations, by the operand that takes them.
pub mod list {
    use super::{Word, Words};

    words! {
        /// MCLM, MCCM.
        MOVE_TYPE "Move Type" { 0 "Absolute", 1 "Incremental" };
        /// MCCM.
        CIRCLE_TYPE "Circle Type" { 0 "Via", 1 "Center", 2 "Radius", 3 "Center Incremental" };
        /// MCCM: names for two dimensions; Shortest and Longest for three.
        DIRECTION "Direction" {
            0 "CW" ["clockwise", "shortest"], 1 "CCW" ["counterclockwise", "longest"],
            2 "CW Full" ["clockwisefull", "shortestfull"], 3 "CCW Full" ["counterclockwisefull", "longestfull"],
        };
        /// MCLM, MCCM, MCCD, MAJ, MCD.
        SPEED_UNITS "Speed Units" {
            0 "Units per sec", 1 "% of Maximum", 4 "Units per MasterUnit",
        } reserved { 3 "Seconds", 7 "Master Units" };
        /// MAM.
        MAM_SPEED_UNITS "Speed Units" {
            0 "Units per sec", 1 "% of Maximum", 3 "Seconds", 4 "Units per MasterUnit", 7 "Master Units",
        };
        /// MCLM, MCCM, MCCD, MAJ, MCD: acceleration and deceleration.
        RATE_UNITS "Accel/Decel Units" {
            0 "Units per sec²", 1 "% of Maximum", 4 "Units per MasterUnit²",
        } reserved { 3 "Seconds", 7 "Master Units" };
        /// MAM.
        MAM_RATE_UNITS "Accel/Decel Units" {
            0 "Units per sec²", 1 "% of Maximum", 3 "Seconds", 4 "Units per MasterUnit²", 7 "Master Units",
        };
        /// MCS, MAS, MAG: always in time.
        STOP_RATE_UNITS "Decel Units" {
            0 "Units per sec²", 1 "% of Maximum",
        } reserved { 3 "Seconds", 4 "Units per MasterUnit²", 7 "Master Units" };
        /// MCLM, MCCM, MCCD, MAJ, MCD.
        JERK_UNITS "Jerk Units" {
            0 "Units per sec³", 1 "% of Maximum", 2 "% of Time", 4 "Units per MasterUnit³",
            6 "% of Time-Master Driven",
        } reserved { 3 "Seconds", 7 "Master Units" };
        /// MAM.
        MAM_JERK_UNITS "Jerk Units" {
            0 "Units per sec³", 1 "% of Maximum", 2 "% of Time", 3 "Seconds", 4 "Units per MasterUnit³",
            6 "% of Time-Master Driven", 7 "Master Units",
        };
        /// MCS, MAS: always in time.
        STOP_JERK_UNITS "Jerk Units" {
            0 "Units per sec³", 1 "% of Maximum", 2 "% of Time",
        } reserved { 3 "Seconds", 4 "Units per MasterUnit³", 6 "% of Time-Master Driven", 7 "Master Units" };
        /// Velocity profile.
        PROFILE "Profile" { 0 "Trapezoidal", 1 "S-curve" };
        /// MCLM, MCCM.
        TERMINATION_TYPE "Termination Type" {
            0 "Actual Tolerance", 1 "No Settle", 2 "Command Tolerance", 3 "No Decel",
            4 "Follow Contour Velocity Constrained" ["contourvelocityconstrained"],
            5 "Follow Contour Velocity Unconstrained" ["contourvelocityunconstrained"],
            6 "Command Tolerance Programmed",
        };
        /// MCLM, MCCM.
        MERGE "Merge" { 0 "Disabled", 1 "Coordinated Motion", 2 "All Motion" };
        /// MAM, MAJ.
        AXIS_MERGE "Merge" { 0 "Disabled", 1 "Enabled" };
        /// Merge Speed.
        MERGE_SPEED "Merge Speed" { 0 "Programmed", 1 "Current" };
        /// Master driven moves.
        LOCK_DIRECTION "Lock Direction" {
            0 "None", 1 "Immediate Forward Only", 2 "Immediate Reverse Only",
            3 "Position Forward Only" ["positionforward"], 4 "Position Reverse Only" ["positionreverse"],
        };
        /// The "Change …" operands.
        NO_YES "Change" { 0 "No", 1 "Yes" };
        /// MCCD.
        MCCD_MOTION_TYPE "Motion Type" { 1 "Coordinated Move" };
        /// MCCD.
        SCOPE "Scope" { 0 "Active Motion", 1 "Active and Pending Motion" };
        /// MCS.
        MCS_STOP_TYPE "Stop Type" { 0 "All", 2 "Coordinated Move", 3 "Coordinated Transform" };
        /// MAS.
        MAS_STOP_TYPE "Stop Type" {
            0 "All", 1 "Jog", 2 "Move", 3 "Gear", 4 "Home", 5 "Tune", 6 "Test", 7 "Time Cam", 8 "Position Cam",
            9 "Master Offset Move", 10 "Direct Control",
        };
        /// MGS.
        STOP_MODE "Stop Mode" { 0 "Programmed", 1 "Fast Stop", 2 "Fast Disable" };
        /// MAJ.
        JOG_DIRECTION "Direction" { 0 "Forward", 1 "Reverse" };
        /// MAM.
        MAM_MOVE_TYPE "Move Type" {
            0 "Absolute", 1 "Incremental", 2 "Rotary Shortest Path", 3 "Rotary Positive", 4 "Rotary Negative",
            5 "Absolute Master Offset", 6 "Incremental Master Offset",
        };
        /// MAG, MAPC, MATC.
        GEAR_DIRECTION "Direction" { 0 "Same", 1 "Opposite", 2 "Reverse", 3 "Unchanged" };
        /// Master position that a slave follows.
        MASTER_REFERENCE "Master Reference" { 0 "Actual", 1 "Command" };
        /// MAG.
        RATIO_FORMAT "Ratio Format" { 0 "Real", 1 "Fraction" ["fractionslavemastercounts"] };
        /// MAG; the reverse of Merge.
        CLUTCH "Clutch" { 0 "Enabled", 1 "Disabled" };
        /// MCD.
        MCD_MOTION_TYPE "Motion Type" { 0 "Jog", 1 "Move" };
        /// MRP.
        REDEFINE_TYPE "Type" { 0 "Absolute", 1 "Relative" };
        /// MRP.
        POSITION_SELECT "Position Select" { 0 "Actual", 1 "Command" };
        /// MDAC.
        MDAC_MOTION_TYPE "Motion Type" { 0 "All", 1 "Move", 2 "Jog", 3 "Time Cam", 4 "Master Offset Move" };
        /// MAPC.
        EXECUTION_MODE "Execution Mode" { 0 "Once", 1 "Continuous", 2 "Persistent" };
        /// MATC.
        TIME_CAM_EXECUTION_MODE "Execution Mode" { 0 "Once", 1 "Continuous" };
        /// MAPC.
        EXECUTION_SCHEDULE "Execution Schedule" {
            0 "Immediate", 1 "Pending", 2 "Forward Only", 3 "Reverse Only", 4 "Bidirectional",
        };
        /// MATC.
        TIME_CAM_EXECUTION_SCHEDULE "Execution Schedule" { 0 "Immediate", 1 "Pending" };
        /// MAPC.
        MASTER_DIRECTION "Master Direction" { 0 "Bidirectional", 1 "Forward Only", 2 "Reverse Only" };
        /// MAW.
        WATCH_TRIGGER "Trigger Condition" { 0 "Forward", 1 "Reverse" };
        /// MAR.
        REGISTRATION_TRIGGER "Trigger Condition" { 0 "Positive Edge", 1 "Negative Edge" };
        /// MAR.
        WINDOWED "Windowed Registration" { 0 "Disabled", 1 "Enabled" };
        /// MAOC: what the cam follows of its axis.
        POSITION_REFERENCE "Position Reference" { 0 "Actual", 1 "Command" };
        /// MDOC.
        DISARM_TYPE "Disarm Type" { 0 "All", 1 "Specific" };
        /// MATC.
        INSTRUCTION_MODE "Instruction Mode" { 0 "Time Driven Mode", 1 "Master Driven Mode" };
        /// MCTP, MCTPO.
        TRANSFORM_DIRECTION "Transform Direction" {
            0 "Forward", 1 "Inverse", 2 "Inverse Left Arm",
            3 "Inverse Left Arm Mirror" ["inverselftarmmirror"], 4 "Inverse Right Arm", 5 "Inverse Right Arm Mirror",
        };
    }
}

#[cfg(test)]
mod tests {
    use super::list::*;
    use super::*;

    #[test]
    fn words_of_the_seeds_are_read() {
        #[rustfmt::skip]
        let cases: &[(&Words, &str, i32)] = &[
            (&SPEED_UNITS, "Unitspersec", 0), (&SPEED_UNITS, "%ofmaximum", 1), (&SPEED_UNITS, "unitspermasterunit", 4),
            (&SPEED_UNITS, "% of Maximum", 1), (&SPEED_UNITS, "Seconds", 3), (&SPEED_UNITS, "masterunits", 7),
            (&RATE_UNITS, "unitspersec²", 0), (&RATE_UNITS, "unitspersec ²", 0), (&RATE_UNITS, "Unitspersec2", 0),
            (&RATE_UNITS, "unitspermasterunit ²", 4), (&RATE_UNITS, "unitspermasterunit2", 4),
            (&JERK_UNITS, "Unitspersec ³", 0), (&JERK_UNITS, "unitspersec3", 0), (&JERK_UNITS, "%oftime", 2),
            (&STOP_JERK_UNITS, "% of Time", 2), (&JERK_UNITS, "unitspermasterunit3", 4),
            (&JERK_UNITS, "%oftimemasterdriven", 6), (&JERK_UNITS, "%ofTime-MasterDriven", 6),
            (&PROFILE, "Trapezoidal", 0), (&PROFILE, "s-curve", 1), (&PROFILE, "SCurve", 1), (&PROFILE, "s curve", 1),
            (&MERGE, "Disabled", 0), (&MERGE, "CoordinatedMotion", 1), (&MERGE, "allmotion", 2),
            (&MERGE_SPEED, "Programmed", 0), (&MERGE_SPEED, "current", 1),
            (&LOCK_DIRECTION, "None", 0), (&LOCK_DIRECTION, "immediateforwardonly", 1),
            (&LOCK_DIRECTION, "immediatereverseonly", 2), (&LOCK_DIRECTION, "positionforward", 3),
            (&LOCK_DIRECTION, "positionforwardonly", 3), (&LOCK_DIRECTION, "positionreverse", 4),
            (&LOCK_DIRECTION, "PositionReverseOnly", 4), (&NO_YES, "Yes", 1), (&NO_YES, "no", 0),
            (&MCCD_MOTION_TYPE, "CoordinatedMove", 1), (&SCOPE, "ActiveMotion", 0),
            (&SCOPE, "activeandpendingmotion", 1), (&MCS_STOP_TYPE, "All", 0), (&MCS_STOP_TYPE, "coordinatedmove", 2),
            (&MCS_STOP_TYPE, "coordinatedtransform", 3), (&MOVE_TYPE, "Absolute", 0), (&MOVE_TYPE, "Incremental", 1),
            (&CIRCLE_TYPE, "CenterIncremental", 3), (&DIRECTION, "Longest Full", 3), (&DIRECTION, "ccw", 1),
            (&RATIO_FORMAT, "fraction_slave_master_counts", 1), (&INSTRUCTION_MODE, "masterdrivenmode", 1),
            (&TRANSFORM_DIRECTION, "inverselftarmmirror", 3), (&TRANSFORM_DIRECTION, "inverseleftarmmirror", 3),
        ];
        for (words, text, value) in cases {
            assert_eq!(words.parse_word(text), Some(*value), "{}: {text}", words.name);
        }
    }

    #[test]
    fn every_word_reads_back_and_stands_for_one_value() {
        for words in ALL {
            for word in words.words.iter().chain(words.reserved) {
                assert_eq!(
                    words.parse_word(word.title),
                    Some(word.value),
                    "{}: {}",
                    words.name,
                    word.title
                );
                assert_eq!(
                    words.parse_word(&word.keyword()),
                    Some(word.value),
                    "{}: {}",
                    words.name,
                    word.title
                );
                for keyword in word.keywords {
                    assert_eq!(*keyword, normalized(keyword), "{}", words.name);
                    assert_eq!(words.parse_word(keyword), Some(word.value), "{}: {keyword}", words.name);
                }
                assert_eq!(words.contains(word.value), words.words.contains(word), "{}", words.name);
            }
            assert!(words.words.is_sorted_by_key(|word| word.value), "{}", words.name);
        }
    }

    #[test]
    fn other_words_are_unknown() {
        for (words, text) in [
            (&PROFILE, "Triangular"),
            (&MERGE, "Enabled"),
            (&MCS_STOP_TYPE, ""),
            (&NO_YES, "1"),
        ] {
            assert_eq!(words.parse_word(text), None, "{}: {text}", words.name);
        }
    }
}
