//! One good ride and what happens to logs: every damaged copy is rejected with a reason or comes
//! through with a warning, and no damage makes a wrong number that calls itself `ok`.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use arrow::array::{ArrayRef, Float64Array, RecordBatch};
use arrow::datatypes::DataType;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use roadbench::internals::batch::jobs::run::RunWork;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Maps, Settings};
use roadbench::internals::contract::channel::Channel::{self, *};
use roadbench::internals::contract::session::Session;
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::report::tables;
use roadbench::internals::simulate::plan::{Plan, PlanKind};
use roadbench::internals::simulate::scenario::Scenario;
use roadbench::internals::simulate::session;
use roadbench::internals::simulate::transients::Transients;
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::rows::{Coefficient, Status};

/// What must become of a log.
enum Fate {
    /// A row of `rejected` with one of these codes.
    Rejected(&'static [&'static str]),
    /// A session with a warning of one of these codes.
    Warned(&'static [&'static str]),
    /// A session whose numbers are those of the clean one.
    Same,
    /// Either: what was hit may not show, but then it may not matter either.
    Any,
}
use Fate::{Any, Rejected, Same, Warned};

const RATE: f64 = 50.0;

/// A short ride with every kind of manoeuvre, and its bike file.
fn ride() -> (Session, String) {
    let mut scenario = Scenario::builtin("archive").expect("scenario");
    scenario.rate = RATE;
    scenario.plans = vec![Plan {
        kind: PlanKind::Paper,
        coasts: 6,
        brakings: 5,
        laps: 5,
        transients: Transients::default(),
    }];
    let machine = scenario.machine(0);
    let mut ride = session(&scenario, &machine, 0).session;
    track(&mut ride);
    ride.meta.bike_id = "b1".into();
    (ride, machine.bike.to_toml())
}

/// Latitude and longitude of the ride, which the simulator's logger has not got.
fn track(ride: &mut Session) {
    let at = |c| ride.get(c).expect("simulated").to_vec();
    let (v, yaw) = (at(VelocityX), at(Yaw));
    let (mut x, mut y) = (0.0, 0.0);
    let (mut latitude, mut longitude) = (Vec::new(), Vec::new());
    for (v, yaw) in v.iter().zip(yaw) {
        x += v * yaw.cos() / RATE; // east
        y += v * yaw.sin() / RATE; // north
        latitude.push(44.0 + y / 111_132.0);
        longitude.push(11.0 + x / (111_320.0 * 44_f64.to_radians().cos()));
    }
    ride.set(Latitude, latitude);
    ride.set(Longitude, longitude);
}

struct Place {
    root: tempfile::TempDir,
    ride: Session,
    fates: BTreeMap<String, Fate>,
}

