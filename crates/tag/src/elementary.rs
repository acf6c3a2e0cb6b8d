//! The elementary CIP data types (CIP Vol. 1, C-2.1.1; spec/ethernet-ip.md §12).

/// An elementary data type of a fixed size.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, PartialOrd, Ord)]
pub enum Elementary {
    /// Boolean, one byte on the wire when it stands alone.
    Bool,
    /// Signed, 1 byte.
    Sint,
    /// Signed, 2 bytes.
    Int,
    /// Signed, 4 bytes.
    Dint,
    /// Signed, 8 bytes.
    Lint,
    /// Unsigned, 1 byte.
    Usint,
    /// Unsigned, 2 bytes.
    Uint,
    /// Unsigned, 4 bytes.
    Udint,
    /// Unsigned, 8 bytes.
    Ulint,
    /// IEEE 754 binary32.
    Real,
    /// IEEE 754 binary64.
    Lreal,
    /// 8 bits.
    Byte,
    /// 16 bits.
    Word,
    /// 32 bits; also the host of 32 elements of a BOOL array.
    Dword,
    /// 64 bits.
    Lword,
}

impl Elementary {
    /// Every elementary type, in the order of the codes.
    pub const ALL: [Elementary; 15] = [
        Self::Bool,
        Self::Sint,
        Self::Int,
        Self::Dint,
        Self::Lint,
        Self::Usint,
        Self::Uint,
        Self::Udint,
        Self::Ulint,
        Self::Real,
        Self::Lreal,
        Self::Byte,
        Self::Word,
        Self::Dword,
        Self::Lword,
    ];

    /// The CIP type code, 0xC1 to 0xD4.
    pub const fn code(self) -> u8 {
        match self {
            Self::Bool => 0xC1,
            Self::Sint => 0xC2,
            Self::Int => 0xC3,
            Self::Dint => 0xC4,
            Self::Lint => 0xC5,
            Self::Usint => 0xC6,
            Self::Uint => 0xC7,
            Self::Udint => 0xC8,
            Self::Ulint => 0xC9,
            Self::Real => 0xCA,
            Self::Lreal => 0xCB,
            Self::Byte => 0xD1,
            Self::Word => 0xD2,
            Self::Dword => 0xD3,
            Self::Lword => 0xD4,
        }
    }

    /// The type of a CIP type code, if it is one of these.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// Size in bytes on the wire and in a tag.
    pub const fn size(self) -> usize {
        match self {
            Self::Bool | Self::Sint | Self::Usint | Self::Byte => 1,
            Self::Int | Self::Uint | Self::Word => 2,
            Self::Dint | Self::Udint | Self::Real | Self::Dword => 4,
            Self::Lint | Self::Ulint | Self::Lreal | Self::Lword => 8,
        }
    }

    /// The name in capitals, such as `DINT`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bool => "BOOL",
            Self::Sint => "SINT",
            Self::Int => "INT",
            Self::Dint => "DINT",
            Self::Lint => "LINT",
            Self::Usint => "USINT",
            Self::Uint => "UINT",
            Self::Udint => "UDINT",
            Self::Ulint => "ULINT",
            Self::Real => "REAL",
            Self::Lreal => "LREAL",
            Self::Byte => "BYTE",
            Self::Word => "WORD",
            Self::Dword => "DWORD",
            Self::Lword => "LWORD",
        }
    }

    /// The type of a name, case ignored.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name().eq_ignore_ascii_case(name))
    }

    /// Whether a path can address single bits of the type (`Dint.5`): true for every integer and bit string, not for BOOL, REAL, LREAL.
    pub const fn has_bits(self) -> bool {
        !matches!(self, Self::Bool | Self::Real | Self::Lreal)
    }

    /// Whether the type is a floating-point type.
    pub const fn is_real(self) -> bool {
        matches!(self, Self::Real | Self::Lreal)
    }
}

impl std::fmt::Display for Elementary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::Elementary;

    #[test]
    fn codes_and_names_are_unique_and_read_back() {
        for kind in Elementary::ALL {
            assert_eq!(Elementary::from_code(kind.code()), Some(kind));
            assert_eq!(Elementary::from_name(&kind.name().to_lowercase()), Some(kind));
        }
        for code in [0x00, 0xA0, 0xC0, 0xCC, 0xD0, 0xD5, 0xDA, 0xFF] {
            assert_eq!(Elementary::from_code(code), None, "code {code:#04x}");
        }
    }
}
