//! A large archive of short logs, for what a batch does over years: `cargo run --release --example
//! crowd -- --sessions 10000 --out DIR`, then `roadbench run DIR/sessions --out OUT`.
//!
//! Each log is another stretch of a bundled session, so that no two are the same bytes; sessions are
//! spread over 20 motorcycles and 500 days.

use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::ingest::{self, write_session};

/// Motorcycles of the archive.
const BIKES: usize = 20;
/// Sessions of a day.
const DAILY: usize = 20;

/// Write a large archive of short logs
#[derive(Parser)]
struct Arguments {
    /// Logs to write.
    #[arg(long, default_value_t = 10_000)]
    sessions: usize,
    /// Length of each, s.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Folder of the archive.
    #[arg(long)]
    out: PathBuf,
}

fn main() -> Result<(), String> {
    let arguments = Arguments::parse();
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let donors = donors(&bundled.join("sessions"))?;
    let bike = std::fs::read_dir(bundled.join("bikes"))
        .map_err(|e| e.to_string())?
        .filter_map(|e| Some(e.ok()?.path()))
        .find(|p| p.extension().is_some_and(|x| x == "toml"))
        .ok_or("no bike file is bundled")?;
    let bikes = arguments.out.join("bikes");
    std::fs::create_dir_all(&bikes).map_err(|e| format!("{}: {e}", bikes.display()))?;
    for number in 0..BIKES {
        let to = bikes.join(format!("crowd_{number:02}.toml"));
        std::fs::copy(&bike, &to).map_err(|e| format!("{}: {e}", to.display()))?;
    }
    (0..arguments.sessions).into_par_iter().try_for_each(|number| {
        let donor = &donors[number % donors.len()];
        let (path, session) = stretch(donor, number, arguments.seconds);
        write_session(arguments.out.join(path), &session, true).map_err(|e| e.to_string())
    })
}

/// The bundled sessions.
fn donors(folder: &Path) -> Result<Vec<Session>, String> {
    let mut logs: Vec<PathBuf> = walkdir::WalkDir::new(folder)
        .into_iter()
        .filter_map(|e| Some(e.ok()?.into_path()))
        .filter(|p| p.extension().is_some_and(|x| x == "parquet"))
        .collect();
    logs.sort();
    let settings = roadbench::internals::pipeline::Pipeline::onroad();
    logs.iter()
        .map(|log| {
            let raw = ingest::read(log, &[]).map_err(|e| e.to_string())?;
            Ok(ingest::run(raw, &settings.ingest).map_err(|e| e.to_string())?.0)
        })
        .collect()
}

/// Some seconds of a session, from where its number says, and where they go.
fn stretch(donor: &Session, number: usize, seconds: f64) -> (PathBuf, Session) {
    let length = ((seconds * donor.rate) as usize).min(donor.len);
    let start = number * 37 % (donor.len - length + 1);
    let bike_id = format!("crowd_{:02}", number % BIKES);
    let day = number / DAILY;
    let (month, day) = (1 + day / 28 % 12, 1 + day % 28);
    let (year, second) = (2024 + number / DAILY / 336, number % DAILY);
    let date = format!("{year}-{month:02}-{day:02}");
    let session_id = format!("crowd_{number:06}");
    let path = format!("sessions/bike={bike_id}/date={date}/{session_id}.parquet");
    let meta = Meta {
        session_id,
        bike_id,
        start_time: Some(format!("{date}T{:02}:00:00Z", second)),
        ..Meta::default()
    };
    let mut session = Session::new(meta, donor.rate, length);
    for channel in donor.channels() {
        if let Some(x) = donor.get(channel) {
            session.set(channel, x[start..start + length].to_vec());
        }
    }
    (path.into(), session)
}
