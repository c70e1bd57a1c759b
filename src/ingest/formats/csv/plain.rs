//! A look at delimited text that no map is known for: its layout is guessed.

use std::borrow::Cow;

use super::table::{self, Table};
use super::{cells, clocks, layout, sentinels};
use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::clock::spread;
use crate::ingest::clock::stamps::text::Kind;
use crate::ingest::clock::stamps::unit;
use crate::ingest::clock::stamps::unit::{Evidence, digits_scale, of_digits, usual_step};
use crate::ingest::error::Error;
use crate::ingest::formats::format::Decoder;
use crate::ingest::formats::listing::{Decoded, ListedClock, Listing, SourceChannel};
use crate::ingest::maps::propose::{best_named, clock};
use crate::ingest::maps::units;
use crate::ingest::motion::track;
use crate::ingest::warning::warning;
use crate::store::objects::Location;

/// Any delimited text.
pub(super) const DECODER: Decoder = Decoder { list, decode };

/// Rows by which a clock is judged.
const JUDGED: usize = 100_000;
/// Stamps may fall back so often, as a share.
const FALLS: f64 = 0.05;

fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
    let (table, seen) = open(log)?;
    let mut layout = vec!["[csv]".to_owned()];
    if table.delimiter != b',' {
        let delimiter = match table.delimiter {
            b'\t' => "\\t".to_owned(),
            other => char::from(other).to_string(),
        };
        layout.push(format!("delimiter = \"{delimiter}\""));
    }
    if table.decimal != '.' {
        layout.push(format!("decimal = {:?}", table.decimal.to_string()));
    }
    if table.names_line > 0 {
        layout.push(format!("skip_rows = {}", table.names_line));
    }
    let below = table.first_line as usize - table.names_line - 2;
    if below > 0 {
        layout.push(format!("rows_after_header = {below}"));
    }
    if seen.units_row > 0 {
        layout.push(format!("units_row = {}", seen.units_row));
    }
    let mut warnings = Vec::new();
    let mut channels = seen.channels;
    let judged = judged_clock(log, &channels, &mut warnings)?;
    if let Some(judged) = &judged {
        for channel in &mut channels {
            // where `decode` finds it again: the clock's place and its seconds per unit
            channel.place[1] = judged.place + 1;
            channel.place[2] = usize::try_from(judged.factor.to_bits()).unwrap_or_default();
        }
    }
    // an empty layout says that nothing was looked at
    let said = layout.len() > 1 || judged.is_none();
    let layout = if said { layout.join("\n") } else { String::new() };
    Ok(Listing { channels, layout, warnings, clock: judged.map(|j| j.clock), ..Listing::default() })
}

fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
    let (mut table, seen) = open(log)?;
    let [_, clock, bits] = wanted.first().map_or([0; 3], |c| c.place);
    let clock = clock.checked_sub(1);
    let names: Vec<String> = wanted.iter().map(|c| c.full()).collect();
    // stamps are read once, as what they are
    let others = names.iter().zip(wanted).filter(|(_, c)| Some(c.place[0]) != clock);
    let mut places: Vec<cells::Wanted<'_>> =
        others.map(|(name, c)| (name.as_str(), c.place[0])).collect();
    places.extend(clock.map(|clock| ("time", clock)));
    let at = clock.map(|_| places.len() - 1);
    // words among the numbers are no reason to show nothing
    let writing = writing(&table, &seen, at);
    let mut read = cells::read_all(log, &mut table.rows, &places, writing, usize::MAX)?;
    let rows = read.columns.first().map_or(0, Vec::len);
    let stamps = clock.and_then(|_| read.columns.pop());
    let labels: Vec<&str> = places.iter().map(|p| p.0).collect();
    sentinels::take_out(&labels, &mut read.columns, &mut read.warnings);
    let time = match &stamps {
        Some(stamps) => seconds(stamps, read.kind, f64::from_bits(bits as u64)),
        // the row's number: rates are then those of rows
        None => (0..rows).map(|i| i as f64).collect(),
    };
    let mut rest = read.columns.into_iter();
    let column = |c: &&SourceChannel| match (&stamps, Some(c.place[0]) == clock) {
        (Some(stamps), true) => stamps.clone(),
        _ => rest.next().unwrap_or_default(),
    };
    let values: Vec<Vec<f64>> = wanted.iter().map(column).collect();
    let columns = names.into_iter().zip(values).collect();
    let columns = clocks::separate(time, columns, |_, _| false);
    Ok(Decoded { columns, warnings: read.warnings, ..Decoded::default() })
}

