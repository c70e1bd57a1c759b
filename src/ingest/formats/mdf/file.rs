//! The bytes of a file, a part at a time, from several threads at once.

use std::sync::Arc;

use falcon_mdf::Mf4Error;
use falcon_mdf::io::ByteSource;
use falcon_mdf::io::range::{RangeFetch, RangeSource, read_seek_source};

use crate::store::objects::source::Source;

/// Bytes that can be read into the same memory again and again.
pub(super) trait Bytes: ByteSource {
    /// Replaces what is in `out`.
    ///
    /// # Errors
    /// They are not there or cannot be read.
    fn read_into(&self, offset: u64, len: usize, out: &mut Vec<u8>) -> Result<(), Mf4Error> {
        let read = self.read_bytes(offset, len)?;
        out.clear();
        out.extend_from_slice(&read);
        Ok(())
    }
}

impl<F: RangeFetch> Bytes for RangeSource<F> {}

/// The bytes of an open log.
///
/// # Errors
/// It cannot be asked for its length.
pub(super) fn bytes(log: Source) -> Result<Arc<dyn Bytes>, Mf4Error> {
    match log {
        #[cfg(unix)]
        Source::Local(file) => Ok(Arc::new(local::Local::new(file)?)),
        log => Ok(Arc::new(read_seek_source(log)?)),
    }
}

#[cfg(unix)]
mod local {
    use std::sync::Arc;

    use falcon_mdf::Mf4Error;
    use falcon_mdf::io::range::RangeSource;
    use falcon_mdf::io::{ByteSlice, ByteSource};

    use crate::store::objects::source::LocalLog;

    /// Less than this is read in windows that are kept: a description's many small blocks.
    const SMALL: usize = 32 << 10;

    /// Bytes of a packed block before its samples.
    const HEAD: usize = 64;

    /// A file on this machine. It is not mapped into memory: were it cut off meanwhile, that
    /// would end the program.
    pub(super) struct Local {
        file: Arc<LocalLog>,
        len: u64,
        small: Box<dyn ByteSource>,
    }

    impl Local {
        pub(super) fn new(file: LocalLog) -> Result<Self, Mf4Error> {
            let len = file.size()?;
            let file = Arc::new(file);
            let of_windows = Arc::clone(&file);
            let fetch = move |at: u64, out: &mut [u8]| Ok(of_windows.read_exact_at(out, at)?);
            Ok(Local { file, len, small: Box::new(RangeSource::new(len, fetch)) })
        }

        /// Whether a packed block is asked for from its head on, to learn what it is. The library
        /// asks so for all of them when it opens a file, and for the samples alone later: to read
        /// them now would be to read the whole file twice.
        fn is_look(&self, offset: u64, len: usize) -> Result<Option<ByteSlice<'_>>, Mf4Error> {
            let head = self.small.read_bytes(offset, HEAD)?;
            let own = head[8..16].iter().rev().fold(0, |sum, b| sum << 8 | u64::from(*b));
            Ok((head.starts_with(b"##DZ") && own == len as u64).then_some(head))
        }
    }

    impl ByteSource for Local {
        fn len(&self) -> u64 {
            self.len
        }

        fn read_bytes(&self, offset: u64, len: usize) -> Result<ByteSlice<'_>, Mf4Error> {
            let there = self.len.saturating_sub(offset);
            if len < SMALL || len as u64 > there {
                return self.small.read_bytes(offset, len);
            }
            let mut out = vec![0; len];
            match self.is_look(offset, len)? {
                Some(head) => out[..HEAD].copy_from_slice(&head),
                None => self.file.read_exact_at(&mut out, offset)?,
            }
            Ok(ByteSlice::owned(out))
        }
    }

    impl crate::ingest::formats::mdf::file::Bytes for Local {
        fn read_into(&self, offset: u64, len: usize, out: &mut Vec<u8>) -> Result<(), Mf4Error> {
            let there = self.len.saturating_sub(offset);
            if len as u64 > there {
                return Err(Mf4Error::truncated(offset, len, there as usize));
            }
            out.resize(len, 0);
            Ok(self.file.read_exact_at(out, offset)?)
        }
    }
}
