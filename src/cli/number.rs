//! Numbers in columns on the terminal.

/// Four digits that fit a column.
pub(super) fn number(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(v) if v != 0.0 && !(1e-3..1e7).contains(&v.abs()) => format!("{v:.2e}"),
        Some(v) if v.abs() >= 1000.0 => format!("{v:.0}"),
        Some(v) => format!("{v:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_their_column() {
        for (v, text) in
            [(0.0, "0.000"), (1.5e-5, "1.50e-5"), (-2.5, "-2.500"), (1_800_001.0, "1800001")]
        {
            assert_eq!(number(Some(v)), text);
        }
        assert_eq!(number(None), "-");
    }
}
