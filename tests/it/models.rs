//! `run --model`: each session is freed of its own causes and of those that it shares, on the bundled
//! archive with models written by hand. Its velocities are 20 ms late; steering zeros are each ride's own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{Coefficient, Truth, WarningRow};

/// What is off in the steering of rides of the first motorcycle, as they are diagnosed, rad.
const ZEROS: [(u32, f64); 3] = [(1, -0.0042), (4, 0.0023), (6, -0.0028)];
const POOLED: &str = "[[pooled]]\neffect = \"latency\"\nlevel = \"fleet\"\nvalue = 0.02\n\
    std_error = 0.001\nunit = \"s\"\nsessions = 12\n";
const LATE: &str = "latency (pooled over 12 sessions of the fleet)";

fn archive() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive")
}

fn id(number: u32) -> String {
    format!("archive_s{number:04}")
}

/// The log of a session: two rides a day, six on each motorcycle.
fn log(number: u32) -> String {
    let (bike, day) = ((number - 1) / 6 + 1, (number - 1) / 2 + 1);
    let below = format!("sessions/bike=archive_{bike:02}/date=2026-05-{day:02}");
    archive().join(below).join(format!("{}.parquet", id(number))).to_string_lossy().into_owned()
}

struct Place {
    folder: tempfile::TempDir,
}

struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Place {
    fn new() -> Self {
        Place { folder: tempfile::tempdir().expect("folder") }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("parent")).expect("folder");
        std::fs::write(path, text).expect("written");
    }

    /// Writes the model of a session into the folder of a diagnosis.
    fn model(&self, number: u32, effects: &[(&str, f64)]) {
        let bike = format!("archive_{:02}", (number - 1) / 6 + 1);
        let mut text = format!("session_id = \"{}\"\nbike_id = \"{bike}\"\n", id(number));
        for (name, value) in effects {
            let unit = Effect::named(name).map_or("1", |e| e.unit);
            text += &format!(
                "[effects.{name}]\nvalue = {value:?}\nstd_error = 0.001\nunit = \"{unit}\"\n"
            );
        }
        self.put(&format!("causes/models/bike={bike}/{}.toml", id(number)), &text);
    }

    fn run(&self, numbers: &[u32], more: &[&str]) -> Said {
        let bikes = archive().join("bikes").to_string_lossy().into_owned();
        let output = Command::cargo_bin("roadbench")
            .expect("binary")
            .current_dir(self.folder.path())
            .arg("run")
            .args(numbers.iter().map(|n| log(*n)))
            .args(["--bikes", &bikes])
            .args(more)
            .output()
            .expect("ran");
        Said {
            code: output.status.code().expect("not killed"),
            out: String::from_utf8(output.stdout).expect("utf-8"),
            err: String::from_utf8(output.stderr).expect("utf-8"),
        }
    }

    /// Runs sessions with a model, or none.
    fn freed(&self, numbers: &[u32], out: &str, model: Option<&str>) {
        let model = model.map(|m| vec!["--model", m]).unwrap_or_default();
        let said = self.run(numbers, &[&["--out", out][..], &model].concat());
        assert_eq!(said.code, 0, "{}", said.err);
    }

    /// The numbers of the sessions that would be computed.
    fn stale(&self, numbers: &[u32], out: &str, model: Option<&str>) -> Vec<u32> {
        let model = model.map(|m| vec!["--model", m]).unwrap_or_default();
        let said = self.run(numbers, &[&["--out", out, "--dry-run"][..], &model].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        let is_stale = |n: &&u32| {
            let own = |line: &&str| line.starts_with("compute") && line.contains(&id(**n));
            said.out.lines().any(|line| own(&line))
        };
        numbers.iter().filter(is_stale).copied().collect()
    }

    /// What the models did to each session, by its number.
    fn told(&self, out: &str) -> BTreeMap<u32, String> {
        let rows: Vec<WarningRow> = read::rows(&self.path(out)).expect("warnings");
        let of_model = rows.into_iter().filter(|row| row.code.starts_with("model_"));
        let number = |id: &str| id.trim_start_matches("archive_s").parse().expect("number");
        let mut told: BTreeMap<u32, String> = BTreeMap::new();
        for row in of_model {
            *told.entry(number(&row.ident.session_id)).or_default() += &row.message;
        }
        told
    }

    /// Mean relative error of a coefficient of the front tyre over sessions.
    fn error(&self, out: &str, numbers: &[u32], coefficient: &str) -> f64 {
        let rows: Vec<Coefficient> = read::rows(&self.path(out)).expect("coefficients");
        let off = |n: &u32| {
            let bike = format!("bike=archive_{:02}", (n - 1) / 6 + 1);
            let file = format!("truth/coefficients/{bike}/{}.parquet", id(*n));
            let truth: Vec<Truth> = read::file_rows(&archive().join(file)).expect("truth");
            let is_it = |tyre: &str, name: &str| tyre == "front" && name == coefficient;
            let truth = truth.iter().find(|t| is_it(&t.tyre, &t.coefficient)).expect("truth");
            let own = rows
                .iter()
                .find(|r| r.ident.session_id == id(*n) && is_it(&r.tyre, &r.coefficient));
            (own.and_then(|r| r.value).expect("a number") / truth.value - 1.0).abs()
        };
        numbers.iter().map(off).sum::<f64>() / numbers.len() as f64
    }

    /// Every table of an output.
    fn tables(&self, out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let root = self.path(out);
        let files = walkdir::WalkDir::new(&root).into_iter().map(|e| e.expect("entry").into_path());
        files
            .filter(|path| path.extension().is_some_and(|e| e == "parquet"))
            .map(|path| {
                let bytes = std::fs::read(&path).expect("bytes");
                (path.strip_prefix(&root).expect("below").to_owned(), bytes)
            })
            .collect()
    }
}

