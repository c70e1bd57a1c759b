//! Outputs that are not as they were written ([`roadbench::internals::batch::store::verify`]).

use roadbench::internals::batch::jobs::run;
use roadbench::internals::batch::store::folder::Store;
use roadbench::internals::batch::store::kind;
use roadbench::internals::batch::store::verify::{Wrong, mend, verify};
use roadbench::internals::report::Pages;

use crate::script::Place;

fn whole_run(place: &Place) {
    place.run();
    let store = Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    run::finish(&store, Pages::Auto, |_| Ok(())).expect("fleet and report");
}

fn found(place: &Place) -> Vec<(Wrong, String)> {
    let done = verify(&place.path("out").into(), true).expect("verified");
    assert_eq!(done.unlisted, 0);
    done.findings.into_iter().map(|f| (f.wrong, f.place)).collect()
}

fn flip(place: &Place, file: &str) {
    let path = place.path(file);
    let mut bytes = std::fs::read(&path).expect("there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).expect("written");
}

const LOGS: [(&str, &str); 4] =
    [("a", "s-a|b1|ok"), ("b", "s-b|b1|ok"), ("c", "s-c|b2|ok"), ("d", "s-d|b2|reject")];

#[test]
fn an_output_is_as_it_was_written_or_it_is_told_what_is_not() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    assert_eq!(found(&place), []);
    let whole = place.files("out");

    // one bit of every file in turn: told by name, and by nothing else
    let files: Vec<String> =
        place.names().into_iter().filter(|n| n.ends_with(".parquet")).collect();
    assert!(files.len() > 12, "{files:?}");
    for file in files.iter().filter(|f| !f.starts_with("rejected/")) {
        flip(&place, &format!("out/{file}"));
        let told = found(&place);
        assert!(told.contains(&(Wrong::Changed, file.clone())), "{file}: {told:?}");
        assert!(
            told.iter().all(|(wrong, at)| at == file || *wrong != Wrong::Changed),
            "{file}: {told:?}"
        );
        flip(&place, &format!("out/{file}"));
    }
    assert_eq!(found(&place), []);

    // a table that is damaged is removed, and its sessions are computed again
    flip(&place, "out/coefficients/bike=b1/2026-05.parquet");
    flip(&place, "out/fleet/fleet.parquet");
    let out = place.path("out").into();
    let mended = mend(&out, false).expect("mended");
    assert_eq!(mended.removed, ["coefficients/bike=b1/2026-05.parquet", "fleet/fleet.parquet"]);
    let again = place.run();
    assert_eq!((again.done, again.unchanged), (2, 1));
    whole_run(&place);
    assert_eq!(found(&place), []);
    assert!(place.files("out") == whole, "not as it was");

    // so is a month's commit markers
    flip(&place, "out/sessions/bike=b1/2026-05.parquet");
    mend(&out, false).expect("mended");
    whole_run(&place);
    assert!(place.files("out") == whole, "not as it was");
}

#[test]
fn what_is_gone_left_over_or_nobodys_is_told() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    std::fs::remove_file(place.path("out/evidence/bike=b1/2026-05.parquet")).expect("removed");
    std::fs::copy(
        place.path("out/plots/bike=b2/2026-05.parquet"),
        place.path("out/plots/bike=b2/2031-01.parquet"),
    )
    .expect("copied");
    place.put("out/coefficients/.roadbench-x.tmp", "half a file");
    std::fs::remove_file(place.path("logs/a.csv")).expect("removed");
    place.put("logs/c.csv", "s-c|b2|ok ");
    let done = verify(&place.path("out").into(), true).expect("verified");
    assert_eq!(done.unlisted, 1, "the copy");
    let mut told: Vec<(Wrong, String)> =
        done.findings.into_iter().map(|f| (f.wrong, f.place)).collect();
    let log = |name: &str| place.path(name).to_string_lossy().into_owned();
    let mut expected = vec![
        (Wrong::Missing, "evidence/bike=b1/2026-05.parquet".to_owned()),
        (Wrong::Orphan, "plots/bike=b2/2031-01.parquet".to_owned()),
        (Wrong::LeftOver, "coefficients/.roadbench-x.tmp".to_owned()),
        (Wrong::LogMissing, log("logs/a.csv")),
        (Wrong::LogChanged, log("logs/c.csv")),
    ];
    told.sort();
    expected.sort();
    assert_eq!(told, expected);
    let alone = verify(&place.path("out").into(), false).expect("verified");
    assert_eq!((alone.logs, alone.findings.len()), (0, 3));
}

/// A damaged table is not given up for nothing: sessions whose logs are gone cannot be computed again.
#[test]
fn mending_keeps_what_no_log_can_give_again() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    let [kept, gone] =
        ["coefficients/bike=b1/2026-05.parquet", "coefficients/bike=b2/2026-05.parquet"];
    flip(&place, &format!("out/{kept}"));
    flip(&place, &format!("out/{gone}"));
    std::fs::remove_file(place.path("logs/a.csv")).expect("removed");
    let out = place.path("out").into();
    let mended = mend(&out, false).expect("mended");
    assert_eq!(mended.removed, [gone]);
    let sessions = mended.kept.get(kept).map(|s| s.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(sessions, Some(vec!["s-a"]), "{:?}", mended.kept);
    // no run has made the other one again
    assert_eq!(mend(&out, true).expect("mended").removed, [kept]);
    let run = place.run();
    assert!(run.done >= 1, "{}", run.done);
    assert!(mend(&out, false).expect("mended").kept.is_empty());
    assert!(
        found(&place).iter().all(|(wrong, _)| *wrong == Wrong::LogMissing),
        "{:?}",
        found(&place)
    );
}

/// A run does not spread what a bad disk made of a table.
#[test]
fn a_run_notices_a_table_that_is_not_as_it_was_written() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    // bytes that still are a table: an older one of the same month
    let table = "out/coefficients/bike=b1/2026-05.parquet";
    let old = std::fs::read(place.path(table)).expect("there");
    place.put("logs/e.csv", "s-e|b1|ok");
    place.run();
    std::fs::write(place.path(table), old).expect("written");
    place.put("logs/f.csv", "s-f|b1|ok");
    let run = place.run();
    assert_eq!((run.done, run.rejected.len(), &run.damage), (4, 1, &None), "the month anew");
    assert_eq!(place.sessions(), ["b1/s-a", "b1/s-b", "b1/s-e", "b1/s-f", "b2/s-c"]);
    assert_eq!(place.run().unchanged, 5);
    whole_run(&place);
    assert_eq!(found(&place), []);
}
