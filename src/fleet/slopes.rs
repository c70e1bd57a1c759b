//! What shared errors do to the rides of a motorcycle, made comparable before they are combined ([`super::combine`]).

use crate::contract::coefficient::Coefficient as C;
use crate::statistics::order::median;

/// Slopes vary by more than this share of their middle where it is variety and not noise.
const VARIETY: f64 = 1.0;

/// Shifts of a ride's coefficients by shared errors: index of the error and shift, by coefficient.
pub(super) type Slopes = Vec<Vec<(usize, f64)>>;

/// Gives every ride of a coefficient the same shared errors: one that a few do not state has its middle there, one that most
/// do not state goes to the model's.
pub(super) fn stated(
    rides: &mut [Slopes],
    places: &[Vec<(usize, usize)>],
    sources: usize,
    model: impl Fn(usize) -> usize,
) {
    for (k, of_key) in places.iter().enumerate() {
        let mut slopes = vec![Vec::new(); sources];
        for (r, row) in of_key {
            rides[*r][*row].iter().for_each(|(j, s)| slopes[*j].push(*s));
        }
        let most = |j: usize| 2 * slopes[j].len() > of_key.len();
        let middles: Vec<Option<f64>> = slopes.iter().map(|s| median(&mut s.clone())).collect();
        let model = model(k);
        for (r, row) in of_key {
            let of_ride = &mut rides[*r][*row];
            let (kept, rare): (Vec<_>, Vec<_>) =
                of_ride.drain(..).partition(|(j, _)| *j == model || most(*j));
            *of_ride = kept;
            for (j, middle) in middles.iter().enumerate() {
                let absent = of_ride.iter().all(|(of, _)| *of != j);
                if let (Some(middle), true) = (middle, j != model && most(j) && absent) {
                    of_ride.push((j, *middle));
                }
            }
            let rare: f64 = rare.iter().map(|(_, s)| s * s).sum();
            if rare > 0.0 {
                match of_ride.iter_mut().find(|(j, _)| *j == model) {
                    Some((_, own)) => *own = own.signum() * own.hypot(rare.sqrt()),
                    None => of_ride.push((model, rare.sqrt())),
                }
            }
        }
    }
}

/// Coefficients whose slopes are what the ride was, as their values are: `c1`, `c3` and `ct` describe tyre and course together,
/// and the numbers of a friction curve trade against each other in one fit.
// METHOD: their slopes are no evidence. A hundred simulated rides took 84 % of the variance of `cg_to_front` away by them, and
// what they made of it had nothing to do with what it was; `c3` was off by twice the error of the median ride
pub(super) fn is_of_its_ride(coefficient: &str) -> bool {
    const OF_ITS_RIDE: [C; 9] = [
        C::SlipCamberC1,
        C::SlipCamberC3,
        C::LateralFrictionCt,
        C::PeakSlip,
        C::MfB,
        C::MfC,
        C::MfD,
        C::MfE1,
        C::MfE2,
    ];
    OF_ITS_RIDE.iter().any(|c| c.name() == coefficient)
}

/// Draws the slopes of each coefficient on each shared error towards their middle, by as much of their variance as noise makes.
pub(super) fn steady(
    rides: &mut [Slopes],
    places: &[Vec<(usize, usize)>],
    varied: &[bool],
    sources: usize,
) {
    for (of_key, varied) in places.iter().zip(varied) {
        let mut slopes = vec![Vec::new(); sources];
        for (r, row) in of_key {
            rides[*r][*row].iter().for_each(|(j, s)| slopes[*j].push(*s));
        }
        let drawn: Vec<Option<(f64, f64)>> = slopes
            .iter_mut()
            .map(|all| {
                let middle = median(all)?;
                let variance =
                    all.iter().map(|s| (s - middle).powi(2)).sum::<f64>() / all.len() as f64;
                let noise = (VARIETY * middle).powi(2);
                let variety = *varied && variance > noise;
                Some((middle, if variety { 1.0 - noise / variance } else { 0.0 }))
            })
            .collect();
        for (r, row) in of_key {
            for (j, slope) in &mut rides[*r][*row] {
                if let Some((middle, variety)) = drawn[*j] {
                    *slope = middle + variety * (*slope - middle);
                }
            }
        }
    }
}
