//! A motorcycle whose tyres are known.
