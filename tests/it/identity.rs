//! Which log is which session: names, copies, moves, and motorcycles with sessions of the same name.

use roadbench::internals::batch::Maps;

use crate::script::{BIKE, Place, Script, adds_up, codes};

/// A session is a motorcycle's: two may have one of the same id each.
#[test]
fn two_motorcycles_may_have_sessions_of_the_same_name() {
    let place = Place::new(&[("a", "monday|b1|ok"), ("b", "monday|b2|ok"), ("c", "monday|b2|ok ")]);
    let run = place.run();
    adds_up(&run);
    assert_eq!((run.done, codes(&run)), (2, vec!["duplicate_session_id"]));
    assert_eq!(place.sessions(), ["b1/monday", "b2/monday"]);
    std::fs::remove_file(place.path("logs/c.csv")).expect("removed");
    let again = place.run();
    assert_eq!((again.done, again.unchanged), (0, 2));
    assert!(!place.names().iter().any(|n| n.starts_with("rejected/")), "{:?}", place.names());

    // one of them changes: the other keeps what it has
    place.put("logs/b.csv", "monday|b2|reject");
    let run = place.run();
    assert_eq!((run.unchanged, codes(&run)), (1, vec!["too_short"]));
    assert_eq!(place.sessions(), ["b1/monday"]);
}

/// The bytes say what a log is: one that was renamed is the same ride, one that was copied does not count twice.
#[test]
fn a_renamed_log_is_the_same_ride_and_a_copy_is_none() {
    let place =
        Place::new(&[("a", "*|b1|ok"), ("b", "*|b1|ok 0.3 2026-05-01"), ("c", "s-c|b1|ok")]);
    place.run();
    assert_eq!(place.sessions(), ["b1/a", "b1/b", "b1/s-c"]);
    let rename = |from: &str, to: &str| {
        std::fs::rename(place.path(from), place.path(to)).expect("renamed");
    };
    rename("logs/a.csv", "logs/z.csv");
    rename("logs/c.csv", "logs/y.csv");
    let run = place.run();
    adds_up(&run);
    assert_eq!((run.done, run.unchanged), (2, 1));
    assert_eq!(place.sessions(), ["b1/b", "b1/s-c", "b1/z"]);

    // a copy is reported, wherever it comes in the order of names, and every night
    for copy in ["logs/0.csv", "logs/zz.csv"] {
        std::fs::copy(place.path("logs/b.csv"), place.path(copy)).expect("copied");
        for _ in 0..2 {
            let run = place.run();
            adds_up(&run);
            assert_eq!((run.done, run.unchanged, codes(&run)), (0, 3, vec!["duplicate_log"]));
            assert!(run.rejected[0].message.contains("b.csv"), "{}", run.rejected[0].message);
        }
        assert_eq!(place.sessions(), ["b1/b", "b1/s-c", "b1/z"]);
        std::fs::remove_file(place.path(copy)).expect("removed");
    }
    std::fs::copy(place.path("logs/y.csv"), place.path("logs/0.csv")).expect("copied");
    let run = place.run();
    assert_eq!((run.done, run.unchanged, codes(&run)), (0, 3, vec!["duplicate_session_id"]));
    std::fs::remove_file(place.path("logs/0.csv")).expect("removed");
    assert_eq!(place.run().rejected.len(), 0);
    assert!(!place.names().iter().any(|n| n.starts_with("rejected/")), "{:?}", place.names());

    // copies of a first night, and into another folder of another night: the first by name counts
    let place = Place::new(&[("a", "*|b1|ok"), ("b", "*|b1|ok"), ("c", "*|b1|ok")]);
    let run = place.run();
    assert_eq!((run.done, codes(&run)), (1, vec!["duplicate_log", "duplicate_log"]));
    place.put("later/d.csv", "*|b1|ok");
    let run = place.run_with(&Script::default(), |s| s.inputs = vec![place.path("later")]);
    assert_eq!(codes(&run.expect("run")), ["duplicate_log"]);
    assert_eq!(place.sessions(), ["b1/a"]);
}

/// A session whose id is the name of its file goes when the file gets another name; so does that of a log that is bad
/// now. A dry run says which, and the run does it.
#[test]
fn a_dry_run_says_which_sessions_go() {
    let place = Place::new(&[
        ("a", "*|b1|ok"),
        ("c", "s-c|b1|ok"),
        ("d", "*|b2|ok 0.3 2026-05-01"),
        ("e", "s-e|b1|ok 0.3 2026-05-02"),
        ("x", "s-x|b1|ok 0.3 2026-05-03"),
        ("y", "s-y|b1|ok 0.3 2026-05-04"),
    ]);
    place.run();
    let before = place.sessions();
    for (from, to) in [("a", "z"), ("c", "0")] {
        let [from, to] = [from, to].map(|name| place.path(&format!("logs/{name}.csv")));
        std::fs::rename(from, to).expect("renamed");
    }
    place.put("logs/d.csv", "rubbish");
    place.put("logs/e.csv", "s-f|b2|ok 0.3 2026-05-02");
    // their sessions stay: they only change names
    place.put("logs/x.csv", "s-y|b1|ok 0.3 2026-05-04");
    place.put("logs/y.csv", "s-x|b1|ok 0.3 2026-05-03");
    let intended = place.setup().intend();
    let says = |name: &str| &intended.iter().find(|(log, ..)| log == name).expect(name).2;
    assert_eq!(says("z"), "new; removes session `a` of b1, which was made from this log");
    assert_eq!(says("0"), "the log was renamed or moved");
    assert!(says("d").ends_with("; removes session `d` of b2, which was made from this log"));
    assert!(says("e").ends_with("; removes session `s-e` of b1, which was made from this log"));
    place.run();
    let after = place.sessions();
    let removed: Vec<String> = before.into_iter().filter(|key| !after.contains(key)).collect();
    assert_eq!(removed, ["b1/a", "b1/s-e", "b2/d"]);
    assert_eq!(intended.iter().filter(|(.., why)| why.contains("removes session")).count(), 3);
}

