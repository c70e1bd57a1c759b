//! What slows a coasting run, over the weight: drag and rolling resistance of the ride's other runs fitted to it.

use super::comparison::{Scatter, Shown};
use super::quantity::{Compare, Fitted, Quantity};
use crate::fit::coasting::{Run, runs};

static QUANTITY: Quantity = Quantity {
    name: "resistance",
    unit: "1",
    words: "resistance",
    least: 0.002,
    shown: ("% of the weight", 100.0),
    causes: [
        "a gust against it, a slope uphill or a brake that drags",
        "a gust from behind or a slope downhill",
    ],
};

pub(super) static COASTING: Compare =
    Compare { quantity: &QUANTITY, scatter: Scatter { sd: 1.5e-3, worth: 4.0 }, shown };

/// Time after which gusts are others, s.
const GUST: f64 = 1.5;

fn shown(fitted: &Fitted<'_>) -> Vec<Shown> {
    let (data, solution) = (fitted.data, fitted.solution);
    if !data.shows_coasting {
        return Vec::new();
    }
    let shown = |run: Run| {
        let length = run.samples as f64 / data.corner_rate;
        Shown {
            segment: run.segment,
            value: run.resistance,
            // over a long run gusts and bumps cancel
            error: COASTING.scatter.sd * 2.0 * (GUST / length).sqrt(),
            columns: run.columns,
        }
    };
    runs(&data.coast, &solution.inputs).into_iter().map(shown).collect()
}
