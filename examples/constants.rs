//! How much each constant of the naming on the road decides: every one is put to two thirds and to four
//! thirds of its value, and the verdicts that change on simulated rides are counted.
//!
//! ```text
//! cargo run --release --example constants -- --rides 20 > book/src/reference/constants.md
//! ```

use std::collections::BTreeMap;

use clap::Parser;
use rayon::prelude::*;
use roadbench::contract::verdict::Verdict;
use roadbench::diagnose::Settings;
use roadbench::diagnose::cause::Naming;
use roadbench::diagnose::road::{self, Prepared};
use roadbench::diagnose::tuning::{self, ROAD, RoadTuning};
use roadbench::pipeline::Pipeline;
use roadbench::simulate::hidden::{Case, Kind};

#[derive(Parser)]
struct Arguments {
    /// Simulated rides; none leaves the counts out.
    #[arg(long, default_value_t = 20)]
    rides: usize,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Null simulations of each ride.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
}

/// Of five: two single effects, two pairs, one that diagnosis is told nothing of.
const KINDS: [Kind; 5] = [Kind::Single, Kind::Double, Kind::Single, Kind::Foreign, Kind::Double];

/// Verdict of every candidate and of the ride.
type Verdicts = BTreeMap<&'static str, Verdict>;

fn verdicts<M>(naming: &Naming<M>) -> Verdicts {
    let ride = if naming.unexplained { Verdict::Unexplained } else { Verdict::NotNeeded };
    let causes = naming.causes.iter().map(|c| (c.candidate.name, c.verdict));
    causes.chain([("(ride)", ride)]).collect()
}

/// Verdicts that change with each constant at two thirds and at four thirds of its value.
fn changes(seed: u64, number: usize, nulls: usize) -> Option<Vec<[usize; 2]>> {
    let case = Case::draw(seed, number, KINDS[number % KINDS.len()], [0.4, 3.0]);
    let (session, machine) = case.ride().ok()?;
    let settings = Settings { nulls, ..Settings::default() };
    let fitted = road::fitted(&session, &machine.bike, &Pipeline::onroad()).ok()?;
    let prepared = Prepared::new(&fitted, &settings);
    let usual = verdicts(&prepared.naming(&RoadTuning::default()));
    let count = |index: usize, share: f64| {
        let mut tuning = RoadTuning::default();
        let constant = ROAD[index];
        let value = share * (constant.get)(&tuning);
        (constant.set)(&mut tuning, value);
        let now = verdicts(&prepared.naming(&tuning));
        now.iter().filter(|(name, verdict)| usual.get(*name) != Some(verdict)).count()
    };
    Some((0..ROAD.len()).map(|k| [2.0 / 3.0, 4.0 / 3.0].map(|share| count(k, share))).collect())
}

fn main() {
    let Arguments { rides, seed, nulls } = Arguments::parse();
    let found: Vec<Vec<[usize; 2]>> =
        (0..rides).into_par_iter().filter_map(|number| changes(seed, number, nulls)).collect();
    let sums = (0..ROAD.len())
        .map(|k| found.iter().fold([0, 0], |[a, b], ride| [a + ride[k][0], b + ride[k][1]]));
    let sums: Vec<[usize; 2]> = sums.collect();
    print!("{}", tuning::reference((!found.is_empty()).then_some((found.len(), &sums))));
}
