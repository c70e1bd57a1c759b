//! Archives of a population of motorcycles: each a complete machine of its own, whose plant is not the
//! model that looks at it. There is more in them than what is hidden.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use roadbench::simulate::hidden::{Case, Kind};
use roadbench::simulate::population::{Machine, ride};

use super::summary::{share, summary};
use super::{Arguments, Outcome, ask, outcomes};

/// What is known of a machine in words, for a count of false names by it.
fn traits(machine: &Machine) -> [String; 4] {
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

/// What was named where nothing is hidden, and on which machines.
fn false_names(all: &[Outcome]) {
    let nulls = || all.iter().filter(|o| matches!(o.case.kind, Kind::Null | Kind::Noisy));
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    let mut machines: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for o in nulls() {
        for t in &o.told {
            *names.entry(&t.name).or_default() += 1;
        }
        // the first attempt's: a machine that was drawn again counts as the one that fell
        let drawn = Machine::draw(o.case.seed, o.case.number, 0);
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
