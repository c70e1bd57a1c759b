//! What a detector is: it claims blocks of a ride for a kind of manoeuvre and judges what it gets.

use crate::contract::reason::{Reason, ReasonCode};
use std::ops::Range;

use super::declaration::{Declaration, Direction};
use super::features::Features;

/// Blocks that a detector takes for a manoeuvre.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    pub at: Range<usize>,
    pub kind: &'static Declaration,
    /// Side of a corner; of a straight manoeuvre it follows from the heading.
    pub direction: Option<Direction>,
}

impl Claim {
    /// A claim without a side.
    pub fn new(at: Range<usize>, kind: &'static Declaration) -> Self {
        Claim { at, kind, direction: None }
    }
}

/// Whether a piece can be used for estimation.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// 0 to 1; NaN counts as 0.
    pub quality: f64,
    /// Why it cannot be used; `None` where it can.
    pub reason: Option<Reason>,
}

impl Verdict {
    /// Of quality 0, for this reason.
    pub fn unusable(code: ReasonCode, sentence: impl Into<String>) -> Self {
        Verdict { quality: 0.0, reason: Some(Reason::new(code, sentence)) }
    }
}

/// One way of riding that is looked for on the coarse clock.
pub trait Detector {
    /// Claims; where two overlap the later one in the list has the blocks.
    fn find(&self, f: &Features) -> Vec<Claim>;

    /// Pieces shorter than this go to their longer neighbour, s.
    fn shortest(&self) -> f64 {
        0.0
    }

    /// Judges the piece `claim` that is left of the claims. `braked` are the blocks in which any
    /// detector found a brake on, in corners too.
    fn judge(&self, f: &Features, claim: &Claim, braked: &[bool]) -> Verdict;
}
