//! Logs that ended a worker before: as long as bytes, limits and roadbench are the same, they would again.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::limits::Limits;
use crate::batch::workers::blame::ENDS_A_WORKER;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::pipeline::Rejection;
use crate::store::objects::Location;
use crate::store::tables::read;
use crate::store::tables::rows::Rejected;

/// Rejections of such logs, by the hash of their bytes.
#[derive(Debug, Default)]
pub(super) struct Quarantine(BTreeMap<String, Rejected>);

impl Quarantine {
    /// Of an output's rejections by this roadbench; what cannot be read does not count.
    pub(super) fn read(out: &Location) -> Self {
        let listed = out.join("rejected").list().unwrap_or_default();
        let files: Vec<Location> =
            listed.into_iter().map(|e| out.join(format!("rejected/{}", e.key))).collect();
        let rows = |at: &Location| {
            let bytes = at.read().ok()?;
            read::rows_of::<Rejected>(at, bytes).ok()
        };
        let rows: Vec<Vec<Rejected>> = files.par_iter().filter_map(rows).collect();
        let is_one = |row: &Rejected| {
            ends_a_worker(&row.code).is_some()
                && row.version == crate::VERSION
                && row.limits.is_some()
        };
        let rows = rows.into_iter().flatten().filter(is_one);
        Quarantine(rows.filter_map(|row| Some((row.input_hash.clone()?, row))).collect())
    }

    /// Whether it is empty.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Why a log of that hash is not tried again under the same limits.
    pub(super) fn of(&self, hash: &str, limits: &Limits) -> Option<Rejection> {
        let row = self.0.get(hash).filter(|r| r.limits.as_deref() == Some(&limits.to_string()))?;
        let (code, stage) = (ends_a_worker(&row.code)?, Stage::parse(&row.stage)?);
        Some(Rejection { stage, code, message: row.message.clone(), limits: row.limits.clone() })
    }
}

/// The code, where it is one of a log that ended a worker.
fn ends_a_worker(code: &str) -> Option<RejectionCode> {
    ENDS_A_WORKER.into_iter().find(|own| own.as_str() == code)
}
