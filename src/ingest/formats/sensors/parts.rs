//! Rides that an archive holds several texts of: parts of one ride are put together, rides of their own are refused.
//!
//! A text is a ride's where it has positions beside its stamps and others have the same columns; sensors have their own.

use crate::ingest::formats::streams::{Stream, Streams};

/// Texts that are rides: as many as have the same columns, positions among them.
fn rides(streams: &Streams) -> Vec<usize> {
    let names = |s: &Stream| s.lines.iter().map(|l| l.name.clone()).collect::<Vec<String>>();
    let has = |s: &Stream, what: &str| s.lines.iter().any(|l| l.name.to_lowercase().contains(what));
    let is_ride = |i: &usize| has(&streams.all[*i], "lat") && has(&streams.all[*i], "lon");
    let with: Vec<usize> = (0..streams.all.len()).filter(is_ride).collect();
    let Some(&first) = with.first() else { return Vec::new() };
    let own = names(&streams.all[first]);
    with.into_iter().filter(|i| names(&streams.all[*i]) == own).collect()
}

/// First and last stamp.
fn span(stream: &Stream) -> Option<(f64, f64)> {
    let mut there = stream.time.iter().copied().filter(|t| t.is_finite());
    let first = there.next()?;
    Some((first, there.next_back().unwrap_or(first)))
}

/// Puts the parts of one ride together, each of which goes on where the one before it ends.
///
/// # Errors
/// The names of texts whose clocks overlap: they are rides of their own.
pub(super) fn join(streams: &mut Streams) -> Result<(), Vec<String>> {
    let rides = rides(streams);
    if rides.len() < 2 {
        return Ok(());
    }
    let group = |i: &usize| streams.all[*i].group.clone();
    let mut parts: Vec<(f64, f64, usize)> = rides
        .iter()
        .filter_map(|&i| span(&streams.all[i]).map(|(start, end)| (start, end, i)))
        .collect();
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    if parts.windows(2).any(|w| w[1].0 <= w[0].1) {
        return Err(rides.iter().map(group).collect());
    }
    let names: Vec<String> = parts.iter().map(|p| group(&p.2)).collect();
    let Some(&(_, _, first)) = parts.first() else { return Ok(()) };
    let mut whole = std::mem::take(&mut streams.all[first]);
    for &(_, _, i) in &parts[1..] {
        let part = std::mem::take(&mut streams.all[i]);
        whole.time.extend(part.time);
        for (line, more) in whole.lines.iter_mut().zip(part.lines) {
            line.values.extend(more.values);
        }
    }
    streams.all[first] = whole;
    let gone: Vec<usize> = rides.into_iter().filter(|i| *i != first).collect();
    let mut place = 0..;
    streams.all.retain(|_| place.next().is_none_or(|i| !gone.contains(&i)));
    streams.facts.push(("parts of one ride".to_owned(), names.join(", ")));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ride(group: &str, start: f64) -> Stream {
        let mut stream = Stream::new(group);
        for i in 0..10 {
            stream.begin(start + f64::from(i));
            stream.set("Latitude", Some("deg"), 47.0 + start);
            stream.set("Longitude", Some("deg"), 8.0);
        }
        stream
    }

    #[test]
    fn parts_of_a_ride_are_put_together_and_rides_are_not() {
        let mut imu = Stream::new("Gyroscope");
        imu.begin(0.0);
        imu.set("X", None, 1.0);
        let all = vec![ride("part2", 10.0), imu.clone(), ride("part1", 0.0)];
        let mut streams = Streams { all, ..Streams::default() };
        join(&mut streams).expect("one ride");
        let lengths: Vec<usize> = streams.all.iter().map(|s| s.time.len()).collect();
        assert_eq!(lengths, [1, 20]);
        assert!(streams.all[1].time.windows(2).all(|w| w[1] == w[0] + 1.0));
        assert_eq!(streams.all[1].get("Latitude").map(|x| [x[0], x[19]]), Some([47.0, 57.0]));
        let all = vec![ride("ride1", 0.0), imu, ride("ride2", 0.0)];
        let mut streams = Streams { all, ..Streams::default() };
        assert_eq!(join(&mut streams), Err(vec!["ride1".to_owned(), "ride2".to_owned()]));
    }
}
