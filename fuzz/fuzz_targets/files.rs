#![no_main]
//! The files that people write by hand: bike files, pipelines, channel maps, tyre property files.

use std::path::Path;

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::tyre::tir;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = Bike::parse(text, "b", Path::new("b.toml"));
    let _ = ChannelMap::parse(text, "m.toml");
    let _ = Pipeline::parse(text, "p.toml");
    let _ = tir::parse(text, Path::new("t.tir"));
});
