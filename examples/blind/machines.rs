//! Archives of a population of motorcycles: each a complete machine of its own, whose plant is not the
//! model that looks at it. There is more in them than what is hidden.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use roadbench::internals::diagnose::road::residuals::CHANNELS;
use roadbench::internals::simulate::effects::ALL;
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::population::{DrawnMachine, ride};

use super::summary::{share, summary};
use super::{Arguments, Outcome, ask, outcomes};

/// Standard error, in usual sizes, up to which a ride says something of an effect.
const CLEAR: f64 = 1.5;

/// Rms of a bias over the size's error from which rides tell what share of it is real; a smaller one counts.
const REAL: f64 = 2.0;
/// Fewest rides to learn from.
const MIN_MACHINES: usize = 10;

/// What is known of a machine in words, for a count of false names by it.
fn traits(machine: &DrawnMachine) -> [String; 4] {
    let twist = machine.build.keys.contains_key("frame_twist.stiffness");
    [
        format!("tyres {:?}", machine.make),
        format!("springs {:?}", machine.springs),
        format!("frame {}", if twist { "twists" } else { "stiff" }),
        format!("attitude {}", if machine.imu.is_some() { "filter" } else { "sensor" }),
    ]
}

/// Hides, asks and prints.
pub fn run(arguments: &Arguments, work: &Path) {
    if arguments.machines == 0 {
        return;
    }
    let sizes = [arguments.sizes[0], arguments.sizes[1]];
    let draw = |n, kind| ride::case(arguments.seed, n, kind, sizes);
    let failed: Mutex<Vec<String>> = Mutex::new(Vec::new());
    let seconds: Mutex<Vec<f64>> = Mutex::new(Vec::new());
    let all = outcomes(arguments, true, arguments.machines, &draw, |case: Case| {
        let folder = work.join(format!("machine-{}", case.number));
        let begin = std::time::Instant::now();
        let (files, ridden) = match ride::write(&case, &folder) {
            Ok(written) => written,
            Err(why) => {
                println!("{why}");
                return None;
            }
        };
        seconds.lock().expect("nobody panicked").push(begin.elapsed().as_secs_f64());
        let mut list = failed.lock().expect("nobody panicked");
        list.extend(ridden.failed.iter().map(|why| format!("machine {}: {why}", case.number)));
        drop(list);
        let outcome = ask(case, files, arguments);
        std::fs::remove_dir_all(&folder).expect("cleared");
        outcome
    });
    if arguments.learn {
        learn(&all);
        return;
    }
    println!("\npopulation of machines");
    if !all.is_empty() {
        summary(&all);
        false_names(&all);
    }
    let failed = failed.into_inner().expect("nobody panicked");
    let seconds = seconds.into_inner().expect("nobody panicked");
    let rides = seconds.len() + failed.len();
    println!(
        "\nridden now: {} in {:.1} s each; drawn again because they fell or could not stand: {}",
        seconds.len(),
        seconds.iter().sum::<f64>() / seconds.len().max(1) as f64,
        share(failed.len(), rides)
    );
    for why in failed {
        println!("  {why}");
    }
}

/// Prints what effects show on machines of which they are not true: `pipelines/other_machines.toml`.
fn learn(all: &[Outcome]) {
    println!(
        "# What effects show on machines of which they are not true: share of the null simulations' bias that\n\
         # rides have too, and standard deviation beyond that of the null simulations, in usual sizes. Learnt by\n\
         #   cargo run --release --example blind -- --archives 0 --machines N --only null --learn"
    );
    println!(
        "# Residual structure by channel that nearly all rides stay below, in what 19 of 20 null simulations do."
    );
    println!("[structure]");
    for (place, channel) in CHANNELS.iter().enumerate() {
        println!("{channel} = {:.1}", usual_structure(all, place));
    }
    println!(
        "# With each effect: how many rides say something of it, and the rms of the size over its error."
    );
    for (place, effect) in ALL.iter().enumerate() {
        let of = |o: &Outcome| o.found.get(place).copied();
        let clear = |[x, error, bias]: &[f64; 3]| {
            x.is_finite() && bias.is_finite() && (1e-6..CLEAR).contains(error)
        };
        let nulls = all.iter().filter(|o| o.case.hidden.is_empty());
        let found: Vec<[f64; 3]> = nulls.filter_map(of).filter(clear).collect();
        if found.len() < MIN_MACHINES {
            continue;
        }
        let [share, sd] = common(&found);
        let rms = found.iter().map(|[x, e, b]| ((x - b) / e).powi(2)).sum::<f64>();
        println!(
            "[{}] # {} rides, rms of size over error {:.2}\nbias_share = {share:.2}\nsd = {sd:.2}",
            effect.name,
            found.len(),
            (rms / found.len() as f64).sqrt()
        );
    }
}

/// Share of the rides that stay below a channel's usual structure: with eight channels, few rides are beyond any.
const USUAL: f64 = 0.97;

/// What the structure of nearly all rides with nothing hidden stays below in a channel, where nothing is named.
fn usual_structure(all: &[Outcome], channel: usize) -> f64 {
    let nulls = all.iter().filter(|o| o.case.hidden.is_empty() && o.told.is_empty());
    let mut largest: Vec<f64> = nulls.filter_map(|o| o.structure.get(channel)).copied().collect();
    largest.sort_by(f64::total_cmp);
    let rank = (USUAL * (largest.len() + 1) as f64) as usize;
    largest.get(rank.saturating_sub(1)).map_or(1.0, |x| x.max(1.0))
}

/// Share of the bias and standard deviation beyond the known errors with which sizes (value, error, bias) are
/// most likely; normal, about the share of the bias.
fn common(found: &[[f64; 3]]) -> [f64; 2] {
    let unlikely = |share: f64, sd: f64| -> f64 {
        let of = |[x, e, b]: &[f64; 3]| {
            let variance = e * e + sd * sd;
            (x - share * b).powi(2) / variance + variance.ln()
        };
        found.iter().map(of).sum()
    };
    let of_errors = found.iter().map(|[_, e, b]| (b / e).powi(2)).sum::<f64>();
    let first = if of_errors < REAL * REAL * found.len() as f64 { 20 } else { 2 };
    let shares = (first..=20).map(|k| 0.05 * f64::from(k));
    let each = |share: f64| (0..=200).map(move |k| [share, 0.02 * f64::from(k)]);
    let least = |a: &[f64; 2], b: &[f64; 2]| unlikely(a[0], a[1]).total_cmp(&unlikely(b[0], b[1]));
    shares.flat_map(each).min_by(least).unwrap_or([1.0, 0.0])
}

/// Causes that are identified where nothing is hidden, and on which machines.
fn false_names(all: &[Outcome]) {
    let nulls = || all.iter().filter(|o| matches!(o.case.kind, Kind::Null | Kind::Noisy));
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    let mut machines: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for o in nulls() {
        for t in &o.told {
            *names.entry(&t.name).or_default() += 1;
        }
        // the first attempt's: a machine that was drawn again counts as the one that fell
        let drawn = DrawnMachine::draw(o.case.seed, o.case.number, 0);
        for what in drawn.iter().flat_map(traits) {
            let [falsely, of] = machines.entry(what).or_default();
            *falsely += usize::from(!o.told.is_empty());
            *of += 1;
        }
    }
    let names: Vec<String> = names.iter().map(|(n, k)| format!("{n} {k}")).collect();
    println!("\nnames on nulls: {}", names.join(", "));
    for (what, [falsely, of]) in machines {
        println!("  {what:18} named {}", share(falsely, of));
    }
}
