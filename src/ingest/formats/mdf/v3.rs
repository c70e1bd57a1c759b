//! MDF 3.

use std::collections::HashMap;
use std::sync::Arc;

use falcon_mdf::Mf4Error;
use falcon_mdf::mdf3::Mdf3File;

use super::common::{broken, group_names, unit};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::raw::Column;

pub(super) fn list(file: &Mdf3File) -> Listing {
    let mut listing = Listing::default();
    let mut groups = Vec::new();
    for (dg, group) in file.data_groups().iter().enumerate() {
        for (cg, group) in group.channel_groups.iter().enumerate() {
            if file.master_channel(dg, cg).is_some() {
                groups.push((dg, cg, group));
            }
        }
    }
    // the comment, where it is a name and not a text of several lines
    let name = |comment: &str| comment.lines().next().unwrap_or_default().trim().to_owned();
    let names = group_names(groups.iter().map(|(_, _, g)| name(&g.comment)).collect());
    for ((dg, cg, group), label) in groups.into_iter().zip(names) {
        for (i, channel) in group.channels.iter().enumerate().filter(|(_, c)| !c.is_time()) {
            // 7 is text, 8 bytes
            if matches!(channel.data_type, 7 | 8) {
                continue;
            }
            listing.channels.push(SourceChannel {
                group: label.clone(),
                name: channel.name.clone(),
                unit: unit(&channel.unit),
                samples: Some(u64::from(group.cycle_count)),
                rate: (channel.sampling_rate > 0.0).then(|| 1.0 / channel.sampling_rate),
                place: [dg, cg, i],
                twin: 0,
            });
        }
    }
    if let Some(ns) = file.start_time_ns() {
        let stamp = jiff::Timestamp::from_nanosecond(i128::from(ns));
        listing.meta.start_time = stamp.ok().map(|t| t.to_string());
    }
    listing.facts.push(("version".into(), file.version().trim().to_owned()));
    if !file.comment().trim().is_empty() {
        listing.facts.push(("comment".into(), file.comment().trim().to_owned()));
    }
    listing
}

pub(super) fn decode(file: &Mdf3File, wanted: &[&SourceChannel]) -> Decoded {
    let mut clocks: HashMap<[usize; 2], Arc<Vec<f64>>> = HashMap::new();
    let mut decoded = Decoded::default();
    for channel in wanted {
        let [dg, cg, i] = channel.place;
        let clock = clocks.entry([dg, cg]).or_insert_with(|| {
            let time = clock(file, dg, cg);
            Arc::new(time.unwrap_or_else(|e| {
                decoded.warnings.push(broken(&channel.group, 0, None, &e));
                Vec::new()
            }))
        });
        let values = file.channel_physical(dg, cg, i).map(|v| v.to_f64());
        let mut values = values.unwrap_or_else(|e| {
            decoded.warnings.push(broken(&channel.full(), 0, None, &e));
            Vec::new()
        });
        values.resize(clock.len(), f64::NAN);
        decoded.columns.push(Column { name: channel.full(), time: Arc::clone(clock), values });
    }
    decoded
}

fn clock(file: &Mdf3File, dg: usize, cg: usize) -> Result<Vec<f64>, Mf4Error> {
    let group = file.data_groups().get(dg).and_then(|dg| dg.channel_groups.get(cg));
    let channels = group.map(|g| &g.channels[..]).unwrap_or_default();
    let at = channels.iter().position(|c| c.is_time());
    let at = at.ok_or_else(|| Mf4Error::parse_error("no time channel"))?;
    Ok(file.channel_physical(dg, cg, at)?.to_f64())
}
