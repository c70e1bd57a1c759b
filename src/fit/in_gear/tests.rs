use super::parameters::*;
use super::track::{self, USUAL};
use super::{Config, InGear, run};
use crate::contract::channel::Channel;

fn fitted(seed: u64, style: track::Style) -> (Theta, InGear) {
    let truth = track::truth(seed);
    let session = track::session(seed, &truth, style);
    (truth, run(&session, &track::bike(), &Config::default()).expect("a fit"))
}

/// Half of a 95 % interval.
fn half(fit: &InGear, k: usize) -> f64 {
    1.96 * fit.fitted.covariance[(k, k)].sqrt()
}

#[test]
#[ignore = "figures: prints every parameter of one session"]
fn print_one() {
    let (truth, fit) = fitted(3, USUAL);
    let f = &fit.fitted;
    println!(
        "clusters {} counts {:?} scale {:?} outliers {:.3} {}",
        f.clusters, f.counts, f.scale, f.outliers, f.converged
    );
    for k in 0..COUNT {
        println!(
            "{:45} true {:8.4} found {:8.4} +- {:.4} prior {:.4} +- {:.4}",
            WORDS[k],
            truth[k],
            f.theta[k],
            half(&fit, k),
            fit.prior.mean[k],
            1.96 * fit.prior.sd[k]
        );
    }
    println!("bounds {:?} of {:.3} {:.3}", fit.bounds, truth[D_F].exp(), truth[D_R].exp());
}

#[test]
#[ignore = "figures: many sessions"]
fn print_many() {
    let styles = [
        ("usual", USUAL),
        ("slope 1 %, wind 4 m/s", track::Style { slope: 0.01, wind: 4.0, ..USUAL }),
    ];
    for (name, style) in styles {
        for with in [true, false] {
            let mut table = vec![Vec::new(); COUNT];
            let (mut held, mut n) = (0, 0);
            for seed in 100..112 {
                let truth = track::truth(seed);
                let mut session = track::session(seed, &truth, style);
                if !with {
                    session.remove(Channel::BrakePressureFront);
                    session.remove(Channel::BrakePressureRear);
                }
                let Some(fit) = run(&session, &track::bike(), &Config::default()) else {
                    println!("none {seed}");
                    continue;
                };
                n += 1;
                for k in 0..2 {
                    if let Some(b) = fit.bounds[k] && b > truth[D_F + k].exp() { println!("bound {k} {b:.3} of {:.3} found {:.3}", truth[D_F + k].exp(), fit.fitted.theta[D_F + k].exp()); }
                    held += usize::from(fit.bounds[k].is_none_or(|b| b < truth[D_F + k].exp()));
                }
                for k in 0..COUNT {
                    table[k].push((fit.fitted.theta[k] - truth[k], half(&fit, k)));
                }
            }
            println!("== {name} pressures {with}: bounds held {held} of {}", 2 * n);
            for k in [
                R_F, R_R, K_F, K_R, K_D, D_R, RHO_F, RHO_R, DRAG, BRAKE_F, BRAKE_R, LATENCY,
                LEAN_ZERO,
            ] {
                let t = &table[k];
                let rms = (t.iter().map(|x| x.0 * x.0).sum::<f64>() / t.len() as f64).sqrt();
                let mean = t.iter().map(|x| x.0).sum::<f64>() / t.len() as f64;
                let covered = t.iter().filter(|x| x.0.abs() < x.1).count();
                let mut h: Vec<f64> = t.iter().map(|x| x.1).collect();
                h.sort_by(f64::total_cmp);
                println!(
                    "{:40} rms {:.5} bias {:+.5} half {:.5} covered {}/{}",
                    WORDS[k],
                    rms,
                    mean,
                    h.get(h.len() / 2).copied().unwrap_or(f64::NAN),
                    covered,
                    t.len()
                );
            }
        }
    }
}

#[test]
#[ignore = "figures"]
fn print_residuals_at_truth() {
    use super::model::{Model, Split};
    for (rate, seed) in [(100.0, 3), (10.0, 3)] {
        let truth = track::truth(seed);
        let session = track::session(seed, &truth, track::Style { rate, noise: 0.0, ..USUAL });
        let columns = super::columns::columns(&session, &Config::default()).expect("columns");
        let bike = track::bike();
        let model = Model::new(&columns, &bike, 0.87);
        let held = super::solve::held_at(&model, &truth, 8.0);
        for (name, pick) in [("drive", 0), ("coast", 1), ("braked", 2)] {
            for lean in [false, true] {
                let mut sums = vec![Vec::new(); 4];
                let mut ax = Vec::new();
                for h in &held {
                    let group = if h.split == Split::Braked { 2 } else { usize::from(columns.closed[h.at]) };
                    if group != pick || (columns.roll[h.at].abs() > 0.35) != lean { continue; }
                    let found = model.evaluate(&truth, h);
                    ax.push(found.force[1]);
                    for k in 0..4 {
                        if h.sigma[k].is_finite() { sums[k].push(found.residual[k]); }
                    }
                }
                print!("{rate} {name} lean {lean} n {} F_r {:.0}: ", ax.len(), ax.iter().sum::<f64>() / ax.len() as f64);
                for s in &mut sums {
                    let n = s.len();
                    let mean = s.iter().sum::<f64>() / n as f64;
                    s.sort_by(f64::total_cmp);
                    if n > 0 { print!(" {:.3} [{:.3} {:.3} {:.3}] n{n};", mean, s[n/10], s[n/2], s[9*n/10]); } else { print!(" -;"); }
                }
                println!();
            }
        }
    }
}
