//! The ground of a motocross track in profile: height over distance, its slope, how fast each part
//! is ridden.

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use crate::contract::key_error::KeyError;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::random::Random;

/// One part of a lap, from its entry to the entry of the next.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Part {
    /// Level ground.
    Straight {
        /// Length, m.
        length: f64,
        /// Speed at its end, m/s.
        speed: f64,
    },
    /// A corner as the plane sees it: braking, rolling, driving out.
    Corner {
        /// Length of the slow part, m.
        length: f64,
        /// Its speed, m/s.
        speed: f64,
    },
    /// A table: parabolic ramp, level top, ramp down.
    Jump {
        /// Height, m.
        height: f64,
        /// Length of the take-off ramp, m; its slope at the lip is twice height over length.
        ramp: f64,
        /// Length of the top, m.
        top: f64,
        /// Length of the ramp down, m.
        landing: f64,
        /// Speed on the ramp, m/s.
        speed: f64,
    },
    /// Waves close together.
    Whoops {
        count: usize,
        /// From crest to crest, m.
        wavelength: f64,
        /// From trough to crest, m.
        height: f64,
        /// Speed, m/s.
        speed: f64,
    },
}

impl Part {
    /// Length, m.
    pub fn length(&self) -> f64 {
        match *self {
            Part::Straight { length, .. } | Part::Corner { length, .. } => length,
            Part::Jump { ramp, top, landing, .. } => ramp + top + landing,
            Part::Whoops { count, wavelength, .. } => count as f64 * wavelength,
        }
    }

    /// Checks the numbers of a scenario file.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        let mut rows = vec![("speed", self.speed(), 1.0, 60.0)];
        match *self {
            Part::Straight { length, .. } | Part::Corner { length, .. } => {
                rows.push(("length", length, 0.5, 5000.0));
            }
            Part::Jump { height, ramp, top, landing, .. } => rows.extend([
                ("height", height, 0.0, 10.0),
                ("ramp", ramp, 1.0, 100.0),
                ("top", top, 0.0, 100.0),
                ("landing", landing, 1.0, 100.0),
            ]),
            Part::Whoops { count, wavelength, height, .. } => rows.extend([
                ("count", count as f64, 1.0, 1000.0),
                ("wavelength", wavelength, 0.5, 50.0),
                ("height", height, 0.0, 3.0),
            ]),
        }
        for (key, value, low, high) in rows {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "`{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }

    fn speed(&self) -> f64 {
        match *self {
            Part::Straight { speed, .. }
            | Part::Corner { speed, .. }
            | Part::Jump { speed, .. }
            | Part::Whoops { speed, .. } => speed,
        }
    }

    /// Expected kind of the segment, while on the ground.
    pub fn kind(&self) -> ManoeuvreKind {
        match self {
            Part::Whoops { .. } => ManoeuvreKind::Whoops,
            Part::Corner { .. } => ManoeuvreKind::Cornering,
            Part::Straight { .. } | Part::Jump { .. } => ManoeuvreKind::Other,
        }
    }

    /// Height and slope at a distance from its entry.
    fn shape(&self, s: f64) -> (f64, f64) {
        match *self {
            Part::Straight { .. } | Part::Corner { .. } => (0.0, 0.0),
            Part::Jump { height, ramp, top, landing, .. } => {
                if s < ramp {
                    // the lip is rounded over its last 0.4 m
                    let lip = ramp - 0.4;
                    if s <= lip {
                        let u = s / ramp;
                        return (height * u * u, 2.0 * height * u / ramp);
                    }
                    let (z, slope) =
                        (height * (lip / ramp).powi(2), 2.0 * height * lip / ramp / ramp);
                    let u = (s - lip) / 0.4;
                    let rest = height - z;
                    // a cubic from (z, slope) to (height, 0)
                    let (m, h) = (slope * 0.4, rest);
                    let y = m * u + (3.0 * h - 2.0 * m) * u * u + (m - 2.0 * h) * u * u * u;
                    let dy = m + 2.0 * (3.0 * h - 2.0 * m) * u + 3.0 * (m - 2.0 * h) * u * u;
                    return (z + y, dy / 0.4);
                }
                if s < ramp + top {
                    return (height, 0.0);
                }
                let u = (s - ramp - top) / landing;
                (
                    0.5 * height * (1.0 + (PI * u).cos()),
                    -0.5 * height * PI / landing * (PI * u).sin(),
                )
            }
            Part::Whoops { wavelength, height, .. } => {
                let phase = TAU * s / wavelength;
                (0.5 * height * (1.0 - phase.cos()), 0.5 * height * TAU / wavelength * phase.sin())
            }
        }
    }
}

/// A wave of the unevenness: amplitude, wave number, phase.
type Wave = (f64, f64, f64);

/// A lap, ridden again and again.
#[derive(Debug, Clone)]
pub struct Ground {
    parts: Vec<Part>,
    entries: Vec<f64>,
    lap: f64,
    waves: Vec<Wave>,
}

/// How hard the rider brakes for what is ahead, m/s².
const BRAKING: f64 = 3.5;
/// How far he looks ahead, m.
const SIGHT: f64 = 60.0;

impl Ground {
    /// A lap of these parts on uneven ground of a given height (standard deviation, m).
    pub fn new(parts: &[Part], unevenness: f64, random: &mut Random) -> Self {
        let mut entries = Vec::with_capacity(parts.len());
        let mut lap = 0.0;
        for part in parts {
            entries.push(lap);
            lap += part.length();
        }
        // wave lengths of 1.2 to 12 m: shorter ones a tyre swallows
        let count = 24;
        let waves = (0..count)
            .map(|k| {
                let length = 1.2 * 10.0_f64.powf(f64::from(k) / f64::from(count - 1));
                let amplitude = length.powf(0.7);
                (amplitude, TAU / (length * random.between(0.95, 1.05)), random.between(0.0, TAU))
            })
            .collect::<Vec<Wave>>();
        let power: f64 = waves.iter().map(|w| 0.5 * w.0 * w.0).sum();
        let scale = unevenness / power.sqrt();
        let waves = waves.into_iter().map(|(a, k, p)| (a * scale, k, p)).collect();
        Ground { parts: parts.to_vec(), entries, lap, waves }
    }

