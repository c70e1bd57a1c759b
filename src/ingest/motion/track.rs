//! Speeds of a satellite track.

use crate::contract::geodesy::distance;

/// Speeds are compared over stretches of at least this, s: positions are rounded.
const STRETCH: f64 = 1.0;
/// Longest stretch; beyond it the receiver was away, s.
const LONGEST: f64 = 3.0;
/// Slowest speed that is compared, m/s.
const SLOWEST: f64 = 3.0;
/// Fewest stretches that tell anything.
const MIN_STRETCHES: usize = 20;

/// How many times the speed of the positions in m/s a column of speeds is; `None` if they tell too little.
///
/// `position` is latitude and longitude in degrees.
pub(crate) fn ratio(time: &[f64], position: [&[f64]; 2], speed: &[f64]) -> Option<f64> {
    let at = |i: usize| [position[0][i], position[1][i]];
    let mut ratios = Vec::new();
    let mut from = 0;
    for i in 0..time.len() {
        let step = time[i] - time[from];
        if step < STRETCH {
            continue;
        }
        let there = distance(at(from), at(i)) / step;
        let within: Vec<f64> = speed[from..=i].iter().copied().filter(|v| v.is_finite()).collect();
        if step < LONGEST && there > SLOWEST && !within.is_empty() {
            ratios.push(within.iter().sum::<f64>() / within.len() as f64 / there);
        }
        from = i;
    }
    if ratios.len() < MIN_STRETCHES {
        return None;
    }
    crate::statistics::order::upper_median(&mut ratios)
}

/// Shortest way between two positions that are compared with a speed, m: they are rounded.
const HOP: f64 = 8.0;
/// Longest; beyond it the receiver was away.
const LONGEST_HOP: f64 = 300.0;

/// Rows that are looked at, about: more would not say more.
const LOOKED_AT: usize = 20_000;

/// How many seconds a unit of the stamps is, by the way between the positions and the speed there in m/s; `None` if too
/// little moves. Any clock will do, however wrong its unit.
pub(crate) fn clock_factor(time: &[f64], position: [&[f64]; 2], speed: &[f64]) -> Option<f64> {
    let mut factors = Vec::new();
    let (mut from, mut sum, mut count) = (None::<usize>, 0.0, 0.0);
    for i in (0..time.len()).step_by((time.len() / LOOKED_AT).max(1)) {
        let (at, v) = ([position[0][i], position[1][i]], speed[i]);
        if !(at[0].is_finite() && at[1].is_finite() && v.is_finite() && time[i].is_finite()) {
            from = None;
            continue;
        }
        let Some(start) = from else {
            (from, sum, count) = (Some(i), v.abs(), 1.0);
            continue;
        };
        (sum, count) = (sum + v.abs(), count + 1.0);
        let way = distance([position[0][start], position[1][start]], at);
        if way < HOP {
            // a stop says nothing, however long
            if v.abs() < 0.2 * sum / count {
                from = None;
            }
            continue;
        }
        let (passed, mean) = (time[i] - time[start], sum / count);
        if way < LONGEST_HOP && passed > 0.0 && mean > 0.0 {
            factors.push(way / (mean * passed));
        }
        (from, sum, count) = (Some(i), v.abs(), 1.0);
    }
    if factors.len() < MIN_STRETCHES / 2 {
        return None;
    }
    crate::statistics::order::upper_median(&mut factors)
}

/// The middle of the speeds while it moves, whatever their unit.
pub(crate) fn middle_speed(speed: &[f64]) -> Option<f64> {
    let most = speed.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut moving: Vec<f64> = speed.iter().map(|v| v.abs()).filter(|v| *v > 0.05 * most).collect();
    crate::statistics::order::upper_median(&mut moving)
}

/// No ride is so long, degrees: a coordinate of 0 that is this far from every other is none.
const AWAY: f64 = 3.0;

/// Takes positions out that no receiver gave: 0 or the pole before the first fix, and what is on no globe. How many they are.
pub(crate) fn without_fix(latitude: &mut [f64], longitude: &mut [f64]) -> usize {
    // some write one of them alone; only near the equator or Greenwich it is a place
    let is_far = |values: &[f64]| {
        let mut others = values.iter().filter(|v| v.is_finite() && **v != 0.0).peekable();
        others.peek().is_some() && others.all(|v| v.abs() > AWAY)
    };
    let (north_far, east_far) = (is_far(latitude), is_far(longitude));
    let mut count = 0;
    for (north, east) in latitude.iter_mut().zip(longitude) {
        let zero = match (*north == 0.0, *east == 0.0) {
            (true, true) => true,
            (true, false) => north_far,
            (false, true) => east_far,
            (false, false) => false,
        };
        if zero || north.abs() >= 90.0 || east.abs() > 360.0 {
            (*north, *east) = (f64::NAN, f64::NAN);
            count += 1;
        }
    }
    count
}

