//! `.SST` logs of the Sufni suspension telemetry unit, version 3: fork and shock, as its sensors count.
//!
//! ```text
//! "SST" | version u8 | rate u16, Hz | padding u16 | start i64, s since 1970 | fork u16, shock u16 | ...
//! ```
//!
//! Little-endian. The counts are angles of two sensors, from which only the geometry of their arms makes millimetres;
//! no map comes with the program.

use std::io::Read as _;
use std::sync::Arc;

use crate::contract::rejection::RejectionCode;
use crate::contract::session::Meta;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::start_time;
use crate::ingest::formats::format::{Format, Head};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::raw::Column;
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

#[derive(Debug)]
pub(super) struct Sst;

const HEADER: usize = 16;
const VERSION: u8 = 3;
/// In the order in which they stand in a sample.
const NAMES: [&str; 2] = ["fork", "shock"];
/// Bytes of a sample.
const SAMPLE: usize = 4;

impl Format for Sst {
    const NAME: &'static str = "sst";
    const DESCRIPTION: &'static str = "Suspension telemetry of the Sufni unit, in counts";
    const CHANNEL_NAMES: &'static str = "`fork`, `shock`";
    const EXTENSIONS: &'static [&'static str] = &["sst"];

    fn sniff(head: &Head<'_>) -> bool {
        head.bytes.starts_with(b"SST") && head.has_extension("sst")
            || head.bytes.starts_with(&[b'S', b'S', b'T', VERSION])
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let file = File::read(log)?;
        let channel = |(place, name): (usize, &&str)| SourceChannel {
            name: (*name).to_owned(),
            unit: None,
            samples: Some((file.samples.len() / SAMPLE) as u64),
            rate: Some(file.rate),
            place: [place, 0, 0],
            ..SourceChannel::default()
        };
        let cut = file.samples.len() % SAMPLE > 0;
        let message = "the log is cut off within a sample; read up to there".to_owned();
        Ok(Listing {
            channels: NAMES.iter().enumerate().map(channel).collect(),
            meta: Meta { start_time: start_time(file.start), ..Meta::default() },
            facts: vec![("unit".to_owned(), "counts of the sensors; a map has to say millimetres with `scale`, `offset` and `unit`".to_owned())],
            warnings: cut.then(|| warning("truncated", None, 1, None, message)).into_iter().collect(),
            ..Listing::default()
        })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let file = File::read(log)?;
        let (samples, _) = file.samples.as_chunks::<SAMPLE>();
        let time = Arc::new((0..samples.len()).map(|i| i as f64 / file.rate).collect::<Vec<f64>>());
        let column = |channel: &&SourceChannel| {
            let at = 2 * channel.place[0];
            let count = |s: &[u8; SAMPLE]| f64::from(u16::from_le_bytes([s[at], s[at + 1]]));
            let values = samples.iter().map(count).collect();
            Column { name: channel.full(), time: Arc::clone(&time), values }
        };
        Ok(Decoded { columns: wanted.iter().map(column).collect(), ..Decoded::default() })
    }
}

struct File {
    rate: f64,
    start: f64,
    samples: Vec<u8>,
}

impl File {
    fn read(log: &Location) -> Result<Self, Error> {
        let fail = |e: std::io::Error| Error::unreadable(log, &e);
        let mut samples = Vec::new();
        source::open(log).map_err(fail)?.read_to_end(&mut samples).map_err(fail)?;
        let Some((header, rest)) = samples.split_at_checked(HEADER) else {
            let message = format!("{log} is cut off within its first {HEADER} bytes");
            return Err(Error::new(RejectionCode::NoSamples, message));
        };
        if header[3] != VERSION {
            let message = format!(
                "{log} is a suspension log of version {}, only {VERSION} is read; export CSV from the program that shows it",
                header[3]
            );
            return Err(Error::new(RejectionCode::UnknownVersion, message));
        }
        let rate = u16::from_le_bytes([header[4], header[5]]);
        if rate == 0 {
            let message = format!("the header of {log} is damaged: it gives a rate of 0 Hz");
            return Err(Error::new(RejectionCode::Damaged, message));
        }
        let start = header[8..].iter().rev().fold(0_u64, |sum, b| sum << 8 | u64::from(*b));
        Ok(File { rate: f64::from(rate), start: start as i64 as f64, samples: rest.to_vec() })
    }
}
