//! Cornering stiffness, camber stiffness and relaxation length of each tyre from how a motorcycle changes its lean, with
//! nothing believed of their ratio (`book/src/estimation.md`, section 11).
//!
//! In steady corners slip angle and camber lie on one curve, so (39) needs the side force ratio `C` from elsewhere. While
//! the lean changes, roll inertia, the wheels' gyroscopic moments and the yaw acceleration load the two axles differently
//! from camber: that separates the two. Steady parts of the same stretches belong to the same fit.
//!
//! ```text
//! x      = -(Fz/Fz0)^0.3 [ D asin(mu/D)/k_alpha (1 + b gamma²) + C gamma (1 + a gamma² + e gamma^4) ]     slip that the force needs
//! alpha  = x + (sigma/u) x' + alpha_0                                                        slip of the wheel, (1)
//! v_i    = u_i tan(alpha_i + Delta_i) - w_i                        lateral velocity of the mass centre by axle i
//! R1 = v_f - v_r        R2 = v_y - v_r        R3 = integral(a_y - psi' v_x) - v_r
//! ```
//!
//! Slip is the response, as it is the noisy side; force and camber are regressors. [`stretches`] finds where the lean
//! changes, [`columns`] brings the channels through one kernel to 5 Hz, [`motion`] makes slips, cambers, loads and forces of
//! them on the motorcycle's balance, [`parameters`] says what is known before the ride, [`noise`] how the residuals of
//! [`model`] are correlated, [`solve`] fits, and [`join`] puts the tyres into the session's solution.
//!
//! Needs lean, its rate, yaw rate, forward velocity, the handlebar's angle, and lateral velocity or acceleration.

pub(crate) mod columns;
pub(crate) mod config;
pub(crate) mod join;
pub(crate) mod model;
pub(crate) mod motion;
pub(crate) mod noise;
pub(crate) mod parameters;
pub(crate) mod solve;
pub(crate) mod stretches;

pub use self::config::Config;
use self::columns::Columns;
use self::model::Model;
use self::motion::Machine;
use self::parameters::Parameters;
pub use self::solve::Fitted;
use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::estimate::signals::Inputs;
use crate::estimate::zeros::Zeros;

/// A ride whose changes of lean were fitted.
#[derive(Debug)]
pub struct Transients {
    /// What was known before.
    pub parameters: Parameters,
    /// What came out.
    pub fitted: Fitted,
}

/// Fits the changes of lean of a filtered session. `inputs` are those of the session's fits, `zeros` its sensors' zeros with
/// the latency of the velocities; `crown` is the front tyre's crown radius where the ride gave it, m. `None` where the session
/// lacks channels or has too few stretches, or the fit does not come to rest.
pub fn run(
    session: &Session,
    inputs: &Inputs,
    zeros: &Zeros,
    crown: Option<f64>,
    config: &Config,
) -> Option<Transients> {
    let found = stretches::find(session, zeros, config)?;
    if found.len() < config.min_stretches {
        return None;
    }
    let columns = Columns::new(session, &found, zeros)?;
    let machine = Machine::new(inputs, crown);
    let parameters = Parameters::new(inputs, zeros, &machine, &columns, config);
    let model = Model::new(&columns, &machine, &parameters);
    let fitted = solve::fit(&model, &parameters)?;
    Some(Transients { parameters, fitted })
}

/// Standing loads of a motorcycle, N.
fn standing(bike: &Bike) -> [f64; 2] {
    crate::contract::bike::Axle::BOTH.map(|axle| bike.static_load(axle))
}

#[cfg(test)]
mod truth_debug {
    use super::*;
    use crate::contract::bike::Axle;
    use crate::simulate::hidden::Kind;
    use crate::simulate::population::bike::BikeFile;
    use crate::simulate::population::ride;

