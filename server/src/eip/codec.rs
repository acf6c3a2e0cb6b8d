//! Frames on a byte stream: `arcline-proto`'s encapsulation joined to a socket.

use std::io;

use arcline_proto::encap::{Frame, FrameDecoder, FrameError};
use bytes::{Bytes, BytesMut};
use tokio_util::codec::{Decoder, Encoder};

/// Cuts incoming bytes into frames; outgoing frames are bytes already.
#[derive(Debug)]
pub(crate) struct FrameCodec(FrameDecoder);

impl FrameCodec {
    /// Accepts up to `limit` bytes behind a header.
    pub(crate) fn new(limit: usize) -> Self {
        Self(FrameDecoder::new(limit))
    }
}

/// Why a stream of frames ended early.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StreamError {
    /// The socket failed.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The peer sent what is no frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

impl Decoder for FrameCodec {
    type Item = Frame;
    type Error = StreamError;

    fn decode(&mut self, buf: &mut BytesMut) -> Result<Option<Frame>, StreamError> {
        Ok(self.0.decode(buf)?)
    }

    /// A stream that ends inside a frame has simply ended.
    fn decode_eof(&mut self, buf: &mut BytesMut) -> Result<Option<Frame>, StreamError> {
        self.decode(buf)
    }
}

impl Encoder<Bytes> for FrameCodec {
    type Error = StreamError;

    fn encode(&mut self, frame: Bytes, out: &mut BytesMut) -> Result<(), StreamError> {
        out.extend_from_slice(&frame);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use arcline_proto::encap::{Command, SessionHandle};

    use super::*;

    #[test]
    fn a_frame_survives_any_split() {
        let frame = Frame::request(
            Command::NOP,
            SessionHandle(7),
            *b"12345678",
            Bytes::from_static(b"data"),
        );
        let bytes = frame.to_bytes();
        for cut in 0..bytes.len() {
            let mut codec = FrameCodec::new(64);
            let mut buf = BytesMut::from(&bytes[..cut]);
            assert!(codec.decode(&mut buf).expect("no error").is_none(), "cut at {cut}");
            buf.extend_from_slice(&bytes[cut..]);
            assert_eq!(
                codec.decode(&mut buf).expect("no error").as_ref(),
                Some(&frame),
                "cut at {cut}"
            );
        }
    }

    #[test]
    fn an_end_inside_a_frame_is_an_end() {
        let mut codec = FrameCodec::new(64);
        assert!(
            codec
                .decode_eof(&mut BytesMut::from(&[1_u8, 2, 3][..]))
                .expect("no error")
                .is_none()
        );
    }
}