/// Rides 1, 2, 4 and 6 of one motorcycle were diagnosed, 5 and those of the other one not.
fn diagnosed() -> Place {
    let place = Place::new();
    for (number, zero) in ZEROS {
        place.model(number, &[("steer_zero", zero), ("latency", 0.024)]);
    }
    place.model(2, &[("latency", 0.017)]);
    place.put("causes/models/pooled.toml", POOLED);
    place
}

#[test]
fn own_causes_go_to_their_session_and_shared_ones_to_all() {
    let place = diagnosed();
    let rides = [1, 2, 4, 5, 6, 7];
    place.freed(&rides, "with", Some("causes"));
    let own = format!("removed from the recording: steer_zero (its own), {LATE}");
    let shared = format!("removed from the recording: {LATE}");
    let expected = rides.map(|n| {
        let has_zero = ZEROS.iter().any(|(k, _)| *k == n);
        (n, if has_zero { own.clone() } else { shared.clone() })
    });
    assert_eq!(place.told("with"), BTreeMap::from(expected));

    // what a steering zero is wrong by: nearer to the truth, and not by another ride's zero (changing lean, which gives the
    // cornering stiffness, frees the zero by itself)
    place.freed(&rides, "without", None);
    let zeros = ZEROS.map(|(n, _)| n);
    place.freed(&zeros, "foreign", Some("causes/models/bike=archive_01/archive_s0001.toml"));
    let error = |out| place.error(out, &zeros, "slip_camber_c1");
    let (with, without) = (error("with"), error("without"));
    println!("front slip_camber_c1: {without:.4} without, {with:.4} with");
    assert!(with < without, "slip_camber_c1: {with} with, {without} without");
    let (own, foreign) = (
        place.error("with", &[4], "slip_camber_c1"),
        place.error("foreign", &[4], "slip_camber_c1"),
    );
    assert!(own < foreign, "{own} with its own zero, {foreign} with that of the first ride");

    // the same again gives the same bytes, whichever folder is named
    place.freed(&rides, "again", Some("causes/models"));
    assert!(place.tables("with") == place.tables("again"), "bytes differ");
}