    #[test]
    #[ignore]
    fn compare() {
        let number: usize = std::env::var("N").unwrap().parse().unwrap();
        let case = ride::case(77, number, Kind::Null, [1.0, 1.0]);
        let ridden = ride::ride(&case, BikeFile::Full).unwrap();
        let mut session = ridden.ride.session.clone();
        println!("{}", ridden.machine);
        let bike = ridden.tour.bike.clone();
        let truth = ridden.truth(&crate::estimate::Config::default());
        for (id, v) in &truth { println!("{:?} {v}", id); }
        let n = session.len;
        for (k, ch) in [crate::contract::channel::Channel::Altitude, crate::contract::channel::Channel::AirTemperature].iter().enumerate() { let _ = (k, ch); }
        let zeros = Zeros { acceleration_known: true, ..Zeros::default() };
        let found = stretches::find(&session, &zeros, &Config::default()).unwrap();
        let cols = Columns::new(&session, &found, &zeros).unwrap();
        let mut inputs = Inputs::nominal(&bike, crate::tyre::formulation::Formulation::Corrected, zeros);
        let get = |c: crate::contract::coefficient::Coefficient, p: crate::contract::coefficient::Part| truth.iter().find(|(id, _)| id.coefficient == c && id.part == p).map(|x| x.1);
        use crate::contract::coefficient::{Coefficient as C, Part};
        inputs.drag = get(C::Drag, Part::Vehicle).unwrap_or(inputs.drag);
        inputs.rolling = get(C::RollingResistance, Part::Vehicle).unwrap_or(inputs.rolling);
        let m = ridden.tour.model.motorcycle.inertia();
        println!("inertia {m} per mass {}", m / bike.mass);
        let machine = Machine::new(&inputs, Some(ridden.machine.plant.crown[0]));
        let mut q = machine.start.clone();
        use motion::Quantity as Q;
        q[Q::RearCrown] = ridden.machine.plant.crown[1];
        q[Q::YawInertia] = m[(2, 2)];
        q[Q::ProductOfInertia] = if std::env::var("IXZ").is_ok() { m[(0, 2)] } else { -m[(0, 2)] };
        q[Q::FrontTwist] = ridden.machine.plant.tyres[0].twisting_stiffness;
        q[Q::RearTwist] = ridden.machine.plant.tyres[1].twisting_stiffness;
        let mo = machine.motion(&cols, &q);
        // truth channels through the same kernel: put them into a session's channels
        let mut put = |f: &dyn Fn(&crate::simulate::ride::Sample) -> f64| -> Vec<f64> {
            let x: Vec<f64> = ridden.ride.samples.iter().map(f).collect();
            session.set(crate::contract::channel::Channel::AccelerationY, x);
            Columns::new(&session, &found, &zeros).unwrap().lateral[0].clone()
        };
        let mut t: Vec<[Vec<f64>; 6]> = Vec::new();
        for k in 0..2 {
            t.push([put(&|s| s.wheels[k].kinematic[1]), put(&|s| s.wheels[k].force[1]), put(&|s| s.wheels[k].load), put(&|s| s.wheels[k].camber), put(&|s| s.wheels[k].slip[1]), put(&|s| s.wheels[k].moment_z)]);
        }
        let _ = n;
        for s in cols.stretches().take(14) {
            print!("v {:.0} lean {:.2} w {:.1}", cols.speed[s.start], cols.roll[0][s.clone()].iter().fold(0.0_f64, |a, b| a.max(b.abs())), 0.0);
            for k in 0..2 {
                let mut lines = Vec::new();
                let e = |f: &dyn Fn(usize) -> f64| -> (f64, f64, f64) {
                    // regress on roll and roll rate
                    let (mut a11, mut a12, mut a22, mut b1, mut b2) = (0.0, 0.0, 0.0, 0.0, 0.0);
                    let mut sum = 0.0;
                    for i in s.clone() { let (x, y, v) = (cols.roll[0][i], cols.roll[1][i], f(i)); a11 += x*x; a12 += x*y; a22 += y*y; b1 += x*v; b2 += y*v; sum += v*v; }
                    let d = a11*a22-a12*a12;
                    ((b1*a22-b2*a12)/d, (a11*b2-a12*b1)/d, (sum / s.len() as f64).sqrt())
                };
                let alpha = |i: usize| ((mo.drift[i] + mo.aside[k][i]) / mo.along[k][i]).atan() - if k == 0 { mo.steer[i] } else { 0.0 };
                lines.push(("alpha", e(&|i| alpha(i) - t[k][0][i]), e(&|i| t[k][0][i])));
                let moment = |i: usize| { t[0][5][i] + t[1][5][i] };
                let own = |i: usize| -> f64 { let q = &q; -q[Q::FrontTwist]*mo.load[0][i]*mo.camber[0][i] - q[Q::RearTwist]*mo.load[1][i]*mo.camber[1][i] };
                lines.push(("force", e(&|i| mo.force[k][i] + (moment(i) - own(i)) * mo.per_moment[k][i] - t[k][1][i]), e(&|i| t[k][1][i])));
                lines.push(("load", e(&|i| mo.load[k][i] - t[k][2][i]), e(&|i| t[k][2][i])));
                lines.push(("camber", e(&|i| mo.camber[k][i] - t[k][3][i]), e(&|i| t[k][3][i])));
                lines.push(("v3", e(&|i| if k==0 {mo.integral[i]-mo.drift[i]-(mo.integral[s.start]-mo.drift[s.start])} else {0.0}), e(&|i| mo.drift[i])));
                for (n, a, b) in lines { print!(" | {} {n} err/rad {:.2e} of {:.2e}, /rate {:.2e} of {:.2e} rms {:.1e}", ["f","r"][k], a.0, b.0, a.1, b.1, a.2); }
            }
            println!();
        }
        let _ = Axle::BOTH;
    }
}
