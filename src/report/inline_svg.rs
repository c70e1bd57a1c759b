//! Small drawings inside tables, as inline SVG: they need no script and print as they are.

use std::fmt::Write as _;

/// Half the width of the interval bar's axis, as a share of the value.
const REACH: f64 = 0.25;

/// A coefficient's 95 % interval relative to its value: the axis goes a quarter of
/// the value to each side, an arrow marks an end that lies beyond. Empty where there is no scale.
pub(crate) fn interval(value: Option<f64>, low: Option<f64>, high: Option<f64>) -> String {
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

/// The 95 % interval of a relative difference about zero: the axis goes a quarter to each side, an arrow marks an end that
/// lies beyond. Empty where there is no relative difference.
pub(crate) fn difference(value: Option<f64>, low: Option<f64>, high: Option<f64>) -> String {
    let (Some(value), Some(low), Some(high)) = (value, low, high) else { return String::new() };
    let place = |v: f64| 60.0 + v / REACH * 52.0;
    let (left, right) = (place(low), place(high));
    let (x1, x2, dot) = (left.clamp(4.0, 116.0), right.clamp(4.0, 116.0), place(value));
    let mut svg = format!(
        "<svg class=\"interval\" viewBox=\"0 0 120 16\" aria-hidden=\"true\">\
         <path class=\"axis\" d=\"M8 8H112M8 5v6M112 5v6M60 2v12\"/>\
         <path class=\"bar\" d=\"M{x1:.1} 8H{x2:.1}\"/>"
    );
    if left < 4.0 {
        svg.push_str("<path class=\"arrow\" d=\"M8 4L3 8L8 12\"/>");
    }
    if right > 116.0 {
        svg.push_str("<path class=\"arrow\" d=\"M112 4L117 8L112 12\"/>");
    }
    if (4.0..=116.0).contains(&dot) {
        svg.push_str(&format!("<circle class=\"dot\" cx=\"{dot:.1}\" cy=\"8\" r=\"2.6\"/>"));
    }
    svg + "</svg>"
}

/// How a part of a [`curve`] is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stroke {
    Solid,
    Dashed,
}

/// A curve in the unit square, abscissa to the right and ordinate up; what leaves it above is cut. `mark` is a point on it,
/// `abscissa` the word under it, `words` what it shows to people who do not see it.
pub(crate) fn curve(
    points: &[([f64; 2], Stroke)],
    mark: Option<[f64; 2]>,
    abscissa: &str,
    words: &str,
) -> String {
    let (width, height, foot) = (150.0, 64.0, 12.0);
    let place = |[x, y]: [f64; 2]| {
        [2.0 + x * (width - 4.0), (height - foot) - y.clamp(0.0, 1.0) * (height - foot - 3.0)]
    };
    let mut lines = String::new();
    for (stroke, name) in [(Stroke::Solid, "solid"), (Stroke::Dashed, "dashed")] {
        let mut path = String::new();
        let mut is_down = false;
        for (i, (point, own)) in points.iter().enumerate() {
            // a dashed part begins where the solid one ends
            let joins = points.get(i + 1).is_some_and(|next| next.1 == stroke);
            if *own != stroke && !(joins && stroke == Stroke::Dashed) {
                is_down = false;
                continue;
            }
            let [x, y] = place(*point);
            // writing to a String cannot fail
            let _ = write!(path, "{}{x:.1} {y:.1}", if is_down { 'L' } else { 'M' });
            is_down = true;
        }
        if path.contains('L') {
            let _ = write!(lines, "<path class=\"{name}\" d=\"{path}\"/>");
        }
    }
    let dot = mark.map_or(String::new(), |mark| {
        let [x, y] = place(mark);
        format!("<circle class=\"dot\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\"/>")
    });
    let base = height - foot;
    format!(
        "<svg class=\"curve\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{words}\"><title>{words}</title>\
         <path class=\"axis\" d=\"M2 2V{base}H{width}\"/>{lines}{dot}\
         <text x=\"{width}\" y=\"{height}\" text-anchor=\"end\" dy=\"-2\">{abscissa}</text></svg>"
    )
}

/// One session's estimate in a [`strip`]: value, lower and upper end.
pub(crate) type Estimate = (f64, f64, f64);

/// Columns of a strip, two pixels each: more sessions than these share them.
const COLUMNS: usize = 106;

/// Estimates of many sessions side by side in their order, each with its interval, over a
/// common ordinate; the rule is their median. Empty of fewer than two.
pub(crate) fn strip(estimates: &[Estimate], median: f64) -> String {
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
    // a column of several sessions: from the least to the largest value, the dot their median
    let shared: Vec<Estimate> = match estimates.len() > COLUMNS {
        false => estimates.to_vec(),
        true => (0..COLUMNS)
            .map(|c| {
                let of = |c: usize| c * estimates.len() / COLUMNS;
                let mut own: Vec<f64> = estimates[of(c)..of(c + 1)].iter().map(|e| e.0).collect();
                own.sort_by(f64::total_cmp);
                (own[own.len() / 2], own[0], own[own.len() - 1])
            })
            .collect(),
    };
    let estimates = &shared;
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

/// Ends of an axis for the boxes of several groups, each sorted: what lies farther than three
/// times the box from it does not set the scale.
pub(crate) fn common_axis<'a>(groups: impl Iterator<Item = &'a [f64]>) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for values in groups.filter(|v| !v.is_empty()) {
        let [q1, _, q3] = quartiles(values);
        let reach = 3.0 * (q3 - q1);
        low = low.min(values[0].max(q1 - reach));
        high = high.max(values[values.len() - 1].min(q3 + reach));
    }
    if low > high {
        return (0.0, 1.0);
    }
    let pad = if high > low { 0.04 * (high - low) } else { 0.05 * high.abs().max(1e-9) };
    (low - pad, high + pad)
}

