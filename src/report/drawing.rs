//! Small drawings inside tables, as inline SVG: they need no script and print as they are.

use std::fmt::Write as _;

/// Half the width of the interval bar's axis, as a share of the value.
const REACH: f64 = 0.25;

/// A coefficient's 95 % interval relative to its value: the axis goes a quarter of
/// the value to each side, an arrow marks an end that lies beyond. Empty where there is no scale.
pub fn interval(value: Option<f64>, low: Option<f64>, high: Option<f64>) -> String {
    let (Some(value), Some(low), Some(high)) = (value, low, high) else { return String::new() };
    if value == 0.0 {
        return String::new();
    }
    let (width, mid) = (120.0, 60.0);
    let place = |v: f64| mid + (v - value) / value.abs() / REACH * (mid - 8.0);
    let (left, right) = (place(low), place(high));
    let (x1, x2) = (left.clamp(4.0, width - 4.0), right.clamp(4.0, width - 4.0));
    let mut svg = format!(
        "<svg class=\"interval\" viewBox=\"0 0 {width} 16\" aria-hidden=\"true\">\
         <path class=\"axis\" d=\"M8 8H112M8 5v6M112 5v6M60 4v8\"/>\
         <path class=\"bar\" d=\"M{x1:.1} 8H{x2:.1}\"/>"
    );
    if left < 4.0 {
        svg.push_str("<path class=\"arrow\" d=\"M8 4L3 8L8 12\"/>");
    }
    if right > width - 4.0 {
        svg.push_str("<path class=\"arrow\" d=\"M112 4L117 8L112 12\"/>");
    }
    svg.push_str("<circle class=\"dot\" cx=\"60\" cy=\"8\" r=\"2.6\"/></svg>");
    svg
}

/// One session's estimate in a [`strip`]: value, lower and upper end.
pub type Estimate = (f64, f64, f64);

/// Estimates of many sessions side by side in their order, each with its interval, over a
/// common ordinate; the rule is their median. Empty of fewer than two.
pub fn strip(estimates: &[Estimate], median: f64) -> String {
    if estimates.len() < 2 {
        return String::new();
    }
    let (width, height) = (220.0, 40.0);
    // the ordinate goes by the values: one hopeless interval must not flatten the others
    let mut values: Vec<f64> = estimates.iter().map(|e| e.0).collect();
    values.sort_by(f64::total_cmp);
    let mut halves: Vec<f64> = estimates.iter().map(|e| (e.2 - e.1) / 2.0).collect();
    halves.sort_by(f64::total_cmp);
    let half = halves[halves.len() / 2];
    let (low, high) = (values[0] - 1.3 * half, values[values.len() - 1] + 1.3 * half);
    let range = if high > low { high - low } else { 1.0 };
    let place = |v: f64| (height - 3.0 - (v - low) / range * (height - 6.0)).clamp(0.0, height);
    let step = (width - 8.0) / estimates.len() as f64;
    let (mut whiskers, mut dots) = (String::new(), String::new());
    for (i, (value, lo, hi)) in estimates.iter().enumerate() {
        let x = 4.0 + (i as f64 + 0.5) * step;
        // writing to a String cannot fail
        let _ = write!(whiskers, "M{x:.1} {:.1}V{:.1}", place(*lo), place(*hi));
        let _ = write!(dots, "M{x:.1} {:.1}h0", place(*value));
    }
    let rule = place(median);
    format!(
        "<svg class=\"strip\" viewBox=\"0 0 {width} {height}\" aria-hidden=\"true\">\
         <path class=\"axis\" d=\"M0 {rule:.1}H{width}\"/>\
         <path class=\"bar\" d=\"{whiskers}\"/><path class=\"dots\" d=\"{dots}\"/></svg>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_is_relative_to_the_value() {
        let svg = interval(Some(10.0), Some(8.75), Some(11.25));
        // an eighth of the value is half the reach: 26 of 52 units to each side of 60
        assert!(svg.contains("M34.0 8H86.0"), "{svg}");
        assert!(!svg.contains("arrow"));
        // a negative value keeps low on the left
        assert!(interval(Some(-10.0), Some(-11.25), Some(-8.75)).contains("M34.0 8H86.0"));
    }

    #[test]
    fn what_lies_beyond_gets_an_arrow() {
        let svg = interval(Some(1.0), Some(-3.0), Some(1.2));
        assert_eq!(svg.matches("arrow").count(), 1);
        assert!(interval(Some(0.0), Some(-1.0), Some(1.0)).is_empty());
        assert!(interval(None, None, None).is_empty());
    }

    #[test]
    fn a_strip_needs_two() {
        assert!(strip(&[(1.0, 0.9, 1.1)], 1.0).is_empty());
        let svg = strip(&[(1.0, 0.9, 1.1), (2.0, 1.9, 2.1)], 1.5);
        assert!(svg.contains("M0 20.0H220"), "{svg}");
    }
}
