//! What the shell allows this process, looked at before anything begins: memory that is missing later ends it without a word.

use super::failure::Failure;

/// Address space that the program takes with one thread, bytes.
#[cfg(target_os = "linux")]
const LEAST: u64 = 1 << 30;
/// The same of memory that it has to itself, bytes.
#[cfg(target_os = "linux")]
const LEAST_DATA: u64 = 512 << 20;
/// What each thread more reserves: its stack, and room for what it allocates.
#[cfg(target_os = "linux")]
const EACH: u64 = 144 << 20;

/// How many threads may work.
///
/// # Errors
/// Not one: the memory is too small that the shell allows (`ulimit -v`, `ulimit -d`).
#[cfg(target_os = "linux")]
pub(super) fn most_threads() -> Result<usize, Failure> {
    use rlimit::{INFINITY, Resource, getrlimit, setrlimit};
    let mut most = usize::MAX;
    for (resource, what, least) in [
        (Resource::AS, "address space are allowed (`ulimit -v`)", LEAST),
        (Resource::DATA, "data are allowed (`ulimit -d`)", LEAST_DATA),
    ] {
        let (soft, hard) = getrlimit(resource).unwrap_or((INFINITY, INFINITY));
        if soft == INFINITY {
            continue;
        }
        let space = setrlimit(resource, hard, hard).map_or(soft, |()| hard);
        let Some(rest) = space.checked_sub(least) else {
            return Err(Failure::Output(format!(
                "{} MB of {what}, and roadbench takes {} MB; raise that",
                space >> 20,
                least >> 20
            )));
        };
        most = most.min(usize::try_from(rest / EACH).unwrap_or(usize::MAX).max(1));
    }
    Ok(most)
}

/// How many threads may work: nobody says.
///
/// # Errors
/// None.
#[cfg(not(target_os = "linux"))]
pub fn most_threads() -> Result<usize, Failure> {
    Ok(usize::MAX)
}
