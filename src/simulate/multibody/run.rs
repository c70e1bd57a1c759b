//! Time steps: the classical Runge-Kutta scheme over the model, and what ends a ride early.

use super::model::{Model, Scratch};
use super::state::{Action, N, State};

/// Why a ride cannot go on.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Fall {
    /// It leans too far to come back.
    #[error("fell over at {time:.2} s: roll {:.0} deg at {speed:.1} m/s", roll.to_degrees())]
    Over {
        /// Time, s.
        time: f64,
        /// Roll, rad.
        roll: f64,
        /// Speed, m/s.
        speed: f64,
    },
    /// It stood on one wheel past the balance point.
    #[error("turned over at {time:.2} s: pitch {:.0} deg at {speed:.1} m/s", pitch.to_degrees())]
    Pitched {
        /// Time, s.
        time: f64,
        /// Pitch, rad.
        pitch: f64,
        /// Speed, m/s.
        speed: f64,
    },
    /// The numbers are no longer finite.
    #[error(
        "the state is not finite at {time:.2} s: the step is too long, or the motorcycle file is \
         impossible"
    )]
    NotFinite {
        /// Time, s.
        time: f64,
    },
}

/// Lean beyond which nothing is ridden, rad.
const LARGEST_ROLL: f64 = 1.25;
/// Pitch beyond which nothing is ridden, rad.
const LARGEST_PITCH: f64 = 0.8;

/// A ride under way.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    pub model: &'a Model,
    pub state: State,
    /// Time, s.
    pub time: f64,
    /// Scratch memory; wheels and forces of the last [`Run::observe`].
    pub scratch: Scratch,
    /// Rates of the state at the last [`Run::observe`].
    pub rates: State,
}

impl<'a> Run<'a> {
    /// Starts in a state.
    pub fn new(model: &'a Model, state: State) -> Self {
        Run { model, state, time: 0.0, scratch: model.scratch(), rates: State::default() }
    }

    /// Evaluates the present instant: afterwards `scratch` and `rates` belong to it.
    pub fn observe(&mut self, action: &Action) {
        self.rates = self.model.rates(&self.state, action, &mut self.scratch);
    }

    /// One step of length `dt` with the action held.
    pub fn step(&mut self, action: &Action, dt: f64) {
        if action.brake != [0.0; 2] || self.scratch.held != [false; 2] {
            self.model.decide_held(&self.state, action, dt, &mut self.scratch);
        }
        let y = self.state.to_array();
        let mut f = |s: &State| self.model.rates(s, action, &mut self.scratch).to_array();
        let at =
            |k: &[f64; N], h: f64| State::from_array(&std::array::from_fn(|i| y[i] + h * k[i]));
        let k1 = f(&self.state);
        let k2 = f(&at(&k1, 0.5 * dt));
        let k3 = f(&at(&k2, 0.5 * dt));
        let k4 = f(&at(&k3, dt));
        self.state = State::from_array(&std::array::from_fn(|i| {
            y[i] + dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
        }));
        self.time += dt;
    }

    /// Whether the ride can go on.
    ///
    /// # Errors
    /// How it ended.
    pub fn check(&self) -> Result<(), Fall> {
        let s = &self.state;
        let time = self.time;
        if !s.to_array().iter().all(|x| x.is_finite()) {
            return Err(Fall::NotFinite { time });
        }
        let speed = s.velocity.linear.x;
        if s.angles[1].abs() > LARGEST_ROLL {
            return Err(Fall::Over { time, roll: s.angles[1], speed });
        }
        if s.angles[2].abs() > LARGEST_PITCH {
            return Err(Fall::Pitched { time, pitch: s.angles[2], speed });
        }
        Ok(())
    }
}
