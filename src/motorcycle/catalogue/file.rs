//! The bike file as text: every number with its unit, where it is from, its uncertainty, what that costs and how the
//! number is measured at home.

use std::fmt::Write as _;
use std::path::Path;

use super::classes::{Catalogue, Cost};
use super::numbers::Number;
use super::owner::Portrait;
use crate::contract::bike::{Bike, schema};
use crate::contract::key_error::KeyError;
use crate::contract::schema::{Key, KeyTable};

/// Changes of a coefficient below this are not said, %.
const LEAST_COST: f64 = 0.5;
/// Longest line of a remark.
const LINE: usize = 110;

/// The text of a portrait's bike file, checked by the reader that `run` has.
///
/// # Errors
/// A number is out of its physical range; a sentence that names the key.
pub fn text(portrait: &Portrait, bike_id: &str) -> Result<String, KeyError> {
    let schema = schema();
    let mut out = head(portrait);
    let name = portrait.texts.get("name").cloned();
    let name = name.or(portrait.model.map(|m| m.name.clone()));
    let name = name.unwrap_or_else(|| bike_id.to_owned());
    let _ = writeln!(out, "name = {}\n", toml::Value::String(name));
    let tables = ["", "front", "rear", "aerodynamics", "brakes", "sensors", "offroad"];
    for table in tables {
        let mut numbers = portrait.numbers.iter().filter(|n| of_table(&n.key) == table).peekable();
        let texts: Vec<_> =
            portrait.texts.iter().filter(|(k, _)| *k != "name" && of_table(k) == table).collect();
        let left = left_out(schema, portrait, table);
        if !table.is_empty() && (numbers.peek().is_some() || !texts.is_empty()) {
            let _ = writeln!(out, "[{table}]");
        }
        for (key, value) in texts {
            let _ = writeln!(out, "{} = {}", leaf(key), toml::Value::String(value.clone()));
        }
        for number in numbers {
            entry(&mut out, number, schema);
        }
        out += &left;
    }
    out += "# One standard deviation of each, in its unit: what the intervals of the coefficients carry.\n";
    out += "[uncertainty]\n";
    for n in portrait.numbers.iter().filter(|n| n.known.sd > 0.0) {
        let _ = writeln!(out, "\"{}\" = {}", n.key, rounded(n.known.sd, n.known.sd));
    }
    Bike::parse(&out, bike_id, Path::new(&format!("{bike_id}.toml")))
        .map_err(|e| KeyError::Values(e.to_string()))?;
    Ok(out)
}

fn head(portrait: &Portrait) -> String {
    let of = match portrait.model {
        Some(model) => format!("{}, class {}", model.name, portrait.class.name),
        None => format!("class {}: {}", portrait.class.name, portrait.class.description),
    };
    let [front, rear] = [0, 1].map(|k| {
        let said = if portrait.sizes_said[k] { "" } else { " (a guess)" };
        format!("{}{said}", portrait.sizes[k].printed)
    });
    let mut out = String::new();
    remark(
        &mut out,
        "",
        &format!("Written by `roadbench bike new`, {of}; tyres {front} and {rear}."),
    );
    remark(
        &mut out,
        "",
        "Numbers that are guesses may stay: the intervals of the coefficients are as much wider as the guesses are \
         uncertain. To make one better measure it, write it here and its standard deviation under [uncertainty].",
    );
    out.push('\n');
    out
}

/// A number with its remarks.
fn entry(out: &mut String, number: &Number, schema: &KeyTable) {
    let Number { key, known, origin, source } = number;
    let declared = schema.keys.iter().find(|k| k.path == *key);
    let unit = declared.and_then(|k| k.unit.as_deref()).filter(|u| *u != "1").unwrap_or("");
    let what = declared.map_or("", |k| k.description.as_str());
    let first = what.split([';', ':', '(']).next().unwrap_or(what).trim_end();
    remark(out, "", first.trim_end_matches('.'));
    let width = match known.sd > 0.0 {
        true => format!("± {} {unit}", rounded(known.sd, known.sd)),
        false => "exact".to_owned(),
    };
    let because = if source.is_empty() { String::new() } else { format!(" ({source})") };
    remark(out, "  ", &format!("{}: {}{because}", origin.name(), width.trim_end()));
    if origin.is_guess()
        && let Some(measure) = Catalogue::builtin().measure(key)
    {
        if let Some(cost) = cost_of(number) {
            remark(out, "  ", &format!("costs: {cost}"));
        }
        let better = measure.sd(known.value);
        let better = format!("; then ± {} {unit}", rounded(better, better));
        remark(out, "  ", &format!("at home: {}{}", measure.home, better.trim_end()));
    }
    let _ = writeln!(out, "{} = {}\n", leaf(key), rounded(known.value, known.sd));
}

