//! What the numbers cost that the bike file does not have or is not sure of.

use super::coefficients::{Estimate, estimate};
use super::solution::{Solution, Upstream};
use crate::contract::bike;
use crate::contract::coefficient::{Coefficient as C, Id};
use crate::contract::schema::Key;
use crate::statistics::clustered_fit::Uncertainty;
use crate::statistics::interval::t95;
use crate::store::tables::rows::Coefficient;

/// Most missing keys that a message lists.
const MAX_KEYS: usize = 3;
/// Widening of an interval from which a message lists the key.
const LEAST: f64 = 1.2;
/// Half of an interval over its value: what is wider with an exact key is unknown either way, and the key no cost.
const USEFUL: f64 = 1.0;

/// Cost of a key that the bike file does not have, or gives with an uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cost {
    /// The key; without `front.` and `rear.`, which are taken together.
    pub key: String,
    /// The coefficient that it widens most.
    pub id: Id,
    /// Half of the 95 % interval over the value, as it is; of a quotient by its standard error.
    pub relative: f64,
    /// The same if the key were exact.
    pub relative_without: f64,
    /// Whether the bike file gives it, with an uncertainty.
    pub given: bool,
    /// How the number is found.
    pub remedy: String,
}

impl std::fmt::Display for Cost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Cost { key, id, relative, relative_without, given, remedy } = self;
        let [now, then] = [relative, relative_without].map(|share| percent(*share));
        let how = if *given { "is uncertain" } else { "not given" };
        write!(f, "{key} {how}: {id} ±{now} % instead of ±{then} %; {remedy}")
    }
}

/// Percentage, in whole numbers above ten.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 9.95 { format!("{percent:.1}") } else { format!("{percent:.0}") }
}

/// The keys whose want or uncertainty costs most, at most three, the most costly first; of all that was fitted.
pub(crate) fn costs(solution: &Solution) -> Vec<Cost> {
    costs_where(solution, |_| true)
}

/// The same, of coefficients that the session's table has as they were fitted.
pub(crate) fn costs_of_rows(solution: &Solution, rows: &[Coefficient]) -> Vec<Cost> {
    costs_where(solution, |id| is_stated(rows, id, solution.found.values[id]))
}

/// Whether the table has a value, and that is the fitted one: what another fit gave has other errors.
fn is_stated(rows: &[Coefficient], id: Id, fitted: f64) -> bool {
    let row = rows.iter().find(|r| Id::from_names(&r.tyre, &r.coefficient) == Some(id));
    let value = row.and_then(|r| r.value);
    value.is_some_and(|value| (value - fitted).abs() <= 1e-9 * value.abs())
}

fn costs_where(solution: &Solution, is_asked: impl Fn(Id) -> bool) -> Vec<Cost> {
    let declared: &[Key] = &bike::schema().keys;
    let is_key = |u: &&Upstream| declared.iter().any(|k| k.path == u.source.name);
    let mut keys: Vec<&str> =
        solution.upstream.iter().filter(is_key).map(|u| leaf(&u.source.name)).collect();
    keys.sort_unstable();
    keys.dedup();
    let widths = widths(solution, is_asked);
    let of_key =
        |key: &str| cost(solution, &widths, key, declared.iter().find(|k| leaf(&k.path) == key)?);
    let mut costs: Vec<Cost> = keys.into_iter().filter_map(of_key).collect();
    let ratio = |c: &Cost| c.relative / c.relative_without;
    costs.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)));
    costs.truncate(MAX_KEYS);
    costs
}

/// The key without its wheel.
fn leaf(key: &str) -> &str {
    key.strip_prefix("front.").or_else(|| key.strip_prefix("rear.")).unwrap_or(key)
}

/// How wide a fitted coefficient's interval is with everything upstream.
struct Width {
    id: Id,
    own: Uncertainty,
    estimate: Estimate,
    /// Half the interval over the value.
    relative: f64,
}

