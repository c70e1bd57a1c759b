//! Hides physical effects in simulated archives and asks `diagnose` for them.
//!
//! ```text
//! cargo run --release --example blind -- --archives 500
//! ```
//!
//! Archives are written to files, answers are kept here; diagnosis gets the files. Prints what was
//! named for what was hidden, by size in detection limits, and the false alarms.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;

use clap::Parser;
use rayon::prelude::*;
use roadbench::contract::bike::Bike;
use roadbench::contract::verdict::Verdict;
use roadbench::diagnose::Settings;
use roadbench::diagnose::road;
use roadbench::effects::{ALL, Effect};
use roadbench::pipeline::Pipeline;
use roadbench::simulate::hidden::{Case, Kind, PLANS};
use serde::{Deserialize, Serialize};

mod multibody;
mod offroad;

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
    /// Archives of the multibody motorcycle beside them.
    #[arg(long, default_value_t = 0)]
    multibody: usize,
    /// Motocross archives beside them.
    #[arg(long, default_value_t = 0)]
    offroad: usize,
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
    gain: Option<f64>,
    /// Held-out gain of the base with the hidden effects free.
    oracle: Option<f64>,
    seconds: f64,
}

/// An outcome without its case, which can be drawn again.
#[derive(Serialize, Deserialize)]
struct Kept {
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
    gain: Option<f64>,
    oracle: Option<f64>,
    seconds: f64,
}

impl Kept {
    fn of(outcome: &Outcome, arguments: &Arguments) -> Self {
        // JSON knows no NaN
        let known =
            |x: &[f64]| x.iter().map(|x| Some(*x).filter(|x| x.is_finite())).collect::<Vec<_>>();
        Kept {
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
            gain: outcome.gain,
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
            gain: self.gain,
            oracle: self.oracle,
            seconds: self.seconds,
        }
    }
}

/// What a file has of this draw, by number.
fn kept(arguments: &Arguments) -> BTreeMap<usize, Kept> {
    let text = arguments.kept.as_ref().and_then(|path| std::fs::read_to_string(path).ok());
    let lines = text.as_deref().unwrap_or_default().lines();
    lines
        // a run that was killed may have left half a line
        .filter_map(|line| serde_json::from_str::<Kept>(line).ok())
        .filter(|k| {
            k.seed == arguments.seed && k.nulls == arguments.nulls && k.sizes == arguments.sizes
        })
        .map(|k| (k.number, k))
        .collect()
}