/// Stamps in seconds, those that are coarser than the rows spread over them.
fn seconds(stamps: &[f64], kind: Kind, factor: f64) -> Vec<f64> {
    let digits = || of_digits(stamps, digits_scale(stamps)?);
    let time: Vec<f64> = match kind {
        Kind::Numbers => digits().unwrap_or_else(|| stamps.iter().map(|t| t * factor).collect()),
        _ => stamps.to_vec(),
    };
    spread(&time).unwrap_or(time)
}

fn writing<'a>(table: &Table, seen: &'a Seen, clock: Option<usize>) -> cells::Writing<'a> {
    cells::Writing {
        decimal: table.decimal,
        missing: &[],
        first_line: table.first_line,
        width: table.names.len(),
        clock,
        units: &seen.units,
    }
}

/// A clock that was found, where, and its seconds per unit.
struct Judged {
    clock: ListedClock,
    place: usize,
    factor: f64,
}

/// The column that holds the stamps, by its name and by what is in it.
fn judged_clock(
    log: &Location,
    channels: &[SourceChannel],
    warnings: &mut Vec<Warning>,
) -> Result<Option<Judged>, Error> {
    let mut ranked: Vec<(usize, usize)> =
        channels.iter().enumerate().filter_map(|(i, c)| Some((clock(c)?.0, i))).collect();
    ranked.sort_unstable();
    let mut coarse = None;
    for (_, i) in ranked {
        let Some(stamps) = Stamps::read(log, channels, i)? else { continue };
        match stamps.judged(channels, i) {
            Ok(judged) if stamps.coarse => coarse = coarse.or(Some(judged)),
            Ok(judged) => return Ok(Some(judged)),
            Err(message) => {
                let message =
                    format!("column `{}` is not taken as the clock: {message}", channels[i].name);
                warnings.push(warning("implausible_clock", None, 1, None, message));
            }
        }
    }
    Ok(coarse)
}

/// A column of stamps with the motion beside it.
struct Stamps {
    stamps: Vec<f64>,
    kind: Kind,
    /// Whether several rows share a stamp.
    coarse: bool,
    /// s per unit by the motion, as of a speed in m/s.
    motion: Option<f64>,
    /// The unit of the speed, if it is known.
    speed: Option<f64>,
}

impl Stamps {
    /// Reads a candidate; `None` if it holds no stamps.
    fn read(
        log: &Location,
        channels: &[SourceChannel],
        clock: usize,
    ) -> Result<Option<Self>, Error> {
        let (mut table, seen) = open(log)?;
        let motion = [Channel::Latitude, Channel::Longitude, Channel::VelocityX];
        let motion = motion.map(|column| best_named(channels, column));
        let mut places = vec![("time", channels[clock].place[0])];
        if let [Some(lat), Some(lon), Some(v)] = motion {
            places.extend([lat, lon, v].map(|i| (channels[i].name.as_str(), channels[i].place[0])));
        }
        let writing = writing(&table, &seen, Some(0));
        let read = cells::read_all(log, &mut table.rows, &places, writing, JUDGED)?;
        let mut columns = read.columns;
        let mut stamps = columns.remove(0);
        if let Some(decoded) = digits_scale(&stamps).and_then(|scale| of_digits(&stamps, scale)) {
            stamps = decoded;
        }
        let there: Vec<f64> = stamps.iter().copied().filter(|t| t.is_finite()).collect();
        let falls = there.windows(2).filter(|w| w[1] < w[0]).count();
        let rises = there.windows(2).filter(|w| w[1] > w[0]).count();
        let enough = 2 * there.len() > stamps.len() && rises > 1;
        if !enough || falls as f64 > FALLS * rises as f64 {
            return Ok(None);
        }
        let spread = spread(&stamps);
        let speed = match motion[2].and_then(|i| channels[i].unit.as_deref()) {
            Some(unit) => units::conversion(unit, "m/s").ok().map(|c| c.factor),
            None => None,
        };
        let factor = match columns.as_mut_slice() {
            [lat, lon, v] => {
                track::without_fix(lat, lon);
                let time = spread.as_deref().map_or(Cow::Borrowed(&stamps[..]), Cow::Borrowed);
                track::clock_factor(&time, [lat, lon], v)
            }
            _ => None,
        };
        let coarse = spread.is_some();
        Ok(Some(Stamps {
            stamps: spread.unwrap_or(stamps),
            kind: read.kind,
            coarse,
            motion: factor,
            speed,
        }))
    }