/// Of every coefficient that was fitted and is asked for, but for those that may well be zero: they have no relative width.
fn widths(solution: &Solution, is_asked: impl Fn(Id) -> bool) -> Vec<Width> {
    let sized =
        |id: &Id| !matches!(id.coefficient, C::MfE1 | C::MfE2 | C::SlipCamberC1 | C::SlipCamberC3);
    let all: Vec<&Upstream> = solution.upstream.iter().collect();
    let width = |id: Id| {
        let own = solution.uncertainty(id);
        if own.quality.n_samples == 0 {
            return None;
        }
        let estimate = estimate(solution, &all, &solution.inputs.bike, id, &own);
        let relative = relative(solution, id, &estimate);
        relative.is_finite().then_some(Width { id, own, estimate, relative })
    };
    Id::onroad().filter(sized).filter(|id| is_asked(*id)).filter_map(width).collect()
}

/// The coefficient that a key widens most; `None` where it widens none enough.
fn cost(solution: &Solution, widths: &[Width], key: &str, declared: &Key) -> Option<Cost> {
    let of_key = |u: &&Upstream| leaf(&u.source.name) == key;
    let others: Vec<&Upstream> = solution.upstream.iter().filter(|u| !of_key(u)).collect();
    let widened = widths.iter().filter_map(|with| {
        let without = estimate(solution, &others, &solution.inputs.bike, with.id, &with.own);
        // its degrees of freedom are fewer, so its quantile is larger: the intervals differ by less than the errors
        if with.estimate.std_error <= LEAST * without.std_error {
            return None;
        }
        let without = relative(solution, with.id, &without);
        is_cost(with.relative, without).then_some((with.id, with.relative, without))
    });
    let (id, relative, relative_without) =
        widened.max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
    let given = solution.upstream.iter().filter(of_key).all(|u| u.missing.is_none());
    let remedy = declared.remedy.clone().unwrap_or_else(|| "measure it".to_owned());
    Some(Cost { key: key.to_owned(), id, relative, relative_without, given, remedy })
}

/// Whether a coefficient would be known, and better, if the key were exact.
fn is_cost(with: f64, without: f64) -> bool {
    with > LEAST * without && without < USEFUL
}

/// Half of a 95 % interval over the value.
fn relative(solution: &Solution, id: Id, found: &Estimate) -> f64 {
    t95(found.dof) * found.std_error / solution.found.values[id].abs()
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
            given: false,
            remedy: "swing the wheel".into(),
        };
        let want = "wheel_inertia not given: rear overturning_stiffness ±38 % instead of ±5.1 %; \
                    swing the wheel";
        assert_eq!(cost.to_string(), want);
        let uncertain = Cost { given: true, ..cost }.to_string();
        assert_eq!(uncertain, want.replace("not given", "is uncertain"));
        assert_eq!(leaf("rear.wheel_inertia"), "wheel_inertia");
        assert_eq!(leaf("trail"), "trail");
    }

    /// A rear tyre that was hardly braked: the table has no value, and no key would have given one.
    #[test]
    fn what_has_no_value_costs_nothing() {
        assert!(is_cost(0.38, 0.05) && is_cost(3.0, 0.9));
        assert!(!is_cost(0.38, 0.37), "as wide without");
        assert!(!is_cost(394.19, 76.59), "unknown either way");
        let id = Id::from((Part::Rear, C::MfD));
        let row = |value| Coefficient {
            tyre: "rear".into(),
            coefficient: "mf_d".into(),
            value,
            ..Coefficient::default()
        };
        assert!(is_stated(&[row(Some(1.1))], id, 1.1));
        assert!(!is_stated(&[row(None)], id, 1.1));
        assert!(!is_stated(&[row(Some(0.9))], id, 1.1), "of another fit");
        assert!(!is_stated(&[row(Some(1.1))], Id::from((Part::Front, C::MfD)), 1.1));
    }
}
