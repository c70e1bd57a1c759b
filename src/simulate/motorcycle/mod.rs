//! A reduced-order motorcycle on the paper's tyres: planar motion of the centre of mass, yaw,
//! roll, both wheel spins, lagged slip angles, steering.
//!
//! Wheel loads and roll acceleration follow from the same instant's balances (tyre forces are
//! proportional to load, so this is a 3x3 linear solve, not a lag):
//!
//! ```text
//! vertical  Nf + Nr                       = m (g + z''),  z = h cos(phi)
//! pitch     -lf Nf + lr Nr - h cos(phi) X = cos(phi) sum(I omega')
//! roll      Ix phi''  = N h sin(phi) + h cos(phi) Y + Mx + sum(I omega) r cos(phi)
//! yaw       Iz r'     = lf Yf - lr Yr + Mz - h sin(phi) X - d/dt sum(I omega sin(phi))
//! plane     m (vx' - r vy) = X - drag + Fx,   m (vy' + r vx) = Y + Fy
//! ```
//!
//! Level frame on the trace of the bike's plane, ISO 8855; `X, Y` are tyre forces in that frame,
//! `v` is the velocity of the centre of mass. Left out: pitch and bounce dynamics, products of inertia,
//! the difference of yaw and pitch inertia. Tyres are toroids on springs
//! ([`Carcass`](crate::tyre::tyre_model::Carcass)): rolling radius and lever arm of the longitudinal
//! force follow load and camber.

mod equations;
mod integration;
pub(crate) mod plant;
mod state;

pub(crate) use integration::Exponential;
pub(crate) use plant::Plant;
pub(crate) use state::{Action, Response, State};

#[cfg(test)]
mod tests {
    use super::state::N;
    use super::*;
    use crate::GRAVITY;
    use crate::motorcycle::balance::{Lengths, pitching};
    use crate::simulate::programme::Lean;
    use crate::simulate::rider::steer_as_felt;
    use crate::simulate::scenario::Scenario;
    use crate::tyre::tyre_model::load_lead;

    fn plant() -> Plant {
        Scenario::builtin("perfect").expect("scenario").nominal_plant()
    }

    /// The estimate's balance and the simulator's are written apart: loads that are solved together with the tyres'
    /// forces against loads that follow from the acceleration.
    #[test]
    fn loads_are_those_of_the_balance() {
        let p = plant();
        let vehicle = &p.vehicle;
        for (brake, drive) in [([0.0; 2], 0.0), ([250.0, 60.0], 0.0), ([0.0; 2], 180.0)] {
            let mut s = State { vx: 25.0, ..State::default() };
            s.omega = [25.0 / p.tyres[0].rolling_radius, 25.0 / p.tyres[1].rolling_radius];
            let action = Action { brake, drive, ..Action::default() };
            for _ in 0..40 {
                p.advance(&mut s, &action, 0.01);
            }
            let response = p.response(&s, &action);
            let rates = p.rates(&s, &action);
            let along = vehicle.mass * response.acceleration[0] + vehicle.drag * s.vx * s.vx;
            let turning = (0..2).map(|k| vehicle.wheel_inertia[k] * rates.omega[k]).sum::<f64>();
            let lever =
                (0..2).map(|k| p.carcass(k, response.load[k]).lever_arm(response.load[k], 0.0));
            let lead = load_lead(p.tyres[0].rolling_resistance, 0.5 * lever.sum::<f64>());
            let loads = Lengths::new(vehicle.cg_to_front, vehicle.wheelbase).loads(
                vehicle.mass * GRAVITY,
                -lead,
                pitching(along, vehicle.cg_height, turning, 1.0),
            );
            for k in 0..2 {
                let off = (loads[k] - response.load[k]) / (vehicle.mass * GRAVITY);
                assert!(off.abs() < 3e-4, "{brake:?} {drive}: {loads:?} {:?}", response.load);
            }
        }
    }

    #[test]
    fn coasting_follows_the_closed_form() {
        // m* v' = -c v^2 - c_rol m g with m* = m + sum(I/(R R_l)), R_l the lever arm:
        // v(t) = sqrt(r/c) tan(atan(v0 sqrt(c/r)) - sqrt(r c)/m* t)
        let p = plant();
        let vehicle = &p.vehicle;
        let mut s = State { vx: 20.0, ..State::default() };
        s.omega = [20.0 / p.tyres[0].rolling_radius, 20.0 / p.tyres[1].rolling_radius];
        for _ in 0..1000 {
            p.advance(&mut s, &Action::default(), 0.01);
        }
        let effective = vehicle.mass
            + (0..2)
                .map(|i| {
                    let load = vehicle.static_loads()[i];
                    let lever = p.carcass(i, load).lever_arm(load, 0.0);
                    vehicle.wheel_inertia[i] / (p.tyres[i].rolling_radius * lever)
                })
                .sum::<f64>();
        let resist = p.tyres[0].rolling_resistance * vehicle.mass * GRAVITY;
        let root = (resist / vehicle.drag).sqrt();
        let v =
            root * ((20.0 / root).atan() - (resist * vehicle.drag).sqrt() / effective * 10.0).tan();
        assert!((s.vx - v).abs() < 2e-3, "{} {v}", s.vx);
    }

