//! What a ride on the multibody motorcycle has beyond machine, road and rider's wish: gusts, pads that
//! bite anew at every stop, hands that tremble; and the brakes of a [`ModelError`].

use super::programme::Controls;
use super::rider::Disturbance;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::simulate::effects::ModelError;
use crate::simulate::effects::ride::Brakes;
use crate::simulate::multibody::{Action, Motorcycle};
use crate::statistics::random::{Coloured, Random};

/// Below this speed gusts weaken, as slopes do: a standing motorcycle is not pushed, m/s.
const MOVING: f64 = 2.0;

#[derive(Debug)]
pub(crate) struct Unsteady {
    disturbance: Disturbance,
    model_error: ModelError,
    wind: [f64; 2],
    mass: f64,
    noise: [Coloured; 3],
    random: Random,
    pads: [f64; 2],
    slope: f64,
    brakes: Brakes,
    time: f64,
    period: f64,
}

impl Unsteady {
    /// At the start of a ride whose rider decides every `period` s; `wind` in road axes, m/s. A yaw
    /// moment is left out: there is nothing for it to act on.
    pub(crate) fn new(
        motorcycle: &Motorcycle,
        disturbance: Disturbance,
        model_error: ModelError,
        wind: [f64; 2],
        mut random: Random,
        period: f64,
    ) -> Self {
        let d = disturbance;
        let noise = [
            Coloured::new(d.gust_x, 1.5, period, &mut random),
            Coloured::new(d.gust_y, 1.5, period, &mut random),
            Coloured::new(d.lean, 1.0, period, &mut random),
        ];
        let mut unsteady = Unsteady {
            disturbance,
            model_error,
            wind,
            mass: motorcycle.mass(),
            noise,
            random,
            pads: [1.0; 2],
            slope: 0.0,
            brakes: Brakes::default(),
            time: 0.0,
            period,
        };
        unsteady.next_phase();
        unsteady
    }

    /// Road and pads differ from run to run.
    pub(crate) fn next_phase(&mut self) {
        self.slope = self.disturbance.grade * self.random.normal();
        self.pads = [0; 2].map(|_| 1.0 + self.disturbance.brake_gain * self.random.normal());
    }

    /// Lean that the rider fails to hold, rad.
    pub(crate) fn sway(&mut self) -> f64 {
        self.noise[2].next(&mut self.random)
    }

    /// Changes the rider's action at a speed (m/s).
    pub(crate) fn act(&mut self, action: &mut Action, controls: &Controls, speed: f64) {
        self.brakes.update(speed, controls.pressure, self.period);
        let Brakes { whole, each } = self.brakes;
        for ((torque, pad), axle) in action.brake.iter_mut().zip(self.pads).zip(Axle::BOTH) {
            let gain = self.model_error.brake_gain(1.0, self.mass, each[axle as usize]);
            let dragging = self.model_error.brake_drag(0.0, self.mass, whole, axle);
            *torque = *torque * pad * gain + dragging;
        }
        for (air, wind) in action.wind.iter_mut().zip(self.wind) {
            *air += wind;
        }
        self.time += self.period;
        action.time = self.time;
        let [ahead, left] = [0, 1].map(|k| self.noise[k].next(&mut self.random));
        let running = (speed / MOVING).clamp(0.0, 1.0);
        action.gust = [running * (ahead - self.mass * GRAVITY * self.slope), running * left];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::multibody::run::Run;
    use crate::simulate::multibody_ride as multibody;
    use crate::simulate::scenario::Scenario;

    #[test]
    fn a_side_gust_does_not_hold_back() {
        let scenario = Scenario::builtin("paper").expect("scenario").certain();
        let tour = multibody::tour(&scenario, &scenario.machine(0), 0).expect("stands");
        let (model, weight) = (&tour.model, tour.model.motorcycle.mass() * GRAVITY);
        let observed = |gust: [f64; 2]| {
            let mut run = Run::new(model, model.straight(5.0));
            run.observe(&Action { gust, ..Action::default() });
            (run.rates.velocity.linear, run.scratch.air[0])
        };
        let (still, drag) = observed([0.0; 2]);
        let (pushed, in_gust) = observed([0.0, 20.0]);
        assert_eq!(drag, in_gust);
        assert!((pushed.x - still.x).abs() * weight < 0.2 * GRAVITY, "{pushed} {still}");
        assert!(pushed.y > still.y);
        let (ahead, _) = observed([20.0, 0.0]);
        let expected = 20.0 * GRAVITY / weight;
        let gained = ahead.x - still.x;
        assert!(gained > 0.85 * expected && gained < expected, "{gained} for {expected}");
    }
}
