//! Rows on their way between programs and files of ours: Arrow's stream format, which needs no encoding.
//!
//! Tables that people read are Parquet ([`file`](super::file)). What is read once, by the next step of the same batch, is
//! made and read ten times faster so.

use std::io::Cursor;

use arrow::array::RecordBatch;
use arrow::ipc::reader::StreamReader;
use arrow::ipc::writer::StreamWriter;
use bytes::Bytes;

use crate::store::tables::mismatch::Mismatch;

/// One batch as a stream.
///
/// # Errors
/// Arrow cannot hold it: our own mistake.
pub(crate) fn encode(batch: &RecordBatch) -> Result<Vec<u8>, Mismatch> {
    let fail = |e: arrow::error::ArrowError| Mismatch::from(e.to_string());
    let mut writer = StreamWriter::try_new(Vec::new(), &batch.schema()).map_err(fail)?;
    writer.write(batch).map_err(fail)?;
    writer.into_inner().map_err(fail)
}

/// The batches of a stream.
///
/// # Errors
/// It is none, or ends early.
pub(crate) fn decode(bytes: Bytes) -> Result<Vec<RecordBatch>, Mismatch> {
    let fail = |e: arrow::error::ArrowError| Mismatch::from(e.to_string());
    let reader = StreamReader::try_new(Cursor::new(bytes), None).map_err(fail)?;
    reader.map(|batch| batch.map_err(fail)).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use arrow::array::{ArrayRef, Float64Array, StringArray};

    use super::*;

    #[test]
    fn rows_come_back_and_half_a_stream_is_none() {
        let numbers: ArrayRef = Arc::new(Float64Array::from(vec![Some(1.5), None, Some(f64::NAN)]));
        let texts: ArrayRef = Arc::new(StringArray::from(vec![Some("a"), Some(""), None]));
        let batch = RecordBatch::try_from_iter([("x", numbers), ("s", texts)]).expect("a batch");
        let bytes = encode(&batch).expect("encoded");
        let back = decode(bytes.clone().into()).expect("decoded");
        assert_eq!(format!("{back:?}"), format!("{:?}", [batch]));
        assert!(decode(Bytes::copy_from_slice(&bytes[..bytes.len() / 2])).is_err());
        assert!(decode(Bytes::from_static(b"PAR1")).is_err());
    }
}
