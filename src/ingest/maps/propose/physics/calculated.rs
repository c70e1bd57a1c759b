//! A lean that the log's own lateral acceleration gives number by number: calculated, no measurement.

use super::log::Log;
use super::signal::{line, mean};
use super::speed::SPAN;
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::ingest::maps::units;

/// A lean that follows from another channel within this share of its size is calculated of it: no two sensors agree so.
const FOLLOWS: f64 = 0.015;
/// ... and is as large within this.
const AS_LARGE: f64 = 0.02;
/// Units of lateral accelerations that loggers write.
const UNITS: [&str; 3] = ["m/s2", "g", "mg"];

/// The lateral acceleration of which a lean (`factor` of its unit are 1 rad) is calculated, and by how much it is off.
pub(super) fn lateral<'a>(log: &'a Log<'_>, place: usize, factor: f64) -> Option<(&'a str, f64)> {
    let lean: Vec<f64> = log.x(place).iter().map(|x| x / factor).collect();
    let lean = mean(&lean, SPAN);
    let own = |i: usize| log.unit(i, "acceleration").map(|u| vec![u]);
    let off = |i: usize, unit: &str| {
        let si = units::conversion(unit, "m/s2").ok()?.factor;
        let ideal: Vec<f64> = log.x(i).iter().map(|a| (a * si / GRAVITY).atan()).collect();
        let ideal = mean(&ideal, SPAN);
        let l = line(&ideal, &lean)?;
        let finite: Vec<f64> = ideal.iter().copied().filter(|x| x.is_finite()).collect();
        let size = (finite.iter().map(|x| x * x).sum::<f64>() / finite.len().max(1) as f64).sqrt();
        let off = l.rms / l.slope.abs() / size;
        ((l.slope.abs() - 1.0).abs() < AS_LARGE && off < FOLLOWS).then_some(off)
    };
    log.named(Channel::AccelerationY).into_iter().find_map(|i| {
        let units = own(i).unwrap_or_else(|| UNITS.to_vec());
        let off = units.into_iter().find_map(|unit| off(i, unit))?;
        Some((log.channels[i].name.as_str(), off))
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::ingest::formats::listing::SourceChannel;
    use crate::ingest::maps::propose::physics::Clock;
    use crate::ingest::raw::Column;

    /// A minute of corners at 10 Hz; the lean in degrees is `larger` than the ideal one and has noise.
    fn of(larger: f64, noise: f64) -> Option<f64> {
        let channel = |name: &str| SourceChannel { name: name.into(), ..SourceChannel::default() };
        let channels = [channel("Lateral acceleration"), channel("Lean angle")];
        let time: Arc<Vec<f64>> = Arc::new((0..600).map(|i| 0.1 * f64::from(i)).collect());
        let side: Vec<f64> = time.iter().map(|t| 0.6 * (0.5 * t).sin()).collect();
        let lean = |(i, a): (usize, &f64)| {
            let shaken = noise * (0.11 * i as f64).sin();
            (10.0 * ((larger * a).atan().to_degrees() + shaken)).round() / 10.0
        };
        let lean = side.iter().enumerate().map(lean).collect();
        let column =
            |values: Vec<f64>| Column { name: "x".into(), time: Arc::clone(&time), values };
        let mut log = Log::new(&channels, Clock::between(0.0, 59.9));
        log.take(0, vec![column(side.clone()), column(lean)]);
        lateral(&log, 1, 1_f64.to_degrees()).map(|found| found.1)
    }

    #[test]
    fn a_lean_of_the_lateral_acceleration_is_calculated() {
        assert!(of(1.0, 0.0).is_some_and(|off| off < 0.005), "{:?}", of(1.0, 0.0));
        // wide tyres, and a sensor of its own
        assert_eq!(of(1.04, 0.0), None);
        assert_eq!(of(1.0, 1.5), None);
    }
}
