//! The page of a comparison of two sets of sessions.

use minijinja::context;
use minijinja::value::Serde;
use serde::Serialize;

use crate::report::assets::Source;
use crate::report::error::Error;
use crate::report::page_shell;

/// Text of the page.
#[derive(Debug, Serialize)]
pub(crate) struct Content {
    /// Title of the browser's tab: both sides as they were chosen.
    pub title: String,
    /// Sides A and B in a line each.
    pub sides: [String; 2],
    pub sentences: Vec<String>,
    /// Heading and rows of each tyre.
    pub tyres: Vec<(String, Vec<Row>)>,
    /// Load of the curves, N.
    pub load: String,
    /// Numbers of the curves at that load.
    pub curves: Vec<Row>,
    /// Sessions that would decide the rest.
    pub undecided: Vec<Paragraph>,
    /// Coefficients without a value on one side.
    pub not_comparable: Vec<String>,
}

/// One number on both sides.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub(crate) struct Row {
    pub name: String,
    pub a: String,
    pub b: String,
    pub difference: String,
    pub interval: String,
    /// A drawing of the interval.
    pub bar: String,
    pub chance: String,
    pub verdict: String,
    pub sentence: String,
}

/// A text with what belongs to it.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in the template
pub(crate) struct Paragraph {
    pub text: String,
    pub items: Vec<String>,
}

/// The page as HTML.
///
/// # Errors
/// The template cannot be rendered: our own mistake.
pub(crate) fn html(content: &Content) -> Result<String, Error> {
    let environment = page_shell::environment()?;
    let template = environment.get_template("comparison.html")?;
    Ok(template.render(context! { page => Serde(content), ..page_shell::context(Source::Page) })?)
}
