//! What is known of a motorcycle before its ride: classes, tyre sizes, the wizard's file.

pub(crate) mod catalogue;
