//! A look at delimited text that no map is known for: its layout is guessed.

use std::borrow::Cow;

use super::positions::{self, Positions};
use super::table::{self, Table};
use super::{cells, clocks, layout, sentinels, text};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::clock::stamps::text::Kind;
use crate::ingest::clock::stamps::unit;
use crate::ingest::clock::stamps::unit::{Evidence, digits_scale, of_digits, usual_step};
use crate::ingest::clock::{longest, spread, wraps};
use crate::ingest::error::Error;
use crate::ingest::formats::format::Decoder;
use crate::ingest::formats::listing::{Decoded, ListedClock, Listing, SourceChannel, number_twins};
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
    no_table(log, &table)?;
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
    let below = table.lines_below;
    if below > 0 {
        layout.push(format!("rows_after_header = {below}"));
    }
    if seen.units_row > 0 {
        layout.push(format!("units_row = {}", seen.units_row));
    }
    let said = seen.positions.left_out.iter().chain(&seen.positions.guessed);
    let mut messages: Vec<&String> = said.map(|s| &s.1).collect();
    messages.dedup();
    let of = |message: &&String| warning(positions::CODE, None, 1, None, (*message).clone());
    let mut warnings: Vec<Warning> = messages.iter().map(of).collect();
    warnings.extend(text::encoding_warning(log)?);
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

/// Texts that are no table of a column for each channel.
fn no_table(log: &Location, table: &Table) -> Result<(), Error> {
    let wrong = |message: String| Err(Error::new(RejectionCode::NoTable, message));
    let names = &table.names;
    if names.len() > 1 && names.iter().all(|n| layout::is_number(n)) {
        return wrong(format!(
            "{log} begins with numbers and has no names of columns: put a line with their names in front, \
             `Time (s),Speed (km/h),...`"
        ));
    }
    if let Some([name, value]) = long_format(table) {
        let [name, value] = [name, value].map(|place| &names[place]);
        return wrong(format!(
            "{log} has one value in a line: column `{name}` names the channel, `{value}` holds its number; write it as a \
             table with a column for each channel (export it as such, or in pandas `df.pivot_table(index=TIME, \
             columns=\"{name}\", values=\"{value}\")`)"
        ));
    }
    Ok(())
}

/// Most columns of a text with one value in a line: time, channel, value, unit and the like.
const LONG: usize = 6;

/// Where a text with one value in a line has the channel's name and its number.
fn long_format(table: &Table) -> Option<[usize; 2]> {
    const VALUES: [&str; 7] = ["value", "val", "wert", "valeur", "valor", "valore", "значение"];
    let called = |name: &String| VALUES.contains(&name.trim().to_lowercase().as_str());
    let value = table.names.iter().position(called)?;
    let kinds = |place: usize| {
        let cells = table.sample.iter().filter_map(|r| r.get(place)).filter(|c| !c.is_empty());
        let mut kinds: Vec<&String> = cells.clone().collect();
        let words = kinds.iter().all(|c| !layout::is_number(c) && c.len() > 2);
        kinds.sort_unstable();
        kinds.dedup();
        (words && kinds.len() > 2 && 3 * kinds.len() < 2 * cells.count()).then_some(kinds.len())
    };
    let named = (0..table.names.len()).filter(|i| *i != value);
    let name = named.filter_map(|i| Some((kinds(i)?, i))).max()?.1;
    (table.names.len() <= LONG).then_some([name, value])
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
    let mut columns: Vec<(String, Vec<f64>)> = names.into_iter().zip(values).collect();
    let mut time = time;
    // what is read is the longest part of a clock that was set while it logged
    if let Some(part) = stamps.as_ref().and_then(|_| longest(&time)) {
        let of = |from: &[f64]| part.iter().map(|&i| from[i]).collect::<Vec<f64>>();
        let message = format!(
            "the clock jumps back or far ahead: of {rows} rows the {} of the longest part between \
             jumps are used",
            part.len()
        );
        read.warnings.push(warning("time_backwards", None, rows - part.len(), None, message));
        time = of(&time);
        columns.iter_mut().for_each(|(_, values)| *values = of(values));
    }
    let columns = clocks::separate(time, columns, |_, _| false);
    Ok(Decoded { columns, warnings: read.warnings, ..Decoded::default() })
}