/// Speed at each stamp from the positions about it, m/s: over at most `span` to both sides.
///
/// NaN where no position is near. Repeated positions of a receiver slower than the rows must be
/// gone before.
pub(crate) fn speed(time: &[f64], position: [&[f64]; 2], span: f64) -> Vec<f64> {
    let known = |i: &usize| position.iter().all(|p| p[*i].is_finite()) && time[*i].is_finite();
    let there: Vec<usize> = (0..time.len()).filter(known).collect();
    let mut out = vec![f64::NAN; time.len()];
    for (k, &i) in there.iter().enumerate() {
        // the neighbours on either side: at least one, and as many as lie within the span
        let near = |j: usize| (time[there[j]] - time[i]).abs() <= span;
        let mut first = k.saturating_sub(1);
        while first > 0 && near(first - 1) {
            first -= 1;
        }
        let mut last = (k + 1).min(there.len() - 1);
        while last + 1 < there.len() && near(last + 1) {
            last += 1;
        }
        // as far to one side as to the other, or a speed that changes would be late
        let reach = (k - first).min(last - k).max(usize::from(first == k || last == k));
        let (a, b) = (k.saturating_sub(reach), (k + reach).min(there.len() - 1));
        let path: f64 = (a..b)
            .map(|j| {
                let (p, q) = (there[j], there[j + 1]);
                distance([position[0][p], position[1][p]], [position[0][q], position[1][q]])
            })
            .sum();
        let step = time[there[b]] - time[there[a]];
        if step > 0.0 && step <= LONGEST.max(4.0 * span) {
            out[i] = path / step;
        }
    }
    out
}

/// A start line from the numbers that a text gives for it, as latitude and longitude of its two ends, degrees. Programs
/// write longitude or latitude first, in minutes of arc or degrees, and west or east positive: it is the first of these
/// that lies within 100 m of the ride. `at` are latitudes and longitudes of the ride, degrees.
pub(crate) fn start_line(numbers: &[f64], at: [&[f64]; 2]) -> Option<[[f64; 2]; 2]> {
    /// 100 m, in degrees of latitude.
    const NEAR_DEGREES: f64 = 1e-3;
    let &[a, b, c, d, ..] = numbers else { return None };
    let passed = |line: &[[f64; 2]; 2]| {
        let [lat, lon] = [0, 1].map(|k| 0.5 * (line[0][k] + line[1][k]));
        let shrink = lat.to_radians().cos();
        let near = |(n, e): (&f64, &f64)| (n - lat).hypot((e - lon) * shrink) < NEAR_DEGREES;
        lat.abs() <= 90.0 && at[0].iter().zip(at[1]).any(near)
    };
    let mut written = [1.0 / 60.0, 1.0].into_iter().flat_map(|scale| {
        [-scale, scale].into_iter().flat_map(move |sign| {
            [[[b, a], [d, c]], [[a, b], [c, d]]]
                .map(|line| line.map(|[lat, lon]| [lat * scale, lon * sign]))
        })
    });
    written.find(passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Degrees of a metre to the north and to the east at 50 degrees (of WGS 84: 111 229.0 m and 71 695.7 m per degree).
    const METRE: [f64; 2] = [1.0 / 111_229.0, 1.0 / 71_695.7];

    /// A circle of 100 m radius at 20 m/s, 10 Hz.
    fn circle(n: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..n).map(|i| i as f64 * 0.1).collect();
        let north = |t: &f64| 50.0 + METRE[0] * 100.0 * (0.2 * t).cos();
        let east = |t: &f64| 13.0 + METRE[1] * 100.0 * (0.2 * t).sin();
        (time.clone(), time.iter().map(north).collect(), time.iter().map(east).collect())
    }

    #[test]
    fn the_speed_of_a_circle() {
        let (time, north, east) = circle(400);
        let speed = speed(&time, [&north, &east], 0.25);
        assert!(speed.iter().all(|v| (v - 20.0).abs() < 0.02), "{speed:?}");
        let kmh = vec![72.0; time.len()];
        let ratio = ratio(&time, [&north, &east], &kmh).expect("enough");
        assert!((ratio - 3.6).abs() < 0.03, "{ratio}");
    }

    #[test]
    fn a_speed_that_grows_is_not_late() {
        let time: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.1).collect();
        let north: Vec<f64> = time.iter().map(|t| 50.0 + METRE[0] * (5.0 * t + t * t)).collect();
        let speed = speed(&time, [&north, &vec![8.0; 200]], 0.5);
        for i in 5..190 {
            assert!((speed[i] - (5.0 + 2.0 * time[i])).abs() < 0.02, "{i}: {}", speed[i]);
        }
    }

    #[test]
    fn a_clock_of_any_unit_is_found() {
        let (time, north, east) = circle(400);
        let speed = vec![20.0; 400];
        for unit in [1.0, 1e-3, 60.0, 1e-9] {
            let stamps: Vec<f64> = time.iter().map(|t| 7e3 + t / unit).collect();
            let found = clock_factor(&stamps, [&north, &east], &speed).expect("it moves");
            assert!((found / unit - 1.0).abs() < 0.03, "{unit}: {found}");
        }
        let still = vec![45.0; 400];
        assert_eq!(clock_factor(&time, [&still, &still], &speed), None);
    }

    #[test]
    fn no_fix_is_no_position() {
        let (mut north, mut east) =
            (vec![0.0, 47.0, 0.0, 9999.0, 90.0], vec![0.0, 8.0, 8.0, 9999.0, 180.0]);
        assert_eq!(without_fix(&mut north, &mut east), 4);
        assert!(north[4].is_nan());
        assert!(north[0].is_nan() && east[3].is_nan() && north[2].is_nan() && east[1] == 8.0);
        // along the equator
        let (mut north, mut east) = (vec![0.1, 0.0, -0.1], vec![8.0, 8.1, 8.2]);
        assert_eq!(without_fix(&mut north, &mut east), 0);
    }

    #[test]
    fn what_stands_still_tells_nothing() {
        let time: Vec<f64> = (0..200).map(f64::from).collect();
        let at = vec![45.0; 200];
        assert_eq!(ratio(&time, [&at, &at], &vec![0.1; 200]), None);
        let metres = distance([0.0, 179.999_5], [0.0, -179.999_5]);
        assert!((metres - 111.32).abs() < 0.01, "over the date line: {metres} m");
    }
}
