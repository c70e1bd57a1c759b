//! What diagnosed sessions share: the pooled rows of `causes`, and the same for `run --model`.

use std::path::Path;

use crate::batch::error::Error;
use crate::batch::store::kind::{SHARED as FOLDER, SHARED_MODEL as MODEL, SHARED_TABLE as TABLE};
use crate::batch::store::local_copy::LocalCopy;
use crate::diagnose::levels::{Member, Pooling, SharedCause};
use crate::simulate::effects::pooled_effects::PooledEffects;
use crate::store::objects::Location;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::rows::{CauseRow, DiagnosisRow};
use crate::store::tables::{file, read};

/// Writes both, and gives back the rows.
///
/// # Errors
/// A table cannot be read, or the output not be written.
pub(crate) fn write(root: &Location, copy: &LocalCopy) -> Result<Vec<CauseRow>, Error> {
    let causes = causes(copy.folder())?;
    let effects = PooledEffects { pooled: causes.iter().filter_map(|c| c.effect()).collect() };
    let rows: Vec<CauseRow> = causes.into_iter().map(|cause| cause.row).collect();
    let path = Location::Local(copy.folder().join(FOLDER).join(TABLE));
    match rows.is_empty() {
        false => file::write(&path, &rows)?,
        true => path.remove().map_err(|e| Error::Output(format!("cannot remove {path}: {e}")))?,
    }
    // its folder has the sessions' models, too, and is not published whole
    let mut places = vec![root.join(MODEL)];
    if copy.is_copy() {
        places.push(Location::Local(copy.folder().to_owned()).join(MODEL));
    }
    for at in places {
        match effects.pooled.is_empty() {
            false => file::write_bytes(&at, effects.to_toml().as_bytes())?,
            true => at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))?,
        }
    }
    Ok(rows)
}

/// What the sessions of an output share, from their own rows of `causes`.
fn causes(out: &Path) -> Result<Vec<SharedCause>, Error> {
    let mut sessions: Vec<DiagnosisRow> = read::rows(out)?;
    // sums depend on the order, in the last digit
    sessions.sort_by(|a, b| Path::new(&a.path).cmp(Path::new(&b.path)));
    let causes = SessionFiles::<CauseRow>::read(out)?;
    let mut pooling = Pooling::default();
    for session in sessions {
        let DiagnosisRow { ident, site, poolable, .. } = session;
        let causes = causes.rows(&ident)?;
        pooling.add(Member { ident, site, sound: poolable }, &causes);
    }
    Ok(pooling.causes())
}
