//! Rows of tables as JSON on stdout: one object a line, whose key `table` says of which.

/// A row of a table as a line, with its end.
pub(super) fn line(table: &str, row: &impl serde::Serialize) -> String {
    #[derive(serde::Serialize)]
    struct Line<'a, R> {
        table: &'a str,
        #[serde(flatten)]
        row: &'a R,
    }
    // a row of texts and numbers can always be written
    serde_json::to_string(&Line { table, row }).map(|text| text + "\n").unwrap_or_default()
}