/// Sizes, in detection limits, that are counted together.
const BINS: [(f64, f64); 4] = [(0.0, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, f64::INFINITY)];

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
    let cases: Vec<Case> = (0..)
        .map(|n| (n, kind_of(n)))
        .filter(|(_, k)| {
            arguments.only.as_ref().is_none_or(|o| format!("{k:?}").eq_ignore_ascii_case(o))
        })
        .filter(|(n, _)| arguments.numbers.is_empty() || arguments.numbers.contains(n))
        .take(if arguments.numbers.is_empty() {
            arguments.archives
        } else {
            arguments.numbers.len()
        })
        .map(|(n, k)| Case::draw(arguments.seed, n, k, sizes))
        .collect();
    let known = Mutex::new(kept(&arguments));
    let keep = arguments.kept.as_ref().map(|path| {
        let file = std::fs::File::options().create(true).append(true).open(path);
        Mutex::new(file.expect("the file of --kept"))
    });
    let outcomes: Vec<Outcome> = cases
        .into_par_iter()
        .filter_map(|case| {
            let known = known.lock().expect("nobody panicked").remove(&case.number);
            if let Some(known) = known {
                return Some(known.outcome(case));
            }
            let folder = work.path().join(case.number.to_string());
            let files = case.write(&folder).expect("archive");
            let outcome = ask(case, files, &arguments);
            std::fs::remove_dir_all(&folder).expect("cleared");
            if let (Some(keep), Some(o)) = (&keep, &outcome) {
                let line = serde_json::to_string(&Kept::of(o, &arguments)).expect("plain numbers");
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
        .collect();
    if !outcomes.is_empty() {
        summary(&outcomes);
    }
    multibody::run(&arguments, work.path());
    offroad::run(
        arguments.offroad,
        arguments.seed,
        arguments.nulls,
        arguments.verbose,
        work.path(),
    );
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
        .naming
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
    let first = found.causes.iter().find(|c| c.gain_heldout.is_some());
    Some(Outcome {
        told,
        alarm: found.naming.alarm,
        unexplained: found.naming.unexplained,
        covariate: found
            .naming
            .structure
            .as_ref()
            .map(|s| format!("{} {:.1}", s.description, s.times)),
        limits,
        all_limits,
        gain: first.and_then(|c| c.gain_heldout),
        oracle: (!case.hidden.is_empty()).then(|| {
            let hidden: Vec<Effect> = case.hidden.iter().map(|(e, _)| **e).collect();
            found.gain_of(&hidden)
        }),
        seconds: begin.elapsed().as_secs_f64(),
        case,
    })
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
        "{:4} {:?} {:.2} {}{} -> {:.1} {}{} | {} ({:.0} s)",
        o.case.number,
        o.case.kind,
        o.case.plan.len(),
        hidden.join(" + "),
        o.case.foreign.map_or(String::new(), |(n, s)| format!("{n} {s:.3}")),
        o.alarm,
        if o.unexplained { "UNEXPLAINED " } else { "" },
        o.covariate.as_deref().unwrap_or(""),
        told.join("; "),
        o.seconds
    );
}

fn share(part: usize, whole: usize) -> String {
    match whole {
        0 => "   -".into(),
        _ => format!("{:3.0} % ({part} of {whole})", 100.0 * part as f64 / whole as f64),
    }
}

fn summary(all: &[Outcome]) {
    let of = |kind: Kind| all.iter().filter(move |o| o.case.kind == kind);
    println!(
        "\n{} archives, {:.1} s each",
        all.len(),
        all.iter().map(|o| o.seconds).sum::<f64>() / all.len() as f64
    );
    for kind in [Kind::Null, Kind::Noisy] {
        for plan in PLANS {
            let these: Vec<_> = of(kind).filter(|o| o.case.plan == plan).collect();
            let alarmed = these.iter().filter(|o| o.alarm > 1.0).count();
            let named = these.iter().filter(|o| !o.told.is_empty()).count();
            let lost = these.iter().filter(|o| o.unexplained).count();
            println!(
                "{kind:?} {plan}: alarm {}, named {}, unexplained {}",
                share(alarmed, these.len()),
                share(named, these.len()),
                share(lost, these.len())
            );
        }
    }
    println!("\nsingle effects by size in detection limits (faint ones apart)");
    println!(
        "{:12} {:>18} {:>18} {:>18} {:>18}",
        "size", "named first", "in class", "wrong", "unexplained"
    );
    for (low, high) in BINS {
        let these: Vec<_> = of(Kind::Single)
            .filter(|o| !o.case.hidden[0].0.faint)
            .filter(|o| (low..high).contains(&o.size(0)))
            .collect();
        let truth = |o: &&&Outcome| o.case.hidden[0].0.name;
        let first =
            these.iter().filter(|o| o.told.first().is_some_and(|t| t.name == truth(o))).count();
        let class = these.iter().filter(|o| o.in_class(truth(o))).count();
        let wrong = these.iter().filter(|o| !o.told.is_empty() && !o.in_class(truth(o))).count();
        let lost = these.iter().filter(|o| o.unexplained).count();
        let n = these.len();
        println!(
            "{low:3} to {high:<5} {:>18} {:>18} {:>18} {:>18}",
            share(first, n),
            share(class, n),
            share(wrong, n),
            share(lost, n)
        );
    }
    let faint: Vec<_> = of(Kind::Single).filter(|o| o.case.hidden[0].0.faint).collect();
    let right = faint.iter().filter(|o| o.in_class(o.case.hidden[0].0.name)).count();
    let wrong =
        faint.iter().filter(|o| !o.told.is_empty() && !o.in_class(o.case.hidden[0].0.name)).count();
    println!(
        "faint effects: in class {}, wrong {}",
        share(right, faint.len()),
        share(wrong, faint.len())
    );
    let extra: usize = of(Kind::Single)
        .map(|o| o.told.iter().filter(|t| t.name != o.case.hidden[0].0.name).count())
        .sum();
    println!(
        "names beside the true one, per single archive: {:.2}",
        extra as f64 / of(Kind::Single).count().max(1) as f64
    );

    println!("\nconfusion (single, above two limits): hidden, then what was named first");
    let mut table: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
    for o in of(Kind::Single).filter(|o| o.size(0) > 2.0) {
        let said = match o.told.first() {
            Some(t) => t.name.as_str(),
            None if o.unexplained => "unexplained",
            None => "nothing",
        };
        *table.entry(o.case.hidden[0].0.name).or_default().entry(said).or_default() += 1;
    }
    for (hidden, said) in &table {
        let said: Vec<String> = said.iter().map(|(n, k)| format!("{n} {k}")).collect();
        println!("  {hidden:24} {}", said.join(", "));
    }

    println!("\nnamed first, of how many, by size in detection limits");
    println!("  {:24} {:>8} {:>8} {:>8} {:>8}", "", "0 to 1", "1 to 2", "2 to 4", "above");
    for effect in ALL {
        let cell = |(low, high): (f64, f64)| {
            let these: Vec<_> = of(Kind::Single)
                .filter(|o| o.case.hidden[0].0.name == effect.name)
                .filter(|o| (low..high).contains(&o.size(0)))
                .collect();
            let first = |o: &&&Outcome| o.told.first().is_some_and(|t| t.name == effect.name);
            match these.len() {
                0 => "-".to_owned(),
                n => format!("{}/{n}", these.iter().filter(first).count()),
            }
        };
        let [a, b, c, d] = BINS.map(cell);
        println!("  {:24} {a:>8} {b:>8} {c:>8} {d:>8}", effect.name);
    }

    println!(
        "\ndetection limits, median of all archives: paper, naturalistic, in the effect's unit"
    );
    for (j, effect) in ALL.iter().enumerate() {
        let limit = |plan: &str| {
            let mut x: Vec<f64> = all
                .iter()
                .filter(|o| o.case.plan == plan)
                .filter_map(|o| o.all_limits.get(j).copied().filter(|l| l.is_finite()))
                .collect();
            x.sort_by(f64::total_cmp);
            x.get(x.len() / 2).map_or("-".to_owned(), |l| format!("{l:.2e}"))
        };
        println!(
            "  {:24} {:>10} {:>10} {}",
            effect.name,
            limit(PLANS[0]),
            limit(PLANS[1]),
            effect.unit
        );
    }

    // intervals and errors of the right names
    let mut errors: Vec<f64> = Vec::new();
    let (mut inside, mut n) = (0, 0);
    for o in all {
        for (e, value) in &o.case.hidden {
            if let Some(t) = o.told.iter().find(|t| t.name == e.name) {
                n += 1;
                inside += usize::from((t.low..=t.high).contains(value));
                errors.push((t.value / value - 1.0).abs());
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    if let (Some(median), Some(most)) =
        (errors.get(errors.len() / 2), errors.get(errors.len() * 9 / 10))
    {
        println!(
            "\nright names: error median {:.0} %, nine in ten below {:.0} %; 95 % interval covers {}",
            100.0 * median,
            100.0 * most,
            share(inside, n)
        );
    }
    let pairs: Vec<_> = of(Kind::Double).filter(|o| (0..2).all(|k| o.size(k) > 2.0)).collect();
    let both = pairs.iter().filter(|o| o.case.hidden.iter().all(|(e, _)| o.named(e.name))).count();
    let classes =
        pairs.iter().filter(|o| o.case.hidden.iter().all(|(e, _)| o.in_class(e.name))).count();
    let extra: usize = of(Kind::Double)
        .map(|o| {
            o.told
                .iter()
                .filter(|t| {
                    !o.case
                        .hidden
                        .iter()
                        .any(|(e, _)| e.name == t.name || t.class.iter().any(|c| c == e.name))
                })
                .count()
        })
        .sum();
    println!(
        "two effects above two limits: both named {}, both in the classes {}; wrong names per archive {:.2}",
        share(both, pairs.len()),
        share(classes, pairs.len()),
        extra as f64 / of(Kind::Double).count().max(1) as f64
    );
    let removed: Vec<_> = of(Kind::Removed).filter(|o| o.alarm > 1.0).collect();
    let blamed = removed.iter().filter(|o| !o.told.is_empty()).count();
    let lost = removed.iter().filter(|o| o.unexplained).count();
    println!(
        "cause not in the library, {} alarmed: unexplained {}, blamed on another {}",
        removed.len(),
        share(lost, removed.len()),
        share(blamed, removed.len())
    );
    let foreign: Vec<_> = of(Kind::Foreign).filter(|o| o.alarm > 1.0).collect();
    let blamed = foreign.iter().filter(|o| !o.told.is_empty()).count();
    println!(
        "outside any library, {} of {} alarmed: blamed on an effect {}",
        foreign.len(),
        of(Kind::Foreign).count(),
        share(blamed, foreign.len())
    );
    for kind in [Kind::Single, Kind::Double] {
        let (gain, oracle) = of(kind)
            .filter(|o| !o.told.is_empty())
            .filter_map(|o| Some((o.gain?, o.oracle?)))
            .fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
        println!("{kind:?}, named: held-out gain over that of the true model {:.3}", gain / oracle);
    }
}
