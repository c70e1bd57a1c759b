//! The `signals` table: estimated beside measured, at the estimation rate.

use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray, new_null_array};

use crate::contract::session::Meta;
use crate::tables::registry;

use super::samples::Samples;
use super::signals::Signals;

/// One batch of every sample of the given sets, in the order of time.
///
/// # Errors
/// The columns do not fit the schema: our own mistake.
pub fn batch(meta: &Meta, sets: &[(&Samples, &Signals)]) -> Result<RecordBatch, String> {
    let mut order: Vec<(usize, usize)> = Vec::new();
    for (set, (samples, _)) in sets.iter().enumerate() {
        order.extend((0..samples.len()).map(|i| (set, i)));
    }
    order.sort_by(|a, b| sets[a.0].0.time[a.1].total_cmp(&sets[b.0].0.time[b.1]));
    let number = |f: &dyn Fn(&Samples, &Signals, usize) -> Option<f64>| -> ArrayRef {
        let values = order.iter().map(|&(set, i)| {
            let (samples, signals) = sets[set];
            f(samples, signals, i).filter(|x| x.is_finite())
        });
        Arc::new(Float64Array::from_iter(values))
    };
    let pair = |pick: &dyn Fn(&Signals) -> &[Vec<f64>; 2], k: usize| {
        number(&|_, s, i| pick(s)[k].get(i).copied())
    };
    let text = |value: &str| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(std::iter::repeat_n(value, order.len())))
    };
    let manoeuvre: ArrayRef = Arc::new(Int64Array::from_iter_values(
        order.iter().map(|&(set, i)| sets[set].0.segment[i] as i64),
    ));
    let mut columns: Vec<ArrayRef> = vec![
        text(&meta.session_id),
        text(&meta.bike_id),
        number(&|x, _, i| Some(x.time[i])),
        manoeuvre,
        number(&|_, s, i| s.speed.get(i).copied()),
        number(&|x, _, i| Some(x.acceleration_x[i])),
        number(&|_, s, i| s.roll.get(i).copied()),
        number(&|x, _, i| Some(x.yaw_rate[i])),
        pair(&|s| &s.slip_ratio, 0),
        pair(&|s| &s.slip_ratio, 1),
        pair(&|s| &s.slip_angle, 0),
        pair(&|s| &s.slip_angle, 1),
        pair(&|s| &s.camber, 0),
        pair(&|s| &s.camber, 1),
        pair(&|s| &s.load, 0),
        pair(&|s| &s.load, 1),
        pair(&|s| &s.force_x, 0),
        pair(&|s| &s.force_x, 1),
        pair(&|s| &s.force_y, 0),
        pair(&|s| &s.force_y, 1),
        number(&|_, s, i| s.overturning.get(i).copied()),
    ];
    let schema = registry::SIGNALS.table().arrow();
    for field in schema.fields().iter().skip(columns.len()) {
        columns.push(new_null_array(field.data_type(), order.len())); // off-road only
    }
    RecordBatch::try_new(schema, columns).map_err(|e| e.to_string())
}