/// Stamps in seconds, those that are coarser than the rows spread over them.
fn seconds(stamps: &[f64], kind: Kind, factor: f64) -> Vec<f64> {
    let digits = || of_digits(stamps, digits_scale(stamps)?);
    let mut time: Vec<f64> = match kind {
        Kind::Numbers => digits().unwrap_or_else(|| stamps.iter().map(|t| t * factor).collect()),
        _ => stamps.to_vec(),
    };
    wraps::unroll(&mut time);
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
        coordinates: &seen.positions.coordinates,
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
    let (mut coarse, mut none) = (None, Vec::new());
    let refused = |i: usize, why: String| {
        let message = format!("column `{}` is not taken as the clock: {why}", channels[i].name);
        warning("implausible_clock", None, 1, None, message)
    };
    for (_, i) in ranked {
        let stamps = match Stamps::read(log, channels, i)? {
            Ok(stamps) => stamps,
            Err(why) => {
                none.push(refused(i, why));
                continue;
            }
        };
        match stamps.judged(channels, i) {
            Ok(judged) if stamps.coarse => coarse = coarse.or(Some(judged)),
            Ok(judged) => return Ok(Some(judged)),
            Err(why) => warnings.push(refused(i, why)),
        }
    }
    if coarse.is_none() {
        warnings.extend(none);
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
    /// Reads a candidate; a sentence if it holds no stamps.
    fn read(
        log: &Location,
        channels: &[SourceChannel],
        clock: usize,
    ) -> Result<Result<Self, String>, Error> {
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
            let example =
                read.warnings.iter().find_map(|w| w.message.split("the first is ").nth(1));
            let example = example.and_then(|e| e.split(';').next());
            return Ok(Err(no_clock(&there, stamps.len(), [rises, falls], example)));
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
        Ok(Ok(Stamps {
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
        let said = said.filter(|_| !digits);
        let any_speed = self.speed.is_none();
        let found = unit::unit(&Evidence { stamps: &self.stamps, said, motion, any_speed })?;
        let clock = ListedClock {
            channel,
            unit: Some(found.name),
            epoch: found.zero.is_some(),
            why: found.why,
        };
        Ok(Judged { clock, place, factor: found.factor })
    }
}

/// Why a column that is called like a clock is none: its stamps, of how many cells, how often they rise and fall, and the
/// first cell that is not read.
fn no_clock(
    stamps: &[f64],
    cells: usize,
    [rises, falls]: [usize; 2],
    example: Option<&str>,
) -> String {
    if 2 * stamps.len() <= cells {
        let example = example.map_or(String::new(), |e| format!(", the first {e}"));
        return format!(
            "{} of its {cells} cells are read neither as numbers nor as times{example}; write seconds, `hh:mm:ss.sss` or \
             `yyyy-mm-dd hh:mm:ss.sss`",
            cells - stamps.len()
        );
    }
    if rises + falls <= 1 {
        return format!(
            "all its stamps are {}: they were written with too few digits, as spreadsheets do; export them with all of them",
            stamps.first().copied().unwrap_or(f64::NAN)
        );
    }
    if falls > rises {
        return "its stamps run backwards: sort the rows by it, the earliest first".to_owned();
    }
    format!(
        "its stamps fall back {falls} times and rise {rises} times: it is the time of a lap, its parts of a second are written \
         without zeros in front, or the file holds several recordings"
    )
}

/// First look at a text.
struct Seen {
    channels: Vec<SourceChannel>,
    /// Units by place in a row, empty where there is none.
    units: Vec<String>,
    /// Which row below the names holds units, from 1; 0 if none does.
    units_row: usize,
    /// Where positions are and how they are written.
    positions: Positions,
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
    let positions = Positions::look(&table.names, &table.sample, table.decimal);
    let row = layout::cells(&table.first, table.delimiter);
    let unit = |place: usize| {
        let note = table.notes.iter().find(|n| n.len() >= table.names.len().min(2));
        let note = note.and_then(|r| r.get(place)).filter(|u| !u.is_empty()).map(plain);
        let position = positions.unit(place).map(str::to_owned);
        let name = &table.names[place];
        let within = || units::of_name(name).1.map(str::to_owned);
        let after = || layout::with_unit(row.get(place)?).map(|w| w.1.to_owned());
        let last_word = || units::behind_name(name).map(str::to_owned);
        position
            .or_else(|| note.filter(|_| units_row > 0))
            .or_else(within)
            .or_else(after)
            .or_else(last_word)
    };
    let all: Vec<Option<String>> = (0..table.names.len()).map(unit).collect();
    let channel = |(place, name): (usize, &String)| SourceChannel {
        name: name.clone(),
        unit: all[place].clone(),
        place: [place, 0, 0],
        ..SourceChannel::default()
    };
    let there = |(place, name): &(usize, &String)| !name.is_empty() && !positions.is_none(*place);
    let mut channels: Vec<SourceChannel> =
        table.names.iter().enumerate().filter(there).map(channel).collect();
    channels.extend(positions.parts_of(&table.names));
    number_twins(&mut channels);
    let units = all.into_iter().map(Option::unwrap_or_default).collect();
    Ok((table, Seen { channels, units, units_row, positions }))
}
