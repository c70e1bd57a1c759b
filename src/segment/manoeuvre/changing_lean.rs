//! Changing lean: slaloms, lane changes, and corners with their roll-in and roll-out.
//!
//! No detector claims it, as it shares its time with the corners in it: the fit that uses it finds it
//! (`fit::transients::stretches`), and its rows come after those that cover the ride. Slaloms, lane changes and roll-ins are
//! one kind: the lean alone does not tell a chicane from a lane change, and the fit takes all alike.

use super::declaration::{Course, Declaration, Peak, Terrain};

pub(super) static CHANGING_LEAN: Declaration = Declaration {
    name: "changing_lean",
    words: "changing lean",
    description: "A slalom, a lane change, or a corner with its roll-in and roll-out, of which cornering and camber stiffness were fitted; overlaps the others.",
    letter: "",
    letter_by_side: None,
    colour: "#b3327a",
    colour_dark: "#e07ab5",
    terrain: Terrain::Road,
    course: Course::Any,
    brakes: [false, false],
    peak: Peak::Roll,
    force_row: None,
};
