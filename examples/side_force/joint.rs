//! Rides of one pair of tyres together: what each knows, once what belongs to the ride or to its motorcycle is
//! fitted along, and the joint estimate.
//!
//! ```text
//! curvature of a ride over [ride | motorcycle | tyres], priors on the ride's own, those projected out
//! sum over the rides of a motorcycle, priors on its own, those projected out
//! sum over motorcycles, priors on what else is unknown of the tyres
//! ```

use nalgebra::{DMatrix, DVector};
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::road;
use roadbench::internals::diagnose::road::base;
use roadbench::internals::diagnose::road::parameters::{BASE, Parameter, Parameters, Place};
use roadbench::internals::diagnose::road::problem::Problem;
use roadbench::internals::diagnose::road::residuals::blocks;
use roadbench::internals::diagnose::road::samples::Samples;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::simulate::effects::physics::Reach;

use super::riding::{On, RIDE};

/// Standard deviation of what nothing is known of, in scales.
const FREE: f64 = 1e3;
/// Rounds of the joint estimate.
const ROUNDS: usize = 12;

macro_rules! place {
    ($name:literal, $scale:expr, $prior:expr, |$w:ident| $place:expr, $reach:expr) => {
        Parameter {
            name: $name,
            scale: $scale,
            prior: $prior,
            place: Place::Base(|$w| $place, |$w, value| $place = value),
            reach: $reach,
        }
    };
}

fn effect(name: &str, prior: f64) -> Parameter {
    Parameter { prior, ..Effect::named(name).expect("an effect").parameter() }
}

/// What is free, in its order: of every ride, of every motorcycle, of the tyres.
pub struct Free {
    pub all: Vec<Parameter>,
    pub ride: usize,
    pub machine: usize,
}

/// Names of what is asked for.
pub const ASKED: [&str; 4] = ["ratio_front", "ratio_rear", "twisting_front", "twisting_rear"];

impl Free {
    pub fn new() -> Self {
        let tyre = |p: &&Parameter| {
            p.name.starts_with("cornering_stiffness") || p.name.starts_with("stiffness_decay")
        };
        // a ride's: what the base fits, and what the sensors and the rider have beyond that
        let mut all: Vec<Parameter> = BASE.iter().filter(|p| !tyre(p)).copied().collect();
        all.extend(["steer_zero", "roll_zero", "rider_lean", "latency"].map(|e| effect(e, 3.0)));
        all.extend([effect("road_bank", 1.0), effect("velocity_lever_arm", 0.2)]);
        let ride = all.len();
        // a motorcycle's: what a workshop measures, and how its front gives way
        all.extend([
            place!("mass", 2.0, 1.0, |w| w.vehicle.mass, Reach::ATTITUDE),
            place!("cg_to_front", 0.007, 1.0, |w| w.vehicle.cg_to_front, Reach::ATTITUDE),
            place!("cg_height", 0.007, 1.0, |w| w.vehicle.cg_height, Reach::ATTITUDE),
            place!("caster_angle", 0.004, 1.0, |w| w.vehicle.caster_angle, Reach::ATTITUDE),
            place!("normal_trail", 0.004, 1.0, |w| w.vehicle.normal_trail, Reach::ATTITUDE),
            place!("yaw_inertia", 2.5, 1.0, |w| w.vehicle.yaw_inertia, Reach::LATERAL),
            effect("wheel_inertia", 0.5),
            effect("front_compliance", 1.0),
        ]);
        let machine = all.len() - ride;
        // the tyres': stiffnesses of which nothing is known, the others as published tyres differ
        let stiffness = |p: &Parameter| match p.name.starts_with("cornering") {
            true => Parameter { prior: FREE, ..*p },
            false => *p,
        };
        all.extend(BASE.iter().filter(tyre).map(stiffness));
        all.extend([
            effect("relaxation_length", 1.0),
            effect("pneumatic_trail", 1.0),
            effect("stiffness_load", 1.0),
            place!("ratio_front", 0.05, 1.0, |w| w.side_force_ratio[0], Reach::LATERAL),
            place!("ratio_rear", 0.04, 1.0, |w| w.side_force_ratio[1], Reach::LATERAL),
            place!("twisting_front", 0.0073, 1.0, |w| w.twisting_stiffness[0], Reach::LATERAL),
            place!("twisting_rear", 0.0136, 1.0, |w| w.twisting_stiffness[1], Reach::LATERAL),
        ]);
        Free { all, ride, machine }
    }

