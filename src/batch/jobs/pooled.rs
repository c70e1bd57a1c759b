//! What is made over all diagnosed sessions: the pooled rows of `causes`, the same for `run --model`, and what differs
//! between a motorcycle's sessions.

use std::path::Path;

use crate::batch::error::Error;
use crate::batch::fleet::compare::select::select;
use crate::batch::store::kind::{
    CHANGES, SHARED as FOLDER, SHARED_MODEL as MODEL, SHARED_TABLE as TABLE,
};
use crate::batch::store::local_copy::LocalCopy;
use crate::batch::store::printed_changes;
use crate::diagnose::levels::{Member, Pooling, SharedCause};
use crate::diagnose::reference::against::{self, Against};
use crate::diagnose::reference::{self, numbers::Ride};
use crate::simulate::effects::pooled_effects::PooledEffects;
use crate::store::objects::Location;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::rows::{
    CauseRow, ChangeRow, Circumstances, DiagnosisRow, EffectTrace, EstimateRow, Ident, SessionRow,
};
use crate::store::tables::{file, read};

/// Results over all sessions.
#[derive(Debug, Default)]
pub struct OverAll {
    /// Pooled rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// Rows of `changes`.
    pub changes: Vec<ChangeRow>,
    /// The rows that a diagnosis last printed; `None` of an output that had none, or none that can be read.
    pub earlier: Option<Vec<ChangeRow>>,
}

/// Writes all of it, and gives back the rows.
///
/// # Errors
/// A table cannot be read, or the output not be written.
pub(crate) fn write(root: &Location, copy: &LocalCopy) -> Result<OverAll, Error> {
    let sessions = sessions(copy.folder())?;
    let causes = causes(copy.folder(), &sessions)?;
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
    let changes = changes(copy.folder(), &sessions)?;
    let earlier = printed_changes::keep(root, &changes, copy.is_whole())?;
    let earlier = Some(earlier).filter(|rows| !rows.is_empty());
    let path = copy.folder().join(CHANGES).join(format!("{CHANGES}.parquet"));
    file::write(Location::Local(path), &changes)?;
    Ok(OverAll { causes: rows, changes, earlier })
}

/// The diagnosed sessions, in order of path: sums depend on the order, in the last digit.
fn sessions(out: &Path) -> Result<Vec<DiagnosisRow>, Error> {
    let mut sessions: Vec<DiagnosisRow> = read::rows(out)?;
    sessions.sort_by(|a, b| Path::new(&a.path).cmp(Path::new(&b.path)));
    Ok(sessions)
}

/// Changes between a motorcycle's sessions, from `estimates` and `effect_traces`.
fn changes(out: &Path, sessions: &[DiagnosisRow]) -> Result<Vec<ChangeRow>, Error> {
    Ok(reference::changes(rides(out, sessions)?))
}

/// Differences of a motorcycle's other rides, as one group, from the rides that a text selects, as for `compare`.
///
/// # Errors
/// `Usage`: the text names none, or too few of a motorcycle. A table cannot be read.
pub(crate) fn against(out: &Path, text: &str) -> Result<Vec<Against>, Error> {
    let sessions = sessions(out)?;
    // a diagnosis of an older version knows neither tyres nor rider; `run` does, if it wrote into the same output
    let known: Vec<SessionRow> = read::rows(out)?;
    let row = |d: &DiagnosisRow| {
        let of_run = known.iter().find(|s| s.ident.key() == d.ident.key()).cloned();
        let Circumstances { site, rider_id, tyre_front, tyre_rear } = d.circumstances.clone();
        let plain = SessionRow { site, rider_id, tyre_front, tyre_rear, ..SessionRow::default() };
        SessionRow { ident: d.ident.clone(), ..of_run.unwrap_or(plain) }
    };
    let rows: Vec<SessionRow> = sessions.iter().map(row).collect();
    let usage = |e: String| Error::Usage(format!("--against {text}: {e}"));
    let chosen = select(text, &rows).map_err(usage)?;
    let is_reference = |ident: &Ident| chosen.iter().any(|row| row.ident.key() == ident.key());
    against::against(rides(out, &sessions)?, is_reference).map_err(usage)
}

/// The rides on the road, with all that they say.
fn rides(out: &Path, sessions: &[DiagnosisRow]) -> Result<Vec<Ride>, Error> {
    let estimates = SessionFiles::<EstimateRow>::read(out)?;
    let traces = SessionFiles::<EffectTrace>::read(out)?;
    let mut rides = Vec::new();
    for DiagnosisRow { ident, circumstances, .. } in sessions {
        let own = Ride {
            ident: ident.clone(),
            circumstances: circumstances.clone(),
            estimates: estimates.rows(ident)?,
            traces: traces.rows(ident)?,
        };
        // off the road there are none
        if !own.estimates.is_empty() {
            rides.push(own);
        }
    }
    Ok(rides)
}

/// Causes that sessions of an output share, from the sessions' rows of `causes`.
fn causes(out: &Path, sessions: &[DiagnosisRow]) -> Result<Vec<SharedCause>, Error> {
    let causes = SessionFiles::<CauseRow>::read(out)?;
    let mut pooling = Pooling::default();
    for session in sessions {
        let DiagnosisRow { ident, circumstances, poolable, .. } = session.clone();
        let causes = causes.rows(&ident)?;
        pooling.add(Member { ident, site: circumstances.site, sound: poolable }, &causes);
    }
    Ok(pooling.causes())
}