impl Place {
    fn new() -> Self {
        let (ride, bike) = ride();
        let root = tempfile::tempdir().expect("folder");
        let place = Place { root, ride, fates: BTreeMap::new() };
        std::fs::create_dir_all(place.path("logs")).expect("folder");
        std::fs::create_dir_all(place.path("bikes")).expect("folder");
        std::fs::write(place.path("bikes/b1.toml"), &bike).expect("bike");
        std::fs::write(place.path("bikes/broken.toml"), "mass = \"heavy\"\n").expect("bike");
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn log(&self, name: &str) -> PathBuf {
        self.path("logs").join(format!("{name}.parquet"))
    }

    /// A copy of the ride with something done to it.
    fn with(&mut self, name: &str, fate: Fate, damage: impl FnOnce(&mut Session)) {
        let mut copy = self.ride.clone();
        copy.meta.session_id = name.to_owned();
        damage(&mut copy);
        write_session(self.log(name), &copy, false).expect("log");
        self.fates.insert(name.to_owned(), fate);
    }

    /// A copy of the ride whose samples are handled one by one.
    fn map(&mut self, name: &str, fate: Fate, channels: &[Channel], f: impl Fn(usize, f64) -> f64) {
        self.with(name, fate, |session| {
            for &channel in channels {
                let x = session.get_mut(channel).expect("channel");
                x.iter_mut().enumerate().for_each(|(i, x)| *x = f(i, *x));
            }
        });
    }

    /// A copy of the ride with something done to its bytes.
    fn bytes(&mut self, name: &str, fate: Fate, damage: impl FnOnce(&mut Vec<u8>)) {
        self.with(name, fate, |_| {});
        let mut bytes = std::fs::read(self.log(name)).expect("log");
        damage(&mut bytes);
        std::fs::write(self.log(name), bytes).expect("log");
    }

    /// A copy of the ride with other stamps, which [`write_session`] could not write.
    fn stamps(&mut self, name: &str, fate: Fate, damage: impl Fn(usize, f64) -> f64) {
        self.with(name, fate, |_| {});
        let path = self.log(name);
        let file = File::open(&path).expect("log");
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("parquet");
        let rows = self.ride.len;
        let mut reader = reader.with_batch_size(rows).build().expect("reader");
        let table = reader.next().expect("rows").expect("batch");
        let time = (0..rows).map(|i| damage(i, i as f64 / RATE)).collect::<Vec<f64>>();
        let mut columns = table.columns().to_vec();
        columns[0] = Arc::new(Float64Array::from(time));
        let table = RecordBatch::try_new(table.schema(), columns).expect("same columns");
        let pair = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
        write(&path, &table, vec![pair("session_id", name), pair("bike_id", "b1")]);
    }

    /// Runs the batch over everything and checks what holds for every log.
    fn run(&self) -> Tables {
        let out = self.path("out");
        let inputs = [self.path("logs").into()];
        let bikes = self.path("bikes").into();
        let settings = Settings {
            inputs: &inputs,
            bikes: Some(&bikes),
            out: &Location::from(&out),
            pipeline: &Pipeline::onroad(),
            maps: &Maps::default(),
            jobs: 2,
            force: false,
            since: None,
        };
        let before = self.names_outside();
        let stop = AtomicBool::new(false);
        let (run, store) = engine::run(&settings, &RunWork::default(), &(), &stop).expect("run");
        drop(store);
        roadbench::internals::report::write(&out).expect("report");
        assert_eq!(before, self.names_outside(), "something was written outside --out");
        assert_eq!(run.inputs, self.fates.len());
        assert_eq!(run.sessions.len() + run.rejected.len(), run.inputs);
        let read = Tables::read(&out);
        assert_eq!(read.rejected.len(), run.rejected.len());
        read
    }

    fn names_outside(&self) -> Vec<PathBuf> {
        walkdir::WalkDir::new(self.root.path())
            .sort_by_file_name()
            .into_iter()
            .map(|e| e.expect("entry").into_path())
            .filter(|p| !p.starts_with(self.path("out")))
            .collect()
    }
}

fn write(path: &Path, table: &RecordBatch, pairs: Vec<KeyValue>) {
    let properties = WriterProperties::builder().set_key_value_metadata(Some(pairs)).build();
    let file = File::create(path).expect("file");
    let mut writer = ArrowWriter::try_new(file, table.schema(), Some(properties)).expect("writer");
    writer.write(table).expect("rows");
    writer.close().expect("closed");
}

/// What a run left, by the log's name.
struct Tables {
    rejected: BTreeMap<String, (String, String)>,
    warnings: BTreeMap<String, Vec<String>>,
    coefficients: BTreeMap<String, Vec<Coefficient>>,
}

impl Tables {
    fn read(out: &Path) -> Self {
        let stem = |path: &str| {
            Path::new(path).file_stem().map(|s| s.to_string_lossy().into_owned()).expect("a name")
        };
        let rejected = tables::rejected(out).expect("rejected");
        let mut warnings: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for w in tables::warnings(out).expect("warnings") {
            assert!(!w.message.is_empty());
            warnings.entry(w.ident.session_id).or_default().push(w.code);
        }
        let mut coefficients: BTreeMap<String, Vec<Coefficient>> = BTreeMap::new();
        for c in tables::coefficients(out).expect("coefficients") {
            coefficients.entry(c.ident.session_id.clone()).or_default().push(c);
        }
        let why = |r: roadbench::internals::store::tables::rows::Rejected| {
            (stem(&r.path), (r.code, r.message))
        };
        Tables { rejected: rejected.into_iter().map(why).collect(), warnings, coefficients }
    }

    /// What is wrong with the fate of a log; nothing if all is well.
    fn complain(&self, name: &str, fate: &Fate) -> Option<String> {
        let warned = self.warnings.get(name).map(Vec::as_slice).unwrap_or_default();
        match (fate, self.rejected.get(name)) {
            (_, Some((code, message))) if code == "internal_error" => {
                Some(format!("{name}: panicked: {message}"))
            }
            (Rejected(codes), Some((code, _))) if codes.contains(&code.as_str()) => None,
            (Rejected(codes), Some((code, message))) => {
                Some(format!("{name}: rejected as {code} ({message}), not as one of {codes:?}"))
            }
            (Rejected(codes), None) => {
                Some(format!("{name}: not rejected ({codes:?}); warnings {warned:?}"))
            }
            (Any, _) => None,
            (_, Some((code, message))) => Some(format!("{name}: rejected as {code}: {message}")),
            (Warned(codes), None) if !warned.iter().any(|w| codes.contains(&w.as_str())) => {
                Some(format!("{name}: no warning of {codes:?}, only {warned:?}"))
            }
            (Warned(_) | Same, None) => None,
        }
    }

