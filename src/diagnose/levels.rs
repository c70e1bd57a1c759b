//! What several sessions share: an effect of a motorcycle, a road or a night.
//!
//! Every session has its own estimate of every effect that it sees. Per effect the sessions are
//! grouped - all together, by bike, by site, by night, each for itself - and the grouping is taken
//! whose means explain the estimates best for their number (Schwarz 1978, BIC). A group's mean is
//! reported when it is beyond chance and predicts each of its sessions from the others.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::contract::verdict::Verdict;
use crate::simulate::effects::pooled_effects::PooledEffect;
use crate::simulate::effects::{ALL, Effect, Level, SessionRef};
use crate::store::tables::rows::POOLED;
use crate::store::tables::rows::{CauseRow, Ident};

/// Least distance of a reported mean from nil, in standard errors: by chance one in a thousand fleets of thirty effects
/// has such a mean.
const MIN_STANDARD_ERRORS: f64 = 4.2;
/// Share of a session's error that all sessions may have in common. It is bias of the method that fault-free
/// simulations do not show, and no number of sessions averages it out.
const COMMON_ERROR: f64 = 0.35;
/// Common error of the sizes of an archive's sessions, as a share: in five simulated archives
/// of six to twelve rides the mean of their late velocities was 4 to 13 % too large.
const COMMON_SHARE: f64 = 0.08;
/// Least gain on sessions left out, in twice the loss.
const GAIN: f64 = 9.0;
/// Factor on the error of a session with an unexplained misfit, which then weighs a quarter. Such sessions are kept:
/// otherwise an archive in which each has one would have no shared causes.
const DOUBT: f64 = 2.0;
/// Standard errors from nil beyond which a session has an effect that its own diagnosis did not identify.
const SEEN: f64 = 1.96;
/// Least number of sessions with an effect for its mean to be identified, where no session identified it.
const MIN_SESSIONS: usize = 2;
/// Most sessions that a row lists.
const LISTED: usize = 5;

#[derive(Debug, Clone)]
pub struct Member {
    /// Session, bike and start.
    pub ident: Ident,
    /// Where it was ridden.
    pub site: Option<String>,
    /// Whether its model is not known to be wrong: nothing stays unexplained.
    pub sound: bool,
}

impl Member {
    /// The group of a level it belongs to.
    fn group(&self, level: Level) -> String {
        let Ident { session_id, bike_id, start_time } = &self.ident;
        let (site, start_time) = (self.site.as_deref(), start_time.as_deref());
        let group = level.group(&SessionRef { session_id, bike_id, site, start_time });
        match level {
            // two motorcycles may have a session of the same id each
            Level::Session => format!("{bike_id}/{group}"),
            _ => group.to_owned(),
        }
    }
}

/// A session's estimate of an effect.
#[derive(Debug, Clone)]
struct Evidence {
    member: Arc<Member>,
    value: f64,
    std_error: f64,
    /// Whether the session itself identified the effect.
    named: bool,
}

impl Evidence {
    /// That of a row of `causes`.
    ///
    /// # Errors
    /// Why the session has none.
    fn of(member: &Arc<Member>, row: Option<&CauseRow>) -> Result<Self, &'static str> {
        let row = row.ok_or("not looked for")?;
        if row.verdict == Verdict::NotIdentifiable.name() {
            return Err("not identifiable in them");
        }
        // the size of an alternative assumes that the other cause is absent
        if row.verdict == Verdict::Alternative.name() {
            return Err("one of several in them");
        }
        let (Some(value), Some(low), Some(high)) = (row.value, row.ci95_low, row.ci95_high) else {
            return Err("no size or error");
        };
        let own = (high - low) / (2.0 * 1.96);
        if !(own > 0.0 && own.is_finite() && value.is_finite()) {
            return Err("no size or error");
        }
        let std_error = if member.sound { own } else { DOUBT * own };
        let named = Verdict::from_name(&row.verdict).is_some_and(Verdict::is_cause);
        Ok(Evidence { member: member.clone(), value, std_error, named })
    }

    /// Whether it has the sign of a size.
    fn agrees(&self, size: f64) -> bool {
        self.value * size > 0.0
    }

    /// Whether it is beyond its error.
    fn is_seen(&self) -> bool {
        self.value.abs() > SEEN * self.std_error
    }
}