    fn tyres(&self) -> &[Parameter] {
        &self.all[self.ride + self.machine..]
    }

    fn place(&self, name: &str) -> usize {
        self.all.iter().position(|p| p.name == name).expect("a parameter of this name")
    }
}

/// A ride and where its fit is.
#[derive(Clone)]
pub struct Ride {
    pub on: On,
    pub values: Parameters,
    samples: Samples,
    start: Parameters,
    sigma: [f64; 8],
    duration: f64,
    /// Loads at rest over those of the first motorcycle, less 1.
    more_load: [f64; 2],
}

impl Ride {
    /// The base fitted to a ride alone.
    pub fn new(session: &Session, bike: &Bike, on: On, first: &Bike) -> Result<Self, String> {
        let fitted = road::fitted(session, bike, &Pipeline::onroad()).map_err(|e| e.message)?;
        let (samples, values) = (fitted.samples, fitted.base.values);
        let load = |b: &Bike| [b.cg_to_rear(), b.cg_to_front].map(|l| b.mass * l / b.wheelbase);
        let (here, there) = (load(bike), load(first));
        Ok(Ride {
            on,
            sigma: base::noise(&samples, &blocks(&samples, &values)),
            start: fitted.base.start,
            duration: session.duration(),
            more_load: [0, 1].map(|k| here[k] / there[k] - 1.0),
            values,
            samples,
        })
    }

    /// Curvature and downhill pull over everything that is free, the ride's own priors in them.
    fn normal(&self, free: &Free) -> (DMatrix<f64>, DVector<f64>) {
        let problem = Problem::new(&self.samples, &self.start, self.sigma, &free.all);
        let (mut matrix, mut pull) = problem.accumulate(&problem.linear(&self.values));
        // stiffness under another load at rest goes with the tyre's load sensitivity
        let load = free.place("stiffness_load");
        for (k, end) in ["front", "rear"].into_iter().enumerate() {
            let stiffness = free.place(&format!("cornering_stiffness_{end}"));
            let by = -free.all[load].scale.abs() / free.all[stiffness].scale * self.more_load[k];
            let column = matrix.column(stiffness).into_owned() * by;
            matrix.column_mut(load).axpy(1.0, &column, 1.0);
            let row = matrix.row(stiffness).into_owned() * by;
            let mut own = matrix.row_mut(load);
            own += row;
            pull[load] += by * pull[stiffness];
        }
        for i in 0..free.ride {
            self.believe(&free.all[i], &self.start, (&mut matrix, &mut pull), i);
        }
        (matrix, pull)
    }

    fn believe(
        &self,
        p: &Parameter,
        start: &Parameters,
        (matrix, pull): (&mut DMatrix<f64>, &mut DVector<f64>),
        i: usize,
    ) {
        let weight = 1.0 / (p.prior * p.prior);
        matrix[(i, i)] += weight;
        pull[i] -= weight * (p.get(&self.values) - p.get(start)) / p.scale;
    }

    fn step(&mut self, parameters: &[Parameter], by: &[f64], share: f64) {
        for (p, d) in parameters.iter().zip(by) {
            let value = p.get(&self.values) + share * d * p.scale;
            p.set(&mut self.values, value);
        }
    }
}

/// The first `n` unknowns projected out of normal equations.
fn without_first(
    matrix: &DMatrix<f64>,
    pull: &DVector<f64>,
    n: usize,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let rest = matrix.nrows() - n;
    let inner = matrix.view((0, 0), (n, n)).into_owned().cholesky()?;
    let cross = matrix.view((0, n), (n, rest)).into_owned();
    let whole = matrix.view((n, n), (rest, rest)).into_owned();
    let own = pull.rows(0, n).into_owned();
    let left = whole - cross.transpose() * inner.solve(&cross);
    Some((left, pull.rows(n, rest) - cross.transpose() * inner.solve(&own)))
}

/// What rides know of the tyres: priors on nothing of theirs.
pub struct Known(Vec<(On, DMatrix<f64>)>);

