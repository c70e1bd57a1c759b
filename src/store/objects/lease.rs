//! A run's lock on a prefix of an object store.
//!
//! There is no lock that dies with its process, so it is an object with an end: made only where
//! there is none (a conditional put), written anew long before its end, and removed by the run
//! that made it. One that a killed run has left is taken over after its end. The machines' clocks
//! have to agree to within a part of `TERM`.

use std::io::{ErrorKind, Result};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use serde::{Deserialize, Serialize};

use super::client;
use super::url::Url;

/// How long a lock lasts that nobody renews, s; `ROADBENCH_LOCK_SECONDS` sets another.
const TERM: u64 = 120;

/// How often a lock that changes under our hands is looked at again.
const TRIES: usize = 5;

/// Contents of the lock object.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Held {
    /// Machine, process and a number drawn for the run.
    owner: String,
    until: Timestamp,
}

/// Why there is no lock.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// Another run has it: who, until when.
    Taken(String, Timestamp),
    /// The store has no conditional puts.
    Unknown,
    /// The store does not answer, or does not let us.
    Failed(std::io::Error),
}

impl From<std::io::Error> for Refusal {
    fn from(e: std::io::Error) -> Self {
        match e.kind() {
            ErrorKind::Unsupported => Refusal::Unknown,
            _ => Refusal::Failed(e),
        }
    }
}

/// A lock, held and renewed until it is dropped.
#[derive(Debug)]
pub(crate) struct Lease {
    url: Url,
    lost: Arc<AtomicBool>,
    renewal: Option<(Sender<()>, JoinHandle<()>)>,
}

struct Renewal {
    url: Url,
    held: Held,
    etag: Option<String>,
    term: Duration,
}

impl Lease {
    /// Takes the lock that is that object.
    ///
    /// # Errors
    /// See [`Refusal`].
    pub(crate) fn take(url: &Url) -> std::result::Result<Lease, Refusal> {
        let seconds = std::env::var("ROADBENCH_LOCK_SECONDS").ok().and_then(|s| s.parse().ok());
        let term = Duration::from_secs(seconds.unwrap_or(TERM).clamp(2, 3600));
        let owner = format!("{}, process {}, {:08x}", host(), std::process::id(), number());
        let mut last = None;
        for _ in 0..TRIES {
            let held = Held { owner: owner.clone(), until: end(term) };
            match client::put_if(url, &encoded(&held), None) {
                Ok(etag) => return Lease::renewed(url, held, etag, term),
                Err(e) if e.kind() != ErrorKind::AlreadyExists => return Err(e.into()),
                Err(_) => {}
            }
            let Some((there, etag)) = look(url)? else { continue };
            if there.owner == owner {
                return Lease::renewed(url, there, etag, term); // its answer was lost
            }
            if there.until > Timestamp::now() {
                return Err(Refusal::Taken(there.owner, there.until));
            }
            tracing::warn!("{url}: taking over the lock of {}, which ended", there.owner);
            match client::put_if(url, &encoded(&held), etag.as_deref()) {
                Ok(etag) => return Lease::renewed(url, held, etag, term),
                Err(e) if e.kind() != ErrorKind::AlreadyExists => return Err(e.into()),
                Err(e) => last = Some(e), // another was quicker, or its answer was lost
            }
        }
        let e = last.unwrap_or_else(|| std::io::Error::other(format!("{url} keeps changing")));
        Err(Refusal::Failed(e))
    }

