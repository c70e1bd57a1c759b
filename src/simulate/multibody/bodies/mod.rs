//! Dynamics of a tree of rigid bodies on a floating base.
//!
//! Forward dynamics by the articulated-body algorithm (Featherstone 2008, *Rigid Body Dynamics
//! Algorithms*, chapters 7 and 9), with joints that may be free, or follow a given acceleration
//! (locked joints, a rider's lean). No allocation after the tree is built.

pub(crate) mod spatial;
pub(crate) mod tree;

pub(crate) use spatial::{Motion, Rigid};
pub(crate) use tree::{Body, Joint, Tree, Work};
