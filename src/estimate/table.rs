//! The `signals` table: estimated beside measured, at the estimation rate.

use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray, new_null_array};

use crate::contract::session::Meta;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::{file, registry};

use super::samples::Samples;
use super::signals::Signals;

/// One batch of every sample of the given sets, in the order of time.
///
/// # Errors
/// The columns do not fit the schema: our own mistake.
pub(crate) fn batch(meta: &Meta, sets: &[(&Samples, &Signals)]) -> Result<RecordBatch, Mismatch> {
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
    let measured = |pick: &dyn Fn(&Samples) -> &[f64]| number(&|x, _, i| Some(pick(x)[i]));
    let estimated = |pick: &dyn Fn(&Signals) -> &[f64]| number(&|_, s, i| pick(s).get(i).copied());
    let text = |value: &str| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(std::iter::repeat_n(value, order.len())))
    };

    let table = registry::SIGNALS.table();
    let schema = table.texts();
    let mut columns: Vec<ArrayRef> = Vec::with_capacity(schema.fields().len());
    for field in schema.fields() {
        columns.push(match field.name().as_str() {
            "session_id" => text(&meta.session_id),
            "bike_id" => text(&meta.bike_id),
            "time" => measured(&|x| &x.time),
            "manoeuvre_id" => Arc::new(Int64Array::from_iter_values(
                order.iter().map(|&(set, i)| sets[set].0.segment[i] as i64),
            )),
            "velocity_x" => estimated(&|s| &s.speed),
            "acceleration_x" => measured(&|x| &x.acceleration_x),
            "roll" => estimated(&|s| &s.roll),
            "yaw_rate" => measured(&|x| &x.yaw_rate),
            "slip_ratio_front" => estimated(&|s| &s.slip_ratio[0]),
            "slip_ratio_rear" => estimated(&|s| &s.slip_ratio[1]),
            "slip_angle_front" => estimated(&|s| &s.slip_angle[0]),
            "slip_angle_rear" => estimated(&|s| &s.slip_angle[1]),
            "camber_front" => estimated(&|s| &s.camber[0]),
            "camber_rear" => estimated(&|s| &s.camber[1]),
            "load_front" => estimated(&|s| &s.load[0]),
            "load_rear" => estimated(&|s| &s.load[1]),
            "force_x_front" => estimated(&|s| &s.force_x[0]),
            "force_x_rear" => estimated(&|s| &s.force_x[1]),
            "force_y_front" => estimated(&|s| &s.force_y[0]),
            "force_y_rear" => estimated(&|s| &s.force_y[1]),
            "overturning_moment" => estimated(&|s| &s.overturning),
            _ => new_null_array(field.data_type(), order.len()), // off-road only
        });
    }
    let batch = RecordBatch::try_new(schema, columns).map_err(|e| Mismatch::from(e.to_string()))?;
    file::typed(table, &batch)
}
