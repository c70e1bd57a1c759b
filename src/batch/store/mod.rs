//! The output folder: whole files whatever happens, one state at a time for its readers.
//!
//! The protocol is a state machine; the page `book/src/store.md` has all of it. A state is known from the marks below
//! `.roadbench/`, the first one that is there:
//!
//! ```text
//! state      mark                        next writer                          readers with `reading` see
//! committed  next.json                   applies it                           they apply it first
//! switched   switched                    makes what is over all sessions      they make it first
//! merging    next/                       removes it                           the old tables
//! staged     staged/run/*.session        takes in what waits                  the old tables
//! behind     behind alone                makes the report                     the new tables
//! settled    output.json alone           -                                    the new tables
//! absent     none                        claims the folder                    nothing
//!
//! absent -> settled -> staged -> merging -> committed -> switched -> behind -> settled
//! ```
//!
//! | file | part of the protocol |
//! |---|---|
//! | [`mark`] | absent or not: `output.json` |
//! | [`lock`] | one writer at a time |
//! | [`folder`] | the writer's side: opens, stages, merges, settles |
//! | [`mod@staged`] | a session that waits |
//! | [`mod@merge`] | from staged to committed |
//! | [`mod@switch`] | from committed to switched |
//! | [`finish_derived`] | from switched to behind: writes the tables over all sessions |
//! | [`reading`] | the reader's side |
//! | [`manifest`] | checksums of what is in place |
//! | [`intact`] | numbers of a table that is not as it was written go to nobody |
//! | [`contents`], [`marker`], [`parts`], [`kind`] | which sessions are there, and in which files |
//! | [`superseded`] | which sessions go with what becomes of a log |
//! | [`forget`], [`mod@verify`], [`mod@migrate`], [`empty`], [`local_copy`], [`printed_changes`] | commands and helpers on top |

pub(crate) mod contents;
pub(crate) mod empty;
pub(crate) mod finish_derived;
pub(crate) mod folder;
pub(crate) mod forget;
pub(crate) mod intact;
pub(crate) mod kind;
pub(crate) mod local_copy;
pub(crate) mod lock;
pub(crate) mod manifest;
pub(crate) mod mark;
pub(crate) mod marker;
pub(crate) mod merge;
pub(crate) mod migrate;
pub(crate) mod parts;
pub(crate) mod printed_changes;
pub(crate) mod reading;
pub(crate) mod staged;
pub(crate) mod superseded;
pub(crate) mod switch;
pub(crate) mod verify;

#[cfg(test)]
mod tests {
    use super::kind::{DIAGNOSE, RUN};
    use super::*;

    /// The page of the protocol names every mark and file of this folder that takes part in it.
    #[test]
    fn the_page_names_every_mark() {
        let page = include_str!("../../../book/src/store.md");
        let of_kinds = [&RUN, &DIAGNOSE].into_iter().flat_map(|k| [k.staged, k.behind, k.switched]);
        let marks =
            [mark::PATH, manifest::PATH, printed_changes::PATH, switch::COMMIT, switch::LOCK];
        for mark in of_kinds.chain(marks).chain([crate::store::tables::registry::LOCK]) {
            assert!(page.contains(mark), "store.md lacks {mark}");
        }
        for file in
            ["mark", "lock", "staged", "merge", "switch", "finish_derived", "reading", "manifest"]
        {
            assert!(page.contains(&format!("`{file}.rs`")), "store.md lacks {file}.rs");
        }
    }
}