/// Names that are exchanged among logs, in one night.
#[test]
fn exchanged_names_lose_nothing() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b2|ok"), ("c", "s-c|b1|ok")]);
    place.run();
    place.put("logs/a.csv", "s-b|b2|ok");
    place.put("logs/b.csv", "s-a|b1|ok");
    let run = place.run();
    adds_up(&run);
    assert_eq!(run.rejected.len(), 0, "{:?}", run.rejected);
    assert_eq!(place.sessions(), ["b1/s-a", "b1/s-c", "b2/s-b"]);
    // a log that becomes another session leaves nothing of what it was
    place.put("logs/c.csv", "s-d|b2|ok");
    place.run();
    assert_eq!(place.sessions(), ["b1/s-a", "b2/s-b", "b2/s-d"]);
}

/// Remarks and layout of bike files and channel maps are nobody's settings.
#[test]
fn remarks_change_nothing() {
    let map = |text: &str| {
        let maps = Maps::parse(&[("mine.toml".to_owned(), text.to_owned())]).expect("a map");
        maps.hash_of(Some(&maps.list()[0].name))
    };
    let text = include_str!("../../pipelines/maps/racebox.toml");
    let bare: Vec<&str> = text.lines().filter(|l| !l.starts_with('#') && !l.is_empty()).collect();
    assert_ne!(bare.join("\n").len(), text.len());
    assert_eq!(map(text), map(&bare.join("\n")));
    assert_ne!(
        map(text),
        map(&text.replacen("sign = -1", "", 1).replacen("name = \"", "name = \"my_", 1))
    );

    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b2|ok")]);
    place.run();
    place.put("bikes/b1.toml", &format!("# weighed on Monday\n{BIKE}\n\n# and again\n"));
    let run = place.run();
    assert_eq!((run.done, run.unchanged), (0, 2));
    place.put("bikes/b1.toml", &BIKE.replace("260.0", "261.0"));
    let run = place.run_with(&Script::default(), |_| {}).expect("run");
    assert_eq!((run.done, run.unchanged), (1, 1));
}

/// A log depends on the channel map that it is read by, and on what might take it instead; on no other.
#[test]
fn a_map_concerns_the_logs_that_are_read_by_it() {
    let place =
        Place::new(&[("a", "s-a|b1|ok map=one"), ("b", "s-b|b1|ok map=two"), ("c", "s-c|b2|ok")]);
    let text = |name: &str, format: &str, detect: &str, from: &str| {
        // a log of MDF has its own clock
        let clock = if format == "csv" { "[time]\ncolumn = \"t\"\nunit = \"s\"\n" } else { "" };
        format!(
            "name = \"{name}\"\nformat = \"{format}\"\n[detect]\ncolumns = [\"{detect}\"]\n{clock}[channel.velocity_x]\n\
             from = \"{from}\"\n"
        )
    };
    let night = |maps: &[(&str, String)]| {
        for (name, text) in maps {
            place.put(&format!("{name}.toml"), text);
        }
        let paths = maps.iter().map(|(name, _)| place.path(&format!("{name}.toml"))).collect();
        let run = place.run_with(&Script::default(), |s| s.maps = paths).expect("run");
        adds_up(&run);
        (run.done, run.unchanged)
    };
    let one = |from| ("one", text("one", "csv", "u", from));
    let two = |detect, from| ("two", text("two", "csv", detect, from));
    assert_eq!(night(&[one("v"), two("w", "v")]), (3, 0));
    assert_eq!(night(&[one("v"), two("w", "v")]), (0, 3));
    assert_eq!(night(&[one("v"), two("w", "speed")]), (1, 2), "the log of map two");
    assert_eq!(night(&[one("speed"), two("w", "speed")]), (1, 2), "the log of map one");
    // a map behind them, and one of another format in front, take nothing from them
    let (last, other) = (text("last", "csv", "x", "v"), text("other", "mdf", "x", "v"));
    let more = [("other", other), one("speed"), two("w", "speed"), ("last", last)];
    assert_eq!(night(&more), (0, 3));
    // one in front may: every possible match is looked at again
    let first = ("first", text("first", "csv", "x", "v"));
    assert_eq!(night(&[first, one("speed"), two("w", "speed")]), (2, 1));
}
