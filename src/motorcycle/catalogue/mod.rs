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

pub(crate) mod classes;
pub(crate) mod file;
pub(crate) mod home;
pub(crate) mod numbers;
pub(crate) mod owner;
pub(crate) mod plausible;
pub(crate) mod tyre_size;

pub(crate) use classes::Catalogue;
pub(crate) use owner::Owner;
pub(crate) use tyre_size::TyreSize;
