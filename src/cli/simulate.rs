//! `roadbench simulate`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::cli::Failure;
use crate::ingest::write_session;
use crate::rows::TruthSegment;
use crate::schema::Table;
use crate::simulate::scenario::{BUILTIN, Scenario};
use crate::simulate::{session, truth, truth_rows};
use crate::table;

/// Write a synthetic archive with known truth beside it
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A built-in scenario (archive, perfect, paper, naturalistic) or a scenario file.
    scenario: String,
    /// Folder of the archive: sessions/, bikes/ and truth/ are made in it.
    #[arg(long)]
    out: PathBuf,
    /// Bikes, instead of the scenario's number.
    #[arg(long)]
    bikes: Option<usize>,
    /// Parallel jobs; 0 takes every core.
    #[arg(long, default_value_t = 0)]
    jobs: usize,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: Arguments) -> Result<(), Failure> {
    let mut scenario = Scenario::load(&arguments.scenario).map_err(Failure::Usage)?;
    if let Some(bikes) = arguments.bikes {
        scenario.fleet.bikes = bikes;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.jobs)
        .build()
        .map_err(|e| Failure::Usage(e.to_string()))?;
    let out = &arguments.out;
    let written = pool.install(|| {
        (0..scenario.fleet.bikes)
            .into_par_iter()
            .map(|bike| write_bike(&scenario, bike, out))
            .collect::<Result<Vec<usize>, table::Error>>()
    });
    let sessions: usize = written.map_err(|e| Failure::Output(e.to_string()))?.iter().sum();
    if let Some((_, text)) = BUILTIN.iter().find(|(name, _)| *name == arguments.scenario) {
        table::write_bytes(&out.join("scenario.toml"), text.as_bytes())
            .map_err(|e| Failure::Output(e.to_string()))?;
    }
    println!(
        "{}: {} sessions of {} bikes, with their truth, in {}",
        scenario.name,
        sessions,
        scenario.fleet.bikes,
        out.display()
    );
    Ok(())
}

/// One bike: its file, its sessions, its truth. Returns the number of sessions.
fn write_bike(scenario: &Scenario, bike: usize, out: &Path) -> Result<usize, table::Error> {
    let machine = scenario.machine(bike);
    let id = &machine.bike.bike_id;
    let file = out.join("bikes").join(format!("{id}.toml"));
    table::write_bytes(&file, machine.bike.to_toml().as_bytes())?;
    let (truth_table, segment_table) =
        (Table::embedded("truth"), Table::embedded("truth_segments"));
    let count = scenario.fleet.sessions_per_bike;
    for i in 0..count {
        let simulated = session(scenario, &machine, bike * count + i);
        let meta = &simulated.session.meta;
        let date = meta.start_time.as_deref().and_then(|t| t.get(..10)).unwrap_or("2026-01-01");
        let name = format!("{}.parquet", meta.session_id);
        let part = format!("bike={id}");
        let folder = out.join("sessions").join(&part).join(format!("date={date}"));
        write_session(&folder.join(&name), &simulated.session, scenario.float32)?;
        let truth = truth_rows(meta, &truth::coefficients(&machine.plant, &simulated));
        table::write(
            &out.join("truth/coefficients").join(&part).join(&name),
            &truth_table,
            &truth,
        )?;
        let segments: Vec<TruthSegment> = simulated
            .labels
            .iter()
            .map(|&(kind, start, end, direction)| TruthSegment {
                session_id: meta.session_id.clone(),
                bike_id: id.clone(),
                kind: kind.name().to_owned(),
                start,
                end,
                direction: direction.map(|d| d.name().to_owned()),
            })
            .collect();
        table::write(
            &out.join("truth/segments").join(&part).join(&name),
            &segment_table,
            &segments,
        )?;
    }
    Ok(count)
}
