//! The bikes of a large run in a list: those first of which there is something to say.

use crate::contract::coefficient::{Coefficient, Part};
use crate::report::list::{self, Cell, List, column, number};
use crate::report::run::bikes::{BikePart, Overview};
use crate::statistics::number_format::{self, fixed};
use crate::statistics::order::median_of_finite;

/// Medians that the list shows, and that a bike may be far off in; in words.
const SHOWN: [(Part, Coefficient, &str); 4] = [
    (Part::Front, Coefficient::MfD, "front peak friction"),
    (Part::Rear, Coefficient::MfD, "rear peak friction"),
    (Part::Front, Coefficient::CorneringStiffness0, "front cornering stiffness"),
    (Part::Rear, Coefficient::CorneringStiffness0, "rear cornering stiffness"),
];
/// Robust standard deviations from the other bikes from which on it is worth a word.
const FAR: f64 = 3.0;

/// Remarks about a bike.
struct Notable<'a> {
    part: &'a BikePart,
    page: &'a str,
    events: usize,
    /// The median that is farthest from the other bikes', in their spread, and its place in [`SHOWN`].
    farthest: Option<(f64, usize)>,
}

fn median<'a>(part: &'a BikePart, shown: (Part, Coefficient, &str)) -> Option<&'a Overview> {
    let (tyre, coefficient, _) = shown;
    let mut rows = part.tyres.iter().flat_map(|t| &t.rows);
    rows.find(|r| r.tyre == tyre.name() && r.name == coefficient.name())
}

impl Notable<'_> {
    fn why(&self) -> String {
        let mut why = Vec::new();
        if self.events > 0 {
            why.push(number_format::count(self.events, "change"));
        }
        if self.part.outlying > 0 {
            why.push(number_format::count(self.part.outlying, "outlying session"));
        }
        if let Some((far, which)) = self.farthest.filter(|(far, _)| far.abs() >= FAR) {
            let words = SHOWN[which].2;
            let than = if far > 0.0 { "above" } else { "below" };
            let far = fixed(far.abs(), 1);
            why.push(format!("{words} {far} spreads {than} the other bikes'"));
        }
        why.join("; ")
    }
}

/// The bikes with their `pages`, the most notable first: by changes, by outlying sessions, by distance
/// from the other bikes. `events` counts a bike's changes.
pub(crate) fn list(bikes: &[BikePart], pages: &[String], events: impl Fn(&str) -> usize) -> List {
    let centres = SHOWN.map(|what| {
        let values: Vec<f64> =
            bikes.iter().filter_map(|b| median(b, what).and_then(|r| r.value)).collect();
        median_of_finite(&values).zip(number_format::robust_sd(&values).filter(|sd| *sd > 0.0))
    });
    let mut notable: Vec<Notable<'_>> = bikes
        .iter()
        .zip(pages)
        .map(|(part, page)| {
            let far = SHOWN.iter().zip(centres).enumerate().filter_map(|(i, (what, centre))| {
                let (centre, sd) = centre?;
                Some(((median(part, *what)?.value? - centre) / sd, i))
            });
            let farthest = far.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
            Notable { part, page, events: events(&part.bike_id), farthest }
        })
        .collect();
    let distance = |n: &Notable<'_>| n.farthest.map_or(0.0, |f| f.0.abs());
    notable.sort_by(|a, b| {
        (b.events, b.part.outlying)
            .cmp(&(a.events, a.part.outlying))
            .then(distance(b).total_cmp(&distance(a)))
    });
    List {
        label: "Bikes",
        words: "bike, why",
        class: "bikes",
        table: "fleet",
        page: list::OTHERS,
        columns: vec![
            column("Bike", ""),
            number("Sessions", "sessions"),
            number("Front peak friction", "front peak friction"),
            number("Rear peak friction", "rear peak friction"),
            number("Front cornering stiffness, 1/rad", "front cornering stiffness, 1/rad"),
            number("Rear cornering stiffness, 1/rad", "rear cornering stiffness, 1/rad"),
            column("Worth a look", "why"),
        ],
        rows: notable.iter().map(row).collect(),
    }
}

fn row(bike: &Notable<'_>) -> Vec<Cell> {
    let mut cells =
        vec![Cell::page(&bike.part.bike_id, bike.page, true), Cell::of(bike.part.sessions)];
    cells.extend(SHOWN.map(|what| {
        Cell::Text(median(bike.part, what).map(|r| r.median.clone()).unwrap_or_default())
    }));
    cells.push(Cell::Text(bike.why()));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::bikes::TyrePart;

    fn bike(id: &str, friction: f64, outlying: usize) -> BikePart {
        let row = Overview {
            tyre: "front".into(),
            name: "mf_d".into(),
            value: Some(friction),
            median: format!("{friction:.2}"),
            ..Overview::default()
        };
        let tyre = TyrePart { rows: vec![row], ..TyrePart::default() };
        BikePart { bike_id: id.into(), outlying, tyres: vec![tyre], ..BikePart::default() }
    }

    #[test]
    fn bikes_with_changes_come_first_then_outlying_sessions_then_the_far_ones() {
        let bikes = [
            bike("a", 1.0, 0),
            bike("b", 1.01, 0),
            bike("c", 0.99, 1),
            bike("d", 1.5, 0),
            bike("e", 1.02, 0),
        ];
        let pages = ["a", "b", "c", "d", "e"].map(|p| format!("bike_{p}.html"));
        let list = list(&bikes, &pages, |id| usize::from(id == "b"));
        let text = |row: usize, k: usize| match &list.rows[row][k] {
            Cell::Text(text) | Cell::Page { text, .. } => text.as_str(),
            other => panic!("{other:?}"),
        };
        assert_eq!([0, 1, 2].map(|i| text(i, 0)), ["b", "c", "d"]);
        assert_eq!([0, 1].map(|i| text(i, 6)), ["1 change", "1 outlying session"]);
        assert!(text(2, 6).contains("spreads above the other bikes'"), "{}", text(2, 6));
        assert_eq!(text(2, 2), "1.50");
    }
}
