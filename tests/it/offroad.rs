//! The off-road estimate against the forward model, whose tyre forces are known, and against
//! damaged logs.

use arrow::array::{Array, AsArray};
use arrow::datatypes::Float64Type;
use rayon::prelude::*;

use roadbench::GRAVITY;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::contract::warning::Warning;
use roadbench::internals::estimate::offroad::rider::Rider;
use roadbench::internals::estimate::offroad::solve::{BRAKING, RowWeights, Solver};
use roadbench::internals::estimate::offroad::weights::Weights;
use roadbench::internals::estimate::offroad::{self, Config, Estimate};
use roadbench::internals::filter;
use roadbench::internals::motorcycle::offroad::equations::Motion;
use roadbench::internals::motorcycle::offroad::planar::PlanarMotorcycle;
use roadbench::internals::pipeline::{self, Input, Outcome, Pipeline};
use roadbench::internals::segment::manoeuvre::ManoeuvreKind;
use roadbench::internals::simulate::motocross::machine::{ForwardModel, Levers, Touching};
use roadbench::internals::simulate::motocross::scenario::{BUILTIN, Motocross};
use roadbench::internals::simulate::motocross::{self, MotocrossRide, pilot};
use roadbench::internals::store::tables::rows::Status;

fn scenario() -> Motocross {
    Motocross::load("motocross").expect("scenario").expect("built in")
}

type Ridden = (Motocross, MotocrossRide);

/// One noisy minute, and all that is said of it: to ride it takes longer than what is looked at.
#[test]
fn of_a_minute_of_motocross() {
    let scenario = scenario();
    let ride = motocross::ride(&scenario, 0);
    assert_eq!(ride.fall, None);
    let ridden = (scenario, ride);
    let looked_at: [fn(&Ridden); 11] = [
        riders_are_ranked_against_the_truth,
        weights_by_noise_beat_weights_by_length,
        flights_and_the_sign_of_the_drive_are_found,
        jumps_whoops_and_corners_are_segments_with_their_figures,
        every_single_missing_channel_is_named_and_the_rest_is_estimated,
        loggers_that_are_apart_are_noticed,
        wrong_signs_zeros_and_gravity_are_noticed,
        lever_arms_and_levers_are_read,
        tables_of_a_session_say_the_same_as_the_estimate,
        a_saturated_accelerometer_hides_its_landings_and_nothing_else,
        odd_logs_go_through_the_pipeline,
    ];
    looked_at.par_iter().for_each(|look| look(&ridden));
}

/// As `pipelines/offroad.toml` does it.
fn filtered(session: &Session) -> Session {
    let mut session = session.clone();
    filter::run(&mut session, &Pipeline::builtin("offroad").filter);
    session
}

fn estimate(session: &Session, bike: &Bike, config: &Config) -> (Estimate, Vec<Warning>) {
    let session = filtered(session);
    offroad::run(&session, bike, config).expect("estimated")
}

fn only(riders: &[Rider]) -> Config {
    Config { riders: riders.to_vec(), ..Config::default() }
}

fn band(x: &[f64], rate: f64) -> Vec<f64> {
    let mut x = x.to_vec();
    filter::high_cut(&mut x, rate, 20.0);
    x
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b).filter(|(a, _)| a.is_finite());
    let n = pairs.clone().count() as f64;
    (pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / n).sqrt()
}

