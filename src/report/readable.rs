//! Sizes as people read them: fixed-point, angles in degrees, shares in per cent, short times in ms.

/// Units and what they are read in: SI, shown, factor.
const READ: [(&str, &str, f64); 7] = [
    ("1", " %", 1e2),
    ("rad", "°", 180.0 / std::f64::consts::PI),
    ("s", " ms", 1e3),
    ("m", " mm", 1e3),
    ("s/m", " ms/m", 1e3),
    ("1/kN", " %/kN", 1e2),
    ("rad/N", "°/kN", 180e3 / std::f64::consts::PI),
];

/// The unit that an SI unit is read in, with the blank before it, and the factor to it.
pub(crate) fn unit(si: &str) -> (String, f64) {
    let read = READ.iter().find(|(of, ..)| *of == si);
    read.map_or_else(
        || (format!(" {si}"), 1.0),
        |(_, shown, factor)| ((*shown).to_owned(), *factor),
    )
}

/// A size of an effect with two digits and its unit.
pub(crate) fn size(value: f64, si: &str) -> String {
    let (shown, factor) = unit(si);
    let x = value * factor;
    let decimals = if x == 0.0 || !x.is_finite() { 0.0 } else { 1.0 - x.abs().log10().floor() };
    format!("{x:.*}{shown}", decimals.clamp(0.0, 6.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_are_fixed_point_in_a_persons_units() {
        let of = [(1.75e-3, "1"), (5.92e-3, "rad"), (3.06e-3, "s"), (0.308, "m/s"), (9.23, "N m")];
        let said = of.map(|(x, unit)| size(x, unit));
        assert_eq!(said, ["0.18 %", "0.34°", "3.1 ms", "0.31 m/s", "9.2 N m"]);
        assert_eq!(size(10.9, "1"), "1090 %");
        assert_eq!(size(0.0, "m"), "0 mm");
    }
}
