//! An open log, wherever it is: what the readers read from.
//!
//! A local log is the file. Of one in an object store only what is asked for is fetched, and kept
//! while it is open; the worker thread keeps the last one that it had open too, so that a log
//! whose header is looked at, then its samples read, is not fetched twice. Every part is of the
//! bytes that were listed: a log written anew meanwhile is an error, not a mixture.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufReader, Cursor, Error, ErrorKind, Read, Result, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::SystemTime;

use bytes::{Buf, Bytes};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::reader::{ChunkReader, Length};

use super::client;
use super::faults;
pub(crate) use super::faults::take as take_fault;
use super::files::{open_file, stat_local};
use super::location::Location;
use super::packed::{self, Unpacked};
use super::stat::Stat;
use super::url::Url;

/// Bytes fetched at a time where a log is read from its start to its end.
const BLOCK: u64 = 8 << 20;

/// Bytes fetched at least where a reader jumps.
const AHEAD: u64 = 64 << 10;

/// Known properties of a log, local or not.
///
/// # Errors
/// It is not there or cannot be asked for.
pub(crate) fn stat(log: impl Into<Location>) -> Result<Stat> {
    match log.into() {
        Location::Remote(url) => stat_of(&url),
        Location::Local(path) => stat_local(&path),
    }
}

/// Identity of a log's bytes, without a look at them: the store's ETag and the size.
///
/// # Errors
/// As [`stat`].
pub(crate) fn identity(url: &Url) -> Result<String> {
    let stat = stat_of(url)?;
    Ok(match &stat.etag {
        Some(etag) => format!("etag-{etag}-{}", stat.size),
        None => {
            let since = stat.modified.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
            format!("written-{}-{}", since.as_millis(), stat.size)
        }
    })
}

type StatCache = Mutex<HashMap<Url, Stat>>;

fn stat_cache() -> &'static StatCache {
    static CACHE: OnceLock<StatCache> = OnceLock::new();
    CACHE.get_or_init(Mutex::default)
}

/// Keeps a listing's entry of a log, until it is listed again.
pub(crate) fn remember(url: Url, stat: Stat) {
    stat_cache().lock().unwrap_or_else(PoisonError::into_inner).insert(url, stat);
}

fn stat_of(url: &Url) -> Result<Stat> {
    let listed = stat_cache().lock().unwrap_or_else(PoisonError::into_inner).get(url).cloned();
    match listed {
        Some(stat) => Ok(stat),
        None => {
            let stat = client::stat(url)?;
            remember(url.clone(), stat.clone());
            Ok(stat)
        }
    }
}

#[derive(Debug)]
pub(crate) enum Source {
    Local(LocalLog),
    Remote(Remote),
    /// Content of a packed log.
    Unpacked(Cursor<Bytes>),
}

/// A file of this machine; what it does not give is noted.
#[derive(Debug)]
pub(crate) struct LocalLog {
    file: File,
    log: Location,
}

impl LocalLog {
    fn open(log: &Location, path: &Path) -> Result<Self> {
        Ok(LocalLog { file: open_file(path)?, log: log.clone() })
    }

    /// Its bytes.
    ///
    /// # Errors
    /// The file cannot be asked.
    pub(crate) fn size(&self) -> Result<u64> {
        let meta = self.file.metadata();
        Ok(meta.inspect_err(|e| faults::note(&self.log, e))?.len())
    }

    /// Bytes at a place, wherever the reader is.
    ///
    /// # Errors
    /// The file ends before, or cannot be read.
    #[cfg(unix)]
    pub(crate) fn read_exact_at(&self, out: &mut [u8], at: u64) -> Result<()> {
        let read = std::os::unix::fs::FileExt::read_exact_at(&self.file, out, at);
        read.inspect_err(|e| faults::note(&self.log, e))
    }

    /// The same file, read from a place on.
    fn from(&self, start: u64) -> Result<LocalLog> {
        let mut file = self.file.try_clone().inspect_err(|e| faults::note(&self.log, e))?;
        file.seek(SeekFrom::Start(start))?;
        Ok(LocalLog { file, log: self.log.clone() })
    }
}

impl Read for LocalLog {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        self.file.read(out).inspect_err(|e| faults::note(&self.log, e))
    }
}

/// An object and where in it the reader is.
#[derive(Debug)]
pub(crate) struct Remote {
    log: Arc<Log>,
    at: u64,
}

