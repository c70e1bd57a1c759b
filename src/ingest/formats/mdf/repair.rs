//! The readable part of an MDF 4 file that was cut off or never closed.
//!
//! Every block holds its length and its links to others, so the whole graph can be walked without
//! knowing what the blocks mean. Links that lead nowhere are cut, and data blocks end where the
//! file does. The file itself stays as it is: the corrections are laid over its bytes.

use std::collections::{BTreeMap, BTreeSet};

use falcon_mdf::io::ByteSource;

use crate::contract::warning::Warning;
use crate::ingest::warning::warning;

/// Where the first block is.
const HEADER: u64 = 64;
/// Length of a block without links and data.
const LEAST: u64 = 24;
/// Blocks of samples: the only ones that are of use without their end.
const DATA: [&[u8]; 4] = [b"##DT", b"##SD", b"##RD", b"##DV"];

#[derive(Debug, Default)]
pub(super) struct Repaired {
    /// Place and new value.
    pub patches: BTreeMap<u64, u64>,
    /// Links that lead nowhere.
    lost: usize,
    /// Bytes of data blocks that are not there.
    missing: u64,
    /// Whether the last data block ran on to the end of the file.
    ran_on: bool,
}

impl Repaired {
    pub(super) fn warnings(&self, unfinished: bool) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if unfinished {
            let on = if self.ran_on { "; its data is read to the file's end" } else { "" };
            let message = format!("the logger never closed this file (unfinalised){on}");
            warnings.push(warning("unfinalised", None, 1, None, message));
        }
        if self.missing > 0 {
            let message = format!(
                "the file is cut off: {} bytes of samples are missing; read up to there",
                self.missing
            );
            warnings.push(warning("truncated", None, 1, None, message));
        }
        if self.lost > 0 {
            let message = format!(
                "{} parts of the file are missing or damaged; their samples are left out",
                self.lost
            );
            warnings.push(warning("damaged", None, self.lost, None, message));
        }
        warnings
    }
}

struct Block {
    id: [u8; 4],
    length: u64,
    links: u64,
}

impl Block {
    fn is_data(&self) -> bool {
        DATA.contains(&&self.id[..])
    }
}

/// Walks a file's blocks.
///
/// # Errors
/// Not even its header is there.
pub(super) fn repair(bytes: &dyn ByteSource, unfinished: bool) -> Result<Repaired, String> {
    let size = bytes.len();
    let header = block_at(bytes, HEADER, false);
    if !header.is_some_and(|b| &b.id == b"##HD" && HEADER + b.length <= size) {
        return Err("its header is cut off".to_owned());
    }
    let mut repaired = Repaired::default();
    let mut seen = BTreeSet::from([HEADER]);
    let mut open = vec![HEADER];
    let mut last_data = None;
    // blocks that overlap could make work without end: no file has more links than fit into it
    let mut budget = size / 8 + 64;
    while let Some(at) = open.pop() {
        let Some(block) = block_at(bytes, at, unfinished) else { continue };
        for i in 0..block.links {
            budget = budget.checked_sub(1).ok_or("its blocks cannot be decoded")?;
            let place = at + LEAST + 8 * i;
            let Some(target) = number(bytes, place).filter(|target| *target != 0) else { continue };
            let found = block_at(bytes, target, unfinished);
            // the header's first link is to the first group of channels
            if (at, i) == (HEADER, 0) && found.is_none() {
                return Err("it is cut off before the description of its channels, which this \
                            writer puts after the samples: nothing can be read"
                    .to_owned());
            }
            let Some(found) = found else {
                repaired.patches.insert(place, 0);
                repaired.lost += 1;
                continue;
            };
            let end = target.saturating_add(found.length);
            if end > size && !found.is_data() {
                repaired.patches.insert(place, 0);
                repaired.lost += 1;
                continue;
            }
            if !seen.insert(target) {
                continue;
            }
            if end > size {
                repaired.patches.insert(target + 8, size - target);
                repaired.missing += end - size;
            }
            if found.is_data() {
                last_data = last_data.max(Some((target, found.length)));
            }
            open.push(target);
        }
    }
    // the block that was being written has the length that it was begun with
    let last = seen.iter().next_back().copied();
    if let Some((at, length)) = last_data
        && unfinished
        && length == LEAST
        && last == Some(at)
    {
        repaired.patches.insert(at + 8, size - at);
        repaired.ran_on = true;
    }
    Ok(repaired)
}

