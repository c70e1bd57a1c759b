//! Text of whatever encoding as UTF-8 bytes with line ends that are `\n` or `\r\n`.
//!
//! A byte order mark stands for UTF-8 or UTF-16, and a zero in every other byte for UTF-16 without one. Of bytes that are
//! no UTF-8 the encoding is the one in which most words are known names ([`by_words`]). Other bytes are passed on as they
//! are, for numbers look the same in every encoding that is left, and [`decoded`] takes names and units that are not UTF-8
//! for Latin-1. A lone `\r` (old Macintosh programs) becomes `\n`, and so do the zeros that a
//! file holds whose logger lost its power.

use std::io::{Read, Result};

use encoding_rs::{
    BIG5, EUC_JP, EUC_KR, Encoding as Legacy, GBK, IBM866, ISO_8859_2, KOI8_R, SHIFT_JIS,
    WINDOWS_1250, WINDOWS_1251, WINDOWS_1252, WINDOWS_1253, WINDOWS_1254,
};

use crate::contract::warning::Warning;
use crate::ingest::error::Error;
use crate::ingest::maps::propose::is_known_word;
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

/// Most bytes that are taken from the file at a time.
const BLOCK: usize = 1 << 16;

/// Encodings of older programs, the likeliest first.
static LEGACY: [&Legacy; 13] = [
    WINDOWS_1252,
    WINDOWS_1250,
    WINDOWS_1251,
    SHIFT_JIS,
    GBK,
    EUC_KR,
    BIG5,
    EUC_JP,
    WINDOWS_1253,
    WINDOWS_1254,
    ISO_8859_2,
    KOI8_R,
    IBM866,
];

/// Letters beyond ASCII in a line by which its words are in another language: fewer are signs like `°`.
const FOREIGN: usize = 12;

/// Lines in which names are looked for.
const NAME_LINES: usize = 40;

/// A file's text as UTF-8.
pub(crate) struct Text<R> {
    file: R,
    encoding: Encoding,
    /// Of an encoding of older programs.
    decoder: Option<encoding_rs::Decoder>,
    /// Whether lines end with a lone `\r`.
    returns: bool,
    /// UTF-8 that nobody has asked for yet.
    ready: Vec<u8>,
    /// How much of it was handed out.
    given: usize,
    /// A byte or a surrogate that waits for its other half.
    left: Vec<u8>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Bytes,
    Legacy(&'static Legacy),
    Utf16 { little: bool },
}

impl<R: Read> Text<R> {
    /// Looks at the first bytes of a file.
    ///
    /// # Errors
    /// They cannot be read.
    pub(crate) fn new(mut file: R) -> Result<Self> {
        let mut head = Vec::with_capacity(BLOCK);
        file.by_ref().take(BLOCK as u64).read_to_end(&mut head)?;
        let (encoding, skip) = encoding(&head);
        let rest = head.split_off(skip);
        let mut text = Text {
            file,
            encoding,
            decoder: None,
            returns: false,
            ready: Vec::new(),
            given: 0,
            left: Vec::new(),
        };
        match encoding {
            Encoding::Bytes => text.ready = rest,
            Encoding::Legacy(of) => {
                text.decoder = Some(of.new_decoder_without_bom_handling());
                text.translate(&rest, rest.len() < BLOCK);
            }
            Encoding::Utf16 { little } => {
                text.left = rest;
                text.fill(little)?;
            }
        }
        text.returns = !text.ready.contains(&b'\n') && text.ready.contains(&b'\r');
        let returns = text.returns;
        clean(&mut text.ready, returns);
        Ok(text)
    }

