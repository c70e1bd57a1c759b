//! Hides physical effects in simulated archives and asks `diagnose` for them.
//!
//! ```text
//! cargo run --release --example blind -- --archives 500
//! ```
//!
//! Archives are written to files, answers are kept here; diagnosis gets the files. Prints the causes
//! identified for the hidden effects, by size in detection limits, and the false alarms.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::cause::{Cause, Objection};
use roadbench::internals::diagnose::road;
use roadbench::internals::diagnose::road::other_machines::shown;
use roadbench::internals::diagnose::road::residuals::CHANNELS;
use roadbench::internals::diagnose::road::structure::terms;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::effects::{ALL, Effect};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::store::tables::rows::SimulationError;
use serde::{Deserialize, Serialize};

mod machines;
mod offroad;
mod summary;

use summary::summary;

#[derive(Parser)]
struct Arguments {
    /// Archives in all.
    #[arg(long, default_value_t = 500)]
    archives: usize,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Simulated nulls of each ride.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
    /// Smallest and largest hidden size, in usual ones.
    #[arg(long, num_args = 2, default_values_t = [0.4, 3.0])]
    sizes: Vec<f64>,
    /// Only this kind of case.
    #[arg(long)]
    only: Option<String>,
    /// Only these cases, by number.
    #[arg(long, value_delimiter = ',')]
    numbers: Vec<usize>,
    /// Archives of a population of multibody motorcycles beside them.
    #[arg(long, default_value_t = 0)]
    machines: usize,
    /// Motocross archives beside them.
    #[arg(long, default_value_t = 0)]
    offroad: usize,
    /// Print what effects show on machines of which they are not true, from the rides with nothing hidden.
    #[arg(long)]
    learn: bool,
    /// A line per archive.
    #[arg(long)]
    verbose: bool,
    /// File in which what was said of each road archive is kept, a JSON object a line: those that are in it are
    /// not asked again. A long run can be stopped and taken up.
    #[arg(long)]
    kept: Option<PathBuf>,
}

/// One archive: what was hidden and what was said.
struct Outcome {
    case: Case,
    told: Vec<Told>,
    alarm: f64,
    unexplained: bool,
    covariate: Option<String>,
    /// Detection limits of the hidden effects in this ride, in their units.
    limits: Vec<f64>,
    /// Those of every effect, in the order of [`ALL`].
    all_limits: Vec<f64>,
    /// What was found of every effect with the fault-free simulations' bias in it, its standard error without what
    /// is known of other machines, and that bias; in usual sizes, in the order of [`ALL`].
    found: Vec<[f64; 3]>,
    /// Largest residual structure of each channel, in what 19 of 20 fault-free simulations stay below.
    structure: Vec<f64>,
    gain: Option<f64>,
    /// Signals of manoeuvres left out that the extended model simulates better, and worse.
    signals: [usize; 2],
    /// Causes taken back because the simulation got worse.
    withdrawn: Vec<String>,
    /// Held-out gain of the base with the hidden effects free.
    oracle: Option<f64>,
    seconds: f64,
}

/// An outcome without its case, which can be drawn again.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Whether it is of the population of machines.
    #[serde(default)]
    machines: bool,
    seed: u64,
    sizes: Vec<f64>,
    nulls: usize,
    number: usize,
    told: Vec<Told>,
    alarm: f64,
    unexplained: bool,
    covariate: Option<String>,
    limits: Vec<Option<f64>>,
    all_limits: Vec<Option<f64>>,
    #[serde(default)]
    found: Vec<Option<[f64; 3]>>,
    #[serde(default)]
    structure: Vec<f64>,
    gain: Option<f64>,
    #[serde(default)]
    signals: [usize; 2],
    #[serde(default)]
    withdrawn: Vec<String>,
    oracle: Option<f64>,
    seconds: f64,
}

impl Kept {
    fn of(outcome: &Outcome, machines: bool, arguments: &Arguments) -> Self {
        // JSON knows no NaN
        let known =
            |x: &[f64]| x.iter().map(|x| Some(*x).filter(|x| x.is_finite())).collect::<Vec<_>>();
        Kept {
            machines,
            seed: arguments.seed,
            sizes: arguments.sizes.clone(),
            nulls: arguments.nulls,
            number: outcome.case.number,
            told: outcome.told.clone(),
            alarm: outcome.alarm,
            unexplained: outcome.unexplained,
            covariate: outcome.covariate.clone(),
            limits: known(&outcome.limits),
            all_limits: known(&outcome.all_limits),
            found: outcome
                .found
                .iter()
                .map(|x| Some(*x).filter(|x| x.iter().all(|x| x.is_finite())))
                .collect(),
            structure: outcome.structure.clone(),
            gain: outcome.gain,
            signals: outcome.signals,
            withdrawn: outcome.withdrawn.clone(),
            oracle: outcome.oracle,
            seconds: outcome.seconds,
        }
    }

