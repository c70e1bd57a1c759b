//! The batch itself: a session per worker, results to the store as they come.

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::threads;
use super::watch::{Finished, State, Watch};
use crate::batch::discover::{DiscoveredLog, inputs};
use crate::batch::error::Error;
use crate::batch::jobs::session;
use crate::batch::jobs::session::Ended;
use crate::batch::jobs::work::Work;
use crate::batch::log_hash::hash_file;
use crate::batch::plan;
use crate::batch::plan::{Job, Plan, Refused};
use crate::batch::settings::Settings;
use crate::batch::store::contents::{Contents, Stale};
use crate::batch::store::folder::Store;
use crate::batch::store::marker::{Committed, Key};
use crate::batch::store::{finish_derived, superseded};
use crate::pipeline::Rejection;
use crate::store::objects::Location;
use crate::store::tables::rows::Rejected;

/// Outcomes of a batch's inputs, counted.
#[derive(Debug, Default)]
pub struct Accounts {
    /// Number of inputs.
    pub inputs: usize,
    /// Sessions that were computed or up to date.
    pub sessions: BTreeSet<Key>,
    /// Number of sessions that were computed and written.
    pub done: usize,
    /// Number of sessions that were up to date.
    pub unchanged: usize,
    /// Rejected inputs, in order of path.
    pub rejected: Vec<Rejected>,
    /// Number of inputs that were not begun because the batch was stopped.
    pub left: usize,
    /// Size of all logs, bytes.
    pub bytes: u64,
    /// Message if some sessions are not in the tables yet: the damaged table, and what to do.
    pub damage: Option<String>,
}

impl Accounts {
    /// Checks that every input is counted exactly once.
    fn check(&self, is_stopped: bool) -> Result<(), Error> {
        let all = self.sessions.len() + self.rejected.len() + self.left;
        if all == self.inputs && (self.left == 0 || is_stopped) {
            return Ok(());
        }
        Err(Error::Internal(format!(
            "{} inputs but {} sessions, {} rejected and {} left",
            self.inputs,
            self.sessions.len(),
            self.rejected.len(),
            self.left
        )))
    }
}

/// [`run_if`] without a check of the inputs.
///
/// # Errors
/// As [`run_if`].
pub fn run<W: Work>(
    settings: &Settings<'_>,
    work: &W,
    watch: &impl Watch<W::Result>,
    stop: &AtomicBool,
) -> Result<(Accounts, Store), Error> {
    run_if(settings, work, watch, stop, |_, _| Ok(()))
}

/// Runs the batch, if `check` lets it with these logs and this folder of bike files. `stop` ends it early: sessions
/// under way are finished, no other is begun.
///
/// Gives back the output too, still locked: no other batch writes there until it is dropped. A
/// single log is always computed, so that its results can be shown.
///
/// # Errors
/// Before anything is written: bad usage. Later: the output cannot be written.
pub(crate) fn run_if<W: Work>(
    settings: &Settings<'_>,
    work: &W,
    watch: &impl Watch<W::Result>,
    stop: &AtomicBool,
    check: impl FnOnce(&[DiscoveredLog], &Location) -> Result<(), Error>,
) -> Result<(Accounts, Store), Error> {
    let (found, bikes) = inputs(settings)?;
    check(&found, &bikes)?;
    let inputs = found.len();
    let pool = threads::pool(threads::taken(settings.jobs).min(inputs));
    let before = Contents::read(work.kind(), settings.out)?;
    let before = within(&pool, || before.with_damage());
    let plan = within(&pool, || plan::plan(found, &bikes, &before, settings, work))?;
    let bytes = plan.bytes();
    let store = Store::open_again(&before)?;
    finish_derived::after_kill(settings.out)?;
    let logs = names(&plan);
    watch.planned(&logs, bytes);
    let logs: BTreeSet<String> = logs.into_iter().collect();
    let n_logs = plan.logs().count();
    let Plan { mut jobs, refused } = plan;
    store.expect(jobs.iter().flat_map(|job| std::iter::once(job).chain(&job.rivals)));
    let mut accounts = Accounts { inputs, bytes, ..Accounts::default() };
    refuse(&store, refused, &mut accounts, watch, stop)?;

    // The largest log first, so that no worker is left with it at the end. Workers take the next
    // job themselves instead of being rayon tasks: a worker that waits for parallel work inside
    // a session can then never begin a second session on top of it.
    jobs.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.location.cmp(&b.location)));
    let shared = Shared {
        settings: Settings { force: settings.force || inputs == 1, ..*settings },
        store: &store,
        jobs: &jobs,
        next: AtomicUsize::new(0),
        halt: AtomicBool::new(false),
        stop,
        tally: Mutex::default(),
    };
    work.planned(inputs);
    match &pool {
        Some(pool) => _ = pool.broadcast(|_| shared.worker(work, watch)),
        None => shared.worker(work, watch),
    }
    work.all_done();
    let tally = shared.tally.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut accounts = tally.close(accounts, n_logs)?;
    accounts.check(stop.load(Ordering::Relaxed))?;
    within(&pool, || store.merge())?;
    accounts.damage = within(&pool, || damage(&store));
    // with `--since` older logs exist although they are not among the inputs
    if settings.since.is_none() {
        store.remove_rejections_of_gone(settings.inputs, &logs)?;
    }
    Ok((accounts, store))
}

