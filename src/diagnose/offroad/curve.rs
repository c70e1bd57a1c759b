//! How the residuals change with the number of a candidate.
//!
//! Every candidate adds to the residuals; none changes what another adds (to first order). So a
//! candidate is the change of every block as its number goes from that of the base to any other:
//! a line, or nodes between which is interpolated.

/// Change of every block from the base.
#[derive(Debug, Clone)]
pub(crate) enum Curve {
    /// Per unit of the number; the base is zero.
    Line(Vec<f64>),
    /// At rising numbers; between them linear in their logarithm. The base is none of them.
    Nodes {
        /// Logarithms of the numbers.
        at: Vec<f64>,
        /// One column per number.
        columns: Vec<Vec<f64>>,
    },
}

impl Curve {
    /// Adds the change at `value` to every block.
    pub(crate) fn add(&self, value: f64, r: &mut [f64]) {
        match self {
            Curve::Line(column) => r.iter_mut().zip(column).for_each(|(r, c)| *r += value * c),
            Curve::Nodes { at, columns } => {
                let (k, share) = place(at, value.ln());
                let (low, high) = (&columns[k], &columns[k + 1]);
                for ((r, a), b) in r.iter_mut().zip(low).zip(high) {
                    *r += a + share * (b - a);
                }
            }
        }
    }

    /// Derivative with respect to the number (a line) or to its logarithm (nodes).
    pub(crate) fn slope(&self, value: f64) -> Vec<f64> {
        match self {
            Curve::Line(column) => column.clone(),
            Curve::Nodes { at, columns } => {
                // over two steps: the interpolation has kinks
                let (k, _) = place(at, value.ln());
                let (low, high) = (k.saturating_sub(1), (k + 2).min(at.len() - 1));
                let by = 1.0 / (at[high] - at[low]);
                columns[low].iter().zip(&columns[high]).map(|(a, b)| by * (b - a)).collect()
            }
        }
    }

    /// Whether the number is a frequency whose logarithm has the interval.
    pub(crate) fn logarithmic(&self) -> bool {
        matches!(self, Curve::Nodes { .. })
    }
}

/// The node below and the share of the way to the next.
fn place(at: &[f64], x: f64) -> (usize, f64) {
    let k = at.partition_point(|a| *a <= x).clamp(1, at.len() - 1) - 1;
    (k, ((x - at[k]) / (at[k + 1] - at[k])).clamp(0.0, 1.0))
}
