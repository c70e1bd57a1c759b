//! Band-pass by FFT, differentiation by FIR, integration by the trapezoid rule.
//!
//! Assumes channels on one uniform clock ([`ingest`](crate::ingest) made it). Nothing is
//! shifted in time: every kernel is symmetric and applied about its centre.
//!
//! - The *high cut* removes what is above the motion of the bike (engine, road, sensor
//!   noise). Gain one half at the cut, one below 0.6 and zero above 1.4 times it.
//! - The *low cut*, off unless the pipeline file asks for it, subtracts the slow mean of a
//!   channel whose mean is only sensor bias. Gain zero at 0 Hz, one above twice the cut.
//! - Each contiguous run of samples is filtered by itself; a gap neither leaks nor is bridged.
//! - Runs shorter than [`SHORTEST`] cannot be separated from noise: they become missing, with a warning.
//!
//! Left as they are, unless the pipeline names them: `throttle` (steps, and bounded by 0 and 1:
//! a filtered step would leave them), `latitude`, `longitude`, `altitude` (filtered by the
//! receiver, degrees), temperatures and tyre pressures (slow and quantised). `gear` is never filtered: it
//! is a label. A `yaw` that wraps is run on first, so that the wrap is not smeared.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::{Deserialize, Deserializer, Serialize};

use crate::contract::channel::Channel;
use crate::contract::key_error::KeyError;
use crate::contract::schema::closest;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::statistics::angles::unwrap;
use crate::statistics::runs::next_run;

pub(crate) mod band;
mod fir;

pub(crate) use band::{high_cut, remove_slow};
pub(crate) use fir::{derivative, integral};

/// Shortest run that is filtered, s: a manoeuvre takes longer, a few stray samples do not.
pub(crate) const SHORTEST: f64 = 0.3;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// High cut where the channel has none of its own, Hz; at or above half the rate it does
    /// nothing.
    #[serde(deserialize_with = "positive")]
    pub high_cut: f64,
    /// Own cuts per channel.
    #[serde(deserialize_with = "bands")]
    pub channel: BTreeMap<String, Band>,
}

/// The pass band of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Band {
    /// Low cut, Hz; 0 keeps everything down to the mean.
    #[serde(default)]
    pub low_cut: f64,
    /// High cut, Hz; the stage's where absent.
    pub high_cut: Option<f64>,
}

impl Default for Config {
    fn default() -> Self {
        Config { high_cut: 20.0, channel: BTreeMap::new() }
    }
}

/// Filters every channel in place, each contiguous run of samples by itself.
///
/// Warns of runs that were too short (`short_run`) and are now missing.
pub fn run(session: &mut Session, config: &Config) -> Vec<Warning> {
    let rate = session.rate;
    let mut warnings = Vec::new();
    let channels: Vec<Channel> = session.channels().collect();
    for channel in channels {
        let Some((low, high)) = config.band(channel) else { continue };
        if low <= 0.0 && high >= 0.5 * rate {
            continue;
        }
        let Some(x) = session.get_mut(channel) else { continue };
        if channel == Channel::Yaw {
            unwrap(x);
        }
        let short = filter(x, rate, low, high);
        if let Some(first) = short.first() {
            let count: usize = short.iter().map(Range::len).sum();
            warnings.push(Warning {
                stage: "filter",
                code: "short_run",
                channel: Some(channel),
                count,
                time: Some(first.start as f64 / rate),
                message: format!(
                    "{channel}: {count} samples in {} pieces shorter than {SHORTEST} s, each \
                     between gaps, cannot be filtered and count as missing",
                    short.len()
                ),
            });
        }
    }
    warnings
}

impl Config {
    /// Low and high cut of a channel, Hz; `None` where it is not filtered.
    fn band(&self, channel: Channel) -> Option<(f64, f64)> {
        use Channel as C;
        match (self.channel.get(channel.name()), channel) {
            (_, C::Gear | C::LapNumber) => None,
            (Some(band), _) => Some((band.low_cut, band.high_cut.unwrap_or(self.high_cut))),
            (None, C::Throttle | C::Latitude | C::Longitude | C::Altitude | C::Grade) => None,
            (None, C::AirTemperature | C::TyreTemperatureFront | C::TyreTemperatureRear) => None,
            (None, C::TyrePressureFront | C::TyrePressureRear) => None,
            (None, _) => Some((0.0, self.high_cut)),
        }
    }
}

/// Filters each run of `x`; runs that are too short become NaN and are given back.
fn filter(x: &mut [f64], rate: f64, low: f64, high: f64) -> Vec<Range<usize>> {
    let mut short = Vec::new();
    let mut next = 0;
    while let Some(run) = next_run(x, next) {
        next = run.end;
        let samples = &mut x[run.clone()];
        if (samples.len() as f64) < SHORTEST * rate {
            samples.fill(f64::NAN);
            short.push(run);
            continue;
        }
        if low > 0.0 {
            remove_slow(samples, rate, low);
        }
        if high < 0.5 * rate {
            high_cut(samples, rate, high);
        }
    }
    short
}

fn positive<'de, D: Deserializer<'de>>(input: D) -> Result<f64, D::Error> {
    let cut = f64::deserialize(input)?;
    if cut > 0.0 && cut.is_finite() {
        Ok(cut)
    } else {
        Err(serde::de::Error::custom(format!("high_cut = {cut} must be a positive number of Hz")))
    }
}

