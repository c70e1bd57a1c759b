//! What the rides of one motorcycle say, number by number.

use std::collections::BTreeMap;

use crate::simulate::effects::Effect;
use crate::statistics::moderated::Scatter;
use crate::store::tables::rows::{Circumstances, EffectTrace, EstimateRow, Ident};

/// A number of table `estimates`.
#[derive(Debug, Clone)]
pub(crate) struct Number {
    /// The parameter of the nominal model, or the effect.
    pub name: String,
    /// Unit of the value.
    pub unit: String,
    /// The effect whose size it is; `None` of a parameter of the nominal model.
    pub effect: Option<&'static Effect>,
}

#[derive(Debug, Clone)]
pub struct Ride {
    pub ident: Ident,
    /// Where, by whom and on what tyres.
    pub circumstances: Circumstances,
    /// Rows of `estimates`.
    pub estimates: Vec<EstimateRow>,
    /// Rows of `effect_traces`.
    pub traces: Vec<EffectTrace>,
}

/// The numbers of one motorcycle's rides, in order of time.
#[derive(Debug, Clone)]
pub(crate) struct History {
    /// Session and bike of each ride.
    pub rides: Vec<Ident>,
    /// By ride where, by whom and on what tyres.
    pub circumstances: Vec<Circumstances>,
    /// The numbers, in order of their names.
    pub numbers: Vec<Number>,
    /// By number and ride; not a number where a ride has none.
    pub values: Vec<Vec<f64>>,
    /// Standard errors from noise and priors, likewise.
    pub errors: Vec<Vec<f64>>,
    /// Variances, likewise, of what may be left of changes that were taken out.
    pub remainder_variance: Vec<Vec<f64>>,
    /// By effect: its name's place in `numbers`, and by ride what a unit of it moves each number by.
    pub traces: Vec<(usize, Vec<Vec<f64>>)>,
    /// Of each number what other motorcycles teach of its scatter.
    pub scatter: Vec<Scatter>,
    /// Likewise of the sum of numbers that shows an effect, at the effect's place.
    pub scatter_of_sums: Vec<Scatter>,
}

impl History {
    /// Of a motorcycle's rides, in any order.
    pub(crate) fn new(mut rides: Vec<Ride>) -> Self {
        // rides without a time come first, by their names
        let order = |r: &Ride| (r.ident.start_time.clone(), r.ident.session_id.clone());
        rides.sort_by_key(order);
        Self::of(&rides)
    }

    /// Of a motorcycle's rides in this order.
    pub(crate) fn of(rides: &[Ride]) -> Self {
        let mut places: BTreeMap<&str, &EstimateRow> = BTreeMap::new();
        for row in rides.iter().flat_map(|r| &r.estimates) {
            places.entry(&row.parameter).or_insert(row);
        }
        let number = |row: &EstimateRow| {
            let effect = (row.part == "effect").then(|| Effect::named(&row.parameter).ok());
            let (name, unit) = (row.parameter.clone(), row.unit.clone());
            Number { name, unit, effect: effect.flatten() }
        };
        let numbers: Vec<Number> = places.values().map(|row| number(row)).collect();
        let place: BTreeMap<&str, usize> = places.keys().copied().zip(0..).collect();
        let blank = || vec![vec![f64::NAN; rides.len()]; numbers.len()];
        let (mut values, mut errors) = (blank(), blank());
        for (i, ride) in rides.iter().enumerate() {
            for row in &ride.estimates {
                let p = place[row.parameter.as_str()];
                if row.value.is_finite() && row.std_error > 0.0 && row.std_error.is_finite() {
                    (values[p][i], errors[p][i]) = (row.value, row.std_error);
                }
            }
        }
        let trace = |effect: usize| {
            let name = &numbers[effect].name;
            let of_ride = |ride: &Ride| {
                let mut moved = vec![0.0; numbers.len()];
                for row in ride.traces.iter().filter(|t| t.effect == *name && t.slope.is_finite()) {
                    if let Some(p) = place.get(row.parameter.as_str()) {
                        moved[*p] = row.slope;
                    }
                }
                moved
            };
            (effect, rides.iter().map(of_ride).collect())
        };
        let effects = (0..numbers.len()).filter(|p| numbers[*p].effect.is_some());
        let traces = effects.map(trace).collect();
        let idents = rides.iter().map(|r| r.ident.clone()).collect();
        let circumstances = rides.iter().map(|r| r.circumstances.clone()).collect();
        let scatter = vec![Scatter::default(); numbers.len()];
        let scatter_of_sums = scatter.clone();
        let remainder_variance = vec![vec![0.0; rides.len()]; numbers.len()];
        History {
            rides: idents,
            circumstances,
            numbers,
            values,
            errors,
            remainder_variance,
            traces,
            scatter,
            scatter_of_sums,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.rides.len()
    }

    /// The date of a ride.
    pub(crate) fn day(&self, ride: usize) -> Option<&str> {
        self.rides[ride].start_time.as_deref().and_then(|t| t.get(..10))
    }
}
