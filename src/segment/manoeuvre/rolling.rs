//! Rolling into and out of a corner: no longer straight and not yet a corner, so it is not used.

use crate::contract::reason::ReasonCode;
use std::ops::Range;

use super::cornering;
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;
use super::mask::runs;
use super::standing::OTHER;

/// Longest stretch before and after a corner that is looked at, s.
const REACH: f64 = 1.5;
/// Pieces shorter than this go to their neighbour, s.
const SHORTEST: f64 = 0.2;

/// Next to the corners that these settings find.
#[derive(Debug)]
pub(crate) struct Rolling<'a>(pub &'a cornering::Config);

impl Detector for Rolling<'_> {
    fn find(&self, f: &Features) -> Vec<Claim> {
        let Rolling(config) = self;
        let bends = cornering::bends(f, config);
        let mut rolling = vec![false; f.len()];
        let reach = f.blocks(REACH);
        for Range { start, end } in runs(&bends) {
            let side = f.lean[(start + end) / 2].signum();
            for i in (start.saturating_sub(reach)..start).rev() {
                let rolls_in = side * f.lean_rate[i] > config.roll_rate;
                if !rolls_in || bends[i] {
                    break;
                }
                rolling[i] = true;
            }
            for i in end..(end + reach).min(f.len()) {
                let rolls_out = side * f.lean_rate[i] < -config.roll_rate;
                if !rolls_out || bends[i] {
                    break;
                }
                rolling[i] = true;
            }
        }
        runs(&rolling).into_iter().map(|at| Claim::new(at, &OTHER)).collect()
    }

    fn shortest(&self) -> f64 {
        SHORTEST
    }

    fn judge(&self, _: &Features, _: &Claim, _: &[bool]) -> Verdict {
        Verdict::unusable(ReasonCode::Transition, "rolling into or out of a corner")
    }
}
