//! The page of a comparison.

use super::Comparison;
use super::answer::{about, answer, not_comparable, undecided};
use super::numbers::{at_load, change, value};
use super::words::noun;
use crate::report::comparison::{Content, Paragraph, Row};
use crate::report::{Error, comparison, inline_svg, labels};
use crate::statistics::number_format::{typeset, typeset_sentence};
use crate::store::tables::rows::ComparisonRow;

/// The page as HTML: forces at a load (N); `same_tyres` as the comparison was made.
///
/// # Errors
/// The template cannot be rendered: our own mistake.
pub(crate) fn html(found: &Comparison, load: f64, same_tyres: bool) -> Result<String, Error> {
    let (compared, others): (Vec<&ComparisonRow>, Vec<&ComparisonRow>) =
        found.rows.iter().partition(|row| row.difference.is_some());
    let mut tyres: Vec<(String, Vec<Row>)> = Vec::new();
    for row in &compared {
        let title = labels::tyre(&row.tyre);
        if tyres.last().is_none_or(|(last, _)| last != title) {
            tyres.push((title.to_owned(), Vec::new()));
        }
        let a = value(row.value_a, row.ci95_low_a, row.ci95_high_a);
        let b = value(row.value_b, row.ci95_low_b, row.ci95_high_b);
        if let Some((_, rows)) = tyres.last_mut() {
            rows.push(shown(row, noun(&row.coefficient), a, b));
        }
    }
    let curves = at_load(&compared, load);
    let curves = curves.into_iter().map(|c| {
        let name = format!("{} {}", labels::tyre(&c.row.tyre), c.name);
        shown(c.row, &name, c.a, c.b)
    });
    let paragraph = |lines: Vec<String>| {
        let mut lines = lines.into_iter();
        let text = lines.next().unwrap_or_default();
        Paragraph { text, items: lines.map(|l| l.trim().to_owned()).collect() }
    };
    comparison::html(&Content {
        title: [0, 1].map(|i| found.sides[i].text.as_str()).join(" against "),
        sides: [0, 1].map(|i| about(&found.sides[i])),
        sentences: answer(found, same_tyres).iter().map(|s| typeset_sentence(s)).collect(),
        tyres,
        load: format!("{load:.0}"),
        curves: curves.collect(),
        undecided: undecided(&compared).into_iter().map(paragraph).collect(),
        not_comparable: not_comparable(&others),
    })
}

fn shown(row: &ComparisonRow, name: &str, a: String, b: String) -> Row {
    let difference = change(row);
    Row {
        name: name.to_owned(),
        a: typeset(&a),
        b: typeset(&b),
        difference: typeset(&difference.size),
        interval: typeset(&difference.ends),
        bar: inline_svg::difference(row.relative, row.relative_low, row.relative_high),
        chance: difference.chance,
        verdict: difference.verdict,
        sentence: typeset_sentence(&row.sentence),
    }
}