#[test]
fn only_sessions_whose_causes_have_changed_are_computed_again() {
    let place = diagnosed();
    let rides = [1, 2, 7];
    let stale = |model| place.stale(&rides, "out", model);
    place.freed(&rides, "out", None);
    assert!(stale(None).is_empty());
    // nothing is shared: those that were not diagnosed are as they were
    std::fs::remove_file(place.path("causes/models/pooled.toml")).expect("removed");
    assert_eq!(stale(Some("causes")), [1, 2]);
    let of_bike = POOLED.replace("\"fleet\"", "\"bike\"\ngroup = \"archive_02\"");
    place.put("causes/models/pooled.toml", &of_bike);
    assert_eq!(stale(Some("causes")), [1, 2, 7]);

    place.put("causes/models/pooled.toml", POOLED);
    place.freed(&rides, "out", Some("causes"));
    assert!(stale(Some("causes")).is_empty());
    assert_eq!(stale(None), [1, 2, 7]);
    // its own latency is replaced by the shared one, so that it does not matter
    place.model(2, &[("latency", 0.018)]);
    assert!(stale(Some("causes")).is_empty());
    place.model(1, &[("steer_zero", -0.0041)]);
    assert_eq!(stale(Some("causes")), [1]);
    place.put("causes/models/pooled.toml", &POOLED.replace("0.02\n", "0.021\n"));
    assert_eq!(stale(Some("causes")), [1, 2, 7]);
    // a night's, which only the log says
    let of_night = POOLED.replace("\"fleet\"", "\"night\"\ngroup = \"2026-05-04\"");
    place.put("causes/models/pooled.toml", &of_night);
    place.freed(&rides, "out", Some("causes"));
    let told = place.told("out");
    assert!(told[&7].contains("latency (pooled over 12 sessions of 2026-05-04)"), "{told:?}");
    assert!(told[&2].contains("latency (its own)"), "{told:?}");
    assert!(stale(Some("causes")).is_empty());
    let of_night = of_night.replace("0.02\n", "0.021\n");
    place.put("causes/models/pooled.toml", &of_night);
    assert_eq!(stale(Some("causes")), [7]);
}

#[test]
fn of_one_file_the_motorcycles_causes_go_to_its_sessions() {
    let place = Place::new();
    place.model(1, &[("latency", 0.02), ("wind", 0.5), ("lift", 0.01)]);
    let file = "causes/models/bike=archive_01/archive_s0001.toml";
    place.freed(&[1, 2, 7], "out", Some(file));
    let told = place.told("out");
    let late = "latency (found in archive_s0001, usually the motorcycle's)";
    for number in [1, 2] {
        assert!(told[&number].contains(late), "{told:?}");
        let left = "stays in the coefficients: lift (found in archive_s0001";
        assert!(told[&number].contains(left), "{told:?}");
    }
    assert!(told[&1].contains("wind (its own)") && !told[&2].contains("wind"), "{told:?}");
    assert!(!told.contains_key(&7), "another motorcycle's: {told:?}");
}

#[test]
fn what_is_wrong_with_models_is_said() {
    let place = diagnosed();
    std::fs::create_dir(place.path("empty")).expect("folder");
    let of_first = "causes/models/bike=archive_01/archive_s0001.toml";
    let refused = |model: &str, says: &[&str]| {
        let said = place.run(&[1], &["--out", "out", "--model", model]);
        assert_eq!(said.code, 2, "{model}: {}", said.err);
        for part in says {
            assert!(said.err.contains(part), "{model}: {part}: {}", said.err);
        }
        assert!(!place.path("out").exists(), "{model}");
    };
    refused("empty", &["there is no model in this folder", "roadbench diagnose"]);
    refused("gone", &["gone", "file not found"]);
    refused("causes/models/bike=archive_01", &["one motorcycle's", "the folder above"]);
    refused("causes/models/pooled.toml", &["what sessions share", "the folder"]);

    place.model(1, &[("latancy", 0.02)]);
    refused("causes", &[of_first, "`latancy`", "did you mean `latency`?"]);
    refused(of_first, &[of_first, "did you mean `latency`?"]);
    place.model(1, &[("latency", 7.0)]);
    refused("causes", &[of_first, "effects.latency.value: 7 s is not between"]);
    place.put(of_first, "session_id = \"archive_s0001\"\nbike_id = 7\n");
    refused("causes", &[of_first, "bike_id"]);
    place.put(of_first, "session_id = \"archive_s0002\"\nbike_id = \"archive_01\"\n");
    refused("causes", &["`archive_s0002` has two models"]);
    place.model(1, &[]);
    let pooled = "causes/models/pooled.toml";
    place.put(pooled, &POOLED.replace("fleet", "fleat"));
    refused("causes", &[pooled, "fleat", "did you mean `fleet`?"]);
    place.put(pooled, &POOLED.replace("latency", "latancy"));
    refused("causes", &[pooled, "pooled[0].effect", "did you mean `latency`?"]);
    place.put(pooled, &POOLED.replace("0.02\n", "2.0\n"));
    refused("causes", &[pooled, "pooled[0].value: 2 s is not between"]);
    place.put(pooled, POOLED);
    let off = ["--out", "out", "--model", "causes", "--pipeline", "offroad"];
    assert_eq!(place.run(&[1], &off).code, 2);
}
