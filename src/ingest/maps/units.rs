//! Units of recorded channels and how they become the contract's.

use crate::contract::key_error::KeyError;

/// One unit: a value `x` in it is `x * factor + offset` in its dimension's base unit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Unit {
    dimension: &'static str,
    factor: f64,
    offset: f64,
}

const DEG: f64 = std::f64::consts::PI / 180.0;
const RPM: f64 = std::f64::consts::PI / 30.0;
const G: f64 = crate::GRAVITY;
const MPH: f64 = 0.44704;
const KNOT: f64 = 1852.0 / 3600.0;
const INCH: f64 = 0.0254;
const PSI: f64 = 6_894.757_293_168;
const FAHRENHEIT: f64 = 5.0 / 9.0;
/// Pound-force, N.
const LBF: f64 = 4.448_221_615;

/// Spelling, dimension, factor, offset. Spellings are compared without case, blanks, `·` and `^`, with
/// `²` as `2`, `°` as `deg` and `µ` as `u`; where case matters (`mPa`) the unit is left out.
#[rustfmt::skip]
const UNITS: &[(&str, &str, f64, f64)] = &[
    ("1", "ratio", 1.0, 0.0), ("", "ratio", 1.0, 0.0), ("-", "ratio", 1.0, 0.0), ("ratio", "ratio", 1.0, 0.0),
    ("none", "ratio", 1.0, 0.0), ("#", "ratio", 1.0, 0.0), ("unitless", "ratio", 1.0, 0.0),
    ("%", "ratio", 0.01, 0.0), ("percent", "ratio", 0.01, 0.0), ("pct", "ratio", 0.01, 0.0), ("%tps", "ratio", 0.01, 0.0),
    ("%open", "ratio", 0.01, 0.0), ("%throttle", "ratio", 0.01, 0.0),
    ("s", "time", 1.0, 0.0), ("sec", "time", 1.0, 0.0), ("secs", "time", 1.0, 0.0), ("second", "time", 1.0, 0.0),
    ("seconds", "time", 1.0, 0.0), ("ms", "time", 1e-3, 0.0), ("msec", "time", 1e-3, 0.0),
    ("milliseconds", "time", 1e-3, 0.0), ("us", "time", 1e-6, 0.0), ("ns", "time", 1e-9, 0.0), ("min", "time", 60.0, 0.0),
    ("h", "time", 3600.0, 0.0), ("hr", "time", 3600.0, 0.0), ("hours", "time", 3600.0, 0.0), ("hour", "time", 3600.0, 0.0),
    ("minute", "time", 60.0, 0.0), ("minutes", "time", 60.0, 0.0), ("mins", "time", 60.0, 0.0), ("day", "time", 86_400.0, 0.0),
    ("days", "time", 86_400.0, 0.0), ("100ns", "time", 1e-7, 0.0), ("10ms", "time", 1e-2, 0.0), ("100us", "time", 1e-4, 0.0),
    ("millis", "time", 1e-3, 0.0), ("millisecond", "time", 1e-3, 0.0), ("usec", "time", 1e-6, 0.0),
    ("micros", "time", 1e-6, 0.0), ("microseconds", "time", 1e-6, 0.0), ("nanoseconds", "time", 1e-9, 0.0),
    ("sek", "time", 1.0, 0.0), ("sekunden", "time", 1.0, 0.0), ("minuten", "time", 60.0, 0.0), ("secondes", "time", 1.0, 0.0),
    ("segundos", "time", 1.0, 0.0), ("secondi", "time", 1.0, 0.0), ("seconden", "time", 1.0, 0.0), ("seg", "time", 1.0, 0.0),
    ("с", "time", 1.0, 0.0), ("мс", "time", 1e-3, 0.0), ("秒", "time", 1.0, 0.0), ("度", "angle", DEG, 0.0),
    ("бар", "pressure", 1e5, 0.0),
    ("m/s", "speed", 1.0, 0.0), ("m/sec", "speed", 1.0, 0.0), ("mps", "speed", 1.0, 0.0), ("ms-1", "speed", 1.0, 0.0),
    ("meters/second", "speed", 1.0, 0.0), ("km/h", "speed", 1.0 / 3.6, 0.0), ("km/hr", "speed", 1.0 / 3.6, 0.0),
    ("kmh", "speed", 1.0 / 3.6, 0.0), ("kph", "speed", 1.0 / 3.6, 0.0), ("kmph", "speed", 1.0 / 3.6, 0.0),
    ("km/u", "speed", 1.0 / 3.6, 0.0), ("км/ч", "speed", 1.0 / 3.6, 0.0), ("м/с", "speed", 1.0, 0.0),
    ("km/std", "speed", 1.0 / 3.6, 0.0), ("k/h", "speed", 1.0 / 3.6, 0.0),
    ("mph", "speed", MPH, 0.0), ("mi/h", "speed", MPH, 0.0), ("miles/h", "speed", MPH, 0.0),
    ("kn", "speed", KNOT, 0.0), ("kt", "speed", KNOT, 0.0), ("kts", "speed", KNOT, 0.0), ("knot", "speed", KNOT, 0.0),
    ("knots", "speed", KNOT, 0.0), ("mm/s", "speed", 1e-3, 0.0), ("cm/s", "speed", 1e-2, 0.0),
    ("ft/s", "speed", 12.0 * INCH, 0.0),
    ("m/s2", "acceleration", 1.0, 0.0), ("m/s/s", "acceleration", 1.0, 0.0), ("m/s**2", "acceleration", 1.0, 0.0),
    ("m/sec2", "acceleration", 1.0, 0.0), ("m/sec/sec", "acceleration", 1.0, 0.0), ("mps2", "acceleration", 1.0, 0.0),
    ("ms-2", "acceleration", 1.0, 0.0), ("m/(s2)", "acceleration", 1.0, 0.0), ("ft/s2", "acceleration", 12.0 * INCH, 0.0),
    ("g", "acceleration", G, 0.0), ("g's", "acceleration", G, 0.0), ("mg", "acceleration", 1e-3 * G, 0.0),
    ("rad", "angle", 1.0, 0.0), ("radian", "angle", 1.0, 0.0), ("radians", "angle", 1.0, 0.0), ("mrad", "angle", 1e-3, 0.0),
    ("grados", "angle", DEG, 0.0), ("gradi", "angle", DEG, 0.0), ("degres", "angle", DEG, 0.0), ("graus", "angle", DEG, 0.0),
    ("graden", "angle", DEG, 0.0), ("stopnie", "angle", DEG, 0.0), ("degrés", "angle", DEG, 0.0),
    ("centideg", "angle", 1e-2 * DEG, 0.0), ("cdeg", "angle", 1e-2 * DEG, 0.0), ("decideg", "angle", 0.1 * DEG, 0.0),
    ("ddeg", "angle", 0.1 * DEG, 0.0), ("mdeg", "angle", 1e-3 * DEG, 0.0),
    ("deg", "angle", DEG, 0.0), ("degs", "angle", DEG, 0.0), ("degree", "angle", DEG, 0.0), ("degrees", "angle", DEG, 0.0),
    ("rad/s", "angular rate", 1.0, 0.0), ("rad/sec", "angular rate", 1.0, 0.0), ("rads-1", "angular rate", 1.0, 0.0),
    ("mrad/s", "angular rate", 1e-3, 0.0), ("deg/s", "angular rate", DEG, 0.0), ("deg/sec", "angular rate", DEG, 0.0),
    ("degs/s", "angular rate", DEG, 0.0), ("degree/s", "angular rate", DEG, 0.0), ("degrees/s", "angular rate", DEG, 0.0),
    ("degs-1", "angular rate", DEG, 0.0), ("dps", "angular rate", DEG, 0.0), ("rpm", "angular rate", RPM, 0.0),
    ("r/min", "angular rate", RPM, 0.0), ("rev/min", "angular rate", RPM, 0.0), ("u/min", "angular rate", RPM, 0.0), ("upm", "angular rate", RPM, 0.0),
    ("tr/min", "angular rate", RPM, 0.0), ("giri/min", "angular rate", RPM, 0.0), ("obr/min", "angular rate", RPM, 0.0),
    ("1/min", "angular rate", RPM, 0.0), ("min-1", "angular rate", RPM, 0.0), ("rev/s", "angular rate", 60.0 * RPM, 0.0),
    ("mdps", "angular rate", 1e-3 * DEG, 0.0), ("mdeg/s", "angular rate", 1e-3 * DEG, 0.0), ("deg/min", "angular rate", DEG / 60.0, 0.0),
    ("degrees/min", "angular rate", DEG / 60.0, 0.0), ("deg/h", "angular rate", DEG / 3600.0, 0.0),
    ("rps", "angular rate", 60.0 * RPM, 0.0), ("hz", "angular rate", 60.0 * RPM, 0.0),
    ("pa", "pressure", 1.0, 0.0), ("hpa", "pressure", 1e2, 0.0), ("kpa", "pressure", 1e3, 0.0),
    ("bar", "pressure", 1e5, 0.0), ("barg", "pressure", 1e5, 0.0), ("mbar", "pressure", 1e2, 0.0), ("mb", "pressure", 1e2, 0.0),
    ("dbar", "pressure", 1e4, 0.0), ("decibar", "pressure", 1e4, 0.0), ("kgf/cm2", "pressure", 1e4 * G, 0.0),
    ("kg/cm2", "pressure", 1e4 * G, 0.0), ("kp/cm2", "pressure", 1e4 * G, 0.0),
    ("psi", "pressure", PSI, 0.0), ("psig", "pressure", PSI, 0.0), ("n/m2", "pressure", 1.0, 0.0),
    ("m", "length", 1.0, 0.0), ("meter", "length", 1.0, 0.0), ("metre", "length", 1.0, 0.0), ("meters", "length", 1.0, 0.0),
    ("metres", "length", 1.0, 0.0), ("cm", "length", 1e-2, 0.0), ("mm", "length", 1e-3, 0.0), ("um", "length", 1e-6, 0.0),
    ("km", "length", 1e3, 0.0), ("ft", "length", 12.0 * INCH, 0.0), ("feet", "length", 12.0 * INCH, 0.0),
    ("in", "length", INCH, 0.0), ("inch", "length", INCH, 0.0), ("mile", "length", 5280.0 * 12.0 * INCH, 0.0),
    ("miles", "length", 5280.0 * 12.0 * INCH, 0.0),
    ("degc", "temperature", 1.0, 0.0), ("c", "temperature", 1.0, 0.0), (".c", "temperature", 1.0, 0.0),
    ("celsius", "temperature", 1.0, 0.0), ("k", "temperature", 1.0, -273.15), ("kelvin", "temperature", 1.0, -273.15),
    ("degf", "temperature", FAHRENHEIT, -32.0 * FAHRENHEIT), (".f", "temperature", FAHRENHEIT, -32.0 * FAHRENHEIT),
    ("f", "temperature", FAHRENHEIT, -32.0 * FAHRENHEIT), ("fahrenheit", "temperature", FAHRENHEIT, -32.0 * FAHRENHEIT),
    ("n", "force", 1.0, 0.0), ("dan", "force", 10.0, 0.0), ("kgf", "force", G, 0.0), ("lbf", "force", LBF, 0.0),
    ("nm", "torque", 1.0, 0.0), ("newtonmeter", "torque", 1.0, 0.0), ("knm", "torque", 1e3, 0.0),
    ("lbft", "torque", LBF * 12.0 * INCH, 0.0), ("ftlb", "torque", LBF * 12.0 * INCH, 0.0),
    // of no column: what is measured in them is none of its candidates
    ("l", "volume", 1e-3, 0.0), ("litre", "volume", 1e-3, 0.0), ("liter", "volume", 1e-3, 0.0), ("ml", "volume", 1e-6, 0.0),
    ("cc", "volume", 1e-6, 0.0), ("l/h", "volume flow", 1e-3 / 3600.0, 0.0), ("l/hr", "volume flow", 1e-3 / 3600.0, 0.0),
    ("l/min", "volume flow", 1e-3 / 60.0, 0.0), ("cc/min", "volume flow", 1e-6 / 60.0, 0.0),
    ("g/s", "mass flow", 1e-3, 0.0), ("kg/h", "mass flow", 1.0 / 3600.0, 0.0), ("kg", "mass", 1.0, 0.0),
    ("v", "voltage", 1.0, 0.0), ("volt", "voltage", 1.0, 0.0), ("volts", "voltage", 1.0, 0.0), ("mv", "voltage", 1e-3, 0.0),
    ("a", "current", 1.0, 0.0), ("ma", "current", 1e-3, 0.0), ("w", "power", 1.0, 0.0), ("kw", "power", 1e3, 0.0), ("hp", "power", 745.699_871_582_270_2, 0.0),
];

