//! Against rides of a forward model that is made another way, see `forward`.

use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::coefficient::{Coefficient, Id};
use roadbench::internals::contract::reason::ReasonCode;
use roadbench::internals::fit::in_gear::model::{A, B, C, D, Held, Model, Split};
use roadbench::internals::fit::in_gear::parameters::*;
use roadbench::internals::fit::in_gear::{Config, InGear, columns, rows, run, solve};
use roadbench::internals::statistics::order::median_of_finite;
use roadbench::internals::store::tables::rows as tables;
use roadbench::internals::store::tables::rows::Status;

use super::forward::{self as track, USUAL};

fn fitted(seed: u64, style: track::Style) -> (Theta, InGear) {
    let truth = track::truth(seed);
    let session = track::session(seed, &truth, style);
    (truth, run(&session, &track::bike(), &Config::default()).expect("a fit"))
}

/// Several rides at once.
fn several(seeds: std::ops::Range<u64>, style: track::Style) -> Vec<(Theta, InGear)> {
    std::thread::scope(|scope| {
        let rides: Vec<_> = seeds.map(|seed| scope.spawn(move || fitted(seed, style))).collect();
        rides.into_iter().map(|ride| ride.join().expect("a ride")).collect()
    })
}

/// Half of a 95 % interval.
fn half(fit: &InGear, k: usize) -> f64 {
    1.96 * fit.fitted.covariance[(k, k)].sqrt()
}

/// The table's row of a coefficient that the ordinary fits do not have.
fn row(fit: &InGear, tyre: &str, name: &str) -> tables::Coefficient {
    let empty = |id: Id| tables::Coefficient {
        tyre: id.part.name().into(),
        coefficient: id.coefficient.name().into(),
        status: Status::NotAvailable,
        ..tables::Coefficient::default()
    };
    let mut all: Vec<tables::Coefficient> = Id::onroad().map(empty).collect();
    assert!(rows::lacking(&all));
    filled(fit, &mut all);
    of(&all, tyre, name).clone()
}

fn filled(fit: &InGear, all: &mut Vec<tables::Coefficient>) {
    rows::fill(all, fit, 0.5, &tables::Ident::default(), &tables::Provenance::default());
}

fn of<'a>(all: &'a [tables::Coefficient], tyre: &str, name: &str) -> &'a tables::Coefficient {
    let own = |r: &&tables::Coefficient| r.tyre == tyre && r.coefficient == name;
    all.iter().find(own).expect("a row")
}

#[test]
fn residuals_vanish_at_the_truth_of_an_exact_log() {
    let truth = track::truth(3);
    let session = track::session(3, &truth, track::Style { rate: 100.0, noise: 0.0, ..USUAL });
    let columns = columns::columns(&session, &Config::default()).expect("columns");
    let bike = track::bike();
    let model = Model::new(&columns, &bike, 0.87);
    let held = solve::held_at(&model, &truth, 8.0);
    let middle = |kind: usize, pick: &dyn Fn(&Held) -> bool| {
        let of = |h: &&Held| h.sigma[kind].is_finite() && pick(h);
        let values: Vec<f64> = held
            .iter()
            .filter(of)
            .map(|h| model.evaluate(&truth, h).residual[kind].abs())
            .collect();
        assert!(values.len() > 15, "{kind}: {}", values.len());
        median_of_finite(&values).expect("residuals")
    };
    let leaning = |h: &Held| columns.roll[h.at].abs() > 0.35;
    assert!(middle(A, &|_| true) < 0.01);
    assert!(middle(B, &leaning) < 0.02);
    // the slip grows faster than the force: what the kernel averages is a little more than what it sees
    assert!(middle(B, &|h| !leaning(h) && h.split == Split::Free) < 0.08);
    assert!(middle(C, &|_| true) < 60.0);
    // the true ratios are not those of the table
    assert!(middle(D, &|_| true) < 30.0);
}

/// Twelve rides of machines drawn around the priors: rms error, coverage, and no peak that was not reached.
#[test]
fn twelve_rides_give_back_what_made_them() {
    let rides = several(100..112, USUAL);
    // the bars of the prototype, see `in-gear.md` in the shared designs: 10 Hz with pressures
    for (k, bar) in [
        (R_F, 0.0011 * 0.298),
        (R_R, 0.0021 * 0.322 * 1.3),
        (RHO_F, 0.0020),
        (RHO_R, 0.0038),
        (K_F, 0.11),
        (K_R, 0.11),
        (BRAKE_F, 0.06),
        (LATENCY, 0.010),
    ] {
        let errors: Vec<f64> =
            rides.iter().map(|(truth, fit)| fit.fitted.theta[k] - truth[k]).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        let pairs = errors.iter().zip(&rides);
        let covered = pairs.filter(|(e, (_, fit))| e.abs() < half(fit, k)).count();
        assert!(rms < bar, "{}: rms {rms:.5} of {bar:.5}", WORDS[k]);
        assert!(covered >= 10, "{}: {covered} of 12", WORDS[k]);
    }
    let mut short = 0;
    for (truth, fit) in &rides {
        let front = row(fit, "front", Coefficient::MfD.name());
        let used = fit.bounds[0].unwrap_or(0.0);
        assert!(used < truth[D_F].exp(), "{used} of {}", truth[D_F].exp());
        if used > 0.0 && used < 0.85 * truth[D_F].exp() {
            let none = (Status::LowerBound, None, None);
            assert_eq!((front.status, front.value, front.ci95_high), none);
            assert!(front.ci95_low.is_some_and(|low| low < truth[D_F].exp()));
            short += 1;
        }
        for tyre in ["front", "rear"] {
            assert_eq!(row(fit, tyre, "effective_rolling_radius").status, Status::Ok);
            assert_eq!(row(fit, tyre, "slip_stiffness").status, Status::Ok);
            assert_ne!(row(fit, tyre, "mf_b").status, Status::Ok, "c and d are assumed");
        }
        let rolling = row(fit, "vehicle", "rolling_resistance");
        assert_eq!((rolling.status, rolling.value), (Status::NotAvailable, None));
        assert!(rolling.advice.is_some_and(|advice| advice.contains("coast in neutral")));
    }
    assert!(short >= 8, "{short}");
}

