//! Effects that several sessions share, on disk: `diagnose` writes them beside its extended models, and
//! `run --model` takes them out of every session of their group.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Effect, Level};
use crate::contract::file_error::{FileError, FileName};
use crate::contract::key_error::KeyError;
use crate::contract::schema::with_hint;

/// Name of the file, in the folder of the extended models. Those lie a folder deeper, whatever a session
/// is called.
pub(crate) const FILE: &str = "pooled.toml";

/// An effect that several sessions share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PooledEffect {
    /// Name of the effect.
    pub effect: String,
    /// Common property of its sessions.
    pub level: Level,
    /// Which of those, as [`Level::group`] has it; empty for the fleet and for sessions that do not say where
    /// or when they were.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// Size, in `unit`.
    pub value: f64,
    /// Standard error of the size, in `unit`.
    pub std_error: f64,
    /// That of the effect.
    pub unit: String,
    /// Number of sessions that the size comes from.
    pub sessions: usize,
}

/// Effects shared by the sessions of an output.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PooledEffects {
    /// Every effect and group.
    #[serde(default)]
    pub pooled: Vec<PooledEffect>,
}

impl PooledEffects {
    pub fn to_toml(&self) -> String {
        let text = toml::to_string(self).unwrap_or_default();
        format!(
            "# What diagnosed sessions share, found by `roadbench diagnose`; for `run --model`.\n{text}"
        )
    }

    /// Checks a file's text; `name` is for messages.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, FileError> {
        let file = FileName::new("pooled effects", name);
        let all: PooledEffects =
            toml::from_str(text).map_err(|e| file.wrong(with_hint(&e.to_string())))?;
        let mut levels: BTreeMap<&str, (Level, Vec<&str>)> = BTreeMap::new();
        for (i, one) in all.pooled.iter().enumerate() {
            one.check().map_err(|(key, e)| file.wrong(format!("pooled[{i}].{key}: {e}")))?;
            let (level, groups) = levels.entry(&one.effect).or_insert((one.level, Vec::new()));
            // else two sizes would be meant for one session
            if *level != one.level {
                let (a, b) = (level.name(), one.level.name());
                let why = format!("{} is pooled by {a} and by {b}; choose one", one.effect);
                return Err(file.wrong(format!("pooled[{i}].level: {why}")));
            }
            if groups.contains(&one.group.as_str()) {
                let why = format!("{} is there twice for this group", one.effect);
                return Err(file.wrong(format!("pooled[{i}].group: {why}")));
            }
            groups.push(&one.group);
        }
        Ok(all)
    }
}

impl PooledEffect {
    /// Checks what the types do not.
    ///
    /// # Errors
    /// The key and what is wrong with it.
    fn check(&self) -> Result<(), (&'static str, KeyError)> {
        let effect = Effect::named(&self.effect).map_err(|e| ("effect", e))?;
        effect.check_size(self.value).map_err(|e| ("value", e))?;
        match (self.level, self.group.is_empty()) {
            (Level::Session, _) => {
                let why = "sessions share nothing at this level; write fleet, bike, site or night";
                Err(("level", why.into()))
            }
            (Level::Fleet, false) => Err(("group", "the fleet has no groups".into())),
            (Level::Bike, true) => Err(("group", "the motorcycle's id is missing".into())),
            _ => Ok(()),
        }
    }

    /// Where the size comes from, in words.
    pub fn origin(&self) -> String {
        let (n, group) = (self.sessions, &self.group);
        match (self.level, group.as_str()) {
            (Level::Bike, _) => format!("pooled over {n} sessions of motorcycle {group}"),
            (Level::Site, "") => format!("pooled over {n} sessions that name no site"),
            (Level::Site, _) => format!("pooled over {n} sessions at {group}"),
            (Level::Night, "") => format!("pooled over {n} sessions that name no start"),
            (Level::Night, _) => format!("pooled over {n} sessions of {group}"),
            (Level::Fleet | Level::Session, _) => format!("pooled over {n} sessions of the fleet"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn late(level: Level, group: &str) -> PooledEffect {
        PooledEffect {
            effect: "latency".to_owned(),
            level,
            group: group.to_owned(),
            value: 0.02,
            std_error: 0.001,
            unit: "s".to_owned(),
            sessions: 6,
        }
    }

    fn refused(pooled: &[PooledEffect]) -> String {
        let text = PooledEffects { pooled: pooled.to_vec() }.to_toml();
        PooledEffects::parse(&text, "p.toml").expect_err("refused").to_string()
    }

    #[test]
    fn what_is_written_is_read_back() {
        let pooled = [("a", 0.02), ("b", 0.03)]
            .map(|(group, value)| PooledEffect { value, ..late(Level::Bike, group) })
            .to_vec();
        let all = PooledEffects { pooled };
        assert_eq!(PooledEffects::parse(&all.to_toml(), "p.toml").ok(), Some(all));
        let fleet = PooledEffects { pooled: vec![late(Level::Fleet, "")] };
        assert!(!fleet.to_toml().contains("group"), "{}", fleet.to_toml());
        assert_eq!(PooledEffects::parse(&fleet.to_toml(), "p.toml").ok(), Some(fleet));
        assert_eq!(PooledEffects::parse("", "p.toml").ok(), Some(PooledEffects::default()));
    }

    #[test]
    fn a_refusal_names_the_file_and_the_key() {
        let named =
            |effect: &str| PooledEffect { effect: effect.to_owned(), ..late(Level::Fleet, "") };
        let sized = PooledEffect { value: 7.0, ..late(Level::Fleet, "") };
        let cases = [
            (
                vec![named("latancy")],
                "pooled[0].effect: no effect is called `latancy`; did you mean `latency`?",
            ),
            (vec![sized], "pooled[0].value: 7 s is not between"),
            (vec![late(Level::Session, "s1")], "pooled[0].level: sessions share nothing"),
            (vec![late(Level::Fleet, "all")], "pooled[0].group: the fleet has no groups"),
            (vec![late(Level::Bike, "")], "pooled[0].group: the motorcycle's id is missing"),
            (
                vec![late(Level::Bike, "a"), late(Level::Fleet, "")],
                "pooled[1].level: latency is pooled by bike and by fleet",
            ),
            (
                vec![late(Level::Night, "d"), late(Level::Night, "d")],
                "pooled[1].group: latency is there twice",
            ),
        ];
        for (pooled, says) in cases {
            let message = refused(&pooled);
            assert!(message.contains(&format!("p.toml: {says}")), "{message}");
        }
        let text = late_text("level = \"fleat\"");
        let message = PooledEffects::parse(&text, "p.toml").expect_err("no such level").to_string();
        assert!(message.contains("p.toml") && message.contains("fleat"), "{message}");
        let message = PooledEffects::parse(&late_text("levle = \"fleet\""), "p.toml");
        assert!(message.is_err_and(|e| e.to_string().contains("`levle`")));
    }

    fn late_text(level: &str) -> String {
        PooledEffects { pooled: vec![late(Level::Fleet, "")] }
            .to_toml()
            .replace("level = \"fleet\"", level)
    }
}
