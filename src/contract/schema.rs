//! What a file of `schemas/` declares: the columns of a table, or the keys of a TOML file.
//!
//! Each file there is the one declaration of its table: the writers build their Arrow schema
//! from it, the readers check against it, `roadbench schema NAME` prints it. The files that users
//! write are listed here, the tables that come out in [`crate::store::tables::registry`].

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::sync::OnceLock;

use arrow::datatypes::{DataType, Field, Schema, SchemaRef, TimeUnit};
use serde::Deserialize;

use super::key_error::KeyError;

macro_rules! embed {
    ($($name:literal),* $(,)?) => {
        /// Name and schema of everything that goes in.
        pub(crate) const INPUTS: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../../schemas/", $name, ".v1.toml")))),*
        ];
    };
}

embed!("session", "channel_map", "bike", "motorcycle", "ride", "pipeline");

/// The schema of an input, by name with or without its version (`session`, `session.v1`).
pub(crate) fn text(name: &str) -> Option<&'static str> {
    let name = name.strip_suffix(".v1").unwrap_or(name);
    INPUTS.iter().find(|(n, _)| *n == name).map(|(_, t)| *t)
}

/// One column of a table.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    pub name: String,
    /// Its name in the table's earlier version: files that have this one are still read.
    pub former: Option<String>,
    /// `float64`, `int64`, `bool`, `utf8`; `timestamp`, an instant.
    #[serde(rename = "type")]
    pub kind: String,
    /// Unit of numbers.
    pub unit: Option<String>,
    /// Column of the same table that has each row's unit.
    pub unit_column: Option<String>,
    /// Whether a row may lack it.
    pub nullable: bool,
    /// Physical range, where one is known.
    pub range: Option<[f64; 2]>,
    pub description: String,
}

/// One table of the contract.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Name of the table.
    pub name: String,
    /// Version of the schema.
    pub version: u32,
    /// Meaning of a row.
    pub description: String,
    /// Its columns, in order.
    #[serde(rename = "column")]
    pub columns: Vec<Column>,
}

/// The table that every log becomes, `session.v1`; parsed once.
pub(crate) fn session() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| Table::embedded("session"))
}

impl Table {
    /// The input table of that name.
    ///
    /// # Panics
    /// If there is none: the names are the program's own, and a test loads them all.
    pub fn embedded(name: &str) -> Self {
        let text = text(name).unwrap_or_else(|| panic!("no schema named {name}"));
        toml::from_str(text).unwrap_or_else(|e| panic!("schemas/{name}.v1.toml: {e}"))
    }

    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// The Arrow schema: unit and description of each field in its metadata.
    pub fn arrow(&self) -> SchemaRef {
        self.schema(Column::data_type)
    }

    /// As [`Table::arrow`], with what rows hold: instants as texts.
    pub fn texts(&self) -> SchemaRef {
        self.schema(Column::row_type)
    }

    fn schema(&self, kind: impl Fn(&Column) -> DataType) -> SchemaRef {
        let fields: Vec<Field> = self.columns.iter().map(|c| c.field(kind(c))).collect();
        let metadata = HashMap::from([
            ("roadbench.table".to_owned(), self.name.clone()),
            ("roadbench.schema".to_owned(), format!("{}.v{}", self.name, self.version)),
            ("description".to_owned(), self.description.clone()),
        ]);
        Arc::new(Schema::new_with_metadata(fields, metadata))
    }
}

impl Column {
    /// Unit of numbers, or which column has it.
    pub fn unit_text(&self) -> Option<String> {
        let column = || Some(format!("as given in the column {}", self.unit_column.as_ref()?));
        self.unit.clone().or_else(column)
    }

    /// The Arrow field, with description, unit (or the column that has it) and former name.
    pub fn arrow(&self) -> Field {
        self.field(self.data_type())
    }

    /// The type in files: an instant has its time zone. Texts are plain strings for readers; on disk Parquet keeps each
    /// of those that many rows share once.
    pub fn data_type(&self) -> DataType {
        match self.kind.as_str() {
            "timestamp" => DataType::Timestamp(TimeUnit::Microsecond, Some("UTC".into())),
            _ => self.row_type(),
        }
    }

