//! Reads a log of any known format and prints its channels.
//!
//! ```text
//! cargo run --example read_log -- ride.csv
//! ```

use std::path::Path;

use roadbench::{IngestConfig, IngestError, clean, read};

fn main() -> Result<(), IngestError> {
    let log = std::env::args().nth(1).unwrap_or_else(|| "ride.csv".to_owned());
    let raw = read(Path::new(&log), &[])?;
    let (session, warnings) = clean(raw, &IngestConfig::default())?;
    println!("{}: {:.0} s at {} Hz", session.meta.session_id, session.duration(), session.rate);
    for channel in session.channels() {
        let samples = session.get(channel).unwrap_or_default();
        let known = samples.iter().filter(|x| x.is_finite()).count();
        println!("  {:<24} {known} of {} samples", channel.name(), session.len);
    }
    for warning in warnings {
        println!("  warning {}: {}", warning.code, warning.message);
    }
    Ok(())
}
