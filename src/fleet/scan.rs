//! How much of a series one step, one stretch or one straight line would explain.

/// From so many values on a series is scanned.
pub(crate) const SCAN_FROM: usize = 8;

/// Up to so many sessions all stretches are tried; above, lengths in steps of a quarter.
const ALL_LENGTHS: usize = 64;

/// At least so many values must be left outside a stretch.
const OUTSIDE: usize = 3;

/// Possible event of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Another level in the sessions `[from, to)`; a step where `to` is the end.
    Stretch(usize, usize),
    /// A straight line over time.
    Line,
}

impl Shape {
    /// Places that had to be found for it, in `n` sessions.
    pub fn ends(self, n: usize) -> f64 {
        match self {
            Shape::Line => 0.0,
            Shape::Stretch(a, b) if b == n || b - a == 1 => 1.0,
            Shape::Stretch(..) => 2.0,
        }
    }
}

/// Every shape that is tried in `n` sessions. A stretch from the start is the step after it.
pub(crate) fn shapes(n: usize) -> Vec<Shape> {
    let mut out = vec![Shape::Line];
    let mut length = 1;
    while length < n {
        // a stretch from the start is the step after it; all but the first session are that session
        let tried = |a: &usize| (*a > 0 || length == 1) && !(*a == 1 && length == n - 1);
        out.extend((0..=n - length).filter(tried).map(|a| Shape::Stretch(a, a + length)));
        length = if n <= ALL_LENGTHS { length + 1 } else { (length + 1).max(length * 5 / 4) };
    }
    if n > ALL_LENGTHS {
        out.extend((2..n - 1).map(|a| Shape::Stretch(a, n)));
    }
    out
}

/// The same stretch with its ends moved to where `gain` is largest: above `ALL_LENGTHS` sessions not all were tried.
pub(crate) fn refined(shape: Shape, n: usize, gain: impl Fn(Shape) -> f64) -> Shape {
    let (Shape::Stretch(mut a, mut b), true) = (shape, n > ALL_LENGTHS) else { return shape };
    let best = |of: &mut dyn Iterator<Item = Shape>, now: Shape| {
        of.fold(now, |best, s| if gain(s) > gain(best) { s } else { best })
    };
    for _ in 0..2 {
        let near = (b - a).div_ceil(4);
        let begins = a.saturating_sub(near)..(a + near + 1).min(b);
        if let Shape::Stretch(from, _) =
            best(&mut begins.map(|from| Shape::Stretch(from, b)), Shape::Stretch(a, b))
        {
            a = from;
        }
        let ends = (b - near.min(b)).max(a + 1)..(b + near).min(n) + 1;
        if let Shape::Stretch(_, to) =
            best(&mut ends.map(|to| Shape::Stretch(a, to)), Shape::Stretch(a, b))
        {
            b = to;
        }
    }
    // all sessions are no stretch
    if a == 0 && b == n { shape } else { Shape::Stretch(a, b) }
}

/// Squared differences count up to so many times their variance.
const CLIP: f64 = 6.25;

/// Mean of a clipped squared standard normal variable: `E min(z^2, CLIP)`.
const CLIPPED: f64 = 0.977_56;

/// Spread between sessions that a few steps, a drift or some outliers hardly widen: from
/// differences of successive sessions, clipped (Huber's "proposal 2").
///
/// ```text
/// mean min((x_{i+1} - x_i)^2 / (2 tau^2 + e_i^2 + e_{i+1}^2), 2.5^2) = 0.97756
/// ```
///
/// 0 where the standard errors alone explain it. NaN values are passed over.
pub(crate) fn robust_tau(values: &[f64], errors: &[f64]) -> f64 {
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    let pairs: Vec<(f64, f64)> = known
        .windows(2)
        .map(|w| {
            let e2 = errors[w[0]].powi(2) + errors[w[1]].powi(2);
            ((values[w[1]] - values[w[0]]).powi(2), e2)
        })
        .collect();
    let clipped = |tau2: f64| {
        let share =
            |(d2, e2): &(f64, f64)| (d2 / (2.0 * tau2 + e2).max(f64::MIN_POSITIVE)).min(CLIP);
        pairs.iter().map(share).sum::<f64>() / pairs.len() as f64 - CLIPPED
    };
    if pairs.is_empty() || clipped(0.0) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, pairs.iter().map(|(d2, _)| *d2).fold(0.0, f64::max));
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if clipped(middle) > 0.0 { low = middle } else { high = middle }
    }
    high.sqrt()
}

