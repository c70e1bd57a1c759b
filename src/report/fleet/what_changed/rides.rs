//! The rides of each motorcycle, in order of time.

use std::collections::BTreeMap;
use std::path::Path;

use crate::contract::instant;
use crate::report::error::Error;
use crate::store::tables::read;
use crate::store::tables::rows::{ChangeRow, Circumstances, DiagnosisRow, Ident, SessionRow};

#[derive(Debug, Clone, Default)]
pub(crate) struct Ride {
    pub ident: Ident,
    /// Where, by whom and on what tyres.
    pub circumstances: Circumstances,
    /// Its page; empty where it has none.
    pub page: String,
    /// Whether `run` has it: events are of these.
    pub is_of_run: bool,
}

/// The rides of one motorcycle, in order of time; those without a time first, by their names.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rides {
    pub rides: Vec<Ride>,
    /// Place of each by its id.
    places: BTreeMap<String, usize>,
}

impl Rides {
    /// In order of time.
    pub(crate) fn new(mut rides: Vec<Ride>) -> Self {
        rides.sort_by(|a, b| {
            let key = |r: &Ride| (r.ident.start_time.clone(), r.ident.session_id.clone());
            key(a).cmp(&key(b))
        });
        let places = rides.iter().map(|r| r.ident.session_id.clone()).zip(0..).collect();
        Rides { rides, places }
    }

    /// Place of a ride.
    pub(crate) fn place(&self, session_id: &str) -> Option<usize> {
        self.places.get(session_id).copied()
    }

    /// Start of each in seconds since 1970; `None` where one is not known, or all are the same.
    pub(crate) fn times(&self) -> Option<Vec<f64>> {
        let of =
            |r: &Ride| Some(instant::microseconds(r.ident.start_time.as_deref()?)? as f64 * 1e-6);
        let times: Vec<f64> = self.rides.iter().map(of).collect::<Option<_>>()?;
        (times.last()? > times.first()?).then_some(times)
    }
}

/// The rides of every motorcycle that `run` or the comparison of rides knows. `pages` are those of the `sessions`,
/// `diagnosis` is the page of a diagnosed one.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn read<'a>(
    out: &Path,
    sessions: &[SessionRow],
    pages: &[String],
    changes: &[ChangeRow],
    diagnosis: impl Fn(&Ident) -> Option<&'a str>,
) -> Result<BTreeMap<String, Rides>, Error> {
    let mut all: BTreeMap<(String, String), Ride> = BTreeMap::new();
    let key = |ident: &Ident| (ident.bike_id.clone(), ident.session_id.clone());
    for (row, page) in sessions.iter().zip(pages) {
        let SessionRow { ident, site, rider_id, tyre_front, tyre_rear, .. } = row.clone();
        let circumstances = Circumstances { site, rider_id, tyre_front, tyre_rear };
        let place = key(&ident);
        all.insert(place, Ride { ident, circumstances, page: page.clone(), is_of_run: true });
    }
    if !changes.is_empty() {
        for row in read::rows::<DiagnosisRow>(out)? {
            let (ident, circumstances) = (row.ident, row.circumstances);
            all.entry(key(&ident)).or_insert_with(|| Ride {
                ident,
                circumstances,
                ..Ride::default()
            });
        }
    }
    for row in changes {
        let plain = || Ride { ident: row.ident.clone(), ..Ride::default() };
        let ride = all.entry(key(&row.ident)).or_insert_with(plain);
        // the page of the diagnosis shows the change
        if let Some(page) = diagnosis(&row.ident) {
            page.clone_into(&mut ride.page);
        }
    }
    let mut bikes: BTreeMap<String, Vec<Ride>> = BTreeMap::new();
    for ((bike, _), ride) in all {
        bikes.entry(bike).or_default().push(ride);
    }
    Ok(bikes.into_iter().map(|(bike, rides)| (bike, Rides::new(rides))).collect())
}