    fn outcome(self, case: Case) -> Outcome {
        let whole = |x: Vec<Option<f64>>| x.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect();
        Outcome {
            case,
            told: self.told,
            alarm: self.alarm,
            unexplained: self.unexplained,
            covariate: self.covariate,
            limits: whole(self.limits),
            all_limits: whole(self.all_limits),
            found: self.found.into_iter().map(|x| x.unwrap_or([f64::NAN; 3])).collect(),
            structure: self.structure,
            gain: self.gain,
            signals: self.signals,
            withdrawn: self.withdrawn,
            oracle: self.oracle,
            seconds: self.seconds,
        }
    }
}

/// What a file has of this draw, of the population of machines or not, by number.
fn kept(machines: bool, arguments: &Arguments) -> BTreeMap<usize, Kept> {
    let text = arguments.kept.as_ref().and_then(|path| std::fs::read_to_string(path).ok());
    let lines = text.as_deref().unwrap_or_default().lines();
    lines
        // a run that was killed may have left half a line
        .filter_map(|line| serde_json::from_str::<Kept>(line).ok())
        .filter(|k| {
            k.machines == machines
                && k.seed == arguments.seed
                && k.nulls == arguments.nulls
                && k.sizes == arguments.sizes
        })
        .map(|k| (k.number, k))
        .collect()
}

#[derive(Clone, Serialize, Deserialize)]
struct Told {
    name: String,
    class: Vec<String>,
    value: f64,
    low: f64,
    high: f64,
}

impl Outcome {
    fn size(&self, k: usize) -> f64 {
        self.case.hidden[k].1.abs() / self.limits[k]
    }

    fn named(&self, effect: &str) -> bool {
        self.told.iter().any(|t| t.name == effect)
    }

    fn in_class(&self, effect: &str) -> bool {
        self.told.iter().any(|t| t.name == effect || t.class.iter().any(|c| c == effect))
    }
}

fn kind_of(number: usize) -> Kind {
    // of twenty: ten single, three null, one noisy, three double, two removed, one foreign
    match number / 2 % 20 {
        0..10 => Kind::Single,
        10..13 => Kind::Null,
        13 => Kind::Noisy,
        14..17 => Kind::Double,
        17..19 => Kind::Removed,
        _ => Kind::Foreign,
    }
}

fn main() {
    let arguments = Arguments::parse();
    let sizes = [arguments.sizes[0], arguments.sizes[1]];
    let work = tempfile::tempdir().expect("a folder for the archives");
    let draw = |n, kind| Case::draw(arguments.seed, n, kind, sizes);
    let outcomes = outcomes(&arguments, false, arguments.archives, &draw, |case| {
        let folder = work.path().join(case.number.to_string());
        let files = case.write(&folder).expect("archive");
        let outcome = ask(case, files, &arguments);
        std::fs::remove_dir_all(&folder).expect("cleared");
        outcome
    });
    if !outcomes.is_empty() {
        summary(&outcomes);
    }
    machines::run(&arguments, work.path());
    offroad::run(
        arguments.offroad,
        arguments.seed,
        arguments.nulls,
        arguments.verbose,
        work.path(),
    );
}

/// Draws cases in the usual shares and asks about each that is not in the file of `--kept`.
fn outcomes(
    arguments: &Arguments,
    machines: bool,
    count: usize,
    draw: &dyn Fn(usize, Kind) -> Case,
    answer: impl Fn(Case) -> Option<Outcome> + Sync,
) -> Vec<Outcome> {
    let Arguments { only, numbers, .. } = arguments;
    let cases: Vec<Case> = (0..)
        .map(|n| (n, kind_of(n)))
        .filter(|(_, k)| only.as_ref().is_none_or(|o| format!("{k:?}").eq_ignore_ascii_case(o)))
        .filter(|(n, _)| numbers.is_empty() || numbers.contains(n))
        .take(if numbers.is_empty() { count } else { count.min(numbers.len()) })
        .map(|(n, k)| draw(n, k))
        .collect();
    let known = Mutex::new(kept(machines, arguments));
    let keep = arguments.kept.as_ref().map(|path| {
        let file = std::fs::File::options().create(true).append(true).open(path);
        Mutex::new(file.expect("the file of --kept"))
    });
    cases
        .into_par_iter()
        .filter_map(|case| {
            let known = known.lock().expect("nobody panicked").remove(&case.number);
            if let Some(known) = known {
                return Some(known.outcome(case));
            }
            let outcome = answer(case);
            if let (Some(keep), Some(o)) = (&keep, &outcome) {
                let kept = Kept::of(o, machines, arguments);
                let line = serde_json::to_string(&kept).expect("plain numbers");
                let mut file = keep.lock().expect("nobody panicked");
                writeln!(file, "{line}").expect("the file of --kept");
            }
            if arguments.verbose
                && let Some(o) = &outcome
            {
                print_case(o);
            }
            outcome
        })
        .collect()
}

