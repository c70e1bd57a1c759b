//! Long tables: the first rows stand in the page, all of them packed beside those for its script,
//! which searches, sorts and turns pages. However many rows there are, a page stays short.

use serde::Serialize;

use crate::report::charts::pack;

/// Rows in the page, of a list of sessions; as many are shown at a time.
pub(crate) const SESSIONS: usize = 50;
/// The same of every other list.
pub(crate) const OTHERS: usize = 20;
/// Rows from which on a list can be searched and sorted.
const TOOLS_FROM: usize = 12;

#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct Column {
    /// Text above it.
    pub head: &'static str,
    /// Classes of its cells; those of class `n` are sorted as numbers.
    pub class: &'static str,
    /// Text before a value where the window is too narrow for a table.
    pub label: &'static str,
}

/// A column of a class, without a label.
pub(crate) const fn column(head: &'static str, class: &'static str) -> Column {
    Column { head, class, label: "" }
}

/// A column of numbers.
pub(crate) const fn number(head: &'static str, label: &'static str) -> Column {
    Column { head, class: "n", label }
}

/// A cell. A plain text is written as such: of 100,000 rows most cells are.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub(crate) enum Cell {
    Text(String),
    /// A text that is sorted by a number.
    Keyed {
        text: String,
        /// Key of the order.
        key: f64,
    },
    /// A link to a page of the report.
    Page {
        text: String,
        /// File name of the page.
        href: String,
        /// Whether it has been written; else the page says how to.
        there: bool,
    },
    /// Lines of differently shown parts.
    Lines {
        /// Class of each line, and its parts.
        lines: Vec<(&'static str, Vec<Part>)>,
    },
}

/// A part of a line.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct Part {
    /// How it is shown.
    pub class: &'static str,
    pub text: String,
    /// The page that it leads to; empty where there is none.
    pub href: String,
}

impl Part {
    /// A part that leads nowhere.
    pub(crate) fn new(class: &'static str, text: impl Into<String>) -> Self {
        Part { class, text: text.into(), href: String::new() }
    }
}

impl Cell {
    /// A link to a page; where it has no name a text.
    pub(crate) fn page(text: &str, href: &str, there: bool) -> Self {
        match href.is_empty() {
            true => Cell::Text(text.to_owned()),
            false => Cell::Page { text: text.to_owned(), href: href.to_owned(), there },
        }
    }

    /// A whole number, or what has a text.
    pub(crate) fn of(value: impl ToString) -> Self {
        Cell::Text(value.to_string())
    }
}

/// A list as a whole.
#[derive(Debug)]
pub(crate) struct List {
    /// Subject of the list: the name of the region.
    pub label: &'static str,
    /// Text that is searched.
    pub words: &'static str,
    /// Classes of the table.
    pub class: &'static str,
    /// Where rows are that a browser without scripts does not show.
    pub table: &'static str,
    /// Rows at a time.
    pub page: usize,
    /// Headings; the first column names the row.
    pub columns: Vec<Column>,
    pub rows: Vec<Vec<Cell>>,
}

/// A list as a template reads it.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in `List`
pub(crate) struct Shown {
    pub label: &'static str,
    pub words: &'static str,
    pub class: &'static str,
    pub table: &'static str,
    pub page: usize,
    pub columns: Vec<Column>,
    pub rows: Vec<Vec<Cell>>,
    /// Number of all rows.
    pub all: usize,
    /// All rows, packed; empty of a short list.
    pub data: String,
}

impl List {
    /// The first rows, and all of them packed.
    ///
    /// # Errors
    /// What serde says: our own mistake.
    pub(crate) fn shown(mut self) -> Result<Shown, serde_json::Error> {
        let all = self.rows.len();
        let data = if all < TOOLS_FROM { String::new() } else { pack::pack(&self.rows)? };
        self.rows.truncate(self.page);
        Ok(Shown {
            label: self.label,
            words: self.words,
            class: self.class,
            table: self.table,
            page: self.page,
            columns: self.columns,
            rows: self.rows,
            all,
            data,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_the_first_rows_however_many_there_are() {
        let list = |n: usize| List {
            label: "Sessions",
            words: "session",
            class: "cards",
            table: "sessions",
            page: OTHERS,
            columns: vec![column("Session", "")],
            rows: (0..n).map(|i| vec![Cell::of(i)]).collect(),
        };
        let short = list(3).shown().expect("three rows");
        assert!(short.data.is_empty() && short.rows.len() == 3);
        let long = list(10_000).shown().expect("many rows");
        assert_eq!((long.rows.len(), long.all), (OTHERS, 10_000));
        assert!(long.data.bytes().all(|b| b.is_ascii_alphanumeric() || b"+/=".contains(&b)));
    }
}
