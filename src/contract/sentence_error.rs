//! Errors of readers and checks whose callers tell nothing apart.

/// Declares such an error: a sentence that says what is wrong and where. Each reader has a type of its own, so that a
/// sentence cannot be taken for another reader's, or for a text.
macro_rules! sentence_error {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
        #[error("{0}")]
        pub struct $name(String);

        impl From<String> for $name {
            fn from(sentence: String) -> Self {
                $name(sentence)
            }
        }

        impl From<&str> for $name {
            fn from(sentence: &str) -> Self {
                $name(sentence.to_owned())
            }
        }

        impl From<$name> for String {
            fn from(e: $name) -> Self {
                e.0
            }
        }
    };
}

pub(crate) use sentence_error;
