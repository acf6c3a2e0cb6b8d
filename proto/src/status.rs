//! General and additional status of CIP replies: codes, names and texts, each from one table
//! (CIP Vol. 1, appendix B; spec/ethernet-ip.md §6).

use std::fmt;

/// Status of a reply: a general code and up to [`CipStatus::MAX_ADDITIONAL`] additional words.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct CipStatus {
    general: u8,
    count: u8,
    words: [u16; Self::MAX_ADDITIONAL],
}

impl CipStatus {
    /// Additional words that are kept.
    pub const MAX_ADDITIONAL: usize = 4;

    /// A general code without additional words.
    pub const fn new(general: u8) -> Self {
        Self {
            general,
            count: 0,
            words: [0; Self::MAX_ADDITIONAL],
        }
    }

    /// With one more additional word; dropped when there are already [`Self::MAX_ADDITIONAL`].
    #[must_use]
    pub fn with(mut self, word: u16) -> Self {
        if let Some(slot) = self.words.get_mut(usize::from(self.count)) {
            *slot = word;
            self.count += 1;
        }
        self
    }

    /// General status 0x01 with the Connection Manager's additional code, see [`connection`].
    pub fn connection(code: u16) -> Self {
        Self::CONNECTION_FAILURE.with(code)
    }

    /// General status 0x1F with its two words: a motion error's ERR and EXERR, two's complement.
    pub fn vendor(err: i16, exerr: i16) -> Self {
        Self::VENDOR_SPECIFIC
            .with(err.cast_unsigned())
            .with(exerr.cast_unsigned())
    }

    /// The general code.
    pub const fn general(&self) -> u8 {
        self.general
    }

    /// The additional words.
    pub fn additional(&self) -> &[u16] {
        self.words.get(..usize::from(self.count)).unwrap_or_default()
    }

    /// Whether the general code is 0x00.
    pub const fn is_success(&self) -> bool {
        self.general == 0
    }

    /// Whether the same general code, with any additional words.
    pub const fn is(&self, other: Self) -> bool {
        self.general == other.general
    }

    /// Text of the additional status, if its first word is known in the context of the general code.
    pub fn additional_text(&self) -> Option<&'static str> {
        let word = *self.additional().first()?;
        let table = match self.general {
            0x01 => connection::TEXTS,
            0x10 => state_conflict::TEXTS,
            0xFF => general_error::TEXTS,
            _ => return None,
        };
        table.iter().find(|(code, _)| *code == word).map(|(_, text)| *text)
    }
}

impl fmt::Display for CipStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CIP status 0x{:02X}", self.general)?;
        if let Some(text) = self.text() {
            write!(f, " ({text})")?;
        }
        for (index, word) in self.additional().iter().enumerate() {
            write!(f, "{} 0x{word:04X}", if index == 0 { "," } else { "" })?;
        }
        if let Some(text) = self.additional_text() {
            write!(f, " ({text})")?;
        }
        Ok(())
    }
}

macro_rules! general {
    ($($code:literal $name:ident $text:literal)*) => {
        impl CipStatus {
            $(#[doc = concat!("General status ", stringify!($code), ": ", $text, ".")]
              pub const $name: Self = Self::new($code);)*

            /// Text of the general code, if it is known.
            pub const fn text(&self) -> Option<&'static str> {
                match self.general {
                    $($code => Some($text),)*
                    _ => None,
                }
            }
        }
    };
}

general! {
    0x00 SUCCESS "success"
    0x01 CONNECTION_FAILURE "connection failure"
    0x02 RESOURCE_UNAVAILABLE "resource unavailable"
    0x03 INVALID_PARAMETER_VALUE "invalid parameter value"
    0x04 PATH_SEGMENT_ERROR "path segment error"
    0x05 PATH_DESTINATION_UNKNOWN "path destination unknown"
    0x06 PARTIAL_TRANSFER "partial transfer"
    0x07 CONNECTION_LOST "connection lost"
    0x08 SERVICE_NOT_SUPPORTED "service not supported"
    0x09 INVALID_ATTRIBUTE_VALUE "invalid attribute value"
    0x0A ATTRIBUTE_LIST_ERROR "attribute list error"
    0x0B ALREADY_IN_REQUESTED_STATE "already in requested mode or state"
    0x0C OBJECT_STATE_CONFLICT "object state conflict"
    0x0D OBJECT_ALREADY_EXISTS "object already exists"
    0x0E ATTRIBUTE_NOT_SETTABLE "attribute not settable"
    0x0F PRIVILEGE_VIOLATION "privilege violation"
    0x10 DEVICE_STATE_CONFLICT "device state conflict"
    0x11 REPLY_TOO_LARGE "reply data too large"
    0x12 FRAGMENTATION_OF_PRIMITIVE "fragmentation of a primitive value"
    0x13 NOT_ENOUGH_DATA "not enough data"
    0x14 ATTRIBUTE_NOT_SUPPORTED "attribute not supported"
    0x15 TOO_MUCH_DATA "too much data"
    0x16 OBJECT_DOES_NOT_EXIST "object does not exist"
    0x19 STORE_FAILURE "store operation failure"
    0x1A REQUEST_TOO_LARGE "routing failure, request too large"
    0x1B RESPONSE_TOO_LARGE "routing failure, response too large"
    0x1C MISSING_ATTRIBUTE_DATA "missing attribute list entry data"
    0x1D INVALID_ATTRIBUTE_LIST "invalid attribute value list"
    0x1E EMBEDDED_SERVICE_ERROR "embedded service error"
    0x1F VENDOR_SPECIFIC "vendor specific error"
    0x20 INVALID_PARAMETER "invalid parameter"
    0x25 KEY_FAILURE "key failure in path"
    0x26 PATH_SIZE_INVALID "path size invalid"
    0x27 UNEXPECTED_ATTRIBUTE "unexpected attribute in list"
    0x28 INVALID_MEMBER "invalid member id"
    0x29 MEMBER_NOT_SETTABLE "member not settable"
    0xFF GENERAL_ERROR "general error"
}

