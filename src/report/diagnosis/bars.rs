//! Drawings of a diagnosis inside its tables, as inline SVG: scores against their threshold, misfits
//! against their noise, the gain against what could be gained.

use std::fmt::Write as _;

/// Largest score that the bar shows; beyond it is an arrow.
pub(crate) const TOP: f64 = 4.0;

/// A score as a bar; the rule stands at one, beyond which 19 of 20 nulls do not go.
pub(crate) fn score(score: f64) -> String {
    if !score.is_finite() {
        return String::new();
    }
    let place = |s: f64| 2.0 + s.clamp(0.0, TOP) / TOP * 104.0;
    let (end, rule) = (place(score), place(1.0));
    let class = if score > 1.0 { "over" } else { "under" };
    let mut svg = format!(
        "<svg class=\"score\" viewBox=\"0 0 116 18\" aria-hidden=\"true\">\
         <path class=\"axis\" d=\"M2 15H106\"/><path class=\"{class}\" d=\"M2 9H{end:.1}\"/>"
    );
    if score > TOP {
        let _ = write!(svg, "<path class=\"beyond\" d=\"M106 4L113 9L106 14Z\"/>");
    }
    let _ = write!(svg, "<path class=\"threshold\" d=\"M{rule:.1} 1V17\"/></svg>");
    svg
}

/// The abscissa that misfits share: multiples of the noise-only rms, logarithmic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
}

/// One channel's misfit, in multiples of its noise-only rms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Levels {
    /// Under the nominal model.
    pub base: f64,
    /// With the causes.
    pub extended: Option<f64>,
    /// The largest of the nulls.
    pub largest: f64,
}

/// Width and margin of the drawing.
const WIDE: (f64, f64) = (220.0, 6.0);

impl Axis {
    /// Wide enough for all, at least from a half to three.
    pub(crate) fn of(levels: &[Levels]) -> Self {
        let all = levels.iter().flat_map(|l| [Some(l.base), l.extended]).flatten();
        let (low, high) = all
            .filter(|r| r.is_finite() && *r > 0.0)
            .fold((0.5, 3.0), |(low, high): (f64, f64), r| (low.min(r), high.max(r)));
        Axis { low: low.max(0.05) / 1.1, high: high.min(1000.0) * 1.1 }
    }

    fn place(&self, ratio: f64) -> f64 {
        let share =
            (ratio.clamp(self.low, self.high) / self.low).ln() / (self.high / self.low).ln();
        WIDE.1 + share * (WIDE.0 - 2.0 * WIDE.1)
    }

    /// The ticks, for the head of the column.
    pub(crate) fn ticks(&self) -> String {
        let mut marks = String::new();
        let mut texts = String::new();
        let mut last = f64::NEG_INFINITY;
        for (value, label) in TICKS {
            let x = self.place(value);
            if value < self.low || value > self.high || x - last < 22.0 {
                continue;
            }
            last = x;
            let _ = write!(marks, "M{x:.1} 15v4");
            let _ = write!(texts, "<text x=\"{x:.1}\" y=\"12\">{label}</text>");
        }
        format!(
            "<svg class=\"levels\" viewBox=\"0 0 {} 20\" aria-hidden=\"true\">\
             <path class=\"axis\" d=\"{marks}\"/>{texts}</svg>",
            WIDE.0
        )
    }

    /// A misfit: from the nominal model's to that with the causes; the shade is what nulls show.
    pub(crate) fn draw(&self, levels: Levels) -> String {
        let Levels { base, extended, largest } = levels;
        if !base.is_finite() {
            return String::new();
        }
        let (one, end) = (self.place(1.0), self.place(largest.max(1.0)));
        let mut svg = format!(
            "<svg class=\"levels\" viewBox=\"0 0 {} 18\" aria-hidden=\"true\">\
             <path class=\"nulls\" d=\"M{:.1} 9H{end:.1}\"/><path class=\"axis\" d=\"M{one:.1} 1V17\"/>",
            WIDE.0, WIDE.1
        );
        let from = self.place(base);
        if let Some(to) = extended.map(|e| self.place(e)) {
            let _ = write!(
                svg,
                "<path class=\"way\" d=\"M{from:.1} 9H{to:.1}\"/>\
                 <path class=\"extended\" d=\"M{to:.1} 4L{:.1} 9L{to:.1} 14L{:.1} 9Z\"/>",
                to + 5.0,
                to - 5.0
            );
        }
        let _ = write!(svg, "<circle class=\"base\" cx=\"{from:.1}\" cy=\"9\" r=\"4.2\"/></svg>");
        svg
    }
}

const TICKS: [(f64, &str); 10] = [
    (0.1, "0.1"),
    (0.5, "0.5"),
    (1.0, "1"),
    (2.0, "2"),
    (5.0, "5"),
    (10.0, "10"),
    (20.0, "20"),
    (50.0, "50"),
    (100.0, "100"),
    (500.0, "500"),
];

/// A length against the longest of its kind, as a bar with a rule at its end.
pub(crate) fn share(value: f64, longest: f64, class: &str) -> String {
    if !(value.is_finite() && longest > 0.0) {
        return String::new();
    }
    let end = 2.0 + (value / longest).clamp(0.0, 1.0) * 316.0;
    format!(
        "<svg class=\"share\" viewBox=\"0 0 320 14\" preserveAspectRatio=\"none\" aria-hidden=\"true\">\
         <path class=\"{class}\" d=\"M2 7H{end:.1}\"/></svg>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_is_at_one_and_what_is_beyond_gets_an_arrow() {
        let svg = score(2.0);
        // a fourth and a half of 104 units from 2
        assert!(svg.contains("M28.0 1V17") && svg.contains("M2 9H54.0"), "{svg}");
        assert!(svg.contains("over") && !svg.contains("beyond"));
        assert!(score(9.0).contains("beyond") && score(0.4).contains("under"));
        assert!(score(f64::NAN).is_empty());
    }

    #[test]
    fn misfits_share_a_logarithmic_axis() {
        let levels = Levels { base: 10.0, extended: Some(1.0), largest: 1.3 };
        let axis = Axis::of(&[levels]);
        // equal factors are equal lengths
        let steps = [axis.place(4.0) - axis.place(2.0), axis.place(8.0) - axis.place(4.0)];
        assert!((steps[0] - steps[1]).abs() < 1e-9);
        assert!(axis.draw(levels).contains("extended") && axis.ticks().contains(">10<"));
        let alone = axis.draw(Levels { extended: None, ..levels });
        assert!(!alone.contains("extended"), "{alone}");
    }
}
