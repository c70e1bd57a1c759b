//! What a ride will give of the tyres' side forces, before it is ridden: it is simulated and fitted as a log is, as
//! planned and with slalom passes after it.

use serde::Serialize;

use super::outcome::{Input, Outcome};
use super::road;
use super::settings::Pipeline;
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::Coefficient as C;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::session::Session;
use crate::contract::status::Status;
use crate::ingest;
use crate::simulate::manoeuvre::{Manoeuvre, advised_passes};
use crate::simulate::pilot::Skill;
use crate::simulate::plan::Phase;
use crate::simulate::scenario::Scenario;
use crate::simulate::tour::Tour;
use crate::simulate::{reduced, ride};
use crate::statistics::random::Random;

/// Predicted coefficients of each tyre.
const SIDE_FORCES: [C; 3] = [C::CorneringStiffness0, C::SideForceRatio, C::CamberStiffness0];

/// Predicted accuracy of one coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Predicted {
    /// Tyre, `front` or `rear`.
    pub tyre: &'static str,
    /// Name of the coefficient.
    pub coefficient: &'static str,
    /// Whether the bike file gives the ratio of camber to cornering stiffness.
    pub ratio_given: bool,
    pub planned: Expected,
    /// With slalom passes after it.
    pub with_slalom: Expected,
}

/// A result of a simulated ride.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Expected {
    /// Half the 95 % interval over the value; none where the ride does not bound it.
    pub half_width: Option<f64>,
    /// How far it could be believed.
    pub status: Status,
}

/// A ride that is planned, on either motorcycle.
pub enum Planned<'a> {
    /// The first session of a scenario.
    Fleet(&'a Scenario),
    /// The first session of a tour.
    Tour(&'a Tour),
}

/// Predicts the side forces: with the bike file that the simulation writes, and, where the scenario gives their ratio, with
/// one that does not.
///
/// # Errors
/// The ride cannot be ridden or fitted.
pub fn predict(ride: &Planned<'_>, pipeline: &Pipeline) -> Result<Vec<Predicted>, FileError> {
    let name = match ride {
        Planned::Fleet(scenario) => &scenario.name,
        Planned::Tour(tour) => &tour.name,
    };
    let wrong = |why: String| FileName::new("scenario", name).wrong(why);
    let (rides, bike) = ride.ridden().map_err(wrong)?;
    let mut out = Vec::new();
    for (bike, ratio_given) in files(&bike).map_err(wrong)? {
        let [planned, with_slalom] =
            [&rides[0], &rides[1]].map(|session| fitted(session.clone(), &bike, pipeline));
        let (planned, with_slalom) = (planned.map_err(wrong)?, with_slalom.map_err(wrong)?);
        for axle in Axle::BOTH {
            for coefficient in SIDE_FORCES {
                out.push(Predicted {
                    tyre: axle.name(),
                    coefficient: coefficient.name(),
                    ratio_given,
                    planned: expected(&planned, axle, coefficient),
                    with_slalom: expected(&with_slalom, axle, coefficient),
                });
            }
        }
    }
    Ok(out)
}

impl Planned<'_> {
    /// The ride and the one with slalom passes, with the motorcycle's bike file.
    fn ridden(&self) -> Result<([Session; 2], Bike), String> {
        match self {
            Planned::Fleet(scenario) => {
                let machine = scenario.machine(0);
                let of = |more: Vec<Phase>| {
                    reduced::session_with(scenario, &machine, 0, |_| more).session
                };
                Ok(([of(Vec::new()), of(passes())], machine.bike.clone()))
            }
            Planned::Tour(tour) => {
                let skill = Skill::learn(&tour.model, ride::period(tour.rate))
                    .map_err(|e| e.to_string())?;
                let mut longer = (*tour).clone();
                let up =
                    Manoeuvre::Accelerate { from: 6.0, to: 15.0, rise: 2.0, peak: 3.0, gear: 1 };
                longer.manoeuvres.push(up);
                longer.manoeuvres.extend(advised_passes());
                longer.manoeuvres.push(Manoeuvre::Stop { duration: 2.0 });
                let rides = [tour, &longer].map(|tour| ride::ride(tour, &skill, 0).session);
                Ok((rides, tour.bike.clone()))
            }
        }
    }
}

/// Slalom passes at the end of a ride.
fn passes() -> Vec<Phase> {
    let mut random = Random::new(1, "slalom");
    let mut out = vec![Phase::Accelerate { to: 15.0, ramp: 2.0, peak: 3.0 }];
    let stop = Manoeuvre::Stop { duration: 2.0 };
    for manoeuvre in advised_passes().chain([stop]) {
        out.extend(manoeuvre.phases(&mut random));
    }
    out
}

