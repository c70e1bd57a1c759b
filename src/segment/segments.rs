//! Segments: what the stage gives to the estimates and to the table `manoeuvres`.

use crate::contract::reason::Reason;
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};

/// One manoeuvre: samples `start..end` of the session.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Manoeuvre of the rider.
    pub kind: ManoeuvreKind,
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
    /// Side of a corner or way along the road; `None` where the ride does not show it.
    pub direction: Option<Direction>,
    /// 0 (unusable) to 1.
    pub quality: f64,
    /// Whether estimation may use it.
    pub used: bool,
    /// Why estimation may not use it.
    pub reason: Option<Reason>,
}
