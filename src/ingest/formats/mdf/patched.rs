//! A file that was repaired in memory.

use std::sync::Arc;

use falcon_mdf::Mf4Error;
use falcon_mdf::io::{ByteSlice, ByteSource};

use super::file::Bytes;

/// Bytes of a file with some eight of them replaced.
pub(super) struct Patched {
    /// As they are in the file.
    pub bytes: Arc<dyn Bytes>,
    /// Place and new value, ascending.
    pub patches: Vec<(u64, u64)>,
}

impl Bytes for Patched {}

impl ByteSource for Patched {
    fn len(&self) -> u64 {
        self.bytes.len()
    }

    fn read_bytes(&self, offset: u64, len: usize) -> Result<ByteSlice<'_>, Mf4Error> {
        let read = self.bytes.read_bytes(offset, len)?;
        let end = offset.saturating_add(len as u64);
        let first = self.patches.partition_point(|(at, _)| at.saturating_add(8) <= offset);
        let here = self.patches[first..].iter().take_while(|(at, _)| *at < end);
        let mut here = here.peekable();
        if here.peek().is_none() {
            return Ok(read);
        }
        let mut own = read.into_owned();
        for (at, value) in here {
            for (place, byte) in (*at..).zip(value.to_le_bytes()) {
                let index = place.checked_sub(offset).and_then(|i| usize::try_from(i).ok());
                if let Some(slot) = index.and_then(|i| own.get_mut(i)) {
                    *slot = byte;
                }
            }
        }
        Ok(ByteSlice::owned(own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use falcon_mdf::io::memory::MemorySource;

    #[test]
    fn patches_show_wherever_they_are_read() {
        let bytes: Arc<dyn Bytes> = Arc::new(MemorySource::new(vec![7; 40]));
        let patches = vec![(4, u64::from_le_bytes([1; 8])), (20, u64::from_le_bytes([2; 8]))];
        let patched = Patched { bytes, patches };
        let whole = patched.read_bytes(0, 40).expect("there");
        for at in 0..40 {
            for len in 0..=(40 - at) {
                let part = patched.read_bytes(at as u64, len).expect("there");
                assert_eq!(part[..], whole[at..at + len], "{at} {len}");
            }
        }
        assert_eq!(whole[3..13], [7, 1, 1, 1, 1, 1, 1, 1, 1, 7]);
    }
}