/// The bike files that a ride is fitted with, and whether each gives the ratios: only one where the scenario has none.
fn files(bike: &Bike) -> Result<Vec<(Bike, bool)>, String> {
    let bare = written(bike, without_ratio)?;
    let same = |axle: &Axle| {
        let key = ratio_of(*axle);
        bare.deviation(&key) == bike.deviation(&key)
    };
    let mut out = Vec::new();
    if !Axle::BOTH.iter().all(same) {
        out.push((written(bike, |_| ())?, true));
    }
    out.push((bare, false));
    Ok(out)
}

/// The bike file that a simulation writes, after a change. What the scenario left to a default is a number of that file, and
/// exact: the simulated motorcycle has it.
fn written(bike: &Bike, change: impl Fn(&mut toml::Table)) -> Result<Bike, String> {
    let mut table: toml::Table = bike.to_toml().parse().map_err(|e| format!("{e}"))?;
    change(&mut table);
    let path = std::path::PathBuf::from(format!("{}.toml", bike.bike_id));
    Bike::parse(&table.to_string(), &bike.bike_id, &path).map_err(|e| e.to_string())
}

/// Takes the ratios and their uncertainties out of a bike file.
fn without_ratio(table: &mut toml::Table) {
    for axle in Axle::BOTH {
        if let Some(toml::Value::Table(wheel)) = table.get_mut(axle.name()) {
            wheel.remove("side_force_ratio");
        }
        if let Some(toml::Value::Table(sds)) = table.get_mut("uncertainty") {
            sds.remove(&ratio_of(axle));
        }
    }
}

/// Key of a tyre's ratio in the bike file.
fn ratio_of(axle: Axle) -> String {
    format!("{}.side_force_ratio", axle.name())
}

/// What `run` makes of a ride.
fn fitted(mut session: Session, bike: &Bike, pipeline: &Pipeline) -> Result<Outcome, String> {
    let input = Input {
        log: std::path::PathBuf::from(&session.meta.session_id).into(),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    let noticed =
        ingest::check(&mut session, Some(bike), &pipeline.ingest).map_err(|e| e.message)?;
    road::run(&input, session, noticed, bike, pipeline).map_err(|e| e.message)
}

fn expected(outcome: &Outcome, axle: Axle, coefficient: C) -> Expected {
    let own = outcome
        .coefficients
        .iter()
        .find(|row| row.tyre == axle.name() && row.coefficient == coefficient.name());
    let Some(row) = own else {
        return Expected { half_width: None, status: Status::NotAvailable };
    };
    let half_width = match (row.value, row.ci95_low, row.ci95_high) {
        (Some(value), Some(low), Some(high)) => Some(0.5 * (high - low) / value.abs()),
        _ => None,
    };
    Expected { half_width: half_width.filter(|x| x.is_finite()), status: row.status }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bike_file_without_the_ratio_knows_it_by_the_schemas_default() {
        let bike = Scenario::builtin("paper").expect("built in").machine(0).bike;
        let both = files(&bike).expect("bike files");
        let [(given, true), (bare, false)] = &both[..] else { panic!("two files") };
        assert_eq!((given.mass, bare.mass), (bike.mass, bike.mass));
        let sd = |bike: &Bike| bike.deviation("front.side_force_ratio");
        assert!(sd(given) == sd(&bike) && sd(bare) > sd(&bike));
        assert_eq!(files(bare).expect("bike files").len(), 1);
    }

    /// The place of the velocity sensor was 5 cm uncertain in one of the two, exact in the other and for `run`.
    #[test]
    fn bike_files_differ_in_the_ratio_alone_and_are_as_they_are_written() {
        for name in ["paper", "naturalistic", "archive"] {
            let bike = Scenario::builtin(name).expect("built in").machine(0).bike;
            let files = files(&bike).expect("bike files");
            let path = std::path::Path::new("b.toml");
            let read = Bike::parse(&bike.to_toml(), &bike.bike_id, path).expect("a bike file");
            assert_eq!(files[0], (read, true), "{name}");
            let others = |bike: &Bike| -> Vec<(String, f64)> {
                let keys = bike.priors_of_missing().keys().chain(bike.uncertainty.keys());
                let others = keys.filter(|key| !key.ends_with("side_force_ratio"));
                others.map(|key| (key.clone(), bike.deviation(key))).collect()
            };
            assert_eq!(others(&files[0].0), others(&files[1].0), "{name}");
        }
    }
}
