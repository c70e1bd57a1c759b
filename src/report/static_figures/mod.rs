//! Figures as SVG and PNG files, for papers, READMEs and continuous integration. Drawn by `kuva`.

pub(crate) mod chart;
pub(crate) mod drawing;
pub(crate) mod listed;
pub(crate) mod panels;
pub(crate) mod write;
