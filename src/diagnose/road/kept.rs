//! Results that are kept by what they were made from: a ride that is diagnosed again with other constants
//! mostly goes through the same models and fault-free simulations, and pays for the others only.

use std::collections::HashMap;
use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};

/// Hash of the inputs of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Key([u8; 32]);

impl Key {
    /// Of all that a result depends on, by what `Debug` says of it: that tells every number exactly.
    pub(crate) fn of(made_from: &impl Debug) -> Self {
        Key(*blake3::hash(format!("{made_from:?}").as_bytes()).as_bytes())
    }
}

/// Results by what they were made from; by default none is kept and each is made whenever it is needed.
#[derive(Debug)]
pub(crate) struct Memo<T>(Option<Mutex<HashMap<Key, Arc<T>>>>);

impl<T> Default for Memo<T> {
    fn default() -> Self {
        Memo(None)
    }
}

impl<T> Memo<T> {
    /// Keeps every result from now on.
    pub(crate) fn keeping() -> Self {
        Memo(Some(Mutex::default()))
    }

    /// Whether it keeps them.
    pub(crate) fn is_keeping(&self) -> bool {
        self.0.is_some()
    }

    /// The result of what it is made from.
    pub(crate) fn get_or(&self, made_from: &impl Debug, make: impl FnOnce() -> T) -> Arc<T> {
        let Some(results) = &self.0 else { return Arc::new(make()) };
        let key = Key::of(made_from);
        // a panic cannot leave half a result: nothing but look-ups runs while it is locked
        let results = || results.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = results().get(&key) {
            return known.clone();
        }
        let made = Arc::new(make());
        results().entry(key).or_insert(made).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_made_once_where_results_are_kept() {
        let made = |kept: &Memo<f64>, from: f64| {
            let mut made = false;
            assert_eq!(
                *kept.get_or(&from, || {
                    made = true;
                    2.0 * from
                }),
                2.0 * from
            );
            made
        };
        let kept = Memo::keeping();
        // two numbers that differ in the last bit are not the same
        assert_eq!(
            [0.3, 0.1 + 0.2, 0.3, 0.1 + 0.2].map(|x| made(&kept, x)),
            [true, true, false, false]
        );
        assert_eq!([0.3, 0.3].map(|x| made(&Memo::default(), x)), [true, true]);
    }
}
