//! Foreign logs, read back by the readers that everybody's logs go through.

use std::path::PathBuf;

use nalgebra::Vector3;

use roadbench::internals::contract::channel::Channel as C;
use roadbench::internals::ingest;
use roadbench::internals::ingest::Raw;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::simulate::loggers::{Foreign, Profile, write};
use roadbench::internals::simulate::multibody::joint;
use roadbench::internals::simulate::ride::Sample;
use roadbench::internals::simulate::track::{self, Track, TrackRide};

/// One lap without anything drawn, and its logs: one ride for all of them, which takes longer than everything else.
#[test]
fn what_loggers_write_of_a_lap_is_read_back() {
    let track = Track::load("track").expect("built in").expect("a track");
    let ridden = track::ride(&Track { laps: 1, ..track }, 0).expect("comes round");
    a_superbike_log_is_read_back_within_its_steps_and_noise(&ridden);
    a_factory_log_is_read_back_and_its_inertial_unit_leans_with_the_frame(&ridden);
    every_logger_writes_its_rate_the_same_for_the_same_seed(&ridden);
    a_phone_feels_the_lean_in_its_own_axes(&ridden);
}

fn read(foreign: &Foreign, map: &str) -> Raw {
    let folder = tempfile::tempdir().expect("a folder");
    let path: PathBuf = folder.path().join(&foreign.file);
    std::fs::write(&path, &foreign.text).expect("written");
    let map = ChannelMap::parse(map, "m.toml").unwrap_or_else(|e| panic!("{e}"));
    ingest::read(path, &[map]).unwrap_or_else(|e| panic!("{e}"))
}

/// Root mean square of a read track less the truth by sample (SI), `delay` (s) earlier.
fn misses(
    ridden: &TrackRide,
    raw: &Raw,
    channel: C,
    truth: impl Fn(&Sample) -> f64,
    delay: f64,
) -> f64 {
    let track = raw.tracks.iter().find(|t| t.channel == channel).expect("read");
    let (samples, rate) = (&ridden.ride.samples, ridden.ride.session.rate);
    let start = track.time[0];
    let squares: f64 = track
        .time
        .iter()
        .zip(&track.values)
        .filter(|(t, _)| **t - start > 1.0)
        .map(|(t, x)| {
            let i = ((t - start - delay) * rate).round() as usize;
            (x - truth(&samples[i.min(samples.len() - 1)])).powi(2)
        })
        .sum();
    (squares / track.values.len() as f64).sqrt()
}

const SUPERBIKE: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 'Time (ms)'\nunit = 'ms'\n\
    [channel.wheel_speed_front]\nfrom = 'Wheel Speed F (km/h)'\nunit = 'km/h'\nradius = 0.3\n\
    [channel.velocity_x]\nfrom = 'GPS Speed (km/h)'\nunit = 'km/h'\n\
    [channel.roll]\nfrom = 'Lean (deg)'\nunit = 'deg'\n\
    [channel.brake_pressure_front]\nfrom = 'Brake F (bar)'\nunit = 'bar'\n\
    [channel.throttle]\nfrom = 'TPS (%)'\nunit = '%'\n\
    [channel.gear]\nfrom = 'Gear'\nunit = '1'\n";

fn a_superbike_log_is_read_back_within_its_steps_and_noise(ridden: &TrackRide) {
    let foreign = write(Profile::Superbike, ridden, 5);
    let raw = read(&foreign, SUPERBIKE);
    // 0.1 bar in steps
    let pressure = misses(ridden, &raw, C::BrakePressureFront, |s| s.controls.pressure[0], 0.0);
    assert!(pressure < 0.04e5, "{pressure}");
    let throttle = misses(ridden, &raw, C::Throttle, |s| s.controls.throttle, 0.0);
    assert!(throttle < 0.0015, "{throttle}");
    assert!(misses(ridden, &raw, C::Gear, |s| s.controls.gear, 0.0) < 1e-9);
    // the wheel's spin by the nominal circumference instead of 0.3 m
    let truth: toml::Table = foreign.truth.parse().expect("TOML");
    let nominal = truth["circumference"][0].as_float().expect("a number");
    let ratio = nominal / std::f64::consts::TAU / 0.3;
    let wheel = |s: &Sample| ratio * s.rates[joint::FRONT];
    assert!(misses(ridden, &raw, C::WheelSpeedFront, wheel, 0.0) < 0.12);
    // zero and wander of the lean: 0.6 and 0.7 degrees
    let lean = misses(ridden, &raw, C::Roll, |s| s.wheels[1].camber, 0.04);
    assert!(lean < 2.5_f64.to_radians(), "{lean}");
    // the receiver is 0.2 s late and not 0
    let speed = |s: &Sample| s.motion.velocity.xy().norm();
    let (late, in_time) = (
        misses(ridden, &raw, C::VelocityX, speed, 0.2),
        misses(ridden, &raw, C::VelocityX, speed, 0.0),
    );
    assert!(late < 0.7 && in_time > 1.5 * late, "{late} {in_time}");
}

