//! A `session.v1` table that is in memory already, as Arrow batches.

use arrow::array::RecordBatch;
use arrow::datatypes::Schema;

use crate::contract::rejection::RejectionCode;
use crate::contract::session::Meta;
use crate::ingest::error::Error;
use crate::ingest::formats::parquet::{append, check_kinds, meta_from, read_contract};
use crate::ingest::ident;
use crate::ingest::raw::Raw;
use crate::ingest::session_schema::with_metadata;
use crate::store::objects::Location;

/// Reads a table by the same rules as a `session.v1` Parquet file: units in the fields' metadata,
/// who and when in the schema's. `known` fills what those lack.
///
/// # Errors
/// It lacks what every session needs, or a column holds no numbers; `name` is for messages.
pub fn read_table(
    name: &str,
    schema: &Schema,
    batches: &[RecordBatch],
    known: Meta,
) -> Result<Raw, Error> {
    let log = &Location::Local(name.into());
    let own = meta_from(|key| schema.metadata().get(key).cloned());
    let meta = ident::checked(ident::or(own, known))?;
    let raw = read_contract(log, schema, meta, |wanted| {
        check_kinds(log, schema, wanted)?;
        let mut columns = vec![Vec::new(); wanted.len()];
        for batch in batches {
            for (column, &i) in columns.iter_mut().zip(wanted) {
                append(column, batch.column(i).clone()).map_err(|message| {
                    Error::new(RejectionCode::WrongType, format!("{name}: {message}"))
                })?;
            }
        }
        Ok(columns)
    })?;
    let own = |key: &str| schema.metadata().get(key).cloned();
    Ok(with_metadata(raw, own))
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;
    use std::sync::Arc;

    use arrow::array::{ArrayRef, Float32Array, Float64Array, StringArray};
    use arrow::datatypes::{DataType, Field};

    use super::*;
    use crate::contract::channel::Channel;

    fn schema(fields: Vec<Field>) -> Schema {
        let metadata = [("session_id", "s1"), ("bike_id", "b1")];
        let metadata = metadata.map(|(k, v)| (k.to_owned(), v.to_owned()));
        Schema::new_with_metadata(fields, HashMap::from(metadata))
    }

    #[test]
    fn batches_become_tracks_in_si() {
        let degrees = HashMap::from([("unit".to_owned(), "deg".to_owned())]);
        let schema = schema(vec![
            Field::new("time", DataType::Float64, false),
            Field::new("roll", DataType::Float32, true).with_metadata(degrees),
        ]);
        let part = |time: Vec<f64>, roll: Vec<Option<f32>>| {
            let columns: Vec<ArrayRef> =
                vec![Arc::new(Float64Array::from(time)), Arc::new(Float32Array::from(roll))];
            RecordBatch::try_new(Arc::new(schema.clone()), columns).expect("fits")
        };
        let batches =
            [part(vec![0.0, 0.1], vec![Some(180.0), None]), part(vec![0.2], vec![Some(90.0)])];
        let raw = read_table("t", &schema, &batches, Meta::default()).expect("read");
        assert_eq!((raw.meta.session_id.as_str(), raw.meta.bike_id.as_str()), ("s1", "b1"));
        assert_eq!(raw.tracks[0].channel, Channel::Roll);
        assert_eq!(*raw.tracks[0].time, [0.0, 0.1, 0.2]);
        let roll = &raw.tracks[0].values;
        assert!((roll[0] - std::f64::consts::PI).abs() < 1e-9 && roll[1].is_nan());
        assert!((roll[2] - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_session_is_refused() {
        let text = schema(vec![Field::new("time", DataType::Utf8, false)]);
        let words: ArrayRef = Arc::new(StringArray::from(vec!["noon"]));
        let batch = RecordBatch::try_new(Arc::new(text.clone()), vec![words]).expect("fits");
        let code = |schema: &Schema, batches: &[RecordBatch], known: Meta| {
            read_table("t", schema, batches, known).expect_err("refused").code.as_str()
        };
        assert_eq!(code(&text, &[batch], Meta::default()), "wrong_type");
        let other = schema(vec![Field::new("tiem", DataType::Float64, false)]);
        assert_eq!(code(&other, &[], Meta::default()), "missing_column");
        let nameless = Schema::new(vec![Field::new("time", DataType::Float64, false)]);
        assert_eq!(code(&nameless, &[], Meta::default()), "bad_session_id");
    }
}
