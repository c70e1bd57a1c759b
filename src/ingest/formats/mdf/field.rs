//! Where in a record a channel's number is, and how it is written there.

use falcon_mdf::blocks::{ChannelType, DataType};
use falcon_mdf::{Channel, ChannelGroup, Conversion};

/// Records in memory.
pub(super) enum Layout<'a> {
    /// One after the other.
    Records {
        /// Whole records.
        bytes: &'a [u8],
        /// Length of one.
        record: usize,
    },
    /// The first bytes of all, then the second ones, and so on.
    Columns {
        /// As many bytes for each place in a record as there are lines.
        bytes: &'a [u8],
        lines: usize,
    },
}

/// A channel's place in its group's records.
pub(super) struct Field<'a> {
    channel: &'a Channel,
    at: usize,
    number: Number,
    /// Byte and mask of the invalidation bit.
    invalid: Option<(usize, u8)>,
}

/// How a number is written, little-endian.
#[derive(Clone, Copy)]
enum Number {
    F32,
    F64,
    Integer { shift: u32, bits: u32, signed: bool },
}

impl Number {
    fn of(channel: &Channel) -> Option<Number> {
        let (shift, bits) = (u32::from(channel.bit_offset), channel.bit_count);
        match (channel.data_type, shift, bits) {
            (DataType::FloatLe, 0, 32) => Some(Number::F32),
            (DataType::FloatLe, 0, 64) => Some(Number::F64),
            // a damaged count may be any
            (DataType::UIntLe | DataType::IntLe, _, 1..=64) if shift + bits <= 64 => {
                Some(Number::Integer { shift, bits, signed: channel.is_signed() })
            }
            _ => None,
        }
    }

    /// Len, bytes.
    fn len(self) -> usize {
        match self {
            Number::F32 => 4,
            Number::F64 => 8,
            Number::Integer { shift, bits, .. } => (shift + bits).div_ceil(8) as usize,
        }
    }
}

impl<'a> Field<'a> {
    /// Of a channel after a record number of `id` bytes; `None` if it is not a plain number.
    pub(super) fn of(channel: &'a Channel, group: &ChannelGroup, id: usize) -> Option<Field<'a>> {
        let stored = matches!(channel.channel_type, ChannelType::FixedLength | ChannelType::Master);
        let readable = channel.unreadable().is_none() && channel.value_kind().is_numeric();
        if !stored || !readable || channel.is_array() {
            return None;
        }
        let number = Number::of(channel)?;
        let at = id.checked_add(channel.byte_offset as usize)?;
        if at.checked_add(number.len())? > id + group.payload_size() {
            return None;
        }
        let byte = (channel.inval_bit_pos / 8) as usize;
        let told = channel.invalidation_bit && byte < group.inval_bytes_len();
        let invalid =
            told.then(|| (id + group.data_bytes_len() + byte, 1_u8 << (channel.inval_bit_pos % 8)));
        Some(Field { channel, at, number, invalid })
    }

    /// The physical values of the records, NaN where they are invalid.
    pub(super) fn decode(&self, records: &Layout<'_>, out: &mut [f64]) {
        match self.number {
            Number::F32 => records.fill(self.at, out, |b| f64::from(f32::from_le_bytes(b))),
            Number::F64 => records.fill(self.at, out, f64::from_le_bytes),
            Number::Integer { shift, bits, signed } => match self.number.len() {
                1 => records.fill(self.at, out, |b: [u8; 1]| integer(b, shift, bits, signed)),
                2 => records.fill(self.at, out, |b: [u8; 2]| integer(b, shift, bits, signed)),
                3 => records.fill(self.at, out, |b: [u8; 3]| integer(b, shift, bits, signed)),
                4 => records.fill(self.at, out, |b: [u8; 4]| integer(b, shift, bits, signed)),
                5 => records.fill(self.at, out, |b: [u8; 5]| integer(b, shift, bits, signed)),
                6 => records.fill(self.at, out, |b: [u8; 6]| integer(b, shift, bits, signed)),
                7 => records.fill(self.at, out, |b: [u8; 7]| integer(b, shift, bits, signed)),
                _ => records.fill(self.at, out, |b: [u8; 8]| integer(b, shift, bits, signed)),
            },
        }
        match self.channel.conversion {
            _ if self.channel.conversion.is_identity() => {}
            Conversion::Linear { offset, factor } => {
                out.iter_mut().for_each(|v| *v = factor * *v + offset);
            }
            _ => out.iter_mut().for_each(|v| *v = self.channel.convert(*v)),
        }
        if self.channel.all_invalid {
            out.fill(f64::NAN);
        } else if let Some((at, mask)) = self.invalid {
            for (i, value) in out.iter_mut().enumerate() {
                if records.byte(i, at) & mask != 0 {
                    *value = f64::NAN;
                }
            }
        }
    }
}

fn integer<const N: usize>(bytes: [u8; N], shift: u32, bits: u32, signed: bool) -> f64 {
    let mut whole = [0; 8];
    whole[..N].copy_from_slice(&bytes);
    let unused = 64 - bits;
    let left = (u64::from_le_bytes(whole) >> shift) << unused;
    if signed {
        ((left as i64) >> unused) as f64
    } else if unused > 0 {
        // as a signed number the processor converts it faster
        ((left >> unused) as i64) as f64
    } else {
        left as f64
    }
}

impl Layout<'_> {
    /// The number in the `N` bytes from `at` on of each record.
    fn fill<const N: usize>(&self, at: usize, out: &mut [f64], number: impl Fn([u8; N]) -> f64) {
        match *self {
            Layout::Records { bytes, record } => {
                let from = bytes.get(at..).unwrap_or_default();
                for (record, value) in from.chunks(record).zip(out) {
                    if let Some(field) = record.first_chunk() {
                        *value = number(*field);
                    }
                }
            }
            Layout::Columns { bytes, lines } => {
                let part = |k: usize| bytes.get((at + k) * lines..).unwrap_or_default();
                let parts: [&[u8]; N] = std::array::from_fn(part);
                let least = parts.iter().map(|p| p.len()).min().unwrap_or(0).min(out.len());
                let parts = parts.map(|p| &p[..least]);
                for (i, value) in out[..least].iter_mut().enumerate() {
                    let mut field = [0; N];
                    for k in 0..N {
                        field[k] = parts[k][i];
                    }
                    *value = number(field);
                }
            }
        }
    }

    /// A byte of a record.
    fn byte(&self, i: usize, at: usize) -> u8 {
        let place = match *self {
            Layout::Records { record, .. } => i * record + at,
            Layout::Columns { lines, .. } => at * lines + i,
        };
        let (Layout::Records { bytes, .. } | Layout::Columns { bytes, .. }) = *self;
        bytes.get(place).copied().unwrap_or(0)
    }
}
