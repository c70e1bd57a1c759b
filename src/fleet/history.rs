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
    /// Their standard errors.
    pub errors: Vec<Vec<f64>>,
    /// Poorly determined values, which are only pooled; NaN where there is none.
    pub poor: Vec<Vec<f64>>,
    /// Their standard errors.
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

    /// Time for slopes: days where every session has one, else the session's number.
    pub fn times(&self) -> Vec<f64> {
        let days: Option<Vec<f64>> = self.days.iter().copied().collect();
        days.unwrap_or_else(|| (0..self.sessions.len()).map(|i| i as f64).collect())
    }
}
