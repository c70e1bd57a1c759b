//! Seeded randomness: one stream per session and purpose, so that nothing depends on order.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;

/// A reproducible source of numbers.
#[derive(Debug, Clone)]
pub struct Random(Pcg64);

impl Random {
    /// The stream of a purpose, e.g. `session 3 sensors`.
    pub fn new(seed: u64, purpose: &str) -> Self {
        let hash = blake3::hash(purpose.as_bytes());
        let mut stream = [0_u8; 16];
        stream.copy_from_slice(&hash.as_bytes()[..16]);
        Random(Pcg64::new(u128::from(seed), u128::from_le_bytes(stream)))
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Uniform between two bounds.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        match Uniform::new(low, high) {
            Ok(uniform) => uniform.sample(&mut self.0),
            Err(_) => low,
        }
    }
}

/// First-order autoregressive noise with a given spread and correlation time.
#[derive(Debug, Clone)]
pub struct Coloured {
    value: f64,
    keep: f64,
    push: f64,
}

impl Coloured {
    /// Noise of standard deviation `sd` and correlation time `tau` (s), stepped every `dt` s.
    pub fn new(sd: f64, tau: f64, dt: f64, random: &mut Random) -> Self {
        let keep = if tau > 0.0 { (-dt / tau).exp() } else { 0.0 };
        let push = sd * (1.0 - keep * keep).sqrt();
        Coloured { value: sd * random.normal(), keep, push }
    }

    pub fn next(&mut self, random: &mut Random) -> f64 {
        self.value = self.keep * self.value + self.push * random.normal();
        self.value
    }
}
