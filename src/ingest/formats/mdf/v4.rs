//! MDF 4.

use std::collections::BTreeMap;
use std::sync::Arc;

use falcon_mdf::blocks::{ChannelType, SyncType};
use falcon_mdf::{Channel, ChannelGroup, Mf4Error, Mf4File};
use rayon::prelude::*;

use super::columns;
use super::common::{broken, group_names, unit};
use super::file::Bytes;
use crate::contract::warning::Warning;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::raw::Column;
use crate::ingest::session_schema::session_meta;
use crate::ingest::warning::warning;

/// Records that are decoded at a time.
const WINDOW: usize = 1 << 16;

/// Most samples that room is made for before they are read.
const RESERVED: usize = 1 << 22;

/// The groups that have samples over time, with a name for each.
fn groups(file: &Mf4File) -> Vec<(String, &ChannelGroup)> {
    let groups: Vec<&ChannelGroup> = file
        .data_groups()
        .iter()
        .flat_map(|dg| &dg.channel_groups)
        // of a bus the frames are read, not the parts that they are logged in
        .filter(|cg| clock(cg).is_some() && !cg.is_vlsd() && !cg.is_bus_event())
        .collect();
    let named = |cg: &&ChannelGroup| match &cg.source {
        _ if !cg.acquisition_name.trim().is_empty() => cg.acquisition_name.clone(),
        Some(source) => source.name.clone(),
        None => String::new(),
    };
    group_names(groups.iter().map(named).collect()).into_iter().zip(groups).collect()
}

/// The channel of a group that has its stamps.
fn clock(group: &ChannelGroup) -> Option<&Channel> {
    let of_time = |c: &&Channel| {
        matches!(c.sync_type, SyncType::Time)
            || (c.is_master() && ["time", "t", "timestamp"].contains(&&*c.name.to_lowercase()))
    };
    group.master_channel().filter(of_time)
}

/// Whether a channel's samples are numbers that can be read.
fn is_numeric(channel: &Channel) -> bool {
    channel.value_kind().is_numeric() && !channel.is_array() && channel.unreadable().is_none()
}

pub(super) fn list(file: &Mf4File) -> Listing {
    let mut listing = Listing::default();
    let mut other = Vec::new();
    for (group, cg) in groups(file) {
        for channel in cg.channels.iter().filter(|c| !c.is_master()) {
            if !is_numeric(channel) {
                other.push(channel.name.clone());
                continue;
            }
            listing.channels.push(SourceChannel {
                group: group.clone(),
                name: channel.name.clone(),
                unit: unit(&channel.unit),
                samples: Some(cg.sample_count),
                rate: None,
                place: [channel.data_group_index, channel.channel_group_index, channel.index],
                twin: 0,
            });
        }
    }
    let start = file.start_time().as_unix_seconds();
    if start > 0.0 {
        let ms = jiff::Timestamp::from_millisecond((start * 1e3).round() as i64);
        listing.meta.start_time = ms.ok().map(|t| t.to_string());
    }
    listing.facts.push(("version".into(), file.version().to_string()));
    let metadata = file.metadata();
    if !metadata.text().trim().is_empty() {
        listing.facts.push(("comment".into(), metadata.text().trim().to_owned()));
    }
    for (path, value) in metadata.properties() {
        let name = path.rsplit('/').next().unwrap_or(path);
        if !session_meta(&mut listing.meta, name, value) {
            listing.facts.push((name.to_owned(), value.to_owned()));
        }
    }
    if !other.is_empty() {
        listing.facts.push(("not numbers".into(), other.join(", ")));
    }
    listing
}

/// Data of one group.
struct Part {
    columns: Vec<(usize, Column)>,
    warning: Option<Warning>,
}

pub(super) fn decode(file: &Mf4File, bytes: &dyn Bytes, wanted: &[&SourceChannel]) -> Decoded {
    let mut of_group: BTreeMap<[usize; 2], Vec<(usize, &SourceChannel)>> = BTreeMap::new();
    for (i, channel) in wanted.iter().enumerate() {
        let [dg, cg, _] = channel.place;
        of_group.entry([dg, cg]).or_default().push((i, channel));
    }
    let part = |([dg, cg], wanted): ([usize; 2], Vec<_>)| part(file, bytes, [dg, cg], &wanted);
    let parts: Vec<Part> = of_group.into_par_iter().map(part).collect();
    let mut decoded = Decoded::default();
    let mut columns = Vec::new();
    for part in parts {
        columns.extend(part.columns);
        decoded.warnings.extend(part.warning);
    }
    columns.sort_by_key(|(i, _)| *i);
    decoded.columns = columns.into_iter().map(|(_, column)| column).collect();
    decoded
}