/// Message if the tables are incomplete: sessions that could not be merged, or damage that no log of this batch repairs.
pub(crate) fn damage(store: &Store) -> Option<String> {
    if let Some(e) = store.take_error() {
        return Some(e.to_string());
    }
    let left = store.found().still_damaged();
    let first = left.first()?;
    let more =
        if left.len() == 1 { String::new() } else { format!(" and {} more", left.len() - 1) };
    let out = store.root();
    Some(format!(
        "{out}: {first}{more} missing or damaged, with sessions whose logs are not among the \
         inputs; run over all logs, restore the files from a backup, or see `roadbench verify \
         {out}`"
    ))
}

/// Runs a closure in a pool, or in this thread if there is none.
fn within<T: Send>(pool: &Option<rayon::ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// The logs in order of path.
fn names(plan: &Plan) -> Vec<String> {
    let jobs = plan.logs().map(|j| j.log.clone());
    let mut names: Vec<String> =
        jobs.chain(plan.refused.iter().map(|r| r.row.path.clone())).collect();
    names.sort_by(|a, b| std::path::Path::new(a).cmp(std::path::Path::new(b)));
    names
}

/// Writes the rows of what is refused unread.
fn refuse<R>(
    store: &Store,
    refused: Vec<Refused>,
    accounts: &mut Accounts,
    watch: &impl Watch<R>,
    stop: &AtomicBool,
) -> Result<(), Error> {
    for refused in refused {
        if stop.load(Ordering::Relaxed) {
            accounts.left += 1;
            continue;
        }
        session::reject(store, &refused.row, None)?;
        let finished = Finished { bytes: refused.bytes, ..Finished::rejected(&refused.row) };
        watch.finished(&finished, None);
        accounts.rejected.push(refused.row);
    }
    Ok(())
}

/// Plan of a batch for one input, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Intended {
    /// Path or URL of the log, as in the tables.
    pub log: String,
    /// The session, if known.
    pub session_id: Option<String>,
    /// Expected outcome; [`State::Rejected`] if it is refused before it is read.
    pub state: State,
    /// Why, in words; empty where nothing would be done.
    pub why: String,
}

/// Plan of [`run`], in order of path. Writes nothing and needs no lock.
///
/// # Errors
/// As [`run`] before it writes.
pub fn dry_run(settings: &Settings<'_>, work: &impl Work) -> Result<Vec<Intended>, Error> {
    let (found, bikes) = inputs(settings)?;
    let force = settings.force || found.len() == 1; // as `run` does
    let there = Contents::read(work.kind(), settings.out)?.with_damage();
    let Plan { jobs, refused } = plan::plan(found, &bikes, &there, settings, work)?;
    // the start of a rejected log is unknown
    let refused = refused.into_iter().map(|r| {
        let gone = superseded::with_rejected(&r.row, &there, |_| false);
        Intended {
            why: r.row.message.clone() + &removal_text(gone),
            log: r.row.path,
            session_id: r.row.session_id,
            state: State::Rejected,
        }
    });
    let logs: Vec<(&Job, Option<&Job>)> = jobs
        .iter()
        .flat_map(|job| job.rivals.iter().map(move |r| (r, Some(job))).chain([(job, None)]))
        .collect();
    let hashed: Vec<std::io::Result<String>> = logs
        .par_iter()
        .map(|(job, _)| job.hash.clone().map_or_else(|| hash_file(&job.location), Ok))
        .collect();
    let bytes: BTreeSet<&String> = hashed.iter().flatten().collect();
    let sessions: BTreeSet<Key> = logs.iter().map(|(job, _)| job.key()).collect();
    let intended = |((job, first), hash): (&(&Job, Option<&Job>), &std::io::Result<String>)| {
        let refused = |why: Rejection| (State::Rejected, why.message);
        let is_archived = |there: &Committed, hash: &str| {
            there.input_hash != hash
                && there.is_other_ride(job.start)
                && !bytes.contains(&there.input_hash)
        };
        let archived = |hash: &str| there.of(&job.key()).iter().find(|row| is_archived(row, hash));
        // sessions of the log's earlier content that no other log gives
        let was_before = |made: &Committed| {
            let others = superseded::by(made, &there, |row| is_archived(row, &made.input_hash));
            others.into_iter().filter(|key| !sessions.contains(key)).collect::<Vec<Key>>()
        };
        let (state, why) = match (hash, first) {
            (Err(e), _) => (State::Rejected, format!("cannot read {}: {e}", job.log)),
            (Ok(_), Some(first)) => refused(plan::same_session(&job.key(), &first.log)),
            (Ok(hash), None) => {
                match (archived(hash), there.copied_from(&job.wanted(hash.clone()))) {
                    (Some(archived), _) => refused(plan::archived(archived, job.start)),
                    (None, Some(_)) => (
                        State::Rejected,
                        "the output has a session from a log with the same bytes".to_owned(),
                    ),
                    (None, None) => {
                        let wanted = job.wanted(hash.clone());
                        let stale = there.stale(&wanted, |table| work.is_requested(table));
                        match stale.or(force.then_some(Stale::Forced)) {
                            Some(stale) => {
                                let gone = removal_text(was_before(&wanted));
                                (State::Done, stale.words().to_owned() + &gone)
                            }
                            None => (State::Unchanged, String::new()),
                        }
                    }
                }
            }
        };
        let session_id = Some(job.meta.session_id.clone());
        Intended { log: job.log.clone(), session_id, state, why }
    };
    let jobs: Vec<Intended> = logs.par_iter().zip(&hashed).map(intended).collect();
    let mut all: Vec<Intended> = refused.chain(jobs).collect();
    all.sort_by(|a, b| a.log.cmp(&b.log));
    Ok(all)
}

