//! A wheel's entry: a surface speed or a spin, and in which unit.

use super::log::{Log, Unit, unit_of};
use super::speed::{SPEEDS, Speed};
use super::verdict::Verdict;
use crate::contract::channel::Channel;
use crate::ingest::maps::units;

/// Units of spins that loggers write.
const SPINS: [&str; 4] = ["rad/s", "rpm", "rev/s", "deg/s"];
/// Radii of motorcycle wheels, m.
const RADII: std::ops::Range<f64> = 0.24..0.37;
/// How far wheel speeds by a nominal circumference are off.
const NOMINAL: f64 = 0.08;
/// A bike file's radius tells the unit of a spin within this share: tyres of a size differ by 2.5 % (ETRTO), loads add
/// 1 to 3 %.
const LIKE: f64 = 0.04;

/// The entry of a wheel, its unit by the motion.
pub(super) fn entry(
    log: &Log<'_>,
    speed: &Speed,
    column: Channel,
    radius: Option<f64>,
    surely_surface: bool,
) -> Verdict {
    let place = speed.place;
    let own = log.unit(place, "speed");
    let spin = log.unit(place, "angular rate");
    let near = if own.is_some() || surely_surface { 2.0 * NOMINAL } else { NOMINAL };
    let surface = unit_of(own, "m/s", &SPEEDS, speed.slope, near).filter(|_| spin.is_none());
    let turning = of_wheels(speed);
    let verdict = |unit: &str| Verdict { confirmed: true, ..Verdict::new(column, place, unit) };
    match (surface, turning) {
        (Some(unit), Some((other, r))) if own.is_none() && unit.name != "m/s" => {
            let doubt = format!(
                "its numbers suit a surface speed in {} as well as {other} with a radius of {r:.3} m",
                unit.name
            );
            let near = (speed.slope
                / units::conversion("m/s", &unit.name).map_or(1.0, |c| c.factor))
            .ln()
            .abs();
            let v = with_radius(verdict(&unit.name), &unit, speed, radius);
            // both would do, but loggers' circumferences are right within a few per cent
            if near < 0.03 || surely_surface {
                v
            } else {
                Verdict { or_unit: Some(other.to_owned()), ..v.doubted(doubt) }
            }
        }
        (Some(unit), _) => with_radius(verdict(&unit.name), &unit, speed, radius),
        (None, _) => spinning(verdict, speed, own.or(spin), radius),
    }
}

/// The radius that a wheel has if its numbers are in that unit, m; `None` of one that is no spin's.
fn radius_in(unit: &str, speed: &Speed) -> Option<f64> {
    Some(units::conversion("rad/s", unit).ok()?.factor / speed.slope)
}

/// The first unit of a spin in which the radius is one that a wheel can have.
fn of_wheels(speed: &Speed) -> Option<(&'static str, f64)> {
    let can = |unit: &'static str| Some((unit, radius_in(unit, speed)?));
    SPINS.into_iter().filter_map(can).find(|(_, r)| RADII.contains(r))
}

/// Whether a radius may be that of the bike file.
fn like(r: f64, of_bike: f64) -> bool {
    (r / of_bike).ln().abs() < LIKE
}

/// The entry of a spin: in the unit of the log (`said`) if a wheel can have the radius, without one in that of the bike
/// file's radius. A radius alone proves no unit: some number of teeth gives any of them.
fn spinning(
    verdict: impl Fn(&str) -> Verdict,
    speed: &Speed,
    said: Option<&str>,
    radius: Option<f64>,
) -> Verdict {
    let own = said.and_then(|u| Some((u, radius_in(u, speed)?)));
    if let Some((unit, r)) = own.filter(|(_, r)| RADII.contains(r)) {
        return verdict(unit).because(format!("in {unit} its radius is {r:.3} m"));
    }
    let by_bike = radius.filter(|_| said.is_none()).and_then(|of_bike| {
        let all = SPINS.into_iter().filter_map(|u| Some((u, radius_in(u, speed)?)));
        Some((all.into_iter().find(|(_, r)| like(*r, of_bike))?, of_bike))
    });
    if let Some(((unit, r), of_bike)) = by_bike {
        let why = format!("in {unit} its radius is {r:.3} m, the bike file's is {of_bike:.3} m");
        return verdict(unit).because(why);
    }
    let unit = said.or(of_wheels(speed).map(|w| w.0)).unwrap_or("?");
    // nothing is known of the number of teeth: a map that brings it is not objected to
    let guess = Verdict { confirmed: false, ..verdict(unit) };
    guess.doubted(uncounted(said, speed, radius))
}