/// The wanted channels of one group; up to the damage, if there is any.
fn part(
    file: &Mf4File,
    bytes: &dyn Bytes,
    [dg, cg]: [usize; 2],
    wanted: &[(usize, &SourceChannel)],
) -> Part {
    let mut columns = vec![Vec::new(); wanted.len() + 1];
    let read = read(file, bytes, [dg, cg], wanted, &mut columns);
    let count = columns.iter().map(Vec::len).min().unwrap_or(0);
    columns.iter_mut().for_each(|column| column.truncate(count));
    let mut columns = columns.into_iter();
    let time = Arc::new(columns.next().unwrap_or_default());
    let name = wanted.first().map(|(_, c)| c.group.as_str()).unwrap_or_default();
    let warning = match read {
        Ok(()) => invalid_stamps(name, &time),
        Err(e) => Some(broken(name, count, time.last().copied(), &e)),
    };
    let column = |((i, channel), values): (&(usize, &SourceChannel), Vec<f64>)| {
        (*i, Column { name: channel.full(), time: Arc::clone(&time), values })
    };
    Part { columns: wanted.iter().zip(columns).map(column).collect(), warning }
}

fn invalid_stamps(group: &str, time: &[f64]) -> Option<Warning> {
    let count = time.iter().filter(|t| !t.is_finite()).count();
    let message = format!("{group}: {count} time stamps are invalid");
    (count > 0).then(|| warning("time_missing", None, count, None, message))
}

/// The stamps, then the wanted channels; what there is of them even where it fails.
fn read(
    file: &Mf4File,
    bytes: &dyn Bytes,
    [dg, cg]: [usize; 2],
    wanted: &[(usize, &SourceChannel)],
    columns: &mut Vec<Vec<f64>>,
) -> Result<(), Mf4Error> {
    let gone = |what: &str| Mf4Error::parse_error(format!("the {what} is missing"));
    let data = file.data_groups().get(dg).ok_or_else(|| gone("group"))?;
    let group = data.channel_groups.get(cg).ok_or_else(|| gone("group"))?;
    let mut channels = vec![clock(group).ok_or_else(|| gone("clock"))?];
    for (_, channel) in wanted {
        channels.push(group.channels.get(channel.place[2]).ok_or_else(|| gone("channel"))?);
    }
    if let Some(read) = columns::read(bytes, data, group, &channels) {
        *columns = read.columns;
        return read.broken.map_or(Ok(()), Err);
    }
    windows(file, group, &channels, columns)
}

/// Channels of any kind, through the library.
fn windows(
    file: &Mf4File,
    group: &ChannelGroup,
    channels: &[&Channel],
    columns: &mut [Vec<f64>],
) -> Result<(), Mf4Error> {
    let computed = |c: &&Channel| {
        matches!(c.channel_type, ChannelType::VirtualMaster | ChannelType::VirtualData)
    };
    // a damaged file may claim any number
    let samples = usize::try_from(group.sample_count).unwrap_or(0).min(RESERVED);
    columns.iter_mut().for_each(|column| column.reserve(samples));
    // those are computed from the number of the sample: a window would begin anew
    for (channel, column) in channels.iter().zip(&mut *columns).filter(|(c, _)| computed(c)) {
        let signal = file.signal(channel)?;
        append(column, signal.values_f64()?, signal.validity());
    }
    let (places, stored): (Vec<usize>, Vec<&Channel>) =
        channels.iter().enumerate().filter(|(_, c)| !computed(c)).map(|(i, c)| (i, *c)).unzip();
    for window in file.signals_chunks(&stored, WINDOW)? {
        for (signal, place) in window?.iter().zip(&places) {
            append(&mut columns[*place], signal.values_f64()?, signal.validity());
        }
    }
    Ok(())
}

fn append(column: &mut Vec<f64>, values: Vec<f64>, valid: Option<Vec<bool>>) {
    let start = column.len();
    column.extend(values);
    for (value, valid) in column[start..].iter_mut().zip(valid.unwrap_or_default()) {
        if !valid {
            *value = f64::NAN;
        }
    }
}
