//! Tyres that fade on a simulated track session are found lap by lap, with tables, plots and page; tyres that do not are
//! left alone. The study `examples/lap_fade` counts over many sessions.

use std::fs;

use assert_cmd::Command;
use roadbench::internals::fit::in_gear;
use roadbench::internals::fit::in_gear::{by_lap, lap_rows};
use roadbench::internals::ingest;
use roadbench::internals::simulate::track::{self, Track, TrackRide};
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{Ident, LapCoefficientRow, LapRow, LapTrendRow};

/// Of the rides; the study reports on others, the errors were tuned on others again.
const SEED: u64 = 4410;
/// Share of the forces that goes from the first timed lap to the last.
const FADE: f64 = 0.08;
/// Timed laps, and one before them.
const LAPS: usize = 8;

fn ridden(fade: f64) -> TrackRide {
    let base = Track::load("track").expect("built in").expect("a track");
    let fade = fade * (LAPS as f64 + 1.0) / (LAPS as f64 - 1.0);
    track::ride(&Track { seed: SEED, laps: LAPS + 1, fade, ..base }, 2).expect("comes round")
}

fn stiffness(trends: &[LapTrendRow]) -> &LapTrendRow {
    let own = |t: &&LapTrendRow| t.tyre == "rear" && t.coefficient == "slip_stiffness";
    trends.iter().find(own).expect("determined")
}

#[test]
fn tyres_that_do_not_fade_have_no_trend() {
    let ridden = ridden(0.0);
    let (session, bike) = (&ridden.ride.session, &ridden.entry.bike);
    let config = in_gear::Config::default();
    let fit = in_gear::run(session, bike, &config).expect("fitted");
    let crossed = ridden.crossings.windows(2).enumerate().skip(1);
    let laps: Vec<(i64, f64, f64)> = crossed.map(|(k, c)| (k as i64, c[0], c[1])).collect();
    assert!(by_lap::run(session, bike, &config, &fit, &laps[..5]).is_empty(), "too few");
    let found = by_lap::run(session, bike, &config, &fit, &laps);
    let (rows, trends) = lap_rows::rows(&found, &Ident::default());
    assert_eq!(rows.len(), LAPS * trends.len());
    let rear = stiffness(&trends);
    assert!(rear.change_low < 0.0 && rear.change_high > 0.0, "{rear:?}");
    assert!(rear.change_high - rear.change_low < 0.1, "{rear:?}");
    assert!(trends.iter().all(|t| t.verdict == "none"), "{trends:?}");
    // radii are known to a thousandth
    let radii = trends.iter().filter(|t| t.coefficient == "effective_rolling_radius");
    assert!(radii.clone().all(|t| t.change_high - t.change_low < 0.005), "{trends:?}");
    assert_eq!(radii.count(), 2);
}

#[test]
fn a_fade_is_found_and_said_by_tables_page_and_terminal() {
    let ridden = ridden(FADE);
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let (session, bike) = (&ridden.ride.session, &ridden.entry.bike);
    let id = &bike.bike_id;
    fs::create_dir_all(at("rides/bikes")).expect("made");
    fs::write(at(&format!("rides/bikes/{id}.toml")), bike.to_toml()).expect("written");
    let mut session = session.clone();
    session.markers.times =
        ridden.crossings[1..].iter().map(|t| (t * 1e3).round() * 1e-3).collect();
    ingest::write_session(at("rides/fading.parquet"), &session, true).expect("written");
    let mut run = Command::cargo_bin("roadbench").expect("built");
    run.arg("run").arg(at("rides")).arg("--out").arg(at("out"));
    let said = run.assert().success();
    let said = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
    assert!(
        said.contains("by the logger's markers") && said.contains("Tyres over 8 laps: "),
        "{said}"
    );
    let out = at("out");
    let trends: Vec<LapTrendRow> = read::rows(&out).expect("a table");
    let rear = stiffness(&trends);
    let truth = -FADE / (1.0 - 0.5 * FADE * 9.0 / 7.0);
    println!("found {:+.3} to {:+.3}, truth {truth:+.3}", rear.change_low, rear.change_high);
    assert!(rear.verdict == "falls" && rear.change_high < 0.0, "{rear:?}");
    assert!((rear.change_low..rear.change_high).contains(&truth), "{rear:?}");
    let each: Vec<LapCoefficientRow> = read::rows(&out).expect("a table");
    assert_eq!(each.len(), 8 * trends.len());
    let laps: Vec<LapRow> = read::rows(&out).expect("a table");
    let timed: Vec<&LapRow> = laps.iter().filter(|l| l.kind == "timed").collect();
    assert_eq!(timed.len(), 8);
    let off =
        timed.iter().filter_map(|l| l.position_difference).fold(0.0, |m: f64, d| m.max(d.abs()));
    println!("markers against position: at most {off:.3} s");
    assert!(timed.iter().all(|l| l.timed_by == "markers") && off < 0.1, "{off}");
    let html = fs::read_dir(out.join("report"))
        .expect("a report")
        .map(|e| e.expect("entry").path())
        .find(|p| {
            p.file_name().is_some_and(|n| {
                n.to_string_lossy().contains("fading")
                    || n.to_string_lossy().contains(&*session.meta.session_id)
            })
        })
        .map(|p| fs::read_to_string(p).expect("a page"))
        .expect("the session's page");
    for words in ["Tyres over the laps", "Slip stiffness over the laps", "By position, s"] {
        assert!(html.contains(words), "{words}");
    }
    assert!(html.contains("markers against position"));
}
