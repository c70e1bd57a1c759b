//! The off-road rows of the `signals` table: ISO axes again.