/// A car's table had a rear radius that was determined, and beside it a curve whose radius was not known.
#[test]
fn a_known_radius_has_no_curve_of_an_unknown_one_beside_it() {
    let (_, fit) = fitted(100, USUAL);
    let curve = |id: Id| {
        let is_of_curve = roadbench::internals::fit::friction::is_of_curve(id.coefficient);
        let unknown = ReasonCode::UnknownRadius.name().to_owned();
        tables::Coefficient {
            tyre: id.part.name().into(),
            coefficient: id.coefficient.name().into(),
            status: if is_of_curve { Status::PoorlyDetermined } else { Status::NotAvailable },
            value: is_of_curve.then_some(2.4),
            reason: is_of_curve.then(|| "the rolling radius is not known from this ride".into()),
            reason_code: is_of_curve.then_some(unknown),
            ..tables::Coefficient::default()
        }
    };
    let mut all: Vec<tables::Coefficient> = Id::onroad().map(curve).collect();
    filled(&fit, &mut all);
    for tyre in ["front", "rear"] {
        assert_eq!(of(&all, tyre, "effective_rolling_radius").status, Status::Ok);
        for name in ["peak_slip", "mf_c", "mf_e1", "mf_e2"] {
            let row = of(&all, tyre, name);
            assert_eq!((row.status, row.value), (Status::NotAvailable, None), "{tyre} {name}");
            assert_eq!(row.reason_code.as_deref(), Some(ReasonCode::AssumedShape.name()));
        }
    }
    assert!(all.iter().all(|r| r.reason_code.as_deref() != Some("unknown_radius")));
    assert!(all.iter().all(|r| r.reason.is_none() || r.reason_code.is_some()));
}

/// A car without a measured lean was given a crown, and a negative one.
#[test]
fn a_crown_takes_a_measured_lean_and_is_none_that_no_tyre_has() {
    let (_, mut fit) = fitted(101, USUAL);
    fit.fitted.theta[RHO_F] = -0.007;
    let crown = row(&fit, "front", "overturning_stiffness");
    assert_eq!(crown.status, Status::PoorlyDetermined);
    assert_eq!(crown.reason_code.as_deref(), Some(ReasonCode::Impossible.name()));
    assert!(crown.advice.is_some_and(|advice| advice.contains("roadbench map")));
    // a peak far beyond what was used leaves the bound
    (fit.fitted.theta[D_F], fit.bounds[0]) = (4.0_f64.ln(), Some(2.6));
    let peak = row(&fit, "front", "mf_d");
    assert_eq!((peak.status, peak.ci95_low), (Status::NotAvailable, None));
    assert_eq!(peak.reason_code.as_deref(), Some(ReasonCode::Impossible.name()));
    fit.is_roll_measured = false;
    let crown = row(&fit, "front", "overturning_stiffness");
    assert_eq!((crown.status, crown.value), (Status::NotAvailable, None));
}

#[test]
fn a_spike_of_a_wheel_speed_does_not_diverge() {
    let truth = track::truth(5);
    let mut session = track::session(5, &truth, USUAL);
    let clean = run(&session, &track::bike(), &Config::default()).expect("a fit");
    for (channel, at) in [(Channel::WheelSpeedFront, 900), (Channel::WheelSpeedRear, 1500)] {
        session.get_mut(channel).expect("wheel")[at] += 100.0; // 30 m/s
    }
    let spiked = run(&session, &track::bike(), &Config::default()).expect("still a fit");
    for k in [R_F, R_R, K_F, K_R, RHO_F, RHO_R, DRAG] {
        let moved = (spiked.fitted.theta[k] - clean.fitted.theta[k]).abs();
        assert!(moved < half(&clean, k), "{}: {moved}", WORDS[k]);
    }
}

#[test]
fn a_ride_without_what_the_fit_needs_is_left_alone() {
    let truth = track::truth(5);
    let session = track::session(5, &truth, track::Style { laps: 1, ..USUAL });
    for channel in [Channel::Roll, Channel::Throttle, Channel::WheelSpeedRear, Channel::VelocityX] {
        let mut less = session.clone();
        less.remove(channel);
        assert!(run(&less, &track::bike(), &Config::default()).is_none(), "{channel}");
    }
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
                    if let Some(b) = fit.bounds[k]
                        && b > truth[D_F + k].exp()
                    {
                        println!(
                            "bound {k} {b:.3} of {:.3} found {:.3}",
                            truth[D_F + k].exp(),
                            fit.fitted.theta[D_F + k].exp()
                        );
                    }
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
