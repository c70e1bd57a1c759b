//! Positions on the earth, WGS 84: what `latitude` and `longitude` (degrees) are in metres.
//!
//! A sphere of the mean radius is wrong by up to 0.6 % from north to south and 0.3 % from east to west, which is
//! more than satellites' speeds are.
//!
//! Source: NGA.STND.0036 (2014), "World Geodetic System 1984", tables 3.1 and 3.3.

/// Radius of the equator, m.
const EQUATOR_RADIUS_M: f64 = 6_378_137.0;
/// First eccentricity, squared.
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;

/// Metres of a degree to the north and to the east at a latitude in degrees.
pub fn metres_per_degree(latitude: f64) -> [f64; 2] {
    let (sin, cos) = latitude.to_radians().sin_cos();
    let flat = 1.0 - ECCENTRICITY_SQUARED * sin * sin;
    let across = EQUATOR_RADIUS_M / flat.sqrt(); // radius of curvature from east to west
    let along = across * (1.0 - ECCENTRICITY_SQUARED) / flat;
    [along.to_radians(), (across * cos).to_radians()]
}

/// Distance between two positions (degrees north and east) that are near each other, m.
pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [north, east] = metres_per_degree(0.5 * (a[0] + b[0]));
    (north * (b[0] - a[0])).hypot(east * east_of(a[1], b[1]))
}

/// Degrees from one longitude to another to the east, over the date line where that is nearer.
pub(crate) fn east_of(from: f64, to: f64) -> f64 {
    (to - from + 540.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_as_long_as_in_the_tables() {
        // Snyder (1987), "Map Projections: A Working Manual", table 4, on WGS 84 within a metre
        for (latitude, north, east) in
            [(0.0, 110_574.0, 111_320.0), (45.0, 111_132.0, 78_847.0), (60.0, 111_412.0, 55_800.0)]
        {
            let [n, e] = metres_per_degree(latitude);
            assert!((n - north).abs() < 1.0 && (e - east).abs() < 1.0, "{latitude}: {n}, {e}");
        }
    }

    #[test]
    fn the_way_over_the_date_line_is_short() {
        let way = distance([0.0, 179.9995], [0.0, -179.9995]);
        assert!((way - 111.32).abs() < 0.01, "{way}");
    }
}
