//! The MOTION_INSTRUCTION structure: status of one execution
//! (spec/axis-and-data-types.md §8.2, spec/coordinated-instructions.md §2.2).

use std::fmt;

/// A bit of FLAGS.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Flag {
    /// Enable: the rung is true.
    En,
    /// Done: accepted, or executed.
    Dn,
    /// Error: the code is in ERR.
    Er,
    /// In process.
    Ip,
    /// Active: this instruction controls the motion now.
    Ac,
    /// Process complete.
    Pc,
    /// Its own profile is accelerating.
    Accel,
    /// Its own profile is decelerating.
    Decel,
    /// Master driven: the slave follows its master at full ratio.
    TrackingMaster,
    /// Event Distance has been answered in Calculated Data.
    CalculatedDataAvailable,
}

impl Flag {
    /// In the order in which events list them.
    pub const ALL: [Flag; 10] = [
        Self::En,
        Self::Dn,
        Self::Er,
        Self::Ip,
        Self::Ac,
        Self::Pc,
        Self::Accel,
        Self::Decel,
        Self::TrackingMaster,
        Self::CalculatedDataAvailable,
    ];

    /// Bit number in FLAGS, 0 to 31.
    pub const fn bit(self) -> u8 {
        match self {
            Self::En => 31,
            Self::Dn => 29,
            Self::Er => 28,
            Self::Pc => 27,
            Self::Ip => 26,
            Self::Ac => 23,
            Self::CalculatedDataAvailable => 4,
            Self::TrackingMaster => 3,
            Self::Decel => 2,
            Self::Accel => 1,
        }
    }

    /// The bit as a mask of FLAGS.
    pub const fn mask(self) -> u32 {
        1 << self.bit()
    }

    /// The member's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::En => "EN",
            Self::Dn => "DN",
            Self::Er => "ER",
            Self::Ip => "IP",
            Self::Ac => "AC",
            Self::Pc => "PC",
            Self::Accel => "ACCEL",
            Self::Decel => "DECEL",
            Self::TrackingMaster => "TrackingMaster",
            Self::CalculatedDataAvailable => "CalculatedDataAvailable",
        }
    }

    /// The flags of a FLAGS word, in the order of [`Flag::ALL`].
    pub fn in_word(flags: u32) -> impl Iterator<Item = Flag> {
        Self::ALL.into_iter().filter(move |flag| flags & flag.mask() != 0)
    }
}

impl fmt::Display for Flag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The MOTION_INSTRUCTION structure.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct MotionControl {
    /// The bits of [`Flag`].
    pub flags: u32,
    /// Error code, 0: none.
    pub err: i16,
    /// Message status, 0: successful.
    pub status: i8,
    /// Step of an instruction of several steps.
    pub state: i8,
    /// Cam segment.
    pub segment: i32,
    /// Extended error code.
    pub exerr: i8,
}

impl MotionControl {
    /// Size of the structure in bytes.
    pub const SIZE: usize = 16;

    /// The structure as it travels: FLAGS, ERR, STATUS, STATE, SEGMENT, EXERR, three zeros.
    pub const fn to_bytes(self) -> [u8; 16] {
        let f = self.flags.to_le_bytes();
        let e = self.err.to_le_bytes();
        let s = self.segment.to_le_bytes();
        let [status] = self.status.to_le_bytes();
        let [state] = self.state.to_le_bytes();
        let [exerr] = self.exerr.to_le_bytes();
        [
            f[0], f[1], f[2], f[3], e[0], e[1], status, state, s[0], s[1], s[2], s[3], exerr, 0, 0, 0,
        ]
    }

    /// Reads the structure; the reserved bytes are ignored.
    pub const fn from_bytes(b: [u8; 16]) -> Self {
        Self {
            flags: u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            err: i16::from_le_bytes([b[4], b[5]]),
            status: i8::from_le_bytes([b[6]]),
            state: i8::from_le_bytes([b[7]]),
            segment: i32::from_le_bytes([b[8], b[9], b[10], b[11]]),
            exerr: i8::from_le_bytes([b[12]]),
        }
    }

    /// Whether the flag is set.
    pub const fn has(&self, flag: Flag) -> bool {
        self.flags & flag.mask() != 0
    }

    /// Whether the instruction has ended, so that none of its bits will be set any more.
    pub const fn has_ended(&self) -> bool {
        (self.has(Flag::Dn) || self.has(Flag::Er)) && !self.has(Flag::Ip) && !self.has(Flag::Ac)
    }

    /// Sets the flag.
    pub const fn set(&mut self, flag: Flag) {
        self.flags |= flag.mask();
    }

    /// Clears the flag.
    pub const fn clear(&mut self, flag: Flag) {
        self.flags &= !flag.mask();
    }

    /// Sets or clears the flag.
    pub const fn put(&mut self, flag: Flag, on: bool) {
        if on { self.set(flag) } else { self.clear(flag) }
    }

    /// Refused: EN and ER, with the error's codes.
    pub fn refused(error: crate::MotionError) -> Self {
        Self {
            flags: Flag::En.mask() | Flag::Er.mask(),
            err: error.err(),
            exerr: error.exerr(),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn bits_stand_where_the_seeds_put_them() {
        #[rustfmt::skip]
        let cases = [
            (Flag::En, 0x8000_0000), (Flag::Dn, 0x2000_0000), (Flag::Er, 0x1000_0000), (Flag::Pc, 0x0800_0000),
            (Flag::Ip, 0x0400_0000), (Flag::Ac, 0x0080_0000), (Flag::Accel, 0x0000_0002), (Flag::Decel, 0x0000_0004),
            (Flag::TrackingMaster, 0x8), (Flag::CalculatedDataAvailable, 0x10),
        ];
        for (flag, mask) in cases {
            assert_eq!(flag.mask(), mask, "{flag}");
        }
    }

    #[test]
    fn a_failed_instruction_reads_as_a_controller_shows_it() {
        let control = MotionControl {
            flags: 0x1000_0000,
            err: 54,
            exerr: -1,
            ..MotionControl::default()
        };
        let bytes = control.to_bytes();
        assert_eq!(bytes, [0, 0, 0, 0x10, 54, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0, 0, 0]);
    }

    proptest! {
        #[test]
        fn bytes_read_back(mut bytes in any::<[u8; 16]>()) {
            bytes[13..].fill(0);
            prop_assert_eq!(MotionControl::from_bytes(bytes).to_bytes(), bytes);
        }
    }
}
