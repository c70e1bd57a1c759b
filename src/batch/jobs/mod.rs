//! What is done with each log: a tyre's coefficients ([`run`]), or causes of misfit ([`diagnose`]); here,
//! over many machines ([`distributed`]), or without files ([`in_memory`]).

pub(crate) mod bikes;
pub(crate) mod diagnose;
pub(crate) mod distributed;
pub(crate) mod in_memory;
pub(crate) mod job_kind;
pub(crate) mod models;
pub(crate) mod pooled;
pub(crate) mod run;
pub(crate) mod session;
pub(crate) mod work;
