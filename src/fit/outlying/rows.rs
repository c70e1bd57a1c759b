//! Outlying manoeuvres as rows of their table and as sentences.

use super::place::{self, Place};
use super::quantity::{Fitted, Outlying};
use crate::contract::warning::{OUTLYING_MANOEUVRE, Warning};
use crate::statistics::number_format::{decimals, fixed};
use crate::store::tables::rows::{Ident, OutlyingManoeuvre};

/// The rows of `outlying_manoeuvres`.
pub(crate) fn rows(
    fitted: &Fitted<'_>,
    found: &[Outlying],
    ident: &Ident,
) -> Vec<OutlyingManoeuvre> {
    let row = |o: &Outlying| {
        let (c, segment) = (&o.compared, &fitted.segments[o.compared.segment]);
        let place = place::of(fitted.session, segment);
        OutlyingManoeuvre {
            ident: ident.clone(),
            manoeuvre_id: c.segment as i64,
            kind: segment.kind.name().to_owned(),
            start: fitted.session.time(segment.start),
            end: fitted.session.time(segment.end),
            quantity: o.quantity.name.to_owned(),
            unit: o.quantity.unit.to_owned(),
            value: c.value,
            expected: c.expected,
            difference: c.value - c.expected,
            ci95_low: c.interval[0],
            ci95_high: c.interval[1],
            n_others: c.others as i64,
            chance: c.t.is_finite().then_some((c.chance * o.comparisons as f64).min(1.0)),
            cause: o.cause().to_owned(),
            distance: place.distance,
            latitude: place.latitude,
            longitude: place.longitude,
        }
    };
    found.iter().map(row).collect()
}

/// A sentence for each: what differed where, by how much, and what it may be.
pub(crate) fn warnings(fitted: &Fitted<'_>, found: &[Outlying]) -> Vec<Warning> {
    let warning = |o: &Outlying| {
        let start = fitted.session.time(fitted.segments[o.compared.segment].start);
        Warning {
            stage: "fit",
            code: OUTLYING_MANOEUVRE,
            channel: None,
            count: 1,
            time: Some(start),
            message: o.sentence(fitted),
        }
    };
    found.iter().map(warning).collect()
}

impl Outlying {
    /// Possible cause.
    fn cause(&self) -> &'static str {
        let larger = self.compared.value > self.compared.expected;
        self.quantity.causes[usize::from(!larger)]
    }

    fn sentence(&self, fitted: &Fitted<'_>) -> String {
        let (c, segment) = (&self.compared, &fitted.segments[self.compared.segment]);
        let kind = segment.kind.name().replace('_', " ");
        let start = fixed(fitted.session.time(segment.start), 1);
        let place = whereabouts(&place::of(fitted.session, segment));
        let (unit, scale) = self.quantity.shown;
        let (words, cause) = (self.quantity.words, self.cause());
        if c.t.is_infinite() {
            let size = fixed(scale * c.value, 2);
            return format!(
                "{kind} at {start} s{place}: {words} {size} {unit} while the motorcycle moved; {cause}"
            );
        }
        let size = scale * (c.value - c.expected);
        let mut ends = c.interval.map(|end| scale * end * size.signum());
        ends.sort_by(f64::total_cmp);
        let digits = decimals((ends[1] - ends[0]) / 4.0);
        let [low, high] = ends.map(|end| fixed(end, digits));
        let size_words = fixed(size.abs(), digits);
        let way = if size > 0.0 { "more" } else { "less" };
        let others = c.others;
        format!(
            "{kind} at {start} s{place}: {size_words} {unit} {way} {words} ({low} to {high}) than the ride's {others} \
             others; possible cause: {cause}"
        )
    }
}

/// Where the middle of a manoeuvre is, in brackets; empty where the log does not say.
fn whereabouts(place: &Place) -> String {
    let ridden = place.distance.map(|d| format!("{} km from the start", fixed(d / 1000.0, 2)));
    let at = place.latitude.zip(place.longitude);
    let at = at.map(|(latitude, longitude)| format!("{latitude:.5}, {longitude:.5}"));
    let parts: Vec<String> = ridden.into_iter().chain(at).collect();
    if parts.is_empty() { String::new() } else { format!(" ({})", parts.join("; ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manoeuvre_is_found_again_by_distance_and_position() {
        let place = Place { distance: Some(3814.3), latitude: Some(45.5), longitude: Some(-7.25) };
        assert_eq!(whereabouts(&place), " (3.81 km from the start; 45.50000, -7.25000)");
        let unplaced = Place { distance: Some(3814.3), latitude: None, longitude: None };
        assert_eq!(whereabouts(&unplaced), " (3.81 km from the start)");
        let nothing = Place { distance: None, latitude: None, longitude: None };
        assert_eq!(whereabouts(&nothing), "");
    }
}
