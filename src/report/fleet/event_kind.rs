//! Kinds of events between sessions.

/// A kind of event as people read it, by its name in the table `fleet_events`.
pub fn label(name: &str) -> &str {
    match name {
        "tyre_swap" => "tyre swap",
        "bike_file" => "wrong bike file",
        "outlier" => "outlying session",
        other => other,
    }
}
