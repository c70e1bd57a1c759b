//! Robust fits and their uncertainty.
