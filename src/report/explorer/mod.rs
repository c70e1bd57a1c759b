//! The tyre explorer: fitted tyres at a load, camber and road of the reader's choice.
//!
//! The page holds each tyre's row of `tyre_parameters` and the bands of its session's charts, and each tyre over all its
//! rides ([`pooled`]); its script evaluates the
//! model (`reports/charts/tyre_model.js`), and is compared with points of the program's own.

pub(crate) mod pooled;
pub(crate) mod tyre;
pub(crate) mod write;

/// File name of the page.
pub(crate) const PAGE: &str = "tyres.html";