/// Quartiles of sorted values, between their places.
fn quartiles(sorted: &[f64]) -> [f64; 3] {
    [0.25, 0.5, 0.75].map(|share| {
        let at = share * (sorted.len() - 1) as f64;
        let (i, part) = (at.floor() as usize, at.fract());
        let next = sorted[(i + 1).min(sorted.len() - 1)];
        sorted[i] + part * (next - sorted[i])
    })
}

/// A box plot of sorted values on an axis from `low` to `high`: box of the quartiles, whiskers to
/// the last value within one and a half boxes, dots beyond; of fewer than five the values alone.
/// What lies off the axis is drawn at its end.
pub(crate) fn boxes(sorted: &[f64], low: f64, high: f64) -> String {
    if sorted.is_empty() {
        return String::new();
    }
    let (width, height) = (300.0, 20.0);
    let place = |v: f64| 4.0 + ((v - low) / (high - low)).clamp(0.0, 1.0) * (width - 8.0);
    let mut svg = format!(
        "<svg class=\"boxes\" viewBox=\"0 0 {width} {height}\" aria-hidden=\"true\">\
         <path class=\"axis\" d=\"M0 19.5H{width}\"/>"
    );
    let mut dots = String::new();
    // writing to a String cannot fail
    let mut dot = |v: f64| {
        let _ = write!(dots, "M{:.1} 10h0", place(v));
    };
    if sorted.len() < 5 {
        sorted.iter().for_each(|v| dot(*v));
    } else {
        let [q1, median, q3] = quartiles(sorted);
        let reach = 1.5 * (q3 - q1);
        let inside = |v: &&f64| **v >= q1 - reach && **v <= q3 + reach;
        let first = sorted.iter().find(inside).copied().unwrap_or(q1);
        let last = sorted.iter().rev().find(inside).copied().unwrap_or(q3);
        sorted.iter().filter(|v| !inside(v)).for_each(|v| dot(*v));
        let [a, b, m, c, d] = [first, q1, median, q3, last].map(place);
        let _ = write!(
            svg,
            "<path class=\"whisker\" d=\"M{a:.1} 10H{b:.1}M{c:.1} 10H{d:.1}M{a:.1} 6v8M{d:.1} 6v8\"/>\
             <path class=\"box\" d=\"M{b:.1} 4H{c:.1}V16H{b:.1}Z\"/>\
             <path class=\"middle\" d=\"M{m:.1} 3V17\"/>"
        );
    }
    let _ = write!(svg, "<path class=\"dots\" d=\"{dots}\"/></svg>");
    svg
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
    fn a_box_holds_the_middle_half_and_shows_what_is_apart() {
        let mut values: Vec<f64> = (0..=20).map(f64::from).collect();
        values.push(500.0);
        let (low, high) = common_axis([values.as_slice()].into_iter());
        // quartiles 5.25 and 15.75: three boxes beyond is 47.25
        assert!(low < 0.0 && (high - (47.25 * 1.04)).abs() < 0.2, "{low} {high}");
        let svg = boxes(&values, 0.0, 100.0);
        assert!(svg.contains("M19.3 4H50.0V16H19.3Z"), "{svg}");
        assert!(svg.contains("M296.0 10h0"), "the far one at the end of the axis: {svg}");
        assert_eq!(boxes(&[1.0, 2.0], 0.0, 4.0).matches("h0").count(), 2);
        assert!(boxes(&[], 0.0, 1.0).is_empty());
        assert_eq!(common_axis(std::iter::empty()), (0.0, 1.0));
    }

    #[test]
    fn a_long_strip_keeps_its_extremes_in_columns() {
        let many: Vec<Estimate> =
            (0..5000).map(|i| if i == 777 { (9.0, 8.9, 9.1) } else { (1.0, 0.9, 1.1) }).collect();
        let svg = strip(&many, 1.0);
        assert!(svg.len() < 12_000, "{}", svg.len());
        assert_eq!(svg.matches("h0").count(), COLUMNS);
        // 0.87 to 9.13 is the ordinate: 9 stands at 40 - 3 - 8.13 / 8.26 * 34
        assert_eq!(svg.matches(" 36.5V3.5").count(), 1, "the extreme reaches up from its column");
    }

    #[test]
    fn a_strip_needs_two() {
        assert!(strip(&[(1.0, 0.9, 1.1)], 1.0).is_empty());
        let svg = strip(&[(1.0, 0.9, 1.1), (2.0, 1.9, 2.1)], 1.5);
        assert!(svg.contains("M0 20.0H220"), "{svg}");
    }
}
