//! What goes over the pipes to a worker and back: frames of a head as JSON and a body of bytes.

use std::ffi::OsString;
use std::io::{self, Read, Write};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::batch::jobs::job_kind::JobKind;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::ingest::Identified;
use crate::store::objects::Location;
use crate::store::objects::counts::Counts;
use crate::store::tables::rows::Ident;

/// Longest head, bytes: the models of a large archive are in one.
const LONGEST_HEAD: u64 = 1 << 30;

/// Settings of all questions to a worker.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Setup {
    /// The roadbench that asks.
    pub version: String,
    /// The pipeline, resolved, as TOML.
    pub pipeline: String,
    /// Channel maps: names and texts.
    pub maps: Vec<(String, String)>,
    /// Work on each log.
    pub what: JobKind,
    /// Whether the worker needs no network.
    pub offline: bool,
}

/// A question to a worker, and the memory that it may use, bytes.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Request<Q> {
    pub memory: u64,
    pub question: Q,
}

/// Question to a worker.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Question {
    /// Identify the session of a log.
    Identify { log: Place },
    /// The files of its session.
    Run {
        log: Place,
        input_hash: String,
        pipeline_hash: String,
        bike_id: String,
        bike: String,
        signals: bool,
        /// Whether what it gives beside the files is asked for.
        result: bool,
    },
}

/// Answer of a worker, and its requests to object stores.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Response {
    pub answer: Answer,
    pub requests: Counts,
}

/// Answer of a worker.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Answer {
    /// It is ready; what it still may do beyond reading, as it tried.
    Ready { version: String, may: Vec<String> },
    /// Session, bike and start of the log.
    Identified(Identified),
    /// The files of its session, which are the body, one after the other; behind them, if it was asked for, what else it
    /// gives: so many bytes of JSON.
    Done { ident: Ident, samples: i64, files: Vec<File>, result: u64 },
    /// It cannot be used.
    Rejected { stage: Stage, code: RejectionCode, message: String },
}

/// A file of a session.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct File {
    pub folder: String,
    pub extension: String,
    pub bytes: u64,
}

impl Answer {
    /// Name of the kind of answer.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Answer::Ready { .. } => "ready",
            Answer::Identified(_) => "who",
            Answer::Done { .. } => "done",
            Answer::Rejected { .. } => "rejected",
        }
    }
}

/// A location, whatever bytes its name has.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) enum Place {
    Local(OsString),
    Remote(Location),
}

impl Place {
    pub(super) fn of(location: &Location) -> Self {
        match location.as_path() {
            Some(path) => Place::Local(path.as_os_str().to_owned()),
            None => Place::Remote(location.clone()),
        }
    }

    pub(super) fn location(self) -> Location {
        match self {
            Place::Local(path) => Location::Local(path.into()),
            Place::Remote(location) => location,
        }
    }
}

pub(super) fn send(to: &mut impl Write, head: &impl Serialize, bodies: &[&[u8]]) -> io::Result<()> {
    let head = serde_json::to_vec(head)?;
    let body: u64 = bodies.iter().map(|b| b.len() as u64).sum();
    to.write_all(&(head.len() as u64).to_le_bytes())?;
    to.write_all(&body.to_le_bytes())?;
    to.write_all(&head)?;
    for bytes in bodies {
        to.write_all(bytes)?;
    }
    to.flush()
}

/// Reads a frame whose body has at most so many bytes.
pub(super) fn receive<T: DeserializeOwned>(
    from: &mut impl Read,
    most: u64,
) -> io::Result<(T, Vec<u8>)> {
    let mut lengths = [0; 16];
    from.read_exact(&mut lengths)?;
    let length = |at: usize| {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&lengths[at..at + 8]);
        u64::from_le_bytes(bytes)
    };
    let (head, body) = (length(0), length(8));
    if head > LONGEST_HEAD || body > most {
        return Err(io::Error::other(format!("a frame of {head} and {body} bytes")));
    }
    let mut exactly = |length: u64| {
        let mut bytes = Vec::new();
        match from.by_ref().take(length).read_to_end(&mut bytes)? as u64 == length {
            true => Ok(bytes),
            false => Err(io::Error::from(io::ErrorKind::UnexpectedEof)),
        }
    };
    let (head, body) = (exactly(head)?, exactly(body)?);
    Ok((serde_json::from_slice(&head)?, body))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_as_they_were_and_claims_are_not_believed() {
        let mut pipe = Vec::new();
        send(&mut pipe, &("head", 1.5), &[b"one", b"", b"two"]).expect("written");
        let (head, body): ((String, f64), _) = receive(&mut pipe.as_slice(), 6).expect("read");
        assert_eq!((head.0.as_str(), head.1, &*body), ("head", 1.5, &b"onetwo"[..]));
        let fails = |bytes: &[u8], most| receive::<(String, f64)>(&mut &*bytes, most).is_err();
        assert!(fails(&pipe, 5));
        assert!(fails(&pipe[..pipe.len() - 1], 6));
        pipe[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(fails(&pipe, 6));
        pipe[..8].copy_from_slice(&(1_u64 << 30).to_le_bytes());
        assert!(fails(&pipe, 6)); // nor is room made for it
    }
}
