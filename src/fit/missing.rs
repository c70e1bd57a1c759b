//! What the numbers cost that the bike file does not have.

use super::coefficients::{together, upstream_variance};
use super::solution::Solution;
use crate::contract::bike;
use crate::contract::coefficient::{Coefficient as C, Id};
use crate::statistics::clustered_fit::Uncertainty;
use crate::statistics::interval::t95;

/// Most keys that are named.
const MOST: usize = 3;
/// A key is named from this widening of an interval on.
const LEAST: f64 = 1.2;

/// What one key that the bike file does not have costs.
#[derive(Debug, Clone, PartialEq)]
pub struct Cost {
    /// The key; without `front.` and `rear.`, which are taken together.
    pub key: String,
    /// The coefficient that it widens most.
    pub id: Id,
    /// Half of the 95 % interval over the value, as it is.
    pub relative: f64,
    /// The same if the key were exact.
    pub relative_without: f64,
    /// How the number is found.
    pub remedy: String,
}

impl std::fmt::Display for Cost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Cost { key, id, relative, relative_without, remedy } = self;
        let [now, then] = [relative, relative_without].map(|share| percent(*share));
        write!(f, "{key} not given: {id} ±{now} % instead of ±{then} %; {remedy}")
    }
}

/// Whole above ten.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 9.95 { format!("{percent:.1}") } else { format!("{percent:.0}") }
}

/// The keys whose want costs most, at most three, the most costly first.
pub fn costs(solution: &Solution) -> Vec<Cost> {
    let mut keys: Vec<&str> =
        solution.upstream.iter().filter_map(|u| Some(leaf(u.missing.as_deref()?))).collect();
    keys.sort_unstable();
    keys.dedup();
    let mut costs: Vec<Cost> = keys.into_iter().filter_map(|key| cost(solution, key)).collect();
    let ratio = |c: &Cost| c.relative / c.relative_without;
    costs.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)));
    costs.truncate(MOST);
    costs
}

/// The key without its wheel.
fn leaf(key: &str) -> &str {
    key.strip_prefix("front.").or_else(|| key.strip_prefix("rear.")).unwrap_or(key)
}

/// The coefficient that a key widens most; `None` where it widens none enough.
fn cost(solution: &Solution, key: &str) -> Option<Cost> {
    // those that may well be zero have no relative width
    let sized =
        |id: &Id| !matches!(id.coefficient, C::MfE1 | C::MfE2 | C::SlipCamberC1 | C::SlipCamberC3);
    let widened = Id::onroad().filter(sized).filter_map(|id| {
        let own = solution.uncertainty(id);
        let value = solution.found.values[id].abs();
        if own.quality.n_samples == 0 || !value.is_finite() {
            return None;
        }
        let all = upstream_variance(solution, id);
        let of_key: f64 = solution
            .upstream
            .iter()
            .filter(|u| u.missing.as_deref().is_some_and(|k| leaf(k) == key))
            .map(|u| u.change.values[id].powi(2))
            .filter(|square| square.is_finite())
            .sum();
        let relative = half(&own, all) / value;
        let relative_without = half(&own, (all - of_key).max(0.0)) / value;
        (relative.is_finite() && relative > LEAST * relative_without).then_some((
            id,
            relative,
            relative_without,
        ))
    });
    let (id, relative, relative_without) =
        widened.max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
    let declared = bike::schema().keys.into_iter().find(|k| leaf(&k.path) == key)?;
    let remedy = declared.remedy.unwrap_or_else(|| "measure it".to_owned());
    Some(Cost { key: key.to_owned(), id, relative, relative_without, remedy })
}

/// Half of a 95 % interval.
fn half(own: &Uncertainty, outside: f64) -> f64 {
    let (std_error, dof) = together(own, outside);
    t95(dof) * std_error
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::coefficient::Part;

    #[test]
    fn a_line_names_key_coefficient_and_remedy() {
        let cost = Cost {
            key: "wheel_inertia".into(),
            id: Id::from((Part::Rear, C::OverturningStiffness)),
            relative: 0.381,
            relative_without: 0.0512,
            remedy: "swing the wheel".into(),
        };
        let want = "wheel_inertia not given: rear overturning_stiffness ±38 % instead of ±5.1 %; \
                    swing the wheel";
        assert_eq!(cost.to_string(), want);
        assert_eq!(leaf("rear.wheel_inertia"), "wheel_inertia");
        assert_eq!(leaf("trail"), "trail");
    }
}