/// Opens a log; a packed one (by its name) is unpacked.
///
/// # Errors
/// It is not there or cannot be read.
pub(crate) fn open(log: &Location) -> Result<Source> {
    if log.is_packed() {
        return Ok(Source::Unpacked(Cursor::new(unpacked(log)?.bytes)));
    }
    packed::forget();
    open_as_it_is(log)
}

/// Why the end of a packed log is missing, if it is.
pub(crate) fn broken(log: &Location) -> Option<String> {
    if log.is_packed() { unpacked(log).ok()?.broken } else { None }
}

fn unpacked(log: &Location) -> Result<Unpacked> {
    packed::unpacked(log, &stat(log)?, open_as_it_is(log)?)
}

fn open_as_it_is(log: &Location) -> Result<Source> {
    thread_local! {
        static LAST: RefCell<Option<Arc<Log>>> = const { RefCell::new(None) };
    }
    let url = match log {
        Location::Local(path) => return LocalLog::open(log, path).map(Source::Local),
        Location::Remote(url) => url,
    };
    let stat = stat_of(url)?;
    let log = LAST.with_borrow_mut(|last| match last {
        Some(log) if log.url == *url && log.stat == stat => Arc::clone(log),
        _ => {
            let log = Log { url: url.clone(), stat, parts: Mutex::default() };
            Arc::clone(last.insert(Arc::new(log)))
        }
    });
    Ok(Source::Remote(Remote { log, at: 0 }))
}

/// The whole log.
///
/// # Errors
/// As [`open()`].
pub(crate) fn read(log: &Location) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(log)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// An object's parts that are here already, by where they begin.
#[derive(Debug)]
struct Log {
    url: Url,
    stat: Stat,
    parts: Mutex<BTreeMap<u64, Bytes>>,
}

impl Log {
    /// Bytes present from a place on; empty if nothing is.
    fn here(&self, at: u64) -> Bytes {
        let parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        let before = parts.range(..=at).next_back();
        before
            .filter(|(start, part)| at - **start < part.len() as u64)
            .map(|(start, part)| part.slice((at - start) as usize..))
            .unwrap_or_default()
    }

    fn fetch(&self, ranges: &[Range<u64>]) -> Result<()> {
        let fetched = self.fetch_missing(ranges);
        fetched.inspect_err(|e| faults::note(&self.url.clone().into(), e))
    }

    fn fetch_missing(&self, ranges: &[Range<u64>]) -> Result<()> {
        let missing: Vec<Range<u64>> = ranges
            .iter()
            .map(|r| r.start..r.end.min(self.stat.size))
            .filter(|r| r.start < r.end && (self.here(r.start).len() as u64) < r.end - r.start)
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        if client::should_be_whole(&self.stat) {
            let whole = client::get_version(&self.url, self.stat.etag.as_deref())?;
            self.parts.lock().unwrap_or_else(PoisonError::into_inner).insert(0, whole);
            return Ok(());
        }
        let fetched = client::get_ranges(&self.url, self.stat.etag.as_deref(), &missing)?;
        let mut parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        for (start, part) in fetched {
            if parts.get(&start).is_none_or(|old| old.len() < part.len()) {
                parts.insert(start, part);
            }
        }
        Ok(())
    }

    fn range(&self, start: u64, length: u64) -> Result<Bytes> {
        let end = start.checked_add(length).filter(|end| *end <= self.stat.size);
        let end = end.ok_or_else(|| Error::from(ErrorKind::UnexpectedEof))?;
        let mut here = self.here(start);
        if (here.len() as u64) < length {
            let wanted = start..end.max(start.saturating_add(AHEAD));
            self.fetch(std::slice::from_ref(&wanted))?;
            here = self.here(start);
        }
        let length = length as usize;
        if here.len() < length {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Ok(here.slice(..length))
    }
}

impl Source {
    /// Its bytes.
    ///
    /// # Errors
    /// The file cannot be asked.
    pub(crate) fn size(&self) -> Result<u64> {
        match self {
            Source::Local(file) => file.size(),
            Source::Remote(remote) => Ok(remote.log.stat.size),
            Source::Unpacked(bytes) => Ok(bytes.get_ref().len() as u64),
        }
    }

