//! What happened to a bike: the search for events.
//!
//! Of all shapes (one session, a stretch, a step, a line) and all coefficients the largest score is
//! taken, if chance alone does not make one so large ([`super::threshold`]); its coefficients'
//! levels are fitted anew, and the rest is searched again. All coefficients that move decide together when.

use super::events::{Event, Moved, classify};
use super::history::History;
use super::levels;
use super::scan::{self, SCAN_FROM, Shape, Sums};
use super::threshold::{Limits, normal_limit};

/// Chance that, once an event is certain, any coefficient is said to move with it that does not.
const JOINS: f64 = 1e-3;

/// A coefficient moves with others where its score is at least this share of the largest that it has anywhere.
const SHADOW: f64 = 0.7;

/// No bike has more events than so many, and a fifth of its sessions.
const MAX_EVENTS: usize = 12;

/// The events of one bike, the strongest first.
pub(crate) fn find(history: &History, limits: &Limits) -> Vec<Event> {
    let n = history.sessions.len();
    let count = |c: &usize| history.values[*c].iter().filter(|v| v.is_finite()).count();
    let scanned: Vec<usize> = (0..history.keys.len()).filter(|c| count(c) >= SCAN_FROM).collect();
    if scanned.is_empty() {
        return Vec::new();
    }
    let search = Search {
        history,
        times: history.times(),
        counts: scanned.iter().map(count).collect(),
        // a coefficient with fewer values needs a larger score; each has the same share of the alarms
        limit: scanned.iter().map(|c| limits.get(count(c), scanned.len())).collect(),
        join: normal_limit(JOINS / scanned.len() as f64),
        shapes: scan::shapes(n),
        scanned,
        limits,
    };
    let mut events: Vec<Event> = Vec::new();
    while events.len() < MAX_EVENTS.max(n / 5) {
        let Some(event) = search.next(&events) else { break };
        events.push(event);
    }
    // what was found first was found beside what was not known yet
    let mut k = 0;
    while k < events.len() {
        let event = events.remove(k);
        let places: Vec<usize> = event.moved.iter().map(|m| m.coefficient).collect();
        let again = search
            .next(&events)
            .filter(|e| e.moved.iter().any(|m| places.contains(&m.coefficient)));
        if let Some(again) = again {
            events.insert(k, again);
            k += 1;
        }
    }
    events.sort_by(|a, b| {
        b.score.total_cmp(&a.score).then(a.sessions().start.cmp(&b.sessions().start))
    });
    events
}

/// Events to look for in a bike's history, and their thresholds.
struct Search<'a> {
    history: &'a History,
    times: Vec<f64>,
    /// Coefficients with values enough.
    scanned: Vec<usize>,
    /// Values of each.
    counts: Vec<usize>,
    /// Score that chance alone hardly makes, of each.
    limit: Vec<f64>,
    /// Score from which on a coefficient moves with others.
    join: f64,
    shapes: Vec<Shape>,
    limits: &'a Limits,
}

impl Search<'_> {
    /// The strongest event beside those known already, if it is beyond the limit.
    fn next(&self, events: &[Event]) -> Option<Event> {
        let Search { history, scanned, shapes, join, .. } = self;
        let sums: Vec<(f64, Sums)> =
            scanned.iter().map(|c| sums(history, events, *c, &self.times)).collect();
        let mut best = (1.0, None);
        // the largest score of each coefficient
        let mut own = vec![0.0_f64; sums.len()];
        for (k, ((_, s), limit)) in sums.iter().zip(&self.limit).enumerate() {
            for shape in shapes {
                let score = s.score(*shape).abs();
                own[k] = own[k].max(score);
                if score / limit > best.0 {
                    best = (score / limit, Some((*shape, k)));
                }
            }
        }
        let (first, k) = best.1?;
        let limit = self.limit[k];
        let chance = self.limits.chance(best.0 * limit, self.counts[k], scanned.len());
        let moved = |shape: Shape| -> Vec<usize> {
            // a score that is much less than the coefficient's largest is the shadow of a change at another time
            let joins = |k: &usize| {
                let score = sums[*k].1.score(shape).abs();
                score >= join.min(limit) && score >= SHADOW * own[*k]
            };
            (0..scanned.len()).filter(joins).collect()
        };
        let joined = moved(first);
        let gain =
            |shape: Shape| joined.iter().map(|k| sums[*k].1.score(shape).powi(2)).sum::<f64>();
        // each end that is found costs what finding it gains by chance (Schwarz): of two descriptions
        // of the same change the one with fewer ends is taken
        let ends = 2.0 * (history.sessions.len() as f64).ln();
        let gain = |shape: Shape| gain(shape) - ends * shape.ends(history.sessions.len());
        let shape = shapes.iter().copied().max_by(|a, b| gain(*a).total_cmp(&gain(*b)))?;
        let shape = scan::refined(shape, history.sessions.len(), gain);
        let moved: Vec<Moved> = moved(shape)
            .into_iter()
            .map(|k| Moved {
                coefficient: scanned[k],
                size: f64::NAN,
                score: sums[k].1.score(shape),
            })
            .collect();
        let score = moved.iter().map(|m| m.score.abs()).fold(0.0, f64::max);
        if moved.is_empty() {
            return None;
        }
        let mut event = classify(history, shape, moved, score);
        for m in &mut event.moved {
            let tau = sums[scanned.iter().position(|c| *c == m.coefficient)?].0;
            m.size = size(history, events, m.coefficient, shape, tau);
        }
        event.chance = chance;
        event.reason = event.describe(history, limit);
        Some(event)
    }
}

/// Spread between sessions and running sums of what the known events leave of a coefficient.
fn sums(history: &History, events: &[Event], c: usize, times: &[f64]) -> (f64, Sums) {
    let (values, errors) = (&history.values[c], &history.errors[c]);
    let columns = levels::regressors(history, events, c, true);
    let residuals = |tau: f64| -> Vec<f64> {
        let variances: Vec<f64> = errors.iter().map(|e| tau * tau + e * e).collect();
        match levels::fit(values, &variances, &columns) {
            // a value with a level of its own leaves no residual
            Some(level) => (0..values.len())
                .map(|i| match level.variance[i] > 0.999 * variances[i] {
                    true => f64::NAN,
                    false => values[i] - level.fitted[i],
                })
                .collect(),
            None => vec![f64::NAN; values.len()],
        }
    };
    let start = scan::robust_tau(values, errors);
    // floor: where the standard errors explain all, a weight is still finite
    let tau = scan::robust_tau(&residuals(start), errors);
    let rest = residuals(tau);
    let variances: Vec<f64> = errors.iter().map(|e| tau * tau + e * e).collect();
    (tau, Sums::new(&rest, &variances, times))
}

/// Change of level, or slope times the whole time, as a share of the level before.
fn size(history: &History, events: &[Event], c: usize, shape: Shape, tau: f64) -> f64 {
    let mut columns = levels::regressors(history, events, c, true);
    let column = levels::column(history, shape);
    let range = column.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x))
        - column.iter().fold(f64::INFINITY, |m, x| m.min(*x));
    columns.push(column);
    let variances: Vec<f64> = history.errors[c].iter().map(|e| tau * tau + e * e).collect();
    match levels::fit(&history.values[c], &variances, &columns) {
        Some(level) => {
            level.theta.last().copied().unwrap_or(f64::NAN) * range / level.theta[0].abs()
        }
        None => f64::NAN,
    }
}
