//! The tyre model of the paper.
