//! The tables over all archives.

use std::collections::BTreeMap;

use roadbench::internals::simulate::effects::ALL;
use roadbench::internals::simulate::hidden::{Kind, PLANS};

use super::Outcome;

/// Sizes, in detection limits, that are counted together.
const BINS: [(f64, f64); 4] = [(0.0, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, f64::INFINITY)];

/// A share in words.
pub fn share(part: usize, whole: usize) -> String {
    match whole {
        0 => "   -".into(),
        _ => format!("{:3.0} % ({part} of {whole})", 100.0 * part as f64 / whole as f64),
    }
}

/// Prints them.
pub fn summary(all: &[Outcome]) {
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
