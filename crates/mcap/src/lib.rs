//! A trace as MCAP, which Foxglove and PlotJuggler open: a channel for each axis or coordinate system, its samples as JSON
//! with a schema, in chunks with an index. No compression.
//!
//! Records as the MCAP specification (version 0) lays them out; all numbers little-endian. Times are nanoseconds of the
//! machine's run: tick times coarse update period.

#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::time::Duration;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Bytes of messages from which a chunk is written.
const CHUNK: usize = 1 << 20;

mod opcode {
    pub(crate) const HEADER: u8 = 0x01;
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const MESSAGE_INDEX: u8 = 0x07;
    pub(crate) const CHUNK_INDEX: u8 = 0x08;
    pub(crate) const STATISTICS: u8 = 0x0B;
    pub(crate) const DATA_END: u8 = 0x0F;
}

/// A file that is being written, in small pieces: `W` buffers.
#[derive(Debug)]
pub struct Mcap<W> {
    file: W,
    /// Bytes written so far.
    offset: u64,
    period: Duration,
    channels: Vec<Channel>,
    /// Schema and channel records, which stand in front and in the summary.
    described: Vec<u8>,
    chunk: Chunk,
    /// Chunk index records.
    chunks: Vec<u8>,
    chunk_count: u32,
    /// Of each channel.
    messages: u64,
    first: Option<u64>,
    last: u64,
}

/// An object whose samples go together.
#[derive(Debug)]
struct Channel {
    topic: String,
    /// Member names and the indices of their samples in a row.
    members: Vec<(String, usize)>,
}

/// Messages that have not been written yet.
#[derive(Debug, Default)]
struct Chunk {
    records: Vec<u8>,
    first: Option<u64>,
    last: u64,
    /// Time and offset of each message, by channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
}

impl<W: Write> Mcap<W> {
    /// Begins a file: names of the signals of a row (`Object.Member`), and the coarse update period.
    ///
    /// # Errors
    /// The beginning could not be written, or there are more objects than channels.
    pub fn new(file: W, signals: &[String], period: Duration) -> io::Result<Self> {
        let mut channels: Vec<Channel> = Vec::new();
        for (index, signal) in signals.iter().enumerate() {
            let (topic, member) = signal.rsplit_once('.').unwrap_or((signal, "value"));
            let member = (member.to_owned(), index);
            match channels.iter_mut().find(|channel| channel.topic == topic) {
                Some(channel) => channel.members.push(member),
                None => channels.push(Channel {
                    topic: topic.to_owned(),
                    members: vec![member],
                }),
            }
        }
        let mut described = Vec::new();
        for (index, channel) in channels.iter().enumerate() {
            let id = number_of(index)?;
            record(&mut described, opcode::SCHEMA, &channel.schema(id));
            record(&mut described, opcode::CHANNEL, &channel.channel(id));
        }
        let mut mcap = Self {
            file,
            offset: 0,
            period,
            channels,
            described,
            chunk: Chunk::default(),
            chunks: Vec::new(),
            chunk_count: 0,
            messages: 0,
            first: None,
            last: 0,
        };
        mcap.put(MAGIC)?;
        let mut head = Vec::new();
        let mut content = Vec::new();
        text(&mut content, "");
        text(&mut content, concat!("arcline ", env!("CARGO_PKG_VERSION")));
        record(&mut head, opcode::HEADER, &content);
        mcap.put(&head)?;
        let described = mcap.described.clone();
        mcap.put(&described)?;
        Ok(mcap)
    }

    /// The samples of one tick.
    ///
    /// # Errors
    /// They could not be written.
    pub fn row(&mut self, tick: u64, row: &[f64]) -> io::Result<()> {
        let time = u64::try_from(u128::from(tick) * self.period.as_nanos()).unwrap_or(u64::MAX);
        for (index, channel) in self.channels.iter().enumerate() {
            let id = number_of(index)?;
            let mut content = Vec::new();
            content.extend(id.to_le_bytes());
            // The sequence wraps as the specification lets it.
            content.extend((self.messages as u32).to_le_bytes());
            content.extend(time.to_le_bytes());
            content.extend(time.to_le_bytes());
            channel.message(row, &mut content)?;
            let offset = self.chunk.records.len() as u64;
            self.chunk.index.entry(id).or_default().push((time, offset));
            record(&mut self.chunk.records, opcode::MESSAGE, &content);
        }
        self.messages += 1;
        self.chunk.first.get_or_insert(time);
        self.chunk.last = time;
        self.first.get_or_insert(time);
        self.last = time;
        if self.chunk.records.len() >= CHUNK {
            self.write_chunk()
        } else {
            Ok(())
        }
    }

