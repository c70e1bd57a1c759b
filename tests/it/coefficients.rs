//! One declaration of each coefficient: what `inspect`, `run`, the pages and the simulator's truth say of
//! it cannot differ.

use std::path::Path;

use assert_cmd::Command;
use roadbench::internals::contract::coefficient::{Coefficient, Id, Source};
use roadbench::internals::estimate::Config;
use roadbench::internals::report::export::fitted::Fitted;
use roadbench::internals::report::labels;
use roadbench::internals::simulate::scenario::Scenario;
use roadbench::internals::simulate::{session, truth};
use roadbench::internals::store::tables::rows::Status;

const LOG: &str = "fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet";
const BIKES: &str = "fixtures/archive/bikes";

/// Runs the binary in the repository and gives back what it prints.
fn roadbench(arguments: &[&str]) -> String {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = command.current_dir(here).args(arguments).output().expect("the binary ran");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn what_inspect_calls_assumed_run_and_the_pages_call_assumed() {
    let text = roadbench(&["inspect", LOG, "--bikes", BIKES, "--json"]);
    let inspection: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out").to_string_lossy().into_owned();
    roadbench(&["run", LOG, "--bikes", BIKES, "--out", &out, "--progress", "never"]);
    let fitted = Fitted::read(Path::new(&out), "archive_s0001", None).expect("session");
    let mut seen = 0;
    for group in inspection["estimates"].as_array().expect("a list") {
        let (tyre, status) = (group["tyre"].as_str(), group["status"].as_str());
        for name in group["coefficients"].as_array().expect("a list") {
            let name = name.as_str().expect("a name");
            let id = Id::from_names(tyre.expect("a tyre"), name).expect("known");
            let row = fitted.row(id.part, id.coefficient).expect("a row");
            let taken = matches!(id.coefficient.spec().source, Source::BikeFile(_));
            assert_eq!(status == Some("assumed"), taken, "{id}");
            // as far as the lean changed
            if matches!(id.coefficient.spec().source, Source::ChangingLean(_)) {
                assert_eq!(status, Some("possible"), "{id}");
                assert_ne!(row.status, Status::NotAvailable, "{id}");
                let riding = labels::riding(&row.tyre, name).expect("known");
                assert!(riding.contains("slaloms"), "{id}: {riding}");
                assert_eq!(group["riding"].as_str(), Some(riding), "{id}");
                seen += 1;
                continue;
            }
            // the second curvature is assumed where the ride has one side of the curve
            let assumed = row.status == Status::Assumed && id.coefficient != Coefficient::MfE2;
            assert_eq!(assumed, taken, "{id}");
            let riding = labels::riding(&row.tyre, name).expect("known");
            assert_eq!(riding.contains("no riding manoeuvre"), taken, "{id}");
            assert_eq!(group["riding"].as_str(), Some(riding), "{id}");
            seen += 1;
        }
    }
    assert_eq!(seen, Id::onroad().count());
}

#[test]
fn the_truth_takes_the_corner_samples_that_the_estimate_takes() {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let ride = session(&scenario, &machine, 0);
    let c1 = |config: &Config| {
        let known = truth::coefficients(&machine.plant, &ride, config);
        let of_slip = |t: &&(Id, f64)| t.0.coefficient == Coefficient::SlipCamberC1;
        known.iter().find(of_slip).expect("known").1
    };
    let usual = Config::default();
    for other in [
        Config { min_camber: 0.4, ..usual.clone() },
        Config { max_roll_rate: 0.01, ..usual.clone() },
        Config { corner_rate: 3.0, ..usual.clone() },
    ] {
        assert_ne!(c1(&usual), c1(&other), "{other:?}");
    }
}
