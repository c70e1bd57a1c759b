//! What a worker may use for one log.

use std::fmt;

const GB: f64 = 1e9;

/// Memory that every log may take, bytes, and the bytes more per byte of the log: a packed log grows tenfold when it is
/// read, and the stages keep a few copies.
const MEMORY: (f64, f64) = (1.5 * GB, 40.0);
/// Processor time that every log may take, s, and the seconds more per byte of the log.
const TIME: (f64, f64) = (60.0, 20.0 / 1e6);
/// Share of the machine's memory that all workers together may take.
const SHARE: f64 = 0.8;

/// Limits that the user gives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LimitOptions {
    /// Memory that one log may take, GB; else by its size.
    pub memory: Option<f64>,
    /// Processor time that one log may take, s; else by its size.
    pub time: Option<f64>,
    /// No workers: logs are read in this process, without limits.
    pub in_process: bool,
}

impl LimitOptions {
    /// The limits of a log of so many bytes, one of so many that are read at the same time.
    pub fn limits(&self, bytes: u64, jobs: usize, effort: f64) -> Limits {
        let own = MEMORY.0 + MEMORY.1 * bytes as f64;
        let most = SHARE * machine_memory() / jobs.max(1) as f64;
        let memory = self.memory.map_or(own.min(most), |gb| gb * GB);
        let time = self.time.unwrap_or((TIME.0 + TIME.1 * bytes as f64) * effort);
        // in whole steps: the text tells limits apart
        Limits { memory: (memory / 1e7).round().max(1.0) as u64, time: time.ceil() as u64 }
    }
}

/// Limits of a worker for one log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Memory, 10 MB.
    memory: u64,
    /// Processor time, s.
    time: u64,
}

impl Limits {
    /// Memory, bytes.
    pub fn bytes(&self) -> u64 {
        self.memory * 10_000_000
    }

    /// Processor time, s.
    pub fn seconds(&self) -> f64 {
        self.time as f64
    }

    /// Memory, for people.
    pub fn memory_text(&self) -> String {
        format!("{:.2} GB", self.bytes() as f64 / GB)
    }

    /// Processor time, for people.
    pub fn time_text(&self) -> String {
        format!("{} s", self.time)
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.memory_text(), self.time_text())
    }
}

/// Files that this process opens beside those of its workers, and those of each worker: three pipes, and a few more while it
/// is started.
const FILES: (u64, u64) = (48, 4);

/// How many workers the files allow that this process may have open.
#[cfg(target_os = "linux")]
pub(super) fn most_workers() -> usize {
    let files = rlimit::increase_nofile_limit(rlimit::INFINITY).unwrap_or(1024);
    usize::try_from(files.saturating_sub(FILES.0) / FILES.1).unwrap_or(usize::MAX).max(1)
}

/// How many workers the files allow that this process may have open; that is not known here.
#[cfg(not(target_os = "linux"))]
pub fn most_workers() -> usize {
    ((1024 - FILES.0) / FILES.1) as usize
}

/// Address space of a worker beside the data that are counted, bytes: the program, stacks, what is only reserved.
#[cfg(target_os = "linux")]
const BESIDE: u64 = 1 << 30;

/// Whether the shell allows less than so many bytes of data.
#[cfg(target_os = "linux")]
pub(super) fn is_less_allowed(bytes: u64) -> bool {
    use rlimit::{Resource, getrlimit};
    let space = getrlimit(Resource::AS).map_or(rlimit::INFINITY, |(soft, _)| soft);
    let data = getrlimit(Resource::DATA).map_or(rlimit::INFINITY, |(_, hard)| hard);
    space < bytes.saturating_add(BESIDE) || data < bytes
}

/// Whether the shell allows less than so many bytes of data; that is not known here.
#[cfg(not(target_os = "linux"))]
pub fn is_less_allowed(_: u64) -> bool {
    false
}

/// Memory of this machine, or of the container that it is, bytes; 8 GB where that is not known.
fn machine_memory() -> f64 {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let total = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find(|l| l.starts_with("MemTotal:"))?.to_owned();
        Some(1024.0 * line.split_whitespace().nth(1)?.parse::<f64>().ok()?)
    });
    let container = read("/sys/fs/cgroup/memory.max").and_then(|t| t.trim().parse::<f64>().ok());
    match (total, container) {
        (Some(a), Some(b)) => a.min(b),
        (a, b) => a.or(b).unwrap_or(8.0 * GB),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_log_may_take_more_and_what_is_asked_for_holds() {
        let asked = LimitOptions::default();
        let (small, large) = (asked.limits(1_000, 1, 1.0), asked.limits(20_000_000, 1, 1.0));
        assert!(large.bytes() > small.bytes() && large.seconds() > small.seconds());
        assert!(asked.limits(1 << 40, 4, 1.0).bytes() as f64 <= 0.8 * machine_memory());
        let asked = LimitOptions { memory: Some(1.0), time: Some(5.0), in_process: false };
        assert_eq!(asked.limits(1 << 40, 64, 30.0).to_string(), "1.00 GB, 5 s");
    }
}
