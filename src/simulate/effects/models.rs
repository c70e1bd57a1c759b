//! What each session has: its own effects, and those that it shares with others. `run --model` takes them out of
//! the recordings, `export --model` puts those of the tyres into the tyres.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use super::extended_model::{Estimate, ExtendedModel};
use super::pooled_effects::PooledEffects;
use super::remove::remove;
use super::{ALL, Effect, Level, ModelError, SessionRef};
use crate::contract::bike::Bike;
use crate::contract::key_error::KeyError;
use crate::contract::session::Session;
use crate::contract::warning::Warning;

/// Where a session's own size comes from, in words.
const OWN: &str = "its own";
/// Code of the warning that says what was taken out of a recording.
const APPLIED: &str = "model_applied";
/// Start of its message.
const TAKEN_OUT: &str = "removed from the recording";

/// Known properties of the sessions of a run. By effect a session has the size that it shares with others where
/// there is one, else its own; one that was not diagnosed has the shared ones only.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Models {
    /// By effect and group.
    #[serde(default)]
    shared: Vec<Shared>,
    /// Sizes by motorcycle, session and effect.
    #[serde(default)]
    own: BTreeMap<String, BTreeMap<String, BTreeMap<String, Size>>>,
}

/// A size and its standard error, in the unit of the effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Size {
    value: f64,
    std_error: f64,
}

/// An effect that every session of a group has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Shared {
    effect: String,
    level: Level,
    /// As of [`Level::group`].
    group: String,
    size: Size,
    /// Where it comes from, in words.
    origin: String,
}

/// An effect that a session has.
#[derive(Debug, Clone, Copy)]
pub struct Has<'a> {
    pub effect: &'static Effect,
    /// In the unit of the effect.
    pub value: f64,
    /// Its standard error, in the unit of the effect.
    pub std_error: f64,
    /// Where that comes from, in words.
    pub origin: &'a str,
}

impl Models {
    /// Of one diagnosed session. What usually belongs to the motorcycle is taken to be the same in all its
    /// sessions, the rest to be this session's: one session says no more.
    pub fn of_one(model: ExtendedModel) -> Self {
        let is_bikes = |name: &str| Effect::named(name).is_ok_and(|e| e.level == Level::Bike);
        let share = |(name, size): (&String, &Size)| Shared {
            effect: name.clone(),
            level: Level::Bike,
            group: model.bike_id.clone(),
            size: *size,
            origin: format!("found in {}, usually the motorcycle's", model.session_id),
        };
        let own = sizes(&model);
        let shared = own.iter().filter(|(name, _)| is_bikes(name)).map(share).collect();
        let sessions = BTreeMap::from([(model.session_id, own)]);
        Models { shared, own: BTreeMap::from([(model.bike_id, sessions)]) }
    }

    /// Of a diagnosis of many sessions, and what they share.
    ///
    /// # Errors
    /// A session that has two models.
    pub fn of_many(
        models: impl IntoIterator<Item = ExtendedModel>,
        shared: &PooledEffects,
    ) -> Result<Self, KeyError> {
        let mut own: BTreeMap<String, BTreeMap<_, _>> = BTreeMap::new();
        for model in models {
            let sizes = sizes(&model);
            let ExtendedModel { session_id, bike_id, .. } = model;
            let sessions = own.entry(bike_id).or_default();
            if sessions.insert(session_id.clone(), sizes).is_some() {
                return Err(KeyError::Values(format!(
                    "session `{session_id}` has two models; remove one"
                )));
            }
        }
        let share = |one: &super::pooled_effects::PooledEffect| Shared {
            effect: one.effect.clone(),
            level: one.level,
            group: one.group.clone(),
            size: Size { value: one.value, std_error: one.std_error },
            origin: one.origin(),
        };
        Ok(Models { shared: shared.pooled.iter().map(share).collect(), own })
    }

    /// Effects of a session, in order of the effects.
    pub fn of(&self, who: &SessionRef<'_>) -> Vec<Has<'_>> {
        let own = self.own.get(who.bike_id).and_then(|sessions| sessions.get(who.session_id));
        let has = |effect: &'static Effect| {
            let own = own.and_then(|sizes| sizes.get(effect.name));
            let is_its = |s: &&Shared| s.effect == effect.name && s.group == s.level.group(who);
            let shared = self.shared.iter().find(is_its);
            let (size, origin) = match shared {
                Some(shared) => (shared.size, shared.origin.as_str()),
                None => (*own?, OWN),
            };
            Some(Has { effect, value: size.value, std_error: size.std_error, origin })
        };
        ALL.iter().filter_map(has).collect()
    }