/// Text of a dry run for sessions that would be removed; empty if there are none.
fn removal_text(sessions: impl IntoIterator<Item = Key>) -> String {
    let words = |Key { bike_id, session_id }: Key| {
        format!("; removes session `{session_id}` of {bike_id}, which was made from this log")
    };
    sessions.into_iter().map(words).collect()
}

/// State that the workers share.
struct Shared<'a> {
    settings: Settings<'a>,
    store: &'a Store,
    jobs: &'a [Job],
    next: AtomicUsize,
    halt: AtomicBool,
    stop: &'a AtomicBool,
    tally: Mutex<Tally>,
}

#[derive(Default)]
struct Tally {
    sessions: BTreeSet<Key>,
    done: usize,
    unchanged: usize,
    rejected: Vec<Rejected>,
    error: Option<Error>,
}

impl Tally {
    /// Adds what the workers did of so many jobs.
    fn close(self, mut accounts: Accounts, jobs: usize) -> Result<Accounts, Error> {
        if let Some(error) = self.error {
            return Err(Error::Output(error.to_string()));
        }
        accounts.left += jobs - self.done - self.unchanged - self.rejected.len();
        accounts.sessions = self.sessions;
        accounts.done = self.done;
        accounts.unchanged = self.unchanged;
        accounts.rejected.extend(self.rejected);
        accounts.rejected.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(accounts)
    }
}

impl Shared<'_> {
    fn worker<W: Work>(&self, work: &W, watch: &impl Watch<W::Result>) {
        while !self.halt.load(Ordering::Relaxed) && !self.stop.load(Ordering::Relaxed) {
            let Some(job) = self.jobs.get(self.next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            if let Err(error) = self.session(job, work, watch) {
                self.halt.store(true, Ordering::Relaxed);
                self.tally().error.get_or_insert(error);
                return;
            }
        }
    }

    /// Computes a session from its log. If that is rejected, the other logs with its session id are tried in turn.
    fn session<W: Work>(
        &self,
        job: &Job,
        work: &W,
        watch: &impl Watch<W::Result>,
    ) -> Result<(), Error> {
        let mut holder: Option<&Job> = None;
        for one in std::iter::once(job).chain(&job.rivals) {
            if self.stop.load(Ordering::Relaxed) && !std::ptr::eq(one, job) {
                return Ok(()); // the rest is left
            }
            let start = Instant::now();
            let ended = match holder {
                Some(holder) => {
                    Ended::Rejected(session::reject_rival(one, self.store, &holder.log)?)
                }
                None => session::run(one, &self.settings, self.store, work)?,
            };
            let gave_rows = match &ended {
                Ended::Done { .. } | Ended::Unchanged => true,
                Ended::Rejected(row) => self.store.keeps(row, one.start),
            };
            if gave_rows {
                holder.get_or_insert(one);
            }
            self.count(one, ended, start.elapsed().as_secs_f64(), watch);
        }
        Ok(())
    }

    /// Counts what became of a log.
    fn count<R>(&self, job: &Job, ended: Ended<R>, seconds: f64, watch: &impl Watch<R>) {
        let mut tally = self.tally();
        let finished = Finished {
            log: &job.log,
            session_id: Some(&job.meta.session_id),
            state: State::Done,
            why: None,
            seconds,
            samples: 0,
            bytes: job.bytes,
        };
        match ended {
            Ended::Unchanged => {
                tally.sessions.insert(job.key());
                tally.unchanged += 1;
                watch.finished(&Finished { state: State::Unchanged, ..finished }, None);
            }
            Ended::Rejected(row) => {
                let refused = Finished::rejected(&row);
                watch.finished(&Finished { seconds, bytes: job.bytes, ..refused }, None);
                tally.rejected.push(row);
            }
            Ended::Done { samples, result, .. } => {
                tally.sessions.insert(job.key());
                tally.done += 1;
                watch.finished(&Finished { samples, ..finished }, result);
            }
        }
    }

    fn tally(&self) -> std::sync::MutexGuard<'_, Tally> {
        self.tally.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