/// Contact as the estimate assumes it, exact motion, the true rider: the forces come back.
#[test]
fn what_the_forward_model_did_comes_back_to_rounding() {
    let text = BUILTIN[0].1.replace("touching = \"normal\"", "touching = \"chassis\"");
    let scenario = Motocross::parse(&text, "round trip".as_ref()).expect("scenario");
    let plant: ForwardModel = scenario.forward_model(0);
    assert_eq!(plant.touching, Touching::Chassis);
    let machine = &plant.machine;
    let solver = Solver::new(machine, [false; 5], &Config::default().solve);
    let p = machine.equations.p;
    let mut state = plant.start(8.0);
    let mut decision = pilot::Decision::default();
    let (mut driven, mut braked, mut worst) = (0, 0, 0.0_f64);
    let dt = 1.0 / 3200.0;
    for i in 0..3200 * 16 {
        let airborne = false;
        let r = plant.respond(&state, &decision.levers, airborne, decision.commanded);
        if i % 32 == 0 {
            decision = pilot::decide(&plant, &state, &r, airborne);
            // the estimate takes engine braking for the brake's: none here
            decision.levers = Levers { drive: decision.levers.drive.max(0.0), ..decision.levers };
        }
        let (q, qd) = (state.q(), state.qd());
        let truth = r.along_chassis(q[2]);
        let possible = truth.iter().all(|f| *f >= 0.0) && state.levers().drive >= 0.0;
        if i % 16 == 0 && possible {
            let motion = Motion {
                mu: q[2],
                z_f: q[3],
                a_r: q[4],
                mud: qd[2],
                zd_f: qd[3],
                ad_r: qd[4],
                mu1dd: r.spin[0],
                mu4dd: r.spin[1],
            };
            let at = machine.equations.at(&motion);
            let mut base = at.known(&r.qdd, r.suspension, GRAVITY);
            base[0] += machine.drag * qd[0] * qd[0].abs();
            let mut b = at.less_rider(&base, &r.rider);
            let mut a_t = at.at;
            // rear drive and rear brake at once is what the estimate excludes; a front wheel that is
            // driven on has a little B_f, which it excludes too, but here is asked for
            let (engine, rear_brake) = (state.levers().drive, state.levers().rear);
            let driving = engine > 1e-6 || truth[4] > 0.0;
            if !(driving && (truth[3] > 0.0 || rear_brake > 1e-6)) {
                let free = if driving {
                    let kappa = machine.chain.kappa(&machine.equations, q[4]);
                    a_t[4][4] += kappa * p.r_r;
                    b[4] += kappa * p.i[0] * (r.qdd[2] - r.qdd[4] + r.spin[0]);
                    driven += 1;
                    [true, true, true, false, true]
                } else {
                    braked += 1;
                    BRAKING
                };
                let f = solver.sample(&a_t, &b, free, [0.0; 2]);
                let scale = truth.iter().fold(100.0_f64, |m, v| m.max(*v));
                for k in 0..5 {
                    worst = worst.max((f[k] - truth[k]).abs() / scale);
                }
            }
        }
        state = plant.step(&state, &r, &decision.levers, airborne, decision.commanded, dt);
    }
    println!("{driven} driven, {braked} braked samples, largest relative error {worst:.1e}");
    assert!(driven > 500 && braked > 300);
    assert!(worst < 1e-9, "{worst:.1e}");
}

/// The ranking of the riders on a noisy minute, as shares of the static load.
fn riders_are_ranked_against_the_truth((scenario, ridden): &Ridden) {
    let rate = ridden.session.rate;
    let (e, _) = estimate(&ridden.session, &scenario.bike, &Config::default());
    let weight = e.machine.weight();
    let truth: Vec<Vec<f64>> = ridden.truth.forces.iter().map(|f| band(f, rate)).collect();
    println!("rms error, % of the static load {weight:.0} N, against the truth below 20 Hz");
    println!("rider    N_f    N_r    B_f    B_r    D_r");
    let mut table = Vec::new();
    for rider in Rider::ALL {
        let of = e.riders.iter().find(|r| r.rider == rider).expect("rider");
        let columns = of.tyres.columns();
        let errors: Vec<f64> =
            (0..5).map(|k| 100.0 * rms(columns[k], &truth[k]) / weight).collect();
        let text: Vec<String> = errors.iter().map(|e| format!("{e:6.2}")).collect();
        println!("{:5} {}", rider.name(), text.join(" "));
        table.push(errors);
    }
    let [none, a, b, c] = &table[..] else { panic!("four riders") };
    for k in 0..5 {
        assert!(c[k] < b[k] && b[k] < a[k], "force {k}");
        assert!(b[k] < none[k], "force {k}");
    }
    // around the jumps: a second before take-off to a second after landing, the flight itself left out
    let mut near = vec![false; ridden.truth.x.len()];
    for (kind, start, end, _) in &ridden.labels {
        if *kind == ManoeuvreKind::Airborne {
            let at = |t: f64| ((t * rate).max(0.0) as usize).min(near.len());
            let (from, off, on, to) = (at(start - 1.0), at(*start), at(*end), at(end + 1.0));
            near[from..off].fill(true);
            near[on..to].fill(true);
        }
    }
    let pick = |x: &[f64]| -> Vec<f64> {
        x.iter().zip(&near).filter(|(_, n)| **n).map(|(x, _)| *x).collect()
    };
    println!("around the jumps");
    let mut jumps = Vec::new();
    for rider in [Rider::B, Rider::C] {
        let of = e.riders.iter().find(|r| r.rider == rider).expect("rider");
        let errors: Vec<f64> = (0..5)
            .map(|k| 100.0 * rms(&pick(of.tyres.columns()[k]), &pick(&truth[k])) / weight)
            .collect();
        let text: Vec<String> = errors.iter().map(|e| format!("{e:6.2}")).collect();
        println!("{:5} {}", rider.name(), text.join(" "));
        jumps.push(errors);
    }
    assert!(jumps[1][1] < 0.95 * jumps[0][1], "C gains on the rear load");
    // what was reached on this minute, with a third of margin
    for (k, most) in [4.5, 9.5, 6.5, 9.5, 8.0].into_iter().enumerate() {
        assert!(c[k] < most, "force {k}: {:.2} %", c[k]);
    }
}