    /// The type that rows are made from: instants are texts there.
    pub fn row_type(&self) -> DataType {
        match self.kind.as_str() {
            "float64" => DataType::Float64,
            "int64" => DataType::Int64,
            "bool" => DataType::Boolean,
            _ => DataType::Utf8,
        }
    }

    fn field(&self, kind: DataType) -> Field {
        let mut metadata = HashMap::from([("description".to_owned(), self.description.clone())]);
        metadata.extend(self.unit_text().map(|unit| ("unit".to_owned(), unit)));
        for (key, value) in [("unit_column", &self.unit_column), ("former", &self.former)] {
            metadata.extend(value.as_ref().map(|value| (key.to_owned(), value.clone())));
        }
        Field::new(&self.name, kind, self.nullable).with_metadata(metadata)
    }
}

/// One key of a TOML file such as the bike file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// Dotted path, e.g. `front.radius`.
    pub path: String,
    /// `number`, `text`, `bool`, `curve` (a list of pairs), or `list` and `table`, which their
    /// own reader looks at.
    #[serde(rename = "type")]
    pub kind: String,
    pub unit: Option<String>,
    /// Whether the file must have it.
    pub required: bool,
    /// Physical range of a number.
    pub range: Option<[f64; 2]>,
    /// Used where the file does not have it.
    pub default: Option<f64>,
    /// As `default`, but not filled in: the estimate takes it, and who asks for the key still learns
    /// that it was not given.
    pub assumed: Option<f64>,
    /// Standard deviation of what is taken where the file does not have the key, in `unit`.
    pub default_uncertainty: Option<f64>,
    /// The same over that number, where it follows from other keys.
    pub default_relative_uncertainty: Option<f64>,
    pub description: String,
    /// How the number is found.
    pub remedy: Option<String>,
    /// Where the default and its uncertainty come from.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub source: Option<String>,
}

/// The keys of a TOML file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyTable {
    pub name: String,
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub version: u32,
    /// Meaning of the file.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub description: String,
    /// Advice where keys are missing.
    pub hint: Option<String>,
    #[serde(rename = "key")]
    pub keys: Vec<Key>,
    /// Keys that it had once.
    #[serde(default)]
    pub removed: Vec<Removed>,
}

/// A key that a file may still have and that nothing reads any more.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Removed {
    /// Dotted path.
    pub path: String,
    pub reason: String,
}

impl Removed {
    /// Message for a file that still has it.
    pub fn message(&self) -> String {
        format!("`{}` is no key any more: {}; delete the line", self.path, self.reason)
    }
}

/// Checked values of a TOML file, by dotted path; defaults are filled in.
#[derive(Debug, Default)]
pub struct Values {
    pub number: BTreeMap<String, f64>,
    /// Those of the numbers that the file does not have: defaults.
    pub defaulted: BTreeSet<String>,
    pub text: BTreeMap<String, String>,
    /// Curves: rows of abscissa and ordinate, abscissae strictly increasing.
    pub curve: BTreeMap<String, Vec<[f64; 2]>>,
}

impl KeyTable {
    /// The keys of the input file of that name.
    ///
    /// # Panics
    /// If there is none, as [`Table::embedded`].
    pub fn embedded(name: &str) -> Self {
        let text = text(name).unwrap_or_else(|| panic!("no schema named {name}"));
        toml::from_str(text).unwrap_or_else(|e| panic!("schemas/{name}.v1.toml: {e}"))
    }