    /// Writes what is left, and the index.
    ///
    /// # Errors
    /// It could not be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.write_chunk()?;
        let mut end = Vec::new();
        record(&mut end, opcode::DATA_END, &0_u32.to_le_bytes());
        self.put(&end)?;
        let summary = self.offset;
        let mut text = std::mem::take(&mut self.described);
        text.extend(std::mem::take(&mut self.chunks));
        record(&mut text, opcode::STATISTICS, &self.statistics()?);
        let mut footer = Vec::new();
        footer.extend(summary.to_le_bytes());
        // No summary offsets, no checksum.
        footer.extend(0_u64.to_le_bytes());
        footer.extend(0_u32.to_le_bytes());
        record(&mut text, opcode::FOOTER, &footer);
        text.extend(MAGIC);
        self.put(&text)?;
        self.file.flush()
    }

    fn write_chunk(&mut self) -> io::Result<()> {
        let chunk = std::mem::take(&mut self.chunk);
        let Some(first) = chunk.first else { return Ok(()) };
        let size = chunk.records.len() as u64;
        let mut content = Vec::with_capacity(chunk.records.len() + 64);
        content.extend(first.to_le_bytes());
        content.extend(chunk.last.to_le_bytes());
        content.extend(size.to_le_bytes());
        content.extend(crc32fast::hash(&chunk.records).to_le_bytes());
        text(&mut content, "");
        content.extend(size.to_le_bytes());
        content.extend(&chunk.records);
        let mut written = Vec::new();
        record(&mut written, opcode::CHUNK, &content);
        let (start, length) = (self.offset, written.len() as u64);
        self.put(&written)?;

        let indexes = self.offset;
        let mut offsets = Vec::new();
        for (id, entries) in &chunk.index {
            offsets.extend(id.to_le_bytes());
            offsets.extend(self.offset.to_le_bytes());
            let mut list = Vec::new();
            for (time, offset) in entries {
                list.extend(time.to_le_bytes());
                list.extend(offset.to_le_bytes());
            }
            let mut content = id.to_le_bytes().to_vec();
            sized(&mut content, &list);
            let mut index = Vec::new();
            record(&mut index, opcode::MESSAGE_INDEX, &content);
            self.put(&index)?;
        }
        let mut content = Vec::new();
        content.extend(first.to_le_bytes());
        content.extend(chunk.last.to_le_bytes());
        content.extend(start.to_le_bytes());
        content.extend(length.to_le_bytes());
        sized(&mut content, &offsets);
        content.extend((self.offset - indexes).to_le_bytes());
        text(&mut content, "");
        content.extend(size.to_le_bytes());
        content.extend(size.to_le_bytes());
        record(&mut self.chunks, opcode::CHUNK_INDEX, &content);
        self.chunk_count += 1;
        Ok(())
    }

    fn statistics(&self) -> io::Result<Vec<u8>> {
        let count = number_of(self.channels.len())?;
        let mut content = Vec::new();
        content.extend((self.messages * u64::from(count)).to_le_bytes());
        content.extend(count.to_le_bytes());
        content.extend(u32::from(count).to_le_bytes());
        // No attachments, no metadata.
        content.extend(0_u32.to_le_bytes());
        content.extend(0_u32.to_le_bytes());
        content.extend(self.chunk_count.to_le_bytes());
        content.extend(self.first.unwrap_or_default().to_le_bytes());
        content.extend(self.last.to_le_bytes());
        let mut counts = Vec::new();
        for index in 0..self.channels.len() {
            counts.extend(number_of(index)?.to_le_bytes());
            counts.extend(self.messages.to_le_bytes());
        }
        sized(&mut content, &counts);
        Ok(content)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.offset += bytes.len() as u64;
        self.file.write_all(bytes)
    }
}

impl Channel {
    fn schema(&self, id: u16) -> Vec<u8> {
        let properties: serde_json::Map<String, serde_json::Value> = self
            .members
            .iter()
            .map(|(name, _)| (name.clone(), serde_json::json!({"type": "number"})))
            .collect();
        let schema = serde_json::json!({"type": "object", "title": self.topic, "properties": properties});
        let mut content = (id + 1).to_le_bytes().to_vec();
        text(&mut content, &self.topic);
        text(&mut content, "jsonschema");
        text(&mut content, &schema.to_string());
        content
    }

    /// Schema ids count from 1: 0 is none.
    fn channel(&self, id: u16) -> Vec<u8> {
        let mut content = id.to_le_bytes().to_vec();
        content.extend((id + 1).to_le_bytes());
        text(&mut content, &format!("/{}", self.topic));
        text(&mut content, "json");
        sized(&mut content, &[]);
        content
    }

