//! What is at a path that a user names, and how bytes get there.

use std::fs::Metadata;
use std::io::{Error, ErrorKind, Result, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::store::objects::Location;
use crate::store::objects::replace::{folder_of, same_file};
use crate::store::tables::{file, registry};

/// So long a pipe is waited for that nobody reads: who starts the reader a moment later is served, and a night does not hang.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often a pipe that is not read is tried.
const PAUSE: Duration = Duration::from_millis(10);
/// Links that lead to one another before they count as a circle, as of Linux.
const MOST_LINKS: usize = 40;
/// Where bytes for a path go.
#[derive(Debug)]
pub(super) enum Target {
    /// To a file, or to where one will be, links followed; what there is of it.
    File(PathBuf, Option<Metadata>),
    /// To what takes bytes one after the other: a device or a pipe.
    Stream,
    /// To this process's own stdout or stderr.
    Printed(Printed),
}

/// One of the two.
#[derive(Debug, Clone, Copy)]
pub(super) enum Printed {
    Out,
    Err,
}

/// In words, with its article.
pub(super) fn what_is(there: &Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = there.file_type();
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if there.is_dir() { "a folder" } else { "a file" }
}

/// Target of the bytes for a path.
pub(super) fn target(path: &Path) -> Result<Target> {
    let wrong = |what: &str| Error::new(ErrorKind::InvalidInput, what.to_owned());
    let there = match std::fs::metadata(path) {
        Ok(there) => Some(there),
        Err(e) if e.kind() == ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    if let Some(printed) = there.as_ref().and_then(printed) {
        return Ok(Target::Printed(printed));
    }
    match there {
        Some(there) if there.is_dir() => Err(wrong("is a folder; a file is needed")),
        Some(there) if !there.is_file() => match what_is(&there) {
            "a socket" => Err(wrong("is a socket; a file is needed")),
            _ => Ok(Target::Stream),
        },
        there => {
            let place = followed(path)?;
            // the name that the system shows of an open file may be no name any more
            let found = std::fs::metadata(&place).ok();
            if there.as_ref().is_some_and(|t| !found.is_some_and(|f| same_file(t, &f))) {
                return Err(wrong("leads to a file without a name; give a file"));
            }
            Ok(Target::File(place, there))
        }
    }
}

/// A path with all links of its last part resolved, whether a file is there or not.
fn followed(path: &Path) -> Result<PathBuf> {
    let mut place = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::symlink_metadata(&place) {
            Ok(there) if there.is_symlink() => {
                place = folder_of(&place).join(std::fs::read_link(&place)?);
            }
            _ => return Ok(place),
        }
    }
    Err(Error::new(ErrorKind::InvalidInput, "is a link that leads in a circle; a file is needed"))
}

/// Whether it is what this process prints to: a file that was opened for that is not replaced under it.
#[cfg(unix)]
fn printed(there: &Metadata) -> Option<Printed> {
    use std::os::fd::AsFd;
    let (out, err) = (std::io::stdout(), std::io::stderr());
    let is = |fd: std::os::fd::BorrowedFd<'_>| {
        let own = fd.try_clone_to_owned().and_then(|fd| std::fs::File::from(fd).metadata());
        own.is_ok_and(|own| same_file(&own, there))
    };
    if is(out.as_fd()) {
        return Some(Printed::Out);
    }
    is(err.as_fd()).then_some(Printed::Err)
}

#[cfg(not(unix))]
fn printed(_: &Metadata) -> Option<Printed> {
    None
}

/// Writes a file to the path the user gave, by the rule of [`tables::output`](crate::store::tables::output).
///
/// # Errors
/// It cannot be written.
pub(crate) fn write(to: impl Into<Location>, bytes: &[u8]) -> std::result::Result<(), file::Error> {
    let to = to.into();
    let Location::Local(path) = &to else { return file::write_bytes(to, bytes) };
    let written = match target(path) {
        Err(e) => Err(e),
        Ok(Target::File(place, _)) => Location::Local(place).write(bytes),
        Ok(Target::Printed(Printed::Out)) => all(&mut std::io::stdout().lock(), bytes),
        Ok(Target::Printed(Printed::Err)) => all(&mut std::io::stderr().lock(), bytes),
        Ok(Target::Stream) => open_stream(path).and_then(|mut stream| all(&mut stream, bytes)),
    };
    written.map_err(|source| file::Error::Io { path: to, source })
}

/// Writes rows as one Parquet file of their table, by the same rule.
///
/// # Errors
/// As [`write()`], or a row does not fit its schema.
pub(crate) fn write_rows<R: registry::Row>(
    to: impl Into<Location>,
    rows: &[R],
) -> std::result::Result<(), file::Error> {
    write(to, &file::to_bytes(rows)?)
}

/// All bytes, however few the other end takes at a time; one that has seen enough is no error.
fn all(stream: &mut impl Write, bytes: &[u8]) -> Result<()> {
    let mut rest = bytes;
    while !rest.is_empty() {
        match stream.write(rest) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(n) => rest = &rest[n..],
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) if e.kind() == ErrorKind::WouldBlock => std::thread::sleep(PAUSE),
            Err(e) if e.kind() == ErrorKind::BrokenPipe => return Ok(()),
            Err(e) => return Err(e),
        }
    }
    match stream.flush() {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        done => done,
    }
}

/// Opens a device or a pipe; waits a little for who reads a pipe.
fn open_stream(path: &Path) -> Result<std::fs::File> {
    let mut options = std::fs::File::options();
    options.write(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY);
    }
    let start = Instant::now();
    loop {
        match options.open(path) {
            Err(e) if is_unread(&e) => {
                if start.elapsed() > PATIENCE {
                    let what = "no program reads this pipe; start its reader first";
                    return Err(Error::new(ErrorKind::BrokenPipe, what));
                }
                std::thread::sleep(PAUSE);
            }
            opened => return opened,
        }
    }
}

/// Whether a pipe has no reader (yet).
fn is_unread(e: &Error) -> bool {
    #[cfg(unix)]
    return e.raw_os_error() == Some(libc::ENXIO);
    #[cfg(not(unix))]
    return false;
}
