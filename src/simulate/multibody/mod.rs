//! The nonlinear motorcycle: rigid bodies, suspension, tyres, road and air.
//!
//! ```text
//! motorcycle file -> model (bodies) -> rates of the state -> ride (time steps)
//!                                   -> trim (steady turns) -> modes (eigenvalues)
//! ```

pub(crate) mod bodies;
pub(crate) mod contact;
pub(crate) mod description;
pub(crate) mod link;
pub(crate) mod model;
pub(crate) mod modes;
pub(crate) mod road;
pub(crate) mod rolling;
pub(crate) mod run;
pub(crate) mod state;
pub(crate) mod trim;

pub(crate) use description::Motorcycle;
pub(crate) use model::{Model, Scratch};
pub(crate) use road::Road;
pub(crate) use state::{Action, State, Wheel, joint};
