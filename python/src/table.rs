//! Tables and schemas as Python sees them: holders of the Arrow PyCapsule interface.

use std::sync::Arc;

use arrow::array::{Array, ArrayRef, RecordBatch, StructArray};
use arrow::datatypes::{DataType, Field, SchemaRef};
use arrow::util::display::{ArrayFormatter, FormatOptions};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use pyo3_arrow::error::PyArrowResult;
use pyo3_arrow::ffi::{ArrayIterator, to_schema_pycapsule, to_stream_pycapsule};

use roadbench::{TableSchema, closest_name, schema_files, schema_text};

/// Rows that a notebook shows.
const SHOWN: usize = 20;

/// An Arrow table. Give it to `pyarrow.table`, `polars.DataFrame`, DuckDB or whatever else takes
/// `__arrow_c_stream__`: it shares its memory with them.
#[pyclass(frozen, module = "roadbench")]
#[derive(Debug)]
pub struct Table {
    name: &'static str,
    batch: RecordBatch,
}

impl Table {
    pub fn new(name: &'static str, batch: RecordBatch) -> Self {
        Table { name, batch }
    }
}

#[pymethods]
impl Table {
    /// What `roadbench.schema` knows it by.
    #[getter]
    fn name(&self) -> &str {
        self.name
    }

    #[getter]
    fn num_rows(&self) -> usize {
        self.batch.num_rows()
    }

    #[getter]
    fn num_columns(&self) -> usize {
        self.batch.num_columns()
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        names(&self.batch.schema())
    }

    /// Columns with units and descriptions.
    #[getter]
    fn schema(&self) -> Schema {
        Schema(self.batch.schema())
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __repr__(&self) -> String {
        format!(
            "<roadbench.Table {}: {} rows, {} columns>",
            self.name,
            self.batch.num_rows(),
            self.batch.num_columns()
        )
    }

    /// As `pyarrow.Table`, which has to be installed.
    fn to_arrow<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyarrow")?.call_method1("table", (slf,))
    }

    /// As `polars.DataFrame`, which has to be installed.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("polars")?.call_method1("DataFrame", (slf,))
    }

    /// As `pandas.DataFrame`; pandas and pyarrow have to be installed.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Table::to_arrow(slf)?.call_method0("to_pandas")
    }

    /// The first rows with their units, for notebooks.
    fn _repr_html_(&self) -> PyResult<String> {
        let wrong = |e: arrow::error::ArrowError| PyValueError::new_err(e.to_string());
        let (schema, rows) = (self.batch.schema(), self.batch.num_rows().min(SHOWN));
        let head: String = schema
            .fields()
            .iter()
            .map(|f| {
                let of = |key: &str| f.metadata().get(key).map_or("", String::as_str);
                let unit = match of("unit") {
                    "" | "1" => String::new(),
                    unit => format!("<br><small>{}</small>", escaped(unit)),
                };
                format!(
                    "<th title=\"{}\">{}{unit}</th>",
                    escaped(of("description")),
                    escaped(f.name())
                )
            })
            .collect();
        let options = FormatOptions::default();
        let columns: Vec<ArrayFormatter<'_>> = self
            .batch
            .columns()
            .iter()
            .map(|c| ArrayFormatter::try_new(c.as_ref(), &options))
            .collect::<Result<_, _>>()
            .map_err(wrong)?;
        let mut body = String::new();
        for i in 0..rows {
            let cells =
                columns.iter().map(|c| format!("<td>{}</td>", escaped(&c.value(i).to_string())));
            body.push_str(&format!("<tr>{}</tr>", cells.collect::<String>()));
        }
        Ok(format!(
            "<table><caption>{}: {} rows{}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>",
            self.name,
            self.batch.num_rows(),
            if rows < self.batch.num_rows() {
                format!(", the first {rows}")
            } else {
                String::new()
            },
        ))
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyArrowResult<Bound<'py, PyCapsule>> {
        to_schema_pycapsule(py, self.batch.schema().as_ref())
    }

    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        let schema = self.batch.schema();
        let rows: ArrayRef = Arc::new(StructArray::from(self.batch.clone())); // shares the buffers
        let field = Field::new("", DataType::Struct(schema.fields().clone()), false)
            .with_metadata(schema.metadata().clone());
        debug_assert_eq!(rows.data_type(), field.data_type());
        let stream = Box::new(ArrayIterator::new(vec![Ok(rows)], field.into()));
        to_stream_pycapsule(py, stream, requested_schema)
    }
}

