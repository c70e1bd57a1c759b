//! The report: a pure function of the tables.
//!
//! [`write()`] reads the tables of an output folder and writes `report/index.html` and one page
//! per session beside it, and one per diagnosed session ([`diagnosis`]). However large the archive,
//! its page stays short: long tables come by pages ([`list`]), many bikes have a page each, and of
//! more than a thousand sessions a page is written when somebody asks for it ([`open()`]). A page opens from disk,
//! offline: it holds all it needs, or, of many, its data alone, with style and script in a folder
//! beside them ([`assets`]). The templates are in `reports/`; the chart library is embedded whole.
//!
//! A folder per kind of page ([`run`], [`session`], [`fleet`], [`diagnosis`]) and what they share:
//! the shell of a page ([`page_shell`]), charts ([`charts`]), drawings inside tables
//! ([`inline_svg`]), number formats ([`number_format`]). The same charts become files in
//! [`static_figures`], the same numbers text in [`terminal`] and [`markdown`].
//!
//! Texts from logs are hostile until escaped: the templates escape every value, and the data
//! inside a script is packed ([`charts::pack`]).

pub use assets::Pages;
pub use build::{build, update, write};
pub use error::Error;
pub use open::open;
pub use page_shell::is_own;
pub use written::{damaged, is_whole};

pub mod as_read;
pub mod assets;
pub mod build;
pub mod charts;
pub mod coefficient_text;
pub mod diagnosis;
pub mod error;
pub mod export;
pub mod fleet;
pub mod inline_svg;
pub mod kinds;
pub mod labels;
pub mod list;
mod lock;
pub mod markdown;
pub mod number_format;
pub mod open;
pub mod page_names;
pub mod page_shell;
pub mod plots;
pub mod run;
pub mod session;
pub mod static_figures;
pub mod summary;
pub mod tables;
pub mod terminal;
pub mod written;
