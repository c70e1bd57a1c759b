//! What is usual of motorcycles, by class; tyre sizes as printed; and the bike file that is made of both and of
//! what its owner knows.
//!
//! ```text
//! class or model  -+
//! tyre sizes      -+-> numbers, each with a standard deviation and where it is from -> bike file
//! what was measured-+
//! ```
//!
//! The classes are data: `pipelines/bikes/catalogue.toml`.

pub mod classes;
pub mod file;
pub mod home;
pub mod numbers;
pub mod owner;
pub mod tyre_size;

pub use classes::Catalogue;
pub use owner::Owner;
pub use tyre_size::TyreSize;
