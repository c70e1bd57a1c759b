//! `session.v1`, the table that every log becomes, and the keys of its metadata.

use crate::contract::channel::Channel;
use crate::contract::schema;
use crate::contract::session::{Markers, Meta};
use crate::ingest::raw::Raw;

/// Takes an entry of a log's own metadata whose key is one of `session.v1`; `false` if it is none.
pub(super) fn session_meta(meta: &mut Meta, key: &str, value: &str) -> bool {
    let value = || Some(value.trim().to_owned());
    match key.trim() {
        "session_id" => meta.session_id = value().unwrap_or_default(),
        "bike_id" => meta.bike_id = value().unwrap_or_default(),
        "start_time" => meta.start_time = value(),
        "tyre_front" => meta.tyre_front = value(),
        "tyre_rear" => meta.tyre_rear = value(),
        "site" => meta.site = value(),
        "rider_id" => meta.rider_id = value(),
        _ => return false,
    }
    true
}

/// Key of the metadata: standard deviations of the scales of the wheel speeds, front and rear, a share each.
pub(super) const WHEEL_SCALE_SD: &str = "wheel_scale_sd";

/// These standard deviations of a table's metadata; zero of a log that measured turns.
pub(super) fn wheel_scale_sd(get: impl Fn(&str) -> Option<String>) -> [f64; 2] {
    let text = get(WHEEL_SCALE_SD).unwrap_or_default();
    let mut shares = text.split(' ').map(|x| x.parse().ok().filter(|x| (0.0..0.5).contains(x)));
    [(); 2].map(|()| shares.next().flatten().unwrap_or(0.0))
}

/// Key of the metadata: time between two measured samples of the forward velocity, s.
pub(super) const VELOCITY_SPACING: &str = "velocity_spacing";

/// This time of a table's metadata, s; 0 where it is absent or no time.
pub(super) fn velocity_spacing(get: impl Fn(&str) -> Option<String>) -> f64 {
    let spacing = get(VELOCITY_SPACING).and_then(|text| text.trim().parse().ok());
    spacing.filter(|s: &f64| s.is_finite() && *s > 0.0).unwrap_or(0.0)
}

/// A log with what its own metadata say beside who and when.
pub(super) fn with_metadata(raw: Raw, get: impl Fn(&str) -> Option<String> + Copy) -> Raw {
    Raw {
        wheel_scale_sd: wheel_scale_sd(get),
        velocity_spacing: velocity_spacing(get),
        markers: markers(get),
        ..raw
    }
}

/// Keys of the metadata: when the logger passed its start line, s in the column `time`; and that line, latitude and
/// longitude of its two ends, degrees.
pub(super) const LAP_MARKERS: &str = "lap_markers";
pub(super) const START_LINE: &str = "start_line";

/// Laps in a table's metadata; a text that is not a number is left out.
pub(super) fn markers(get: impl Fn(&str) -> Option<String>) -> Markers {
    let numbers = |key: &str| -> Vec<f64> {
        let text = get(key).unwrap_or_default();
        let number = |word: &str| word.parse().ok().filter(|x: &f64| x.is_finite());
        text.split_whitespace().filter_map(number).collect()
    };
    let line = match numbers(START_LINE)[..] {
        [a, b, c, d] => Some([[a, b], [c, d]]),
        _ => None,
    };
    Markers { times: numbers(LAP_MARKERS), line }
}

/// These metadata of a session's markers.
pub(super) fn marker_pairs(markers: &Markers) -> [(&'static str, Option<String>); 2] {
    let text = |numbers: &[f64]| {
        let words: Vec<String> = numbers.iter().map(ToString::to_string).collect();
        (!words.is_empty()).then(|| words.join(" "))
    };
    let line: Vec<f64> = markers.line.iter().flatten().flatten().copied().collect();
    [(LAP_MARKERS, text(&markers.times)), (START_LINE, text(&line))]
}

/// Unit of a channel in `session.v1`; `1` for a channel without dimension.
pub(super) fn si_unit(channel: Channel) -> &'static str {
    schema::session().column(channel.name()).and_then(|c| c.unit.as_deref()).unwrap_or("1")
}