/// Estimates of an effect in all sessions.
#[derive(Debug, Default)]
struct EffectEvidence {
    seen: Vec<Evidence>,
    /// The sessions without an estimate, and why.
    left_out: Vec<(Arc<Member>, &'static str)>,
}

/// Estimates of every effect in the sessions.
#[derive(Debug, Default)]
pub struct Pooling {
    estimates: BTreeMap<&'static str, EffectEvidence>,
}

impl Pooling {
    /// Takes a session's rows of `causes`. A session without a row of an effect on the road is not counted.
    pub fn add(&mut self, member: Member, causes: &[CauseRow]) {
        let member = Arc::new(member);
        let own = |effect: &Effect| {
            causes.iter().find(|row| row.effect == effect.name && row.level == "session")
        };
        if ALL.iter().all(|effect| own(effect).is_none()) {
            return;
        }
        for effect in ALL {
            let estimates = self.estimates.entry(effect.name).or_default();
            match Evidence::of(&member, own(effect)) {
                Ok(evidence) => estimates.seen.push(evidence),
                Err(why) => estimates.left_out.push((member.clone(), why)),
            }
        }
    }

    /// Rows of `causes` for what sessions share, of every effect by name.
    ///
    /// A row is identified if one session identified the effect with this sign, or two have it with this sign beyond
    /// their errors. Any other mean may be a bias of the method in all of them: its row is not needed.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub fn rows(&self) -> Vec<CauseRow> {
        self.causes().into_iter().map(|cause| cause.row).collect()
    }

    /// Shared causes of every effect, by name.
    pub fn causes(&self) -> Vec<SharedCause> {
        let of = |effect: &'static Effect| Some((effect, self.estimates.get(effect.name)?));
        ALL.iter()
            .filter_map(of)
            .filter(|(_, estimates)| estimates.seen.len() > 1)
            .flat_map(|(effect, estimates)| pool_one(effect, estimates))
            .collect()
    }
}

/// A cause that a group of sessions shares.
#[derive(Debug, Clone)]
pub struct SharedCause {
    /// Its row of `causes`.
    pub row: CauseRow,
    /// Level of the group: fleet, motorcycle, site or night.
    level: Level,
    /// Sessions that its size comes from.
    sessions: usize,
}

impl SharedCause {
    /// For `run --model`; `None` where the mean is not identified.
    pub fn effect(&self) -> Option<PooledEffect> {
        let CauseRow { effect, unit, pooled_over, .. } = self.row.clone();
        let is_cause = Verdict::from_name(&self.row.verdict).is_some_and(Verdict::is_cause);
        let (low, high) = self.row.ci95_low.zip(self.row.ci95_high).filter(|_| is_cause)?;
        Some(PooledEffect {
            effect,
            level: self.level,
            group: pooled_over.unwrap_or_default(),
            value: self.row.value?,
            std_error: (high - low) / (2.0 * 1.96),
            unit,
            sessions: self.sessions,
        })
    }
}

/// Weighted mean, its standard error with the scatter between sessions, and the squared misfit.
fn mean(estimates: &[&Evidence]) -> (f64, f64, f64) {
    let weight = |s: &&&Evidence| s.std_error.powi(-2);
    let total: f64 = estimates.iter().map(|s| weight(&s)).sum();
    let mean = estimates.iter().map(|s| weight(&s) * s.value).sum::<f64>() / total;
    let misfit: f64 = estimates.iter().map(|s| weight(&s) * (s.value - mean).powi(2)).sum();
    // sessions that differ more than their errors make the mean less certain (Birge 1932)
    let degrees = (estimates.len() as f64 - 1.0).max(1.0);
    let scatter = (misfit / degrees).max(1.0).sqrt() / total.sqrt();
    let usual = (estimates.len() as f64 / total).sqrt();
    (mean, scatter.hypot(COMMON_ERROR * usual), misfit)
}

/// Fall of twice the loss when each session is predicted from the others of its group.
fn left_out(estimates: &[&Evidence]) -> f64 {
    (0..estimates.len())
        .map(|k| {
            let others: Vec<&Evidence> =
                estimates.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, s)| *s).collect();
            let (by, _, _) = mean(&others);
            let own = estimates[k];
            by * (2.0 * own.value - by) / own.std_error.powi(2)
        })
        .sum()
}

/// The estimates by the group of a level.
fn grouped(seen: &[Evidence], level: Level) -> BTreeMap<String, Vec<&Evidence>> {
    let mut groups: BTreeMap<String, Vec<&Evidence>> = BTreeMap::new();
    for estimate in seen {
        groups.entry(estimate.member.group(level)).or_default().push(estimate);
    }
    groups
}