/// Sums of a series from which the score of any stretch follows at once.
#[derive(Debug)]
pub(crate) struct Sums {
    weight: Vec<f64>,
    weighted: Vec<f64>,
    count: Vec<usize>,
    line: f64,
}

impl Sums {
    /// Of values with their variances, NaN passed over, and the times of a line.
    pub(crate) fn new(values: &[f64], variances: &[f64], times: &[f64]) -> Self {
        let n = values.len();
        let mut sums = Sums {
            weight: vec![0.0; n + 1],
            weighted: vec![0.0; n + 1],
            count: vec![0; n + 1],
            line: 0.0,
        };
        let known = |i: usize| values[i].is_finite() && variances[i] > 0.0;
        // the middle first: large values with small differences lose no digits
        let total: f64 = (0..n).filter(|i| known(*i)).map(|i| 1.0 / variances[i]).sum();
        let mean_of = |x: &[f64]| {
            (0..n).filter(|i| known(*i)).map(|i| x[i] / variances[i]).sum::<f64>() / total
        };
        let (mean, time) = (mean_of(values), mean_of(times));
        let (mut top, mut bottom) = (0.0, 0.0);
        for i in 0..n {
            let (w, x) = if known(i) { (1.0 / variances[i], values[i] - mean) } else { (0.0, 0.0) };
            sums.weight[i + 1] = sums.weight[i] + w;
            sums.weighted[i + 1] = sums.weighted[i] + w * x;
            sums.count[i + 1] = sums.count[i] + usize::from(w > 0.0);
            top += w * (times[i] - time) * x;
            bottom += w * (times[i] - time).powi(2);
        }
        sums.line = if bottom > 0.0 { top / bottom.sqrt() } else { 0.0 };
        sums
    }

    /// The contrast over its standard deviation: standard normal where nothing has happened.
    pub(crate) fn score(&self, shape: Shape) -> f64 {
        let Shape::Stretch(a, b) = shape else { return self.line };
        let n = self.weight.len() - 1;
        let inside = self.count[b] - self.count[a];
        if inside == 0 || self.count[n] - inside < OUTSIDE {
            return 0.0;
        }
        let (w, s) = (self.weight[b] - self.weight[a], self.weighted[b] - self.weighted[a]);
        let (rest, s_rest) = (self.weight[n] - w, self.weighted[n] - s);
        (s / w - s_rest / rest) / (1.0 / w + 1.0 / rest).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_hardly_widens_the_spread_and_scores_where_it_is() {
        let noise = |i: usize| [0.3, -1.1, 0.8, -0.2, 1.3, -0.9][i * 7 % 6];
        let values: Vec<f64> =
            (0..40).map(|i| noise(i) + if i < 25 { 5.0 } else { 15.0 }).collect();
        let tau = robust_tau(&values, &[0.0; 40]);
        assert!((0.5..2.0).contains(&tau), "{tau}");
        let times: Vec<f64> = (0..40).map(f64::from).collect();
        let sums = Sums::new(&values, &[tau * tau; 40], &times);
        let score = |s: &Shape| sums.score(*s).abs();
        let best = shapes(40).into_iter().max_by(|a, b| score(a).total_cmp(&score(b)));
        assert_eq!(best, Some(Shape::Stretch(25, 40)));
    }

    #[test]
    fn the_ends_of_a_long_stretch_are_found_to_the_session() {
        let n = 400;
        let level = |i: usize| if (101..234).contains(&i) { 3.0 } else { 0.0 };
        let values: Vec<f64> = (0..n).map(|i| level(i) + 0.1 * (i * 7 % 6) as f64).collect();
        let times: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let sums = Sums::new(&values, &vec![0.03; n], &times);
        let score = |s: Shape| sums.score(s).abs();
        let coarse = shapes(n).into_iter().max_by(|a, b| score(*a).total_cmp(&score(*b)));
        let coarse = coarse.expect("some shape");
        assert_ne!(coarse, Shape::Stretch(101, 234));
        assert_eq!(refined(coarse, n, score), Shape::Stretch(101, 234));
    }

    #[test]
    fn no_contrast_is_tried_twice() {
        let n = 12;
        let all = shapes(n);
        let inside = |s: &Shape| match s {
            Shape::Stretch(a, b) => (0..n).map(|i| (*a..*b).contains(&i)).collect::<Vec<_>>(),
            Shape::Line => Vec::new(),
        };
        for (k, a) in all.iter().enumerate() {
            for b in &all[k + 1..] {
                let other: Vec<bool> = inside(b).iter().map(|x| !x).collect();
                assert!(inside(a) != inside(b) && inside(a) != other, "{a:?} {b:?}");
            }
        }
    }
}