    /// Coefficients that call themselves ok and are further from the clean ride's than the
    /// intervals of both allow.
    fn wrong(&self, name: &str) -> Vec<String> {
        let clean: BTreeMap<(&str, &str), &Coefficient> = self.coefficients["clean"]
            .iter()
            .map(|c| ((c.tyre.as_str(), c.coefficient.as_str()), c))
            .collect();
        let width = |c: &Coefficient| match (c.ci95_low, c.ci95_high) {
            (Some(low), Some(high)) => (high - low) / 2.0,
            _ => 0.0,
        };
        let ok = self.coefficients.get(name).into_iter().flatten();
        ok.filter(|c| c.status == Status::Ok)
            .filter_map(|c| {
                let reference = clean[&(c.tyre.as_str(), c.coefficient.as_str())];
                let (value, other) = (c.value?, reference.value?);
                // some hundred intervals are compared, and half a ride is no fine one: a few of 95 % miss a little
                let allowed = 1.25 * (width(c) + width(reference));
                (reference.status == Status::Ok && (value - other).abs() > allowed).then(|| {
                    format!(
                        "{name}: {} {} = {value:.5} +- {:.5}, clean {other:.5} +- {:.5}",
                        c.tyre,
                        c.coefficient,
                        width(c),
                        width(reference)
                    )
                })
            })
            .collect()
    }
}

const LATERAL: [Channel; 7] = [VelocityY, AccelerationY, Roll, Yaw, RollRate, YawRate, SteerAngle];

/// Damage to the file itself.
fn damage_files(place: &mut Place) {
    place.bytes("truncated", Rejected(&["truncated"]), |b| b.truncate(b.len() * 2 / 3));
    place.bytes("magic", Rejected(&["not_parquet"]), |b| b[..4].copy_from_slice(b"PAR7"));
    place.bytes("empty", Rejected(&["empty_file"]), Vec::clear);
    // a footer of 2 GB
    place.bytes("footer_claim", Rejected(&["truncated"]), |b| {
        let at = b.len() - 8;
        b[at..at + 4].copy_from_slice(&0x7fff_fff0_u32.to_le_bytes());
    });
    // the first page's header: thrift compact, field 1 (type), field 2 (uncompressed size) as
    // zigzag varints; 2 GB in the latter
    place.bytes("page_claim", Rejected(&["damaged", "truncated"]), |b| {
        assert_eq!((b[4], b[6]), (0x15, 0x15), "a page header begins after the magic");
        b[7..12].copy_from_slice(&[0xfe, 0xff, 0xff, 0xff, 0x0f]);
    });
    // bytes in the middle: Parquet has no checksum that must be there
    place.bytes("scribbled", Any, |b| {
        let middle = b.len() / 2;
        b[middle..middle + 4096].fill(0xff);
    });
    let text = DataType::Utf8;
    let words: ArrayRef = Arc::new(arrow::array::StringArray::from(vec!["fast", "slow"]));
    let stamps: ArrayRef = Arc::new(Float64Array::from(vec![0.0, 0.02]));
    let field = |name: &str, kind| arrow::datatypes::Field::new(name, kind, true);
    let fields = vec![field("time", DataType::Float64), field("velocity_x", text)];
    let schema = Arc::new(arrow::datatypes::Schema::new(fields));
    let table = RecordBatch::try_new(schema, vec![stamps, words]).expect("table");
    let pair = KeyValue::new("bike_id".to_owned(), "b1".to_owned());
    write(&place.log("words"), &table, vec![pair]);
    place.fates.insert("words".into(), Rejected(&["wrong_type"]));
}

/// Damage to the columns.
fn damage_columns(place: &mut Place) {
    let degrees = |_: usize, x: f64| x.to_degrees();
    place.with("no_velocity", Rejected(&["missing_column"]), |s| {
        s.remove(VelocityX);
    });
    place.with("no_steer", Same, |s| {
        s.remove(SteerAngle);
    });
    place.map("velocity_kmh", Rejected(&["unit_velocity"]), &[VelocityX], |_, v| 3.6 * v);
    place.map("roll_deg", Rejected(&["unit_angle"]), &[Roll], degrees);
    place.map("steer_deg", Rejected(&["unit_angle"]), &[SteerAngle], degrees);
    place.map("yaw_rate_deg", Rejected(&["unit_rate"]), &[YawRate], degrees);
    place.map("acceleration_g", Warned(&["unit_acceleration"]), &[AccelerationX], |_, a| a / 9.81);
    place.map("velocity_nan", Rejected(&["missing_column"]), &[VelocityX], |_, _| f64::NAN);
    place.map("roll_nan", Warned(&["empty_channel"]), &[Roll], |_, _| f64::NAN);
    place.map("front_stuck", Warned(&["stuck"]), &[WheelSpeedFront], |_, _| 42.0);
    // a gyro of +-50 deg/s: half of what the corners ask for
    place.map("yaw_rate_clipped", Warned(&["clipped"]), &[YawRate], |_, r| r.clamp(-0.3, 0.3));
    place.map("spikes", Warned(&["spike"]), &[WheelSpeedRear], |i, w| {
        if i % 977 == 500 { w + 400.0 } else { w }
    });
    place.with("wheels", Rejected(&["wheels_swapped"]), |s| {
        exchange(s, [WheelSpeedFront, WheelSpeedRear])
    });
    place.with("brakes", Rejected(&["brakes_swapped"]), |s| {
        exchange(s, [BrakePressureFront, BrakePressureRear]);
    });
    place.map("roll_mirrored", Rejected(&["sign_roll_yaw"]), &[Roll], |_, x| -x);
    place.map("yaw_mirrored", Warned(&["sign_yaw"]), &[Yaw], |_, x| -x);
    place.map("all_mirrored", Warned(&["sign_lateral"]), &LATERAL, |_, x| -x);
    place.map("backwards", Rejected(&["sign_velocity_x"]), &[VelocityX], |_, v| -v);
}

fn exchange(session: &mut Session, [a, b]: [Channel; 2]) {
    let (x, y) = (session.remove(a).expect("a"), session.remove(b).expect("b"));
    session.set(a, y);
    session.set(b, x);
}

/// Damage to the clock.
fn damage_clocks(place: &mut Place) {
    // the logger's clock is set back by 3 s in the middle of the ride
    let middle = place.ride.len / 2;
    place.stamps("time_backwards", Warned(&["time_backwards"]), move |i, t| {
        if i < middle { t } else { t - 3.0 }
    });
    place.stamps("time_reversed", Rejected(&["too_short", "no_time"]), |_, t| -t);
    place.stamps("time_nan", Rejected(&["no_time"]), |_, _| f64::NAN);
    place.stamps(
        "gap_in_time",
        Warned(&["gap"]),
        move |i, t| if i < middle { t } else { t + 30.0 },
    );
    place.with("gap_in_samples", Warned(&["gap"]), move |s| {
        let channels: Vec<Channel> = s.channels().collect();
        let gap = middle..middle + (30.0 * RATE) as usize;
        for c in channels {
            s.get_mut(c).expect("there")[gap.clone()].fill(f64::NAN);
        }
    });
    let one = |place: &Place| {
        let mut short = Session::new(place.ride.meta.clone(), RATE, 1);
        for c in place.ride.channels() {
            short.set(c, vec![place.ride.get(c).expect("there")[0]]);
        }
        short
    };
    let one = one(place);
    place.with("one_row", Rejected(&["too_short"]), |s| {
        let id = s.meta.session_id.clone();
        *s = one;
        s.meta.session_id = id;
    });
}

/// Names that lead elsewhere, are taken or mean nothing.
fn damage_names(place: &mut Place) {
    place.with("dots", Rejected(&["bad_session_id"]), |s| {
        s.meta.session_id = "../../outside".into();
    });
    place.with("bike_dots", Rejected(&["bad_bike_id"]), |s| s.meta.bike_id = "../b1".into());
    place.with("unknown_bike", Rejected(&["no_bike_file"]), |s| s.meta.bike_id = "b7".into());
    place.with("broken_bike", Rejected(&["bad_bike_file"]), |s| s.meta.bike_id = "broken".into());
    // after `clean` in order of path
    place.with("duplicate", Rejected(&["duplicate_session_id"]), |s| {
        s.meta.session_id = "clean".into();
    });
}

#[test]
fn dirt_is_named_and_never_believed() {
    let mut place = Place::new();
    place.with("clean", Same, |_| {});
    damage_files(&mut place);
    damage_columns(&mut place);
    damage_clocks(&mut place);
    damage_names(&mut place);
    place.map("velocity_scale", Same, &[VelocityX], |_, v| 1.05 * v);
    let tables = place.run();
    let mut complaints: Vec<String> =
        place.fates.iter().filter_map(|(name, fate)| tables.complain(name, fate)).collect();
    let clean = &tables.coefficients["clean"];
    let n_ok = clean.iter().filter(|c| c.status == Status::Ok).count();
    assert!(n_ok >= 15, "the clean ride determines only {n_ok} coefficients");
    // the comparison has teeth: 5 % of the velocity cannot be seen, and makes numbers wrong
    assert!(!tables.wrong("velocity_scale").is_empty());
    for name in place.fates.keys().filter(|n| *n != "velocity_scale") {
        complaints.extend(tables.wrong(name));
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    let steer = tables.coefficients["no_steer"].iter();
    let lost = steer.filter(|c| c.status != Status::Ok).count();
    assert!(lost > clean.len() - n_ok, "without the steer angle something must be missing");
}
