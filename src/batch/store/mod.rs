//! The output folder: whole files whatever happens, one state at a time for its readers.

pub(crate) mod contents;
pub(crate) mod empty;
pub(crate) mod folder;
pub(crate) mod forget;
pub(crate) mod kind;
pub(crate) mod local_copy;
pub(crate) mod lock;
pub(crate) mod manifest;
pub(crate) mod mark;
pub(crate) mod marker;
pub(crate) mod merge;
pub(crate) mod migrate;
pub(crate) mod parts;
pub(crate) mod reading;
pub(crate) mod settle;
pub(crate) mod staged;
pub(crate) mod switch;
pub(crate) mod verify;
