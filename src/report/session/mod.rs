//! The page of one session.

pub mod bench_points;
pub mod bench_values;
pub mod forces;
pub mod laps;
pub mod page;
pub mod write;
