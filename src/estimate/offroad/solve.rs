//! The tyre forces, sample by sample: constrained non-negative least squares.
//!
//! ```text
//! minimise | B_d (A_t f - b_1) |^2 + | B_c W f |^2,   f = [N_f, N_r, B_f, B_r, D_r] >= 0
//! ```
//! Drive and brake exclude each other, as the paper has it: throttle and brake pressures show
//! which, where they are logged, the sign of the sum along the chassis otherwise. The columns of the other branch
//! are left out, which is `B_c -> infinity` and better conditioned (book, Off the road, section 7). A
//! wheel that is off the ground is held to zero by `B_c`, faded over the switching.
//!
//! Source: Vasquez et al. 2019, eqs. 3 to 6.

use serde::{Deserialize, Serialize};

use super::contact::Contact;
use super::kinematics::Kinematics;
use super::nnls;
use super::rider::Forces;
use super::weights::{Weights, determined};
use crate::GRAVITY;
use crate::motorcycle::offroad::equations::Motion;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;

/// Which rows count how much.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RowWeights {
    /// By the noise of the bike file where it gives all of it, by lengths otherwise.
    #[default]
    Noise,
    /// Moments over wheelbase and swing arm.
    Lengths,
}

/// Settings of the solution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Which rows count how much.
    pub weights: RowWeights,
    /// `B_c`: how hard a wheel in the air is held to no force.
    pub constraint: f64,
    /// Drive and brake change places when the sum along the chassis is beyond this, N.
    pub dead_band: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config { weights: RowWeights::Noise, constraint: 10.0, dead_band: 30.0 }
    }
}

/// Tyre forces along the chassis' axes, N; NaN where they are not determined.
#[derive(Debug, Clone, Default, PartialEq)]
#[allow(missing_docs)] // the symbols of the paper
pub struct TyreForces {
    pub n_f: Vec<f64>,
    pub n_r: Vec<f64>,
    pub b_f: Vec<f64>,
    pub b_r: Vec<f64>,
    pub d_r: Vec<f64>,
}

/// The forces' names, in the order of `f_t`.
pub(crate) const NAMES: [&str; 5] = ["n_f", "n_r", "b_f", "b_r", "d_r"];

impl TyreForces {
    fn with_capacity(n: usize) -> Self {
        let empty = || Vec::with_capacity(n);
        TyreForces { n_f: empty(), n_r: empty(), b_f: empty(), b_r: empty(), d_r: empty() }
    }

    #[inline]
    fn push(&mut self, f: [f64; 5]) {
        let [n_f, n_r, b_f, b_r, d_r] = f;
        self.n_f.push(n_f);
        self.n_r.push(n_r);
        self.b_f.push(b_f);
        self.b_r.push(b_r);
        self.d_r.push(d_r);
    }

    /// The columns, in the order of `f_t`.
    pub fn columns(&self) -> [&[f64]; 5] {
        [&self.n_f, &self.n_r, &self.b_f, &self.b_r, &self.d_r]
    }

    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub fn len(&self) -> usize {
        self.n_f.len()
    }
}

/// The unknowns of the two branches.
pub const DRIVING: [bool; 5] = [true, true, false, false, true];
/// As [`DRIVING`].
pub const BRAKING: [bool; 5] = [true, true, true, true, false];

/// Ready to solve samples of one bike.
#[derive(Debug, Clone)]
pub struct Solver<'a> {
    machine: &'a PlanarMotorcycle,
    weights: Weights,
    constraint: f64,
    dead_band: f64,
    /// Determined forces while braking and while driving.
    known: [[bool; 5]; 2],
}

impl<'a> Solver<'a> {
    /// A solver for the rows that the channels allow.
    pub fn new(machine: &'a PlanarMotorcycle, lost: [bool; 5], config: &Config) -> Self {
        let equations = &machine.equations;
        let weights = match (&machine.noise, config.weights) {
            (Some(noise), RowWeights::Noise) => Weights::whitening(equations, noise, lost),
            _ => Weights::lengths(equations, lost),
        };
        Solver {
            machine,
            weights,
            constraint: config.constraint,
            dead_band: config.dead_band,
            known: [determined(machine, lost, BRAKING), determined(machine, lost, DRIVING)],
        }
    }

