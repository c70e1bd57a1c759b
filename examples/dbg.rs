use nalgebra::{DMatrix, DVector};
use roadbench::contract::bike::Bike;
use roadbench::diagnose::Settings;
use roadbench::diagnose::road::null_simulation::NullSimulation;
use roadbench::diagnose::road::replay::From;
use roadbench::diagnose::road::residuals::CHANNELS;
use roadbench::diagnose::road::problem::Problem;
use roadbench::diagnose::road::samples::{BLOCK, Samples};
use roadbench::diagnose::road::{self, Fitted};
use roadbench::pipeline::{self, Pipeline};
use std::collections::BTreeMap;
fn main() {
    let dir = std::env::args().nth(1).unwrap();
    let name = std::env::args().nth(2).unwrap();
    let only = |part: &str| std::fs::read_dir(format!("{dir}/{part}")).unwrap().next().unwrap().unwrap().path();
    let bike = Bike::read(&only("bikes")).unwrap();
    let (session, _) = pipeline::prepare(only("sessions"), &[], &bike, &Pipeline::onroad()).map_err(|e| e.message).unwrap();
    let Fitted { session, segments, samples, base } = road::fitted(&session, &bike, &Pipeline::onroad()).map_err(|e| e.message).unwrap();
    let effects = Settings::default().effects;
    let start = base.starting_point(&samples, &effects);
    let near = &start.near;
    for p in &near.parameters { print!("{} {:.4} ({:+.1})  ", p.name, p.get(&near.values), (p.get(&near.values)-p.get(&near.start))/p.scale/p.prior); }
    println!();
    let effect = effects.iter().find(|e| e.name == name).unwrap();
    let mut all = near.parameters.clone(); all.push(effect.parameter());
    let _ = (&segments, NullSimulation::new(&session, &segments, &start.noise, 1).noiseless(&near.values, From::Session));
    let samples: &Samples = &samples;
    let problem = Problem::new(samples, &near.start, near.sigma, &all);
    let linear = problem.linear(&near.values);
    let p = all.len();
    let mut m = DMatrix::zeros(p, p); let mut g = DVector::zeros(p);
    for (_, r) in &samples.manoeuvres { problem.accumulate(&linear, r.start / BLOCK..r.end / BLOCK, &mut m, &mut g); }
    m.fill_lower_triangle_with_upper_triangle();
    for (i, q) in all.iter().enumerate().take(p - 1) { m[(i, i)] += 1.0 / (q.prior * q.prior); }
    let b = p - 1;
    let a = m.view((0, 0), (b, b)).into_owned();
    let c = m.view((0, b), (b, 1)).into_owned();
    let coef = a.cholesky().unwrap().solve(&c);
    let mut cells: BTreeMap<(String, usize), (f64, f64, usize)> = BTreeMap::new();
    for (kind, r) in &samples.manoeuvres {
        for bl in r.start / BLOCK..r.end / BLOCK { for ch in 0..8 {
            let Some((z, w)) = problem.weigh(&linear, ch, bl) else { continue };
            let mut x = linear.columns[b][ch][bl];
            for i in 0..b { x -= coef[(i, 0)] * linear.columns[i][ch][bl]; }
            let x = x / near.sigma[ch];
            let e = cells.entry((kind.name().to_owned(), ch)).or_default();
            e.0 -= w * x * z; e.1 += w * x * x; e.2 += 1;
        } }
    }
    let (t, i) = cells.values().fold((0.0, 0.0), |s, e| (s.0 + e.0, s.1 + e.1));
    println!("{name}: size {:.3} sd {:.3} in usual", t / i, 1.0 / i.sqrt());
    for ((k, ch), e) in &cells { if e.1 / i > 0.01 || (e.0 / t).abs() > 0.05 { println!("  {k:16} {:14} pull {:8.2} information {:8.2} own size {:6.2} n {}", CHANNELS[*ch], e.0, e.1, e.0 / e.1, e.2); } }
    let mut co: Vec<(f64, &str)> = (0..b).map(|i| (coef[(i, 0)], near.parameters[i].name)).collect();
    co.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    println!("  like: {:?}", &co[..6]);
}
