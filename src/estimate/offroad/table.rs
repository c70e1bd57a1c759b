//! The off-road rows of the `signals` table: ISO axes again (x forward, z up, nose down positive).

use std::sync::Arc;

use arrow::array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray, new_null_array,
};

use super::Estimate;
use crate::contract::session::Meta;
use crate::segment::Segment;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::{file, registry};

/// One batch of every rider's forces and the motion they come from, at about `rate` samples per
/// second, rider by rider.
///
/// # Errors
/// The columns do not fit the schema: our own mistake.
pub(crate) fn batch(
    meta: &Meta,
    estimate: &Estimate,
    segments: &[Segment],
    rate: f64,
) -> Result<RecordBatch, Mismatch> {
    let k = &estimate.kinematics;
    let step = (k.rate / rate).round().max(1.0) as usize;
    let samples: Vec<usize> = (0..k.len()).step_by(step).collect();
    let rows = samples.len() * estimate.riders.len();
    let mut manoeuvre = Vec::with_capacity(samples.len());
    let mut current = 0;
    for &i in &samples {
        while current + 1 < segments.len() && segments[current].end <= i {
            current += 1;
        }
        manoeuvre.push(current as i64);
    }
    let each = |f: &dyn Fn(usize, usize) -> f64| -> ArrayRef {
        let samples = &samples;
        let values = (0..estimate.riders.len())
            .flat_map(|r| samples.iter().map(move |&i| Some(f(r, i)).filter(|x| x.is_finite())));
        Arc::new(Float64Array::from_iter(values))
    };
    let same = |x: &[f64], sign: f64| each(&|_, i| sign * x[i]);
    let text = |value: &str| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(std::iter::repeat_n(value, rows)))
    };
    let tyre = |f: &dyn Fn([f64; 5]) -> f64| {
        each(&|r, i| f(estimate.riders[r].tyres.columns().map(|c| c[i])))
    };
    let rider = |f: &dyn Fn([f64; 4]) -> f64| each(&|r, i| f(estimate.riders[r].forces.at(i)));
    let on_ground = |off: &[bool], row: usize| -> ArrayRef {
        // none where its own row of the equations is missing
        let values = samples.iter().map(|&i| (!k.lost[row]).then_some(!off[i])).collect::<Vec<_>>();
        Arc::new(BooleanArray::from(values.repeat(estimate.riders.len())))
    };

    let table = registry::SIGNALS.table();
    let schema = table.texts();
    let mut columns = Vec::with_capacity(schema.fields().len());
    for field in schema.fields() {
        columns.push(match field.name().as_str() {
            "session_id" => text(&meta.session_id),
            "bike_id" => text(&meta.bike_id),
            "time" => each(&|_, i| i as f64 / k.rate),
            "manoeuvre_id" => {
                Arc::new(Int64Array::from(manoeuvre.repeat(estimate.riders.len()))) as ArrayRef
            }
            "velocity_x" => same(&k.xd, 1.0),
            "acceleration_x" => same(&k.xdd, 1.0),
            "load_front" => tyre(&|f| f[0]),
            "load_rear" => tyre(&|f| f[1]),
            "force_x_front" => tyre(&|f| -f[2]),
            "force_x_rear" => tyre(&|f| f[4] - f[3]),
            "rider" => {
                let name = |r: &super::RiderEstimate| vec![r.rider.name(); samples.len()];
                Arc::new(StringArray::from(
                    estimate.riders.iter().flat_map(name).collect::<Vec<_>>(),
                ))
            }
            "pitch" => same(&k.mu, -1.0),
            "velocity_z" => same(&k.zd, -1.0),
            "acceleration_z" => same(&k.zdd, -1.0),
            "fork_travel" => same(&k.z_f, 1.0),
            "swing_arm_travel" => same(&k.a_r, 1.0),
            "fork_force" => same(&k.f_sf, 1.0),
            "shock_moment" => same(&k.t_sr, 1.0),
            "contact_front" => on_ground(&estimate.contact.front.off, 3),
            "contact_rear" => on_ground(&estimate.contact.rear.off, 4),
            "rider_peg_x" => rider(&|f| f[0]),
            "rider_peg_z" => rider(&|f| -f[1]),
            "rider_bar_x" => rider(&|f| f[2]),
            "rider_bar_z" => rider(&|f| -f[3]),
            _ => new_null_array(field.data_type(), rows),
        });
    }
    let batch = RecordBatch::try_new(schema, columns).map_err(|e| Mismatch::from(e.to_string()))?;
    file::typed(table, &batch)
}