/// A block's head, if one is there.
fn block_at(bytes: &dyn ByteSource, at: u64, unfinished: bool) -> Option<Block> {
    if at.checked_add(LEAST)? > bytes.len() {
        return None;
    }
    let head = bytes.read_bytes(at, LEAST as usize).ok()?;
    let id: [u8; 4] = head[..4].try_into().ok()?;
    let word = |from: usize| head[from..from + 8].try_into().ok().map(u64::from_le_bytes);
    let (mut length, links) = (word(8)?, word(16)?);
    if unfinished && DATA.contains(&&id[..]) {
        length = length.max(LEAST);
    }
    let fits = links.checked_mul(8).and_then(|n| n.checked_add(LEAST))? <= length;
    (id.starts_with(b"##") && fits).then_some(Block { id, length, links })
}

fn number(bytes: &dyn ByteSource, at: u64) -> Option<u64> {
    if at.checked_add(8)? > bytes.len() {
        return None;
    }
    let eight: [u8; 8] = bytes.read_bytes(at, 8).ok()?[..].try_into().ok()?;
    Some(u64::from_le_bytes(eight))
}

#[cfg(test)]
mod tests {
    use super::*;
    use falcon_mdf::io::memory::MemorySource;

    fn block(id: &[u8; 4], links: &[u64], data: usize, length: Option<u64>) -> Vec<u8> {
        let own = LEAST + 8 * links.len() as u64 + data as u64;
        let mut bytes = id.to_vec();
        bytes.extend([0; 4]);
        bytes.extend(length.unwrap_or(own).to_le_bytes());
        bytes.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|l| bytes.extend(l.to_le_bytes()));
        bytes.resize(own as usize, 1);
        bytes
    }

    /// Header with links to a group at 128 and to somewhere else; the group's data at 168.
    fn file(elsewhere: u64, length: Option<u64>) -> MemorySource {
        let mut bytes = vec![0; 64];
        bytes.extend(block(b"##HD", &[128, elsewhere], 24, None));
        bytes.extend(block(b"##DG", &[168], 8, None));
        bytes.extend(block(b"##DT", &[], 100, length));
        MemorySource::new(bytes)
    }

    #[test]
    fn whole_files_need_nothing() {
        let repaired = repair(&file(0, None), false).expect("walked");
        assert!(repaired.patches.is_empty() && repaired.warnings(false).is_empty());
    }

    #[test]
    fn links_to_nowhere_are_cut_and_data_ends_with_the_file() {
        let repaired = repair(&file(9999, Some(5000)), false).expect("walked");
        assert_eq!(repaired.patches, BTreeMap::from([(64 + 32, 0), (168 + 8, 124)]));
        let codes: Vec<&str> = repaired.warnings(false).iter().map(|w| w.code).collect();
        assert_eq!(codes, ["truncated", "damaged"]);
    }

    #[test]
    fn data_that_was_being_written_runs_on_to_the_end() {
        for length in [0, LEAST] {
            let repaired = repair(&file(0, Some(length)), true).expect("walked");
            assert_eq!(repaired.patches, BTreeMap::from([(168 + 8, 124)]));
            assert_eq!(repaired.warnings(true)[0].code, "unfinalised");
        }
        assert!(repair(&MemorySource::new(vec![0; 70]), false).is_err());
    }
}
