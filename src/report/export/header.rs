//! A fitted tyre as a C99 header that evaluates it (`tyre.h` with the numbers filled in).

use std::fmt::Write as _;

use super::ends::Ends;
use super::file::one_line;
use super::fitted::Fitted;
use super::numbers::{self, Number};
use super::origins;
use super::tyre::{Characterised, effects_of};

use crate::report::export::error::Error;

const TEMPLATE: &str = include_str!("tyre.h");

/// The header of some tyres of one session.
///
/// # Errors
/// A sentence that names the tyre of which a half was not ridden: the header evaluates whole tyres.
pub(crate) fn write(fitted: &Fitted, tyres: &[Characterised]) -> Result<String, Error> {
    let session = &fitted.session;
    let mut constants = String::new();
    for tyre in tyres {
        if let Some(half) = tyre.missing_half() {
            return Err(Error::NoValue(half));
        }
        constants.push_str(&self::tyre(fitted, tyre));
    }
    let mut who = String::new();
    let models = [&session.tyre_front, &session.tyre_rear];
    for line in [
        format!(
            "Tyres of {}, session {}, fitted by roadbench {}.",
            session.ident.bike_id, session.ident.session_id, session.provenance.version
        ),
        format!("Input {}", session.provenance.input_hash),
        format!("Pipeline {}", session.provenance.pipeline_hash),
    ]
    .into_iter()
    .chain(models.into_iter().flatten().map(|m| format!("Tyre model {m}")))
    .chain(tyres.iter().flat_map(Characterised::adjustment))
    .chain(tyres.iter().map(Characterised::share_line))
    .chain(tyres.iter().flat_map(|c| origins::following(fitted, c)))
    .chain(effects_of(tyres, &[]))
    {
        let _ = writeln!(who, " * {}", comment(&line));
    }
    let fields: Vec<String> = numbers::ALL.iter().map(field).collect();
    let first = tyres.first().map_or("front", |t| t.axle.name());
    Ok(TEMPLATE
        .replace("@@WHO@@", who.trim_end())
        .replace("@@FIRST@@", first)
        .replace("@@FIELDS@@", &fields.join("\n"))
        .replace("@@TYRES@@\n", &constants))
}

fn tyre(fitted: &Fitted, c: &Characterised) -> String {
    let ends = Ends::of(c);
    let mut out = format!("\nstatic const roadbench_tyre roadbench_{} = {{\n", c.axle.name());
    for number in numbers::ALL {
        // the shortest digits that read back to the same number
        let value = (number.value)(c, &ends);
        let from = origins::of(fitted, c, number.name);
        let from = from.map_or(String::new(), |from| format!(" /* {} */", comment(&from)));
        let _ = writeln!(out, "    .{} = {value:?},{from}", number.name);
    }
    out + "};\n"
}

fn field(number: &Number) -> String {
    let unit = if number.unit.is_empty() { String::new() } else { format!(", {}", number.unit) };
    format!("    double {}; /* {}{unit} */", number.name, number.meaning)
}

/// A log's text can neither end the comment nor begin a trigraph or a continued line.
fn comment(text: &str) -> String {
    one_line(text).replace("*/", "* /").replace("/*", "/ *").replace(['\\', '?'], "_")
}
