//! The unit in which stamps count: by the calendar, by rates that loggers have, by the motion.

use crate::contract::instant;
use crate::ingest::maps::units;
use crate::statistics::order::upper_median;

/// A clock's unit: how the channel map spells it, s per unit, and the Unix time of its zero, if it has a calendar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Calendar {
    /// As in `time.unit` of a channel map.
    pub unit: &'static str,
    /// Factor, s per unit.
    pub factor: f64,
    /// Where it begins to count, s since 1970.
    pub zero: f64,
    /// Name, for people.
    pub what: &'static str,
}

const fn calendar(unit: &'static str, factor: f64, zero: f64, what: &'static str) -> Calendar {
    Calendar { unit, factor, zero, what }
}

/// Clocks that count from some day. No number is in the range of two with the same rate.
#[rustfmt::skip]
pub(crate) const CALENDARS: &[Calendar] = &[
    calendar("s", 1.0, 0.0, "Unix seconds"),
    calendar("ms", 1e-3, 0.0, "Unix milliseconds"),
    calendar("us", 1e-6, 0.0, "Unix microseconds"),
    calendar("100ns", 1e-7, -62_135_596_800.0, "ticks of .NET since the year 1"),
    calendar("100ns", 1e-7, -11_644_473_600.0, "Windows file times since 1601"),
    calendar("ns", 1e-9, 0.0, "Unix nanoseconds"),
    calendar("day", 86_400.0, -2_209_161_600.0, "days of a spreadsheet since 1900"),
    calendar("day", 86_400.0, -62_167_305_600.0, "days of MATLAB since the year 0"),
    calendar("day", 86_400.0, -210_866_760_000.0, "Julian days"),
];

/// Units that are tried where the motion asks for another, the likeliest first.
const TRIED: &[&str] = &["s", "ms", "us", "min", "ns", "h", "day", "100ns", "10ms", "100us"];

/// Slowest and fastest sampling that is taken for a logger's without a word of the motion, s between rows.
const STEPS: [f64; 2] = [1.0 / 2100.0, 2.1];
/// Sampling that is believed where the log says the unit of the stamps and nothing that of the speed, s between rows.
const SAID: [f64; 2] = [1.0 / 510.0, 2.1];
/// Beyond these steps no clock is believed, s between rows.
pub(crate) const IMPOSSIBLE: [f64; 2] = [2e-5, 30.0];
/// How far the motion may be off a unit: speeds are a little late and rounded.
const MOTION_TOLERANCE: f64 = 0.15;

/// Known properties of stamps before their unit is.
#[derive(Debug, Clone, Default)]
pub(crate) struct Evidence<'a> {
    /// The stamps as numbers.
    pub stamps: &'a [f64],
    /// The unit that the log says, in its name or in a row of units.
    pub said: Option<&'a str>,
    /// s per unit by the motion, for each unit that the speed may be in; empty where nothing moves.
    pub motion: Vec<f64>,
    /// Whether nobody knows the unit of the speed: then it may be any, tenths of km/h, say.
    pub any_speed: bool,
}

/// A unit that was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    /// As in `time.unit` of a channel map.
    pub name: String,
    /// Factor, s per unit.
    pub factor: f64,
    /// Unix time of its zero, where it has a calendar.
    pub zero: Option<f64>,
    /// Reason of the decision, where it is not what the log says.
    pub why: Option<String>,
}

/// The calendar in which stamps are days of a ride's years, sampled as loggers do.
pub(crate) fn calendar_of(stamps: &[f64]) -> Option<&'static Calendar> {
    let first = stamps.iter().copied().find(|t| t.is_finite())?;
    let last = stamps.iter().rev().copied().find(|t| t.is_finite())?;
    let step = usual_step(stamps);
    let fits = |c: &&Calendar| {
        let plausible = step.is_none_or(|d| {
            let d = d * c.factor;
            // whole seconds, and clocks that stand
            (IMPOSSIBLE[0] * 0.5..=IMPOSSIBLE[1]).contains(&d)
        });
        plausible && [first, last].iter().all(|t| in_years(t * c.factor + c.zero))
    };
    CALENDARS.iter().find(fits)
}

/// Whether a Unix time is one of a ride's years.
pub(crate) fn in_years(unix: f64) -> bool {
    let second = |year: i16| {
        let start = jiff::civil::date(year, 1, 1).to_zoned(jiff::tz::TimeZone::UTC);
        start.map_or(f64::NAN, |z| z.timestamp().as_second() as f64)
    };
    (second(instant::YEARS.start)..second(instant::YEARS.end)).contains(&unix)
}

/// Middle of the steps ahead: of a coarse clock what its rows are apart.
pub(crate) fn usual_step(stamps: &[f64]) -> Option<f64> {
    let there: Vec<f64> = stamps.iter().copied().filter(|t| t.is_finite()).collect();
    let mut steps: Vec<f64> = there.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    upper_median(&mut steps)
}

