//! The output folder: whole files whatever happens, one state at a time for its readers.

pub mod contents;
pub mod empty;
pub mod folder;
pub mod forget;
pub mod kind;
pub mod local_copy;
pub mod lock;
pub mod manifest;
pub mod mark;
pub mod marker;
pub mod merge;
pub mod migrate;
pub mod parts;
pub mod reading;
pub mod settle;
pub mod staged;
pub mod switch;
pub mod verify;