/// Costs of a number's uncertainty, the most first.
pub(crate) fn cost_of(number: &Number) -> Option<String> {
    let measure = Catalogue::builtin().measure(&number.key)?;
    let relative = 100.0 * number.known.sd / number.known.value.abs();
    let axle = number.key.split_once('.').map(|(axle, _)| axle);
    let axle = axle.filter(|a| ["front", "rear"].contains(a));
    let other = |c: &Cost| {
        let end = if axle == Some("front") { "rear" } else { "front" };
        axle.is_some() && c.of.starts_with(end)
    };
    let mut costs: Vec<(f64, &str)> = measure
        .costs
        .iter()
        .filter(|c| !other(c))
        .map(|c| (c.elasticity.abs() * relative, c.of.as_str()))
        .filter(|(percent, _)| *percent >= LEAST_COST)
        .collect();
    costs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let said: Vec<String> =
        costs.iter().take(3).map(|(percent, of)| format!("{of} ± {percent:.1} %")).collect();
    if said.is_empty() { None } else { Some(said.join(", ")) }
}

/// Keys of a table that are left to their defaults.
fn left_out(schema: &KeyTable, portrait: &Portrait, table: &str) -> String {
    let mut out = String::new();
    let missing = |k: &&Key| {
        let given = portrait.numbers.iter().any(|n| n.key == k.path);
        of_table(&k.path) == table && !given && k.kind == "number"
    };
    for key in schema.keys.iter().filter(missing) {
        let value = key.default.or(key.assumed);
        let unit = key.unit.as_deref().filter(|u| *u != "1").map(|u| format!(" {u}"));
        let width = key.default_uncertainty;
        let width = width.map(|sd| format!("± {sd}{}", unit.unwrap_or_default()));
        let relative = key.default_relative_uncertainty.map(|s| format!("± {:.0} %", 100.0 * s));
        let Some(width) = width.or(relative) else { continue };
        let value = value.map_or("from other numbers".to_owned(), |v| format!("{v:.3}"));
        let remedy = key.remedy.as_ref().map(|r| format!("; better: {r}")).unwrap_or_default();
        remark(&mut out, "", &format!("{} left out: {value} {width}{remedy}", leaf(&key.path)));
    }
    if !out.is_empty() {
        out.push('\n');
    }
    out
}

fn of_table(key: &str) -> &str {
    key.split_once('.').map_or("", |(table, _)| table)
}

fn leaf(key: &str) -> &str {
    key.split_once('.').map_or(key, |(_, leaf)| leaf)
}

/// A number with as many digits as its uncertainty makes sense of.
pub(crate) fn rounded(value: f64, sd: f64) -> String {
    let scale = if sd > 0.0 { sd } else { value.abs().max(1e-12) * 1e-3 };
    // two digits of the uncertainty
    let place = scale.log10().floor() - 1.0;
    let digits = (-place).clamp(0.0, 12.0) as usize;
    let step = 10f64.powf(place.max(0.0));
    let text = format!("{:.digits$}", (value / step).round() * step);
    let text = if place > 0.0 { text } else { format!("{value:.digits$}") };
    // TOML's numbers of this file are decimals
    if text.contains('.') { text } else { format!("{text}.0") }
}

/// A remark, broken into lines.
fn remark(out: &mut String, indent: &str, text: &str) {
    let mut line = format!("#{indent}");
    for word in text.split_whitespace() {
        if line.len() + word.len() + 1 > LINE && line.len() > 2 + indent.len() {
            let _ = writeln!(out, "{line}");
            line = format!("#{indent}  ");
        }
        line.push(' ');
        line.push_str(word);
    }
    let _ = writeln!(out, "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motorcycle::catalogue::Owner;

    #[test]
    fn every_class_makes_a_file_that_the_reader_takes() {
        for class in &Catalogue::builtin().classes {
            let owner = Owner { class: Some(class.name.clone()), ..Owner::default() };
            let portrait = owner.portrait(Catalogue::builtin()).unwrap_or_else(|e| panic!("{e}"));
            let text = text(&portrait, "mine").unwrap_or_else(|e| panic!("{}: {e}", class.name));
            let bike = Bike::parse(&text, "mine", Path::new("mine.toml")).expect("a bike");
            assert!(bike.uncertainty.len() == portrait.numbers.len(), "a guess is never exact");
            assert!((bike.mass - class.mass.mean).abs() < 1.0);
            assert!(text.lines().all(|l| l.len() <= LINE + 2), "{text}");
        }
    }

    #[test]
    fn a_number_has_its_source_uncertainty_and_remedy_beside_it() {
        let owner = Owner { class: Some("naked".into()), weight: Some(260.0), ..Owner::default() };
        let portrait = owner.portrait(Catalogue::builtin()).expect("a portrait");
        let text = text(&portrait, "mine").expect("a file");
        let above = text.split("cg_height = 0.617").next().expect("before it");
        let own = above.rsplit("\n\n").next().expect("its remarks");
        for part in ["guess from the class: ± 0.050 m", "Foale 2006", "costs:", "at home: lift"] {
            assert!(own.contains(part), "{part}: {own}");
        }
        assert!(text.contains("side_force_ratio left out: 0.095 ± 0.0475"), "{text}");
    }

    #[test]
    fn digits_are_those_of_the_uncertainty() {
        assert_eq!(rounded(260.04, 3.0), "260.0");
        assert_eq!(rounded(0.61705, 0.05), "0.617");
        assert_eq!(rounded(127_345.0, 31_859.0), "127000.0");
        assert_eq!(rounded(31_859.0, 31_859.0), "32000.0");
        assert_eq!(rounded(0.3, 0.0), "0.30000");
    }
}
