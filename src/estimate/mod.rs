//! Tyre slips, loads and forces, sample by sample, from what was measured.

pub mod needs;
