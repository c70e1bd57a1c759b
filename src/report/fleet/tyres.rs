//! What all rides say of each tyre, and of the numbers of the bike files: the tables `tyres` and `bikes` as lists.

use std::path::Path;

use crate::contract::coefficient::Coefficient as C;
use crate::report::error::Error;
use crate::report::labels;
use crate::report::list::{self, Cell, List, column, number};
use crate::statistics::number_format::{self, decimals_of, fixed};
use crate::store::tables::read;
use crate::store::tables::rows::{BikeRow, TyreRow};

/// The coefficients by which people tell tyres apart; the others are in the table.
const SHOWN: [C; 5] = [
    C::EffectiveRollingRadius,
    C::MfD,
    C::SlipStiffness,
    C::CorneringStiffness0,
    C::CamberStiffness0,
];

/// Of the variance of an estimate, what all rides share limits it from here on.
const SHARED: f64 = 0.5;

#[derive(Debug, Default)]
pub(crate) struct Tyres {
    /// Rows of `tyres` that are shown: tyre models first, then bike by bike.
    pub tyres: Vec<TyreRow>,
    /// Tyres on motorcycles, of all coefficients.
    pub specimens: usize,
    /// Rows of `bikes` that the rides doubt.
    pub doubted: Vec<BikeRow>,
}

impl Tyres {
    /// Reads what is there.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn read(out: &Path) -> Result<Self, Error> {
        let rows: Vec<TyreRow> = read::rows(out)?;
        let mut specimens: Vec<(&str, &str, i64)> = rows
            .iter()
            .filter_map(|r| Some((r.bike_id.as_deref()?, r.tyre.as_str(), r.specimen?)))
            .filter(|(_, tyre, _)| *tyre != "vehicle")
            .collect();
        specimens.sort_unstable();
        specimens.dedup();
        let specimens = specimens.len();
        // a model of one tyre is that tyre
        let is_shown = |r: &TyreRow| {
            (r.bike_id.is_some() || r.n_tyres > 1)
                && SHOWN.iter().any(|c| c.name() == r.coefficient)
        };
        let mut tyres: Vec<TyreRow> = rows.into_iter().filter(is_shown).collect();
        tyres.sort_by_key(|r| {
            let order = labels::order(&r.tyre, &r.coefficient);
            (r.bike_id.clone(), order.0, r.tyre_model.clone(), r.specimen, order.2)
        });
        let mut doubted: Vec<BikeRow> = read::rows(out)?;
        doubted.retain(|row| row.reason.is_some());
        doubted.sort_by(|a, b| {
            b.shift.abs().total_cmp(&a.shift.abs()).then_with(|| a.bike_id.cmp(&b.bike_id))
        });
        Ok(Tyres { tyres, specimens, doubted })
    }

    /// How many tyres, and what limits them, as a sentence; empty where there is none.
    pub(crate) fn summary(&self) -> String {
        if self.specimens == 0 {
            return String::new();
        }
        let of_bikes = self.tyres.iter().filter(|r| r.bike_id.is_some());
        let (mut all, mut shared) = (0, 0);
        for row in of_bikes {
            all += 1;
            shared += usize::from(row.shared_share.is_some_and(|s| s > SHARED));
        }
        format!(
            "{}; of {all} estimates {shared} are limited by what all rides of a bike share, which more rides do not cure.",
            number_format::count(self.specimens, "tyre"),
        )
    }
}

/// The list of tyres.
pub(crate) fn tyres(rows: &[TyreRow]) -> List {
    List {
        label: "Tyres",
        words: "bike, tyre, model, coefficient",
        class: "tyres",
        table: "tyres",
        page: list::OTHERS,
        columns: vec![
            column("Tyre", ""),
            column("Coefficient", ""),
            number("Value", "value"),
            number("95 % interval", "95 %"),
            number("Sessions", "sessions"),
            number("Median of sessions", "median"),
            number("Shared", "shared"),
            column("Limited by", "why"),
        ],
        rows: rows.iter().map(tyre).collect(),
    }
}

fn tyre(r: &TyreRow) -> Vec<Cell> {
    let whose = match (&r.bike_id, &r.tyre_model, r.specimen) {
        (None, Some(model), _) => {
            format!("{model}, {}, {}", r.tyre, number_format::count(r.n_tyres as usize, "tyre"))
        }
        (Some(bike), Some(model), _) => format!("{bike}, {}, {model}", r.tyre),
        (Some(bike), None, Some(n)) if n > 0 => format!("{bike}, {} no. {}", r.tyre, n + 1),
        (bike, ..) => format!("{}, {}", bike.as_deref().unwrap_or_default(), r.tyre),
    };
    let digits = decimals_of(r.value, Some(r.std_error));
    let of = |x: f64| Cell::Keyed { text: fixed(x, digits), key: x };
    let unit = labels::unit(&r.unit);
    let name = labels::coefficient(&r.coefficient);
    let name = if unit.is_empty() { name.to_owned() } else { format!("{name}, {unit}") };
    let (shared, key) = match r.shared_share {
        Some(share) => (format!("{} %", fixed(100.0 * share, 0)), share),
        None => (String::new(), -1.0),
    };
    let limited = labels::spaced(&r.limited_by);
    vec![
        Cell::Text(whose),
        Cell::Text(name),
        of(r.value),
        Cell::Keyed {
            text: format!("{} to {}", fixed(r.ci95_low, digits), fixed(r.ci95_high, digits)),
            key: r.ci95_high - r.ci95_low,
        },
        Cell::of(r.n_sessions),
        of(r.median),
        Cell::Keyed { text: shared, key },
        Cell::Text(match r.limited_share {
            Some(share) if r.bike_id.is_some() => {
                format!("{limited} ({} %)", fixed(100.0 * share, 0))
            }
            _ => limited,
        }),
    ]
}

/// The list of numbers of the bike files that the rides doubt.
pub(crate) fn bikes(rows: &[BikeRow]) -> List {
    List {
        label: "Bike files",
        words: "bike, number",
        class: "bikes",
        table: "bikes",
        page: list::OTHERS,
        columns: vec![
            column("Bike", ""),
            column("Number", ""),
            column("What the rides say", ""),
            number("Standard errors away", "standard errors"),
            number("Sessions", "sessions"),
        ],
        rows: rows
            .iter()
            .map(|r| {
                vec![
                    Cell::Text(r.bike_id.clone()),
                    Cell::Text(labels::spaced(&r.source)),
                    Cell::Text(number_format::typeset(r.reason.as_deref().unwrap_or_default())),
                    Cell::Keyed { text: number_format::typeset(&fixed(r.shift, 1)), key: r.shift },
                    Cell::of(r.n_sessions),
                ]
            })
            .collect(),
    }
}
