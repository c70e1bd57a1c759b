//! Why a command did not do what it was asked; each kind has its exit code.

use crate::store::objects::plain::plain;
use crate::store::tables::output::Refusal;

/// A message for stderr, by kind.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Bad usage or configuration, nothing written: 2.
    Usage(String),
    /// Some inputs were rejected, and are listed, or the run was stopped before its end: 1.
    Rejected(String),
    /// The output could not be written, or what it holds is not as it was written: 3.
    Output(String),
}

impl Failure {
    /// Bad usage: what was given is wrong.
    pub(crate) fn usage(why: impl std::fmt::Display) -> Self {
        Failure::Usage(why.to_string())
    }

    /// Exit code and message.
    pub(crate) fn parts(self) -> (u8, String) {
        let (code, message) = match self {
            Failure::Rejected(message) => (1, message),
            Failure::Usage(message) => (2, message),
            Failure::Output(message) => (3, message),
        };
        (code, plain(&message).into_owned())
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Wrong(message) => Failure::Usage(message),
            Refusal::Cannot(message) => Failure::Output(message),
        }
    }
}