/// Rows weighted by what they are worth: the moment about the centre of mass, into which all errors of
/// the rider go, counts for less.
fn weights_by_noise_beat_weights_by_length((scenario, ridden): &Ridden) {
    let truth = band(&ridden.truth.forces[0], ridden.session.rate);
    let error = |weights: RowWeights| {
        let mut config = only(&[Rider::C]);
        config.solve.weights = weights;
        let (e, _) = estimate(&ridden.session, &scenario.bike, &config);
        rms(&e.riders[0].tyres.n_f, &truth)
    };
    let (noise, lengths) = (error(RowWeights::Noise), error(RowWeights::Lengths));
    println!("front load: {noise:.0} N by noise, {lengths:.0} N by lengths");
    assert!(noise < 0.7 * lengths);
}

/// Runs of `true` at least so long.
fn events(x: &[bool], least: usize) -> Vec<(usize, usize)> {
    let mut out = Vec::new();
    let mut i = 0;
    while i < x.len() {
        let end = x[i..].iter().position(|v| *v != x[i]).map_or(x.len(), |d| i + d);
        if x[i] && end - i >= least {
            out.push((i, end));
        }
        i = end;
    }
    out
}

fn alike(p: &(usize, usize), q: &(usize, usize)) -> bool {
    let common = p.1.min(q.1) as f64 - p.0.max(q.0) as f64;
    common > 0.5 * (p.1.max(q.1) - p.0.min(q.0)) as f64
}

fn flights_and_the_sign_of_the_drive_are_found((scenario, ridden): &Ridden) {
    let rate = ridden.session.rate;
    let (e, _) = estimate(&ridden.session, &scenario.bike, &only(&[Rider::C]));
    // a flight of 60 ms is 0.7 m at 12 m/s; what is shorter is a bump
    let least = (0.06 * rate) as usize;
    let (mut hits, mut missed, mut wrong, mut edges) = (0, 0, 0, Vec::new());
    for (found, truth) in
        [(&e.contact.front.off, &ridden.truth.off[0]), (&e.contact.rear.off, &ridden.truth.off[1])]
    {
        let (all_found, all_true) = (events(found, 1), events(truth, 1));
        for p in events(truth, least) {
            match all_found.iter().find(|q| alike(&p, q)) {
                Some(q) => {
                    hits += 1;
                    edges.push(p.0.abs_diff(q.0) as f64 / rate);
                    edges.push(p.1.abs_diff(q.1) as f64 / rate);
                }
                None => missed += 1,
            }
        }
        wrong +=
            events(found, least).iter().filter(|q| !all_true.iter().any(|p| alike(p, q))).count();
    }
    let f1 = 2.0 * f64::from(hits) / (2 * hits + missed + wrong as i32) as f64;
    edges.sort_by(f64::total_cmp);
    let median = edges[edges.len() / 2];
    println!(
        "flights: F1 {f1:.3} ({hits} hit, {missed} missed, {wrong} wrong), edges {:.1} ms",
        1e3 * median
    );
    assert!(hits > 20 && f1 >= 0.97 && median <= 0.015);

    let along = |f: &[&[f64]; 5], i: usize| f[4][i] - f[3][i] - f[2][i];
    let truth: Vec<Vec<f64>> = ridden.truth.forces.iter().map(|f| band(f, rate)).collect();
    let truth: [&[f64]; 5] = std::array::from_fn(|k| truth[k].as_slice());
    let mine = e.riders[0].tyres.columns();
    let strong: Vec<usize> =
        (0..mine[0].len()).filter(|&i| along(&truth, i).abs() > 100.0).collect();
    let right = strong.iter().filter(|&&i| along(&truth, i) * along(&mine, i) > 0.0).count();
    let share = right as f64 / strong.len() as f64;
    println!("drive or brake: right in {:.1} % of {} samples", 100.0 * share, strong.len());
    assert!(share >= 0.97, "{share}");
}