impl Known {
    /// That of rides of 8 minutes each.
    pub fn of(rides: &[Ride], free: &Free) -> Option<Self> {
        let mut by_machine: Vec<(On, DMatrix<f64>)> = Vec::new();
        for ride in rides {
            let (matrix, pull) = ride.normal(free);
            let (left, _) = without_first(&matrix, &pull, free.ride)?;
            let left = left * (RIDE / ride.duration);
            match by_machine.iter_mut().find(|(on, _)| *on == ride.on) {
                Some((_, sum)) => *sum += left,
                None => by_machine.push((ride.on, left)),
            }
        }
        Some(Known(by_machine))
    }

    /// Standard deviations of what is asked for, in its units, after `times` as many rides: nothing is known
    /// beforehand of the ratios, or of the twisting stiffnesses, whichever is asked.
    pub fn deviations(&self, free: &Free, times: f64) -> Option<[f64; 4]> {
        let tyres = free.tyres();
        let mut sum = DMatrix::zeros(tyres.len(), tyres.len());
        for (_, matrix) in &self.0 {
            let mut matrix = matrix * times;
            for i in 0..free.machine {
                matrix[(i, i)] += free.all[free.ride + i].prior.powi(-2);
            }
            let nil = DVector::zeros(matrix.nrows());
            sum += without_first(&matrix, &nil, free.machine)?.0;
        }
        let mut out = [f64::NAN; 4];
        for (k, asked) in ASKED.into_iter().enumerate() {
            let kind = asked.split('_').next().unwrap_or_default();
            let mut matrix = sum.clone();
            for (i, p) in tyres.iter().enumerate() {
                let prior = if p.name.starts_with(kind) { FREE } else { p.prior };
                matrix[(i, i)] += prior.powi(-2);
            }
            let j = tyres.iter().position(|p| p.name == asked)?;
            out[k] = matrix.cholesky()?.inverse()[(j, j)].sqrt() * tyres[j].scale;
        }
        Some(out)
    }
}

/// The joint estimate of rides on one motorcycle, nothing known of the ratios beforehand: values and standard
/// deviations of what is asked for.
pub fn estimate(rides: &mut [Ride], free: &Free) -> Option<[[f64; 2]; 4]> {
    let shared: Vec<Parameter> = free.all[free.ride..]
        .iter()
        .map(|p| match p.name.starts_with("ratio") {
            true => Parameter { prior: FREE, ..*p },
            false => *p,
        })
        .collect();
    // what is shared begins at one place
    let first = rides.first()?.values.clone();
    let start = rides.first()?.start.clone();
    for ride in rides.iter_mut() {
        shared.iter().for_each(|p| p.set(&mut ride.values, p.get(&first)));
    }
    let mut covariance = DMatrix::zeros(shared.len(), shared.len());
    for round in 0..ROUNDS {
        if round > 0 && round < 5 {
            for ride in rides.iter_mut() {
                ride.sigma = base::noise(&ride.samples, &blocks(&ride.samples, &ride.values));
            }
        }
        let normals: Vec<_> = rides.iter().map(|ride| ride.normal(free)).collect();
        let mut matrix = DMatrix::zeros(shared.len(), shared.len());
        let mut pull = DVector::zeros(shared.len());
        for (own, down) in &normals {
            let (left, rest) = without_first(own, down, free.ride)?;
            matrix += left;
            pull += rest;
        }
        for (i, p) in shared.iter().enumerate() {
            rides.first()?.believe(p, &start, (&mut matrix, &mut pull), i);
        }
        let factor = matrix.cholesky()?;
        let step = factor.solve(&pull);
        covariance = factor.inverse();
        // far steps of a curved problem are shortened
        let share = (2.0 / step.amax()).min(1.0);
        for (ride, (own, down)) in rides.iter_mut().zip(&normals) {
            let inner = own.view((0, 0), (free.ride, free.ride)).into_owned().cholesky()?;
            let cross = own.view((0, free.ride), (free.ride, shared.len()));
            let of_ride = inner.solve(&(down.rows(0, free.ride) - cross * &step));
            ride.step(&free.all[..free.ride], of_ride.as_slice(), share);
            ride.step(&shared, step.as_slice(), share);
        }
        if round > 5 && step.amax() < 3e-3 {
            break;
        }
    }
    let ride = rides.first()?;
    let of = |name: &str| {
        let j = shared.iter().position(|p| p.name == name)?;
        Some([shared[j].get(&ride.values), covariance[(j, j)].sqrt() * shared[j].scale])
    };
    let mut out = [[f64::NAN; 2]; 4];
    for (to, name) in out.iter_mut().zip(ASKED) {
        *to = of(name)?;
    }
    Some(out)
}
