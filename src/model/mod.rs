//! The tyre model of the paper, and the kinematics that steering and roll give a wheel.

pub mod kinematics;
pub mod magic_formula;
pub mod tyre;

pub use magic_formula::MagicFormula;
pub use tyre::{Stiffness, Tyre};