    fn renewed(
        url: &Url,
        held: Held,
        etag: Option<String>,
        term: Duration,
    ) -> std::result::Result<Lease, Refusal> {
        let lost = Arc::new(AtomicBool::new(false));
        let (stop, stopped) = channel();
        let flag = Arc::clone(&lost);
        let mut renewal = Renewal { url: url.clone(), held, etag, term };
        let renewing = move || {
            while stopped.recv_timeout(term / 4) == Err(RecvTimeoutError::Timeout) {
                if let Err(e) = renewal.renew() {
                    tracing::error!("{}: the lock is lost: {e}", renewal.url);
                    flag.store(true, Ordering::Relaxed);
                    return;
                }
            }
        };
        match std::thread::Builder::new().spawn(renewing) {
            Ok(thread) => Ok(Lease { url: url.clone(), lost, renewal: Some((stop, thread)) }),
            // a lock that ends under a run is none
            Err(e) => {
                let _ = client::delete(url);
                let message = format!("no thread can be started that renews the lock: {e}");
                Err(Refusal::Failed(std::io::Error::new(e.kind(), message)))
            }
        }
    }

    /// Whether it is still ours.
    ///
    /// # Errors
    /// It could not be renewed in time, and another run may be writing.
    pub(crate) fn check(&self) -> Result<()> {
        if self.lost.load(Ordering::Relaxed) {
            let message = "the lock on the output could not be renewed in time; run again";
            return Err(std::io::Error::other(message));
        }
        Ok(())
    }
}

impl Renewal {
    /// Moves the end. What fails is tried again at the next turn, unless the end has come.
    fn renew(&mut self) -> Result<()> {
        let held = Held { until: end(self.term), ..self.held.clone() };
        let renewed = client::put_if(&self.url, &encoded(&held), self.etag.as_deref());
        let failed = match renewed {
            Ok(etag) => {
                (self.held, self.etag) = (held, etag);
                return Ok(());
            }
            Err(e) => e,
        };
        if failed.kind() == ErrorKind::AlreadyExists {
            match look(&self.url) {
                Ok(Some((there, etag))) if there.owner == self.held.owner => {
                    (self.held, self.etag) = (there, etag); // the answer was lost
                    return Ok(());
                }
                Ok(_) => return Err(failed),
                Err(_) => {}
            }
        }
        match self.held.until > Timestamp::now() {
            true => Ok(()),
            false => Err(failed),
        }
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.renewal.take() {
            drop(stop);
            let _ = thread.join(); // it does not panic
        }
        if !self.lost.load(Ordering::Relaxed)
            && let Err(e) = client::delete(&self.url)
        {
            tracing::warn!("{}: the lock could not be removed and ends by itself: {e}", self.url);
        }
    }
}

/// Content, and its etag; `None` if it went or changed meanwhile, or is not readable.
fn look(url: &Url) -> Result<Option<(Held, Option<String>)>> {
    let seen = client::stat(url).and_then(|stat| {
        let range = 0..stat.size;
        let parts = client::get_ranges(url, stat.etag.as_deref(), std::slice::from_ref(&range))?;
        Ok((parts.into_iter().next().map(|(_, bytes)| bytes), stat))
    });
    match seen {
        Ok((bytes, stat)) => {
            let nobody = || Held { owner: "somebody".to_owned(), until: Timestamp::UNIX_EPOCH };
            let held = bytes.and_then(|b| serde_json::from_slice(&b).ok());
            Ok(Some((held.unwrap_or_else(nobody), stat.etag)))
        }
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::AlreadyExists) => Ok(None),
        Err(e) => Err(e),
    }
}

fn end(term: Duration) -> Timestamp {
    let term = SignedDuration::try_from(term).unwrap_or(SignedDuration::from_mins(2));
    Timestamp::now() + term
}

fn encoded(held: &Held) -> Vec<u8> {
    serde_json::to_vec(held).unwrap_or_default()
}

fn host() -> String {
    let file = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = file.or_else(|| std::env::var("HOSTNAME").ok()).unwrap_or_default();
    let name = name.trim();
    if name.is_empty() { "some machine".to_owned() } else { name.to_owned() }
}

/// Another one for every run of a process.
fn number() -> u32 {
    static LAST: Mutex<u32> = Mutex::new(0);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    *last = last.wrapping_add(1);
    let now = Timestamp::now().subsec_nanosecond().unsigned_abs();
    now.rotate_left(8) ^ *last
}
