//! "The rear yaw moment is overestimated: coherent with the twisting stiffness used (0.039 m/rad)
//! being higher than the true one (0.031)" (Discussion).

use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::scenario::Scenario;

use super::common::*;

/// Truth less what is assumed, m/rad: the paper's.
const WRONG: f64 = -0.008;

/// Yaw-moment errors of the lane change (front and rear, rms), with the assumed twisting stiffness and
/// with the true one, where the truth is off by `wrong`; `prepare` may change the scenario.
pub fn study(wrong: f64, number: usize, prepare: fn(&mut Scenario)) -> [[f64; 2]; 2] {
    let hidden = [("twisting_stiffness", wrong)];
    let hidden = if wrong == 0.0 { &[][..] } else { &hidden[..] };
    let (mut scenario, machine) = machine("paper", number, hidden);
    prepare(&mut scenario);
    let tour = multibody::tour(&scenario, &machine, number).expect("stands");
    let ridden = ride(&tour, number);
    let assumed = tyres(&characterise(&ridden, &tour.bike), &tour.bike, 1.0);
    let mut bike = tour.bike.clone();
    for end in ["front", "rear"] {
        let key = format!("{end}.twisting_stiffness");
        bike = bike.with(&key, bike.value(&key).expect("assumed") + wrong);
    }
    let corrected = tyres(&characterise(&ridden, &bike), &bike, 1.0);
    let own = tour.model.motorcycle.clone();
    let reference = lane_change(own.clone(), 1.0);
    let on = |tyres| {
        let [front, rear] = boxed(tyres);
        lane_change(own.with_tyres(front, rear), 1.0)
    };
    let (before, after) = (on(assumed), on(corrected));
    table(&reference, &[("assumed", &before), ("true", &after)]);
    [&before, &after].map(|r| [2, 3].map(|k| off(&reference, r, SIGNALS[k].1)[0]))
}

/// Prints the study.
pub fn print() {
    println!("2. Rear yaw moment: the twisting stiffness?");
    for wrong in [WRONG, 0.0] {
        println!("  truth is off by {wrong} m/rad");
        study(wrong, 0, |_| {});
    }
    for wrong in [WRONG, 0.0, -4.0 * WRONG] {
        for (plan, number) in [("paper", 0), ("naturalistic", 1)] {
            let hidden = [("twisting_stiffness", wrong)];
            let (scenario, machine) = machine(plan, number, &hidden);
            let tour = multibody::tour(&scenario, &machine, number).expect("stands");
            let d = diagnosed(&ride(&tour, number), &tour.bike);
            println!(
                "  diagnosed, off by {wrong}, {plan}: {}; {}",
                told(&d),
                about(&d, "twisting_stiffness")
            );
        }
    }
}