    fn key(&self, path: &str) -> Result<&Key, KeyError> {
        let beneath = |k: &&Key| {
            let rest = path.strip_prefix(&k.path);
            k.kind == "table" && rest.is_some_and(|r| r.starts_with('.'))
        };
        let exact = self.keys.iter().find(|k| k.path == path);
        exact.or_else(|| self.keys.iter().find(beneath)).ok_or_else(|| {
            let near = closest(path, self.keys.iter().map(|k| k.path.as_str()));
            let remedy = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("`roadbench schema {}` lists them", self.name),
            };
            KeyError::Unknown { path: path.to_owned(), remedy }
        })
    }

    /// Takes keys out of a file's table that it had once; gives back which.
    pub fn take_removed(&self, table: &mut toml::Table) -> Vec<&Removed> {
        fn take(table: &mut toml::Table, path: &str) -> bool {
            match path.split_once('.') {
                // `uncertainty` has dotted paths for keys
                None => table.remove(path).is_some(),
                Some((head, rest)) => {
                    let inner = table.get_mut(head).and_then(toml::Value::as_table_mut);
                    inner.is_some_and(|inner| take(inner, rest)) || table.remove(path).is_some()
                }
            }
        }
        self.removed.iter().filter(|key| take(table, &key.path)).collect()
    }

    /// Checks a file's table against the keys and fills in the defaults.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self, table: &toml::Table) -> Result<Values, KeyError> {
        let mut values = Values::default();
        let mut given: Vec<String> = Vec::new();
        for (path, value) in flatten(table) {
            let key = self.key(&path)?;
            let fits = match key.kind.as_str() {
                // its own reader looks at what is beneath
                "table" => key.path != path,
                "list" => value.is_array(),
                "bool" => value.is_bool(),
                _ => true,
            };
            if !fits {
                return Err(KeyError::Type { path, wanted: format!("a {}", key.kind) });
            }
            if matches!(key.kind.as_str(), "table" | "list" | "bool") {
                given.push(key.path.clone());
                continue;
            }
            if key.kind == "text" {
                let toml::Value::String(text) = value else {
                    return Err(KeyError::Type { path, wanted: "a text, in quotes".to_owned() });
                };
                values.text.insert(path, text.clone());
                continue;
            }
            if key.kind == "curve" {
                values.curve.insert(path.clone(), curve(&path, value)?);
                continue;
            }
            let number = number(&path, value)?;
            let unit = key.unit.as_deref().unwrap_or("1");
            if let Some([low, high]) = key.range
                && !(low..=high).contains(&number)
            {
                let out_of = format!("out of its physical range {low} to {high} {unit}");
                return Err(KeyError::Range { path, value: number, unit: unit.to_owned(), out_of });
            }
            values.number.insert(path, number);
        }
        let mut missing = Vec::new();
        for key in &self.keys {
            if values.number.contains_key(&key.path)
                || values.text.contains_key(&key.path)
                || values.curve.contains_key(&key.path)
                || given.contains(&key.path)
            {
                continue;
            }
            if key.required {
                missing.push(format!(
                    "`{}` ({}{})",
                    key.path,
                    key.description.trim_end_matches('.'),
                    key.unit.as_ref().map(|u| format!(", {u}")).unwrap_or_default()
                ));
                continue;
            }
            if let Some(default) = key.default {
                values.number.insert(key.path.clone(), default);
                values.defaulted.insert(key.path.clone());
            }
        }
        if missing.is_empty() {
            return Ok(values);
        }
        let keys = if missing.len() == 1 { "key" } else { "keys" };
        let hint = self.hint.as_ref().map(|h| format!("; {h}")).unwrap_or_default();
        Err(KeyError::Missing { keys: format!("{keys} {}", missing.join(", ")), hint })
    }

    /// Checks the numbers of a file that its own reader takes apart: each is finite, and where there is a key of that
    /// path it is in the key's range.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check_ranges(&self, table: &toml::Table) -> Result<(), KeyError> {
        refuse_infinite(table)?;
        for (path, value) in flatten(table) {
            // `*` stands for one part of a path
            let is_of = |key: &&Key| {
                let (a, b) = (key.path.split('.'), path.split('.'));
                a.clone().count() == b.clone().count() && a.zip(b).all(|(a, b)| a == "*" || a == b)
            };
            let key = self.keys.iter().find(is_of);
            let Some((key, [low, high])) = key.and_then(|k| Some((k, k.range?))) else { continue };
            let Ok(number) = number(&path, value) else { continue }; // the reader says what it wants
            if !(low..=high).contains(&number) {
                let unit = key.unit.as_deref().unwrap_or("1").to_owned();
                let out_of = format!("not between {low} and {high}");
                return Err(KeyError::Range { path, value: number, unit, out_of });
            }
        }
        Ok(())
    }

    /// Checks a table of standard uncertainties: the same keys, positive numbers.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check_uncertainty(
        &self,
        table: &toml::Table,
    ) -> Result<BTreeMap<String, f64>, KeyError> {
        let checked = |path: &str, value: &toml::Value| {
            if self.key(path)?.kind != "number" {
                return Err(KeyError::NoNumber { path: path.to_owned() });
            }
            let sd = number(path, value)?;
            match sd >= 0.0 && sd.is_finite() {
                true => Ok(sd),
                false => Err(KeyError::Negative { path: path.to_owned(), value: sd }),
            }
        };
        let mut out = BTreeMap::new();
        for (path, value) in flatten(table) {
            let sd = checked(&path, value).map_err(|e| KeyError::Uncertainty(Box::new(e)))?;
            out.insert(path, sd);
        }
        Ok(out)
    }
}

