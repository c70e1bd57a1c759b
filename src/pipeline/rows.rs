//! Rows that sessions on the road and off it have alike.

use super::outcome::Input;
use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::contract::session::{Meta, Session};
use crate::contract::warning::Warning;
use crate::segment::Segment;
use crate::store::tables::rows;

/// Provenance of an input's rows.
pub(super) fn provenance(input: &Input<'_>) -> rows::Provenance {
    rows::Provenance {
        input_hash: input.input_hash.clone(),
        pipeline_hash: input.pipeline_hash.clone(),
        version: crate::VERSION.to_owned(),
    }
}

/// Says on every row of `coefficients` which motorcycle and which tyre it is of, so that comparing needs no join.
pub(super) fn name_machine(coefficients: &mut [rows::Coefficient], ride: &Session, bike: &Bike) {
    for row in coefficients {
        let tyre = Axle::BOTH.into_iter().find(|axle| axle.name() == row.tyre);
        row.tyre_model = tyre.and_then(|axle| tyre_model(&ride.meta, bike, axle));
        row.motorcycle.clone_from(&bike.name);
    }
}

/// Model of a tyre: what the log or its map says, else the bike file's.
fn tyre_model(meta: &Meta, bike: &Bike, axle: Axle) -> Option<String> {
    let ridden = match axle {
        Axle::Front => &meta.tyre_front,
        Axle::Rear => &meta.tyre_rear,
    };
    ridden.as_ref().or(bike.wheel(axle).model.as_ref()).cloned()
}

/// The rows of `warnings`.
pub(super) fn warnings(ident: &rows::Ident, warnings: Vec<Warning>) -> Vec<rows::WarningRow> {
    warnings.into_iter().map(|w| row(ident, w)).collect()
}

fn row(ident: &rows::Ident, warning: Warning) -> rows::WarningRow {
    rows::WarningRow {
        ident: ident.clone(),
        stage: warning.stage.to_owned(),
        code: warning.code.to_owned(),
        channel: warning.channel.map(|c| c.name().to_owned()),
        count: warning.count as i64,
        time: warning.time.filter(|t| t.is_finite()),
        message: warning.message,
    }
}

/// The sample of the largest magnitude.
fn peak(x: impl Iterator<Item = f64>) -> Option<f64> {
    x.filter(|v| v.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

fn mean(x: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = x.filter(|v| v.is_finite()).fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// The rows of `manoeuvres`; slips are from these rolling radii, m, front and rear.
pub(super) fn manoeuvres(
    session: &Session,
    segments: &[Segment],
    radius: [f64; 2],
    ident: &rows::Ident,
) -> Vec<rows::Manoeuvre> {
    let v = session.get(Channel::VelocityX);
    let wheels = [Channel::WheelSpeedFront, Channel::WheelSpeedRear].map(|c| session.get(c));
    segments
        .iter()
        .enumerate()
        .map(|(number, s)| {
            let (start, end) = (s.start, s.end.min(session.len));
            fn cut(x: Option<&[f64]>, start: usize, end: usize) -> Option<&[f64]> {
                x.map(|x| &x[start..end])
            }
            let finite = |x: Option<f64>| x.filter(|x| x.is_finite());
            let slip = |k: usize| {
                let (omega, v) = (cut(wheels[k], start, end)?, cut(v, start, end)?);
                peak(
                    omega
                        .iter()
                        .zip(v)
                        .filter(|(_, v)| **v > 2.0)
                        .map(|(w, v)| radius[k] * w / v - 1.0),
                )
            };
            let channel = |c: Channel| cut(session.get(c), start, end);
            let ax = channel(Channel::AccelerationX);
            rows::Manoeuvre {
                ident: ident.clone(),
                manoeuvre_id: number as i64,
                kind: s.kind.name().to_owned(),
                start: session.time(start),
                end: session.time(end),
                direction: s.direction.map(|d| d.name().to_owned()),
                quality: s.quality,
                used: s.used,
                reason: s.reason.as_deref().map(str::to_owned),
                reason_code: s.reason.as_ref().map(|r| r.code.name().to_owned()),
                speed_start: finite(cut(v, start, end).and_then(|v| v.first().copied())),
                speed_end: finite(cut(v, start, end).and_then(|v| v.last().copied())),
                speed_mean: cut(v, start, end).and_then(|v| mean(v.iter().copied())),
                acceleration_x_mean: ax.and_then(|x| mean(x.iter().copied())),
                acceleration_x_peak: ax.and_then(|x| peak(x.iter().copied())),
                acceleration_y_peak: channel(Channel::AccelerationY)
                    .and_then(|x| peak(x.iter().copied())),
                roll_peak: channel(Channel::Roll).and_then(|x| peak(x.iter().copied())),
                slip_ratio_front_peak: slip(0),
                slip_ratio_rear_peak: slip(1),
                ..rows::Manoeuvre::default()
            }
        })
        .collect()
}

/// The row of `sessions`.
pub(super) fn session(
    session: &Session,
    input: &Input<'_>,
    bike: &Bike,
    manoeuvres: &[rows::Manoeuvre],
    coefficients: &[rows::Coefficient],
    warnings: &[rows::WarningRow],
    provenance: rows::Provenance,
) -> rows::SessionRow {
    let meta = &session.meta;
    let distance = session
        .get(Channel::VelocityX)
        .map(|v| v.iter().filter(|v| v.is_finite()).map(|v| v.abs() / session.rate).sum::<f64>());
    let channels: Vec<&str> = session.channels().map(Channel::name).collect();
    rows::SessionRow {
        ident: rows::Ident::from(meta),
        path: input.log.to_string(),
        duration: session.duration(),
        rate: session.rate,
        n_samples: session.len as i64,
        distance,
        channels: channels.join(","),
        n_manoeuvres: manoeuvres.len() as i64,
        n_used: manoeuvres.iter().filter(|m| m.used).count() as i64,
        n_coefficients_ok: coefficients.iter().filter(|c| c.status == rows::Status::Ok).count()
            as i64,
        n_warnings: warnings.len() as i64,
        tyre_front: tyre_model(meta, bike, Axle::Front),
        tyre_rear: tyre_model(meta, bike, Axle::Rear),
        site: meta.site.clone(),
        rider_id: meta.rider_id.clone(),
        provenance,
    }
}
