//! The rides of a motorcycle lead to one another.

use serde::Serialize;

use crate::store::tables::rows::SessionRow;

/// The page of another ride of the same motorcycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Neighbour {
    pub page: String,
    pub id: String,
}

/// The ride before a session and the one after it.
pub(crate) type Neighbours = [Option<Neighbour>; 2];

/// Of each session, in their order; `pages` are theirs, an empty name where there is none.
pub(crate) fn neighbours(sessions: &[SessionRow], pages: &[String]) -> Vec<Neighbours> {
    let mut order: Vec<usize> = (0..sessions.len()).collect();
    let key = |i: usize| (&sessions[i].ident.bike_id, &sessions[i].ident.start_time, i);
    order.sort_by(|a, b| key(*a).cmp(&key(*b)));
    let mut found = vec![[None, None]; sessions.len()];
    for pair in order.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        // of rides without a time nobody knows which came first
        let is_dated = [a, b].iter().all(|i| sessions[*i].ident.start_time.is_some());
        if is_dated && sessions[a].ident.bike_id == sessions[b].ident.bike_id {
            let to = |i: usize| {
                let id = sessions[i].ident.session_id.clone();
                (!pages[i].is_empty()).then(|| Neighbour { page: pages[i].clone(), id })
            };
            (found[a][1], found[b][0]) = (to(b), to(a));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::ident::Ident;

    #[test]
    fn rides_follow_in_time_and_stay_with_their_motorcycle() {
        let session = |bike: &str, id: &str, day: u32| SessionRow {
            ident: Ident {
                session_id: id.into(),
                bike_id: bike.into(),
                start_time: Some(format!("2026-05-{day:02}T00:00:00Z")),
            },
            ..SessionRow::default()
        };
        let sessions = [
            session("a", "x", 3),
            session("a", "y", 1),
            session("a", "z", 2),
            session("b", "w", 2),
        ];
        let pages = ["x.html", "y.html", "", "w.html"].map(str::to_owned);
        let found = neighbours(&sessions, &pages);
        let pages: Vec<[Option<&str>; 2]> = found
            .iter()
            .map(|n| n.each_ref().map(|n| n.as_ref().map(|n| n.page.as_str())))
            .collect();
        // y, z (without a page), x
        assert_eq!(
            pages,
            [[None, None], [None, None], [Some("y.html"), Some("x.html")], [None, None]]
        );
    }
}
