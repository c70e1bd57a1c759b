//! The workers of a batch: as many as are asked for, or as the machine gives.

use std::ffi::OsString;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::child::{Child, Ended};
use super::limits::Limits;
use super::wire::{Answer, Question, Setup};

/// Waits before a first worker is tried for again.
const PAUSES: [Duration; 3] =
    [Duration::from_millis(200), Duration::from_secs(1), Duration::from_secs(3)];

/// Workers, started as they are needed.
#[derive(Debug)]
pub(super) struct Pool {
    /// Command of a worker: the program and its arguments.
    program: Vec<OsString>,
    setup: Setup,
    workers: Mutex<Workers>,
    /// Somebody may go on.
    changed: Condvar,
}

#[derive(Debug)]
struct Workers {
    idle: Vec<Child>,
    /// Idle, at work or about to be started.
    there: usize,
    /// No more are started than this.
    most: usize,
    /// There was none, and waiting did not help.
    is_in_vain: bool,
}

impl Pool {
    /// With a first worker.
    ///
    /// # Errors
    /// It cannot be started; in words.
    pub(super) fn new(program: Vec<OsString>, setup: Setup, most: usize) -> Result<Self, String> {
        let first = Child::start(&program, &setup)?;
        tracing::debug!("workers may, beyond reading: {:?}", first.may);
        let workers = Workers { idle: vec![first], there: 1, most: most.max(1), is_in_vain: false };
        Ok(Pool { program, setup, workers: Mutex::new(workers), changed: Condvar::new() })
    }

    /// Settings of the workers.
    pub(super) fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Ends those that are idle.
    pub(super) fn clear(&self) {
        let mut workers = self.lock();
        workers.there -= workers.idle.len();
        workers.idle.clear();
    }

    /// Asks a worker. One that served before and fails may have failed by what it served, and one that was killed by who killed
    /// it: then another one is asked, for the latter once.
    ///
    /// # Errors
    /// It ended over it, or there is none.
    pub(super) fn ask(
        &self,
        question: &Question,
        limits: &Limits,
    ) -> Result<(Answer, Vec<u8>), Ended> {
        let mut killed = 0;
        loop {
            let mut child = self.take()?;
            let is_fresh = child.is_fresh();
            match child.ask(question, limits) {
                Ok(answer) => {
                    self.lock().idle.push(child);
                    self.changed.notify_one();
                    return Ok(answer);
                }
                Err(ended) => {
                    drop(child);
                    self.is_gone();
                    match ended {
                        Ended::Killed(_) if killed == 0 => killed += 1,
                        Ended::Killed(_) => return Err(ended),
                        _ if !is_fresh => {} // never more often than there are workers
                        ended => return Err(ended),
                    }
                }
            }
        }
    }

    /// An idle worker, or a new one. Where none can be started, one of the others is waited for, and no more are tried for.
    fn take(&self) -> Result<Child, Ended> {
        let mut pauses = PAUSES.iter();
        let mut workers = self.lock();
        loop {
            if let Some(child) = workers.idle.pop() {
                return Ok(child);
            }
            if workers.there >= workers.most {
                workers = self.changed.wait(workers).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            workers.there += 1;
            drop(workers);
            let why = match Child::start(&self.program, &self.setup) {
                Ok(child) => {
                    self.lock().is_in_vain = false;
                    return Ok(child);
                }
                Err(why) => why,
            };
            workers = self.lock();
            workers.there -= 1;
            if workers.there > 0 {
                if workers.there < workers.most {
                    workers.most = workers.there;
                    tracing::warn!(
                        "no more than {} worker processes can be started ({why}): logs wait for one of them",
                        workers.most
                    );
                }
                continue;
            }
            self.changed.notify_all(); // those that wait for one of the others wait for nobody
            let pause = pauses.next().filter(|_| !workers.is_in_vain);
            workers.is_in_vain |= pause.is_none();
            drop(workers);
            match pause {
                Some(pause) => std::thread::sleep(*pause),
                None => return Err(Ended::NotStarted(why)),
            }
            workers = self.lock();
        }
    }

    fn is_gone(&self) {
        self.lock().there -= 1;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Workers> {
        self.workers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
