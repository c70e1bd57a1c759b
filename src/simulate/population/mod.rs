//! A population of motorcycles: complete machines, drawn at random over what is on the road, for rides
//! whose plant is neither the model that looks at them nor always the same.
//!
//! ```text
//! seed, number -> masses, lengths, bodies, tyres, carcass, suspension, sensors -> motorcycle + bike files
//! ```
//!
//! A machine depends on seed, number and the attempt alone. What is hidden in a [`Case`](super::hidden::Case) is put into it by
//! the same formulas as into any other plant; [`BikeFile`](bike::BikeFile) says how much its owner knows.

pub(crate) mod bike;
mod build;
mod draw;
pub(crate) mod machine;
#[cfg(feature = "internals")]
pub(crate) mod ride;
pub(crate) mod tyre;
pub(crate) mod wizard;

pub(crate) use machine::DrawnMachine;

#[cfg(test)]
mod tests {
    use super::bike::BikeFile;
    use super::machine::DrawnMachine;
    use crate::simulate::effects::ModelError;
    use crate::simulate::multibody::{Model, Road};
    use crate::simulate::scenario::Scenario;

    fn draw(number: usize) -> DrawnMachine {
        DrawnMachine::draw(3, number, 0).expect("built in")
    }

    #[test]
    fn a_machine_depends_on_seed_number_and_attempt_alone() {
        let text = |m: &DrawnMachine| format!("{m:?}");
        let first: Vec<String> = (0..6).map(|n| text(&draw(n))).collect();
        for number in (0..6).rev() {
            assert_eq!(text(&draw(number)), first[number]);
        }
        assert!(first[0] != text(&DrawnMachine::draw(3, 0, 1).expect("built in")));
        assert!(
            first[0] != first[1] && first[0] != text(&DrawnMachine::draw(4, 0, 0).expect("it"))
        );
    }

    #[test]
    fn the_first_forty_stand_and_are_what_was_drawn() {
        for number in 0..40 {
            let machine = draw(number);
            let m = machine.motorcycle(&ModelError::default()).expect("stands");
            let (vehicle, centre) = (&machine.plant.vehicle, m.centre());
            for (found, expected) in [
                (m.mass(), vehicle.mass),
                (m.wheelbase(), vehicle.wheelbase),
                (m.centres[0].x - centre.x, vehicle.cg_to_front),
                (centre.z, vehicle.cg_height),
                (m.caster_angle, vehicle.caster_angle),
                (m.trail(), machine.build.trail.expect("drawn")),
            ] {
                assert!((found / expected - 1.0).abs() < 1e-9, "{number}: {found} for {expected}");
            }
            assert!(m.frame.mass > 80.0, "{number}: {}", m.frame.mass);
            let at_rest = Model::new(m, Road::default()).straight(0.0);
            assert!(at_rest.position.z.abs() < 1e-9 && at_rest.angles[2].abs() < 1e-9);
        }
    }

    #[test]
    fn a_bike_file_tells_nothing_of_what_is_hidden_and_a_short_one_less() {
        let scenario = Scenario::builtin("paper").expect("scenario");
        for number in 0..8 {
            let machine = draw(number);
            let bike = |hidden: &ModelError, file| {
                machine.tour(&scenario, hidden, file).expect("stands").bike
            };
            let mut hidden = ModelError::default();
            for name in ["wheel_inertia", "side_force_ratio_rear", "relaxation_length"] {
                let effect = crate::simulate::effects::Effect::named(name).expect("an effect");
                (effect.set)(&mut hidden, effect.typical);
            }
            let full = bike(&ModelError::default(), BikeFile::Full);
            assert_eq!(full, bike(&hidden, BikeFile::Full));
            let minimal = bike(&hidden, BikeFile::Minimal);
            assert!(minimal.mass == full.mass && minimal.uncertainty.is_empty());
            assert!(minimal.value("trail").is_none() && full.value("trail").is_some());
            let wizard = bike(&hidden, BikeFile::Wizard);
            assert!(wizard.mass != full.mass && wizard.uncertainty["cg_height"] > 0.03);
            let tutorial = bike(&hidden, BikeFile::Tutorial);
            assert_eq!(tutorial.uncertainty.keys().collect::<Vec<_>>(), ["mass"]);
        }
    }

    /// The tyres of either make show on the bench what the plant, and so the bike file, says.
    #[test]
    fn hidden_numbers_of_tyres_are_in_tyres_of_any_make() {
        use super::super::tyre_truth::bench;
        let mut hidden = ModelError::default();
        for name in ["side_force_ratio_front", "twisting_stiffness", "relaxation_length"] {
            let effect = crate::simulate::effects::Effect::named(name).expect("an effect");
            (effect.set)(&mut hidden, effect.typical);
        }
        for number in 0..8 {
            let machine = draw(number);
            for hidden in [ModelError::default(), hidden] {
                let m = machine.motorcycle(&hidden).expect("stands");
                let plant = machine.plant_with(&hidden);
                let tyre = &m.tyres.as_ref().expect("shod")[0];
                let b = bench(tyre.as_ref(), m.static_loads()[0], 1.0);
                let is = &plant.tyres[0];
                for (found, expected) in [
                    (b.camber_stiffness / b.cornering_stiffness, is.side_force_ratio),
                    (b.twisting_stiffness, is.twisting_stiffness),
                    (b.relaxation_length, is.relaxation_length),
                    (b.rolling_radius, is.rolling_radius),
                    (b.overturning_stiffness, is.overturning_stiffness),
                ] {
                    assert!(
                        (found - expected).abs() < 2e-3 * expected.abs(),
                        "{number} {found} {expected}"
                    );
                }
            }
        }
    }
}