    /// Letters of an older encoding as UTF-8; `last` of the end of the file.
    fn translate(&mut self, bytes: &[u8], last: bool) {
        let Some(decoder) = &mut self.decoder else { return };
        let room = decoder.max_utf8_buffer_length(bytes.len()).unwrap_or(4 * bytes.len() + 16);
        let mut text = String::with_capacity(room);
        let _ = decoder.decode_to_string(bytes, &mut text, last);
        (self.ready, self.given) = (text.into_bytes(), 0);
        if last {
            self.decoder = None;
        }
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
                Encoding::Bytes => {
                    let n = self.file.read(out)?;
                    clean(&mut out[..n], self.returns);
                    return Ok(n);
                }
                Encoding::Legacy(_) => {
                    // a block may hold no whole letter
                    while self.given == self.ready.len() && self.decoder.is_some() {
                        let mut raw = Vec::with_capacity(BLOCK);
                        self.file.by_ref().take(BLOCK as u64).read_to_end(&mut raw)?;
                        self.translate(&raw, raw.len() < BLOCK);
                        clean(&mut self.ready, self.returns);
                    }
                }
                // a block may hold no whole letter
                Encoding::Utf16 { little } => loop {
                    let waiting = self.left.len();
                    self.fill(little)?;
                    if !self.ready.is_empty() || self.left.len() <= waiting {
                        let returns = self.returns;
                        clean(&mut self.ready, returns);
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

/// Zeros and lone returns to line ends.
fn clean(bytes: &mut [u8], returns: bool) {
    if bytes.contains(&0) {
        bytes.iter_mut().filter(|b| **b == 0).for_each(|b| *b = b'\n');
    }
    if returns {
        bytes.iter_mut().filter(|b| **b == b'\r').for_each(|b| *b = b'\n');
    }
}

/// The encoding that the first bytes say, and the length of their mark.
fn encoding(head: &[u8]) -> (Encoding, usize) {
    match head {
        [0xff, 0xfe, ..] => (Encoding::Utf16 { little: true }, 2),
        [0xfe, 0xff, ..] => (Encoding::Utf16 { little: false }, 2),
        [0xef, 0xbb, 0xbf, ..] => (Encoding::Bytes, 3),
        // letters of names beside zeros
        [a, 0, b, 0, ..] if *a != 0 && *b != 0 => (Encoding::Utf16 { little: true }, 0),
        [0, a, 0, b, ..] if *a != 0 && *b != 0 => (Encoding::Utf16 { little: false }, 0),
        _ => (by_words(head).map_or(Encoding::Bytes, Encoding::Legacy), 0),
    }
}

/// The encoding in which the names of a text are words that are known; `None` of UTF-8 and of a text that says nothing.
fn by_words(head: &[u8]) -> Option<&'static Legacy> {
    let lines = head.split_inclusive(|b| *b == b'\n' || *b == b'\r');
    let names: Vec<u8> =
        lines.take(NAME_LINES).filter(|l| !l.is_ascii()).flatten().copied().collect();
    let utf8 = std::str::from_utf8(&names).err().is_none_or(|e| e.error_len().is_none());
    let control = |b: &u8| b.is_ascii_control() && !matches!(b, b'\t' | b'\r' | b'\n');
    if utf8 || names.iter().any(control) {
        return None;
    }
    let known = |encoding: &&'static Legacy| {
        let (text, _, damaged) = encoding.decode(&names);
        let words = text.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_ascii());
        (if damaged { 0 } else { words.filter(|w| is_known_word(w)).count() }, *encoding)
    };
    // of equal ones the first
    let mut scored = LEGACY.iter().map(known);
    let first = scored.next()?;
    let best = scored.fold(first, |best, next| if next.0 > best.0 { next } else { best });
    (best.0 > 0).then_some(best.1)
}

/// A warning of a log whose encoding is not known.
///
/// # Errors
/// It cannot be read.
pub(super) fn encoding_warning(log: &Location) -> std::result::Result<Option<Warning>, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let mut head = Vec::new();
    source::open(log).map_err(fail)?.take(BLOCK as u64).read_to_end(&mut head).map_err(fail)?;
    Ok(unknown_encoding(&head).map(|m| warning("unknown_encoding", None, 1, None, m)))
}

/// Message about a text in no encoding that is known: names that are no UTF-8 and words of no language.
fn unknown_encoding(head: &[u8]) -> Option<String> {
    // signs of Latin-1 are no letters: °, ², µ, º, ·
    let letter = |b: &&u8| !b.is_ascii() && ![0xb0, 0xb2, 0xb5, 0xb7, 0xba].contains(*b);
    let line =
        |l: &&[u8]| l.iter().filter(letter).count() > FOREIGN && std::str::from_utf8(l).is_err();
    let found = encoding(head) == (Encoding::Bytes, 0)
        && head.split(|b| *b == b'\n').take(NAME_LINES).any(|l| line(&l));
    found.then(|| {
        "its names are in no Unicode encoding (windows-1250, windows-1251, Shift_JIS, GBK, ...?) and no word of them is \
         known: save the file as UTF-8"
            .to_owned()
    })
}

/// Whether the first bytes of a file are text: without control characters but tabs, line ends, and the zeros at the
/// end of a file whose logger lost its power.
pub(crate) fn is_text(head: &[u8]) -> bool {
    if matches!(encoding(head).0, Encoding::Utf16 { .. }) {
        return true;
    }
    let zeros = head.iter().rev().take_while(|b| **b == 0).count();
    let mut text = &head[..head.len() - zeros];
    // zeros within, and text again: the logger went on in the same file
    let plain = |b: &u8| !b.is_ascii_control() || matches!(b, b'\t' | b'\r' | b'\n');
    let mut lines = 0;
    while let Some(zero) = text.iter().position(|b| *b == 0) {
        let (before, after) = text.split_at(zero);
        lines += before.iter().filter(|b| matches!(b, b'\n' | b'\r')).count();
        if lines < 2 || !before.iter().all(plain) {
            return false;
        }
        text = &after[after.iter().take_while(|b| **b == 0).count()..];
    }
    !(text.is_empty() && zeros > 0 && lines == 0) && text.iter().all(plain)
}

/// Whether the first bytes of a file are UTF-16.
pub(crate) fn is_utf16(head: &[u8]) -> bool {
    matches!(encoding(head).0, Encoding::Utf16 { .. })
}

/// The first part of a text in whatever encoding; `None` if it is none.
pub(crate) fn beginning(head: &[u8]) -> Option<String> {
    if !is_text(head) && head.contains(&0) {
        return None;
    }
    Some(whole(head))
}

/// A text in whatever encoding.
pub(crate) fn whole(bytes: &[u8]) -> String {
    let mut utf8 = Vec::with_capacity(bytes.len());
    // reading from memory cannot fail
    if let Ok(mut text) = Text::new(bytes) {
        let _ = text.read_to_end(&mut utf8);
    }
    decoded(&utf8)
}

/// Bytes as text: UTF-8, or else Latin-1.
pub(crate) fn decoded(bytes: &[u8]) -> String {
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
        for bytes in [&utf16(true)[2..], &utf16(false)[2..]] {
            assert_eq!(read(bytes, 7), text, "without a mark");
        }
        assert_eq!(read(b"a,b\r1,2\r3,4", 5), "a,b\n1,2\n3,4");
        assert_eq!(read(b"a,b\r\n1,2\r\n", 5), "a,b\r\n1,2\r\n");
        assert_eq!(read(b"a,b\n1,\0\0\x003,4\n\0", 5), "a,b\n1,\n\n\n3,4\n\n");
        assert_eq!(read(b"", 5), "");
        assert_eq!(read(b"\xff\xfe", 5), "");
    }

