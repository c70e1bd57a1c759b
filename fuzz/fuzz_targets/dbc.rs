#![no_main]
//! CAN databases, by which a sample's frames are read.

use std::io::Write;
use std::sync::OnceLock;

use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::formats::survey::survey;
use tempfile::NamedTempFile;

const FRAMES: &[u8] = include_bytes!("../seeds/can/ride.log");

fn log() -> &'static NamedTempFile {
    static LOG: OnceLock<NamedTempFile> = OnceLock::new();
    LOG.get_or_init(|| {
        let mut file = NamedTempFile::new().expect("the machine's temporary folder");
        file.write_all(FRAMES).expect("the machine's temporary folder");
        file
    })
}

libfuzzer_sys::fuzz_target!(|text: &str| {
    let aids = Aids { dbc: vec![text.to_owned()], names: vec!["b.dbc".into()] };
    let _ = survey(log().path(), &aids);
});