fn jumps_whoops_and_corners_are_segments_with_their_figures((scenario, ridden): &Ridden) {
    let rate = ridden.session.rate;
    let session = filtered(&ridden.session);
    let (e, _) = offroad::run(&session, &scenario.bike, &only(&[Rider::C])).expect("estimated");
    let tyres = &e.riders[0].tyres;
    let ride = roadbench::internals::segment::offroad::Ride {
        rate,
        speed: &e.kinematics.xd,
        acceleration: &e.kinematics.xdd,
        pitch: &e.kinematics.mu,
        airborne: &e.contact.airborne,
        braking: [&tyres.b_f, &tyres.b_r],
        load: &tyres.n_r,
        yaw_rate: None,
    };
    let segments = roadbench::internals::segment::offroad::run(&ride, &Default::default());
    assert!(segments.windows(2).all(|w| w[0].end == w[1].start));
    let true_of = |kind: ManoeuvreKind| ridden.labels.iter().filter(move |l| l.0 == kind);
    let found = |kind: ManoeuvreKind, start: f64, end: f64| {
        segments.iter().any(|s| {
            let (a, b) = (s.start as f64 / rate, s.end as f64 / rate);
            s.kind == kind && b.min(end) - a.max(start) > 0.6 * (end - start)
        })
    };
    for kind in [ManoeuvreKind::Airborne, ManoeuvreKind::Whoops, ManoeuvreKind::Cornering] {
        let (mut all, mut hit) = (0, 0);
        for (_, start, end, _) in true_of(kind) {
            all += 1;
            hit += usize::from(found(kind, *start, *end));
        }
        println!("{kind:?}: {hit} of {all}");
        assert!(all >= 2 && hit == all, "{kind:?}: {hit} of {all}");
    }
    assert_eq!(
        segments.iter().filter(|s| s.kind == ManoeuvreKind::Airborne).count(),
        true_of(ManoeuvreKind::Airborne).count()
    );
    // landings against the truth below 20 Hz
    let load = band(&ridden.truth.forces[1], rate);
    let mut errors = Vec::new();
    for s in segments.iter().filter(|s| s.kind == ManoeuvreKind::Airborne) {
        let figures = e.figures(s);
        let time = (s.end - s.start) as f64 / rate;
        assert!((figures.flight_time.expect("flight") - time).abs() < 0.02);
        if let Some(got) = figures.landing[1] {
            let from = s.end - (0.1 * rate) as usize;
            let window = &load[from..(s.end + (0.35 * rate) as usize).min(load.len())];
            let truth = window.iter().copied().fold(0.0, f64::max);
            errors.push((got - truth) / truth);
        }
    }
    println!("rear landing loads, relative errors {errors:.3?}");
    assert!(errors.len() >= 3 && errors.iter().all(|e| e.abs() < 0.12));

    // engaged friction, made from the truth in the same way
    let with_truth = {
        let mut e = e.clone();
        let t = &mut e.riders[0].tyres;
        let truth = |k: usize| band(&ridden.truth.forces[k], rate);
        (t.n_f, t.n_r, t.b_f, t.b_r, t.d_r) = (truth(0), truth(1), truth(2), truth(3), truth(4));
        e
    };
    let ident = Default::default();
    let provenance = Default::default();
    let mine = e.coefficients(&segments, &ident, &provenance);
    let truth = with_truth.coefficients(&segments, &ident, &provenance);
    for (m, t) in mine.iter().zip(&truth) {
        let (m_value, t_value) = (m.value.expect("value"), t.value.expect("value"));
        println!(
            "{} {}: {m_value:.3} ({:.3} to {:.3}), true {t_value:.3}",
            m.tyre,
            m.coefficient,
            m.ci95_low.expect("low"),
            m.ci95_high.expect("high")
        );
        let (low, high) = (m.ci95_low.expect("low"), m.ci95_high.expect("high"));
        assert!((low..=high).contains(&t_value), "{}", m.coefficient);
        assert!((m_value - t_value).abs() < 0.15, "{}", m.coefficient);
    }
}

fn codes(warnings: &[Warning]) -> Vec<&str> {
    warnings.iter().map(|w| w.code).collect()
}

fn said<'a>(warnings: &'a [Warning], code: &str) -> &'a str {
    let found = warnings.iter().find(|w| w.code == code);
    &found.unwrap_or_else(|| panic!("no {code} in {:?}", codes(warnings))).message
}