    /// Everything that [`Models::apply`] does to a session as text, for the hash of what its tables are made
    /// from; empty where that is nothing. Where site or start are not known before the log is read, it has
    /// what every site or night shares: rather too much than to overlook a change.
    pub fn text_of(&self, who: &SessionRef<'_>) -> String {
        let mut text = String::new();
        for Has { effect, value, origin, .. } in self.of(who) {
            // writing to a String cannot fail; a number's shortest text says all of it
            let _ = writeln!(text, "{} = {value:?}, {origin}", effect.name);
        }
        let is_open = |level: Level| match level {
            Level::Site => who.site.is_none(),
            Level::Night => who.start_time.is_none(),
            Level::Session | Level::Bike | Level::Fleet => false,
        };
        for s in self.shared.iter().filter(|s| is_open(s.level)) {
            let _ = writeln!(text, "{} = {:?} perhaps, {}", s.effect, s.size.value, s.origin);
        }
        text
    }

    /// Takes out of a session what it has, and says what that was.
    pub fn apply(&self, session: &mut Session, bike: &mut Bike) -> Vec<Warning> {
        let meta = session.meta.clone();
        let all = self.of(&SessionRef::from(&meta));
        if all.is_empty() {
            return Vec::new();
        }
        let mut error = ModelError::default();
        for Has { effect, value, .. } in &all {
            (effect.set)(&mut error, *value);
        }
        let stays = remove(&error, session, bike);
        let (left, taken): (Vec<Has<'_>>, Vec<Has<'_>>) =
            all.into_iter().partition(|has| stays.contains(&has.effect.name));
        let warning = |code, says: &str, which: &[Has<'_>]| {
            let list: Vec<String> =
                which.iter().map(|has| format!("{} ({})", has.effect.name, has.origin)).collect();
            (!which.is_empty()).then(|| Warning {
                stage: "ingest",
                code,
                channel: None,
                count: 1,
                time: None,
                message: format!("{says}: {}", list.join(", ")),
            })
        };
        let taken = warning(APPLIED, TAKEN_OUT, &taken);
        let left = warning(
            "model_left",
            "cannot be taken out of a recording, stays in the coefficients",
            &left,
        );
        taken.into_iter().chain(left).collect()
    }
}

/// Whether a session's warning (its code and message) says that an effect was taken out of its recording.
pub(crate) fn was_taken_out(code: &str, message: &str, effect: &Effect) -> bool {
    let list = message.strip_prefix(TAKEN_OUT).unwrap_or_default();
    let starts = |before: &str| list.contains(&format!("{before}{} (", effect.name));
    code == APPLIED && (starts(": ") || starts("), "))
}