    fn place(&self, x: f64) -> (usize, f64) {
        let s = x.rem_euclid(self.lap);
        let k = self.entries.partition_point(|e| *e <= s).saturating_sub(1);
        (k, s - self.entries[k])
    }

    /// The part at a distance.
    pub fn part(&self, x: f64) -> &Part {
        &self.parts[self.place(x).0]
    }

    /// Height, m, and slope at a distance.
    pub fn at(&self, x: f64) -> (f64, f64) {
        let (k, s) = self.place(x);
        let (mut z, mut slope) = self.parts[k].shape(s);
        for (a, number, phase) in &self.waves {
            let (sin, cos) = (number * x + phase).sin_cos();
            z += a * sin;
            slope += a * number * cos;
        }
        (z, slope)
    }

    /// Slope without the unevenness: what a rider sees.
    pub fn seen_slope(&self, x: f64) -> f64 {
        let (k, s) = self.place(x);
        self.parts[k].shape(s).1
    }

    /// The speed a rider wants here, m/s: that of the part, or what lets him brake for the next.
    pub fn speed(&self, x: f64) -> f64 {
        let (first, s) = self.place(x);
        let mut wanted = self.parts[first].speed();
        let mut ahead = self.parts[first].length() - s;
        let mut k = first;
        while ahead < SIGHT {
            k = (k + 1) % self.parts.len();
            let v = self.parts[k].speed();
            wanted = wanted.min((v * v + 2.0 * BRAKING * ahead).sqrt());
            ahead += self.parts[k].length();
        }
        wanted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn height_is_continuous_and_the_slope_is_its_derivative() {
        let parts = [
            Part::Straight { length: 20.0, speed: 12.0 },
            Part::Jump { height: 1.6, ramp: 9.0, top: 7.0, landing: 8.0, speed: 11.0 },
            Part::Whoops { count: 5, wavelength: 3.5, height: 0.3, speed: 9.0 },
        ];
        let ground = Ground::new(&parts, 0.02, &mut Random::new(1, "ground"));
        let mut last = ground.at(0.0).0;
        for i in 1..70_000 {
            let x = f64::from(i) * 1e-3;
            let (z, slope) = ground.at(x);
            assert!((z - last).abs() < 2e-3, "{x}");
            let (a, b) = (ground.at(x - 1e-6).0, ground.at(x + 1e-6).0);
            // the slope itself jumps where whoops begin nowhere: both ends are level
            assert!(((b - a) / 2e-6 - slope).abs() < 1e-3, "{x}");
            last = z;
        }
        assert!(ground.speed(5.0) > 11.0 && ground.speed(19.9) < 11.2);
    }
}
