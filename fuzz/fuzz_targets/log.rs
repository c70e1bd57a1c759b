//! A log of any bytes through reading (which begins with identification) and ingest, as a batch
//! does it, and through the survey of all its channels, as `inspect` does it.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use roadbench::internals::ingest;
use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::formats::survey::survey;
use roadbench::internals::ingest::maps as map;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::pipeline::Pipeline;

/// What the samples of fixtures/formats are read with, besides the maps that are shipped.
const MAPS: [&str; 4] = [
    include_str!("../../fixtures/formats/ride_bus.toml"),
    include_str!("../../fixtures/formats/ride_can.toml"),
    include_str!("../../fixtures/formats/ride_json.toml"),
    include_str!("../../fixtures/formats/ride_ros2.toml"),
];
const DBC: &str = include_str!("../../fixtures/formats/ride.dbc");

/// The last panic, for people.
static PANIC: Mutex<String> = Mutex::new(String::new());

struct Given {
    maps: Vec<ChannelMap>,
    aids: Aids,
    config: ingest::Config,
}

fn given() -> &'static Given {
    static GIVEN: OnceLock<Given> = OnceLock::new();
    GIVEN.get_or_init(|| {
        // libfuzzer's own ends the process at a panic within a library too, which the readers
        // turn into an error
        std::panic::set_hook(Box::new(|panic| {
            *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = panic.to_string();
        }));
        let aids = Aids { dbc: vec![DBC.into()], names: vec!["ride.dbc".into()] };
        let mut maps = map::file::shipped().to_vec();
        for text in MAPS {
            let mut map = ChannelMap::parse(text, "fixtures/formats").expect("ours");
            if !map.dbc.is_empty() {
                map.aids = aids.clone();
            }
            maps.push(map);
        }
        Given { maps, aids, config: Pipeline::onroad().ingest }
    })
}

/// Reads bytes as a log whose name ends as given. Errors are right; panics and hangs are not.
pub fn read(bytes: &[u8], extension: &str) {
    let given = given();
    let mut file = tempfile::Builder::new()
        .suffix(extension)
        .tempfile()
        .expect("the machine's temporary folder");
    file.write_all(bytes).expect("the machine's temporary folder");
    if catch_unwind(AssertUnwindSafe(|| through(file.path(), given))).is_err() {
        eprintln!("{}", PANIC.lock().unwrap_or_else(PoisonError::into_inner));
        std::process::abort();
    }
}

fn through(path: &Path, given: &Given) {
    if let Ok(raw) = ingest::read(path, &given.maps) {
        let _ = ingest::run(raw, &given.config);
    }
    let _ = survey(path, &given.aids);
}
