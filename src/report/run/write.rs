//! Writing the page of the run, that of the fleet, and those of the bikes.

use std::collections::BTreeMap;
use std::path::Path;

use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use rayon::prelude::*;

use crate::report::assets::{INDEX_SCRIPT, Source};
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::fleet;
use crate::report::fleet::page::PAGE;
use crate::report::fleet::tables::FleetTables;
use crate::report::fleet::what_changed::motorcycle::{Motorcycle, Sources};
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
/// Motorcycles that changed, and that did not, which the run's page lists.
const CHANGED: usize = 12;

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
        let events = fleet::tables::events(self.out)?;
        let sessions = &self.tables.sessions;
        let histories = fleet::tables::histories(self.out, sessions)?;
        let of_run = (&fleet[..], &events[..], &histories);
        let sources = Sources::read(self.out, (sessions, self.pages), self.diagnosed, of_run)?;
        let mut changed = sources.motorcycles();
        page.explorer = explorer::write::write(
            self.out,
            self.environment,
            self.tables,
            &all_rides,
            self.bench,
        )?;
        page.fleet = (!fleet.is_empty() && !sessions.is_empty()).then_some(events.len());
        let bikes = self.bikes(&page, &sources, &changed)?;
        let name_of: BTreeMap<&str, &str> =
            bikes.iter().map(|(id, name)| (id.as_str(), name.as_str())).collect();
        for motorcycle in &mut changed {
            let page = name_of.get(motorcycle.bike_id.as_str());
            motorcycle.page = page.copied().unwrap_or_default().to_owned();
        }
        let mut own: Vec<String> = bikes.iter().map(|(_, name)| name.clone()).collect();
        if page.fleet.is_some() {
            let (rows, events, histories) = (&fleet, &events, &histories);
            let tables = FleetTables { sessions, pages: self.pages, rows, events, histories };
            fleet::write::write(self.out, self.environment, &tables, &changed)?;
            own.push(PAGE.to_owned());
        }
        if page.explorer {
            own.push(explorer::PAGE.to_owned());
        }
        self.index(page, &changed, &name_of)?;
        Ok(own)
    }

    /// Writes the page of each motorcycle of which something can be said, and of all where they are too many for the run's; each
    /// id with the name of its page.
    fn bikes(
        &self,
        page: &Page,
        sources: &Sources<'_>,
        changed: &[Motorcycle],
    ) -> Result<Vec<(String, String)>, Error> {
        // there may be thousands
        let changed = by_id(changed);
        let of_run: BTreeMap<&str, &BikePart> =
            page.bikes.iter().map(|bike| (bike.bike_id.as_str(), bike)).collect();
        let is_many = page.bikes.len() > INLINE;
        let all = page.bikes.iter().map(|bike| bike.bike_id.as_str());
        let mut ids: Vec<&str> = all.filter(|id| is_many || changed.contains_key(id)).collect();
        // of those that are diagnosed only
        ids.extend(changed.keys().copied().filter(|id| !of_run.contains_key(id)));
        let taken = self.names.iter().map(String::as_str).chain(self.diagnosed.pages());
        let names = page_names::bikes(ids.iter().copied(), taken);
        ids.par_iter().zip(&names).try_for_each(|(id, name)| {
            let own = of_run.get(id).copied();
            let sessions = of_bike(&page.sessions, id, |s| &s.bike_id);
            let diagnosed_only = BikePart { bike_id: (*id).to_owned(), ..BikePart::default() };
            let html = self.environment.get_template("bike.html")?.render(context! {
                bike => Serde(own.unwrap_or(&diagnosed_only)),
                fleet => page.fleet.is_some(),
                explorer => page.explorer,
                changed => Serde(changed.get(id)),
                lines => Serde(sources.lines(id)),
                sessions => Serde(match sessions.is_empty() {
                    true => None,
                    false => Some(lists::sessions(sessions).shown()?),
                }),
                ..self.context()
            })?;
            Ok::<(), Error>(self.put(name, &html)?)
        })?;
        Ok(ids.into_iter().map(str::to_owned).zip(names).collect())
    }

    /// Writes the run's page.
    fn index(
        &self,
        page: Page,
        changed: &[Motorcycle],
        name_of: &BTreeMap<&str, &str>,
    ) -> Result<(), Error> {
        let is_many = page.bikes.len() > INLINE;
        let listed = match is_many {
            false => None,
            true => {
                let by_id = by_id(changed);
                let of = |id: &str| by_id.get(id).map_or(0, |m| m.entries.len());
                let pages: Vec<String> = page
                    .bikes
                    .iter()
                    .map(|b| {
                        name_of.get(b.bike_id.as_str()).copied().unwrap_or_default().to_owned()
                    })
                    .collect();
                Some(notable::list(&page.bikes, &pages, of).shown()?)
            }
        };
        let inline: &[BikePart] = if is_many { &[] } else { &page.bikes };
        let list = |list: crate::report::list::List| match list.rows.is_empty() {
            true => Ok(None),
            false => list.shown().map(Some),
        };
        let (different, same): (Vec<&Motorcycle>, Vec<&Motorcycle>) =
            changed.iter().partition(|m| !m.entries.is_empty());
        let shown = &different[..different.len().min(CHANGED)];
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
            changed => changed.len(),
            different => Serde(shown),
            more_different => different.len() - shown.len(),
            same => Serde(&same[..same.len().min(CHANGED)]),
            more_same => same.len().saturating_sub(CHANGED),
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

fn by_id(changed: &[Motorcycle]) -> BTreeMap<&str, &Motorcycle> {
    changed.iter().map(|motorcycle| (motorcycle.bike_id.as_str(), motorcycle)).collect()
}
