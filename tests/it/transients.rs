//! Stiffness and side force ratio from changing lean: slaloms of a machine of the population, whose tyres are known.

use roadbench::internals::contract::bike::Axle;
use roadbench::internals::contract::coefficient::{Coefficient as C, Id};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::hidden::{Kind, plan_named};
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride;
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::rows::Status;

#[test]
fn fast_slaloms_give_stiffness_and_ratio_of_both_tyres() {
    let mut case = ride::case(78, 4, Kind::Null, [1.0, 1.0]);
    case.plan = plan_named("mixed + 2 fast passes").expect("a plan");
    let ridden = ride::ride(&case, BikeFile::Full).expect("ridden");
    let folder = tempfile::tempdir().expect("folder");
    let log = folder.path().join("ride.parquet");
    write_session(&log, &ridden.ride.session, false).expect("written");
    let run = |enabled: bool| {
        let mut pipeline = Pipeline::onroad();
        pipeline.transients.enabled = enabled;
        let input = Input {
            log: Location::from(log.as_path()),
            maps: &[],
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: false,
        };
        pipeline::run(&input, &ridden.tour.bike, &pipeline).expect("characterised").coefficients
    };
    let (with, without) = (run(true), run(false));
    let truth = ridden.truth(&Pipeline::onroad().estimate);
    for axle in Axle::BOTH {
        for coefficient in [C::CorneringStiffness0, C::CamberStiffness0, C::SideForceRatio] {
            let id = Id::from((axle, coefficient));
            let true_value = truth.iter().find(|(known, _)| *known == id).expect("known").1;
            let own = |rows: &[roadbench::internals::store::tables::rows::Coefficient]| {
                let is_own = |r: &&roadbench::internals::store::tables::rows::Coefficient| {
                    r.tyre == axle.name() && r.coefficient == coefficient.name()
                };
                rows.iter().find(is_own).expect("a row").clone()
            };
            let row = own(&with);
            println!("{id}: {true_value} {:?} {:?} {:?}", row.value, row.ci95_low, row.ci95_high);
            assert_eq!(row.status, Status::Ok, "{id}: {row:?}");
            let [value, low, high] =
                [row.value, row.ci95_low, row.ci95_high].map(|x| x.expect("a number"));
            assert!((value / true_value - 1.0).abs() < 0.15, "{id}: {value} for {true_value}");
            assert!((low..=high).contains(&true_value), "{id}: {low} to {high}, {true_value}");
            assert!(high - low < 0.8 * value, "{id}: {low} to {high}");
            let before = own(&without);
            match coefficient {
                C::SideForceRatio => assert_eq!(before.status, Status::Assumed, "{id}"),
                _ => assert_ne!(before.value, row.value, "{id}"),
            }
        }
    }
}
