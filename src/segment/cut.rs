//! Claims of several detectors made into segments that cover the ride.

use super::heading::Axis;
use super::segments::Segment;
use crate::segment::manoeuvre::detector::{Claim, Detector};
use crate::segment::manoeuvre::features::Features;
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};

/// Who has a block: place of the detector, and what it claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Owner {
    detector: usize,
    kind: ManoeuvreKind,
    direction: Option<Direction>,
}

/// A run of blocks with one owner.
struct Piece {
    owner: Owner,
    claim: Claim,
}

impl Piece {
    fn len(&self) -> usize {
        self.claim.at.len()
    }
}

/// Cuts `samples` samples into segments. Of several detectors that claim a block the first in the
/// list has it; blocks that nobody claims are the last one's.
pub(super) fn cut(
    f: &Features,
    detectors: &[Box<dyn Detector + '_>],
    samples: usize,
) -> Vec<Segment> {
    let found: Vec<Vec<Claim>> = detectors.iter().map(|d| d.find(f)).collect();
    let mut braked = vec![false; f.len()];
    for claim in found.iter().flatten().filter(|c| c.kind.is_braking()) {
        braked[claim.at.clone()].fill(true);
    }
    let pieces = merge_short(owners(&found, f.len()), |detector| {
        // at least one block: zero seconds keep every piece
        f.blocks(detectors[detector].shortest())
    });
    let axis = Axis::new(f, pieces.iter().map(|p| &p.claim));
    // without any sign of lean a straight is only assumed to be one
    let trust = if f.lean.iter().any(|l| l.is_finite()) { 1.0 } else { 0.5 };
    pieces
        .into_iter()
        .map(|Piece { owner, claim }| {
            let verdict = detectors[owner.detector].judge(f, &claim, &braked);
            let straight = claim.kind.is_straight();
            Segment {
                kind: owner.kind,
                start: claim.at.start * f.step,
                end: (claim.at.end * f.step).min(samples),
                direction: if straight { axis.direction(f, &claim.at) } else { claim.direction },
                quality: if verdict.quality.is_finite() { trust * verdict.quality } else { 0.0 },
                used: verdict.reason.is_none(),
                reason: verdict.reason,
            }
        })
        .collect()
}

/// The owner of each of `blocks` blocks.
fn owners(found: &[Vec<Claim>], blocks: usize) -> Vec<Owner> {
    let nobody = Owner {
        detector: found.len().saturating_sub(1),
        kind: ManoeuvreKind::Other,
        direction: None,
    };
    let mut owners = vec![nobody; blocks];
    for (detector, claims) in found.iter().enumerate().rev() {
        for Claim { at, kind, direction } in claims {
            let kind = ManoeuvreKind::of(kind);
            owners[at.clone()].fill(Owner { detector, kind, direction: *direction });
        }
    }
    owners
}

/// Runs of one owner; ones shorter than `shortest` blocks of their detector go to the longer
/// neighbour, the shortest first.
fn merge_short(owners: Vec<Owner>, shortest: impl Fn(usize) -> usize) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::new();
    for (i, owner) in owners.into_iter().enumerate() {
        match out.last_mut() {
            Some(last) if last.owner == owner => last.claim.at.end = i + 1,
            _ => {
                let Owner { kind, direction, .. } = owner;
                let claim = Claim { at: i..i + 1, kind: kind.declaration(), direction };
                out.push(Piece { owner, claim });
            }
        }
    }
    while let Some(k) = (0..out.len())
        .filter(|&k| out.len() > 1 && out[k].len() < shortest(out[k].owner.detector))
        .min_by_key(|&k| out[k].len())
    {
        let before = k.checked_sub(1).map_or(0, |j| out[j].len());
        let after = out.get(k + 1).map_or(0, Piece::len);
        let at = out.remove(k).claim.at;
        let heir = if before >= after { k - 1 } else { k };
        let whole = &mut out[heir].claim.at;
        *whole = whole.start.min(at.start)..whole.end.max(at.end);
        // the pieces on both sides of it may have one owner
        if k > 0 && k < out.len() && out[k - 1].owner == out[k].owner {
            let next = out.remove(k);
            out[k - 1].claim.at.end = next.claim.at.end;
        }
    }
    out
}