/// From one unit to another: `y = x * factor + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    pub factor: f64,
    /// Offset, in the target unit.
    pub offset: f64,
}

impl Conversion {
    /// Leaves values as they are.
    pub const IDENTITY: Conversion = Conversion { factor: 1.0, offset: 0.0 };

    pub fn is_identity(self) -> bool {
        self == Self::IDENTITY
    }
}

/// How a value in unit `from` becomes one in unit `to`.
///
/// # Errors
/// A sentence that names the unit and lists those that would do.
pub(crate) fn conversion(from: &str, to: &str) -> Result<Conversion, KeyError> {
    if from == to {
        return Ok(Conversion::IDENTITY);
    }
    let target = lookup(to).ok_or_else(|| KeyError::Values(format!("unknown unit `{to}`")))?;
    if from.trim() == "kN" && target.dimension == "force" {
        // without case it is the spelling of knots
        return Ok(Conversion { factor: 1e3 / target.factor, offset: 0.0 });
    }
    let source = lookup(from).ok_or_else(|| {
        KeyError::Values(format!("unknown unit `{from}`; known are {}", known(target.dimension)))
    })?;
    if source.dimension != target.dimension {
        return Err(KeyError::Values(format!(
            "unit `{from}` measures {}, not {}; known are {}",
            source.dimension,
            target.dimension,
            known(target.dimension)
        )));
    }
    Ok(Conversion {
        factor: source.factor / target.factor,
        offset: (source.offset - target.offset) / target.factor,
    })
}