/// The unit of a clock.
///
/// # Errors
/// The stamps contradict the motion in every unit, or no unit gives a rate that a logger has.
pub(crate) fn unit(known: &Evidence<'_>) -> Result<Unit, String> {
    let said = known.said.and_then(|u| Some((u, units::conversion(u, "s").ok()?.factor)));
    let agrees = |factor: f64| {
        known.motion.is_empty()
            || known.motion.iter().any(|m| (factor / m).ln().abs() < MOTION_TOLERANCE)
    };
    let is_believed = |c: &&Calendar| known.any_speed || agrees(c.factor);
    if let Some(c) = calendar_of(known.stamps).filter(is_believed) {
        let other = said.filter(|s| (s.1 / c.factor - 1.0).abs() > 1e-6);
        let why = match other {
            Some((unit, _)) => format!("the stamps are {}, not {unit} as the log says", c.what),
            None => format!("the stamps are {}", c.what),
        };
        return Ok(Unit {
            name: c.unit.into(),
            factor: c.factor,
            zero: Some(c.zero),
            why: Some(why),
        });
    }
    let step = usual_step(known.stamps);
    let usual = |factor: f64| step.is_none_or(|d| (STEPS[0]..=STEPS[1]).contains(&(d * factor)));
    let of = |name: &str, why: Option<String>| {
        let factor = units::conversion(name, "s").map_or(1.0, |c| c.factor);
        Unit { name: name.to_owned(), factor, zero: None, why }
    };
    if let Some((name, factor)) = said {
        // what the log says stands as long as nothing contradicts it
        if agrees(factor) && (usual(factor) || !known.motion.is_empty()) {
            return Ok(of(name, None));
        }
        // a speed of no known unit contradicts nothing
        let plausible = step.is_some_and(|d| (SAID[0]..=SAID[1]).contains(&(d * factor)));
        if known.any_speed && plausible {
            return Ok(of(name, None));
        }
    } else if agrees(1.0) && usual(1.0) {
        return Ok(of("s", None));
    }
    let factor_of = |name: &str| units::conversion(name, "s").map_or(f64::NAN, |c| c.factor);
    let by_motion = || TRIED.iter().find(|u| !known.motion.is_empty() && agrees(factor_of(u)));
    if let Some(found) = by_motion() {
        let not = said.map_or(String::new(), |s| format!(", not {} as the log says", s.0));
        let why = format!("speed and positions agree with stamps in {found}{not}");
        return Ok(of(found, Some(why)));
    }
    if !known.motion.is_empty() {
        let speed = match known.any_speed {
            true => " (the log does not say the unit of the speed, which may be another than m/s)",
            false => "",
        };
        return Err(format!(
            "the stamps contradict the motion: speed and positions need {:.4} s per unit{speed}; \
             give the right `unit` in the map's [time], or `rate` instead of `column`",
            known.motion[0]
        ));
    }
    let by_rate = TRIED.iter().find(|u| usual(factor_of(u)));
    match (by_rate, said, step) {
        (Some(found), None, Some(step)) => {
            let rate = 1.0 / (step * factor_of(found));
            let why = format!(
                "the log does not give the unit of the stamps; {found} is assumed, which gives \
                 {rate:.0} Hz: check it"
            );
            Ok(of(found, Some(why)))
        }
        (_, Some((name, factor)), Some(step))
            if (IMPOSSIBLE[0]..=IMPOSSIBLE[1]).contains(&(step * factor)) =>
        {
            Ok(of(name, None))
        }
        (_, _, Some(step)) => Err(format!(
            "the stamps are {step} apart, which is no logger's rate in {}; give their `unit` in \
             the map's [time], or `rate` instead of `column`",
            said.map_or("s", |s| s.0)
        )),
        (_, said, None) => Ok(of(said.map_or("s", |s| s.0), None)),
    }
}

/// A clock of digits, `hhmmss.ss` as a number: its seconds of the day; `None` if it is none.
///
/// `scale` is s per unit of the last digits: 1 of `hhmmss`, 0.001 of `hhmmssmmm`.
pub(crate) fn of_digits(stamps: &[f64], scale: f64) -> Option<Vec<f64>> {
    let mut out = Vec::with_capacity(stamps.len());
    for t in stamps {
        if !t.is_finite() {
            out.push(f64::NAN);
            continue;
        }
        let number = t * scale;
        let (whole, part) = (number.trunc(), number.fract());
        let (h, m, s) = ((whole / 1e4).trunc(), (whole / 100.0).trunc() % 100.0, whole % 100.0);
        if !(0.0..240_000.0).contains(&number) || m > 59.0 || s > 60.0 {
            return None;
        }
        out.push(3600.0 * h + 60.0 * m + s + part);
    }
    Some(out)
}

