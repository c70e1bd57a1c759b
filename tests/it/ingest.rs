//! Ingest from the outside: files in, sessions or reasons out.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use proptest::prelude::*;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::contract::warning::Warning;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::{self, Config, Raw, Track};

const NAN: f64 = f64::NAN;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Deterministic noise, uniform in -1..1.
fn noise(n: usize) -> impl Iterator<Item = f64> {
    let mut state = 42_u64;
    (0..n).map(move |_| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

fn wave(frequency: f64, t: f64) -> f64 {
    (std::f64::consts::TAU * frequency * t).sin()
}

/// Time by which a channel lags a sine of that frequency, s.
fn lag(session: &Session, channel: Channel, frequency: f64) -> f64 {
    let (mut sin, mut cos) = (0.0, 0.0);
    for (i, v) in session.get(channel).expect("there").iter().enumerate().filter(|v| !v.1.is_nan())
    {
        let phase = std::f64::consts::TAU * frequency * session.time(i);
        sin += v * phase.sin();
        cos += v * phase.cos();
    }
    -cos.atan2(sin) / (std::f64::consts::TAU * frequency)
}

fn session(seconds: usize) -> Session {
    let meta = Meta {
        session_id: "s1".into(),
        bike_id: "b1".into(),
        start_time: Some("2025-06-01T10:00:00Z".into()),
        tyre_front: Some("front tyre".into()),
        tyre_rear: None,
        site: Some("Mugello".into()),
        rider_id: Some("r".into()),
    };
    let len = seconds * 100;
    let mut session = Session::new(meta, 100.0, len);
    let noisy = |scale: f64| noise(len).map(|x| scale * x).collect::<Vec<f64>>();
    let speed = noise(len).map(|x| 20.0 + 0.1 * x).collect();
    session.set(Channel::VelocityX, speed);
    session.set(Channel::Roll, (0..len).map(|i| 0.3 * wave(0.2, i as f64 / 100.0)).collect());
    session.set(Channel::YawRate, noisy(0.2));
    session.set(Channel::Gear, vec![3.0; len]);
    session
}

fn raw(time: Vec<f64>, channel: Channel, values: Vec<f64>) -> Raw {
    let track = Track { channel, time: Arc::new(time), values };
    Raw { tracks: vec![track], ..Raw::default() }
}

fn run(raw: Raw) -> (Session, Vec<Warning>) {
    ingest::run(raw, &Config::default()).expect("usable")
}

fn codes(warnings: &[Warning]) -> Vec<&'static str> {
    warnings.iter().map(|w| w.code).collect()
}

fn read_back(path: &Path) -> (Session, Vec<Warning>) {
    run(ingest::read(path, &[]).expect("readable"))
}

fn written(folder: &Path, session: &Session) -> PathBuf {
    let path = folder.join("s.parquet");
    ingest::write_session(&path, session, false).expect("written");
    path
}

#[test]
fn what_is_written_is_read_back_bit_for_bit() {
    let folder = folder();
    let mut session = session(20);
    let roll = session.get_mut(Channel::Roll).expect("there");
    roll[500..600].fill(NAN);
    let path = written(folder.path(), &session);
    let (back, warnings) = read_back(&path);
    assert_eq!(codes(&warnings), ["gap"]);
    assert_eq!((warnings[0].channel, warnings[0].time), (Some(Channel::Roll), Some(5.0)));
    assert_eq!(back.meta, session.meta);
    assert_eq!((back.rate, back.len), (100.0, 2000));
    for channel in session.channels() {
        let bits = |s: &Session| -> Vec<u64> {
            s.get(channel).expect("there").iter().map(|v| v.to_bits()).collect()
        };
        assert_eq!(bits(&session), bits(&back), "{channel}");
    }
    assert_eq!(ingest::identify(&path, &[]).expect("known").meta.bike_id, "b1");
}

#[test]
fn float32_keeps_seven_digits_in_fewer_bytes() {
    let folder = folder();
    let session = session(60);
    let narrow = folder.path().join("n.parquet");
    ingest::write_session(&narrow, &session, true).expect("written");
    let (back, _) = read_back(&narrow);
    let pairs = session.get(Channel::VelocityX).expect("a").iter();
    for (a, b) in pairs.zip(back.get(Channel::VelocityX).expect("b")) {
        assert!((a - b).abs() < 1e-7 * a.abs());
    }
    let size = |p: &Path| std::fs::metadata(p).expect("there").len();
    assert!(size(&narrow) * 10 < size(&written(folder.path(), &session)) * 7);
}

#[test]
fn jittered_stamps_keep_the_phase() {
    // 100 Hz, stamps off by up to 4 ms: taken at face value, neighbours would nearly swap
    let n = 6000;
    let taken = |i: usize| i as f64 / 100.0;
    let stamps: Vec<f64> = noise(n).enumerate().map(|(i, x)| taken(i) + 0.004 * x).collect();
    let first = stamps[0];
    let values = (0..n).map(|i| wave(5.0, taken(i))).collect();
    let (session, warnings) = run(raw(stamps, Channel::YawRate, values));
    assert_eq!(codes(&warnings), ["time_jitter"]);
    assert_eq!(session.rate, 100.0);
    // the session begins at the first repaired stamp, near 0
    let lag = lag(&session, Channel::YawRate, 5.0);
    assert!(lag.abs() < 0.5e-3, "{lag} s; the first stamp was off by {first} s");
}

#[test]
fn coarse_stamps_are_spread_over_the_rows() {
    // whole tenths of a second at 100 Hz
    let n = 3000;
    let stamps = (0..n).map(|i| f64::from(i / 10) / 10.0).collect();
    let values = (0..n).map(|i| wave(2.0, f64::from(i) / 100.0)).collect();
    let (session, warnings) = run(raw(stamps, Channel::YawRate, values));
    assert_eq!(codes(&warnings), ["time_jitter"]);
    assert!((session.len as i64 - 3000).abs() <= 1 && session.rate == 100.0);
}

#[test]
fn two_clocks_meet_without_delay() {
    let fast: Vec<f64> = (0..2000).map(|i| f64::from(i) / 100.0).collect();
    let slow: Vec<f64> = (0..780).map(|i| 0.0037 + f64::from(i) / 39.0).collect();
    let track = |channel, time: &[f64]| Track {
        channel,
        time: Arc::new(time.to_vec()),
        values: time.iter().map(|t| wave(3.0, *t)).collect(),
    };
    let tracks = vec![track(Channel::YawRate, &fast), track(Channel::RollRate, &slow)];
    let (session, _) = run(Raw { tracks, ..Raw::default() });
    assert_eq!(session.rate, 100.0);
    assert!(lag(&session, Channel::RollRate, 3.0).abs() < 0.1e-3);
    let worst = session
        .get(Channel::RollRate)
        .expect("there")
        .iter()
        .enumerate()
        .filter(|(_, v)| !v.is_nan())
        .map(|(i, v)| (v - wave(3.0, session.time(i))).abs())
        .fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn repeated_and_backward_stamps_are_left_out() {
    let mut stamps: Vec<f64> = (0..1000).map(|i| f64::from(i) / 100.0).collect();
    let values: Vec<f64> = stamps.iter().map(|t| wave(0.5, *t)).collect();
    stamps[100] = stamps[99];
    stamps[300] = 0.2;
    stamps[500] = 99.0;
    stamps[700] = NAN;
    let (session, warnings) = run(raw(stamps, Channel::Roll, values));
    assert_eq!(codes(&warnings), ["time_missing", "time_duplicated", "time_backwards"]);
    assert_eq!(warnings[1].time, Some(0.99));
    assert_eq!(warnings[2].count, 2);
    assert_eq!((session.rate, session.len), (100.0, 1000));
    for (i, v) in session.get(Channel::Roll).expect("there").iter().enumerate() {
        assert!((v - wave(0.5, session.time(i))).abs() < 1e-4, "{i}: {v}");
    }
}

#[test]
fn a_restarted_clock_leaves_its_longest_part() {
    let part = |n: u32| (0..n).map(|i| f64::from(i) / 100.0);
    let stamps: Vec<f64> = part(500).chain(part(2000)).collect();
    let values = stamps.iter().map(|t| wave(0.5, *t)).collect();
    let (session, warnings) = run(raw(stamps, Channel::Roll, values));
    assert_eq!(codes(&warnings), ["time_backwards"]);
    assert!(warnings[0].message.contains("500 of 2500 rows"), "{}", warnings[0].message);
    assert_eq!(session.len, 2000);
}

#[test]
fn a_long_gap_stays_and_a_short_one_is_bridged() {
    let kept = |i: &u32| !(1000..4000).contains(i) && !(500..510).contains(i);
    let stamps: Vec<f64> = (0..6000).filter(kept).map(|i| f64::from(i) / 100.0).collect();
    let values = stamps.iter().map(|t| wave(0.5, *t)).collect();
    let (session, warnings) = run(raw(stamps, Channel::Roll, values));
    assert_eq!(codes(&warnings), ["gap"]);
    assert_eq!((warnings[0].count, warnings[0].time), (1, Some(10.0)));
    let roll = session.get(Channel::Roll).expect("there");
    assert_eq!(roll.iter().filter(|v| v.is_nan()).count(), 3000);
    for (i, v) in roll.iter().enumerate().take(510).skip(500) {
        assert!((v - wave(0.5, session.time(i))).abs() < 0.01);
    }
}

/// A moving bike with noisy channels, one of which is changed.
fn riding(change: impl Fn(&mut Vec<f64>)) -> (Vec<f64>, Vec<Warning>) {
    let n = 6000;
    let time = Arc::new((0..n).map(|i| i as f64 / 100.0).collect::<Vec<f64>>());
    let speed = noise(n).map(|x| 15.0 + 0.05 * x).collect();
    let mut rate: Vec<f64> =
        noise(n).enumerate().map(|(i, x)| 2.0 * wave(0.5, i as f64 / 100.0) + 0.02 * x).collect();
    change(&mut rate);
    let track = |channel, values| Track { channel, time: Arc::clone(&time), values };
    let tracks = vec![track(Channel::VelocityX, speed), track(Channel::RollRate, rate)];
    let (session, warnings) = run(Raw { tracks, ..Raw::default() });
    let rate = session.get(Channel::RollRate).map(<[f64]>::to_vec).unwrap_or_default();
    (rate, warnings)
}

#[test]
fn a_clean_ride_gives_no_warning() {
    let (_, warnings) = riding(|_| {});
    assert_eq!(warnings, []);
}

#[test]
fn spikes_are_bridged() {
    let (rate, warnings) = riding(|x| {
        x[1000] += 4.0;
        x[3000] -= 3.0;
    });
    assert_eq!(codes(&warnings), ["spike"]);
    assert_eq!((warnings[0].count, warnings[0].time), (2, Some(10.0)));
    assert!((rate[1000] - 2.0 * wave(0.5, 10.0)).abs() < 0.1);
}

/// A rear brake that is dabbed for 0.12 s every 8 s, sampled at `rate`: found dabs, and warnings.
fn dabs(rate: f64, spike: bool) -> (usize, Vec<Warning>) {
    let n = (240.0 * rate) as usize;
    let time = Arc::new((0..n).map(|i| i as f64 / rate).collect::<Vec<f64>>());
    let dab = |t: f64| (4.0..4.12).contains(&(t % 8.0));
    let mut pressure: Vec<f64> = noise(n)
        .zip(time.iter())
        .map(|(x, t)| 1e3 * x + if dab(*t + 1e-6) { 4e5 } else { 0.0 })
        .collect();
    if spike {
        pressure[(1.0 * rate) as usize] += 8e5;
    }
    let speed = noise(n).map(|x| 15.0 + 0.05 * x).collect();
    let track = |channel, values| Track { channel, time: Arc::clone(&time), values };
    let tracks =
        vec![track(Channel::VelocityX, speed), track(Channel::BrakePressureRear, pressure)];
    let (session, warnings) = run(Raw { tracks, ..Raw::default() });
    let p = session.get(Channel::BrakePressureRear).expect("there");
    let found = (0..30).filter(|k| {
        let at = ((f64::from(*k) * 8.0 + 4.05) * rate).round() as usize;
        p[at - 1..at + 2].iter().any(|p| *p > 2e5)
    });
    (found.count(), warnings)
}

#[test]
fn dabs_of_a_brake_are_no_spikes_at_any_rate() {
    for rate in [10.0, 20.0, 50.0, 100.0] {
        assert_eq!(dabs(rate, false), (30, vec![]), "{rate} Hz");
    }
    // a sample of 20 ms is no foot's doing
    let (found, warnings) = dabs(100.0, true);
    assert_eq!((found, codes(&warnings)), (30, vec!["spike"]));
}

#[test]
fn a_saturated_gyro_is_told_and_its_plateaus_are_missing() {
    let (rate, warnings) = riding(|x| x.iter_mut().for_each(|v| *v = v.clamp(-1.5, 1.5)));
    assert_eq!(codes(&warnings), ["clipped", "gap"]);
    assert!(warnings[0].message.contains("-1.5000 and 1.5000"));
    assert!(rate.iter().filter(|v| v.is_nan()).count() > 2000);
}

#[test]
fn a_stuck_sensor_is_missing_while_it_is_stuck() {
    let (rate, warnings) = riding(|x| {
        let value = x[2000];
        x[2000..2450].fill(value);
    });
    assert_eq!(codes(&warnings), ["stuck", "gap"]);
    assert!(rate[2001..2450].iter().all(|v| v.is_nan()) && !rate[2000].is_nan());
}

#[test]
fn a_smooth_simulation_may_rest() {
    let (_, warnings) = riding(|x| {
        for (i, v) in x.iter_mut().enumerate() {
            *v = if i < 3000 { 0.0 } else { 1.0 - wave(0.5, 0.5 + i as f64 / 100.0) };
        }
    });
    assert_eq!(warnings, []);
}

#[test]
fn a_coarse_sensor_may_rest_too() {
    let (_, warnings) = riding(|x| {
        for (i, v) in x.iter_mut().enumerate() {
            let still = (2000..3000).contains(&i);
            *v = if still {
                0.0
            } else {
                ((wave(0.5, i as f64 / 100.0) + *v * 0.02) * 50.0).round() / 50.0
            };
        }
    });
    assert_eq!(warnings, []);
}

#[test]
fn rare_values_out_of_range_are_missing_many_are_left_for_the_check() {
    let (rate, warnings) = riding(|x| x[700..710].fill(1e6));
    assert_eq!(codes(&warnings), ["out_of_range"]);
    assert!(rate[705].abs() < 3.0);
    let (rate, warnings) = riding(|x| x.iter_mut().for_each(|v| *v = v.to_degrees()));
    assert_eq!(codes(&warnings), ["out_of_range"]);
    assert!(rate.iter().any(|v| v.abs() > 100.0));
}

#[test]
fn an_empty_channel_goes() {
    let (rate, warnings) = riding(|x| x.fill(NAN));
    assert_eq!(codes(&warnings), ["empty_channel"]);
    assert_eq!((rate.len(), warnings[0].channel), (0, Some(Channel::RollRate)));
}

/// The code and message with which a file of these bytes is refused.
fn refused(name: &str, bytes: &[u8]) -> (&'static str, String) {
    let folder = folder();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    let error = ingest::read(&path, &[])
        .and_then(|raw| ingest::run(raw, &Config::default()))
        .expect_err("refused");
    (error.code.as_str(), error.message)
}

fn bytes_of(session: &Session) -> Vec<u8> {
    let folder = folder();
    std::fs::read(written(folder.path(), session)).expect("there")
}

#[test]
fn dirt_is_refused_with_its_reason() {
    let good = bytes_of(&session(5));
    assert_eq!(refused("a.parquet", b"").0, "empty_file");
    assert_eq!(refused("a.parquet", b"PAR1").0, "not_parquet");
    assert_eq!(refused("a.parquet", &[b"XXXX", &good[4..]].concat()).0, "not_parquet");
    assert_eq!(refused("a.parquet", &good[..good.len() / 2]).0, "truncated");
    assert_eq!(refused("a.bin", &[0, 1, 2, 3, 0, 0, 0, 0]).0, "unknown_format");
    assert_eq!(refused("a.csv", b"a,b\n1,2\n").0, "no_channel_map");
    let mut claim = good.clone();
    let end = claim.len();
    claim[end - 8..end - 4].copy_from_slice(&0x7fff_fff0_u32.to_le_bytes());
    let (code, message) = refused("a.parquet", &claim);
    assert_eq!(code, "truncated");
    assert!(message.contains("2147483632 bytes of footer"), "{message}");
    assert_eq!(refused("a.csv", b"time,velocity_x\n").0, "too_short");
    assert_eq!(refused("a.csv", b"time,velocity_x\n0,1\n").0, "too_short");
    assert_eq!(refused("a.csv", b"time,velocity_x\n0,1\n0.1,1\n").0, "too_short");
    assert_eq!(refused("a.csv", b"time,velocity_x\n,1\n,1\n,2\n").0, "no_time");
    assert_eq!(refused("a.csv", b"time,velocity_x\n0,fast\n1,fast\n").0, "bad_cell");
    assert_eq!(
        ingest::read(Path::new("nowhere.csv"), &[]).expect_err("none").code.as_str(),
        "unreadable"
    );
}

#[test]
fn ids_that_lead_out_of_the_archive_are_refused() {
    let mut bad = session(5);
    bad.meta.session_id = "../../evil".into();
    assert_eq!(refused("a.parquet", &bytes_of(&bad)).0, "bad_session_id");
    let mut bad = session(5);
    bad.meta.bike_id = "../b".into();
    assert_eq!(refused("a.parquet", &bytes_of(&bad)).0, "bad_bike_id");
}

mod columns {
    //! Parquet from elsewhere.

    use super::*;
    use arrow::array::{ArrayRef, Float32Array, Float64Array, Int32Array, StringArray};
    use arrow::datatypes::{DataType, Field, Schema};

    fn write(columns: Vec<(&str, Option<&str>, ArrayRef)>) -> (tempfile::TempDir, PathBuf) {
        let (fields, arrays): (Vec<Field>, Vec<ArrayRef>) = columns
            .into_iter()
            .map(|(name, unit, array)| {
                let kind: DataType = array.data_type().clone();
                let unit = unit.map(|u| ("unit".to_owned(), u.to_owned()));
                (Field::new(name, kind, true).with_metadata(unit.into_iter().collect()), array)
            })
            .unzip();
        let batch = arrow::array::RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
            .expect("fits");
        let folder = folder();
        let path = folder.path().join("bike=b7").join("date=2025-01-02").join("s 9.parquet");
        roadbench::internals::store::tables::file::write_batch(&path, &batch).expect("written");
        (folder, path)
    }

    fn time() -> ArrayRef {
        Arc::new(Float64Array::from_iter_values((0..300).map(|i| f64::from(i) / 100.0)))
    }

    #[test]
    fn units_in_the_metadata_are_converted_and_names_come_from_the_path() {
        let speed = Arc::new(Float32Array::from_iter(
            (0..300).map(|i| if i == 7 { None } else { Some(36.0) }),
        ));
        let gear = Arc::new(Int32Array::from_iter_values((0..300).map(|_| 2)));
        let (_folder, path) = write(vec![
            ("time", Some("s"), time()),
            ("velocity_x", Some("km/h"), speed),
            ("gear", None, gear),
            ("lap", None, Arc::new(StringArray::from_iter_values((0..300).map(|_| "1")))),
        ]);
        let raw = ingest::read(&path, &[]).expect("readable");
        assert_eq!(codes(&raw.warnings), ["unknown_column"]);
        assert_eq!((raw.meta.bike_id.as_str(), raw.meta.session_id.as_str()), ("b7", "s 9"));
        assert_eq!(raw.meta.start_time.as_deref(), Some("2025-01-02T00:00:00Z"));
        assert!(raw.tracks[0].values[7].is_nan());
        let (session, _) = run(raw);
        assert!(session.get(Channel::VelocityX).expect("there").iter().all(|v| *v == 10.0));
        assert!(session.get(Channel::Gear).expect("there").iter().all(|v| *v == 2.0));
    }

    #[test]
    fn a_wrong_unit_or_type_or_no_time_names_the_column() {
        let one = |unit| vec![("time", Some("s"), time()), ("velocity_x", Some(unit), time())];
        let (_folder, path) = write(one("furlong"));
        let error = ingest::read(&path, &[]).expect_err("unknown");
        assert_eq!(error.code.as_str(), "unknown_unit");
        assert!(error.message.contains("`velocity_x`") && error.message.contains("furlong"));
        let (_folder, path) = write(vec![("times", None, time()), ("velocity_x", None, time())]);
        let error = ingest::read(&path, &[]).expect_err("no time");
        assert_eq!(error.code.as_str(), "missing_column");
        assert!(error.message.contains("is it `times`?"), "{error}");
        let text = Arc::new(StringArray::from_iter_values((0..300).map(|_| "fast")));
        let (_folder, path) = write(vec![("time", None, time()), ("velocity_x", None, text)]);
        assert_eq!(ingest::read(&path, &[]).expect_err("text").code.as_str(), "wrong_type");
    }

    #[test]
    fn other_names_go_through_a_map() {
        let map = ChannelMap::parse(
            "name = 'm'\nformat = 'parquet'\n[detect]\ncolumns = ['v']\n[meta]\nbike_id = 'x'\n\
             [time]\ncolumn = 'time'\n[channel.velocity_x]\nfrom = 'v'\nunit = 'mph'\n",
            "m",
        )
        .expect("a map");
        let speed = Arc::new(Float64Array::from_iter_values((0..300).map(|_| 60.0)));
        let (_folder, path) = write(vec![("v", None, speed), ("time", None, time())]);
        let raw = ingest::read(&path, &[map]).expect("readable");
        assert!((raw.tracks[0].values[0] - 26.8224).abs() < 1e-12);
        assert_eq!(raw.tracks[0].time[1], 0.01);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(
        bytes in proptest::collection::vec(any::<u8>(), 0..600),
        start in proptest::sample::select(vec![
            "", "PAR1", "time,velocity_x\n", "susp 1,2,3\nsusp 1,2,3\nsusp 1,2,3\n15,",
        ]),
        end in proptest::sample::select(vec!["", "\x40\0\0\0PAR1"]),
        name in proptest::sample::select(vec!["a.parquet", "a.csv", "a.log"]),
    ) {
        attempt(name, &[start.as_bytes(), &bytes, end.as_bytes()].concat());
    }

    #[test]
    fn arbitrary_numbers_never_panic(
        rows in proptest::collection::vec((any::<f64>(), -1e3..1e3_f64), 0..80),
        plain in any::<bool>(),
    ) {
        let mut text = "time,velocity_x\n".to_owned();
        for (i, (t, v)) in rows.iter().enumerate() {
            let t = if plain { i as f64 * 0.1 + v * 1e-4 } else { *t };
            text += &format!("{t},{v}\n");
        }
        attempt("a.csv", text.as_bytes());
    }

    #[test]
    fn damaged_files_never_panic(
        places in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..6),
        footer in any::<bool>(),
    ) {
        static GOOD: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
        let mut bytes = GOOD.get_or_init(|| bytes_of(&session(2))).clone();
        let from = if footer { bytes.len() * 3 / 4 } else { 4 };
        for (at, byte) in places {
            let at = from + at.index(bytes.len() - from);
            bytes[at] = byte;
        }
        attempt("a.parquet", &bytes);
    }
}

fn attempt(name: &str, bytes: &[u8]) {
    let folder = folder();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    if let Ok(raw) = ingest::read(&path, &[]) {
        let _ = ingest::run(raw, &Config::default());
    }
}

#[test]
fn convert_on_the_command_line() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mut text = "time;v\n".to_owned();
    for i in (0..300).filter(|i| !(100..200).contains(i)) {
        text += &format!("{};{}\n", f64::from(i) / 100.0, 36 + i % 2);
    }
    std::fs::write(at("ride.csv"), text).expect("written");
    let map = "name = 'm'\nformat = 'csv'\n[csv]\ndelimiter = ';'\n[time]\ncolumn = 'time'\n\
               [channel.velocity_x]\nfrom = 'v'\nunit = 'km/h'\n";
    std::fs::write(at("m.toml"), map).expect("written");
    std::fs::write(at("bad.toml"), map.replace("km/h", "furlong")).expect("written");
    let convert = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("roadbench").expect("built");
        command.current_dir(folder.path()).args(["convert", "ride.csv"]).args(arguments);
        command.output().expect("runs")
    };
    let output = convert(&["--map", "m.toml", "--dry-run"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("velocity_x") && text.contains("km/h"));
    assert_eq!(convert(&["--out", "o.parquet"]).status.code(), Some(1), "no map fits");
    let output = convert(&["--map", "bad.toml", "--out", "o.parquet"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("`furlong`"));
    assert!(!at("o.parquet").exists());
    let output = convert(&["--map", "m.toml", "--out", "ride.csv/o.parquet"]);
    assert_eq!(output.status.code(), Some(3));
    let output = convert(&["--map", "m.toml", "--out", "o.parquet"]);
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("gap: velocity_x: 1 gap(s)"));
    let (session, warnings) = read_back(&at("o.parquet"));
    assert_eq!(codes(&warnings), ["gap"]);
    let speed = session.get(Channel::VelocityX).expect("there");
    assert_eq!((session.len, speed.iter().filter(|v| v.is_nan()).count()), (300, 100));
    assert!((speed[0] - 10.0).abs() < 1e-12);
}

/// A real recording beside the repository, if it is there.
fn recording(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("note: {name} is not there, test skipped");
    None
}

/// Median of a ratio while the bike rides.
fn ratio(session: &Session, wheel: Channel) -> f64 {
    let speeds = session.get(Channel::VelocityX).expect("there");
    let spins = session.get(wheel).expect("there");
    let mut ratios: Vec<f64> = speeds
        .iter()
        .zip(spins)
        .filter(|(v, w)| **v > 5.0 && **w > 5.0)
        .map(|(v, w)| v / w)
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios[ratios.len() / 2]
}

#[test]
fn the_race_car_reads_as_its_source_describes_it() {
    let Some(path) = recording("indy_av21_car/Putnam_park2023_run4_2.csv") else { return };
    let (session, _) = read_back(&path);
    assert_eq!((session.rate, session.len), (25.0, 11900));
    assert_eq!(session.meta.start_time.as_deref(), Some("2023-08-15T16:33:07.464Z"));
    let top = session.get(Channel::VelocityX).expect("there").iter().copied().fold(0.0, f64::max);
    assert!((top - 32.39).abs() < 0.01, "SOURCE says 32.4 m/s: {top}");
    // SOURCE: wheel over vx 1.010 to 1.015 with the ECU's radius, here 0.30 m
    let front = ratio(&session, Channel::WheelSpeedFront);
    assert!((0.3 / 1.0165..0.3 / 1.010).contains(&front), "{front}");
}

#[test]
fn kiro_has_the_radius_that_its_source_found() {
    for name in ["KIRO_4.txt", "Primeira_Saida.txt"] {
        let Some(path) = recording(&format!("emoto_kiro/{name}")) else { return };
        let (session, _) = read_back(&path);
        assert_eq!(session.rate, 5.0);
        // 0.0537 m per motor radian, MAD 4.3 %, times the assumed ratio of 5.4
        let radius = ratio(&session, Channel::WheelSpeedRear);
        assert!((radius - 0.29).abs() < 0.005, "{name}: {radius}");
    }
}

#[test]
fn the_bicycle_has_no_time_column_and_steers_to_the_side_it_leans_to() {
    let Some(path) = recording("tudelft_sbw_bicycle/eigen_normal_sil6.5n2_5.4kph.log") else {
        return;
    };
    let (session, warnings) = read_back(&path);
    assert_eq!((session.rate, session.len), (100.0, 13814));
    assert_eq!(codes(&warnings), ["unknown_column"]);
    let (roll, steer) = (session.get(Channel::Roll), session.get(Channel::SteerAngle));
    let pairs = roll.expect("roll").iter().zip(steer.expect("steer"));
    // ISO 8855: leaning right is positive, steering right negative
    assert!(pairs.map(|(r, s)| r * s).sum::<f64>() < 0.0);
}
