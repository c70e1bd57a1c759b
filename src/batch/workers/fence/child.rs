//! A worker, as the process sees it that asks.

use std::ffi::OsString;
use std::io::{self, BufReader, Read};
use std::process::{ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::limits::{self, Limits};
use super::wire::{self, Answer, Question, Response, Setup};
use crate::store::objects::counts;

/// How often a worker's processor time is looked at.
const LOOK: Duration = Duration::from_millis(200);
/// How long a worker may take to get ready.
const START: Duration = Duration::from_secs(60);
/// How long a worker that has closed its output may take to end.
const END: Duration = Duration::from_secs(10);
/// A worker that waits (for a disk, a store, a loaded machine) is given so many times its processor time.
const PATIENCE: f64 = 10.0;
/// Part of a worker's last output that is kept, bytes.
const LAST_WORDS: usize = 4096;
/// Largest answer, bytes.
const LARGEST: u64 = 8 << 30;

/// Why a worker is no more.
#[derive(Debug)]
pub(super) enum Ended {
    /// It went beyond its memory.
    Memory,
    /// It had no more memory before it had what it may.
    NoMemory,
    /// It went beyond its time.
    Time,
    /// By itself, in words.
    Crash(String),
    /// By a signal that is no crash's and that nobody here sent, in words.
    Killed(String),
    /// It never began; in words.
    NotStarted(String),
}

/// A worker; ended when dropped.
#[derive(Debug)]
pub(super) struct Child {
    process: std::process::Child,
    /// `None` once the worker knows that no more questions come.
    to: Option<ChildStdin>,
    answers: Receiver<io::Result<(Answer, Vec<u8>)>>,
    /// Gives back its last words.
    words: Option<JoinHandle<String>>,
    asked: usize,
    /// Rights beyond reading.
    pub may: Vec<String>,
}

impl Child {
    /// Starts a worker and waits until it is ready.
    ///
    /// # Errors
    /// In words: it cannot be started, or is of another roadbench.
    pub(super) fn start(program: &[OsString], setup: &Setup) -> Result<Self, String> {
        let [name, arguments @ ..] = program else { return Err("no program".to_owned()) };
        let mut command = Command::new(name);
        command.args(arguments);
        command.env("RUST_BACKTRACE", "0"); // its last words are short
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Ctrl-C is for the batch: sessions under way are finished
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process = command.spawn().map_err(|e| e.to_string())?;
        let (to, from) = (process.stdin.take(), process.stdout.take());
        let stderr = process.stderr.take();
        let (sender, answers) = channel();
        // ended when it is dropped: also where there is no thread to listen to it
        let mut child = Child { process, to, answers, words: None, asked: 0, may: Vec::new() };
        let thread = || std::thread::Builder::new().name("worker".to_owned());
        if let Some(stderr) = stderr {
            let words = thread().spawn(|| last_words(stderr));
            child.words = Some(words.map_err(|e| e.to_string())?);
        }
        if let Some(from) = from {
            thread().spawn(move || listen(from, &sender)).map_err(|e| e.to_string())?;
        }
        if let Err(e) = child.send(setup) {
            // it says better why it is no more
            let word = child.last_word();
            return Err(if word.is_empty() { e.to_string() } else { word });
        }
        match child.answers.recv_timeout(START) {
            Ok(Ok((Answer::Ready { version, may }, _))) if version == crate::VERSION => {
                child.may = may;
                Ok(child)
            }
            Ok(Ok(_)) => Err("it is another version of roadbench".to_owned()),
            _ => Err(format!("it did not get ready ({})", child.last_word())),
        }
    }

    /// Whether it has served nothing yet.
    pub(super) fn is_fresh(&self) -> bool {
        self.asked == 0
    }

    /// An answer. After an error the worker is no more.
    ///
    /// # Errors
    /// It crashed, or was ended at a limit.
    pub(super) fn ask(
        &mut self,
        question: &Question,
        limits: &Limits,
    ) -> Result<(Answer, Vec<u8>), Ended> {
        self.asked += 1;
        let (start, used) = (Instant::now(), self.processor_time());
        let sent = self.send(&wire::Request { memory: limits.bytes(), question });
        loop {
            match self.answers.recv_timeout(LOOK) {
                Ok(Ok(answer)) => return Ok(answer),
                Ok(Err(e)) if e.kind() != io::ErrorKind::UnexpectedEof => {
                    return Err(Ended::Crash(format!("its answer cannot be read: {e}")));
                }
                Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {
                    let waited = start.elapsed().as_secs_f64();
                    let busy = match (self.processor_time(), used) {
                        (Some(now), Some(before)) => now - before,
                        _ => waited,
                    };
                    if busy > limits.seconds() || waited > PATIENCE * limits.seconds() {
                        let _ = self.process.kill();
                        let _ = self.process.wait();
                        return Err(Ended::Time);
                    }
                }
            }
        }
        let is_over = self.await_end();
        let words = self.last_word();
        Err(match self.process.wait() {
            _ if words.contains("memory allocation of") => {
                if limits::is_less_allowed(limits.bytes()) {
                    Ended::NoMemory
                } else {
                    Ended::Memory
                }
            }
            Ok(_) if !is_over => Ended::Crash(format!("it closed its answers{}", after(&words))),
            Ok(status) if is_killed(status) => Ended::Killed(status.to_string()),
            Ok(status) => Ended::Crash(format!("{status}{}", after(&words))),
            Err(e) => Ended::Crash(match sent {
                Ok(()) => e.to_string(),
                Err(sent) => sent.to_string(),
            }),
        })
    }

    fn send(&mut self, what: &impl serde::Serialize) -> io::Result<()> {
        match &mut self.to {
            Some(to) => wire::send(to, what, &[]),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    /// Seconds of processor time that it has had; none where the system does not say.
    fn processor_time(&self) -> Option<f64> {
        let text = std::fs::read_to_string(format!("/proc/{}/stat", self.process.id())).ok()?;
        // after the name, which may have anything in it, and 11 more: user and system time, in ticks of 10 ms
        let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
        let user: f64 = fields.next()?.parse().ok()?;
        let system: f64 = fields.next()?.parse().ok()?;
        Some((user + system) / 100.0)
    }

    /// It says nothing more: gives it time to end by itself, so that its exit status is known. Returns whether it has
    /// ended.
    fn await_end(&mut self) -> bool {
        let start = Instant::now();
        while matches!(self.process.try_wait(), Ok(None)) {
            if start.elapsed() > END {
                return false;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        true
    }

    /// Its last output; the worker has ended then.
    fn last_word(&mut self) -> String {
        self.to = None;
        let _ = self.process.kill();
        self.words.take().and_then(|thread| thread.join().ok()).unwrap_or_default()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.to = None;
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Passes on a worker's answers until it ends or nobody listens.
fn listen(from: ChildStdout, to: &Sender<io::Result<(Answer, Vec<u8>)>>) {
    let mut from = BufReader::new(from);
    loop {
        let told = wire::receive::<Response>(&mut from, LARGEST);
        let answer = told.map(|(told, body)| {
            counts::add_all(&told.requests);
            (told.answer, body)
        });
        let is_over = answer.is_err();
        if to.send(answer).is_err() || is_over {
            return;
        }
    }
}

/// Signals by which a process ends for what it did itself: illegal instruction, trap, abort, bus error, arithmetic,
/// segmentation fault, a bad system call.
#[cfg(unix)]
const OWN: [i32; 8] = [4, 5, 6, 7, 8, 10, 11, 31];

/// Whether a signal ended it that is sent by others: by the system, which has no memory left, or by a person.
#[cfg(unix)]
fn is_killed(status: ExitStatus) -> bool {
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    signal.is_some_and(|signal| !OWN.contains(&signal))
}

#[cfg(not(unix))]
fn is_killed(_: ExitStatus) -> bool {
    false
}

fn after(words: &str) -> String {
    let is_said = |l: &&str| !l.trim().is_empty() && !l.starts_with("note:");
    let line = words.lines().rev().find(is_said).unwrap_or_default();
    let line: String = line.trim().chars().filter(|c| !c.is_control()).take(200).collect();
    if line.is_empty() { line } else { format!(", {line}") }
}

/// Reads to the end and keeps the end of it.
fn last_words(mut from: impl Read) -> String {
    let mut kept = Vec::new();
    let mut some = [0; 1024];
    while let Ok(n @ 1..) = from.read(&mut some) {
        kept.extend_from_slice(&some[..n]);
        let beyond = kept.len().saturating_sub(LAST_WORDS);
        kept.drain(..beyond);
    }
    String::from_utf8_lossy(&kept).into_owned()
}