/// The level whose groups explain the estimates best, and the other levels with the same groups. `None` if there is no
/// effect, or if each session has its own size: the sessions' own rows have that.
fn level_of(effect: &Effect, seen: &[Evidence]) -> Option<(Level, Vec<Level>)> {
    let n = seen.len() as f64;
    let partition = |level: Level| -> BTreeSet<Vec<String>> {
        let ids = |estimates: &Vec<&Evidence>| -> Vec<String> {
            estimates.iter().map(|s| s.member.ident.session_id.clone()).collect()
        };
        grouped(seen, level).values().map(ids).collect()
    };
    let levels = [Level::Fleet, Level::Bike, Level::Site, Level::Night, Level::Session];
    let cost = |level: Level| {
        let groups = grouped(seen, level);
        groups.values().map(|g| mean(g).2).sum::<f64>() + groups.len() as f64 * n.ln()
    };
    let nothing: f64 = seen.iter().map(|s| (s.value / s.std_error).powi(2)).sum();
    let best = levels.into_iter().min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
    if cost(best) >= nothing || best == Level::Session {
        return None;
    }
    // of levels with the same groups the usual one of the effect is taken
    let same: Vec<Level> =
        levels.into_iter().filter(|l| partition(*l) == partition(best)).collect();
    // an effect that each ride usually has by itself, such as a sensor's zero, is the motorcycle's if rides share it
    let usual = if effect.level == Level::Session { Level::Bike } else { effect.level };
    let level = if same.contains(&usual) { usual } else { best };
    Some((level, same.into_iter().filter(|l| *l != level).collect()))
}

fn pool_one(effect: &Effect, estimates: &EffectEvidence) -> Vec<SharedCause> {
    let Some((level, others)) = level_of(effect, &estimates.seen) else { return Vec::new() };
    let others: Vec<&str> = others.iter().map(|l| l.name()).collect();
    let also = match others.is_empty() {
        true => String::new(),
        false => format!("; these sessions cannot tell it from {}", others.join(", ")),
    };
    let of_group = |(name, seen): (String, Vec<&Evidence>)| {
        let left_out: Vec<(&str, &'static str)> = estimates
            .left_out
            .iter()
            .filter(|(member, _)| member.group(level) == name)
            .map(|(member, why)| (member.ident.session_id.as_str(), *why))
            .collect();
        let sessions = seen.len();
        let row = shared(effect, &Group { level, name, seen, left_out })?;
        Some(SharedCause { row: CauseRow { reason: row.reason + &also, ..row }, level, sessions })
    };
    grouped(&estimates.seen, level).into_iter().filter_map(of_group).collect()
}

/// The sessions that may share an effect.
struct Group<'a> {
    level: Level,
    name: String,
    seen: Vec<&'a Evidence>,
    /// Ids of those without an estimate, and why.
    left_out: Vec<(&'a str, &'static str)>,
}

/// The row of what a group shares; `None` where its mean is within chance.
fn shared(effect: &Effect, group: &Group<'_>) -> Option<CauseRow> {
    let (value, std_error, _) = mean(&group.seen);
    let gain = left_out(&group.seen);
    let score = (value / std_error).abs() / MIN_STANDARD_ERRORS;
    let sound = score >= 1.0 && gain >= GAIN && effect.in_bounds(value);
    if group.seen.len() < 2 || !sound {
        return None;
    }
    let agreeing = || group.seen.iter().filter(|s| s.agrees(value));
    let named = agreeing().filter(|s| s.named).count();
    let seen = agreeing().filter(|s| s.is_seen()).count();
    let supported = named > 0 || seen >= MIN_SESSIONS;
    let verdict = if supported { Verdict::Named } else { Verdict::NotNeeded };
    let half_width = 1.96 * std_error.hypot(COMMON_SHARE * value);
    let bikes: BTreeSet<&str> =
        group.seen.iter().map(|s| s.member.ident.bike_id.as_str()).collect();
    let bike = bikes.first().filter(|_| bikes.len() == 1).copied().unwrap_or(POOLED);
    Some(CauseRow {
        ident: Ident {
            session_id: POOLED.to_owned(),
            bike_id: bike.to_owned(),
            ..Ident::default()
        },
        rank: 1,
        effect: effect.name.to_owned(),
        verdict: verdict.name().to_owned(),
        level: group.level.name().to_owned(),
        pooled_over: Some(group.name.clone()).filter(|n| !n.is_empty()),
        parameter: effect.name.to_owned(),
        value: Some(value),
        unit: effect.unit.to_owned(),
        ci95_low: Some(value - half_width),
        ci95_high: Some(value + half_width),
        score,
        false_alarm_rate: 0.001,
        gain_heldout: Some(gain),
        separate_by: Some(effect.separate_by.to_owned()),
        reason: reason(effect.sentence_of(value), group, [named, seen]),
        ..CauseRow::default()
    })
}