    /// The clock that the stamps are. Where they contradict the speed in the unit that the log says for it, that unit may
    /// be the wrong one.
    fn judged(&self, channels: &[SourceChannel], channel: usize) -> Result<Judged, String> {
        let any = || {
            let known = ["m/s", "km/h", "mph", "knots"].iter();
            known.filter_map(|u| Some(units::conversion(u, "m/s").ok()?.factor)).collect()
        };
        match self.speed {
            Some(factor) => {
                let first = self.judged_by(channels, channel, vec![factor]);
                first.or_else(|e| self.judged_by(channels, channel, any()).map_err(|_| e))
            }
            None => self.judged_by(channels, channel, any()),
        }
    }

    fn judged_by(
        &self,
        channels: &[SourceChannel],
        channel: usize,
        speeds: Vec<f64>,
    ) -> Result<Judged, String> {
        let place = channels[channel].place[0];
        let motion: Vec<f64> =
            self.motion.iter().flat_map(|m| speeds.iter().map(move |u| m / u)).collect();
        if self.kind != Kind::Numbers {
            let agrees = motion.is_empty() || motion.iter().any(|m| (0.5..2.0).contains(m));
            let epoch = self.kind == Kind::Dated;
            let clock = ListedClock { channel, unit: None, epoch, why: None };
            return match agrees {
                true => Ok(Judged { clock, place, factor: 1.0 }),
                false => Err(format!(
                    "its times contradict speed and positions, which ask for {:.3} s per second",
                    motion[0]
                )),
            };
        }
        let said = clock(&channels[channel]).and_then(|c| c.1);
        let digits = usual_step(&self.stamps).is_some() && digits_scale(&self.stamps).is_some();
        let found =
            unit::unit(&Evidence { stamps: &self.stamps, said: said.filter(|_| !digits), motion })?;
        let clock = ListedClock {
            channel,
            unit: Some(found.name),
            epoch: found.zero.is_some(),
            why: found.why,
        };
        Ok(Judged { clock, place, factor: found.factor })
    }
}

/// What a text seems to be.
struct Seen {
    channels: Vec<SourceChannel>,
    /// Units by place in a row, empty where there is none.
    units: Vec<String>,
    /// Which row below the names holds units, from 1; 0 if none does.
    units_row: usize,
}

fn open(log: &Location) -> Result<(Table, Seen), Error> {
    let mut table = table::open(log, &[], 0)?;
    let plain = |cell: &String| units::of_brackets(cell).to_owned();
    let known = |cells: &Vec<String>| {
        let filled: Vec<&String> = cells.iter().filter(|c| !c.is_empty()).collect();
        let units =
            filled.iter().filter(|c| units::dimension(units::of_brackets(c)).is_some()).count();
        filled.len() > 1 && 2 * units > filled.len()
    };
    // the last row of words may be the units of the names above it
    let mut units_row = 0;
    if known(&table.names) {
        let below = table::open(log, &[], 1)?;
        if below.names.len() == table.names.len() {
            units_row = table.names_line - below.names_line;
            table = below;
        }
    }
    if let Some(first) = table.names.first_mut() {
        *first = first.trim_start_matches(['#', ' ']).to_owned();
    }
    let row = layout::cells(&table.first, table.delimiter);
    let unit = |place: usize| {
        let note = table.notes.iter().find(|n| n.len() >= table.names.len().min(2));
        let note = note.and_then(|r| r.get(place)).filter(|u| !u.is_empty()).map(plain);
        let name = &table.names[place];
        let within = || units::of_name(name).1.map(str::to_owned);
        let behind = || layout::with_unit(row.get(place)?).map(|w| w.1.to_owned());
        let last_word = || units::behind_name(name).map(str::to_owned);
        note.filter(|_| units_row > 0).or_else(within).or_else(behind).or_else(last_word)
    };
    let all: Vec<Option<String>> = (0..table.names.len()).map(unit).collect();
    let channel = |(place, name): (usize, &String)| SourceChannel {
        name: name.clone(),
        unit: all[place].clone(),
        place: [place, 0, 0],
        ..SourceChannel::default()
    };
    let channels: Vec<SourceChannel> =
        table.names.iter().enumerate().filter(|(_, n)| !n.is_empty()).map(channel).collect();
    let units = all.into_iter().map(Option::unwrap_or_default).collect();
    Ok((table, Seen { channels, units, units_row }))
}
