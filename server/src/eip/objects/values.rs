//! Values of attributes as bytes.

use arcline_proto::cip::CipStatus;
use bytes::{BufMut, Bytes, BytesMut};

/// `length u8, bytes`.
pub(super) fn short_string(text: &str) -> Bytes {
    let length = u8::try_from(text.len()).unwrap_or(u8::MAX);
    let mut out = BytesMut::with_capacity(1 + text.len());
    out.put_u8(length);
    out.put_slice(text.as_bytes().get(..usize::from(length)).unwrap_or_default());
    out.freeze()
}

/// `length u16, bytes`, at most 65,535.
pub(super) fn long_string(text: &str) -> Bytes {
    let length = u16::try_from(text.len()).unwrap_or(u16::MAX);
    let mut out = BytesMut::with_capacity(2 + text.len());
    out.put_u16_le(length);
    out.put_slice(text.as_bytes().get(..usize::from(length)).unwrap_or_default());
    out.freeze()
}

pub(super) fn u8_value(value: u8) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&[value]))
}

pub(super) fn u16_value(value: u16) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

pub(super) fn u32_value(value: u32) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

pub(super) fn u64_value(value: u64) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

pub(super) fn f64_value(value: f64) -> Result<Bytes, CipStatus> {
    Ok(Bytes::copy_from_slice(&value.to_le_bytes()))
}

/// 0x14.
pub(super) fn no_attribute() -> Result<Bytes, CipStatus> {
    Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED)
}