/// Reason of a row: how many sessions it comes from, how many of them identified the effect (`named`) or have it beyond
/// their error (`seen`), which are in doubt and which are left out.
fn reason(sentence: &str, group: &Group<'_>, [named, seen]: [usize; 2]) -> String {
    let n = group.seen.len();
    let all = n + group.left_out.len();
    let mut text = match named > 0 || seen >= MIN_SESSIONS {
        true => {
            format!("{sentence}: shared by {n} of {all} sessions, identified in {named} of them")
        }
        false => format!(
            "not identified: no session identified it and {seen} have it beyond their error: the \
             mean of {n} of {all} sessions would mean that {sentence}"
        ),
    };
    let doubtful: Vec<&str> = group
        .seen
        .iter()
        .filter(|s| !s.member.sound)
        .map(|s| s.member.ident.session_id.as_str())
        .collect();
    if !doubtful.is_empty() {
        let ids = listed(&doubtful);
        text +=
            &format!("; counted with twice their error, as they have an unexplained misfit: {ids}");
    }
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (id, why) in &group.left_out {
        reasons.entry(why).or_default().push(id);
    }
    for (why, ids) in reasons {
        text += &format!("; left out, {why}: {}", listed(&ids));
    }
    text
}

/// Ids in words; the number of those beyond the first few.
fn listed(ids: &[&str]) -> String {
    let first = ids[..ids.len().min(LISTED)].join(", ");
    match ids.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(k: usize, bike: &str, site: &str, night: usize) -> Member {
        Member {
            ident: Ident {
                session_id: format!("s{k}"),
                bike_id: bike.to_owned(),
                start_time: Some(format!("2026-05-{:02}T20:00:00Z", night + 1)),
            },
            site: Some(site.to_owned()),
            sound: true,
        }
    }

    /// A row of a session whose standard error is 0.01, its size in those.
    fn row(effect: &str, verdict: Verdict, size: f64) -> CauseRow {
        CauseRow {
            effect: effect.to_owned(),
            verdict: verdict.name().to_owned(),
            level: "session".to_owned(),
            value: Some(0.01 * size),
            ci95_low: Some(0.01 * (size - 1.96)),
            ci95_high: Some(0.01 * (size + 1.96)),
            ..CauseRow::default()
        }
    }

    /// The rows of sessions of one bike at one site, each with its own row of `latency`.
    fn of_sessions(rows: &[CauseRow], sound: impl Fn(usize) -> bool) -> Vec<CauseRow> {
        let mut pooling = Pooling::default();
        for (k, row) in rows.iter().enumerate() {
            let member = Member { sound: sound(k), ..member(k, "a", "x", k) };
            pooling.add(member, std::slice::from_ref(row));
        }
        pooling.rows()
    }

    /// Two bikes on two sites over three nights, twelve sessions; `shift` is the truth in standard errors.
    fn told(shift: impl Fn(usize, usize, usize) -> f64) -> Vec<(String, Option<String>)> {
        let noise = [0.3, -0.8, 0.5, -0.2, 0.9, -0.6, 0.1, -0.4, 0.7, -0.9, 0.2, 0.4];
        let mut pooling = Pooling::default();
        for (k, noise) in noise.into_iter().enumerate() {
            let (bike, site, night) = (k % 2, k / 2 % 2, k / 4);
            let size = shift(bike, site, night) + noise;
            let causes = [row("latency", Verdict::NotNeeded, size)];
            pooling.add(member(k, ["a", "b"][bike], ["x", "y"][site], night), &causes);
        }
        pooling.rows().into_iter().map(|r| (r.level, r.pooled_over)).collect()
    }

    #[test]
    fn an_effect_is_attributed_to_what_shares_it() {
        let own = |level: &str, name: &str| vec![(level.to_owned(), Some(name.to_owned()))];
        assert_eq!(told(|bike, _, _| if bike == 1 { 5.0 } else { 0.0 }), own("bike", "b"));
        assert_eq!(told(|_, site, _| if site == 0 { -5.0 } else { 0.0 }), own("site", "x"));
        assert_eq!(
            told(|_, _, night| if night == 2 { 5.0 } else { 0.0 }),
            own("night", "2026-05-03")
        );
        assert_eq!(told(|_, _, _| 4.0), vec![("fleet".to_owned(), None)]);
        assert!(told(|_, _, _| 0.0).is_empty());
    }

    #[test]
    fn no_number_of_sessions_makes_a_size_surer_than_they_may_be_off_by_together() {
        let estimates = vec![row("latency", Verdict::NotNeeded, 5.0); 400];
        let rows = of_sessions(&estimates, |_| true);
        let (Some(low), Some(high)) = (rows[0].ci95_low, rows[0].ci95_high) else { panic!() };
        assert!(high - low > 2.0 * 1.96 * COMMON_SHARE * 0.05, "{low} to {high}");
    }

    #[test]
    fn a_mean_that_no_session_supports_is_not_named() {
        // each within its own error, all to the same side
        let weak = vec![row("latency", Verdict::NotNeeded, 1.9); 80];
        let [own] = &of_sessions(&weak, |_| true)[..] else { panic!() };
        assert_eq!(own.verdict, "not_needed");
        assert!(own.reason.contains("no session identified it and 0 have it"), "{}", own.reason);
        // one that identified it, or two beyond their errors
        let mut rows = weak.clone();
        rows[7] = row("latency", Verdict::Ambiguous, 1.9);
        assert_eq!(of_sessions(&rows, |_| true)[0].verdict, "named");
        let mut rows = weak.clone();
        rows[7] = row("latency", Verdict::NotNeeded, 2.2);
        assert_eq!(of_sessions(&rows, |_| true)[0].verdict, "not_needed");
        rows[8] = row("latency", Verdict::NotNeeded, 2.2);
        assert_eq!(of_sessions(&rows, |_| true)[0].verdict, "named");
        // of the other sign it supports nothing
        let mut rows = weak;
        rows[7] = row("latency", Verdict::Named, -2.2);
        assert_eq!(of_sessions(&rows, |_| true)[0].verdict, "not_needed");
    }

    #[test]
    fn only_what_is_named_is_taken_out_of_recordings() {
        let mut pooling = Pooling::default();
        for k in 0..80 {
            let own = [row("latency", Verdict::Named, 5.0), row("lift", Verdict::NotNeeded, 1.9)];
            pooling.add(member(k, "a", "x", k), &own);
        }
        let causes = pooling.causes();
        let effects: Vec<_> = causes.iter().filter_map(SharedCause::effect).collect();
        let [late] = &effects[..] else { panic!("{effects:?}") };
        assert_eq!(causes.len(), 2);
        assert_eq!((late.level, late.group.as_str(), late.sessions), (Level::Bike, "a", 80));
        assert!((late.value - 0.05).abs() < 1e-12 && late.std_error > COMMON_SHARE * 0.05);
    }

    #[test]
    fn every_session_is_counted_and_those_left_out_are_listed() {
        let mut rows = vec![row("latency", Verdict::Named, -6.0); 6];
        rows.extend(vec![row("latency", Verdict::NotNeeded, -6.0); 4]);
        rows.extend(vec![row("latency", Verdict::NotIdentifiable, 0.0); 7]);
        rows.push(row("lift", Verdict::NotNeeded, 0.0));
        // off the road nothing is looked for that sessions share
        rows.push(row("fork_friction", Verdict::Named, 6.0));
        let rows = of_sessions(&rows, |k| k != 3);
        let [own] = &rows[..] else { panic!("{rows:?}") };
        assert_eq!(own.verdict, "named");
        for part in [
            "the velocity comes early: shared by 10 of 18 sessions, identified in 6 of them",
            "counted with twice their error, as they have an unexplained misfit: s3",
            "left out, not identifiable in them: s10, s11, s12, s13, s14 and 2 more",
            "left out, not looked for: s17",
        ] {
            assert!(own.reason.contains(part), "{part}: {}", own.reason);
        }
    }

    #[test]
    fn a_session_with_something_unexplained_has_twice_its_error() {
        let estimates = vec![row("latency", Verdict::NotNeeded, 5.0); 8];
        let width = |sound: bool| {
            let rows = of_sessions(&estimates, |_| sound);
            rows[0].value.zip(rows[0].ci95_high).map_or(f64::NAN, |(value, high)| high - value)
        };
        let of_mean = |width: f64| (width / 1.96).powi(2) - (COMMON_SHARE * 0.05).powi(2);
        assert!((of_mean(width(false)) / of_mean(width(true)) - 4.0).abs() < 1e-6);
    }
}