fn every_single_missing_channel_is_named_and_the_rest_is_estimated((scenario, ridden): &Ridden) {
    let rate = ridden.session.rate;
    let truth: Vec<Vec<f64>> = ridden.truth.forces.iter().map(|f| band(f, rate)).collect();
    let (whole, _) = estimate(&ridden.session, &scenario.bike, &only(&[Rider::C]));
    let base: Vec<f64> =
        (0..5).map(|k| rms(whole.riders[0].tyres.columns()[k], &truth[k])).collect();
    let channels: Vec<Channel> = ridden.session.channels().collect();
    assert_eq!(channels.len(), 13);
    for channel in channels {
        let mut session = ridden.session.clone();
        session.remove(channel);
        let (e, warnings) = estimate(&session, &scenario.bike, &only(&[Rider::C]));
        let named = warnings.iter().any(|w| w.message.contains(channel.name()));
        assert!(named, "{channel}: {:?}", codes(&warnings));
        let columns = e.riders[0].tyres.columns();
        let error = |k: usize| match columns[k].iter().any(|v| v.is_finite()) {
            true => rms(columns[k], &truth[k]),
            false => f64::NAN,
        };
        let errors: Vec<f64> = (0..5).map(error).collect();
        let gone = warnings.iter().find(|w| w.code == "force_unavailable");
        println!("{channel:26} {errors:6.0?} {}", gone.map_or("", |w| w.message.as_str()));
        // with twelve channels both loads are still estimated; the redundant ones cost next to
        // nothing, a travel a seventh of the weight
        use Channel as C;
        let redundant = matches!(
            channel,
            C::ChassisAccelerationZ
                | C::HeadAccelerationZ
                | C::TailAccelerationZ
                | C::ForkTopAcceleration
                | C::ForkBottomAcceleration
                | C::ShockTopAcceleration
                | C::ShockBottomAcceleration
                | C::WheelSpeedFront
                | C::WheelSpeedRear
        );
        for k in 0..2 {
            let most = if redundant { 1.4 * base[k] } else { 0.2 * whole.machine.weight() };
            assert!(errors[k] < most, "{channel} force {k}: {} N", errors[k]);
        }
    }
    // two travels: brake forces cannot be separated any more, and that is said
    let mut session = ridden.session.clone();
    session.remove(Channel::ForkTravel);
    session.remove(Channel::ShockTravel);
    let (e, warnings) = estimate(&session, &scenario.bike, &only(&[Rider::C]));
    let message = said(&warnings, "force_unavailable");
    assert!(message.contains("b_f while braking") && message.contains("b_r while braking"));
    let tyres = &e.riders[0].tyres;
    assert!(tyres.b_f.iter().any(|v| v.is_nan()) && tyres.n_f.iter().all(|v| v.is_finite()));
    // nothing along z: nothing can be said, and that is said too
    let mut session = ridden.session.clone();
    for channel in
        [Channel::ChassisAccelerationZ, Channel::HeadAccelerationZ, Channel::TailAccelerationZ]
    {
        session.remove(channel);
    }
    let (_, warnings) = estimate(&session, &scenario.bike, &only(&[Rider::B]));
    assert!(said(&warnings, "force_unavailable").contains("n_f while braking"));
}

fn loggers_that_are_apart_are_noticed((scenario, ridden): &Ridden) {
    let rate = ridden.session.rate;
    for late in [0.0_f64, 0.002, 0.012, -0.03] {
        let mut session = ridden.session.clone();
        let shift = (late * rate).round() as isize;
        for channel in [
            Channel::HeadAccelerationZ,
            Channel::ForkTravel,
            Channel::ForkTopAcceleration,
            Channel::ForkBottomAcceleration,
            Channel::WheelSpeedFront,
        ] {
            let x = session.get(channel).expect("there");
            let last = x.len() as isize - 1;
            let moved = (0..=last).map(|i| x[(i - shift).clamp(0, last) as usize]).collect();
            session.set(channel, moved);
        }
        let (_, warnings) = estimate(&session, &scenario.bike, &only(&[Rider::B]));
        let found = warnings.iter().find(|w| w.code == "unsynchronised");
        assert_eq!(found.is_some(), late.abs() > 0.005, "{late}: {:?}", codes(&warnings));
        if let Some(w) = found {
            let milliseconds = format!("{:.0} ms", 1000.0 * late.abs());
            let side = if late > 0.0 { "late" } else { "early" };
            assert!(w.message.contains(side), "{}", w.message);
            assert!(w.message.contains(&milliseconds), "{}", w.message);
        }
    }
}

fn wrong_signs_zeros_and_gravity_are_noticed((scenario, ridden): &Ridden) {
    let with = |channel: Channel, f: &dyn Fn(f64) -> f64| {
        let mut session = ridden.session.clone();
        let moved = session.get(channel).expect("there").iter().map(|v| f(*v)).collect();
        session.set(channel, moved);
        estimate(&session, &scenario.bike, &only(&[Rider::C]))
    };
    let (e, warnings) = with(Channel::ForkTravel, &|v| -v);
    assert!(said(&warnings, "negative_travel").contains("fork_travel"));
    assert!(e.kinematics.lost[3] && !e.kinematics.lost[4]);
    let (_, warnings) = with(Channel::ShockTravel, &|v| v - 0.05);
    assert!(said(&warnings, "negative_travel").contains("shock_travel"));
    let (_, warnings) = with(Channel::TailAccelerationZ, &|v| -v);
    assert!(said(&warnings, "sign_acceleration").contains("tail_acceleration_z"));
    // a logger that takes gravity out gives the same forces
    let (plain, _) = estimate(&ridden.session, &scenario.bike, &only(&[Rider::C]));
    let (e, warnings) = with(Channel::ChassisAccelerationZ, &|v| v - GRAVITY);
    assert!(said(&warnings, "gravity_removed").contains("chassis_acceleration_z"));
    let apart = rms(&e.riders[0].tyres.n_r, &plain.riders[0].tyres.n_r);
    assert!(apart < 0.03 * plain.machine.weight(), "{apart}");
}

