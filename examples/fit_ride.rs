//! Fits the tyres of one ride and prints their coefficients with 95 % intervals.
//!
//! ```text
//! cargo run --example fit_ride -- ride.parquet bike.toml
//! ```

use std::error::Error;
use std::path::Path;

use roadbench::{Bike, Pipeline, Status, fit_log};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [log, bike] = arguments.as_slice() else {
        return Err("usage: fit_ride LOG BIKE_FILE".into());
    };
    let bike = Bike::read(Path::new(bike))?;
    let pipeline = Pipeline::read(Path::new("onroad"))?;
    let outcome = fit_log(Path::new(log), &bike, &pipeline)?;
    for c in outcome.coefficients.iter().filter(|c| c.status == Status::Ok) {
        if let (Some(value), Some(low), Some(high)) = (c.value, c.ci95_low, c.ci95_high) {
            let name = format!("{} {}", c.tyre, c.coefficient);
            println!("{name:<40} {value:>10.4}  {low:.4} to {high:.4} {}", c.unit);
        }
    }
    Ok(())
}
