#![allow(missing_docs)]
use roadbench::diagnose::{
    base,
    effects::ALL,
    replay,
    samples::{Samples, picks},
    scan::scan,
    world::World,
};
use roadbench::estimate::{Formulation, zeros};
use roadbench::fit::chain::{self, Data};
use roadbench::pipeline::Pipeline;
use roadbench::simulate::hidden::*;
use roadbench::simulate::rider::Disturbance;
use roadbench::{filter, segment};
fn main() {
    let number: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let level: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let c = Case::draw(
        1,
        number,
        [Kind::Null, Kind::Single, Kind::Double]
            [std::env::args().nth(3).unwrap().parse::<usize>().unwrap()],
        [0.6, 3.0],
    );
    println!("{:?}", c.hidden.iter().map(|(e, v)| (e.name, *v)).collect::<Vec<_>>());
    let (mut sc, m) = c.machine().unwrap();
    if level < 2 {
        sc.disturbance = Disturbance::default();
    }
    if level < 1 {
        sc.sensors.clear();
    }
    let s = roadbench::simulate::session(&sc, &m, number).session;
    let p = Pipeline::onroad();
    let mut f = s.clone();
    filter::run(&mut f, &p.filter);
    let seg = segment::run(&f, &m.bike, &p.segment);
    let (z, _) = zeros::run(&f, &m.bike);
    let data = Data::gather(&f, &seg, &m.bike, z, &p.estimate);
    let sol = chain::solve(&data, &m.bike, Formulation::Corrected, &p.fit);
    let sam = Samples::gather(&s, &seg);
    let b = base::fit(&sam, &World::new(&m.bike, &sol));
    let plant = replay::plant(
        &b.world,
        [m.bike.front.width, m.bike.rear.width],
        [m.bike.front.vertical_stiffness, m.bike.rear.vertical_stiffness],
    );
    let r = replay::replay(&s, &seg, &plant);
    let sam2 = Samples::take(&r, &picks(&s, &seg));
    let b2 = base::fit(&sam2, &b.world);
    // same sigma
    let mut b2s = b2.clone();
    b2s.sigma = b.sigma;
    let t = std::time::Instant::now();
    let cal = roadbench::diagnose::null::Calibration::new(&s, &seg, &b, &plant, ALL, 24, 7);
    println!("cal {:?}", t.elapsed());
    println!(
        "{:?}",
        roadbench::diagnose::slow::slow(
            &s,
            &seg,
            &sam,
            &roadbench::diagnose::residuals::blocks(&sam, &b.world),
            &b.world
        )
    );
    let x = scan(&sam, &b, ALL);
    let y = scan(&sam2, &b2s, ALL);
    println!(
        "stiffness {:?} start {:?} crown {} ratio {:?}; truth {:?}",
        b.world.stiffness,
        b.start.stiffness,
        b.world.crown,
        b.world.side_force_ratio,
        m.plant.tyres.map(|t| (
            t.stiffness.k_alpha(0.0, t.side_force_ratio),
            t.stiffness.c3 / t.side_force_ratio,
            t.side_force_ratio
        ))
    );
    println!(
        "sigma {:?}\n      {:?}",
        b.sigma.map(|x| (x * 1e4).round() / 1e4),
        b2.sigma.map(|x| (x * 1e4).round() / 1e4)
    );
    for (e, (a, c)) in ALL.iter().zip(x.iter().zip(&y)) {
        let j = ALL.iter().position(|f| f.name == e.name).unwrap();
        println!(
            "{:24} {:8.3} se {:6.3} info {:6.3} | bias {:7.3} spread {:6.3} scatter {:6.3} gain {:6.0} z {:5.1} score {:.1} thr {:?} {}",
            e.name,
            a.delta,
            a.std_error,
            1.0 / a.information.sqrt(),
            cal.bias[j],
            cal.spread[j],
            cal.scatter[j],
            a.gain,
            (a.delta - cal.bias[j]) / cal.spread[j],
            cal.judge(j, a).score,
            cal.threshold.map(|x| (x * 10.0).round() / 10.0),
            c.delta
        );
    }
}
