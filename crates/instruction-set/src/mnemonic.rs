//! Names of the instructions.

use std::fmt;
use std::str::FromStr;

use crate::{Instruction, catalog};

macro_rules! mnemonics {
    ($($name:ident $constant:ident $text:literal $title:literal;)*) => {
        /// An instruction by its mnemonic.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum Mnemonic {
            $(#[doc = $title] $name,)*
        }

        impl Mnemonic {
            /// Every instruction, in the order in which they came to be: the place is that of the type of its tag.
            pub const ALL: &'static [Mnemonic] = &[$(Self::$name),*];

            /// In capitals, such as `MCLM`.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$name => $text),* }
            }

            /// Whether the instruction stops motion or switches off, and begins no motion.
            pub const fn is_stop(self) -> bool {
                matches!(
                    self,
                    Self::Mas | Self::Mcs | Self::Mgs | Self::Msf | Self::Masd | Self::Mcsd | Self::Mgsd
                )
            }

            /// Whether the instruction begins motion, at once or when its trigger or master comes. The controller refuses such an instruction
            /// while motion is inhibited.
            pub const fn begins_motion(self) -> bool {
                match self {
                    Self::Maj | Self::Mam | Self::Mag | Self::Mah | Self::Mapc | Self::Matc => true,
                    Self::Mclm | Self::Mccm | Self::Mcpm | Self::Mct | Self::Mcto => true,
                    Self::Mgs | Self::Mgsd | Self::Mgsr | Self::Mgsp | Self::Mso | Self::Msf | Self::Masd => false,
                    Self::Masr | Self::Mafr | Self::Mas | Self::Mcd | Self::Mrp | Self::Mdac | Self::Mccd => false,
                    Self::Mcs | Self::Mcsd | Self::Mcsr | Self::Mdcc | Self::Mctp | Self::Mctpo | Self::Mccp => false,
                    Self::Mcsv | Self::Maw | Self::Mdw | Self::Mar | Self::Mdr | Self::Maoc | Self::Mdoc => false,
                }
            }

            /// Whether the instruction switches an axis on, or resets a shutdown.
            pub const fn switches_on(self) -> bool {
                matches!(self, Self::Mso | Self::Masr | Self::Mcsr | Self::Mgsr)
            }

            /// The full name.
            pub const fn title(self) -> &'static str {
                match self { $(Self::$name => $title),* }
            }

            /// The instruction's faceplate.
            pub fn instruction(self) -> &'static Instruction {
                match self { $(Self::$name => &catalog::$constant),* }
            }
        }
    };
}

mnemonics! {
    Mgs MGS "MGS" "Motion Group Stop";
    Mgsd MGSD "MGSD" "Motion Group Shutdown";
    Mgsr MGSR "MGSR" "Motion Group Shutdown Reset";
    Mgsp MGSP "MGSP" "Motion Group Strobe Position";
    Mso MSO "MSO" "Motion Servo On";
    Msf MSF "MSF" "Motion Servo Off";
    Masd MASD "MASD" "Motion Axis Shutdown";
    Masr MASR "MASR" "Motion Axis Shutdown Reset";
    Mafr MAFR "MAFR" "Motion Axis Fault Reset";
    Mas MAS "MAS" "Motion Axis Stop";
    Mah MAH "MAH" "Motion Axis Home";
    Maj MAJ "MAJ" "Motion Axis Jog";
    Mam MAM "MAM" "Motion Axis Move";
    Mag MAG "MAG" "Motion Axis Gear";
    Mcd MCD "MCD" "Motion Change Dynamics";
    Mrp MRP "MRP" "Motion Redefine Position";
    Mdac MDAC "MDAC" "Master Driven Axis Control";
    Mapc MAPC "MAPC" "Motion Axis Position Cam";
    Matc MATC "MATC" "Motion Axis Time Cam";
    Mclm MCLM "MCLM" "Motion Coordinated Linear Move";
    Mccm MCCM "MCCM" "Motion Coordinated Circular Move";
    Mccd MCCD "MCCD" "Motion Coordinated Change Dynamics";
    Mcs MCS "MCS" "Motion Coordinated Stop";
    Mcsd MCSD "MCSD" "Motion Coordinated Shutdown";
    Mcsr MCSR "MCSR" "Motion Coordinated Shutdown Reset";
    Mdcc MDCC "MDCC" "Master Driven Coordinated Control";
    Mct MCT "MCT" "Motion Coordinated Transform";
    Mctp MCTP "MCTP" "Motion Calculate Transform Position";
    Mcpm MCPM "MCPM" "Motion Coordinated Path Move";
    Mcto MCTO "MCTO" "Motion Coordinated Transform with Orientation";
    Mctpo MCTPO "MCTPO" "Motion Calculate Transform Position with Orientation";
    Mccp MCCP "MCCP" "Motion Calculate Cam Profile";
    Mcsv MCSV "MCSV" "Motion Calculate Slave Values";
    Maw MAW "MAW" "Motion Arm Watch";
    Mdw MDW "MDW" "Motion Disarm Watch";
    Mar MAR "MAR" "Motion Arm Registration";
    Mdr MDR "MDR" "Motion Disarm Registration";
    Maoc MAOC "MAOC" "Motion Arm Output Cam";
    Mdoc MDOC "MDOC" "Motion Disarm Output Cam";
}

impl fmt::Display for Mnemonic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that is no instruction.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{name:?} is not a motion instruction")]
pub struct UnknownMnemonic {
    /// The unknown name.
    pub name: String,
}

impl FromStr for Mnemonic {
    type Err = UnknownMnemonic;

    /// Any case.
    fn from_str(text: &str) -> Result<Self, UnknownMnemonic> {
        let found = Self::ALL
            .iter()
            .find(|mnemonic| mnemonic.name().eq_ignore_ascii_case(text));
        found.copied().ok_or_else(|| UnknownMnemonic { name: text.to_owned() })
    }
}
