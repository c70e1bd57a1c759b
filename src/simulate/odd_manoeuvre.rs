//! Manoeuvres that are not as the others of their ride: a slippery place under one stop, a gust during one
//! coasting, a wheel that locks once.
//!
//! ```toml
//! [[odd_manoeuvres]]
//! kind = "front_braking"
//! number = 2            # the second of the ride
//! friction = -0.3       # 30 % less than elsewhere
//! ```
//!
//! A plan is turned into phases first; [`with_odd`] then changes the phases of the odd manoeuvres, so that plan and
//! rider know nothing of them.

use serde::{Deserialize, Serialize};

use super::conditions::Conditions;
use super::plan::Phase;
use crate::contract::key_error::KeyError;

/// Kinds of manoeuvre that can be odd.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OddKind {
    /// Braked with the front wheel alone.
    FrontBraking,
    /// Braked with the rear wheel alone.
    RearBraking,
    /// In neutral.
    Coasting,
    /// In a corner at constant speed.
    Cornering,
}

/// A manoeuvre that is not as the others of its ride.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OddManoeuvre {
    pub kind: OddKind,
    /// Which of its kind, from 1; one that is not ridden changes nothing.
    pub number: usize,
    /// Friction of the road under it, relative difference from elsewhere.
    #[serde(default)]
    pub friction: f64,
    /// Head wind while it lasts, m/s.
    #[serde(default)]
    pub head_wind: f64,
    /// Slip ratio (negative) at which the rider lets the brake go, instead of the plan's.
    pub slip: Option<f64>,
}

impl OddManoeuvre {
    /// # Errors
    /// A number is not plausible; the sentence names the key.
    fn check(&self) -> Result<(), KeyError> {
        let within =
            |key: &str, value: f64, low: f64, high: f64| match (low..=high).contains(&value) {
                true => Ok(()),
                false => Err(KeyError::Values(format!(
                    "`{key}` = {value} is not between {low} and {high}"
                ))),
            };
        within("number", self.number as f64, 1.0, 1e6)?;
        within("friction", self.friction, -0.95, 1.0)?;
        within("head_wind", self.head_wind, -30.0, 30.0)?;
        within("slip", self.slip.unwrap_or(0.0), -1.0, 0.0)?;
        let braked = [OddKind::FrontBraking, OddKind::RearBraking].contains(&self.kind);
        match self.slip.is_some() && !braked {
            true => {
                Err(KeyError::Values("`slip` is of front_braking and rear_braking only".into()))
            }
            false => Ok(()),
        }
    }
}

/// Checks a scenario's odd manoeuvres.
///
/// # Errors
/// A number is not plausible, or two entries are of one manoeuvre; the sentence names the key.
pub(crate) fn check(all: &[OddManoeuvre]) -> Result<(), KeyError> {
    for (i, odd) in all.iter().enumerate() {
        odd.check()?;
        if all[..i].iter().any(|o| (o.kind, o.number) == (odd.kind, odd.number)) {
            let number = odd.number;
            return Err(KeyError::Values(format!(
                "`number` = {number} stands twice for one kind: join the two entries"
            )));
        }
    }
    Ok(())
}

impl OddKind {
    /// The kind of a phase, if it can be odd.
    fn of(phase: &Phase) -> Option<OddKind> {
        match *phase {
            Phase::Brake { ramp: [front, rear], .. } => match (front > 0.0, rear > 0.0) {
                (true, false) => Some(OddKind::FrontBraking),
                (false, true) => Some(OddKind::RearBraking),
                _ => None,
            },
            Phase::Coast { .. } => Some(OddKind::Coasting),
            Phase::Corner { .. } => Some(OddKind::Cornering),
            _ => None,
        }
    }
}

/// The phases with what is odd in some of them.
pub(crate) fn with_odd(phases: Vec<Phase>, odd: &[OddManoeuvre]) -> Vec<Phase> {
    if odd.is_empty() {
        return phases;
    }
    let mut counts = [0_usize; 4];
    let mut out = Vec::with_capacity(phases.len() + 2 * odd.len());
    for mut phase in phases {
        let found = OddKind::of(&phase).and_then(|kind| {
            counts[kind as usize] += 1;
            odd.iter().find(|o| o.kind == kind && o.number == counts[kind as usize])
        });
        let Some(found) = found else {
            out.push(phase);
            continue;
        };
        if let (Phase::Brake { slip, .. }, Some(wanted)) = (&mut phase, found.slip) {
            *slip = wanted;
        }
        let conditions = Conditions { lost_grip: -found.friction, head_wind: found.head_wind };
        out.extend([
            Phase::Meet { conditions },
            phase,
            Phase::Meet { conditions: Conditions::default() },
        ]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_manoeuvre_of_the_number_is_odd() {
        let stop = |rear: f64| Phase::Brake {
            ramp: [1e6 * (1.0 - rear), 1e6 * rear],
            peak: [1e7; 2],
            until: 1.0,
            slip: -0.2,
        };
        let odd = OddManoeuvre {
            kind: OddKind::FrontBraking,
            number: 2,
            friction: -0.3,
            head_wind: 0.0,
            slip: Some(-0.9),
        };
        odd.check().expect("plausible");
        let phases = with_odd(vec![stop(0.0), stop(1.0), stop(0.0), stop(0.0)], &[odd]);
        let slips: Vec<f64> = phases
            .iter()
            .filter_map(|p| if let Phase::Brake { slip, .. } = p { Some(*slip) } else { None })
            .collect();
        assert_eq!(slips, [-0.2, -0.2, -0.9, -0.2]);
        let met =
            |p: &Phase| if let Phase::Meet { conditions } = p { Some(*conditions) } else { None };
        assert_eq!(phases.iter().position(|p| met(p).is_some()), Some(2));
        assert_eq!(met(&phases[2]).map(|c| c.lost_grip), Some(0.3));
        assert_eq!(met(&phases[4]), Some(Conditions::default()));
        for wrong in [
            OddManoeuvre { number: 0, ..odd },
            OddManoeuvre { friction: -1.0, ..odd },
            OddManoeuvre { slip: Some(0.1), ..odd },
            OddManoeuvre { kind: OddKind::Coasting, ..odd },
        ] {
            assert!(wrong.check().is_err(), "{wrong:?}");
        }
        let other = OddManoeuvre { kind: OddKind::RearBraking, slip: None, ..odd };
        assert!(check(&[odd, other]).is_ok() && check(&[odd, other, odd]).is_err());
    }
}
