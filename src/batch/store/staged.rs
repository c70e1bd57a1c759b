//! A session on its way into the tables: one file with all that it gives, written whole or not at all.
//!
//! `<out>/.roadbench/staged/<command>/<session>.session` is a Parquet file with a row per file of the session (folder,
//! extension, content, checksum), and its [`Committed`] as metadata: to see whose it is only the footer is read. A file
//! without rows says that the session is to be taken out. Rows of tables that sessions share are Arrow streams in it: they
//! become Parquet once, in the month's file.

use std::collections::BTreeMap;
use std::sync::Arc;

use arrow::array::{ArrayRef, AsArray, LargeBinaryArray, RecordBatch, StringArray};
use bytes::Bytes;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::metadata::{KeyValue, ParquetMetaDataReader};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::ChunkReader;
use serde::{Deserialize, Serialize};

use super::manifest::checksum;
use super::marker::{Committed, Key};
use crate::batch::jobs::work::SessionFile;
use crate::store::tables::mismatch::Mismatch;

/// Extension of these files: they are no table.
pub(crate) const EXTENSION: &str = "session";

/// Key of the metadata.
const KEY: &str = "roadbench.staged";

/// Session of staged files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Staged {
    pub bike_id: String,
    /// Id of the session, unique per motorcycle.
    pub session_id: String,
    /// Its commit entry; `None` if the session is to be removed.
    pub made: Option<Committed>,
    /// The folders that it has files for.
    pub folders: Vec<String>,
}

impl Staged {
    /// Bike and id of the session.
    pub fn key(&self) -> Key {
        Key::new(&self.bike_id, &self.session_id)
    }
}

/// A session's files by folder: extension and content.
pub(crate) type Files = BTreeMap<String, (String, Bytes)>;

/// The bytes of such a file.
///
/// # Errors
/// Parquet cannot hold it: our own mistake.
pub(crate) fn encode(staged: &Staged, files: &[SessionFile]) -> Result<Vec<u8>, Mismatch> {
    let head = serde_json::to_string(staged).map_err(|e| Mismatch::from(e.to_string()))?;
    let texts = |of: fn(&SessionFile) -> &'static str| -> ArrayRef {
        Arc::new(StringArray::from_iter_values(files.iter().map(of)))
    };
    let content = LargeBinaryArray::from_iter_values(files.iter().map(|f| &f.bytes));
    let sums = StringArray::from_iter_values(files.iter().map(|f| checksum(&f.bytes)));
    let columns: [(&str, ArrayRef); 4] = [
        ("folder", texts(|f| f.folder)),
        ("extension", texts(|f| f.extension)),
        ("content", Arc::new(content)),
        ("checksum", Arc::new(sums)),
    ];
    let batch = RecordBatch::try_from_iter(columns).map_err(|e| Mismatch::from(e.to_string()))?;
    // an object store gets a third of the bytes; each content is a page of its own, those that are packed lose no time
    let level = ZstdLevel::try_new(1).map_err(|e| Mismatch::from(e.to_string()))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(level))
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::None)
        .set_key_value_metadata(Some(vec![KeyValue::new(KEY.to_owned(), head)]))
        .build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties))
        .map_err(|e| Mismatch::from(e.to_string()))?;
    writer.write(&batch).map_err(|e| Mismatch::from(e.to_string()))?;
    writer.close().map_err(|e| Mismatch::from(e.to_string()))?;
    Ok(bytes)
}

/// Session of a staged file; `None` if it is no such file.
pub(crate) fn head(file: &impl ChunkReader) -> Option<Staged> {
    let about = ParquetMetaDataReader::new().parse_and_finish(file).ok()?;
    let pairs = about.file_metadata().key_value_metadata()?;
    let head = pairs.iter().find(|p| p.key == KEY)?.value.as_deref()?;
    serde_json::from_str(head).ok()
}

/// The files in it.
///
/// # Errors
/// It is no such file, or a content is not as it was written.
pub(crate) fn files(bytes: Bytes) -> Result<Files, Mismatch> {
    let reader = ParquetRecordBatchReaderBuilder::try_new(bytes)
        .and_then(ParquetRecordBatchReaderBuilder::build)
        .map_err(|e| Mismatch::from(e.to_string()))?;
    let mut files = Files::new();
    for batch in reader {
        let batch = batch.map_err(|e| Mismatch::from(e.to_string()))?;
        let text = |name: &str| batch.column_by_name(name)?.as_string_opt::<i32>();
        let content = batch.column_by_name("content").and_then(|c| c.as_binary_opt::<i64>());
        let columns = (text("folder"), text("extension"), content);
        let (Some(folder), Some(extension), Some(content)) = columns else {
            return Err(Mismatch::from("it lacks the columns of a staged session".to_owned()));
        };
        // what an earlier version left has none
        let sums = text("checksum");
        for i in 0..batch.num_rows() {
            let content = Bytes::copy_from_slice(content.value(i));
            if sums.is_some_and(|sums| sums.value(i) != checksum(&content)) {
                return Err(Mismatch::from(format!("{}: the checksum is wrong", folder.value(i))));
            }
            files.insert(folder.value(i).to_owned(), (extension.value(i).to_owned(), content));
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_back_as_they_were() {
        let made =
            Committed { session_id: "a/b".into(), part: "2026-05".into(), ..Committed::default() };
        let staged = Staged {
            bike_id: "b1".into(),
            session_id: "a/b".into(),
            made: Some(made),
            folders: vec!["causes".into(), "models".into()],
        };
        let file = |folder, extension, bytes: &[u8]| SessionFile {
            folder,
            extension,
            bytes: bytes.to_vec(),
        };
        let given = [file("causes", "parquet", b"PAR1"), file("models", "toml", b"")];
        let bytes = Bytes::from(encode(&staged, &given).expect("encoded"));
        assert_eq!(head(&bytes).as_ref(), Some(&staged));
        let back = files(bytes).expect("read");
        assert_eq!(back["causes"], ("parquet".to_owned(), Bytes::from_static(b"PAR1")));
        assert_eq!(back["models"], ("toml".to_owned(), Bytes::new()));
        let gone = Staged { made: None, folders: Vec::new(), ..staged };
        let bytes = Bytes::from(encode(&gone, &[]).expect("encoded"));
        assert_eq!(head(&bytes), Some(gone));
        assert!(files(bytes).expect("read").is_empty());
        assert!(head(&Bytes::from_static(b"half a file")).is_none());
    }
}
