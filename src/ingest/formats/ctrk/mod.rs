//! Yamaha Y-Trac `.CTRK` logs: [`records`] has the bytes, [`channels`] what they mean.
//!
//! Read by the published specification and its examples; no file of a real logger could be had to
//! try it on.

use crate::contract::rejection::RejectionCode;
use crate::contract::session::{Markers, Meta};
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::format::Format;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::raw::Column;
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

mod channels;
mod records;

use records::Contents;

/// Yamaha Y-Trac `.CTRK`.
#[derive(Debug)]
pub(super) struct Ctrk;

/// Before this a logger's clock was never set, ms since 1970: it begins at 2000-01-01.
const CLOCK_SET: i64 = 1_262_304_000_000;

impl Format for Ctrk {
    const NAME: &'static str = "ytrac_ctrk";
    const DESCRIPTION: &'static str =
        "Yamaha Y-Trac, written from the published specification and never tried on a real file";
    const EXTENSIONS: &'static [&'static str] = &["ctrk"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("ytrac_ctrk")];

    fn sniff(head: &Head<'_>) -> bool {
        records::is(head.bytes)
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
        let contents = records::split(&bytes);
        let columns = columns(log, &contents)?;
        let channel = |(column, unit): &(Column, &'static str)| SourceChannel {
            name: column.name.clone(),
            unit: Some((*unit).to_owned()),
            samples: Some(column.values.len() as u64),
            ..SourceChannel::default()
        };
        let first = contents.records.first().map(|r| r.stamp).filter(|s| *s > CLOCK_SET);
        let start = first.or_else(|| channels::start_by_gps(&contents));
        let start = start.and_then(|ms| jiff::Timestamp::from_millisecond(ms).ok());
        let said = |key: &str| contents.footer.get(key).filter(|v| !v.is_empty()).cloned();
        let meta = Meta {
            start_time: start.map(|t| t.to_string()),
            site: said("CircuitName"),
            rider_id: said("User"),
            ..Meta::default()
        };
        Ok(Listing {
            channels: columns.iter().map(channel).collect(),
            meta,
            facts: contents.footer.clone().into_iter().filter(|(_, v)| !v.is_empty()).collect(),
            warnings: broken(&contents),
            ..Listing::default()
        })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
        let contents = records::split(&bytes);
        let columns = columns(log, &contents)?;
        let find = |c: &&SourceChannel| columns.iter().find(|(col, _)| col.name == c.name);
        let columns = wanted.iter().filter_map(find).map(|(c, _)| c.clone()).collect();
        let markers = Markers { times: channels::laps(&contents), line: None };
        Ok(Decoded { columns, markers, ..Decoded::default() })
    }
}

fn columns(log: &Location, contents: &Contents<'_>) -> Result<Vec<(Column, &'static str)>, Error> {
    let columns = channels::columns(contents);
    if columns.is_empty() {
        let why = contents.broken.as_deref().map(|b| format!(": {b}")).unwrap_or_default();
        let message = format!("{log} has no records of known channels{why}");
        return Err(Error::new(RejectionCode::NoChannels, message));
    }
    Ok(columns)
}

fn broken(contents: &Contents<'_>) -> Vec<Warning> {
    let told = |why: &String| {
        let message = format!("{why}; the log is read up to there");
        warning("cut_off", None, 1, None, message)
    };
    contents.broken.iter().map(told).collect()
}
