//! An outcome as Arrow tables: what the store writes, and what is given back where nothing is.

use std::collections::BTreeMap;

use arrow::array::RecordBatch;

use crate::contract::schema::Table;
use crate::pipeline::Outcome;
use crate::tables::file;

/// The schemas of a session's tables, parsed once.
#[derive(Debug)]
pub struct Schemas(BTreeMap<&'static str, Table>);

impl Schemas {
    /// All of them.
    pub fn load() -> Self {
        let tables =
            ["sessions", "coefficients", "manoeuvres", "forces", "warnings", "plots", "rejected"]
                .map(|name| (name, Table::embedded(name)));
        Schemas(BTreeMap::from(tables))
    }

    /// One of them.
    pub(super) fn of(&self, name: &str) -> &Table {
        &self.0[name]
    }

    /// A session's tables by name, as it has them: `forces` off-road, `signals` if asked for.
    /// `sessions`, the one row that says it is done, comes last.
    ///
    /// # Errors
    /// A row does not fit its schema: our own mistake.
    pub fn tables(
        &self,
        outcome: &Outcome,
    ) -> Result<Vec<(&'static str, RecordBatch)>, file::Error> {
        let mut tables = vec![
            ("coefficients", file::batch(self.of("coefficients"), &outcome.coefficients)?),
            ("manoeuvres", file::batch(self.of("manoeuvres"), &outcome.manoeuvres)?),
            ("warnings", file::batch(self.of("warnings"), &outcome.warnings)?),
            ("plots", file::batch(self.of("plots"), &outcome.plots)?),
        ];
        if !outcome.forces.is_empty() {
            tables.push(("forces", file::batch(self.of("forces"), &outcome.forces)?));
        }
        if let Some(signals) = &outcome.signals {
            tables.push(("signals", signals.clone()));
        }
        let session = std::slice::from_ref(&outcome.session);
        tables.push(("sessions", file::batch(self.of("sessions"), session)?));
        Ok(tables)
    }
}