    /// Names of the forces that are lost in one branch or both, with the branch.
    pub fn unavailable(&self) -> Vec<String> {
        let mut out = Vec::new();
        for (branch, (known, free)) in
            ["braking", "driving"].iter().zip(self.known.iter().zip([BRAKING, DRIVING]))
        {
            for k in 0..5 {
                if free[k] && !known[k] {
                    out.push(format!("{} while {branch}", NAMES[k]));
                }
            }
        }
        out
    }

    /// The forces of one sample from `A_t` (with the chain) and `b_1`. `off` fades a wheel's
    /// forces out: front, rear, 0 on the ground to 1 in the air.
    #[inline]
    pub fn sample(
        &self,
        at: &[[f64; 5]; 5],
        b: &[f64; 5],
        free: [bool; 5],
        off: [f64; 2],
    ) -> [f64; 5] {
        let right = self.weights.apply(b);
        let mut columns = [[0.0; 5]; 5];
        for j in 0..5 {
            if free[j] {
                columns[j] =
                    self.weights.apply(&[at[0][j], at[1][j], at[2][j], at[3][j], at[4][j]]);
            }
        }
        let mut g = [[0.0; 5]; 5];
        let mut c = [0.0; 5];
        for i in 0..5 {
            if !free[i] {
                continue;
            }
            let a = &columns[i];
            c[i] = a[0] * right[0]
                + a[1] * right[1]
                + a[2] * right[2]
                + a[3] * right[3]
                + a[4] * right[4];
            for j in 0..=i {
                let e = &columns[j];
                let v = a[0] * e[0] + a[1] * e[1] + a[2] * e[2] + a[3] * e[3] + a[4] * e[4];
                g[i][j] = v;
                g[j][i] = v;
            }
        }
        let [front, rear] = off.map(|o| (self.constraint * o) * (self.constraint * o));
        g[0][0] += front;
        g[2][2] += front;
        for k in [1, 3, 4] {
            g[k][k] += rear;
        }
        nnls::solve(&g, &c, free)
    }

    /// The forces over a session, for several riders at once.
    pub fn run(&self, k: &Kinematics, contact: &Contact, riders: &[Forces]) -> Vec<TyreForces> {
        let n = k.len();
        let machine = self.machine;
        let equations = &machine.equations;
        let p = &equations.p;
        let mut out: Vec<TyreForces> =
            riders.iter().map(|_| TyreForces::with_capacity(n)).collect();
        let mut driving = vec![true; riders.len()];
        for i in 0..n {
            let at = equations.at(&k.motion(i));
            let mut base = at.known(
                &[k.xdd[i], k.zdd[i], k.mudd[i], k.zdd_f[i], k.add_r[i]],
                [k.f_sf[i], k.t_sr[i]],
                GRAVITY,
            );
            let speed = k.xd[i];
            if speed.is_finite() {
                base[0] += machine.drag * speed * speed.abs();
            }
            let kappa = machine.chain.kappa(equations, k.a_r[i]);
            let spin = p.i[0] * (k.mudd[i] - k.add_r[i] + k.mu1dd[i]);
            for (r, rider) in riders.iter().enumerate() {
                let mut b = at.less_rider(&base, &rider.at(i));
                if !(b[0] + b[1] + b[2] + b[3] + b[4]).is_finite() {
                    out[r].push([f64::NAN; 5]);
                    continue;
                }
                let along = at.along(&b);
                match k.levers.get(i) {
                    Some(1) => driving[r] = true,
                    Some(-1) => driving[r] = false,
                    _ if along.abs() > self.dead_band => driving[r] = along > 0.0,
                    _ => {}
                }
                let mut a_t = at.at;
                let (free, known) = if driving[r] {
                    a_t[4][4] += kappa * p.r_r;
                    b[4] += kappa * spin;
                    (DRIVING, &self.known[1])
                } else {
                    (BRAKING, &self.known[0])
                };
                let mut f =
                    self.sample(&a_t, &b, free, [contact.front.fade[i], contact.rear.fade[i]]);
                for j in 0..5 {
                    if free[j] && !known[j] {
                        f[j] = f64::NAN;
                    }
                }
                out[r].push(f);
            }
        }
        out
    }
}

impl Kinematics {
    /// Inputs of the matrices, at a sample.
    #[inline]
    pub fn motion(&self, i: usize) -> Motion {
        Motion {
            mu: self.mu[i],
            z_f: self.z_f[i],
            a_r: self.a_r[i],
            mud: self.mud[i],
            zd_f: self.zd_f[i],
            ad_r: self.ad_r[i],
            mu1dd: self.mu1dd[i],
            mu4dd: self.mu4dd[i],
        }
    }
}