    fn message(&self, row: &[f64], content: &mut Vec<u8>) -> io::Result<()> {
        let mut buffer = zmij::Buffer::new();
        for (index, (name, column)) in self.members.iter().enumerate() {
            let value = row.get(*column).copied().unwrap_or_default();
            // Names of members need no escapes; JSON has neither infinities nor NaN.
            let digits = if value.is_finite() {
                buffer.format(value)
            } else {
                "null"
            };
            write!(content, "{}\"{name}\":{digits}", if index == 0 { '{' } else { ',' })?;
        }
        content.push(b'}');
        Ok(())
    }
}

fn number_of(index: usize) -> io::Result<u16> {
    u16::try_from(index)
        .ok()
        .filter(|id| *id < u16::MAX)
        .ok_or_else(|| io::Error::other("too many channels"))
}

fn record(out: &mut Vec<u8>, opcode: u8, content: &[u8]) {
    out.push(opcode);
    out.extend((content.len() as u64).to_le_bytes());
    out.extend(content);
}

/// Bytes with their length, UDINT.
fn sized(out: &mut Vec<u8>, bytes: &[u8]) {
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(bytes);
}

fn text(out: &mut Vec<u8>, text: &str) {
    sized(out, text.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Opcodes and contents.
    fn records(mut bytes: &[u8]) -> Vec<(u8, &[u8])> {
        let mut records = Vec::new();
        while bytes.len() > MAGIC.len() {
            let length = u64::from_le_bytes(bytes[1..9].try_into().expect("eight bytes")) as usize;
            records.push((bytes[0], &bytes[9..9 + length]));
            bytes = &bytes[9 + length..];
        }
        assert_eq!(bytes, MAGIC, "the end");
        records
    }

    #[test]
    fn a_file_is_whole_and_indexed() {
        let mut bytes = Vec::new();
        let signals = ["X.CommandPosition", "CS1.PathSpeed", "X.ActualPosition"].map(str::to_owned);
        let mut mcap = Mcap::new(&mut bytes, &signals, Duration::from_millis(1)).expect("begun");
        let rows = 30_000_u64;
        for tick in 0..rows {
            mcap.row(tick + 5, &[tick as f64 * 0.5, 1.0, f64::NAN])
                .expect("written");
        }
        mcap.finish().expect("finished");
        assert!(bytes.starts_with(MAGIC));
        let records = records(&bytes[MAGIC.len()..]);
        let of = |opcode: u8| {
            records
                .iter()
                .filter(move |(code, _)| *code == opcode)
                .map(|(_, content)| *content)
        };
        // In front and in the summary.
        assert_eq!((of(opcode::SCHEMA).count(), of(opcode::CHANNEL).count()), (4, 4));
        let chunks: Vec<&[u8]> = of(opcode::CHUNK).collect();
        assert!(
            chunks.len() > 1 && chunks.len() == of(opcode::CHUNK_INDEX).count(),
            "{}",
            chunks.len()
        );
        assert_eq!(of(opcode::MESSAGE_INDEX).count(), 2 * chunks.len());
        // 8 + 8 + 8 + 4 + 4 + 8 bytes of head, then the messages.
        let mut messages = Vec::new();
        for chunk in &chunks {
            let inner = [&chunk[40..], MAGIC].concat();
            assert_eq!(chunk[24..28], crc32fast::hash(&chunk[40..]).to_le_bytes());
            messages.extend(
                super::tests::records(&inner)
                    .iter()
                    .map(|(_, content)| content.to_vec()),
            );
        }
        assert_eq!(messages.len() as u64, 2 * rows);
        let message = &messages[2];
        assert_eq!(message[6..14], 6_000_000_u64.to_le_bytes());
        assert_eq!(&message[22..], b"{\"CommandPosition\":0.5,\"ActualPosition\":null}");
        // Indexes point at records of their kind.
        for index in of(opcode::CHUNK_INDEX) {
            let start = u64::from_le_bytes(index[16..24].try_into().expect("eight bytes")) as usize;
            assert_eq!(bytes[start], opcode::CHUNK);
            let offset = u64::from_le_bytes(index[38..46].try_into().expect("eight bytes")) as usize;
            assert_eq!(bytes[offset], opcode::MESSAGE_INDEX);
        }
        let footer = of(opcode::FOOTER).next().expect("a footer");
        let summary = u64::from_le_bytes(footer[..8].try_into().expect("eight bytes")) as usize;
        assert_eq!(bytes[summary], opcode::SCHEMA);
        let statistics = of(opcode::STATISTICS).next().expect("statistics");
        assert_eq!(statistics[..8], (2 * rows).to_le_bytes());
    }
}