/// The velocity is that of the centre of mass, unless the bike file gives a lever arm, and levers that are
/// logged say what is driven and what is braked.
fn lever_arms_and_levers_are_read((scenario, ridden): &Ridden) {
    let session = filtered(&ridden.session);
    let rate = session.rate;
    let truth = band(&ridden.truth.qdd[0], rate);
    let error = |bike: &Bike| {
        let (e, _) = offroad::run(&session, bike, &only(&[Rider::B])).expect("estimated");
        rms(&e.kinematics.xdd, &truth)
    };
    let told = error(&scenario.bike);
    let untold =
        error(&scenario.bike.with("sensors.velocity_x", 0.0).with("sensors.velocity_z", 0.6));
    println!("x'' off by {told:.2} m/s2 with the lever arm, {untold:.2} with a wrong one");
    assert!(told < 0.7 && untold > 2.0 * told);

    // true levers: braking where the true sum along the chassis brakes, with one bar
    let mut with_levers = session.clone();
    let along = |i: usize| {
        let f = &ridden.truth.forces;
        f[4][i] - f[3][i] - f[2][i]
    };
    let lever = |on: &dyn Fn(f64) -> bool, value: f64| -> Vec<f64> {
        (0..session.len).map(|i| if on(along(i)) { value } else { 0.0 }).collect()
    };
    with_levers.set(Channel::Throttle, lever(&|f| f > 0.0, 0.5));
    with_levers.set(Channel::BrakePressureFront, lever(&|f| f < 0.0, 5e5));
    with_levers.set(Channel::BrakePressureRear, vec![0.0; session.len]);
    let (e, _) = offroad::run(&with_levers, &scenario.bike, &only(&[Rider::C])).expect("estimated");
    let tyres = &e.riders[0].tyres;
    for i in 0..session.len {
        let wrong = if along(i) > 0.0 { tyres.b_f[i] + tyres.b_r[i] } else { tyres.d_r[i] };
        assert!(along(i) == 0.0 || wrong == 0.0, "sample {i}");
    }
}

/// `B_d' B_d` is the inverse of the covariance, whatever rows are left, up to its scale.
#[test]
fn whitening_inverts_the_covariance() {
    let machine = PlanarMotorcycle::new(&scenario().bike).expect("bike");
    let noise = machine.noise.expect("noise");
    let at = machine.equations.at(&Motion { z_f: 0.1, a_r: 0.17, ..Motion::default() });
    for lost in [[false; 5], [true, false, false, false, false], [false, false, false, true, true]]
    {
        let w = Weights::whitening(&machine.equations, &noise, lost).b_d;
        // an error of one standard deviation in any single source, whitened: sum of squares over
        // the sources is the identity times the scale
        let mut sum = [[0.0; 5]; 5];
        let mut source = |column: [f64; 5]| {
            let white: [f64; 5] =
                std::array::from_fn(|i| (0..5).map(|j| w[i][j] * column[j]).sum());
            for i in 0..5 {
                for j in 0..5 {
                    sum[i][j] += white[i] * white[j];
                }
            }
        };
        for (k, sigma) in noise.qdd.into_iter().enumerate() {
            source(std::array::from_fn(|i| at.m[i][k] * sigma));
        }
        source([0.0, 0.0, 0.0, noise.fs[0], 0.0]);
        source([0.0, 0.0, 0.0, 0.0, noise.fs[1]]);
        for (k, direction) in [(0, [1.0, 0.0]), (1, [0.0, 1.0]), (2, [1.0, 0.0]), (3, [0.0, 1.0])] {
            let [x, z] = direction.map(|d| d * noise.fr);
            source([x, z, at.ar[k] * noise.fr, 0.0, 0.0]);
        }
        let scale = (0..5).map(|k| sum[k][k]).fold(0.0, f64::max);
        for i in 0..5 {
            for j in 0..5 {
                let expected = if i == j && !lost[i] { scale } else { 0.0 };
                assert!((sum[i][j] - expected).abs() < 1e-9 * scale, "{lost:?} {i} {j}");
            }
        }
    }
}

/// The bike file of the scenario, changed.
fn bike_text(change: &dyn Fn(String) -> String) -> Result<Bike, String> {
    let text = change(scenario().bike.to_toml());
    Bike::parse(&text, "mx", "mx.toml".as_ref()).map_err(|e| e.to_string())
}

