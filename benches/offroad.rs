//! The cost of the off-road estimate, in multiples of real time at 1.6 kHz on one core, beside
//! `scipy.optimize.nnls` in a loop on the same problems in the same run.
//!
//! `cargo bench --no-default-features --bench offroad`; the yardstick needs python3 with scipy.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Instant;

use roadbench::internals::estimate::offroad::contact::Contact;
use roadbench::internals::estimate::offroad::kinematics::Kinematics;
use roadbench::internals::estimate::offroad::rider::{self, Base, Rider};
use roadbench::internals::estimate::offroad::solve::{
    BRAKING, Config as SolveConfig, DRIVING, Solver,
};
use roadbench::internals::estimate::offroad::weights::Weights;
use roadbench::internals::estimate::offroad::{self, Config};
use roadbench::internals::filter;
use roadbench::internals::motorcycle::offroad::planar::PlanarMotorcycle;
use roadbench::internals::simulate::motocross::{self, scenario::Motocross};

const RATE: f64 = 1600.0;
/// Problems handed to scipy.
const PROBLEMS: usize = 20_000;

/// Best of several runs, s.
fn best(mut work: impl FnMut()) -> f64 {
    (0..7)
        .map(|_| {
            let begin = Instant::now();
            work();
            begin.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let scenario = Motocross::load("motocross").expect("scenario").expect("built in");
    let begin = Instant::now();
    let mut session = motocross::ride(&scenario, 0).session;
    let simulated = begin.elapsed().as_secs_f64();
    let n = session.len;
    let raw = session.clone();
    let filter_config = roadbench::internals::pipeline::Pipeline::builtin("offroad").filter;
    filter::run(&mut session, &filter_config);
    let say = |what: &str, samples: usize, seconds: f64| {
        let rate = samples as f64 / seconds;
        println!("{what:46} {:9.3} M samples/s {:8.0} x real time", rate * 1e-6, rate / RATE);
        rate
    };
    println!("{n} samples at {RATE} Hz, one core");
    say("simulation", n, simulated);

    let config = Config { riders: vec![Rider::B], ..Config::default() };
    say("filter", n, {
        let mut work = raw.clone();
        best(|| {
            work = raw.clone();
            filter::run(&mut work, &filter_config);
        })
    });
    let machine = PlanarMotorcycle::new(&scenario.bike).expect("bike");
    say("kinematics", n, best(|| drop(Kinematics::new(&session, &machine))));
    let (k, _) = Kinematics::new(&session, &machine);
    say("wheels off", n, best(|| drop(Contact::detect(&k, &machine, &config.contact))));
    let contact = Contact::detect(&k, &machine, &config.contact);
    let p = machine.equations.p;
    let base = Base {
        rate: k.rate,
        mu: &k.mu,
        mud: &k.mud,
        xdd: &k.xdd,
        zdd: &k.zdd,
        airborne: &contact.airborne,
    };
    let ride = |which| rider::forces(which, &machine.rider, p.peg, p.bar, &base, &config.rider);
    for which in [Rider::A, Rider::B, Rider::C] {
        let seconds = best(|| drop(ride(which)));
        say(&format!("rider {}", which.name()), n, seconds);
    }
    let forces = vec![ride(Rider::B).expect("rider b")];
    let solver = Solver::new(&machine, k.lost, &config.solve);
    let own = say("equations and NNLS", n, best(|| drop(solver.run(&k, &contact, &forces))));
    say(
        "whole estimate, rider b",
        n,
        best(|| drop(offroad::run(&session, &scenario.bike, &config))),
    );
    let all = Config::default();
    say(
        "whole estimate, riders none, a, b, c",
        n,
        best(|| drop(offroad::run(&session, &scenario.bike, &all))),
    );

    // the same problems for scipy: ten rows, five unknowns
    let weights = Weights::lengths(&machine.equations, [false; 5]);
    let lengths =
        SolveConfig { weights: offroad::solve::RowWeights::Lengths, ..config.solve.clone() };
    let plain = Solver::new(&machine, k.lost, &lengths);
    let mut bytes = Vec::new();
    let mut problems = Vec::new();
    for i in (0..n).step_by((n / PROBLEMS).max(1)).take(PROBLEMS) {
        let at = machine.equations.at(&k.motion(i));
        let known = at.known(
            &[k.xdd[i], k.zdd[i], k.mudd[i], k.zdd_f[i], k.add_r[i]],
            [k.f_sf[i], k.t_sr[i]],
            roadbench::GRAVITY,
        );
        let b = at.less_rider(&known, &forces[0].at(i));
        let free = if at.along(&b) > 0.0 { DRIVING } else { BRAKING };
        let off = [contact.front.fade[i], contact.rear.fade[i]];
        for row in 0..5 {
            for column in 0..5 {
                let v = if free[column] { weights.b_d[row][row] * at.at[row][column] } else { 0.0 };
                bytes.extend_from_slice(&v.to_le_bytes());
            }
        }
        for row in 0..5 {
            let hold = [off[0], off[1], off[0], off[1], off[1]][row];
            let hold = if free[row] { lengths.constraint * hold } else { 1e3 };
            for column in 0..5 {
                bytes.extend_from_slice(&(if row == column { hold } else { 0.0 }).to_le_bytes());
            }
        }
        for row in 0..10 {
            let v = if row < 5 { weights.b_d[row][row] * b[row] } else { 0.0 };
            bytes.extend_from_slice(&f64::to_le_bytes(v));
        }
        problems.push((at.at, b, free, off));
    }
    let mut sum = [0.0; 5];
    let seconds = best(|| {
        sum = [0.0; 5];
        for (at, b, free, off) in &problems {
            let f = plain.sample(at, b, *free, *off);
            (0..5).for_each(|k| sum[k] += f[k]);
        }
    });
    let alone = say("NNLS alone, matrices given", problems.len(), seconds);
    match scipy(&bytes, problems.len()) {
        Ok((rate, theirs)) => {
            println!(
                "{:46} {:9.3} M samples/s {:8.1} x real time",
                "scipy.optimize.nnls in a loop",
                rate * 1e-6,
                rate / RATE
            );
            println!(
                "ours / scipy: {:.0} (NNLS alone), {:.0} with the equations",
                alone / rate,
                own / rate
            );
            let apart = (0..5).map(|k| (sum[k] - theirs[k]).abs() / theirs[k].abs().max(1.0));
            println!("sums of the forces differ by at most {:.1e}", apart.fold(0.0, f64::max));
        }
        Err(why) => println!("scipy.optimize.nnls: not measured ({why})"),
    }
}

const SCRIPT: &str = "
import sys, time, numpy as np
from scipy.optimize import nnls
x = np.frombuffer(sys.stdin.buffer.read()).reshape(-1, 60)
A = np.ascontiguousarray(x[:, :50]).reshape(-1, 10, 5); b = np.ascontiguousarray(x[:, 50:])
best = 1e9
for _ in range(3):
    s = np.zeros(5); t = time.perf_counter()
    for i in range(len(A)): s += nnls(A[i], b[i])[0]
    best = min(best, time.perf_counter() - t)
print(len(A) / best, *s)
";

/// Problems per second and the sums of the solutions.
fn scipy(bytes: &[u8], count: usize) -> Result<(f64, Vec<f64>), String> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut child = Command::new(python)
        .args(["-c", SCRIPT])
        .env("OMP_NUM_THREADS", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| e.to_string())?;
    let mut input = child.stdin.take().ok_or("no input")?;
    let written = input.write_all(bytes);
    drop(input);
    let output = child.wait_with_output().map_err(|e| e.to_string())?;
    written.map_err(|e| format!("{e}: is scipy installed?"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    match numbers.split_first() {
        Some((rate, sums)) if sums.len() == 5 && count > 0 => Ok((*rate, sums.to_vec())),
        _ => Err("python3 with scipy did not answer".to_owned()),
    }
}