fn a_factory_log_is_read_back_and_its_inertial_unit_leans_with_the_frame(ridden: &TrackRide) {
    let foreign = write(Profile::Factory, ridden, 5);
    let map = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 't'\nunit = 's'\n\
        [channel.velocity_x]\nfrom = 'v_gps'\nunit = 'km/h'\n\
        [channel.brake_pressure_rear]\nfrom = 'p_brake_rr'\nunit = 'bar'\n\
        [channel.roll]\nfrom = 'lean_imu'\nunit = 'deg'\n\
        [channel.yaw_rate]\nfrom = 'yawrate_imu'\nunit = 'deg/s'\n";
    let raw = read(&foreign, map);
    let rear = misses(ridden, &raw, C::BrakePressureRear, |s| s.controls.pressure[1], 0.0);
    assert!(rear < 0.04e5, "{rear}");
    let lean = misses(ridden, &raw, C::Roll, |s| s.wheels[1].camber, 0.02);
    assert!(lean < 0.3_f64.to_radians(), "{lean}");
    let body = misses(ridden, &raw, C::YawRate, |s| s.motion.spin.z, 0.0);
    assert!(body < 0.3_f64.to_radians(), "{body}");
}

fn every_logger_writes_its_rate_the_same_for_the_same_seed(ridden: &TrackRide) {
    let length = ridden.ride.session.duration();
    let all = [Profile::Superbike, Profile::Factory, Profile::Phone, Profile::Satellite];
    for (profile, rate) in all.into_iter().zip([10.0, 100.0, 25.0, 10.0]) {
        let foreign = write(profile, ridden, 5);
        let lines = foreign.text.lines().count() as f64;
        assert!((lines - length * rate).abs() < 25.0, "{profile:?}: {lines} for {}", length * rate);
        assert_eq!(foreign.text, write(profile, ridden, 5).text);
        assert!(foreign.text != write(profile, ridden, 6).text);
        assert!(foreign.truth.parse::<toml::Table>().is_ok(), "{}", foreign.truth);
    }
}

/// Away from its mounting, a phone feels what the frame does: about one g on average, and its axes turn as one.
fn a_phone_feels_the_lean_in_its_own_axes(ridden: &TrackRide) {
    let foreign = write(Profile::Phone, ridden, 5);
    let truth: toml::Table = foreign.truth.parse().expect("TOML");
    let angle = |k: usize| truth["mounting"][k].as_float().expect("a number");
    let turned = nalgebra::Rotation3::from_euler_angles(angle(0), angle(1), angle(2));
    let (mut count, mut misses) = (0, 0.0);
    for (k, line) in foreign.text.lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |i: usize| cells[i].parse::<f64>().expect("a number");
        let body = turned * Vector3::new(cell(10), cell(11), cell(12)) / 1_f64.to_degrees();
        let spin = ridden.ride.samples[4 * k].motion.spin;
        misses += (body - spin).norm_squared();
        count += 1;
    }
    // biases of up to half a degree a second on each axis, noise of 0.3
    let rms = (misses / f64::from(count)).sqrt().to_degrees();
    assert!(rms < 1.2, "{rms}");
}

/// The bundled log: two laps. `ROADBENCH_BLESS=1` writes it anew.
#[test]
fn the_bundled_superbike_log_is_one_of_a_track() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers/superbike.csv");
    if std::env::var_os("ROADBENCH_BLESS").is_some() {
        let track = Track::load("track").expect("built in").expect("a track");
        let two = track::ride(&Track { laps: 2, ..track }, 0).expect("comes round");
        let foreign = write(Profile::Superbike, &two, 22);
        let folder = path.parent().expect("a folder");
        std::fs::create_dir_all(folder).expect("made");
        std::fs::write(&path, &foreign.text).expect("written");
        std::fs::write(folder.join("superbike_truth.toml"), &foreign.truth).expect("written");
        std::fs::write(folder.join("ride_truth.toml"), track::notes(&two)).expect("written");
        std::fs::write(folder.join("bike.toml"), two.entry.bike.to_toml()).expect("written");
    }
    let map = ChannelMap::parse(SUPERBIKE, "m.toml").unwrap_or_else(|e| panic!("{e}"));
    let raw = ingest::read(path, &[map]).unwrap_or_else(|e| panic!("{e}"));
    let of = |channel: C| &raw.tracks.iter().find(|t| t.channel == channel).expect("read").values;
    let most = |x: &[f64]| x.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(of(C::Gear).iter().all(|g| *g >= 1.0), "in gear");
    let lean = most(of(C::Roll)).to_degrees();
    assert!((45.0..60.0).contains(&lean), "{lean}");
    assert!(most(of(C::BrakePressureFront)) > 5e5 && most(of(C::VelocityX)) > 45.0);
}
