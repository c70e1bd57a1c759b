//! What is done with each log: a tyre's coefficients ([`run`]), or causes of misfit ([`diagnose`]); here,
//! over many machines ([`distributed`]), or without files ([`in_memory`]).

pub mod bikes;
pub mod diagnose;
pub mod distributed;
pub mod in_memory;
pub mod models;
pub mod pooled;
pub mod run;
pub mod session;
pub mod what;
pub mod work;
