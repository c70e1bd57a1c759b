//! Which errors two sides of a comparison share: the sources of the evidence; equal names are one error.
//!
//! ```text
//! a number of the bike file, a scale of its sensors    one error of the motorcycle, if both sides took the same number
//! a number of a tyre, a rule for tyres                 one error of the tyre: another tyre has its own
//! model                                                half of its variance is the motorcycle's, half the tyre's
//! ```

use super::session::Session;
use crate::contract::bike::Axle;
use crate::contract::error_source::MODEL;
use crate::fleet::combine::Key;
use crate::fleet::evidence::Piece;

/// Share of the variance of the model's error that belongs to the tyre; the rest is the motorcycle's.
// METHOD: assumed; no fleet with swapped tyres has shown it
const TYRE_SHARE: f64 = 0.5;
/// Errors that belong to the two tyres together.
const OF_TYRES: [&str; 3] = ["crown_split", "trail_rule", "slip_difference"];
/// Stands between the name of an error and what it belongs to.
const OF: char = '|';

/// The name of an error without what it belongs to: `model`, or a key of the bike file.
pub(super) fn plain(name: &str) -> &str {
    name.split(OF).next().unwrap_or(name)
}

/// Which tyre is on an axle: its model, or, where nobody says, another one on each side.
fn tyre(session: &Session, axle: Axle) -> String {
    match &session.tyres[axle as usize] {
        Some(model) => model.clone(),
        None => format!("of {}", ["A", "B", "neither"][session.side.min(2)]),
    }
}

/// A group of sessions of one side with one tyre, of which a coefficient has one value.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Group {
    /// 0 is A, 1 is B, 2 neither.
    pub side: usize,
    /// The tyre; empty of what is the motorcycle's own.
    pub tyre: String,
}

impl Group {
    fn of(session: &Session, part: &str) -> Group {
        let axle = Axle::BOTH.into_iter().find(|axle| axle.name() == part);
        let tyre = axle.map_or_else(String::new, |axle| tyre(session, axle));
        Group { side: session.side, tyre }
    }
}

/// The pieces of the sessions of one motorcycle under their new names.
#[derive(Debug, Default)]
pub(super) struct Renamed {
    /// By session: key and piece, those of one key one after the other.
    pub pieces: Vec<Vec<(Key, Piece)>>,
    /// The groups, which [`Key::specimen`] numbers.
    pub groups: Vec<Group>,
    /// The tyre's part of the model's error, by key, as the pieces have it.
    pub of_tyre: Vec<(Key, Piece)>,
}

impl Renamed {
    /// Of the sessions of one motorcycle.
    pub(super) fn of(sessions: &[&Session]) -> Renamed {
        let mut out = Renamed::default();
        let parts = sessions.iter().flat_map(|s| s.pieces.iter().map(|p| Group::of(s, &p.tyre)));
        out.groups = parts.collect();
        out.groups.sort();
        out.groups.dedup();
        for session in sessions {
            let mut of_session = Vec::with_capacity(session.pieces.len());
            for piece in &session.pieces {
                let group = Group::of(session, &piece.tyre);
                let key = Key {
                    tyre: piece.tyre.clone(),
                    specimen: out.groups.iter().position(|g| *g == group).unwrap_or_default(),
                    coefficient: piece.coefficient.clone(),
                };
                let mut piece = piece.clone();
                if piece.shared && piece.source == MODEL && !group.tyre.is_empty() {
                    let shift = piece.shift * TYRE_SHARE.sqrt();
                    out.of_tyre.push((key.clone(), Piece { shift, ..piece.clone() }));
                    piece.shift *= (1.0 - TYRE_SHARE).sqrt();
                }
                if piece.shared {
                    piece.source = name(session, &piece);
                }
                of_session.push((key, piece));
            }
            of_session.sort_by(|a, b| a.0.cmp(&b.0));
            out.pieces.push(of_session);
        }
        out
    }
}

/// Name of an error; errors of one name are shared.
fn name(session: &Session, piece: &Piece) -> String {
    let source = piece.source.as_str();
    let whose = match Axle::BOTH.into_iter().find(|a| source.starts_with(&format!("{}.", a.name())))
    {
        Some(axle) => tyre(session, axle),
        None if OF_TYRES.contains(&source) => Axle::BOTH.map(|a| tyre(session, a)).join(" "),
        None if source == MODEL => format!("{} {}", piece.tyre, piece.coefficient),
        None => String::new(),
    };
    // a number that the other side took otherwise is another error
    let taken = piece.taken.map(|t| format!("{:.9e}", t[0])).unwrap_or_default();
    format!("{source}{OF}{whose}{OF}{taken}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session(side: usize, front: Option<&str>, mass: f64) -> Session {
        let piece = |source: &str, taken| Piece {
            tyre: "front".into(),
            coefficient: "mf_d".into(),
            value: 1.0,
            source: source.into(),
            shared: true,
            shift: 0.1,
            taken,
            ..Piece::default()
        };
        Session {
            side,
            tyres: [front.map(str::to_owned), None],
            pieces: vec![
                piece("mass", Some([mass, 2.0])),
                piece("front.vertical_stiffness", Some([1.5e5, 8e3])),
                piece(MODEL, None),
            ],
            ..Session::default()
        }
    }

    fn names(session: &Session) -> Vec<String> {
        let found = Renamed::of(&[session]);
        found.pieces[0].iter().map(|(_, piece)| piece.source.clone()).collect()
    }

    #[test]
    fn what_the_motorcycle_has_in_common_has_one_name_and_what_the_tyre_has_another() {
        let a = names(&session(0, Some("soft"), 250.0));
        let same = names(&session(1, Some("soft"), 250.0));
        assert_eq!(a, same);
        let other_tyre = names(&session(1, Some("hard"), 250.0));
        assert_eq!(other_tyre[0], a[0], "the mass is the motorcycle's");
        assert_ne!(other_tyre[1], a[1], "the stiffness is the tyre's");
        assert_eq!(other_tyre[2], a[2], "the motorcycle's part of the model's error");
        assert_ne!(names(&session(1, Some("soft"), 260.0))[0], a[0], "another bike file");
        // where nobody says which tyre it was, the sides have two
        assert_ne!(names(&session(0, None, 250.0))[1], names(&session(1, None, 250.0))[1]);
        assert!(a.iter().all(|n| !plain(n).contains(OF)), "{a:?}");
        assert_eq!(plain(&a[0]), "mass");
    }

    #[test]
    fn both_parts_of_the_models_error_are_all_of_it() {
        let found = Renamed::of(&[&session(0, Some("soft"), 250.0)]);
        let own: f64 = found.pieces[0][2].1.shift.powi(2);
        let tyre: f64 = found.of_tyre[0].1.shift.powi(2);
        assert!((own + tyre - 0.01).abs() < 1e-12, "{found:?}");
        assert_eq!(found.groups, [Group { side: 0, tyre: "soft".into() }]);
    }
}