fn number(path: &str, value: &toml::Value) -> Result<f64, KeyError> {
    match value {
        toml::Value::Float(x) if x.is_finite() => Ok(*x),
        toml::Value::Integer(i) => Ok(*i as f64),
        other => Err(KeyError::Type {
            path: path.to_owned(),
            wanted: format!("a finite number, found {other}"),
        }),
    }
}

/// Refuses `nan` and `inf` wherever they are: no setting means anything by them.
///
/// # Errors
/// Error text that names the key.
pub(crate) fn refuse_infinite(table: &toml::Table) -> Result<(), KeyError> {
    fn look(path: &str, value: &toml::Value) -> Result<(), KeyError> {
        match value {
            toml::Value::Float(x) if !x.is_finite() => {
                Err(KeyError::Infinite { path: path.to_owned(), value: *x })
            }
            toml::Value::Array(values) => {
                values.iter().enumerate().try_for_each(|(k, v)| look(&format!("{path}[{k}]"), v))
            }
            toml::Value::Table(table) => {
                table.iter().try_for_each(|(key, v)| look(&format!("{path}.{key}"), v))
            }
            _ => Ok(()),
        }
    }
    table.iter().try_for_each(|(key, value)| look(key, value))
}

/// As [`refuse_infinite`], of a file's text; what is wrong with the text otherwise its own reader says.
///
/// # Errors
/// Error text that names the key.
pub(crate) fn refuse_infinite_in(text: &str) -> Result<(), KeyError> {
    toml::from_str::<toml::Table>(text).map_or(Ok(()), |table| refuse_infinite(&table))
}

/// Reads a list of pairs whose first column increases.
fn curve(path: &str, value: &toml::Value) -> Result<Vec<[f64; 2]>, KeyError> {
    let shape = || KeyError::Type {
        path: path.to_owned(),
        wanted: "a list of pairs, such as [[0.0, 250.0], [0.3, 1700.0]]".to_owned(),
    };
    let rows = value.as_array().filter(|rows| rows.len() >= 2).ok_or_else(shape)?;
    let mut out = Vec::with_capacity(rows.len());
    for (k, row) in rows.iter().enumerate() {
        let pair = row.as_array().filter(|pair| pair.len() == 2).ok_or_else(shape)?;
        let at = format!("{path}[{k}]");
        out.push([number(&at, &pair[0])?, number(&at, &pair[1])?]);
    }
    if let Some(k) = out.windows(2).position(|w| w[1][0] <= w[0][0]) {
        return Err(KeyError::Values(format!(
            "`{path}`: its first column must increase from row to row, but row {} has {} after {}",
            k + 2,
            out[k + 1][0],
            out[k][0]
        )));
    }
    Ok(out)
}

