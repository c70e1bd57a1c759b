//! Whose a row is.

use serde::{Deserialize, Serialize};

use crate::contract::session::Meta;

/// Who and when, repeated in every per-session row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Ident {
    /// The session.
    pub session_id: String,
    /// The bike.
    pub bike_id: String,
    /// RFC 3339; in tables an instant, and in UTC when it is read back.
    pub start_time: Option<String>,
}

impl Ident {
    /// Bike and session: what orders sessions in every table that is read back.
    pub fn key(&self) -> (&str, &str) {
        (&self.bike_id, &self.session_id)
    }
}

impl From<&Meta> for Ident {
    fn from(meta: &Meta) -> Self {
        Ident {
            session_id: meta.session_id.clone(),
            bike_id: meta.bike_id.clone(),
            start_time: meta.start_time.clone(),
        }
    }
}
