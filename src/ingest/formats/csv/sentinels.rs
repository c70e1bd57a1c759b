//! Numbers that loggers write for "no sample": 9999 and the like.

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::maps::propose::is_called;
use crate::ingest::warning::warning;

/// Sizes of numbers that are written for none.
const NONE: [f64; 15] = [
    999.0,
    999.9,
    9999.0,
    9999.9,
    99_999.0,
    999_999.0,
    9_999_999.0,
    999_999_999.0,
    32_767.0,
    32_768.0,
    65_535.0,
    2_147_483_647.0,
    2_147_483_648.0,
    4_294_967_295.0,
    1e20,
];

/// A number stands for none when it is so many times as far from zero as every other.
const FAR: f64 = 3.0;

/// Fewest other numbers by which that is seen.
const FEW: usize = 10;

/// The number of a column that stands for none, and how often it is there.
pub(super) fn of(values: &[f64]) -> Option<(f64, usize)> {
    // the largest size, and the largest of the others
    let (mut most, mut next, mut count, mut others) = (0.0_f64, 0.0_f64, 0, 0);
    for size in values.iter().map(|v| v.abs()) {
        if size > most {
            (next, others, most, count) = (most, others + count, size, 1);
        } else if size == most {
            count += 1;
        } else if size <= most {
            next = next.max(size);
            others += 1;
        }
    }
    let known = NONE.contains(&most) || most > 1e30;
    (known && others >= FEW && most > FAR * next).then_some((most, count))
}

/// No ride is so long, degrees: a coordinate of -1 that is this far from every other is none.
const AWAY: f64 = 3.0;

/// How often a coordinate is -1 for none.
fn minus_one(values: &[f64]) -> Option<usize> {
    let there = || values.iter().filter(|v| v.is_finite());
    let count = there().filter(|v| **v == -1.0).count();
    let others = || there().filter(|v| **v != -1.0 && **v != 0.0);
    let far = count > 0 && others().count() >= FEW && others().all(|v| (v + 1.0).abs() > AWAY);
    far.then_some(count)
}

/// Takes such numbers out of columns.
pub(super) fn take_out(names: &[&str], columns: &mut [Vec<f64>], warnings: &mut Vec<Warning>) {
    for (name, column) in names.iter().zip(columns) {
        let place = || [Channel::Latitude, Channel::Longitude].iter().any(|c| is_called(name, *c));
        let alone = || minus_one(column).filter(|_| place()).map(|count| (-1.0, count));
        let Some((size, count)) = of(column).or_else(alone) else { continue };
        let none = |v: f64| if size < 0.0 { v == size } else { v.abs() == size };
        column.iter_mut().filter(|v| none(**v)).for_each(|v| *v = f64::NAN);
        let message = format!(
            "column `{name}`: {count} cells are {size}, far from every other number; taken as missing"
        );
        warnings.push(warning("no_sample", None, count, None, message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_none_are_far_from_the_others() {
        let with = |x: f64| {
            let mut values: Vec<f64> = (0..50).map(f64::from).collect();
            values[7] = x;
            values
        };
        assert_eq!(of(&with(9999.0)), Some((9999.0, 1)));
        assert_eq!(of(&with(-9999.0)), Some((9999.0, 1)));
        assert_eq!(of(&with(65_535.0)), Some((65_535.0, 1)));
        assert_eq!(of(&with(1234.0)), None, "a spike");
        assert_eq!(of(&with(f64::NAN)), None);
        let rpm: Vec<f64> = (0..50).map(|i| 9950.0 + f64::from(i)).collect();
        assert_eq!(of(&rpm), None, "9999 is a speed of an engine");
        assert_eq!(of(&[9999.0, 1.0]), None);
    }

    #[test]
    fn minus_one_is_no_place_on_a_ride_elsewhere() {
        let ride = |from: f64| {
            let at = |i: u32| if i.is_multiple_of(9) { -1.0 } else { from + 1e-5 * f64::from(i) };
            (0..90).map(at).collect::<Vec<f64>>()
        };
        let mut columns = [ride(47.0), ride(-1.001), ride(47.0)];
        let mut warnings = Vec::new();
        take_out(&["Latitude (deg)", "Longitude", "Lean"], &mut columns, &mut warnings);
        let gone = columns.map(|c| c.iter().filter(|v| v.is_nan()).count());
        assert_eq!(gone, [10, 0, 0]);
        assert!(warnings.len() == 1 && warnings[0].message.contains("are -1"), "{warnings:?}");
    }
}
