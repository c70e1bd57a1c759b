//! How much each constant of the identification on the road decides: every one is put to two thirds and to four
//! thirds of its value, and the verdicts that change on simulated rides are counted.
//!
//! A ride is simulated and fitted once. Its namings keep what they compute (`Prepared::keeping`), so one by
//! another constant costs only the models and fault-free simulations that no identification before it has met.
//!
//! ```text
//! cargo run --release --example constants -- --rides 20 > book/src/reference/constants.md
//! ```

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Parser;
use rayon::ThreadPoolBuilder;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::cause::Identification;
use roadbench::internals::diagnose::road::{self, Prepared};
use roadbench::internals::diagnose::tuning::{self, ROAD, RoadTuning};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::hidden::{Case, Kind};

#[derive(Parser)]
struct Arguments {
    /// Simulated rides; none leaves the counts out.
    #[arg(long, default_value_t = 20)]
    rides: usize,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fault-free simulations of each ride.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
}

/// Of five: two single effects, two pairs, one that diagnosis does not know.
const KINDS: [Kind; 5] = [Kind::Single, Kind::Double, Kind::Single, Kind::Foreign, Kind::Double];

/// Verdict of every candidate and of the ride.
type Verdicts = BTreeMap<&'static str, Verdict>;

fn verdicts<M>(identification: &Identification<M>) -> Verdicts {
    let ride = if identification.unexplained { Verdict::Unexplained } else { Verdict::NotNeeded };
    let causes = identification.causes.iter().map(|c| (c.candidate.name, c.verdict));
    causes.chain([("(ride)", ride)]).collect()
}

/// Verdicts that change with each constant at two thirds and at four thirds of its value.
fn changes(seed: u64, number: usize, nulls: usize) -> Option<Vec<[usize; 2]>> {
    let begin = Instant::now();
    let case = Case::draw(seed, number, KINDS[number % KINDS.len()], [0.4, 3.0]);
    let (session, machine) = case.ride().ok()?;
    let settings = Settings { nulls, ..Settings::default() };
    let fitted = road::fitted(&session, &machine.bike, &Pipeline::onroad()).ok()?;
    let prepared = Prepared::new(&fitted, &settings).keeping();
    let usual = verdicts(&prepared.identification(&RoadTuning::default()));
    let count = |index: usize, share: f64| {
        let mut tuning = RoadTuning::default();
        let constant = ROAD[index];
        let value = share * (constant.get)(&tuning);
        (constant.set)(&mut tuning, value);
        let now = verdicts(&prepared.identification(&tuning));
        now.iter().filter(|(name, verdict)| usual.get(*name) != Some(verdict)).count()
    };
    let counts = |k| [2.0 / 3.0, 4.0 / 3.0].map(|share| count(k, share));
    let counts = (0..ROAD.len()).map(counts).collect();
    eprintln!("ride {number}: {:.0} s", begin.elapsed().as_secs_f64());
    Some(counts)
}

/// What is made of every number below `count`, each on one core: what a ride keeps is large, so no more are
/// under way than there are cores.
fn on_every_core<T: Send>(count: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let numbers = numbers.take_while(|number| *number < count);
        numbers.map(|number| (number, pool.install(|| make(number)))).collect::<Vec<_>>()
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut made: Vec<(usize, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("no panic")).collect()
    });
    made.sort_by_key(|(number, _)| *number);
    made.into_iter().map(|(_, made)| made).collect()
}

fn main() {
    let Arguments { rides, seed, nulls } = Arguments::parse();
    let found = on_every_core(rides, |number| changes(seed, number, nulls));
    let found: Vec<Vec<[usize; 2]>> = found.into_iter().flatten().collect();
    let sums = (0..ROAD.len())
        .map(|k| found.iter().fold([0, 0], |[a, b], ride| [a + ride[k][0], b + ride[k][1]]));
    let sums: Vec<[usize; 2]> = sums.collect();
    print!("{}", tuning::reference((!found.is_empty()).then_some((found.len(), &sums))));
}