/// Reads and checks the table of bands: known channels, sensible cuts.
fn bands<'de, D: Deserializer<'de>>(input: D) -> Result<BTreeMap<String, Band>, D::Error> {
    let bands = BTreeMap::<String, Band>::deserialize(input)?;
    for (name, band) in &bands {
        check_band(name, band).map_err(serde::de::Error::custom)?;
    }
    Ok(bands)
}

fn check_band(name: &str, band: &Band) -> Result<(), KeyError> {
    match Channel::from_name(name) {
        None => {
            let near = closest(name, Channel::ALL.iter().map(|c| c.name()));
            let hint = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            return Err(KeyError::Values(format!("filter.channel: no channel `{name}`{hint}")));
        }
        Some(Channel::Gear) => {
            return Err(KeyError::Values(
                "filter.channel.gear: the gear is a label and cannot be filtered".into(),
            ));
        }
        Some(Channel::LapNumber) => {
            return Err(
                "filter.channel.lap_number: a lap's number is a label and cannot be filtered"
                    .into(),
            );
        }
        Some(_) => {}
    }
    let Band { low_cut, high_cut } = *band;
    if !(low_cut >= 0.0 && low_cut.is_finite()) {
        return Err(KeyError::Values(format!(
            "filter.channel.{name}: low_cut = {low_cut} must be 0 or more Hz"
        )));
    }
    match high_cut {
        Some(high) if !(high > 0.0 && high.is_finite()) => Err(KeyError::Values(format!(
            "filter.channel.{name}: high_cut = {high} must be a positive number of Hz"
        ))),
        Some(high) if high <= low_cut => Err(KeyError::Values(format!(
            "filter.channel.{name}: low_cut = {low_cut} Hz must be below high_cut = {high} Hz"
        ))),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    fn noise(n: usize, seed: u64) -> Vec<f64> {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        (0..n).map(|_| rng.random::<f64>() - 0.5).collect()
    }

    fn session(x: Vec<f64>, channel: Channel) -> Session {
        let mut s = Session::new(Meta::default(), 100.0, x.len());
        s.set(channel, x);
        s
    }

    #[test]
    fn a_run_gives_the_same_alone_or_between_gaps() {
        let x = noise(777, 3);
        let mut alone = x.clone();
        filter(&mut alone, 100.0, 0.0, 20.0);
        let mut longer = noise(5000, 4);
        longer[999] = f64::NAN;
        longer[1000..1777].copy_from_slice(&x);
        longer[1777] = f64::NAN;
        filter(&mut longer, 100.0, 0.0, 20.0);
        assert_eq!(alone, longer[1000..1777]);
        assert!(longer[999].is_nan() && longer[1777].is_nan());
        assert!(longer[..999].iter().chain(&longer[1778..]).all(|v| v.is_finite()));
    }

    #[test]
    fn stray_samples_become_missing_with_a_warning() {
        let mut x = noise(500, 5);
        x[100..120].fill(f64::NAN);
        x[125..150].fill(f64::NAN);
        let mut s = session(x, Channel::Roll);
        let warnings = run(&mut s, &Config::default());
        assert_eq!(warnings.len(), 1);
        assert_eq!((warnings[0].code, warnings[0].count), ("short_run", 5));
        assert_eq!(warnings[0].time, Some(1.2));
        let x = s.get(Channel::Roll).expect("there");
        assert!(x[100..150].iter().all(|v| v.is_nan()) && x[150].is_finite());
    }

    #[test]
    fn labels_and_cuts_above_nyquist_are_left_alone() {
        let x: Vec<f64> = (0..400).map(|i| f64::from(i / 100)).collect();
        for channel in [Channel::Gear, Channel::Throttle, Channel::Latitude] {
            let mut s = session(x.clone(), channel);
            assert!(run(&mut s, &Config::default()).is_empty());
            assert_eq!(s.get(channel), Some(x.as_slice()));
        }
        let mut s = session(x.clone(), Channel::Roll);
        run(&mut s, &Config { high_cut: 50.0, ..Config::default() });
        assert_eq!(s.get(Channel::Roll), Some(x.as_slice()));
    }

    #[test]
    fn a_wrapping_heading_runs_on() {
        let truth: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        let wrapped = truth.iter().map(|y| y.sin().atan2(y.cos())).collect();
        let mut s = session(wrapped, Channel::Yaw);
        run(&mut s, &Config::default());
        let got = s.get(Channel::Yaw).expect("there");
        assert!(got.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn a_bad_band_is_named() {
        let parse = |t: &str| toml::from_str::<Config>(t).expect_err("bad").to_string();
        assert!(parse("[channel.rol]\nlow_cut = 0.1").contains("did you mean `roll`"));
        assert!(parse("[channel.gear]\nhigh_cut = 2.0").contains("label"));
        assert!(parse("[channel.roll]\nlow_cut = 5.0\nhigh_cut = 2.0").contains("must be below"));
        assert!(parse("[channel.roll]\nhigh_cut = -2.0").contains("positive"));
        assert!(parse("high_cut = 0.0").contains("positive"));
        let ok: Config = toml::from_str("[channel.roll_rate]\nlow_cut = 0.05").expect("good");
        assert_eq!(ok.band(Channel::RollRate), Some((0.05, 20.0)));
    }
}
