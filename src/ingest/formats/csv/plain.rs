//! A look at delimited text that no map is known for: its layout is guessed.

use super::table::{self, Table};
use super::{cells, clocks};
use crate::ingest::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::format::Decoder;
use crate::ingest::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::propose::is_time;
use crate::ingest::units;
use crate::objects::Location;

/// Any delimited text.
pub const DECODER: Decoder = Decoder { list, decode };

fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
    let (table, guess) = open(log)?;
    let mut layout = vec!["[csv]".to_owned()];
    if table.delimiter != b',' {
        layout.push(format!("delimiter = {:?}", char::from(table.delimiter)));
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
    if guess.units {
        layout.push("units_row = 1".to_owned());
    }
    let layout = if layout.len() > 1 { layout.join("\n") } else { String::new() };
    Ok(Listing { channels: guess.channels, layout, ..Listing::default() })
}

fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
    let (mut table, guess) = open(log)?;
    let names: Vec<String> = wanted.iter().map(|c| c.full()).collect();
    let mut places: Vec<cells::Wanted<'_>> =
        names.iter().zip(wanted).map(|(name, c)| (name.as_str(), c.place[0])).collect();
    if let Some(clock) = guess.clock {
        places.push(("time", clock));
    }
    let writing = cells::Writing {
        decimal: table.decimal,
        missing: &[],
        first_line: table.first_line,
        width: table.names.len(),
    };
    // words among the numbers are no reason to show nothing
    let mut read = cells::read_all(log, &mut table.rows, &places, writing)?;
    let time = match guess.clock {
        Some(_) => {
            let mut time = read.columns.pop().unwrap_or_default();
            time.iter_mut().for_each(|t| *t *= guess.factor);
            time
        }
        // the row's number: rates are then those of rows
        None => (0..read.columns.first().map_or(0, Vec::len)).map(|i| i as f64).collect(),
    };
    let columns = names.into_iter().zip(read.columns).collect();
    Ok(Decoded { columns: clocks::separate(time, columns, |_, _| false), warnings: read.warnings })
}

/// What a text seems to be.
struct Guess {
    channels: Vec<SourceChannel>,
    /// Whether the row below the names holds units.
    units: bool,
    /// Place of the stamps, if there are any, and seconds per unit.
    clock: Option<usize>,
    factor: f64,
}

fn open(log: &Location) -> Result<(Table, Guess), Error> {
    let mut table = table::open(log, &[], 0)?;
    let known = |cells: &Vec<String>| {
        let filled: Vec<&String> = cells.iter().filter(|c| !c.is_empty()).collect();
        let units = filled.iter().filter(|c| units::dimension(c).is_some()).count();
        filled.len() > 1 && 2 * units > filled.len()
    };
    // the last row of words may be the units of the names above it
    let mut units = known(&table.names);
    if units {
        let below = table::open(log, &[], 1)?;
        units = below.names.len() == table.names.len();
        if units {
            table = below;
        }
    }
    if let Some(first) = table.names.first_mut() {
        *first = first.trim_start_matches(['#', ' ']).to_owned();
    }
    let unit = |place: usize| {
        let note = table.notes.first().and_then(|r| r.get(place)).filter(|u| !u.is_empty());
        let behind = || units::of_name(table.names.get(place)?).1.map(str::to_owned);
        note.filter(|_| units).cloned().or_else(behind)
    };
    let channel = |(place, name): (usize, &String)| SourceChannel {
        name: name.clone(),
        unit: unit(place),
        place: [place, 0, 0],
        ..SourceChannel::default()
    };
    let channels: Vec<SourceChannel> =
        table.names.iter().enumerate().filter(|(_, n)| !n.is_empty()).map(channel).collect();
    let clock = channels.iter().find(|c| is_time(c));
    let factor = clock.and_then(|c| units::conversion(c.unit.as_deref()?, "s").ok());
    let guess = Guess {
        units,
        clock: clock.map(|c| c.place[0]),
        factor: factor.map_or(1.0, |c| c.factor),
        channels,
    };
    Ok((table, guess))
}
