//! Motocross archives: what is hidden is in the rider or in the fork; the rides are two minutes long.

use std::path::Path;

use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::diagnose::offroad;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::hidden_offroad::{Hidden, OffroadCase};
use roadbench::internals::store::tables::rows::CauseRow;

/// Length of a ride, s.
const DURATION: f64 = 120.0;

/// Whether a case is of a kind.
type Is = fn(Hidden) -> bool;

struct Outcome {
    case: OffroadCase,
    causes: Vec<CauseRow>,
}

impl Outcome {
    fn named(&self) -> impl Iterator<Item = &CauseRow> {
        self.causes.iter().filter(|c| c.verdict == "named")
    }

    fn in_class(&self, effect: &str) -> bool {
        self.causes.iter().any(|c| {
            let rivals = c.equivalent_to.as_deref().unwrap_or_default();
            matches!(c.verdict.as_str(), "named" | "ambiguous")
                && (c.effect == effect || rivals.split(", ").any(|r| r == effect))
        })
    }

    /// What is named and is not there. Legs push fore and aft too.
    fn wrong(&self) -> usize {
        let legs = self.case.hidden == Hidden::Legs;
        let truth = self.case.truth().map(|(name, _)| name);
        self.named()
            .filter(|c| Some(c.effect.as_str()) != truth)
            .filter(|c| !(legs && c.effect == "rider_horizontal_motion"))
            .count()
    }
}

/// Hides, asks and prints.
pub fn run(archives: usize, seed: u64, nulls: usize, verbose: bool, work: &Path) {
    let ask = |number: usize| -> Result<Outcome, String> {
        let case = OffroadCase::draw(seed, number);
        let (log, bike) = case.write(&work.join(format!("offroad-{number}")), DURATION)?;
        let bike = Bike::read(&bike).map_err(|e| e.to_string())?;
        let found = offroad::log(&log, &[], &bike, &Pipeline::builtin("offroad"), nulls)
            .map_err(|e| e.message)?;
        Ok(Outcome { case, causes: found.causes })
    };
    let all: Vec<Outcome> = (0..archives)
        .into_par_iter()
        .filter_map(|number| match ask(number) {
            Ok(outcome) => {
                if verbose {
                    let told: Vec<String> = outcome
                        .causes
                        .iter()
                        .filter(|c| matches!(c.verdict.as_str(), "named" | "ambiguous"))
                        .map(|c| format!("{} {} {:.3?}", c.verdict, c.effect, c.value))
                        .collect();
                    println!("off-road {number} {:?} -> {}", outcome.case.hidden, told.join("; "));
                }
                Some(outcome)
            }
            Err(why) => {
                println!("off-road {number}: {why}");
                None
            }
        })
        .collect();
    if all.is_empty() {
        return;
    }
    println!("\noff-road, {} rides of {DURATION} s", all.len());
    let kinds: [(&str, Is); 5] = [
        ("nothing", |h| h == Hidden::Nothing),
        ("nothing, sensors half as noisy again", |h| h == Hidden::Noise),
        ("vertical motion of the rider", |h| matches!(h, Hidden::VerticalMotion(_))),
        ("friction in the fork", |h| matches!(h, Hidden::ForkFriction(_))),
        ("legs that push", |h| h == Hidden::Legs),
    ];
    println!(
        "{:38} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "hidden", "archives", "named", "in class", "wrong", "inside", "error"
    );
    for (what, is) in kinds {
        let these: Vec<&Outcome> = all.iter().filter(|o| is(o.case.hidden)).collect();
        let named = |o: &&&Outcome| match o.case.truth() {
            Some((name, _)) => o.named().any(|c| c.effect == name),
            None => o.named().next().is_some(),
        };
        let class = |o: &&&Outcome| o.case.truth().is_some_and(|(name, _)| o.in_class(name));
        // size and interval of correctly identified causes
        let sizes: Vec<(f64, bool)> = these
            .iter()
            .filter_map(|o| {
                let (name, size) = o.case.truth()?;
                let c = o.named().find(|c| c.effect == name)?;
                let size = size?;
                let inside = (c.ci95_low?..=c.ci95_high?).contains(&size);
                Some(((c.value? / size - 1.0).abs(), inside))
            })
            .collect();
        let mut errors: Vec<f64> = sizes.iter().map(|s| s.0).collect();
        errors.sort_by(f64::total_cmp);
        println!(
            "{what:38} {:8} {:8} {:8} {:8} {:>8} {:>8}",
            these.len(),
            these.iter().filter(named).count(),
            these.iter().filter(class).count(),
            these.iter().map(|o| o.wrong()).sum::<usize>(),
            format!("{}/{}", sizes.iter().filter(|s| s.1).count(), sizes.len()),
            errors.get(errors.len() / 2).map_or("-".to_owned(), |e| format!("{:.0} %", 100.0 * e)),
        );
    }
}
