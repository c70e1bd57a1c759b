//! Whose a row is.

use serde::{Deserialize, Serialize};

use crate::contract::session::Meta;

/// Who and when, repeated in every per-session row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Ident {
    /// Id of the session.
    pub session_id: String,
    /// Id of the motorcycle.
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

/// Where, by whom and on what tyres a session was ridden; what its log does not say is `None`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Circumstances {
    pub site: Option<String>,
    pub rider_id: Option<String>,
    /// On the front wheel.
    pub tyre_front: Option<String>,
    /// On the rear wheel.
    pub tyre_rear: Option<String>,
}

impl From<&Meta> for Circumstances {
    fn from(meta: &Meta) -> Self {
        Circumstances {
            site: meta.site.clone(),
            rider_id: meta.rider_id.clone(),
            tyre_front: meta.tyre_front.clone(),
            tyre_rear: meta.tyre_rear.clone(),
        }
    }
}