    #[test]
    fn older_encodings_are_known_by_their_words() {
        for (encoding, names) in [
            (WINDOWS_1250, "Czas (s);Prędkość GPS (km/h);Szerokość geogr.;Długość geogr."),
            (WINDOWS_1251, "Время (с);Скорость GPS (км/ч);Широта;Долгота"),
            (SHIFT_JIS, "時間 (s),GPS速度 (km/h),緯度,経度"),
            (GBK, "时间(s),GPS速度(km/h),纬度,经度"),
            (EUC_KR, "시간 (s),GPS 속도 (km/h),위도,경도"),
            (WINDOWS_1252, "Zeit (s);Schräglage (°);Breitengrad;Längengrad"),
        ] {
            let rows = "0,00;54,04;47,0;8,0\n".repeat(6000);
            let (bytes, _, lost) = encoding.encode(names);
            assert!(!lost, "{names}");
            let text = [&bytes[..], b"\n", rows.as_bytes(), &bytes[..]].concat();
            let found = read(&text, 1000);
            assert!(found.starts_with(names) && found.ends_with(names), "{}", &found[..80]);
            assert_eq!(unknown_encoding(&text), None);
        }
        // a sign is no word
        assert_eq!(encoding(b"T [\xb0C];v\n0;1\n"), (Encoding::Bytes, 0));
        assert_eq!(unknown_encoding(b"T [\xb0C];v\n0;1\n"), None);
        let (greek, _, _) = WINDOWS_1253.encode("Ωμεγα;Στροφες;Ισχυς κινητηρα\n0;1;2\n");
        assert!(unknown_encoding(&greek).is_some_and(|m| m.contains("UTF-8")));
    }

    #[test]
    fn text_with_zeros_of_a_lost_power_is_text() {
        for (bytes, text) in [
            (&b"a,b\n1,2\n"[..], true),
            (b"a,b\n1,2\n3,\0\0\0", true),
            (b"a,b\n1,2\n3,\0\0\x004,5\n", true),
            (b"\0\0\0\0", false),
            (b"a\0b\0,\0", true),
            (b"PK\x03\x04\0\0", false),
            (b"ab\0cd\n\n", false),
        ] {
            assert_eq!(is_text(bytes), text, "{bytes:?}");
        }
    }
}
