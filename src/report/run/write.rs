//! Writing the page of the run, that of the fleet, and those of the bikes.

use std::path::Path;

use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use rayon::prelude::*;

use crate::report::assets::{INDEX_SCRIPT, Source};
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::fleet::page::Event;
use crate::report::fleet::{self, page::PAGE};
use crate::report::run::bikes::{BikePart, of_bike};
use crate::report::run::page::Page;
use crate::report::run::{lists, notable, page};
use crate::report::session::bench_values::BenchValues;
use crate::report::tables::{self, RunTables};
use crate::report::{explorer, page_names, page_shell};
use crate::store::tables::rows::TyreRow;
use crate::store::tables::{file, read};

/// Bikes up to which their coefficients stand on the run's page itself.
const INLINE: usize = 4;

/// All that these pages are made from.
pub(crate) struct Writer<'a> {
    pub(crate) out: &'a Path,
    pub(crate) environment: &'a Environment<'a>,
    pub(crate) tables: &'a RunTables,
    pub(crate) diagnosed: &'a Diagnosed,
    /// Names of the sessions' pages, in their order.
    pub(crate) names: &'a [String],
    /// The same, empty where no page is.
    pub(crate) pages: &'a [String],
    /// Whether a page that is not there is written when somebody asks for it.
    pub(crate) on_demand: bool,
    pub(crate) bench: &'a BenchValues,
}

impl Writer<'_> {
    /// Writes the pages; the names of those beside the run's.
    pub(crate) fn write(&self) -> Result<Vec<String>, Error> {
        let fleet = fleet::tables::fleet(self.out)?;
        let rejected = tables::rejected(self.out)?;
        let all_rides: Vec<TyreRow> = read::rows(self.out)?;
        let mut page = page::build(self.tables, self.names, rejected, &fleet, &all_rides);
        for (entry, there) in page.sessions.iter_mut().zip(self.pages) {
            entry.there = !there.is_empty();
        }
        page.diagnoses = self.diagnosed.entries();
        let mut own = Vec::new();
        let mut events = Vec::new();
        if !fleet.is_empty() && !page.sessions.is_empty() {
            let sessions = &self.tables.sessions;
            events = fleet::write::write(self.out, self.environment, sessions, self.pages)?;
            page.fleet = Some(events.len());
            own.push(PAGE.to_owned());
        }
        page.explorer =
            explorer::write::write(self.out, self.environment, self.tables, self.bench)?;
        if page.explorer {
            own.push(explorer::PAGE.to_owned());
        }
        let bikes = self.bikes(&page, &events)?;
        self.index(page, &bikes, &events)?;
        own.extend(bikes);
        Ok(own)
    }

    /// Writes the bikes' pages where there are too many for the run's; their names.
    fn bikes(&self, page: &Page, events: &[Event]) -> Result<Vec<String>, Error> {
        if page.bikes.len() <= INLINE {
            return Ok(Vec::new());
        }
        let ids = page.bikes.iter().map(|b| b.bike_id.as_str());
        let taken = self.names.iter().map(String::as_str).chain(self.diagnosed.pages());
        let names = page_names::bikes(ids, taken);
        page.bikes.par_iter().zip(&names).try_for_each(|(bike, name)| {
            let sessions = of_bike(&page.sessions, &bike.bike_id, |s| &s.bike_id);
            let events: Vec<&Event> = events.iter().filter(|e| e.bike == bike.bike_id).collect();
            let count = events.len();
            let events = match count {
                0 => None,
                _ => Some(fleet::lists::events(events.into_iter()).shown()?),
            };
            let html = self.environment.get_template("bike.html")?.render(context! {
                bike => Serde(bike),
                fleet => page.fleet.is_some(),
                explorer => page.explorer,
                count => count,
                events => Serde(events),
                sessions => Serde(lists::sessions(sessions).shown()?),
                ..self.context()
            })?;
            Ok::<(), Error>(self.put(name, &html)?)
        })?;
        Ok(names)
    }

    /// Writes the run's page.
    fn index(&self, page: Page, bikes: &[String], events: &[Event]) -> Result<(), Error> {
        let listed = match bikes.is_empty() {
            true => None,
            false => {
                let of = |id: &str| events.iter().filter(|e| e.bike == id).count();
                Some(notable::list(&page.bikes, bikes, of).shown()?)
            }
        };
        let inline: &[BikePart] = if bikes.is_empty() { &page.bikes } else { &[] };
        let list = |list: crate::report::list::List| match list.rows.is_empty() {
            true => Ok(None),
            false => list.shown().map(Some),
        };
        let html = self.environment.get_template("run.html")?.render(context! {
            run => context! {
                inputs => page.inputs,
                verdict => page.verdict,
                answer => page.answer,
                ridden => page.ridden,
                fleet => page.fleet,
                explorer => page.explorer,
                warnings => Serde(&page.warnings),
            },
            bikes => Serde(inline),
            listed => Serde(listed),
            changed => Serde(self.diagnosed.motorcycles()),
            found => self.diagnosed.answer(),
            diagnoses => Serde(list(lists::diagnoses(&page.diagnoses))?),
            sessions => Serde(list(lists::sessions(&page.sessions))?),
            rejected => Serde(list(lists::rejected(&page.rejected))?),
            ..self.context()
        })?;
        Ok(self.put("index.html", &html)?)
    }

    fn context(&self) -> Value {
        let script = INDEX_SCRIPT.to_owned();
        context! {
            on_demand => self.on_demand,
            beside => self.on_demand,
            index_script => Value::from_safe_string(script),
            ..page_shell::context(Source::Page)
        }
    }

    fn put(&self, name: &str, html: &str) -> Result<(), file::Error> {
        file::write_bytes(self.out.join("report").join(name), html.as_bytes())
    }
}
