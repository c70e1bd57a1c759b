//! The nonlinear motorcycle: rigid bodies, suspension, tyres, road and air.
//!
//! ```text
//! motorcycle file -> model (bodies) -> rates of the state -> ride (time steps)
//!                                   -> trim (steady turns) -> modes (eigenvalues)
//! ```

pub mod bodies;
pub mod contact;
pub mod description;
pub mod link;
pub mod model;
pub mod modes;
pub mod road;
pub mod rolling;
pub mod run;
pub mod state;
pub mod trim;

pub use description::Motorcycle;
pub use model::{Model, Scratch};
pub use road::Road;
pub use state::{Action, State, Wheel, joint};