fn ask(case: Case, (log, bike): (PathBuf, PathBuf), arguments: &Arguments) -> Option<Outcome> {
    let begin = std::time::Instant::now();
    let removed = |e: &Effect| {
        case.kind == Kind::Removed
            && case.hidden.iter().any(|(h, _)| h.name == e.name || e.is_confounded_with(h.name))
    };
    let effects: Vec<Effect> = ALL.iter().filter(|e| !removed(e)).copied().collect();
    let settings = Settings { nulls: arguments.nulls, effects, advise: false };
    let bike = Bike::read(&bike).expect("bike");
    let found = match road::log(&log, &[], &bike, &Pipeline::onroad(), &settings) {
        Ok(found) => found,
        Err(why) => {
            println!("{} refused: {}", case.number, why.message);
            return None;
        }
    };
    let told = found
        .identification
        .causes
        .iter()
        .filter(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous))
        .map(|c| Told {
            name: c.candidate.name.to_owned(),
            class: c.equivalent.iter().map(|&c| c.to_owned()).collect(),
            value: c.value(),
            low: c.value() - 1.96 * c.std_error(),
            high: c.value() + 1.96 * c.std_error(),
        })
        .collect();
    let limit = |e: &Effect| {
        let j = settings.effects.iter().position(|f| f.name == e.name);
        j.map_or(f64::NAN, |j| found.calibration.limit(j) * e.typical.abs())
    };
    let limits = case.hidden.iter().map(|(e, _)| limit(e)).collect();
    let all_limits = ALL.iter().map(limit).collect();
    let own = |e: &Effect| {
        let cause = found.identification.causes.iter().find(|c| c.candidate.name == e.name);
        let place = settings.effects.iter().position(|f| f.name == e.name);
        let unmodelled = place.map_or(0.0, |j| found.calibration.scale.unmodelled[j]);
        let of = |c: &Cause| {
            let per = 1.0 / e.typical.abs();
            let error = c.std_error() * per;
            let own = (error * error - unmodelled * unmodelled).max(0.0).sqrt();
            [(c.value() + c.bias) * per, own, c.bias * per / shown(e.name).bias_share]
        };
        cause.map_or([f64::NAN; 3], of)
    };
    let first = found.causes.iter().find(|c| c.gain_heldout.is_some());
    let signals = [SimulationError::is_better, SimulationError::is_worse]
        .map(|is| found.simulation_errors.iter().filter(|e| is(e)).count());
    let is_withdrawn = |c: &&Cause| c.objection == Some(Objection::WorseSimulation);
    let withdrawn = found.identification.causes.iter().filter(is_withdrawn);
    let withdrawn = withdrawn.map(|c| format!("{} {:.4}", c.candidate.name, c.value())).collect();
    Some(Outcome {
        told,
        alarm: found.identification.alarm,
        unexplained: found.identification.unexplained,
        covariate: found
            .identification
            .structure
            .as_ref()
            .map(|s| format!("{} {:.1}", s.description, s.times)),
        limits,
        all_limits,
        found: ALL.iter().map(own).collect(),
        structure: structure(&found),
        gain: first.and_then(|c| c.gain_heldout),
        signals,
        withdrawn,
        oracle: (!case.hidden.is_empty()).then(|| {
            let hidden: Vec<Effect> = case.hidden.iter().map(|(e, _)| **e).collect();
            found.gain_of(&hidden)
        }),
        seconds: begin.elapsed().as_secs_f64(),
        case,
    })
}

/// Largest structure of each channel that the base leaves.
fn structure(found: &road::RoadDiagnosis) -> Vec<f64> {
    let problem = found.base.problem(&found.samples);
    let linear = problem.linear(&found.base.values);
    let scale = &found.calibration.scale.structure;
    let mut largest = vec![0.0_f64; CHANNELS.len()];
    for (term, usual) in terms(&found.samples, &problem, &linear).iter().zip(&scale.usual) {
        let own = &mut largest[term.channel];
        *own = own.max(term.gain / usual / scale.threshold);
    }
    largest
}

fn print_case(o: &Outcome) {
    let hidden: Vec<String> = o
        .case
        .hidden
        .iter()
        .zip(&o.limits)
        .map(|((e, v), l)| format!("{} {v:.4} ({:.1})", e.name, v.abs() / l))
        .collect();
    let told: Vec<String> = o
        .told
        .iter()
        .map(|t| {
            format!("{} {:.4}±{:.4} {:?}", t.name, t.value, (t.high - t.value) / 1.96, t.class)
        })
        .collect();
    println!(
        "{:4} {:?} {:.2} {}{} -> {:.1} {}{} | {} | better {} worse {} taken back {:?} ({:.0} s)",
        o.case.number,
        o.case.kind,
        o.case.plan.len(),
        hidden.join(" + "),
        o.case.foreign.map_or(String::new(), |(n, s)| format!("{n} {s:.3}")),
        o.alarm,
        if o.unexplained { "UNEXPLAINED " } else { "" },
        o.covariate.as_deref().unwrap_or(""),
        told.join("; "),
        o.signals[0],
        o.signals[1],
        o.withdrawn,
        o.seconds
    );
}