    #[test]
    fn loads_carry_the_weight_and_the_load_transfer() {
        let p = plant();
        let vehicle = &p.vehicle;
        let s = State { vx: 15.0, omega: [50.0, 48.0], ..State::default() };
        let action = Action { brake: [400.0, 0.0], ..Action::default() };
        let r = p.response(&s, &action);
        assert!((r.load[0] + r.load[1] - vehicle.mass * GRAVITY).abs() < 1e-6);
        // pitch balance about the front contact with drag at the centre of mass
        let rates = p.rates(&s, &action);
        let spin: f64 = (0..2).map(|i| vehicle.wheel_inertia[i] * rates.omega[i]).sum();
        let x = vehicle.mass * r.acceleration[0] + vehicle.drag * s.vx * s.vx;
        // each load acts ahead of its axle
        let lead: f64 = (0..2)
            .map(|i| {
                let arm = p.carcass(i, vehicle.static_loads()[i]).lever_arm(r.load[i], 0.0);
                p.tyres[i].rolling_resistance * arm * r.load[i]
            })
            .sum();
        let carried = vehicle.mass * GRAVITY * vehicle.cg_to_front + lead;
        let rear = (carried + x * vehicle.cg_height + spin) / vehicle.wheelbase;
        assert!((r.load[1] - rear).abs() < 1e-4, "{} {rear}", r.load[1]);
    }

    #[test]
    fn a_finer_step_changes_nothing_visible() {
        let p = plant();
        let start = State { vx: 12.0, omega: [41.0, 39.5], roll: -0.2, ..State::default() };
        let action = Action { steer: 0.02, brake: [150.0, 40.0], ..Action::default() };
        let (mut a, mut b) = (start, start);
        for _ in 0..50 {
            p.advance(&mut a, &action, 0.01);
            for _ in 0..8 {
                p.advance(&mut b, &action, 0.00125);
            }
        }
        let (a, b) = (a.to_array(), b.to_array());
        for i in 0..N {
            // a hundredth of what the best velocity sensor sees
            assert!((a[i] - b[i]).abs() < 2e-4 * (1.0 + b[i].abs()), "{i}: {} {}", a[i], b[i]);
        }
    }

    /// Against the classical scheme with an eighth of the step, ridden as replays are: steered so that a corner is held,
    /// brakes and throttle going evenly up and down.
    #[test]
    fn the_exponential_scheme_rides_as_the_classical_one() {
        let p = plant();
        let scheme = Exponential::new(&p);
        for (brake, drive, lean) in
            [(520.0, 0.0, 0.0), (0.0, 400.0, 0.0), (60.0, 0.0, -0.5), (0.0, 150.0, 0.7)]
        {
            let begin = |speed: f64| {
                let omega = p.tyres.map(|t| speed / t.rolling_radius);
                State { vx: speed, omega, ..State::default() }
            };
            let (mut coarse, mut fine) = (begin(22.0), begin(22.0));
            let action = |t: f64, state: &State| {
                let share = (t * std::f64::consts::PI / 1.5).sin().max(0.0);
                let wanted = Lean { angle: lean * share, rate: 0.0, acceleration: 0.0 };
                let given = Action {
                    brake: [brake * share, 0.0],
                    drive: drive * share,
                    ..Action::default()
                };
                Action {
                    steer: steer_as_felt(&p, state, &p.response(state, &given), &wanted),
                    ..given
                }
            };
            let mut worst = [0.0_f64; N];
            for k in 0..150 {
                let t = 0.01 * f64::from(k);
                let given = |state: &State| {
                    let steer = action(t, state).steer;
                    [t, t + 0.01].map(|t| Action { steer, ..action(t, state) })
                };
                let [from, to] = given(&coarse);
                scheme.advance(&mut coarse, [&from, &to], 0.01, None);
                let [from, to] = given(&fine);
                for part in 0..8 {
                    p.advance(
                        &mut fine,
                        &from.towards(&to, (f64::from(part) + 0.5) / 8.0),
                        0.00125,
                    );
                }
                for (i, (a, b)) in coarse.to_array().into_iter().zip(fine.to_array()).enumerate() {
                    worst[i] = worst[i].max((a - b).abs() / (1.0 + b.abs()));
                }
            }
            // a thousandth: of the speed lost in the hardest stop a six-hundredth
            assert!(worst.iter().all(|x| *x < 1e-3), "{brake} {drive} {lean}: {worst:?}");
        }
    }
}
