//! Which format a log is of.

use std::io::Read as _;

use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::ingest::formats::FORMATS;
use crate::ingest::formats::format::{HEAD_LEN, Head, LogFormat};
use crate::ingest::formats::unread;
use crate::store::objects::{Location, source};

/// Largest file that is read, bytes: a day of 100 Hz riding is a tenth of it.
const MAX_FILE: u64 = 4 << 30;

/// The format of a log.
///
/// # Errors
/// The file cannot be read or is of no known kind.
pub fn format_of(log: impl Into<Location>) -> Result<&'static LogFormat, Error> {
    let log = &log.into();
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let mut file = source::open(log).map_err(fail)?;
    let size = file.size().map_err(fail)?;
    if size == 0 {
        return Err(Error::new(RejectionCode::EmptyFile, format!("{log} is empty")));
    }
    if size > MAX_FILE {
        let message = format!("{log} is {} MB long; split the log", size >> 20);
        return Err(Error::new(RejectionCode::FileTooLarge, message));
    }
    let mut bytes = Vec::new();
    let named = Head { log, bytes: &bytes };
    if let Some(format) = FORMATS.first().filter(|f| (f.sniff)(&named)) {
        return Ok(format); // its name settles it: its first bytes need not be fetched
    }
    file.by_ref().take(HEAD_LEN).read_to_end(&mut bytes).map_err(fail)?;
    let head = Head { log, bytes: &bytes };
    let found = FORMATS.iter().find(|f| (f.sniff)(&head));
    // almost any text could be a table
    let sure = found.is_some_and(|f| f.name != "csv");
    if let Some(advice) = unread::advice(&head).filter(|_| !sure) {
        let code = match unread::is_packed(advice) {
            true => RejectionCode::UnknownCompression,
            false => RejectionCode::UnknownFormat,
        };
        return Err(Error::new(code, format!("{log} is {advice}")));
    }
    found.ok_or_else(|| {
        let names: Vec<&str> = FORMATS.iter().map(|f| f.name).collect();
        let message = format!("{log} is none of {}", names.join(", "));
        Error::new(RejectionCode::UnknownFormat, message)
    })
}