/// Whether stamps are better a clock of digits: they jump from 59 s to the next minute, and then they do not.
pub(crate) fn digits_scale(stamps: &[f64]) -> Option<f64> {
    // as numbers they are no even clock, as digits they are
    let jumps = |stamps: &[f64]| {
        let step = usual_step(stamps)?;
        Some(stamps.windows(2).filter(|w| w[1] - w[0] > 10.0 * step && w[1] - w[0] > 0.0).count())
    };
    // parts of a second are digits of whole numbers
    let whole = stamps.iter().take(100).all(|t| t.is_nan() || t.fract() == 0.0);
    [1.0, 1e-2, 1e-3].into_iter().filter(|scale| *scale == 1.0 || whole).find(|scale| {
        let Some(decoded) = of_digits(stamps, *scale) else { return false };
        matches!((jumps(stamps), jumps(&decoded)), (Some(a), Some(b)) if a > 0 && 2 * b < a + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(start: f64, step: f64) -> Vec<f64> {
        (0..60).map(|i| start + f64::from(i) * step).collect()
    }

    fn found(stamps: &[f64], said: Option<&str>, motion: &[f64]) -> Result<Unit, String> {
        unit(&Evidence { stamps, said, motion: motion.to_vec(), any_speed: false })
    }

    #[test]
    fn the_calendar_tells_the_unit() {
        for (start, step, unit) in [
            (1_792_922_400.0, 0.5, "s"),
            (1_792_922_400e3, 500.0, "ms"),
            (1_792_922_400e6, 5e5, "us"),
            (1_792_922_400e9, 5e8, "ns"),
            (46_320.416_667, 0.5 / 86_400.0, "day"),
            (739_915.4, 0.5 / 86_400.0, "day"),
            (639_285_192e9, 5e6, "100ns"),
            (134_373_960e9, 5e6, "100ns"),
        ] {
            let got = found(&stamps(start, step), None, &[]).expect(unit);
            assert_eq!((got.name.as_str(), got.zero.is_some()), (unit, true), "{start}");
            assert!(
                (usual_step(&stamps(start, step)).expect("steps") * got.factor - 0.5).abs() < 0.01
            );
        }
        // what counts from the start of the logger is no date
        for (start, step) in [(4e8, 1e4), (4e11, 1e7)] {
            assert!(found(&stamps(start, step), Some("us"), &[]).expect("a unit").zero.is_none());
        }
    }

    #[test]
    fn rates_and_motion_tell_it_else() {
        assert_eq!(found(&stamps(0.0, 0.5), None, &[]).expect("s").name, "s");
        assert_eq!(found(&stamps(0.0, 10.0), None, &[]).expect("ms").name, "ms");
        assert_eq!(found(&stamps(0.0, 0.5), Some("ms"), &[1.0]).expect("s").name, "s");
        assert_eq!(found(&stamps(0.0, 0.5 / 60.0), None, &[60.0]).expect("min").name, "min");
        assert_eq!(found(&stamps(0.0, 0.5 / 60.0), Some("min"), &[]).expect("min").name, "min");
        assert_eq!(found(&stamps(0.0, 1000.0), None, &[1e-6]).expect("us").name, "us");
        assert!(found(&stamps(0.0, 0.5), None, &[7.3]).is_err());
        assert!(found(&stamps(0.0, 1e9), None, &[]).expect("ns").why.is_some());
        assert!(found(&stamps(0.0, 5e-3), Some("ms"), &[]).is_err());
    }

    /// Tenths of km/h without a word ask for another clock than the one that the log says.
    #[test]
    fn a_speed_of_no_known_unit_moves_no_declared_clock() {
        let ten_hertz = stamps(0.0, 0.1);
        let of = |said: Option<&str>, any_speed: bool| {
            let motion = [1.0, 1.0 / 3.6].map(|m| 0.1 * m / 3.6).to_vec();
            unit(&Evidence { stamps: &ten_hertz, said, motion, any_speed })
        };
        assert_eq!(of(Some("s"), true).expect("said").name, "s");
        assert!(of(Some("s"), false).is_err(), "the unit of the speed is known");
        assert!(of(None, true).expect_err("nobody knows").contains("the unit of the speed"));
        // no logger takes 10 000 samples in a second
        assert!(of(Some("ms"), true).is_err());
        let dated = stamps(1_792_922_400.0, 0.1);
        let known = Evidence { stamps: &dated, said: None, motion: vec![0.0278], any_speed: true };
        assert_eq!(unit(&known).expect("a date").zero, Some(0.0));
    }

    #[test]
    fn a_clock_of_digits() {
        let of_day = |s: f64| {
            let (h, m) = ((s / 3600.0).floor(), (s / 60.0).floor() % 60.0);
            1e4 * h + 100.0 * m + s % 60.0
        };
        let seconds = stamps(36_045.0, 0.5);
        let digits: Vec<f64> = seconds.iter().map(|s| of_day(*s)).collect();
        assert_eq!(digits_scale(&digits), Some(1.0));
        assert_eq!(of_digits(&digits, 1.0).expect("digits"), seconds);
        let milli: Vec<f64> = digits.iter().map(|d| 1e3 * d).collect();
        assert_eq!(digits_scale(&milli), Some(1e-3));
        assert_eq!(digits_scale(&seconds), None);
    }
}
