//! One session's page, when somebody asks for it.

use std::path::{Path, PathBuf};

use crate::report::assets::{self, Pages};
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::diagnosis::tables::causes;
use crate::report::error::Error;
use crate::report::find::find;
use crate::report::lock::Lock;
use crate::report::session::neighbours::{Neighbours, neighbours};
use crate::report::session::{bench_values, write::Writer};
use crate::report::tables::{self, RunTables, SessionTables};
use crate::report::written::Written;
use crate::report::{page_names, page_shell};
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::rows::{ForceRow, Ident, SessionRow};

/// Writes the page of one session, unless it is there and up to date, and nothing else of the report;
/// its path. The bike is needed where several have a session of that name.
///
/// # Errors
/// There is no such session or there are several, a table cannot be read, the page cannot be written.
pub fn open(out: &Path, session: &str, bike: Option<&str>, kind: Pages) -> Result<PathBuf, Error> {
    tables::check(out)?;
    let _lock = Lock::take(out);
    let sessions = SessionFiles::<SessionRow>::read(out)?;
    let keys: Vec<(&str, &str)> = sessions.keys().collect();
    let place = find(&keys, session, bike)?;
    // a page's name goes by those of the others
    let names = page_names::sessions(keys.iter().copied());
    let ident = Ident {
        bike_id: keys[place].0.to_owned(),
        session_id: keys[place].1.to_owned(),
        start_time: None,
    };
    let tables = RunTables::read_one(out, &ident)?;
    let stored = SessionTables::read_one(out, &ident)?;
    let forces = SessionFiles::<ForceRow>::read_one(out, &ident)?.rows(&ident)?;
    let bench = bench_values::read(out)?;
    let diagnosed = Diagnosed::read(out, &[], &[], &names)?;
    let environment = page_shell::environment()?;
    let folder = out.join("report");
    let beside = match kind.on_demand(keys.len()) {
        true => Neighbours::default(),
        false => {
            let there = page_shell::written(&folder);
            let page =
                |name: &String| if there.contains(name) { name.clone() } else { String::new() };
            let pages: Vec<String> = names.iter().map(page).collect();
            neighbours(&tables::sessions(out)?, &pages).swap_remove(place)
        }
    };
    let whole = Written::whole(&folder);
    let writer = Writer {
        tables: &tables,
        stored: &stored,
        forces: &forces,
        bench: &bench,
        diagnosed: &diagnosed,
        environment: &environment,
        folder: &folder,
        source: kind.source(keys.len()),
        kept: Some(kind),
        neighbours: std::slice::from_ref(&beside),
        whole: &whole,
    };
    let name = &names[place];
    if writer.write(std::slice::from_ref(name))? {
        assets::write(&folder)?;
    }
    if assets::has_written(&folder) {
        let there = page_shell::written(&folder);
        assets::write_written(
            &folder,
            names.iter().map(String::as_str).filter(|n| there.contains(*n)),
        )?;
    }
    Written::list(&folder)?;
    Ok(folder.join(name))
}

/// Makes sure that an output has a session, of whichever bike: one of a run or one that was diagnosed.
///
/// # Errors
/// There is none of that name, or a table cannot be read.
pub(crate) fn require_session(out: &Path, session: &str) -> Result<(), Error> {
    let (ridden, diagnosed) = (tables::sessions(out)?, causes(out)?);
    let idents = ridden.iter().map(|s| &s.ident).chain(diagnosed.iter().map(|c| &c.ident));
    let keys: Vec<(&str, &str)> =
        idents.map(|i| (i.bike_id.as_str(), i.session_id.as_str())).collect();
    match keys.iter().any(|key| key.1 == session) {
        true => Ok(()),
        false => find(&keys, session, None).map(|_| ()),
    }
}
