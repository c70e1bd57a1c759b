//! MoTeC `.ld` logs; [`ld`] has the bytes, [`ldx`] the laps, which MoTeC keeps in a file of their own beside the log.

use std::collections::HashMap;
use std::io::BufReader;
use std::sync::Arc;

use crate::contract::rejection::RejectionCode;
use crate::contract::session::{Markers, Meta};
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::format::Format;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel, number_twins};
use crate::ingest::formats::text_export::facts;
use crate::ingest::ident;
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::raw::Column;
use crate::ingest::warning::warning;
use crate::store::objects::Location;
use crate::store::objects::source;
use crate::store::objects::source::Source;

mod ld;
mod ldx;

/// MoTeC `.ld`.
#[derive(Debug)]
pub(super) struct Ld;

impl Format for Ld {
    const NAME: &'static str = "motec_ld";
    const DESCRIPTION: &'static str = "MoTeC `.ld` logs";
    const EXTENSIONS: &'static [&'static str] = &["ld"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("motec_ld")];

    fn sniff(head: &Head<'_>) -> bool {
        ld::is(head.bytes)
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let (mut file, size, contents) = open(log)?;
        let channel = |(place, c): (usize, &ld::Channel)| SourceChannel {
            name: c.name.clone(),
            unit: Some(c.unit.clone()).filter(|u| !u.is_empty()),
            samples: Some(c.there(size)),
            rate: Some(f64::from(c.rate)),
            place: [place, 0, 0],
            ..SourceChannel::default()
        };
        let text = |text: &str| Some(text.to_owned()).filter(|t| !t.is_empty());
        let start = facts::moment(&format!("{} {}", contents.date, contents.time));
        let mut warnings = Vec::new();
        warnings.extend(start.as_deref().map(facts::wall_clock));
        for fault in &contents.faults {
            warnings.push(warning("damaged", None, 1, None, fault.clone()));
        }
        let cut = contents.channels.iter().filter(|c| c.there(size) < u64::from(c.samples)).count();
        if cut > 0 {
            let message =
                format!("{cut} channels have fewer samples than they say: the file is cut off");
            warnings.push(warning("cut_off", None, cut, None, message));
        }
        let mut meta = Meta {
            bike_id: facts::name(&contents.vehicle),
            rider_id: text(&contents.driver),
            site: text(&contents.venue),
            start_time: start,
            ..Meta::default()
        };
        if !ident::from_path(log).bike_id.is_empty() {
            meta.bike_id.clear(); // the folder that the user chose is a better source than the header
        }
        let about = ld::about(&mut file, size).map_err(|e| Error::unreadable(log, &e))?;
        let mut channels: Vec<SourceChannel> =
            contents.channels.iter().enumerate().map(channel).collect();
        number_twins(&mut channels);
        Ok(Listing {
            channels,
            meta,
            facts: about.into_iter().filter(|(_, v)| !v.is_empty()).collect(),
            warnings,
            ..Listing::default()
        })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let (mut file, size, contents) = open(log)?;
        let mut clocks: HashMap<(u16, usize), Arc<Vec<f64>>> = HashMap::new();
        let mut columns = Vec::with_capacity(wanted.len());
        for source in wanted {
            let Some(channel) = contents.channels.get(source.place[0]) else { continue };
            let values =
                ld::samples(&mut file, size, channel).map_err(|e| Error::unreadable(log, &e))?;
            let n = values.len();
            let time = clocks.entry((channel.rate, n)).or_insert_with(|| {
                Arc::new((0..n).map(|i| i as f64 / f64::from(channel.rate)).collect())
            });
            columns.push(Column { name: source.full(), time: Arc::clone(time), values });
        }
        let (times, warnings) = ldx::beacons(log);
        Ok(Decoded { columns, warnings, markers: Markers { times, line: None } })
    }
}

fn open(log: &Location) -> Result<(BufReader<Source>, u64, ld::Log), Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let source = source::open(log).map_err(fail)?;
    let size = source.size().map_err(fail)?;
    let mut file = BufReader::new(source);
    let contents = ld::list(&mut file, size).map_err(fail)?.ok_or_else(|| {
        Error::new(RejectionCode::CutOff, format!("{log} ends within its header"))
    })?;
    if contents.channels.is_empty() {
        let why = contents.faults.first().map(|f| format!(": {f}")).unwrap_or_default();
        return Err(Error::new(RejectionCode::NoChannels, format!("{log} has no channels{why}")));
    }
    Ok((file, size, contents))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_of_one_name_are_read_by_their_number() {
        let number = [0, 1, 1, 0];
        let bytes = ld::tests::file(&[
            ("v", 3, 2, number, vec![1, 0]),
            ("rpm", 3, 2, number, vec![9, 0]),
            ("v", 3, 2, number, vec![2, 0]),
        ]);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("twins.ld");
        std::fs::write(&path, bytes).expect("written");
        let log = Location::from(path);
        let listing = Ld::list(&log, &Aids::default()).expect("a log");
        let error = listing.find("v").expect_err("which of them?");
        assert_eq!(error.code.as_str(), "ambiguous_column");
        assert!(error.message.contains("v #1, v #2"), "{error}");
        let wanted = ["v #2", "rpm", "v #1"].map(|name| listing.find(name).expect(name));
        let columns = Ld::decode(&log, &Aids::default(), &wanted).expect("a log").columns;
        let found: Vec<(&str, &[f64])> =
            columns.iter().map(|c| (c.name.as_str(), c.values.as_slice())).collect();
        assert_eq!(found, [("v #2", &[2.0][..]), ("rpm", &[9.0]), ("v #1", &[1.0])]);
    }
}
