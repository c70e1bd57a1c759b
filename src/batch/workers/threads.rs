//! Threads, as many as are asked for and as the machine gives.

use rayon::{ThreadPool, ThreadPoolBuilder};

/// More per core make nothing faster, and each log's share of the memory smaller.
const PER_CORE: usize = 8;
/// So many are always allowed: they may wait for a store.
const ALLOWED: usize = 16;

/// Stack of a thread, bytes: that of a main thread, whatever `ulimit -s` says.
pub(crate) const STACK: usize = 8 << 20;

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Number of threads for a requested number; 0 takes one per core.
pub(crate) fn taken(asked: usize) -> usize {
    match asked {
        0 => {
            let set = std::env::var("RAYON_NUM_THREADS").ok().and_then(|n| n.parse().ok());
            set.filter(|n| *n > 0).unwrap_or_else(cores)
        }
        asked => asked.min(ALLOWED.max(PER_CORE * cores())),
    }
}

/// So many threads, or as many as there can be, which is said; none where there can be no other one at all.
pub(crate) fn pool(wanted: usize) -> Option<ThreadPool> {
    let mut threads = wanted.max(1);
    loop {
        let built = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
        let e = match built {
            Ok(pool) if threads < wanted => {
                tracing::warn!("no more than {threads} of {wanted} threads can be started");
                return Some(pool);
            }
            Ok(pool) => return Some(pool),
            Err(e) => e,
        };
        if threads == 1 {
            tracing::warn!("no thread can be started ({e}): all work is done on one thread");
            return None;
        }
        threads /= 2;
    }
}

/// Does something in this thread, and what it does in parallel too.
pub(crate) fn alone<T>(work: impl FnOnce() -> T) -> T {
    let own = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    if let Err(e) = &own {
        tracing::debug!("{e}"); // it is one of a pool already
    }
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_as_are_asked_for_within_reason() {
        assert_eq!(taken(3), 3);
        assert!(taken(0) >= 1 && taken(999) < 999);
        assert_eq!(pool(3).map(|pool| pool.current_num_threads()), Some(3));
        let in_parallel = || {
            use rayon::prelude::*;
            (0..100).into_par_iter().map(|i| i * rayon::current_num_threads()).sum::<usize>()
        };
        let thread = std::thread::spawn(move || alone(in_parallel));
        assert_eq!(thread.join().expect("no panic"), 4950, "one thread did it");
    }
}
