//! The `plots` table: what is drawn of a session, downsampled while the samples are there.
//!
//! A plot is declared where its rows are made ([`fits`], [`ride`], [`laps`], [`residuals`], [`offroad`]) and
//! listed in the [`catalogue`], from which the report takes titles, axes and how it is drawn
//! ([`plot::Plot`]).
//!
//! Of a cloud the samples that would lie under others are left out ([`downsample`]); lines are the
//! fits over the ridden range with the 95 % interval of the curve and, inside it, the part that the
//! scatter between manoeuvres has in it ([`crate::fit::bands`]); the time line keeps the mean,
//! least and largest value of each of [`sheet::TIMELINE_BINS`] spans, so that no peak is lost.

pub(crate) mod catalogue;
pub(crate) mod downsample;
pub(crate) mod fits;
pub(crate) mod laps;
pub(crate) mod measured;
pub(crate) mod offroad;
pub(crate) mod plot;
pub(crate) mod residuals;
pub(crate) mod ride;
pub(crate) mod road;
pub(crate) mod sheet;
