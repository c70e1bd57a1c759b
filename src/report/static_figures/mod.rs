//! Figures as SVG and PNG files, for papers, READMEs and continuous integration. Drawn by `kuva`.

pub mod chart;
pub mod drawing;
pub mod listed;
pub mod panels;
pub mod write;