#[test]
fn bike_files_are_checked_by_key() {
    let linkage = |text: String| {
        let at = text.find("linkage").expect("linkage");
        let end = at + text[at..].find('\n').expect("line");
        format!("{}linkage = [[0.0, 0.0], [0.05, 0.2], [0.1, 0.19]]{}", &text[..at], &text[end..])
    };
    let message = bike_text(&linkage).expect_err("not monotonic");
    assert!(message.contains("`offroad.linkage` is not monotonic"), "{message}");
    let message = bike_text(&|t| t.replace("peg_x", "peg_y")).expect_err("misspelt");
    assert!(message.contains("peg_y") && message.contains("did you mean"), "{message}");
    let without = bike_text(&|t| {
        t.lines().filter(|l| !l.starts_with("mass_chassis")).collect::<Vec<_>>().join("\n")
    })
    .expect("a bike all the same");
    let message = PlanarMotorcycle::new(&without).expect_err("lacks a key").to_string();
    assert!(message.contains("offroad.mass_chassis"), "{message}");
    let heavy = bike_text(&|t| t.replace("mass = 182.0", "mass = 260.0")).expect("a bike");
    assert!(PlanarMotorcycle::new(&heavy).expect_err("contradiction").to_string().contains("260"));
    // an exact lumping makes the swing arm's inertia negative: that is no mistake
    let with_i2 = |value: &str| {
        let value = value.to_owned();
        bike_text(&move |t| {
            t.replace("inertia_swing_arm = 0.28", &format!("inertia_swing_arm = {value}"))
        })
        .expect("a bike")
    };
    assert!(PlanarMotorcycle::new(&with_i2("-0.2855")).is_ok());
    assert!(
        PlanarMotorcycle::new(&with_i2("-15.0"))
            .expect_err("no body")
            .to_string()
            .contains("positive definite")
    );
}

/// A session through the whole pipeline, as `roadbench run --pipeline offroad` does it.
fn run_pipeline(session: &Session, bike: &Bike) -> Outcome {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("ride.parquet");
    roadbench::internals::ingest::write_session(&path, session, true).expect("written");
    let input = Input {
        log: (&path).into(),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: true,
    };
    pipeline::run(&input, bike, &Pipeline::builtin("offroad")).expect("through")
}