    /// Fetches what will be needed in few requests; of a file nothing.
    ///
    /// # Errors
    /// The store does not give it.
    pub(crate) fn prepare(&self, ranges: &[Range<u64>]) -> Result<()> {
        match self {
            Source::Local(_) | Source::Unpacked(_) => Ok(()),
            Source::Remote(remote) => remote.log.fetch(ranges),
        }
    }
}

impl Read for Remote {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.at >= self.log.stat.size || out.is_empty() {
            return Ok(0);
        }
        let mut here = self.log.here(self.at);
        if here.is_empty() {
            let end = self.at.saturating_add(BLOCK);
            self.log.fetch(std::slice::from_ref(&(self.at..end)))?;
            here = self.log.here(self.at);
        }
        let n = here.len().min(out.len());
        if n == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        here.copy_to_slice(&mut out[..n]);
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for Remote {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.log.stat.size.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = at.ok_or_else(|| Error::from(ErrorKind::InvalidInput))?;
        Ok(self.at)
    }
}

impl Read for Source {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        match self {
            Source::Local(file) => file.read(out),
            Source::Remote(remote) => remote.read(out),
            Source::Unpacked(bytes) => bytes.read(out),
        }
    }
}

impl Seek for Source {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        match self {
            Source::Local(file) => file.file.seek(to),
            Source::Remote(remote) => remote.seek(to),
            Source::Unpacked(bytes) => bytes.seek(to),
        }
    }
}

impl Length for Source {
    fn len(&self) -> u64 {
        match self {
            Source::Local(file) => file.size().unwrap_or(0),
            Source::Remote(remote) => remote.log.stat.size,
            Source::Unpacked(bytes) => bytes.get_ref().len() as u64,
        }
    }
}

/// Where the parquet decoder reads a page's header, then its bytes.
#[derive(Debug)]
pub(crate) enum Chunk {
    /// In a file.
    Local(BufReader<LocalLog>),
    /// In an object.
    Remote(Remote),
    /// In what was unpacked.
    Unpacked(<Bytes as ChunkReader>::T),
}

impl Read for Chunk {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        match self {
            Chunk::Local(file) => file.read(out),
            Chunk::Remote(remote) => remote.read(out),
            Chunk::Unpacked(bytes) => bytes.read(out),
        }
    }
}

impl ChunkReader for Source {
    type T = Chunk;

    fn get_read(&self, start: u64) -> ParquetResult<Chunk> {
        match self {
            Source::Local(file) => Ok(Chunk::Local(BufReader::new(file.from(start)?))),
            Source::Remote(remote) => {
                Ok(Chunk::Remote(Remote { log: Arc::clone(&remote.log), at: start }))
            }
            Source::Unpacked(bytes) => bytes.get_ref().get_read(start).map(Chunk::Unpacked),
        }
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        match self {
            Source::Local(file) => {
                let mut bytes = Vec::with_capacity(length);
                file.from(start)?.take(length as u64).read_to_end(&mut bytes)?;
                if bytes.len() < length {
                    let message = format!("{length} bytes at {start}, and the file ends before");
                    return Err(ParquetError::EOF(message));
                }
                Ok(bytes.into())
            }
            Source::Remote(remote) => remote
                .log
                .range(start, length as u64)
                .map_err(|e| ParquetError::External(Box::new(e))),
            Source::Unpacked(bytes) => bytes.get_ref().get_bytes(start, length),
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// A folder in place of a file: it can be opened, and every read of it is an error of the system.
    #[test]
    fn what_the_system_does_not_give_is_noted_whoever_asks() {
        let folder = tempfile::tempdir().expect("folder");
        let log = Location::from(folder.path().join("a.csv.gz"));
        let broken = || {
            let file = File::open(folder.path()).expect("a folder can be opened");
            LocalLog { file, log: log.clone() }
        };
        let is_noted = || take_fault(&log).is_some_and(|e| e.raw_os_error().is_some());
        assert!(!is_noted());
        assert!(broken().read(&mut [0; 4]).is_err() && is_noted());
        assert!(broken().read_exact_at(&mut [0; 4], 0).is_err() && is_noted());
        let source = Source::Local(broken());
        assert!(source.get_bytes(0, 4).is_err() && is_noted());
        let mut chunk = source.get_read(0).expect("opened");
        assert!(chunk.read(&mut [0; 4]).is_err() && is_noted());
        // half a packed log is none, if it is the disk that does not give the rest
        let stat = Stat { size: 1, etag: None, modified: SystemTime::UNIX_EPOCH };
        let unpacked = packed::unpacked(&log, &stat, Source::Local(broken()));
        assert!(unpacked.is_err_and(|e| e.raw_os_error().is_some()) && is_noted());
        // a log that ends is read to its end
        let whole = folder.path().join("whole");
        std::fs::write(&whole, "ab").expect("written");
        let mut whole = LocalLog::open(&log, &whole).expect("there");
        assert!(whole.read_exact(&mut [0; 4]).is_err() && !is_noted());
    }
}
