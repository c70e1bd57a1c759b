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
//! [`origins`] says where each number is from. [`curve_bands`] are the intervals of the look-up tables. [`parameters`] are the rows of the table `tyre_parameters`. A property file is shaped to the tyre by [`shape`]; how far it may be used is said in [`validity`].
//! [`adjusted`] says what the stiffness of the tyre is adjusted to and what that costs. [`effects`] says which identified causes become part of the tyre, [`over_load`] how what depends on
//! load is said in a property file. [`written`] is the one call for all formats. All are written from the output tables
//! alone (and, for what no ride gives, the bike file).

pub(crate) mod adjusted;
pub(crate) mod check;
pub(crate) mod csv;
pub(crate) mod curve_bands;
pub(crate) mod effects;
pub(crate) mod ends;
pub(crate) mod error;
pub(crate) mod file;
pub(crate) mod fit;
pub(crate) mod fit_62;
pub(crate) mod fitted;
pub(crate) mod fmu;
pub(crate) mod force_bands;
pub(crate) mod grid;
pub(crate) mod header;
pub(crate) mod magic_formula_62;
pub(crate) mod motorcycle;
pub(crate) mod numbers;
pub(crate) mod origins;
pub(crate) mod over_load;
pub(crate) mod parameters;
pub(crate) mod ranges;
pub(crate) mod reduced;
pub(crate) mod row_tyre;
pub(crate) mod shape;
pub(crate) mod tydex;
pub(crate) mod tyre;
pub(crate) mod validity;
pub(crate) mod written;