/// A table's columns, with units and descriptions as field metadata. `pyarrow.schema` takes it.
#[pyclass(frozen, module = "roadbench")]
#[derive(Debug)]
pub struct Schema(SchemaRef);

#[pymethods]
impl Schema {
    #[getter]
    fn names(&self) -> Vec<String> {
        names(&self.0)
    }

    /// Unit of a column; `None` where it has none.
    fn unit(&self, column: &str) -> PyResult<Option<String>> {
        self.metadata(column, "unit")
    }

    /// What a column means.
    fn description(&self, column: &str) -> PyResult<Option<String>> {
        self.metadata(column, "description")
    }

    /// Name of a column in the table's earlier version; `None` where it has kept it.
    fn former(&self, column: &str) -> PyResult<Option<String>> {
        self.metadata(column, "former")
    }

    /// Type of a column, as Arrow calls it: `Utf8`, `Float64`, `Int64`, `Boolean` or a timestamp.
    fn kind(&self, column: &str) -> PyResult<String> {
        Ok(self.field(column)?.data_type().to_string())
    }

    /// Whether rows may lack a column.
    fn nullable(&self, column: &str) -> PyResult<bool> {
        Ok(self.field(column)?.is_nullable())
    }

    /// Version of the table; columns have former names from version 2 on.
    #[getter]
    fn version(&self) -> u32 {
        let name = self.0.metadata().get("roadbench.schema");
        name.and_then(|name| name.rsplit_once(".v")?.1.parse().ok()).unwrap_or(1)
    }

    fn __len__(&self) -> usize {
        self.0.fields().len()
    }

    fn __repr__(&self) -> String {
        let name = self.0.metadata().get("roadbench.schema").map_or("", String::as_str);
        let mut out = format!("<roadbench.Schema {name}>");
        for field in self.0.fields() {
            let of = |key: &str| field.metadata().get(key).map_or("", String::as_str);
            let kind = field.data_type();
            let null = if field.is_nullable() { "?" } else { "" };
            out.push_str(&format!(
                "\n  {}: {kind}{null} [{}] {}",
                field.name(),
                of("unit"),
                of("description")
            ));
        }
        out
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyArrowResult<Bound<'py, PyCapsule>> {
        to_schema_pycapsule(py, self.0.as_ref())
    }
}

impl Schema {
    fn field(&self, column: &str) -> PyResult<&Field> {
        self.0.field_with_name(column).map_err(|_| {
            let near = closest_name(column, self.0.fields().iter().map(|f| f.name().as_str()));
            let near = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            PyValueError::new_err(format!("there is no column `{column}`{near}"))
        })
    }

    fn metadata(&self, column: &str, key: &str) -> PyResult<Option<String>> {
        Ok(self.field(column)?.metadata().get(key).cloned())
    }
}

/// Text in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn names(schema: &SchemaRef) -> Vec<String> {
    schema.fields().iter().map(|f| f.name().clone()).collect()
}

/// The schema of a table of the contract.
#[pyfunction]
#[pyo3(name = "schema")]
pub fn schema_of(name: &str) -> PyResult<Schema> {
    let parsed = |text: &str| toml::from_str::<TableSchema>(text).ok(); // some are key files
    if let Some(table) = schema_text(name).and_then(parsed) {
        return Ok(Schema(table.arrow()));
    }
    let tables = schema_files().filter(|(_, text)| parsed(text).is_some());
    let names: Vec<&str> = tables.map(|(name, _)| name).collect();
    Err(PyValueError::new_err(format!("no table `{name}`; there are {}", names.join(", "))))
}
