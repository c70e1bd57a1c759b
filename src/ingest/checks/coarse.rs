//! Positions that are rounded too coarsely for a speed or a turn.

use super::view::View;
use crate::contract::channel::Channel;
use crate::contract::geodesy::metres_per_degree;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::warning::warning;

/// A track that is rounded to more than this gives no speed over 2 s, m: four decimals of a degree are 11 m.
pub(crate) const COARSE: f64 = 3.0;
/// Samples that are looked at, about.
const LOOKED_AT: usize = 20_000;
/// Samples on a grid are this near to it, in its steps.
const ON_GRID: f64 = 0.02;

/// Takes a coarse position out of what the checks see, with a warning: it stays in the session.
pub(super) fn take_out(session: &Session, view: &mut View) -> Option<Warning> {
    let (lat, lon) = (session.get(Channel::Latitude)?, session.get(Channel::Longitude)?);
    let north = lat.iter().copied().find(|x| x.is_finite())?;
    let metres = metres_per_degree(north);
    let steps = [lat, lon].into_iter().zip(metres).map(|(x, metres)| Some(metres * grid(x)?));
    let step = steps.flatten().fold(0.0, f64::max);
    if step < COARSE {
        return None;
    }
    view.remove(Channel::Latitude);
    view.remove(Channel::Longitude);
    let message = format!(
        "latitude and longitude are rounded to {step:.0} m: too coarse to check speeds and corners by them; write positions \
         with seven decimals of a degree"
    );
    Some(warning("coarse_position", Some(Channel::Latitude), lat.len(), None, message))
}

/// The step of a grid that all numbers are on; `None` where there is none.
fn grid(x: &[f64]) -> Option<f64> {
    let every = (x.len() / LOOKED_AT).max(1);
    let mut x: Vec<f64> = x.iter().step_by(every).copied().filter(|x| x.is_finite()).collect();
    x.sort_unstable_by(f64::total_cmp);
    x.dedup();
    let gaps: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let step = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let on_grid = |gap: &f64| (gap / step - (gap / step).round()).abs() < ON_GRID;
    (gaps.len() >= 2 && gaps.iter().all(on_grid)).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_found_and_a_straight_road_is_none() {
        let path = |i: i32| 8.0 + 1e-4 * f64::from(i) + 4e-5 * (0.1 * f64::from(i)).sin();
        let fine: Vec<f64> = (0..300).map(path).collect();
        assert_eq!(grid(&fine), None);
        let coarse: Vec<f64> = fine.iter().map(|x| (x * 1e3).round() / 1e3).collect();
        assert!((grid(&coarse).expect("three decimals") - 1e-3).abs() < 1e-9);
        assert_eq!(grid(&[8.0; 50]), None);
    }
}