fn sizes(model: &ExtendedModel) -> BTreeMap<String, Size> {
    let size = |found: &Estimate| Size { value: found.value, std_error: found.std_error };
    model.effects.iter().map(|(name, found)| (name.clone(), size(found))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;
    use crate::simulate::effects::pooled_effects::PooledEffect;
    use crate::simulate::scenario::Scenario;

    fn model(session_id: &str, bike_id: &str, effects: &[(&str, f64)]) -> ExtendedModel {
        let estimate = |value| Estimate { value, std_error: 0.001, unit: String::new() };
        ExtendedModel {
            session_id: session_id.to_owned(),
            bike_id: bike_id.to_owned(),
            effects: effects.iter().map(|(n, v)| ((*n).to_owned(), estimate(*v))).collect(),
            ..ExtendedModel::default()
        }
    }

    fn pooled(effect: &str, level: Level, group: &str, value: f64) -> PooledEffect {
        PooledEffect {
            effect: effect.to_owned(),
            level,
            group: group.to_owned(),
            value,
            std_error: 0.001,
            unit: String::new(),
            sessions: 4,
        }
    }

    fn who<'a>(session_id: &'a str, bike_id: &'a str) -> SessionRef<'a> {
        let (site, start_time) = (Some("x"), Some("2026-05-01T20:00:00Z"));
        SessionRef { session_id, bike_id, site, start_time }
    }

    #[test]
    fn each_level_reaches_its_own_sessions() {
        let own = [model("s1", "a", &[("steer_zero", 0.004), ("latency", 0.03)])];
        let shared = PooledEffects {
            pooled: vec![
                pooled("latency", Level::Fleet, "", 0.02),
                pooled("roll_zero", Level::Bike, "a", 0.005),
                pooled("road_grade", Level::Site, "x", 0.003),
                pooled("wind", Level::Night, "2026-05-01", 1.0),
            ],
        };
        let models = Models::of_many(own, &shared).expect("models");
        let has = |who: &SessionRef<'_>| -> Vec<(&str, f64, &str)> {
            models.of(who).into_iter().map(|h| (h.effect.name, h.value, h.origin)).collect()
        };
        let late = ("latency", 0.02, "pooled over 4 sessions of the fleet");
        let lean = ("roll_zero", 0.005, "pooled over 4 sessions of motorcycle a");
        let slope = ("road_grade", 0.003, "pooled over 4 sessions at x");
        let wind = ("wind", 1.0, "pooled over 4 sessions of 2026-05-01");
        let zero = ("steer_zero", 0.004, "its own");
        assert_eq!(has(&who("s1", "a")), [slope, wind, zero, lean, late]);
        // never diagnosed
        assert_eq!(has(&who("s2", "a")), [slope, wind, lean, late]);
        assert_eq!(has(&who("s2", "b")), [slope, wind, late]);
        let elsewhere = SessionRef { site: Some("y"), start_time: None, ..who("s3", "b") };
        assert_eq!(has(&elsewhere), [late]);
        let unread = SessionRef { site: None, start_time: None, ..who("s1", "b") };
        let hashed = models.text_of(&unread);
        assert_eq!(hashed.lines().count(), 3, "{hashed}");
        assert!(hashed.contains("road_grade = 0.003 perhaps, pooled over"), "{hashed}");
        // the same name on another motorcycle is another session
        assert_eq!(has(&who("s1", "b")), [slope, wind, late]);
    }

    #[test]
    fn of_one_session_goes_to_the_others_what_is_usually_the_motorcycles() {
        let models = Models::of_one(model("s1", "a", &[("latency", 0.02), ("wind", 1.0)]));
        let told = |who: &SessionRef<'_>| models.text_of(who);
        let found = "latency = 0.02, found in s1, usually the motorcycle's\n";
        assert_eq!(told(&who("s1", "a")), format!("wind = 1.0, its own\n{found}"));
        assert_eq!(told(&who("s2", "a")), found);
        assert_eq!(told(&who("s1", "b")), "");
    }

    #[test]
    fn a_warning_tells_what_was_taken_out() {
        let mut session = Session::new(Meta::default(), 100.0, 3);
        session.meta.bike_id = "a".to_owned();
        session.meta.session_id = "s1".to_owned();
        let sizes = [("latency", 0.03), ("twisting_stiffness", 0.01), ("friction_load", 0.1)];
        let models = Models::of_one(model("s1", "a", &sizes));
        let mut bike = Scenario::builtin("perfect").expect("scenario").machine(0).bike;
        let warnings = models.apply(&mut session, &mut bike);
        let taken = |name: &str| {
            let effect = Effect::named(name).expect("known");
            warnings.iter().any(|w| was_taken_out(w.code, &w.message, effect))
        };
        assert!(taken("latency") && taken("twisting_stiffness"), "{warnings:?}");
        assert!(!taken("friction_load") && !taken("wind"), "{warnings:?}");
        let has = models.of(&SessionRef::from(&session.meta));
        assert!(has.iter().all(|h| h.std_error == 0.001) && has.len() == 3);
    }

    #[test]
    fn a_session_has_one_model() {
        let twice = [model("s1", "a", &[]), model("s1", "a", &[])];
        let message =
            Models::of_many(twice, &PooledEffects::default()).expect_err("two").to_string();
        assert!(message.contains("`s1`"), "{message}");
    }

    #[test]
    fn models_pass_through_text() {
        let shared =
            PooledEffects { pooled: vec![pooled("latency", Level::Fleet, "", 1.0 / 49.0)] };
        let own =
            [model("s.1 = \"x\"", "a", &[("steer_zero", -1.0 / 237.0)]), model("t", "a", &[])];
        let models = Models::of_many(own, &shared).expect("models");
        let text = toml::to_string(&models).expect("text");
        assert_eq!(toml::from_str::<Models>(&text).expect("back"), models);
    }
}
