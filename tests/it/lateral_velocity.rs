//! A lateral velocity that is turned round or in km/h is left out: what would come of it is determined and wrong.

use std::path::Path;

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest;
use roadbench::internals::pipeline::{self, Input, Pipeline};

/// Codes of the warnings on the lateral velocity of a ride of the bundled archive, with it times a factor.
fn said(bike: &str, session: &str, factor: f64) -> Vec<String> {
    let archive = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let mut raw =
        ingest::read(archive.join("sessions").join(session).as_path(), &[]).expect("read");
    for track in raw.tracks.iter_mut().filter(|t| t.channel == Channel::VelocityY) {
        track.values.iter_mut().for_each(|v| *v *= factor);
    }
    let bike = Bike::read(&archive.join(format!("bikes/{bike}.toml"))).expect("bike");
    let input = Input {
        log: Path::new("ride").into(),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    let outcome =
        pipeline::run_raw(raw, &input, &bike, &Pipeline::onroad()).expect("characterised");
    let own = outcome.warnings.iter().filter(|w| w.code.ends_with("velocity_y"));
    own.map(|w| w.code.to_owned()).collect()
}

#[test]
fn turned_or_in_another_unit_it_is_left_out() {
    for (bike, session) in [
        ("archive_01", "bike=archive_01/date=2026-05-01/archive_s0002.parquet"),
        ("archive_02", "bike=archive_02/date=2026-05-06/archive_s0011.parquet"),
    ] {
        assert!(said(bike, session, 1.0).is_empty(), "{session}: right");
        assert_eq!(said(bike, session, -1.0), ["sign_velocity_y"], "{session}");
        assert_eq!(said(bike, session, 3.6), ["scale_velocity_y"], "{session}");
    }
}
