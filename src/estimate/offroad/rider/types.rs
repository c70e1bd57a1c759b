//! What the rider models share: their names, the motion they are given, the forces they return, and
//! their settings.

use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rider {
    /// No rider: the forces of the bike alone, for comparison.
    None,
    /// A mass on springs and dampers, integrated.
    A,
    /// Weight on the pegs, horizontal inertia at the bar.
    B,
    /// B, with the vertical motion of the chassis, low-passed.
    C,
}

impl Rider {
    pub const ALL: [Rider; 4] = [Rider::None, Rider::A, Rider::B, Rider::C];

    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Rider::None => "none",
            Rider::A => "a",
            Rider::B => "b",
            Rider::C => "c",
        }
    }
}

/// The chassis' motion under the rider, sample by sample; NaN where it is not known.
#[derive(Debug, Clone, Copy)]
pub struct Base<'a> {
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Pitch, nose up, rad.
    pub mu: &'a [f64],
    /// Pitch rate, rad/s.
    pub mud: &'a [f64],
    /// Acceleration of the centre of mass of the chassis forward, m/s².
    pub xdd: &'a [f64],
    /// The same down, m/s².
    pub zdd: &'a [f64],
    /// Whether both wheels are off the ground.
    pub airborne: &'a [bool],
}

/// Forces on the bike, ground axes, N.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Forces {
    /// Pegs, forward.
    pub lx: Vec<f64>,
    /// Pegs, down.
    pub lz: Vec<f64>,
    /// Bar, forward.
    pub ax: Vec<f64>,
    /// Bar, down.
    pub az: Vec<f64>,
    /// Samples at which the rider had toppled over and was stood up again: rider A only.
    pub toppled: Vec<usize>,
}

impl Forces {
    /// No force over `n` samples.
    pub fn zeros(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Forces { lx: zeros(), lz: zeros(), ax: zeros(), az: zeros(), toppled: Vec::new() }
    }

    /// The same rider with half of the fore-and-aft force at the bar moved to the pegs: how it is
    /// shared is not measured.
    pub fn half_at_pegs(&self) -> Self {
        let mut other = self.clone();
        for (pegs, bar) in other.lx.iter_mut().zip(&mut other.ax) {
            *bar *= 0.5;
            *pegs += *bar;
        }
        other
    }

    /// `[L_x, L_z, A_x, A_z]` of a sample.
    #[inline]
    pub fn at(&self, i: usize) -> [f64; 4] {
        [self.lx[i], self.lz[i], self.ax[i], self.az[i]]
    }
}

/// Settings of the riders.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Rider C's cut-off, Hz.
    pub cut_off: f64,
    /// Below this rider C follows the chassis fore and aft too, Hz; absent: always, as rider B.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizontal_cut_off: Option<f64>,
    /// Rider C filtered forward and backward: no lag, but the cut-offs fall to 0.8 of themselves.
    pub zero_phase: bool,
    /// Share of the horizontal force that B and C take with their arms, the rest with their feet;
    /// the paper has it all at the bar.
    pub arms: f64,
    /// Over how long B and C let go and take hold at take-off and landing, s.
    pub crossfade: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            cut_off: 1.5,
            horizontal_cut_off: None,
            zero_phase: true,
            arms: 1.0,
            crossfade: 0.05,
        }
    }
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        for (key, value, low, high) in [
            ("cut_off", self.cut_off, 0.05, 50.0),
            ("horizontal_cut_off", self.horizontal_cut_off.unwrap_or(1.0), 0.05, 50.0),
            ("arms", self.arms, 0.0, 1.0),
            ("crossfade", self.crossfade, 0.0, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[offroad.rider] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }
}

/// One while the rider holds on, zero in the air, with ramps of `crossfade` seconds outside the flight.
pub(crate) fn hold(base: &Base<'_>, crossfade: f64) -> Vec<f64> {
    let ramp = 1.0 / (crossfade * base.rate).max(1.0);
    let mut hold: Vec<f64> = base.airborne.iter().map(|&a| if a { 0.0 } else { 1.0 }).collect();
    for i in 1..hold.len() {
        hold[i] = hold[i].min(hold[i - 1] + ramp);
    }
    for i in (1..hold.len()).rev() {
        hold[i - 1] = hold[i - 1].min(hold[i] + ramp);
    }
    hold
}
