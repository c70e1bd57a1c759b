//! What is declared of an effect.

use serde::{Deserialize, Serialize};

use crate::contract::channel::Channel;
use crate::contract::session::Meta;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Every kind of braking.
pub(crate) const BRAKING: &[ManoeuvreKind] =
    &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking, ManoeuvreKind::CombinedBraking];

/// Level of an effect: the group for which it should be the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    Session,
    /// A motorcycle: a part of it, or a sensor on it.
    Bike,
    Site,
    /// A night of the fleet: the weather, a rider's day.
    Night,
    Fleet,
}

impl Level {
    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Level::Session => "session",
            Level::Bike => "bike",
            Level::Site => "site",
            Level::Night => "night",
            Level::Fleet => "fleet",
        }
    }

    /// The group of this level that a session belongs to: its own id, its motorcycle's, its site, the date of
    /// its start; of the fleet nothing, and nothing either where the session does not say.
    pub fn group<'a>(self, of: &SessionRef<'a>) -> &'a str {
        match self {
            Level::Session => of.session_id,
            Level::Bike => of.bike_id,
            Level::Site => of.site.unwrap_or_default(),
            Level::Night => {
                let start = of.start_time.unwrap_or_default();
                start.char_indices().nth(DATE).map_or(start, |(end, _)| &start[..end])
            }
            Level::Fleet => "",
        }
    }
}

/// Characters of the date that an RFC 3339 time starts with.
const DATE: usize = 10;

/// Properties of a session that decide its groups.
#[derive(Debug, Clone, Copy, Default)]
pub struct SessionRef<'a> {
    pub session_id: &'a str,
    pub bike_id: &'a str,
    /// Where it was ridden.
    pub site: Option<&'a str>,
    /// When it began, RFC 3339.
    pub start_time: Option<&'a str>,
}

impl<'a> From<&'a Meta> for SessionRef<'a> {
    fn from(meta: &'a Meta) -> Self {
        SessionRef {
            session_id: &meta.session_id,
            bike_id: &meta.bike_id,
            site: meta.site.as_deref(),
            start_time: meta.start_time.as_deref(),
        }
    }
}

/// The words, the unit and the prior of an effect: what its file declares beside its formula.
#[derive(Debug, Clone, Copy)]
pub struct EffectSpec {
    /// Sentence where its size has the sign of `typical`, as a main clause for reports.
    pub sentence: &'static str,
    /// Sentence where it has the other sign; `sentence` again where that is true of both, as of a
    /// zero that is off to either side.
    pub opposite: &'static str,
    /// Unit of its size.
    pub unit: &'static str,
    /// Its usual size with its usual sign: the scale of steps and of the prior.
    pub typical: f64,
    /// Smallest and largest size that is physically plausible.
    pub bounds: [f64; 2],
    /// Where usual size and bounds come from.
    pub source: &'static str,
    /// Where it enters the model.
    pub enters: &'static str,
    /// Channels without which it is not identifiable.
    pub channels: &'static [Channel],
    /// Manoeuvres of which at least one kind must have been ridden.
    pub kinds: &'static [ManoeuvreKind],
    /// Effects or base parameters that change a ride alike; one of two effects declares it
    /// ([`Effect::confusions`](super::Effect::confusions)).
    pub confounded_with: &'static [&'static str],
    /// The riding or the channel that tells it from those.
    pub separate_by: &'static str,
    pub level: Level,
    /// Whether the built-in ride plans show next to nothing of it at its usual size.
    pub faint: bool,
}

impl EffectSpec {
    /// Sentence of an effect with a size.
    pub fn sentence_of(&self, size: f64) -> &'static str {
        by_sign(size, self.typical, [self.sentence, self.opposite])
    }
}

/// The first of two sentences, or the second where a size has not the sign of a usual one; a size that is
/// zero or not known has the first.
pub(crate) fn by_sign(size: f64, typical: f64, [same, other]: [&'static str; 2]) -> &'static str {
    if size * typical < 0.0 { other } else { same }
}