macro_rules! additional {
    ($(#[$doc:meta])* $module:ident $($code:literal $name:ident $text:literal)*) => {
        $(#[$doc])*
        pub mod $module {
            $(#[doc = concat!("Additional status ", stringify!($code), ": ", $text, ".")]
              pub const $name: u16 = $code;)*

            /// Code and text of each.
            pub const TEXTS: &[(u16, &str)] = &[$(($code, $text)),*];
        }
    };
}

additional! {
    /// Additional status of the Connection Manager, behind general status 0x01.
    connection
    0x0100 DUPLICATE "connection in use or duplicate Forward Open"
    0x0103 CLASS_TRIGGER_UNSUPPORTED "transport class and trigger combination not supported"
    0x0106 OWNERSHIP_CONFLICT "ownership conflict"
    0x0107 NOT_FOUND "connection not found"
    0x0108 INVALID_TYPE "invalid connection type"
    0x0109 INVALID_SIZE "invalid connection size"
    0x0110 NOT_CONFIGURED "target not configured"
    0x0111 RPI_UNSUPPORTED "requested packet interval not supported"
    0x0113 OUT_OF_CONNECTIONS "out of connections"
    0x0114 KEY_VENDOR_OR_PRODUCT "vendor id or product code mismatch"
    0x0115 KEY_DEVICE_TYPE "device type mismatch"
    0x0116 KEY_REVISION "revision mismatch"
    0x0117 INVALID_APPLICATION_PATH "invalid produced or consumed application path"
    0x0118 INVALID_CONFIGURATION_PATH "invalid or inconsistent configuration application path"
    0x0119 NON_LISTEN_ONLY_NOT_OPEN "non-listen-only connection not open"
    0x011A TARGET_OUT_OF_CONNECTIONS "target object out of connections"
    0x011C CLASS_UNSUPPORTED "transport class not supported"
    0x011D TRIGGER_UNSUPPORTED "production trigger not supported"
    0x011E DIRECTION_UNSUPPORTED "direction not supported"
    0x011F FIXED_VARIABLE_O_TO_T "originator to target fixed or variable flag wrong"
    0x0120 FIXED_VARIABLE_T_TO_O "target to originator fixed or variable flag wrong"
    0x0123 TYPE_O_TO_T "originator to target connection type wrong"
    0x0124 TYPE_T_TO_O "target to originator connection type wrong"
    0x0125 REDUNDANT_OWNER "originator to target redundant owner not supported"
    0x0126 CONFIGURATION_SIZE "configuration size wrong"
    0x0127 SIZE_O_TO_T "originator to target size wrong"
    0x0128 SIZE_T_TO_O "target to originator size wrong"
    0x0129 CONFIGURATION_PATH "configuration application path wrong"
    0x012A CONSUMING_PATH "consuming application path wrong"
    0x012B PRODUCING_PATH "producing application path wrong"
    0x012F INCONSISTENT_PATHS "application paths inconsistent"
    0x0132 NULL_OPEN_UNSUPPORTED "null Forward Open not supported"
    0x0133 TIMEOUT_MULTIPLIER "timeout multiplier not acceptable"
    0x0203 TIMED_OUT "connection timed out"
    0x0204 UNCONNECTED_TIMED_OUT "unconnected request timed out"
    0x0205 UNCONNECTED_PARAMETER "parameter error in unconnected request"
    0x0206 TOO_LARGE_FOR_UNCONNECTED "message too large for unconnected send"
    0x0301 NO_BUFFER "no buffer memory"
    0x0302 NO_BANDWIDTH "no network bandwidth"
    0x0311 PORT_UNAVAILABLE "port not available"
    0x0312 LINK_ADDRESS_INVALID "link address not valid"
    0x0315 INVALID_SEGMENT "invalid segment in connection path"
    0x0316 CLOSE_PATH_MISMATCH "path of the close does not match"
    0x0318 LINK_ADDRESS_TO_SELF "link address to self invalid"
    0x031C MISCELLANEOUS "miscellaneous"
    0x0814 DATA_FORMAT_MISMATCH "data format mismatch"
}

additional! {
    /// Additional status behind general status 0x10.
    state_conflict
    0x2101 MODE "the mode forbids it"
    0x2802 SAFETY "the safety state forbids it"
}

additional! {
    /// Additional status behind general status 0xFF (data access of a Logix controller).
    general_error
    0x2104 OFFSET_BEYOND_DATA "offset is beyond the data"
    0x2105 ELEMENTS_BEYOND_TAG "elements are beyond the end of the tag"
    0x2107 TYPE_MISMATCH "data type does not match the tag"
}
