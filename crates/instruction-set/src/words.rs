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
    /// Further spellings, as words are compared.
    pub keywords: &'static [&'static str],
}

/// An enumeration.
#[derive(Debug, PartialEq, Eq)]
pub struct Words {
    /// The name of the enumeration.
    pub name: &'static str,
    /// The legal values, ascending.
    pub words: &'static [Word],
    /// Words that are understood and are out of range here: units of other instructions.
    pub reserved: &'static [Word],
}

impl Words {
    /// The value of a word, if it is one of this enumeration, reserved ones included.
    pub fn parse_word(&self, text: &str) -> Option<i32> {
        let mut wanted = String::with_capacity(text.len());
        wanted.extend(compared(text));
        let first = wanted.bytes().next();
        // Most words differ in their first character, which counts and is ASCII in every spelling.
        let begins_alike = |spelling: &str| spelling.bytes().next().map(|byte| byte.to_ascii_lowercase()) == first;
        let is_text = |spelling: &str| begins_alike(spelling) && compared(spelling).eq(wanted.chars());
        let mut all = self.words.iter().chain(self.reserved);
        all.find(|word| is_text(word.title) || word.keywords.iter().copied().any(is_text))
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

/// The characters of a word that count when words are compared.
pub(crate) fn compared(text: &str) -> impl Iterator<Item = char> {
    text.chars()
        .filter(|c| !c.is_whitespace() && !matches!(c, '-' | '_'))
        .map(|c| plain_digit(c).to_ascii_lowercase())
}

fn plain_digit(c: char) -> char {
    match c {
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        other => other,
    }
}

/// An enumeration as a Rust type.
pub trait Enumeration: Copy {
    /// Its words: the legal ones of the operands that take all of them.
    const WORDS: &'static Words;
    /// The value that stands for an illegal number, until [`crate::Instruction::verify`] refuses it.
    const FIRST: Self;

    /// The value of a number.
    fn from_number(number: i32) -> Option<Self>;
}

macro_rules! words {
    ($($(#[$doc:meta])* $constant:ident $enum:ident $name:literal {
           $first:ident = $first_value:literal $first_title:literal $([$($first_keyword:literal),*])?
           $(, $variant:ident = $value:literal $title:literal $([$($keyword:literal),*])?)* $(,)?
       } $({ $($(#[$part_doc:meta])* $part:ident $part_name:literal {
           $($own:ident),* $(,)? } $(reserved { $($reserved:ident),* $(,)? })?;)* })?)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, PartialEq, Eq, Debug)]
            pub enum $enum {
                #[doc = $first_title]
                $first = $first_value,
                $(#[doc = $title] $variant = $value,)*
            }

            impl $enum {
                /// Its number, title and keywords.
                pub const fn definition(self) -> Word {
                    match self {
                        Self::$first => Word {
                            value: $first_value,
                            title: $first_title,
                            keywords: &[$($($first_keyword),*)?],
                        },
                        $(Self::$variant => Word {
                            value: $value,
                            title: $title,
                            keywords: &[$($($keyword),*)?],
                        },)*
                    }
                }
            }

            impl Enumeration for $enum {
                const WORDS: &'static Words = &$constant;
                const FIRST: Self = Self::$first;

                fn from_number(number: i32) -> Option<Self> {
                    match number {
                        $first_value => Some(Self::$first),
                        $($value => Some(Self::$variant),)*
                        _ => None,
                    }
                }
            }

            $(#[$doc])*
            pub static $constant: Words = Words {
                name: $name,
                words: &[$enum::$first.definition(), $($enum::$variant.definition()),*],
                reserved: &[],
            };

            $($(
                $(#[$part_doc])*
                pub static $part: Words = Words {
                    name: $part_name,
                    words: &[$($enum::$own.definition()),*],
                    reserved: &[$($($enum::$reserved.definition()),*)?],
                };
            )*)?
        )*

        /// Every enumeration.
        pub static ALL: &[&Words] = &[$(&$constant, $($(&$part,)*)?)*];
    };
}

/// The enumerations: each as a Rust type, as its words, and as the parts of them that some operands take.
pub mod list {
    use super::{Enumeration, Word, Words};

    words! {
        /// MCLM, MCCM.
        MOVE_TYPE MoveType "Move Type" { Absolute = 0 "Absolute", Incremental = 1 "Incremental" }
        /// MCCM.
        CIRCLE_TYPE CircleType "Circle Type" {
            Via = 0 "Via", Center = 1 "Center", Radius = 2 "Radius", CenterIncremental = 3 "Center Incremental",
        }
        /// MCCM: names for two dimensions; Shortest and Longest for three.
        DIRECTION CircleDirection "Direction" {
            Clockwise = 0 "CW" ["clockwise", "shortest"], CounterClockwise = 1 "CCW" ["counterclockwise", "longest"],
            ClockwiseFull = 2 "CW Full" ["clockwisefull", "shortestfull"],
            CounterClockwiseFull = 3 "CCW Full" ["counterclockwisefull", "longestfull"],
        }
        /// MAM.
        MAM_SPEED_UNITS SpeedUnits "Speed Units" {
            UnitsPerSec = 0 "Units per sec", PercentOfMaximum = 1 "% of Maximum", Seconds = 3 "Seconds",
            UnitsPerMasterUnit = 4 "Units per MasterUnit", MasterUnits = 7 "Master Units",
        } {
            /// MCLM, MCCM, MCCD, MAJ, MCD.
            SPEED_UNITS "Speed Units" { UnitsPerSec, PercentOfMaximum, UnitsPerMasterUnit }
                reserved { Seconds, MasterUnits };
        }
        /// MAM.
        MAM_RATE_UNITS RateUnits "Accel/Decel Units" {
            UnitsPerSec2 = 0 "Units per sec²", PercentOfMaximum = 1 "% of Maximum", Seconds = 3 "Seconds",
            UnitsPerMasterUnit2 = 4 "Units per MasterUnit²", MasterUnits = 7 "Master Units",
        } {
            /// MCLM, MCCM, MCCD, MAJ, MCD: acceleration and deceleration.
            RATE_UNITS "Accel/Decel Units" { UnitsPerSec2, PercentOfMaximum, UnitsPerMasterUnit2 }
                reserved { Seconds, MasterUnits };
            /// MCS, MAS, MAG: always in time.
            STOP_RATE_UNITS "Decel Units" { UnitsPerSec2, PercentOfMaximum }
                reserved { Seconds, UnitsPerMasterUnit2, MasterUnits };
        }
        /// MAM.
        MAM_JERK_UNITS JerkUnits "Jerk Units" {
            UnitsPerSec3 = 0 "Units per sec³", PercentOfMaximum = 1 "% of Maximum", PercentOfTime = 2 "% of Time",
            Seconds = 3 "Seconds", UnitsPerMasterUnit3 = 4 "Units per MasterUnit³",
            PercentOfTimeMasterDriven = 6 "% of Time-Master Driven", MasterUnits = 7 "Master Units",
        } {
            /// MCLM, MCCM, MCCD, MAJ, MCD.
            JERK_UNITS "Jerk Units" {
                UnitsPerSec3, PercentOfMaximum, PercentOfTime, UnitsPerMasterUnit3, PercentOfTimeMasterDriven,
            } reserved { Seconds, MasterUnits };
            /// MCS, MAS: always in time.
            STOP_JERK_UNITS "Jerk Units" { UnitsPerSec3, PercentOfMaximum, PercentOfTime }
                reserved { Seconds, UnitsPerMasterUnit3, PercentOfTimeMasterDriven, MasterUnits };
        }
        /// Velocity profile.
        PROFILE VelocityProfile "Profile" { Trapezoidal = 0 "Trapezoidal", SCurve = 1 "S-curve" }
        /// MCLM, MCCM.
        TERMINATION_TYPE TerminationType "Termination Type" {
            ActualTolerance = 0 "Actual Tolerance", NoSettle = 1 "No Settle", CommandTolerance = 2 "Command Tolerance",
            NoDecel = 3 "No Decel",
            ContourVelocityConstrained = 4 "Follow Contour Velocity Constrained" ["contourvelocityconstrained"],
            ContourVelocityUnconstrained = 5 "Follow Contour Velocity Unconstrained" ["contourvelocityunconstrained"],
            CommandToleranceProgrammed = 6 "Command Tolerance Programmed",
        }
        /// MCLM, MCCM.
        MERGE Merge "Merge" {
            Disabled = 0 "Disabled", CoordinatedMotion = 1 "Coordinated Motion", AllMotion = 2 "All Motion",
        }
        /// MAM, MAJ.
        AXIS_MERGE AxisMerge "Merge" { Disabled = 0 "Disabled", Enabled = 1 "Enabled" }
        /// Merge Speed.
        MERGE_SPEED MergeSpeed "Merge Speed" { Programmed = 0 "Programmed", Current = 1 "Current" }
        /// Master driven moves.
        LOCK_DIRECTION LockDirection "Lock Direction" {
            None = 0 "None", ImmediateForward = 1 "Immediate Forward Only", ImmediateReverse = 2 "Immediate Reverse Only",
            PositionForward = 3 "Position Forward Only" ["positionforward"],
            PositionReverse = 4 "Position Reverse Only" ["positionreverse"],
        }
        /// The "Change …" operands.
        NO_YES NoYes "Change" { No = 0 "No", Yes = 1 "Yes" }
        /// MCCD.
        MCCD_MOTION_TYPE MccdMotionType "Motion Type" { CoordinatedMove = 1 "Coordinated Move" }
        /// MCCD.
        SCOPE Scope "Scope" { Active = 0 "Active Motion", ActiveAndPending = 1 "Active and Pending Motion" }
        /// MCS.
        MCS_STOP_TYPE McsStopType "Stop Type" {
            All = 0 "All", CoordinatedMove = 2 "Coordinated Move", CoordinatedTransform = 3 "Coordinated Transform",
        }
        /// MAS.
        MAS_STOP_TYPE MasStopType "Stop Type" {
            All = 0 "All", Jog = 1 "Jog", Move = 2 "Move", Gear = 3 "Gear", Home = 4 "Home", Tune = 5 "Tune",
            Test = 6 "Test", TimeCam = 7 "Time Cam", PositionCam = 8 "Position Cam",
            MasterOffsetMove = 9 "Master Offset Move", DirectControl = 10 "Direct Control",
        }
        /// MGS.
        STOP_MODE StopMode "Stop Mode" { Programmed = 0 "Programmed", FastStop = 1 "Fast Stop", FastDisable = 2 "Fast Disable" }
        /// MAJ.
        JOG_DIRECTION JogDirection "Direction" { Forward = 0 "Forward", Reverse = 1 "Reverse" }
        /// MAM.
        MAM_MOVE_TYPE MamMoveType "Move Type" {
            Absolute = 0 "Absolute", Incremental = 1 "Incremental", RotaryShortestPath = 2 "Rotary Shortest Path",
            RotaryPositive = 3 "Rotary Positive", RotaryNegative = 4 "Rotary Negative",
            AbsoluteMasterOffset = 5 "Absolute Master Offset", IncrementalMasterOffset = 6 "Incremental Master Offset",
        }
        /// MAG, MAPC, MATC.
        GEAR_DIRECTION GearDirection "Direction" {
            Same = 0 "Same", Opposite = 1 "Opposite", Reverse = 2 "Reverse", Unchanged = 3 "Unchanged",
        }
        /// Master position that a slave follows.
        MASTER_REFERENCE Reference "Master Reference" { Actual = 0 "Actual", Command = 1 "Command" } {
            /// MAOC: the position of the axis that the cam follows.
            POSITION_REFERENCE "Position Reference" { Actual, Command };
            /// MRP.
            POSITION_SELECT "Position Select" { Actual, Command };
        }
        /// MAG.
        RATIO_FORMAT RatioFormat "Ratio Format" { Real = 0 "Real", Fraction = 1 "Fraction" ["fractionslavemastercounts"] }
        /// MAG; the reverse of Merge.
        CLUTCH Clutch "Clutch" { Enabled = 0 "Enabled", Disabled = 1 "Disabled" }
        /// MCD.
        MCD_MOTION_TYPE McdMotionType "Motion Type" { Jog = 0 "Jog", Move = 1 "Move" }
        /// MRP.
        REDEFINE_TYPE RedefineType "Type" { Absolute = 0 "Absolute", Relative = 1 "Relative" }
        /// MDAC.
        MDAC_MOTION_TYPE MdacMotionType "Motion Type" {
            All = 0 "All", Move = 1 "Move", Jog = 2 "Jog", TimeCam = 3 "Time Cam", MasterOffsetMove = 4 "Master Offset Move",
        }
        /// MAPC, MAOC.
        EXECUTION_MODE ExecutionMode "Execution Mode" { Once = 0 "Once", Continuous = 1 "Continuous", Persistent = 2 "Persistent" } {
            /// MATC.
            TIME_CAM_EXECUTION_MODE "Execution Mode" { Once, Continuous };
        }
        /// MAPC, MAOC.
        EXECUTION_SCHEDULE ExecutionSchedule "Execution Schedule" {
            Immediate = 0 "Immediate", Pending = 1 "Pending", ForwardOnly = 2 "Forward Only", ReverseOnly = 3 "Reverse Only",
            Bidirectional = 4 "Bidirectional",
        } {
            /// MATC.
            TIME_CAM_EXECUTION_SCHEDULE "Execution Schedule" { Immediate, Pending };
        }
        /// MAPC.
        MASTER_DIRECTION MasterDirection "Master Direction" {
            Bidirectional = 0 "Bidirectional", ForwardOnly = 1 "Forward Only", ReverseOnly = 2 "Reverse Only",
        }
        /// MAW.
        WATCH_TRIGGER WatchTrigger "Trigger Condition" { Forward = 0 "Forward", Reverse = 1 "Reverse" }
        /// MAR.
        REGISTRATION_TRIGGER RegistrationTrigger "Trigger Condition" {
            PositiveEdge = 0 "Positive Edge", NegativeEdge = 1 "Negative Edge",
        }
        /// MAR.
        WINDOWED Windowed "Windowed Registration" { Disabled = 0 "Disabled", Enabled = 1 "Enabled" }
        /// MDOC.
        DISARM_TYPE DisarmType "Disarm Type" { All = 0 "All", Specific = 1 "Specific" }
        /// MATC.
        INSTRUCTION_MODE InstructionMode "Instruction Mode" {
            TimeDriven = 0 "Time Driven Mode", MasterDriven = 1 "Master Driven Mode",
        }
        /// PATH_DATA.
        INTERPOLATION_TYPE InterpolationType "Interpolation Type" {
            PointToPoint = 0 "Point to Point", Linear = 1 "Continuous Path Linear",
        }
        /// DYNAMICS_DATA.
        UNITS_MODE UnitsMode "Units Mode" { Percent = 0 "Percent", CoordinationUnits = 1 "Coordination Units" }
        /// DYNAMICS_DATA.
        TIME_UNITS TimeUnits "Time Units" { Seconds = 0 "Seconds", MasterUnits = 1 "Master Units" }
        /// MCTP, MCTPO.
        TRANSFORM_DIRECTION TransformDirection "Transform Direction" {
            Forward = 0 "Forward", Inverse = 1 "Inverse", InverseLeftArm = 2 "Inverse Left Arm",
            InverseLeftArmMirror = 3 "Inverse Left Arm Mirror" ["inverselftarmmirror"],
            InverseRightArm = 4 "Inverse Right Arm", InverseRightArmMirror = 5 "Inverse Right Arm Mirror",
        }
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
                    assert!(compared(keyword).eq(keyword.chars()), "{}: {keyword}", words.name);
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
