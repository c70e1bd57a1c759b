//! Sessions that are taken out of an output ([`roadbench::internals::batch::store::forget`]).

use roadbench::internals::batch::Error;
use roadbench::internals::batch::jobs::run;
use roadbench::internals::batch::store::folder::Store;
use roadbench::internals::batch::store::forget::{Selection, forget};
use roadbench::internals::batch::store::kind;
use roadbench::internals::report::Pages;
use roadbench::internals::store::tables::read;

use crate::script::Place;

/// A run with what is made over all sessions.
fn whole_run(place: &Place) {
    place.run();
    let store = Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    run::finish(&store, Pages::Auto, |_| Ok(())).expect("fleet and report");
}

/// The files that name a session, be it in a table, a page or their own name.
fn naming(place: &Place, session: &str) -> Vec<String> {
    let has = |name: &str, bytes: Vec<u8>| match name.ends_with(".parquet") {
        true => {
            let batches = read::batches_of(bytes.into()).expect("a table");
            batches.iter().any(|batch| format!("{batch:?}").contains(session))
        }
        false => String::from_utf8_lossy(&bytes).contains(session),
    };
    let tables = place.files("out").into_iter();
    tables
        .filter(|(name, bytes)| name.contains(session) || has(name, bytes.clone()))
        .map(|t| t.0)
        .collect()
}

#[test]
fn what_is_forgotten_is_in_no_table_and_on_no_page() {
    let place = Place::new(&[
        ("a", "s-alpha|b1|ok"),
        ("b", "s-beta|b1|ok"),
        ("c", "s-gamma|b2|ok"),
        ("d", "s-delta|b2|reject"),
    ]);
    whole_run(&place);
    let out = place.path("out").into();
    let before = place.files("out");
    assert!(naming(&place, "s-beta").len() > 5);
    let by_id = Selection { sessions: vec!["s-beta".into()], ..Selection::default() };
    let told = forget(&out, &by_id, false).expect("listed");
    assert_eq!(told.len(), 1);
    assert!(told[0].log.ends_with("b.csv") && told[0].bike_id == "b1", "{told:?}");
    assert!(place.files("out") == before, "only listed");
    assert_eq!(forget(&out, &by_id, true).expect("forgotten"), told);
    assert_eq!(naming(&place, "s-beta"), [""; 0]);
    assert_eq!(place.sessions(), ["b1/s-alpha", "b2/s-gamma"]);

    // a motorcycle leaves no folder, its rejected inputs none either
    let by_bike = Selection { bikes: vec!["b2".into()], ..Selection::default() };
    assert_eq!(forget(&out, &by_bike, true).expect("forgotten").len(), 2);
    assert_eq!(naming(&place, "s-gamma").len() + naming(&place, "s-delta").len(), 0);
    assert!(!place.path("out/sessions/bike=b2").exists());

    // the logs are there still
    place.run();
    assert_eq!(place.sessions(), ["b1/s-alpha", "b1/s-beta", "b2/s-gamma"]);
}

#[test]
fn missing_logs_are_told_from_a_missing_disk() {
    let logs = [("a", "s-a|b1|ok"), ("b", "s-b|b1|ok"), ("c", "s-c|b2|reject"), ("d", "s-d|b2|ok")];
    let place = Place::new(&logs);
    whole_run(&place);
    let out = place.path("out").into();
    let missing = Selection { missing: true, ..Selection::default() };
    assert_eq!(forget(&out, &missing, true).expect("nothing"), []);
    let unknown = Selection { sessions: vec!["s-x".into()], ..Selection::default() };
    let why = forget(&out, &unknown, true).expect_err("no such session");
    assert!(
        matches!(&why, Error::Usage(m) if m.contains("`s-x`") && m.contains("did you mean")),
        "{why}"
    );

    std::fs::rename(place.path("logs/a.csv"), place.path("logs/renamed.csv")).expect("renamed");
    std::fs::remove_file(place.path("logs/c.csv")).expect("removed");
    let gone = forget(&out, &missing, true).expect("forgotten");
    let logs: Vec<&str> = gone.iter().map(|g| g.session_id.as_str()).collect();
    assert_eq!(logs, ["s-a", "s-c"]);
    assert_eq!(place.sessions(), ["b1/s-b", "b2/s-d"]);

    std::fs::rename(place.path("logs"), place.path("unmounted")).expect("renamed");
    let why = forget(&out, &missing, true).expect_err("all are gone");
    assert!(matches!(&why, Error::Usage(m) if m.contains("2 of the 2 logs")), "{why}");
    assert_eq!(place.sessions(), ["b1/s-b", "b2/s-d"]);
}

/// Two writers of one report: the second waits, and has seen the tables as they are then.
#[test]
#[cfg(target_os = "linux")]
fn a_report_waits_for_another() {
    let place = Place::new(&[("a", "s-a|b1|ok")]);
    whole_run(&place);
    let held = std::fs::File::open(place.path("out/report")).expect("folder");
    held.lock().expect("locked");
    let out = place.path("out");
    let waiting = std::thread::spawn(move || roadbench::internals::report::update(&out));
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(!waiting.is_finished());
    place.put("logs/b.csv", "s-later|b1|ok");
    place.run();
    held.unlock().expect("let go");
    waiting.join().expect("no panic").expect("written");
    let index = std::fs::read_to_string(place.path("out/report/index.html")).expect("page");
    assert!(place.path("out/report/s-later.html").exists() && index.contains("s-later"));
}
