//! A clock against calendar, rates and motion, after a channel map was read: a wrong unit of the stamps is an error that
//! says the right one.

use std::sync::Arc;

use super::unit::{CALENDARS, IMPOSSIBLE, digits_scale, in_years, of_digits, usual_step};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::ingest::motion::track;
use crate::ingest::raw::Track;

/// Stamps beyond this are of no clock that a map reads correctly: the year 2199, s.
const LAST_YEAR: f64 = 7.3e9;
/// So far the motion may be off before the clock is doubted: less may be the unit of the speed.
const OFF: f64 = 7.0;
/// Stamps by which the rate of a text's clock is judged.
const LOOKED_AT: usize = 5000;
/// Speeds that are taken for a motorcycle's, m/s: others have a wrong unit themselves.
const SPEEDS: [f64; 2] = [2.0, 120.0];

/// Brings numbers of a text's clock into seconds, as a map says. Digits `hhmmss.ss` are seen by their jumps.
///
/// # Errors
/// A sentence: no logger has such a rate, or such a year.
pub(crate) fn in_seconds(stamps: &mut [f64], factor: f64) -> Result<(), String> {
    // no unit of 1 s makes digits
    if let Some(scale) = digits_scale(stamps)
        && let Some(decoded) = of_digits(stamps, scale)
    {
        stamps.copy_from_slice(&decoded);
        return Ok(());
    }
    let step = usual_step(&stamps[..stamps.len().min(LOOKED_AT)]);
    if let Some(message) = of_calendar(stamps, step, factor) {
        return Err(message);
    }
    if let Some(step) = step.map(|d| d * factor).filter(|d| outside(*d)) {
        return Err(format!(
            "no logger writes stamps {step} s apart: give the right `unit`, or `rate` instead of `column`"
        ));
    }
    stamps.iter_mut().for_each(|t| *t *= factor);
    Ok(())
}

fn outside(step: f64) -> bool {
    !(IMPOSSIBLE[0]..=IMPOSSIBLE[1]).contains(&step)
}

/// Error in stamps that are a date in another unit.
fn of_calendar(stamps: &[f64], step: Option<f64>, factor: f64) -> Option<String> {
    let first = stamps.iter().copied().find(|t| t.is_finite())?;
    let step = step?;
    let known = CALENDARS.iter().any(|c| c.factor == factor && in_years(first * factor + c.zero));
    if !outside(step * factor) && (first * factor < LAST_YEAR || known) {
        return None;
    }
    let fits = |c: &&super::unit::Calendar| {
        c.factor != factor && !outside(step * c.factor) && in_years(first * c.factor + c.zero)
    };
    let c = CALENDARS.iter().find(fits)?;
    Some(format!(
        "the stamps ({first} first) are {}: give `unit = \"{}\"` and, for the start time, `epoch = true`",
        c.what, c.unit
    ))
}

/// Holds the clock of a log that was read against its speed and positions.
///
/// # Errors
/// `implausible_clock`: the stamps contradict both in a way that no unit of the speed explains.
pub(crate) fn by_motion(tracks: &[Track]) -> Result<(), Error> {
    let of = |channel: Channel| tracks.iter().find(|t| t.channel == channel);
    let (Some(v), Some(lat), Some(lon)) =
        (of(Channel::VelocityX), of(Channel::Latitude), of(Channel::Longitude))
    else {
        return Ok(());
    };
    if !Arc::ptr_eq(&lat.time, &lon.time) || !Arc::ptr_eq(&v.time, &lat.time) {
        return Ok(());
    }
    let needed = track::clock_factor(&v.time, [&lat.values, &lon.values], &v.values);
    let Some(factor) = needed.filter(|f| !(1.0 / OFF..OFF).contains(f)) else { return Ok(()) };
    match track::middle_speed(&v.values) {
        Some(speed) if (SPEEDS[0]..SPEEDS[1]).contains(&speed) => {
            let message = format!(
                "the clock contradicts the motion: by velocity_x and the positions the log's time runs {factor:.4} times \
                 what the stamps say; correct the unit or the rate of the clock ([time] of the channel map)"
            );
            Err(Error::new(RejectionCode::ImplausibleClock, message))
        }
        _ => Ok(()),
    }
}
