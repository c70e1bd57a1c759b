//! What diagnosis says of rides on the multibody motorcycle in which nothing is hidden.

use roadbench::internals::simulate::multibody_ride as multibody;

use super::common::*;

/// Prints the table.
pub fn print() {
    println!(
        "0. Nothing is hidden; the tyres are toroids on springs, which the base model has not"
    );
    for number in 0..6 {
        let plan = ["paper", "naturalistic"][number % 2];
        let (scenario, machine) = machine(plan, number, &[]);
        let tour = multibody::tour(&scenario, &machine, number).expect("stands");
        let begin = std::time::Instant::now();
        let ridden = ride(&tour, number);
        let spent = begin.elapsed().as_secs_f64();
        let d = diagnosed(&ridden, &tour.bike);
        let tyre = tour.model.motorcycle.tyres.as_ref().expect("tyres")[0].carcass();
        println!(
            "  {number} {plan}, {:.0} s ridden in {spent:.1} s; crown {:.3} m, deflection {:.4} /kN; \
             named: {}",
            ridden.session.duration(),
            tyre.crown,
            1e3 * tyre.deflection_share / tyre.stiffness / tyre.radius,
            told(&d)
        );
    }
}
