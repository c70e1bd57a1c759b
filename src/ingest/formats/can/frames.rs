//! The frames of a log, whatever kind of file it is.

use std::io::{BufReader, Read};

use super::frame::{Frame, Scan};
use super::{blf, text, trc};
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::store::objects::{Location, source};

/// The kinds of CAN logs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FrameFile {
    /// Vector's binary logging format.
    Blf,
    /// Vector's text.
    Asc,
    /// Linux can-utils' text, as a log or as shown on the screen.
    Candump,
    /// PEAK's text.
    Trc,
}

/// Kind of a log by its first bytes.
pub(super) fn kind(head: &[u8]) -> Option<FrameFile> {
    if head.starts_with(b"LOGG") {
        return Some(FrameFile::Blf);
    }
    let start = &head[..head.len().min(4096)];
    if start.contains(&0) {
        return None;
    }
    let start = String::from_utf8_lossy(start);
    if trc::is_trace(&start) {
        return Some(FrameFile::Trc);
    }
    let mut lines = start.trim_start_matches('\u{feff}').lines().map(str::trim);
    let mut lines = lines.by_ref().filter(|l| !l.is_empty() && !l.starts_with("//"));
    let first = lines.next()?;
    if text::candump(first).is_some() {
        return Some(FrameFile::Candump);
    }
    let is_base = |line: &str| text::Base::parse(line).is_some();
    let asc = is_base(first) || (first.starts_with("date ") && lines.take(4).any(is_base));
    asc.then_some(FrameFile::Asc)
}

/// Every data frame in turn. Error frames, remote frames and other events are passed over.
pub(super) fn each(log: &Location, take: &mut dyn FnMut(&Frame<'_>)) -> Result<Scan, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let mut reader = BufReader::with_capacity(1 << 18, source::open(log).map_err(fail)?);
    let mut head = Vec::new();
    reader.by_ref().take(4096).read_to_end(&mut head).map_err(fail)?;
    let kind = kind(&head).ok_or_else(|| {
        Error::new(RejectionCode::UnknownFormat, format!("{log} is not a CAN log any more"))
    })?;
    let mut whole = head.chain(reader);
    match kind {
        FrameFile::Blf => blf::each(&mut whole, take),
        FrameFile::Asc => text::each_asc(&mut whole, take),
        FrameFile::Candump => text::each_candump(&mut whole, take),
        FrameFile::Trc => trc::each(&mut whole, take),
    }
    .map_err(fail)
}

/// Lets a vector go before a reader.
trait Chained {
    fn chain<R: Read>(self, rest: R) -> BufReader<std::io::Chain<std::io::Cursor<Vec<u8>>, R>>;
}

impl Chained for Vec<u8> {
    fn chain<R: Read>(self, rest: R) -> BufReader<std::io::Chain<std::io::Cursor<Vec<u8>>, R>> {
        BufReader::with_capacity(1 << 16, Read::chain(std::io::Cursor::new(self), rest))
    }
}
