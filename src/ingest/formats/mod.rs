//! The formats of logs that can be read: a file and a line in [`FORMATS`] each.

use crate::ingest::formats::format::{LogFormat, format};
use crate::store::objects::Location;

mod can;
mod csv;
mod ctrk;
pub(crate) mod detect;
mod fit;
pub(crate) mod format;
mod gpx;
mod kiro;
pub(crate) mod listing;
mod mcap;
mod mdf;
mod motec;
mod nmea;
pub(crate) mod parquet;
mod sensors;
mod sst;
mod streams;
pub(crate) mod survey;
pub(crate) mod table;
mod text_export;
mod ubx;
pub(crate) mod unread;
mod vbo;

/// Every format, the most particular first: a log is of the first that takes it.
pub const FORMATS: &[LogFormat] = &[
    parquet::FORMAT,
    format::<mdf::Mdf>(),
    format::<mcap::Mcap>(),
    format::<can::Can>(),
    format::<motec::Ld>(),
    format::<ctrk::Ctrk>(),
    format::<sst::Sst>(),
    format::<fit::Fit>(),
    format::<gpx::Gpx>(),
    format::<ubx::Ubx>(),
    format::<sensors::Sensors>(),
    format::<text_export::Motec>(),
    format::<text_export::Aim>(),
    format::<text_export::RaceChrono>(),
    format::<text_export::racebox::RaceBox>(),
    format::<text_export::xsens::Xsens>(),
    format::<vbo::Vbo>(),
    kiro::FORMAT,
    format::<nmea::Nmea>(),
    csv::FORMAT,
];

/// The extensions of logs, each once, in the order of [`FORMATS`].
pub(crate) fn extensions() -> Vec<&'static str> {
    let mut all: Vec<&str> = Vec::new();
    for extension in FORMATS.iter().flat_map(|format| format.extensions) {
        if !all.contains(extension) {
            all.push(extension);
        }
    }
    all
}

/// Whether a file is taken for a log by its name when a folder is searched.
pub(crate) fn has_log_extension(file: &Location) -> bool {
    FORMATS.iter().flat_map(|format| format.extensions).any(|e| file.has_extension(e))
}
