//! Rides on the nonlinear motorcycle.