/// Leaves of a table by dotted path, in the file's order of keys.
fn flatten(table: &toml::Table) -> Vec<(String, &toml::Value)> {
    fn walk<'a>(prefix: &str, table: &'a toml::Table, out: &mut Vec<(String, &'a toml::Value)>) {
        for (key, value) in table {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            match value {
                toml::Value::Table(inner) => walk(&path, inner, out),
                leaf => out.push((path, leaf)),
            }
        }
    }
    let mut out = Vec::new();
    walk("", table, &mut out);
    out
}

/// The candidate nearest to a misspelt word, if one is near.
pub fn closest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let most = |c: &str| 2.max(c.len() / 4);
    candidates
        // a log may have thousands of names, and most differ by their length already
        .filter(|c| c.chars().count().abs_diff(word.chars().count()) <= most(c))
        .map(|c| (distance(word, c), c))
        .min()
        .filter(|(d, c)| *d <= most(c))
        .map(|(_, c)| c)
}

/// As [`closest`], whatever the case, and else a name that the word is a part of or has in it.
pub(crate) fn nearest<'a>(
    word: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let named: Vec<(String, &str)> = candidates.map(|c| (c.to_lowercase(), c)).collect();
    let near = closest(&lower, named.iter().map(|(l, _)| l.as_str())).map(str::to_owned);
    let within =
        |l: &str| l.len().min(lower.len()) > 2 && (l.contains(&lower) || lower.contains(l));
    let found = match near {
        Some(near) => named.iter().find(|(l, _)| *l == near),
        None => named.iter().find(|(l, _)| within(l)),
    };
    found.map(|(_, c)| *c)
}

/// `; did you mean ...?` where a candidate is near to a misspelt word, else nothing.
pub(crate) fn meant<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> String {
    closest(word, candidates).map(|c| format!("; did you mean `{c}`?")).unwrap_or_default()
}

/// The message of a TOML reader about an unknown key or word, with the nearest of those that it
/// says it expected.
pub(crate) fn with_hint(message: &str) -> String {
    let quoted = |text: &str| -> Vec<String> {
        text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let line =
        message.lines().find(|l| l.contains("unknown field") || l.contains("unknown variant"));
    let Some((unknown, expected)) = line.and_then(|l| l.split_once("expected")) else {
        return message.to_owned();
    };
    let (unknown, expected) = (quoted(unknown), quoted(expected));
    let word = unknown.first().map_or("", String::as_str);
    match closest(word, expected.iter().map(String::as_str)) {
        Some(near) => format!("{}\ndid you mean `{near}`?", message.trim_end()),
        None => message.to_owned(),
    }
}

/// Levenshtein distance of two short words.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let change = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_by_its_length_alone_may_still_be_meant() {
        let near = |word: &str| closest(word, ["roll", "roll_rate", "velocity_x"].into_iter());
        assert_eq!(near("rol"), Some("roll"));
        assert_eq!(near("rollrate"), Some("roll_rate"));
        assert_eq!(near("velocity_xyz"), Some("velocity_x"));
        assert_eq!(near("velocity_wxyz"), None);
    }
    use crate::contract::channel::Channel;

    #[test]
    fn every_file_loads_and_knows_its_name() {
        for (name, text) in INPUTS {
            let value: toml::Table = text.parse().expect(name);
            assert_eq!(value["name"].as_str(), Some(*name));
            if value.contains_key("column") {
                Table::embedded(name);
            } else {
                KeyTable::embedded(name);
            }
        }
    }

    #[test]
    fn channels_and_session_schema_agree() {
        let table = Table::embedded("session");
        let names: Vec<&str> = table.columns.iter().skip(1).map(|c| c.name.as_str()).collect();
        let channels: Vec<&str> = Channel::ALL.iter().map(|c| c.name()).collect();
        assert_eq!(names, channels);
        assert!(table.columns.iter().skip(1).all(|c| c.range.is_some()));
    }

    #[test]
    fn a_misspelt_key_is_named_with_its_neighbour() {
        let bikes = KeyTable::embedded("bike");
        let table: toml::Table = "masss = 200.0".parse().expect("toml");
        let message = bikes.check(&table).expect_err("unknown key").to_string();
        assert!(message.contains("`masss`") && message.contains("`mass`"), "{message}");
    }
}