/// Whether two spellings mean the same unit; `None` if one of them is unknown.
pub fn same(a: &str, b: &str) -> Option<bool> {
    if a == b {
        return Some(true);
    }
    Some(lookup(a)? == lookup(b)?)
}

/// Quantity of a unit (`speed`, `angle`, ...); `None` if it is unknown.
pub(crate) fn dimension(unit: &str) -> Option<&'static str> {
    lookup(unit).map(|u| u.dimension)
}

/// A column's name without the unit that ends it in brackets, and that unit: `Speed (km/h)` is `Speed` in `km/h`.
/// What stands in the brackets and is no unit belongs to the name.
pub(crate) fn of_name(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    let within = |open: char, close: char| {
        let (before, unit) = name.strip_suffix(close)?.rsplit_once(open)?;
        let unit = unit.trim();
        // a letter may be a place as well: front, left
        let place =
            matches!(unit, "A" | "F" | "L" | "N") && !before.to_lowercase().contains("temp");
        (!unit.is_empty() && !before.trim().is_empty() && !place && lookup(unit).is_some())
            .then(|| (before.trim_end_matches([' ', '_']), Some(unit)))
    };
    [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')]
        .into_iter()
        .find_map(|(open, close)| within(open, close))
        .unwrap_or((name, None))
}

/// Text within brackets, if anything does: `[km/h]` in a row of units.
pub(crate) fn of_brackets(text: &str) -> &str {
    let text = text.trim();
    let within = |open: char, close: char| text.strip_prefix(open)?.strip_suffix(close);
    [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')]
        .into_iter()
        .find_map(|(open, close)| within(open, close))
        .map_or(text, str::trim)
}

/// The unit that a name says without brackets: as its last word (`speed_kmh`, `Lean deg`, `v - m/s`), or because the
/// name is nothing but a unit (`Km/h`). Letters that may be places or axes are none.
pub(crate) fn behind_name(name: &str) -> Option<&'static str> {
    let mut plain = String::with_capacity(name.len() + 4);
    let mut last = ' ';
    for c in name.trim().chars() {
        let letter = c.is_alphanumeric() || matches!(c, '%' | '°' | '²');
        if letter && c.is_uppercase() && last.is_lowercase() {
            plain.push('_');
        }
        match letter {
            true => plain.extend(c.to_lowercase()),
            false if !plain.ends_with('_') => plain.push('_'),
            false => {}
        }
        last = c;
    }
    let plain = plain.trim_end_matches('_');
    let after = |end: &str| {
        let before = plain.strip_suffix(end)?;
        (before.is_empty() || before.ends_with('_')).then_some(before)
    };
    let (end, unit) = BEHIND.iter().find(|(end, _)| after(end).is_some())?;
    // alone they are words of their own
    let alone = plain.len() == end.len() && dimension(unit) != Some("speed");
    (!alone).then_some(*unit)
}

/// How names end that say a unit, the longest first.
#[rustfmt::skip]
const BEHIND: &[(&str, &str)] = &[
    ("km_per_h", "km/h"), ("km_h", "km/h"), ("kmh", "km/h"), ("kph", "km/h"), ("kmph", "km/h"), ("mph", "mph"), ("knots", "knots"),
    ("kts", "knots"), ("m_s_2", "m/s2"), ("m_s2", "m/s2"), ("m_s²", "m/s2"), ("mps2", "m/s2"), ("mss", "m/s2"), ("ms2", "m/s2"),
    ("rad_s", "rad/s"), ("rads", "rad/s"), ("radps", "rad/s"), ("deg_s", "deg/s"), ("degs", "deg/s"), ("degps", "deg/s"),
    ("dps", "deg/s"), ("°_s", "deg/s"), ("m_s", "m/s"), ("mps", "m/s"), ("rpm", "rpm"), ("degrees", "deg"), ("deg", "deg"),
    ("°", "deg"), ("radians", "rad"), ("rad", "rad"), ("mbar", "mbar"), ("bar", "bar"), ("kpa", "kPa"), ("psi", "psi"),
    ("percent", "%"), ("pct", "%"), ("%", "%"), ("degc", "degC"), ("degf", "degF"), ("celsius", "degC"), ("mm", "mm"),
];

/// The known spellings of a dimension, for messages.
fn known(dimension: &str) -> String {
    let names: Vec<&str> =
        UNITS.iter().filter(|u| u.1 == dimension && !u.0.is_empty()).map(|u| u.0).collect();
    names.join(", ")
}

fn lookup(text: &str) -> Option<Unit> {
    // only its case tells it from mPa, which nobody rides with
    if text.trim() == "MPa" {
        return Some(Unit { dimension: "pressure", factor: 1e6, offset: 0.0 });
    }
    let text: String =
        text.chars().filter(|c| !(c.is_whitespace() || matches!(c, '·' | '^'))).collect();
    let text = text.to_lowercase().replace('²', "2").replace('¹', "1").replace('⁻', "-");
    let text = text.replace('°', "deg").replace(['µ', 'μ'], "u");
    listed(&text).or_else(|| scaled(&text))
}

fn listed(text: &str) -> Option<Unit> {
    let &(_, dimension, factor, offset) = UNITS.iter().find(|u| u.0 == text)?;
    Some(Unit { dimension, factor, offset })
}

/// A fraction of a unit, as loggers write that keep whole numbers: `0.1km/h`, `0.01 deg`, `1e-7deg`. A number that is no
/// fraction is a sensor's range (`16 g`), and none.
fn scaled(text: &str) -> Option<Unit> {
    let places = text.char_indices().map(|(i, _)| i).skip(1);
    places.filter(|&i| text[..i].ends_with(|c: char| c.is_ascii_digit())).find_map(|i| {
        let share: f64 = text[..i].replace(',', ".").parse().ok()?;
        let unit = listed(text[i..].trim_start_matches(['*', 'x', '×']))?;
        let is_fraction = share > 0.0 && share < 1.0 && unit.dimension != "ratio";
        (is_fraction && unit.offset == 0.0).then_some(Unit { factor: share * unit.factor, ..unit })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::schema::Table;

    fn convert(x: f64, from: &str, to: &str) -> f64 {
        let c = conversion(from, to).expect(from);
        x * c.factor + c.offset
    }

    #[test]
    fn textbook_values() {
        let cases = [
            (36.0, "km/h", "m/s", 10.0),
            (1.0, "kn", "m/s", 0.514_444_444_444),
            (60.0, "mph", "m/s", 26.8224),
            (180.0, "°", "rad", std::f64::consts::PI),
            (60.0, "rpm", "rad/s", std::f64::consts::TAU),
            (1.0, "g", "m/s²", 9.80665),
            (2.5, "bar", "Pa", 250_000.0),
            (212.0, "degF", "degC", 100.0),
            (-40.0, "degF", "degC", -40.0),
            (293.15, "K", "degC", 20.0),
            (50.0, "%", "1", 0.5),
            (39.27, "deg", "deg", 39.27),
            (std::f64::consts::PI, "rad", "deg", 180.0),
            (1500.0, "µs", "s", 0.0015),
            (1.0, "psi", "Pa", 6_894.757),
            (2.0, "m/s/s", "m/s²", 2.0),
            (2.0, "m/s^2", "m/s²", 2.0),
            (2.0, "m·s⁻²", "m/s²", 2.0),
            (2.0, "m s^-2", "m/s²", 2.0),
            (90.0, "sec", "min", 1.5),
            (7.2, "km/hr", "m/s", 2.0),
            (30.0, "U/min", "rad/s", std::f64::consts::PI),
            (30.0, "Upm", "rad/s", std::f64::consts::PI),
            (50.0, "°/s", "deg/s", 50.0),
            (212.0, "°F", "°C", 100.0),
            (1013.25, "mbar", "kPa", 101.325),
            (25.0, "%TPS", "1", 0.25),
            (3.6, "l/h", "cc/min", 60.0),
            (2.5, "litre", "l", 2.5),
            (1.0, "mile", "km", 1.609_344),
            (2.5, "MPa", "bar", 25.0),
            (250.0, "dbar", "bar", 25.0),
            (1.0, "kgf/cm2", "Pa", 98_066.5),
            (1500.0, "centideg", "deg", 15.0),
            (1500.0, "mdps", "deg/s", 1.5),
            (541.0, "0.1 km/h", "km/h", 54.1),
            (1500.0, "0.01deg", "deg", 15.0),
            (4.7e8, "1e-7 deg", "deg", 47.0),
            (250.0, "0,1 bar", "bar", 25.0),
            (125.0, "0.02bar", "bar", 2.5),
            (90.0, "deg/min", "deg/s", 1.5),
        ];
        for (x, from, to, y) in cases {
            let got = convert(x, from, to);
            assert!((got - y).abs() < 1e-6 * y.abs().max(1.0), "{x} {from} -> {got} {to}, not {y}");
        }
    }

    #[test]
    fn every_unit_of_the_contract_is_known() {
        for column in Table::embedded("session").columns {
            let unit = column.unit.expect("a unit");
            assert!(lookup(&unit).is_some(), "{}: {unit}", column.name);
        }
    }

    #[test]
    fn wrong_units_are_named_with_those_that_would_do() {
        let message = conversion("furlong", "m/s").expect_err("unknown").to_string();
        assert!(message.contains("`furlong`") && message.contains("km/h"), "{message}");
        assert!(message.contains("mph") && !message.contains("rad/s"), "{message}");
        let message = conversion("deg", "m/s").expect_err("mixed").to_string();
        assert!(message.contains("angle"), "{message}");
    }

    /// Ranges of sensors and numbers of channels are no units.
    #[test]
    fn only_a_fraction_scales_a_unit() {
        for none in
            ["16 g", "2g", "0.1", "0.1 F/R", "-0.1 bar", "0 bar", "0.1 degC x", "infdeg", "1 %"]
        {
            assert_eq!(dimension(none), None, "{none}");
        }
        assert_eq!(of_name("Lean (0.1 deg)"), ("Lean", Some("0.1 deg")));
    }

    #[test]
    fn a_unit_may_be_the_last_word_of_a_name() {
        for (name, unit) in [
            ("speed_kmh", Some("km/h")),
            ("Speed km/h", Some("km/h")),
            ("Km/h", Some("km/h")),
            ("GPS Speed - m/s", Some("m/s")),
            ("speed_m_s", Some("m/s")),
            ("LeanDeg", Some("deg")),
            ("Lean °", Some("deg")),
            ("yaw_rate_deg_s", Some("deg/s")),
            ("acc_x_m_s2", Some("m/s2")),
            ("front_brake_bar", Some("bar")),
            ("TPS %", Some("%")),
            ("speed", None),
            ("RPM", None),
            ("Engine RPM", Some("rpm")),
            ("handlebar", None),
            ("Grad", None),
            ("acc_x", None),
            ("brake_f", None),
        ] {
            assert_eq!(behind_name(name), unit, "{name}");
        }
    }

    #[test]
    fn a_unit_in_brackets_ends_a_name() {
        for (name, base, unit) in [
            ("Speed (km/h)", "Speed", Some("km/h")),
            ("Time (ms)", "Time", Some("ms")),
            ("TPS (%)", "TPS", Some("%")),
            ("Brake F [bar]", "Brake F", Some("bar")),
            ("Lean(deg)", "Lean", Some("deg")),
            ("Accel X (m/s/s)", "Accel X", Some("m/s/s")),
            ("yaw_rate_[deg/s]", "yaw_rate", Some("deg/s")),
            ("Wheel (front)", "Wheel (front)", None),
            ("Speed (GPS)", "Speed (GPS)", None),
            ("Brake (F)", "Brake (F)", None),
            ("Air Temp (F)", "Air Temp", Some("F")),
            ("(km/h)", "(km/h)", None),
            ("km/h", "km/h", None),
        ] {
            assert_eq!(of_name(name), (base, unit), "{name}");
        }
    }
}
