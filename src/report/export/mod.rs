//! A fitted tyre for other programs.
//!
//! | file | format |
//! |---|---|
//! | [`fitted`] | `toml`: every coefficient with interval, status and reason, ranges, provenance |
//! | [`motorcycle`] | `tir`: Magic Formula property file, the motorcycle set 5.2 |
//! | [`magic_formula_62`] | `tir`: Magic Formula property file, version 6.2 |
//! | [`reduced`] | `tir`: the few coefficients of MF 6.2 that follow at small angles |
//! | [`tydex`] | `tydex`: sweeps of the tyre as a bench would measure them |
//! | [`csv`] | `csv`: look-up tables |
//! | [`header`] | `c`: a header that evaluates the tyre |
//! | [`fmu`] | `fmu`: the same as a simulation unit of FMI 3.0 |
//!
//! A property file is shaped to the tyre by [`shape`]; how far it may be used is said in [`validity`].
//! [`effects`] says which effects that a diagnosis named become part of the tyre, [`over_load`] how what depends on
//! load is said in a property file. [`written`] is the one call for all formats. All are written from the output tables
//! alone (and, for what no ride gives, the bike file).

pub mod check;
pub mod csv;
pub mod effects;
pub mod ends;
pub mod file;
pub mod fit;
pub mod fit_62;
pub mod fitted;
pub mod fmu;
pub mod grid;
pub mod header;
pub mod magic_formula_62;
pub mod motorcycle;
pub mod numbers;
pub mod over_load;
pub mod ranges;
pub mod reduced;
pub mod shape;
pub mod tydex;
pub mod tyre;
pub mod validity;
pub mod written;
