//! Archives of the multibody motorcycle: there is more in them than what is hidden. Its tyres are
//! toroids on springs, so a rolling radius that falls with camber and with load is true of each.

use std::path::Path;

use rayon::prelude::*;
use roadbench::effects::physics::Multibody;
use roadbench::simulate::hidden::{Case, Kind};

use super::{Arguments, Outcome, ask, print_case};

/// Whether an outcome is of a kind.
type Is<'a> = &'a dyn Fn(&Outcome) -> bool;

/// What is true of this motorcycle whatever is hidden.
const TRUE: [&str; 2] = ["radius_camber", "radius_load"];

/// One effect that the motorcycle can carry and a ride can show; in one of four nothing.
fn draw(seed: u64, number: usize) -> Case {
    let kind = if (number / 2).is_multiple_of(4) { Kind::Null } else { Kind::Single };
    let mut tries = (0..).map(|k| Case::draw(seed + 1000 * k, number, kind, [1.0, 3.0]));
    let fits = |c: &Case| c.hidden.iter().all(|(e, _)| e.multibody == Multibody::Hooks && !e.faint);
    tries.find(fits).unwrap_or_else(|| Case::draw(seed, number, Kind::Null, [1.0, 3.0]))
}

/// Hides, asks and prints.
pub fn run(arguments: &Arguments, work: &Path) {
    let all: Vec<Outcome> = (0..arguments.multibody)
        .into_par_iter()
        .filter_map(|number| {
            let case = draw(arguments.seed, number);
            let folder = work.join(format!("multibody-{number}"));
            let outcome = match case.write_multibody(&folder) {
                Ok(files) => ask(case, files, arguments)?,
                Err(why) => {
                    println!("multibody {number}: {why}");
                    return None;
                }
            };
            std::fs::remove_dir_all(&folder).expect("cleared");
            if arguments.verbose {
                print_case(&outcome);
            }
            Some(outcome)
        })
        .collect();
    if all.is_empty() {
        return;
    }
    let wrong = |o: &Outcome| {
        o.told
            .iter()
            .filter(|t| {
                let known = |name: &str| {
                    TRUE.contains(&name) || o.case.hidden.iter().any(|(e, _)| e.name == name)
                };
                !known(&t.name) && !t.class.iter().any(|name| known(name))
            })
            .count()
    };
    let count = |these: &[&Outcome], what: Is<'_>| these.iter().filter(|o| what(o)).count();
    println!("\nmultibody, {} rides", all.len());
    println!(
        "{:26} {:>8} {:>8} {:>8} {:>12} {:>12}",
        "hidden", "archives", "named", "in class", "unexplained", "wrong names"
    );
    let rows: [(&str, Is<'_>); 3] = [
        ("nothing", &|o| o.case.hidden.is_empty()),
        ("below two limits", &|o| !o.case.hidden.is_empty() && o.size(0) <= 2.0),
        ("above two limits", &|o| !o.case.hidden.is_empty() && o.size(0) > 2.0),
    ];
    for (what, is) in rows {
        let these: Vec<&Outcome> = all.iter().filter(|o| is(o)).collect();
        let hidden = |o: &Outcome| o.case.hidden.first().map(|(e, _)| e.name);
        println!(
            "{what:26} {:8} {:8} {:8} {:12} {:12}",
            these.len(),
            count(&these, &|o| hidden(o).is_some_and(|name| o.named(name))),
            count(&these, &|o| hidden(o).is_some_and(|name| o.in_class(name))),
            count(&these, &|o| o.unexplained),
            these.iter().map(|o| wrong(o)).sum::<usize>()
        );
    }
}
