//! Refusals of a server in words: the meaning of a CIP status, with its numbers behind it.

use arcline_proto::cip::CipStatus;

/// `clients may not change it, or not with the role of this connection (CIP status 0x0F)`.
pub(crate) fn in_words(status: CipStatus) -> String {
    let code = |word: &u16| format!(", 0x{word:04X}");
    let codes: String = status.additional().iter().map(code).collect();
    format!("{} (CIP status 0x{:02X}{codes})", words(status), status.general())
}

fn words(status: CipStatus) -> &'static str {
    if let Some(text) = status.additional_text() {
        return text;
    }
    let known = WORDS.iter().find(|(known, _)| status.is(*known));
    known.map_or_else(|| status.text().unwrap_or("the server refused it"), |(_, words)| *words)
}

/// General status, and its meaning, which stands behind the name of the requested object. Other statuses have the text of CIP.
const WORDS: &[(CipStatus, &str)] = &[
    (CipStatus::CONNECTION_FAILURE, "the server refused the connection"),
    (CipStatus::RESOURCE_UNAVAILABLE, "the server has no room for it"),
    (
        CipStatus::INVALID_PARAMETER_VALUE,
        "the server cannot use a value of the request",
    ),
    (CipStatus::PATH_SEGMENT_ERROR, "the server cannot read its path"),
    (CipStatus::PATH_DESTINATION_UNKNOWN, "the server does not have it"),
    (
        CipStatus::SERVICE_NOT_SUPPORTED,
        "the server does not offer this service",
    ),
    (CipStatus::INVALID_ATTRIBUTE_VALUE, "it cannot have this value"),
    (
        CipStatus::OBJECT_STATE_CONFLICT,
        "its present state does not allow this",
    ),
    (CipStatus::OBJECT_ALREADY_EXISTS, "it exists already"),
    (CipStatus::ATTRIBUTE_NOT_SETTABLE, "it cannot be set"),
    (
        CipStatus::PRIVILEGE_VIOLATION,
        "clients may not change it, or not with the role of this connection",
    ),
    (
        CipStatus::DEVICE_STATE_CONFLICT,
        "the present state of the server does not allow this",
    ),
    (CipStatus::REPLY_TOO_LARGE, "the reply is too long for the connection"),
    (CipStatus::NOT_ENOUGH_DATA, "the request is too short"),
    (CipStatus::ATTRIBUTE_NOT_SUPPORTED, "it has no such attribute"),
    (CipStatus::TOO_MUCH_DATA, "the request is too long"),
    (CipStatus::OBJECT_DOES_NOT_EXIST, "it does not exist"),
    (CipStatus::STORE_FAILURE, "the server could not save it"),
    (
        CipStatus::INVALID_PARAMETER,
        "the server cannot use a value of the request",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_before_numbers() {
        #[rustfmt::skip]
        let cases = [
            (CipStatus::PRIVILEGE_VIOLATION,   "clients may not change it, or not with the role of this connection (CIP status 0x0F)"),
            (CipStatus::connection(0x0113),    "out of connections (CIP status 0x01, 0x0113)"),
            (CipStatus::connection(0x7777),    "the server refused the connection (CIP status 0x01, 0x7777)"),
            (CipStatus::GENERAL_ERROR.with(0x2105), "elements are beyond the end of the tag (CIP status 0xFF, 0x2105)"),
            (CipStatus::KEY_FAILURE,           "key failure in path (CIP status 0x25)"),
            (CipStatus::new(0x77),             "the server refused it (CIP status 0x77)"),
        ];
        for (status, expected) in cases {
            assert_eq!(in_words(status), expected);
        }
    }
}