/// The doubt of a spin whose unit, or number of pulses a turn, only its owner knows.
fn uncounted(said: Option<&str>, speed: &Speed, radius: Option<f64>) -> String {
    let seen = match said.map(|unit| (unit, radius_in(unit, speed))) {
        Some((unit, Some(r))) => format!("in {unit} its radius would be {r:.4} m, of no wheel"),
        Some((unit, None)) => format!("{:.3} of its {unit} are 1 m/s", speed.slope),
        None => "the log does not say its unit".to_owned(),
    };
    let spin = said.filter(|unit| radius_in(unit, speed).is_some()).unwrap_or("Hz");
    // turns of the source per turn of a wheel of that radius
    let pulses = |r: f64| r / radius_in(spin, speed).unwrap_or(f64::NAN);
    let count = match radius {
        Some(r) => format!("about {:.1} by the bike file's radius", pulses(r)),
        None => format!("{:.1} to {:.1} by wheels' radii", pulses(RADII.start), pulses(RADII.end)),
    };
    let other = of_wheels(speed).filter(|(_, r)| radius.is_none_or(|of_bike| like(*r, of_bike)));
    let other = other.map_or(String::new(), |(unit, r)| {
        format!("; or it is in {unit}, with a radius of {r:.3} m")
    });
    format!(
        "{seen}: how many teeth or pulses has a turn of the wheel? Put in `unit`, and that number as `ratio`: in {spin} \
         it is {count}{other}"
    )
}

fn with_radius(verdict: Verdict, unit: &Unit, speed: &Speed, radius: Option<f64>) -> Verdict {
    let factor = units::conversion("m/s", &unit.name).map_or(1.0, |c| c.factor);
    let ratio = speed.slope / factor;
    let mut v = verdict.because(format!(
        "a surface speed in {}, {:+.1} % off the ground's",
        unit.name,
        100.0 * (ratio - 1.0)
    ));
    if let Some(not) = &unit.not {
        v = v.because(format!("not in {not}, as the log says"));
    }
    match radius {
        Some(radius) => {
            v.radius = Some(radius);
            v.because("its radius is the bike file's: better is the circumference set in the logger over 2 pi")
        }
        None => {
            v.radius = Some(0.3);
            v.doubted(RADIUS)
        }
    }
}

/// The doubt that only a radius takes away.
pub(crate) const RADIUS: &str =
    "a speed: with which radius did the logger compute it? put it in, or give --bike";

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel of 0.3 m is 31.83 rpm per m/s, and with 54 teeth 28.65 pulses a second.
    #[test]
    fn a_radius_alone_proves_no_unit() {
        let of = |said: Option<&str>, slope: f64, radius: Option<f64>| {
            let verdict = |unit: &str| Verdict {
                confirmed: true,
                ..Verdict::new(Channel::WheelSpeedFront, 0, unit)
            };
            spinning(verdict, &Speed { place: 0, slope, r: 1.0 }, said, radius)
        };
        let (rpm, teeth) = (31.83, 28.65);
        for sure in [of(Some("rpm"), rpm, None), of(None, rpm, Some(0.295))] {
            assert_eq!((sure.unit.as_str(), &sure.doubt), ("rpm", &None));
        }
        // in rpm the radius would be 0.333 m
        for (said, radius) in [
            (Some("Hz"), None),
            (Some("Hz"), Some(0.33)),
            (None, None),
            (None, Some(0.3)),
            (Some("km/h"), None),
        ] {
            let guess = of(said, teeth, radius);
            let doubt = guess.doubt.expect("a guess");
            assert!(doubt.contains("`ratio`") && !guess.confirmed, "{said:?}: {doubt}");
            assert_eq!(guess.unit, said.unwrap_or("rpm"));
        }
        assert!(of(Some("Hz"), teeth, Some(0.3)).doubt.is_some_and(|d| d.contains("about 54.0")));
    }
}
