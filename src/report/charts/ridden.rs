//! What of a fit's line was not ridden: it is dashed, as beyond the ridden range in the tyre explorer.
//!
//! ```text
//! used points:          x x   x  xx            x xx x  x
//! line:       - - - - -|--------- - - - - - - -|--------- - - -
//!                                       0
//! ```
//!
//! Corners of one lean leave the lines below it to the form of the fit. The stiffness has no points of its own: those of
//! the slip angle of the same tyre count, unless changes of lean gave it.

use std::ops::Range;

use super::chart::{Chart, Line};
use crate::report::plots::catalogue::FITS;
use crate::report::plots::fits::{SLIP_ANGLE, STIFFNESS};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::store::tables::rows::Manoeuvre;

const NOTE: &str = " Dashed: not ridden, by the form of the fit.";

/// Marks what was not ridden in the fits of a session.
pub(super) fn mark(charts: &mut [Chart], manoeuvres: &[Manoeuvre]) {
    let ranges = |name: &str| used(charts.iter().find(|c| c.name == name)?);
    let mut of: Vec<(&str, Used)> =
        FITS.iter().filter_map(|plot| Some((plot.name, ranges(plot.name)?))).collect();
    let changing = ManoeuvreKind::ChangingLean.name();
    if !manoeuvres.iter().any(|m| m.used && m.kind == changing) {
        let camber = |k: usize| Some((STIFFNESS[k].name, ranges(SLIP_ANGLE[k].name)?.either_way()));
        of.extend((0..2).filter_map(camber));
    }
    for chart in charts {
        let Some((_, used)) = of.iter().find(|(name, _)| *name == chart.name) else { continue };
        for line in chart.lines.iter_mut().filter(|line| !line.path) {
            line.unridden = used.gaps(line);
        }
        if chart.lines.iter().any(|line| !line.unridden.is_empty()) {
            chart.caption.push_str(NOTE);
        }
    }
}

/// Abscissae of the points that a fit used.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Used {
    low: f64,
    high: f64,
    /// The smallest, of either sign.
    least: f64,
}

fn used(chart: &Chart) -> Option<Used> {
    let points = chart.clouds.iter().flat_map(|c| c.x.iter().zip(&c.w));
    let used = points.filter(|(_, weight)| **weight > 0.0).map(|(x, _)| *x);
    used.fold(None, |found: Option<Used>, x| {
        let Used { low, high, least } = found.unwrap_or(Used { low: x, high: x, least: x.abs() });
        Some(Used { low: low.min(x), high: high.max(x), least: least.min(x.abs()) })
    })
}

impl Used {
    /// The same of what is alike to either side.
    fn either_way(self) -> Used {
        let most = self.low.abs().max(self.high.abs());
        Used { low: -most, high: most, ..self }
    }

    /// Stretches of a line without a used point, those that hold a point of the line.
    fn gaps(&self, line: &Line) -> Vec<[f64; 2]> {
        let ends = line.x.first().zip(line.x.last());
        let Some((first, last)) = ends else { return Vec::new() };
        // past the line's ends, so that these are within
        let past = 1.0 + last - first;
        let gaps = [[first - past, self.low], [-self.least, self.least], [self.high, last + past]];
        let holds = |[from, to]: &[f64; 2]| line.x.iter().any(|x| from < x && x < to);
        gaps.into_iter().filter(holds).collect()
    }
}

impl Line {
    /// Runs of a stretch, and whether each was ridden; one that was not reaches to its neighbours.
    pub(crate) fn runs(&self, stretch: &Range<usize>) -> Vec<(Range<usize>, bool)> {
        let within = |x: f64| self.unridden.iter().any(|[from, to]| *from < x && x < *to);
        let ridden: Vec<bool> = stretch.clone().map(|i| !within(self.x[i])).collect();
        let mut out = Vec::new();
        let mut start = stretch.start;
        for run in ridden.chunk_by(|a, b| a == b) {
            let end = start + run.len();
            let wider = start.saturating_sub(1).max(stretch.start)..(end + 1).min(stretch.end);
            out.push(if run[0] { (start..end, true) } else { (wider, false) });
            start = end;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::charts::chart::Cloud;

    /// A line from `from` to 40 in steps of 5.
    fn line(from: i32) -> Line {
        let x: Vec<f64> = (from / 5..=8).map(|i| 5.0 * f64::from(i)).collect();
        Line { y: vec![Some(1.0); x.len()], x, ..Line::default() }
    }

    fn chart(name: &str, line: Line, points: &[f64]) -> Chart {
        let (x, w) = (points.to_vec(), points.iter().map(|x| f64::from(*x != 3.0)).collect());
        let clouds =
            if points.is_empty() { Vec::new() } else { vec![Cloud { x, w, ..Cloud::default() }] };
        Chart { name: name.into(), lines: vec![line], clouds, ..Chart::default() }
    }

    fn used_kind(kind: ManoeuvreKind) -> Manoeuvre {
        Manoeuvre { kind: kind.name().into(), used: true, ..Manoeuvre::default() }
    }

    /// The lines were solid from 0 degrees on where no corner had less than 13; the stiffness has no points to show it.
    #[test]
    fn a_line_below_the_smallest_ridden_lean_is_dashed() {
        let (slip, stiffness) = (SLIP_ANGLE[0].name, STIFFNESS[0].name);
        let points = [3.0, -13.0, -31.0, 16.0, 38.0]; // the first is an outlier
        let charts = || {
            let lateral = chart(slip, line(-40), &points);
            vec![
                lateral,
                chart(stiffness, line(0), &[]),
                chart("roll_over_lateral", line(0), &points),
            ]
        };
        let mut cornered = charts();
        mark(&mut cornered, &[used_kind(ManoeuvreKind::Coasting)]);
        let dashed = |chart: &Chart| -> Vec<f64> {
            let line = &chart.lines[0];
            let off = |x: &&f64| line.unridden.iter().any(|[a, b]| a < *x && *x < b);
            line.x.iter().filter(off).copied().collect()
        };
        assert_eq!(dashed(&cornered[0]), [-40.0, -35.0, -10.0, -5.0, 0.0, 5.0, 10.0, 40.0]);
        assert_eq!(dashed(&cornered[1]), [0.0, 5.0, 10.0, 40.0]);
        assert!(cornered[1].caption.contains("not ridden"));
        assert!(cornered[2].lines[0].unridden.is_empty() && cornered[2].caption.is_empty());
        // changes of lean ride it
        let mut changed = charts();
        mark(&mut changed, &[used_kind(ManoeuvreKind::ChangingLean)]);
        assert!(dashed(&changed[1]).is_empty() && !dashed(&changed[0]).is_empty());
        // what is not ridden reaches to what is
        let runs = cornered[1].lines[0].runs(&(0..9));
        assert_eq!(runs, [(0..4, false), (3..8, true), (7..9, false)]);
    }
}
