//! The page of one session.

pub(crate) mod bench_points;
pub(crate) mod bench_values;
pub(crate) mod cards;
pub(crate) mod forces;
pub(crate) mod lap_trends;
pub(crate) mod laps;
pub(crate) mod neighbours;
pub(crate) mod page;
pub(crate) mod printed;
pub(crate) mod write;
