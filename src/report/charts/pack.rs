//! A page's data, small: what is drawn as JSON, deflated, as base64.
//!
//! Numbers are most of a page. They are rounded to what a screen resolves, so a column of them is
//! written as whole multiples of its last decimal, each as the step from the one before:
//! `[1.25, 1.5]` is `{"e": 2, "d": [125, 25]}`. A column that this would change by a bit is
//! written as it is. The page's script undoes it with what browsers have built in
//! (`DecompressionStream`). What logs call things is inside too, and so cannot end the `<script>`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use libdeflater::{CompressionLvl, Compressor};
use serde::ser::Error;
use serde::{Serialize, Serializer};

/// Decimals that are tried; more than the most that [`super::resolution::digits`] gives.
const DECIMALS: i32 = 12;
/// Largest multiple: far below where whole numbers have gaps.
const LARGEST: f64 = 1e15;

/// A value as it stands in a page's `<script>`: base64 of zlib of JSON.
///
/// # Errors
/// What serde says; plain structs of numbers and texts do not fail.
pub(crate) fn pack<T: Serialize>(value: &T) -> Result<String, serde_json::Error> {
    let json = serde_json::to_vec(value)?;
    let mut deflate = Compressor::new(CompressionLvl::default());
    let mut packed = vec![0; deflate.zlib_compress_bound(json.len())];
    let length = deflate.zlib_compress(&json, &mut packed).map_err(serde_json::Error::custom)?;
    Ok(STANDARD.encode(&packed[..length]))
}

/// A column of numbers.
#[derive(Serialize)]
#[serde(untagged)]
enum Column<'a> {
    Steps { e: i32, d: Vec<Option<i64>> },
    Plain(&'a [Option<f64>]),
}

pub(in crate::report) fn plain<S: Serializer>(values: &[f64], to: S) -> Result<S::Ok, S::Error> {
    let values: Vec<Option<f64>> = values.iter().copied().map(Some).collect();
    gaps(&values, to)
}

/// Writes a column with gaps; a gap is null, and the next step goes from the value before it.
pub(in crate::report) fn gaps<S: Serializer>(
    values: &[Option<f64>],
    to: S,
) -> Result<S::Ok, S::Error> {
    column(values).serialize(to)
}

fn column(values: &[Option<f64>]) -> Column<'_> {
    let found = (0..=DECIMALS).find(|e| values.iter().flatten().all(|v| whole(*v, *e).is_some()));
    let Some(e) = found.filter(|_| values.len() > 1) else { return Column::Plain(values) };
    let mut before = 0;
    let mut step = |value: f64| {
        let now = whole(value, e)?;
        let step = now - before;
        before = now;
        Some(step)
    };
    Column::Steps { e, d: values.iter().map(|v| v.and_then(&mut step)).collect() }
}

/// The value in units of its `e`-th decimal, if dividing gives the very same number back.
fn whole(value: f64, e: i32) -> Option<i64> {
    let scale = 10f64.powi(e);
    let units = (value * scale).round();
    (units.abs() < LARGEST && units / scale == value).then_some(units as i64)
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    fn json(values: &[Option<f64>]) -> String {
        serde_json::to_string(&column(values)).expect("json")
    }

    #[test]
    fn columns_are_steps_of_their_last_decimal() {
        assert_eq!(
            json(&[Some(1.25), Some(1.5), None, Some(-0.5)]),
            r#"{"e":2,"d":[125,25,null,-200]}"#
        );
        assert_eq!(json(&[Some(3.0), Some(4.0)]), r#"{"e":0,"d":[3,1]}"#);
        assert_eq!(json(&[]), "[]");
        // not decimal, not finite, too large: as they are
        let third = 1.0 / 3.0;
        assert_eq!(json(&[Some(third), Some(1.0)]), format!("[{third},1.0]"));
        assert_eq!(json(&[Some(f64::NAN), Some(1.0)]), "[null,1.0]");
        assert!(matches!(column(&[Some(1e300), Some(1.0)]), Column::Plain(_)));
    }

    #[test]
    fn steps_give_the_same_numbers_back() {
        let rounded = |i: i32| {
            crate::statistics::number_format::round(f64::from(i * i % 7919).sqrt() * 0.37, 4)
        };
        let values: Vec<Option<f64>> = (0..5000).map(|i| Some(rounded(i))).collect();
        let Column::Steps { e, d } = column(&values) else { panic!("rounded numbers are steps") };
        let mut sum = 0;
        for (value, step) in values.iter().zip(d) {
            sum += step.expect("no gaps");
            assert_eq!(*value, Some(sum as f64 / 10f64.powi(e)));
        }
    }

    #[test]
    fn texts_cannot_close_the_script() {
        let texts = ["</script><b>&\u{2028}", "\"'"];
        let packed = pack(&texts).expect("packed");
        assert!(!packed.contains(['<', '>', '&', '"', '\'']), "{packed}");
        let bytes = STANDARD.decode(&packed).expect("base64");
        let mut json = String::new();
        flate2::read::ZlibDecoder::new(&bytes[..]).read_to_string(&mut json).expect("zlib");
        let back: Vec<String> = serde_json::from_str(&json).expect("json");
        assert_eq!(back, texts);
    }
}
