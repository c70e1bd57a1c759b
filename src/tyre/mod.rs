//! Tyre models: the paper's, and those of simulators behind one trait
//! ([`tyre_model::TyreModel`]); and the kinematics that steering and roll give a wheel.

pub mod custom;
pub mod dive;
pub mod formulation;
pub mod keys;
pub mod kinematics;
pub mod linear;
pub mod magic_formula;
pub mod mf_62;
mod mf_62_scale;
pub mod mf_mc;
pub mod offroad;
pub mod pair;
pub mod published;
pub mod tir;
pub mod tydex;
pub mod tyre;
pub mod tyre_model;

pub use magic_formula::MagicFormula;
pub use tyre::{Stiffness, Tyre};
