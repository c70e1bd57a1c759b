//! One bike's coefficients, session by session in order of time.

use std::collections::{BTreeMap, BTreeSet};

use super::observation::Observation;

/// Sessions by coefficients; NaN where a session has no value.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// Session ids, by start time, then id; those without a time last.
    pub sessions: Vec<String>,
    /// Start of each, days since 1970.
    pub days: Vec<Option<f64>>,
    /// Where each was ridden, where that is known.
    pub sites: Vec<Option<String>>,
    /// Tyre and coefficient.
    pub keys: Vec<(String, String)>,
    /// Determined values, by coefficient and session; NaN where there is none.
    pub values: Vec<Vec<f64>>,
    pub errors: Vec<Vec<f64>>,
    /// Poorly determined values, which are only pooled; NaN where there is none.
    pub poor: Vec<Vec<f64>>,
    pub poor_errors: Vec<Vec<f64>>,
}

impl History {
    /// The rows of one bike; what is not finite, or has no positive standard error, is left out.
    pub fn new(rows: &[&Observation]) -> Self {
        let usable = |o: &&&Observation| {
            o.value.is_finite()
                && o.error.is_finite()
                && o.error > 0.0
                && (o.error * o.error).is_normal()
        };
        let mut starts: BTreeMap<&str, Option<f64>> = BTreeMap::new();
        let mut sites: BTreeMap<&str, &str> = BTreeMap::new();
        for o in rows.iter().filter(usable) {
            let day = starts.entry(&o.session).or_default();
            *day = day.or(o.day);
            if let Some(site) = &o.site {
                sites.insert(&o.session, site);
            }
        }
        let mut sessions: Vec<(&str, Option<f64>)> = starts.into_iter().collect();
        let late = |day: Option<f64>| day.unwrap_or(f64::INFINITY);
        sessions.sort_by(|a, b| late(a.1).total_cmp(&late(b.1)).then(a.0.cmp(b.0)));
        let place: BTreeMap<&str, usize> =
            sessions.iter().enumerate().map(|(i, (id, _))| (*id, i)).collect();
        let keys: BTreeSet<(&str, &str)> =
            rows.iter().filter(usable).map(|o| (&*o.tyre, &*o.coefficient)).collect();
        let keys: Vec<(&str, &str)> = keys.into_iter().collect();
        let empty = || vec![vec![f64::NAN; sessions.len()]; keys.len()];
        let mut history = History {
            sessions: sessions.iter().map(|(id, _)| (*id).to_owned()).collect(),
            days: sessions.iter().map(|(_, day)| *day).collect(),
            sites: sessions.iter().map(|(id, _)| sites.get(id).map(|s| (*s).to_owned())).collect(),
            keys: keys.iter().map(|(t, c)| ((*t).to_owned(), (*c).to_owned())).collect(),
            values: empty(),
            errors: empty(),
            poor: empty(),
            poor_errors: empty(),
        };
        for o in rows.iter().filter(usable) {
            let Ok(c) = keys.binary_search(&(&*o.tyre, &*o.coefficient)) else { continue };
            let i = place[&*o.session];
            let (value, error) = match o.determined {
                true => (&mut history.values, &mut history.errors),
                false => (&mut history.poor, &mut history.poor_errors),
            };
            value[c][i] = o.value;
            error[c][i] = o.error;
        }
        history
    }

    /// Whether slopes are per day: at least half of the sessions have a day.
    pub fn is_dated(&self) -> bool {
        2 * self.days.iter().flatten().count() >= self.sessions.len()
    }

    /// Time for slopes, days; the session's number where fewer than half of the sessions have a day.
    ///
    /// A session without a day among dated ones has their mean: there it says nothing of a slope.
    pub fn times(&self) -> Vec<f64> {
        if !self.is_dated() {
            return (0..self.sessions.len()).map(|i| i as f64).collect();
        }
        let known: Vec<f64> = self.days.iter().flatten().copied().collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        self.days.iter().map(|day| day.unwrap_or(mean)).collect()
    }

    /// Whether a session's time is known, for a slope over [`History::times`].
    pub(crate) fn is_timed(&self, session: usize) -> bool {
        self.days[session].is_some() || !self.is_dated()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(days: &[Option<f64>]) -> History {
        let of = |i: usize| format!("s{i}");
        History {
            sessions: (0..days.len()).map(of).collect(),
            days: days.to_vec(),
            ..History::default()
        }
    }

    #[test]
    fn a_session_without_a_day_takes_the_days_from_no_other() {
        let most = history(&[Some(10.0), Some(12.0), Some(17.0), None]);
        assert_eq!(most.times(), [10.0, 12.0, 17.0, 13.0]);
        assert_eq!([0, 3].map(|i| most.is_timed(i)), [true, false]);
        let few = history(&[Some(10.0), None, None]);
        assert_eq!(few.times(), [0.0, 1.0, 2.0]);
        assert!(few.is_timed(1) && !few.is_dated());
        assert!(history(&[]).times().is_empty());
    }
}
