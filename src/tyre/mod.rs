//! Tyre models: the paper's, and those of simulators, as one trait
//! ([`tyre_model::TyreModel`]); and the kinematics that steering and roll give a wheel.

pub(crate) mod custom;
pub(crate) mod dive;
pub(crate) mod formulation;
pub(crate) mod keys;
pub(crate) mod kinematics;
pub(crate) mod linear;
pub(crate) mod magic_formula;
pub(crate) mod mf_62;
mod mf_62_scale;
pub(crate) mod mf_mc;
pub(crate) mod pair;
pub(crate) mod paper;
pub(crate) mod published;
pub(crate) mod tir;
pub(crate) mod tydex;
pub(crate) mod tyre_model;

pub(crate) use magic_formula::MagicFormula;
pub(crate) use paper::{Stiffness, Tyre};
