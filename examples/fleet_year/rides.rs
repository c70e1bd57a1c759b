//! Rides through the real simulator and the real pipeline, kept as tables: `<folder>/<bike>/<state>/`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::estimate;
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::{reduced, truth};
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::registry::Row;
use roadbench::internals::store::tables::rows::{Coefficient, EvidenceRow, Truth};
use roadbench::internals::store::tables::{file, read};

/// Failures as words.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A motorcycle in one state: what it is, what its owner says it is, and its sensors.
pub struct State {
    /// The motorcycle's number.
    pub bike: usize,
    /// Folder of this state.
    pub name: String,
    /// What is ridden.
    pub machine: Machine,
    /// What the rides are evaluated with.
    pub file: Bike,
    /// Factors of the measured lean and of the measured forward acceleration.
    pub gains: [f64; 2],
    /// Number of the first ride among the motorcycle's.
    pub first: usize,
    /// How many rides.
    pub rides: usize,
}

/// What the rides of a state gave.
#[derive(Default, Clone)]
pub struct Rides {
    /// Coefficients.
    pub coefficients: Vec<Coefficient>,
    /// Evidence.
    pub evidence: Vec<EvidenceRow>,
    /// Truth.
    pub truth: Vec<Truth>,
}

/// Numbers of a motorcycle's rides begin here.
pub const STRIDE: usize = 1000;

fn folder(out: &Path, state: &State) -> PathBuf {
    out.join(format!("bike_{:02}", state.bike)).join(&state.name)
}

fn table<R: Row>(folder: &Path) -> PathBuf {
    folder.join(format!("{}.parquet", R::spec().name))
}

/// Rides every state that is not there yet.
pub fn ride(out: &Path, scenario: &Scenario, states: &[State]) -> Result<(), Failure> {
    let work = tempfile::tempdir()?;
    states.par_iter().try_for_each(|state| {
        let folder = folder(out, state);
        if table::<Truth>(&folder).is_file() {
            return Ok(());
        }
        let mut all = Rides::default();
        let each: Result<Vec<Rides>, Failure> = (0..state.rides)
            .into_par_iter()
            .map(|k| one(scenario, state, STRIDE * state.bike + state.first + k, work.path()))
            .collect();
        for ride in each? {
            all.coefficients.extend(ride.coefficients);
            all.evidence.extend(ride.evidence);
            all.truth.extend(ride.truth);
        }
        file::write(table::<Coefficient>(&folder).as_path(), &all.coefficients)?;
        file::write(table::<EvidenceRow>(&folder).as_path(), &all.evidence)?;
        file::write(table::<Truth>(&folder).as_path(), &all.truth)?;
        eprintln!("{} {}: {} rides", state.bike, state.name, state.rides);
        Ok(())
    })
}

/// The rides of a state, of a folder that [`ride`] wrote.
pub fn read(out: &Path, state: &State) -> Result<Rides, Failure> {
    let folder = folder(out, state);
    Ok(Rides {
        coefficients: read::file_rows(&table::<Coefficient>(&folder))?,
        evidence: read::file_rows(&table::<EvidenceRow>(&folder))?,
        truth: read::file_rows(&table::<Truth>(&folder))?,
    })
}

fn one(scenario: &Scenario, state: &State, number: usize, work: &Path) -> Result<Rides, Failure> {
    let mut simulated = reduced::session(scenario, &state.machine, number);
    let known = truth::coefficients(&state.machine.plant, &simulated, &estimate::Config::default());
    let session = &mut simulated.session;
    for (channel, gain) in [Channel::Roll, Channel::AccelerationX].into_iter().zip(state.gains) {
        session.get_mut(channel).into_iter().flatten().for_each(|x| *x *= gain);
    }
    let log = work.join(format!("{number}_{}.parquet", state.name));
    let outcome = run(session, &log, &state.file)?;
    let meta = &session.meta;
    let truth = known.into_iter().map(|(id, value)| Truth {
        session_id: meta.session_id.clone(),
        bike_id: meta.bike_id.clone(),
        tyre: id.part.name().to_owned(),
        coefficient: id.coefficient.name().to_owned(),
        value,
        unit: id.coefficient.spec().unit.to_owned(),
    });
    Ok(Rides {
        truth: truth.filter(|t| t.value.is_finite()).collect(),
        coefficients: outcome.coefficients,
        evidence: outcome.evidence,
    })
}

fn run(session: &Session, log: &Path, bike: &Bike) -> Result<pipeline::Outcome, Failure> {
    write_session(log, session, true)?;
    let input = Input {
        log: Location::from(log),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    let outcome = pipeline::run(&input, bike, &Pipeline::onroad()).map_err(|e| e.message)?;
    std::fs::remove_file(log)?;
    Ok(outcome)
}
