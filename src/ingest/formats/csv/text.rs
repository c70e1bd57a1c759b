//! Text of whatever encoding as UTF-8 bytes.
//!
//! A byte order mark stands for UTF-8 or UTF-16; without one the bytes are passed on as they are, for
//! numbers look the same in every encoding that is left, and [`decoded`] takes names and units
//! that are not UTF-8 for Latin-1.

use std::io::{Read, Result};

/// Most bytes that are taken from the file at a time.
const BLOCK: usize = 1 << 16;

/// A file's text as UTF-8.
pub struct Text<R> {
    file: R,
    encoding: Encoding,
    /// UTF-8 that nobody has asked for yet.
    ready: Vec<u8>,
    /// How much of it was handed out.
    given: usize,
    /// A byte or a surrogate that waits for its other half.
    left: Vec<u8>,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Bytes,
    Utf16 { little: bool },
}

impl<R: Read> Text<R> {
    /// Looks at the first bytes of a file.
    ///
    /// # Errors
    /// They cannot be read.
    pub fn new(mut file: R) -> Result<Self> {
        let mut mark = Vec::with_capacity(3);
        file.by_ref().take(3).read_to_end(&mut mark)?;
        let (encoding, skip) = match mark[..] {
            [0xff, 0xfe, ..] => (Encoding::Utf16 { little: true }, 2),
            [0xfe, 0xff, ..] => (Encoding::Utf16 { little: false }, 2),
            [0xef, 0xbb, 0xbf] => (Encoding::Bytes, 3),
            _ => (Encoding::Bytes, 0),
        };
        let rest = mark.split_off(skip.min(mark.len()));
        let (ready, left) = match encoding {
            Encoding::Bytes => (rest, Vec::new()),
            Encoding::Utf16 { .. } => (Vec::new(), rest),
        };
        Ok(Text { file, encoding, ready, given: 0, left })
    }

    fn fill(&mut self, little: bool) -> Result<()> {
        let mut raw = std::mem::take(&mut self.left);
        let before = raw.len();
        raw.resize(before + BLOCK, 0);
        let n = loop {
            match self.file.read(&mut raw[before..]) {
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                done => break done?,
            }
        };
        raw.truncate(before + n);
        let mut whole = raw.len() / 2 * 2;
        let unit = |i: usize| {
            let pair = [raw[i], raw[i + 1]];
            if little { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) }
        };
        // the first half of a pair of surrogates waits for the second
        if n > 0 && whole >= 2 && (0xd800..0xdc00).contains(&unit(whole - 2)) {
            whole -= 2;
        }
        let units: Vec<u16> = (0..whole).step_by(2).map(unit).collect();
        self.ready = String::from_utf16_lossy(&units).into_bytes();
        self.given = 0;
        self.left = raw.split_off(whole);
        if n == 0 {
            self.left.clear(); // half a letter at the end of a file that was cut
        }
        Ok(())
    }
}

impl<R: Read> Read for Text<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.given == self.ready.len() {
            match self.encoding {
                Encoding::Bytes => return self.file.read(out),
                // a block may hold no whole letter
                Encoding::Utf16 { little } => loop {
                    let waiting = self.left.len();
                    self.fill(little)?;
                    if !self.ready.is_empty() || self.left.len() <= waiting {
                        break;
                    }
                },
            }
        }
        let n = out.len().min(self.ready.len() - self.given);
        out[..n].copy_from_slice(&self.ready[self.given..self.given + n]);
        self.given += n;
        Ok(n)
    }
}

/// Whether bytes begin with the mark of UTF-16.
pub fn is_utf16(bytes: &[u8]) -> bool {
    matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..])
}

/// Bytes as text: UTF-8, or else Latin-1.
pub fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a few bytes at a time.
    struct Slow<'a>(&'a [u8], usize);

    impl Read for Slow<'_> {
        fn read(&mut self, out: &mut [u8]) -> Result<usize> {
            let n = self.1.min(out.len()).min(self.0.len());
            out[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    fn read(bytes: &[u8], step: usize) -> String {
        let mut out = Vec::new();
        Text::new(Slow(bytes, step)).expect("in memory").read_to_end(&mut out).expect("in memory");
        decoded(&out)
    }

    #[test]
    fn every_encoding_is_the_same_text() {
        let text = "Time,°C,m/s²\n1,2,3\n🏍,é\n";
        let utf16 = |little: bool| {
            let mut bytes = if little { vec![0xff, 0xfe] } else { vec![0xfe, 0xff] };
            for unit in text.encode_utf16() {
                bytes.extend(if little { unit.to_le_bytes() } else { unit.to_be_bytes() });
            }
            bytes
        };
        let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        for step in [1, 2, 3, 7, 1000] {
            for bytes in [text.as_bytes().to_vec(), marked.clone(), utf16(true), utf16(false)] {
                assert_eq!(read(&bytes, step), text, "{step} bytes at a time");
            }
            // cut within a letter
            let cut = utf16(true);
            assert!(read(&cut[..cut.len() - 1], step).starts_with("Time,°C"));
        }
        assert_eq!(read(b"T [\xb0C]", 5), "T [°C]");
        assert_eq!(read(b"", 5), "");
        assert_eq!(read(b"\xff\xfe", 5), "");
    }
}