fn tables_of_a_session_say_the_same_as_the_estimate((scenario, ridden): &Ridden) {
    let outcome = run_pipeline(&ridden.session, &scenario.bike);
    let ids: Vec<i64> = outcome.manoeuvres.iter().map(|m| m.manoeuvre_id).collect();
    assert_eq!(ids, (0..ids.len() as i64).collect::<Vec<_>>());
    let flights: Vec<_> = outcome.manoeuvres.iter().filter(|m| m.kind == "airborne").collect();
    assert!(flights.len() >= 4);
    for f in &flights {
        assert!((f.flight_time.expect("time") - (f.end - f.start)).abs() < 0.02);
    }
    for rider in ["none", "a", "b", "c"] {
        assert!(outcome.forces.iter().any(|f| f.rider == rider && f.kind == "whoops"));
    }
    assert_eq!(outcome.coefficients.len(), 3);
    // braking puts load to the front, driving takes it
    let transfer = |kind: &str| {
        let of: Vec<f64> = outcome
            .manoeuvres
            .iter()
            .filter(|m| m.kind == kind)
            .filter_map(|m| m.load_transfer)
            .collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    assert!(transfer("combined_braking") > 0.04 && transfer("driving") < -0.02);
    // signals: every rider, 200 Hz, ISO axes: the rider's weight points down
    let signals = outcome.signals.expect("signals");
    assert_eq!(signals.num_rows(), 4 * 200 * 60);
    let number = |name: &str| {
        let column = signals.column_by_name(name).expect(name);
        column.as_primitive::<Float64Type>().clone()
    };
    let down = number("rider_peg_z");
    let mean = arrow::compute::sum(&down).expect("values") / down.len() as f64;
    assert!(mean < -300.0, "{mean}");
    let load = number("load_rear");
    assert!(arrow::compute::min(&load).expect("values") >= 0.0);
    let contact = signals.column_by_name("contact_rear").expect("there").as_boolean();
    assert!(contact.has_true() && contact.has_false(), "on the ground and off it");
}

fn a_saturated_accelerometer_hides_its_landings_and_nothing_else((scenario, ridden): &Ridden) {
    let mut session = ridden.session.clone();
    // a 4 g sensor on the chassis
    let clipped =
        session.get(Channel::ChassisAccelerationZ).expect("there").iter().map(|v| v.min(39.2));
    let clipped = clipped.collect();
    session.set(Channel::ChassisAccelerationZ, clipped);
    let whole = run_pipeline(&ridden.session, &scenario.bike);
    let outcome = run_pipeline(&session, &scenario.bike);
    let warning = outcome.warnings.iter().find(|w| w.code == "clipped").expect("noticed");
    assert_eq!(warning.channel.as_deref(), Some("chassis_acceleration_z"));
    let landings = |o: &Outcome| -> Vec<Option<f64>> {
        let flights = o.manoeuvres.iter().filter(|m| m.kind == "airborne");
        flights.map(|m| m.landing_load_rear).collect()
    };
    println!("landings {:.0?}, clipped {:.0?}", landings(&whole), landings(&outcome));
    let known = |o: &Outcome| landings(o).iter().filter(|l| l.is_some()).count();
    assert!(known(&whole) >= 4 && known(&outcome) < known(&whole));
    // the forces without it agree with those of all
    let (a, b) = (outcome.signals.expect("signals"), whole.signals.expect("signals"));
    let column = |batch: &arrow::array::RecordBatch| -> Vec<Option<f64>> {
        let loads = batch.column_by_name("load_rear").expect("load");
        loads.as_primitive::<Float64Type>().iter().take(200 * 60).collect()
    };
    let (a, b) = (column(&a), column(&b));
    let both: Vec<(f64, f64)> = a.iter().zip(&b).filter_map(|(a, b)| a.zip(*b)).collect();
    let share = both.len() as f64 / b.len() as f64;
    let apart =
        (both.iter().map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / both.len() as f64).sqrt();
    println!("{:.1} % left, {apart:.0} N apart", 100.0 * share);
    assert!(share > 0.9 && apart < 60.0);
}

fn odd_logs_go_through_the_pipeline((scenario, ridden): &Ridden) {
    let rate = ridden.session.rate;
    // a stretch of the minute, from second to second
    let cut = |from: f64, to: f64, without: &[Channel]| {
        let (from, to) = ((from * rate) as usize, (to * rate) as usize);
        let mut session = Session::new(ridden.session.meta.clone(), rate, to - from);
        for channel in ridden.session.channels().filter(|c| !without.contains(c)) {
            session.set(channel, ridden.session.get(channel).expect("there")[from..to].to_vec());
        }
        session
    };
    for without in [
        &[][..],
        &[Channel::VelocityX],
        &[Channel::VelocityX, Channel::WheelSpeedFront],
        &[Channel::Pitch],
        &[Channel::ForkTravel, Channel::ShockTravel],
    ] {
        let outcome = run_pipeline(&cut(2.0, 14.0, without), &scenario.bike);
        assert!(!outcome.manoeuvres.is_empty() && outcome.coefficients.len() == 3);
        assert_eq!(outcome.warnings.is_empty(), without.is_empty(), "{without:?}");
    }
    // three seconds with every channel gone
    let mut session = cut(2.0, 14.0, &[]);
    for channel in ridden.session.channels() {
        let x = session.get_mut(channel).expect("there");
        x[(4.0 * rate) as usize..(7.0 * rate) as usize].fill(f64::NAN);
    }
    let outcome = run_pipeline(&session, &scenario.bike);
    assert!(outcome.manoeuvres.iter().any(|m| !m.used && m.start < 5.0 && m.end > 5.0));
    // hardly a second: nothing to tell, and no panic
    let outcome = run_pipeline(&cut(2.0, 3.1, &[]), &scenario.bike);
    assert!(outcome.coefficients.iter().all(|c| c.status != Status::Ok));
    // without the shock's travel the flights are still found, by the weight, and landings with them
    let outcome = run_pipeline(&cut(2.0, 14.0, &[Channel::ShockTravel]), &scenario.bike);
    assert!(outcome.warnings.iter().any(|w| w.code == "flights_by_load"));
    assert_eq!(outcome.manoeuvres.iter().filter(|m| m.kind == "airborne").count(), 2);
    let signals = outcome.signals.expect("signals");
    assert_eq!(
        signals.column_by_name("contact_rear").expect("there").null_count(),
        signals.num_rows()
    );
    // a flight that the log's end cuts off has no landing
    let end = ridden.labels.iter().find(|l| l.0 == ManoeuvreKind::Airborne).expect("flight").2;
    let outcome = run_pipeline(&cut(2.0, end - 0.1, &[]), &scenario.bike);
    let last = outcome.manoeuvres.iter().rfind(|m| m.kind == "airborne").expect("flight");
    assert_eq!(last.landing_load_rear, None);
    // a posture in which rider A topples at once costs rider A, not the session
    let bike = bike_text(&|t| t.replace("shoulder_x = -0.1", "shoulder_x = 0.36")).expect("bike");
    let outcome = run_pipeline(&cut(2.0, 14.0, &[]), &bike);
    assert!(outcome.warnings.iter().any(|w| w.code == "rider_left_out"));
    assert!(outcome.forces.iter().all(|f| f.rider != "a"));
}
