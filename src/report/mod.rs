//! The report: a pure function of the tables.
//!
//! [`write()`] reads the tables of an output folder and writes `report/index.html` and one page
//! per session beside it, and one per diagnosed session ([`diagnosis`]). However large the archive,
//! its page stays short: long tables come by pages ([`list`]), many bikes have a page each, and of
//! more than a thousand sessions a page is written when somebody asks for it ([`open()`]). A page opens from disk,
//! offline: it holds all it needs, or, of many, its data alone, with style and script in a folder
//! beside them ([`assets`]). The templates are in `reports/`; the chart library is embedded whole.
//!
//! A folder per kind of page ([`run`], [`session`], [`fleet`], [`diagnosis`], [`explorer`], [`comparison`]) and what they share:
//! the shell of a page ([`page_shell`]), charts ([`charts`]), drawings inside tables
//! ([`inline_svg`]), number formats ([`number_format`](crate::statistics::number_format)). The same charts become files in
//! [`static_figures`], the same numbers text in [`terminal`] and [`markdown`].
//!
//! Texts from logs are hostile until escaped: the templates escape every value, and the data
//! inside a script is packed ([`charts::pack`]).

pub(crate) use assets::Pages;
pub(crate) use build::build;
pub(crate) use error::Error;
pub(crate) use open::open;
pub(crate) use page_shell::is_own;
pub(crate) use written::{damaged, is_whole};

pub(crate) mod answer;
pub(crate) mod as_read;
pub(crate) mod assets;
pub(crate) mod build;
pub(crate) mod change_sentence;
pub(crate) mod charts;
pub(crate) mod coefficient_text;
pub(crate) mod comparison;
pub(crate) mod diagnosis;
pub(crate) mod error;
pub(crate) mod explorer;
pub(crate) mod export;
pub(crate) mod find;
pub(crate) mod fleet;
pub(crate) mod inline_svg;
pub(crate) mod kinds;
pub(crate) mod labels;
pub(crate) mod list;
pub(crate) mod list_of_sessions;
mod lock;
pub(crate) mod markdown;
pub(crate) mod next_ride;
pub(crate) mod open;
pub(crate) mod page_names;
pub(crate) mod page_shell;
pub(crate) mod parameter_words;
pub(crate) mod plots;
pub(crate) mod readable;
pub(crate) mod run;
pub(crate) mod session;
pub(crate) mod static_figures;
pub(crate) mod summary;
pub(crate) mod tables;
pub(crate) mod terminal;
pub(crate) mod written;
