//! Runs an archive and writes the front tyre of one session as a Magic Formula property file.
//!
//! ```text
//! cargo run --example export_tyre -- fixtures/archive tables archive_01_2026-05-01 front.tir
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use roadbench::{
    BatchSettings, CoefficientSet, ExportFormat, ExportRequest, ExportTyre, Location, Maps, Pages,
    Pipeline, RunWork, export_tyre, finish_run, run_batch,
};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [archive, out, session, tyre] = arguments.as_slice() else {
        return Err("usage: export_tyre ARCHIVE OUT SESSION FILE".into());
    };
    let inputs = [Location::from(archive)];
    let bikes = Location::from(archive.join("bikes"));
    let settings = BatchSettings {
        inputs: &inputs,
        bikes: Some(&bikes),
        out: &Location::from(out),
        pipeline: &Pipeline::read(Path::new("onroad"))?,
        maps: &Maps::default(),
        jobs: 0,
        force: false,
        since: None,
    };
    let never = AtomicBool::new(false);
    let (accounts, store) = run_batch(&settings, &RunWork { signals: false }, &(), &never)?;
    if store.is_behind() {
        finish_run(&store, Pages::Auto, |_| Ok(()))?;
    }
    println!("{} sessions, {} rejected", accounts.sessions.len(), accounts.rejected.len());
    drop(store); // other commands may use the tables again
    let request = ExportRequest {
        out,
        session: &session.to_string_lossy(),
        bike: None,
        format: ExportFormat::Tir,
        tyre: Some(ExportTyre::Front),
        bikes: Some(&archive.join("bikes")),
        set: CoefficientSet::Motorcycle,
        friction: 1.0,
        load: None,
        models: None,
    };
    std::fs::write(tyre, export_tyre(&request)?.bytes())?;
    Ok(())
}
