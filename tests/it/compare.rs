//! `roadbench compare`: coverage and power where the difference is known, on drawn evidence and on the bundled archive.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use roadbench::internals::batch::fleet::compare::compare as compare_sets;
use roadbench::internals::fleet::compare::{Difference, Session, Verdict, compare};
use roadbench::internals::fleet::evidence::Piece;
use roadbench::internals::statistics::random::Random;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{ComparisonRow, Truth};

const ARCHIVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/archive");

/// Relative errors of what is drawn: of the bike file's mass, of the model, of a ride, and the spread between rides.
const MASS: f64 = 0.05;
const MODEL: f64 = 0.02;
const OWN: f64 = 0.02;
const BETWEEN: f64 = 0.02;
/// How well it is known what a shared error does to a ride.
const SLOPE: f64 = 0.3;

/// Sessions of two tyres on one motorcycle, B larger by `difference`.
fn drawn(random: &mut Random, sessions: [usize; 2], difference: f64) -> Vec<Session> {
    let (mass, of_bike) = (random.normal(), random.normal());
    let mut out = Vec::new();
    for side in 0..2 {
        let of_tyre = random.normal();
        for i in 0..sessions[side] {
            let slope = |random: &mut Random| 1.0 + SLOPE * random.normal();
            let error = MASS * mass * slope(random)
                + MODEL * 0.5_f64.sqrt() * (of_bike + of_tyre) * slope(random)
                + OWN * random.normal()
                + BETWEEN * random.normal();
            let value = 1.1 * (side as f64 * difference + error).exp();
            let piece = |source: &str, shared, share: f64| Piece {
                session: format!("{side}-{i}"),
                tyre: "rear".into(),
                coefficient: "mf_d".into(),
                unit: "1".into(),
                value,
                source: source.into(),
                shared,
                shift: share * value,
                ..Piece::default()
            };
            out.push(Session {
                bike: "b".into(),
                session: format!("{side}-{i}"),
                side,
                tyres: [None, Some(format!("tyre {side}"))],
                pieces: vec![
                    piece("mass", true, MASS),
                    piece("model", true, MODEL),
                    piece("own", false, OWN),
                ],
            });
        }
    }
    out
}

const PAIRS: usize = 200;

/// Pairs whose interval contains the truth, pairs that differ, mean half width, and mean half width without pairing.
fn pairs(sessions: [usize; 2], difference: f64) -> (usize, usize, f64, f64) {
    let mut random = Random::new(57, &format!("compare {sessions:?} {difference}"));
    let (mut held, mut differ, mut half, mut apart) = (0, 0, 0.0, 0.0);
    for _ in 0..PAIRS {
        let found = compare(&drawn(&mut random, sessions, difference));
        let [one] = found.as_slice() else { panic!("{found:?}") };
        let Some(Difference { relative: Some([_, low, high]), .. }) = one.difference else {
            panic!("{one:?}")
        };
        let verdict = one.difference.as_ref().map(Difference::verdict);
        held += usize::from((low..=high).contains(&difference.exp_m1()));
        differ += usize::from(verdict == Some(Verdict::Larger));
        half += 0.5 * (high.ln_1p() - low.ln_1p()) / PAIRS as f64;
        let widths = one.sides.iter().flatten().map(|s| 0.5 * (s.interval[1] / s.interval[0]).ln());
        apart += widths.map(|w| w * w).sum::<f64>().sqrt() / PAIRS as f64;
    }
    println!("{sessions:?}, {difference}: {held} held, {differ} larger, {half:.4} of {apart:.4}");
    (held, differ, half, apart)
}

#[test]
fn intervals_of_differences_contain_the_truth_and_shared_errors_cancel() {
    let (mut held, mut all) = (0, 0);
    for sessions in [[1, 1], [1, 4], [3, 3], [6, 10], [20, 20]] {
        for difference in [0.0, 0.08] {
            let (of, _, half, apart) = pairs(sessions, difference);
            assert!((182..=198).contains(&of), "{sessions:?} {difference}: {of} of {PAIRS}");
            (held, all) = (held + of, all + PAIRS);
            if sessions[0] >= 3 {
                assert!(half < 0.6 * apart, "{sessions:?}: {half} of {apart}");
            }
        }
    }
    let share = held as f64 / all as f64;
    assert!((0.93..0.98).contains(&share), "{share}");
}

#[test]
fn a_difference_of_8_percent_is_seen_and_none_is_not() {
    for (sessions, least) in [([3, 3], 0.5), ([6, 10], 0.8), ([20, 20], 0.9)] {
        let (_, differ, ..) = pairs(sessions, 0.08);
        assert!(differ as f64 >= least * PAIRS as f64, "{sessions:?}: {differ}");
        let (_, by_chance, ..) = pairs(sessions, 0.0);
        assert!(by_chance <= PAIRS / 20, "{sessions:?}: {by_chance}");
    }
}

/// What the motorcycle's other sessions say of the spread narrows a comparison of one session with one.
#[test]
fn other_sessions_tell_of_the_spread() {
    let mut random = Random::new(3, "others");
    let all = drawn(&mut random, [21, 1], 0.0);
    let few: Vec<Session> =
        all.iter().filter(|s| s.side == 1 || s.session == "0-0").cloned().collect();
    let mut with = all;
    with.iter_mut().filter(|s| s.side == 0 && s.session != "0-0").for_each(|s| s.side = 2);
    let of = |sessions: &[Session]| {
        let found = compare(sessions);
        assert_eq!(found[0].sides.iter().flatten().map(|s| s.sessions).collect::<Vec<_>>(), [1, 1]);
        let difference = found[0].difference.clone().expect("comparable");
        (difference.is_assumed, difference.interval[1] - difference.interval[0])
    };
    let (alone, beside) = (of(&few), of(&with));
    assert!(alone.0 && !beside.0, "{alone:?} {beside:?}");
    assert!(beside.1 < alone.1, "{alone:?} {beside:?}");
}

/// Sessions of both sides on each of two tyres of one motorcycle, or on each of two motorcycles, B larger by `difference`;
/// `rides` by side and tyre, `levels` of the tyres as logarithms.
fn on_two(
    random: &mut Random,
    rides: [[usize; 2]; 2],
    levels: [f64; 2],
    are_bikes: bool,
    difference: f64,
) -> Vec<Session> {
    let [mass, of_bike, of_tyre] = [(); 3].map(|()| [random.normal(), random.normal()]);
    let mut out = Vec::new();
    for (side, which) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let bike = if are_bikes { which } else { 0 };
        for i in 0..rides[side][which] {
            let mut slope = || 1.0 + SLOPE * random.normal();
            let of_model = of_bike[bike] + if are_bikes { 0.0 } else { of_tyre[which] };
            let error = MASS * mass[bike] * slope() + MODEL * 0.5_f64.sqrt() * of_model * slope();
            let error = error + OWN.hypot(BETWEEN) * random.normal();
            let value = 0.4 * (levels[which] + side as f64 * difference + error).exp();
            let session = format!("{side}-{which}-{i}");
            let piece = |source: &str, shared, share: f64| Piece {
                session: session.clone(),
                tyre: if are_bikes { "vehicle" } else { "rear" }.into(),
                coefficient: if are_bikes { "drag" } else { "mf_d" }.into(),
                unit: "1".into(),
                value,
                source: source.into(),
                shared,
                shift: share * value,
                ..Piece::default()
            };
            out.push(Session {
                bike: format!("b{bike}"),
                session: session.clone(),
                side,
                tyres: [None, Some(format!("tyre {which}"))],
                pieces: vec![
                    piece("mass", true, MASS),
                    piece("model", true, MODEL),
                    piece("own", false, OWN),
                ],
            });
        }
    }
    out
}

/// Both riders rode both tyres: how much tyres differ is no matter for how much the riders do.
#[test]
fn tyres_and_motorcycles_that_both_sides_rode_cancel() {
    let mut random = Random::new(58, "both rode both");
    let width = |sessions: &[Session]| {
        let found = compare(sessions);
        let of = found[0].difference.as_ref().and_then(|d| d.relative).expect("of one sign");
        (of[1..].iter().map(|end| end.ln_1p()).collect::<Vec<_>>(), of[2].ln_1p() - of[1].ln_1p())
    };
    for are_bikes in [false, true] {
        let mut mean = |rides, levels, difference| {
            let (mut held, mut sum) = (0, 0.0);
            for _ in 0..PAIRS {
                let all = on_two(&mut random, rides, levels, are_bikes, difference);
                let (ends, wide) = width(&all);
                held += usize::from((ends[0]..=ends[1]).contains(&difference));
                sum += wide / PAIRS as f64;
            }
            (held, sum)
        };
        let (_, one) = mean([[6, 0], [6, 0]], [0.0; 2], 0.0);
        let (held, both) = mean([[3, 3], [3, 3]], [-0.02, 0.02], 0.05);
        assert!(held >= 182, "{are_bikes}: {held} of {PAIRS}");
        assert!(both < 1.25 * one, "{are_bikes}: {both} of two, {one} of one");
        // as unequal as the rides may be
        let (held, _) = mean([[5, 1], [2, 4]], [-0.02, 0.02], 0.05);
        assert!(held >= 182, "{are_bikes}, unequal: {held} of {PAIRS}");
        // what one side alone rode does not cancel
        let (_, other) = mean([[6, 0], [3, 3]], [0.0; 2], 0.0);
        assert!(other > 1.2 * one, "{are_bikes}: {other} with another, {one} of one");
    }
}

/// Sides of two motorcycles each, whose tyres differ more than their rides: no number of rides decides, more tyres would.
#[test]
fn tyres_that_differ_within_a_side_limit_a_comparison() {
    let mut random = Random::new(11, "tyres");
    let mut sessions = Vec::new();
    for (side, bike) in [(0, "a1"), (0, "a2"), (1, "b1"), (1, "b2")] {
        for i in 0..12 {
            let value = 1.1 * (0.002 * random.normal()).exp();
            let piece = Piece {
                session: format!("{bike}-{i}"),
                tyre: "rear".into(),
                coefficient: "mf_d".into(),
                unit: "1".into(),
                value,
                source: "own".into(),
                shared: false,
                shift: 0.002 * value,
                ..Piece::default()
            };
            sessions.push(Session {
                bike: bike.into(),
                session: format!("{bike}-{i}"),
                side,
                tyres: [None, Some(format!("tyre {side}"))],
                pieces: vec![piece],
            });
        }
    }
    let limit = |sessions: &[Session]| {
        let found = compare(sessions);
        let difference = found[0].difference.clone().expect("comparable");
        difference.limited_by
    };
    let (by, share) = limit(&sessions);
    assert!(by == "tyres" && share > 0.7, "{by} {share}");
    // of one tyre on each side nothing says how tyres differ
    sessions.retain(|s| s.bike.ends_with('1'));
    assert_eq!(limit(&sessions).0, "rides");
}

/// The output of the bundled archive.
fn output() -> &'static Path {
    static OUT: OnceLock<tempfile::TempDir> = OnceLock::new();
    OUT.get_or_init(|| {
        let folder = tempfile::tempdir().expect("folder");
        let done =
            roadbench(folder.path(), &["run", ARCHIVE, "-o", "out", "-q", "--pages", "none"]);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        folder
    })
    .path()
}

fn roadbench(at: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_roadbench"));
    command.current_dir(at).args(arguments).output().expect("roadbench starts")
}

/// True values by bike, tyre and coefficient.
fn truths() -> BTreeMap<(String, String, String), f64> {
    let folder = PathBuf::from(ARCHIVE).join("truth/coefficients");
    let files = walkdir::WalkDir::new(folder).into_iter().map(|e| e.expect("entry").into_path());
    let files = files.filter(|p| p.extension().is_some_and(|e| e == "parquet"));
    let mut out = BTreeMap::new();
    for row in files.flat_map(|path| read::file_rows::<Truth>(&path).expect("truth")) {
        out.insert((row.bike_id, row.tyre, row.coefficient), row.value);
    }
    for bike in ["archive_01", "archive_02"] {
        for tyre in ["front", "rear"] {
            let of = |c: &str| out[&(bike.to_owned(), tyre.to_owned(), c.to_owned())];
            let stiffness = of("mf_b") * of("mf_c") * of("mf_d");
            out.insert((bike.to_owned(), tyre.to_owned(), "slip_stiffness".to_owned()), stiffness);
        }
    }
    out
}

fn found(a: &str, b: &str) -> Vec<ComparisonRow> {
    let found = compare_sets(&output().join("out"), a, Some(b), false);
    let rows = found.unwrap_or_else(|e| panic!("{a} {b}: {e}")).rows;
    rows.into_iter().filter(|row| row.difference.is_some()).collect()
}

/// One test: the archive is run once.
#[test]
fn the_bundled_archive_is_compared_as_it_is() {
    two_motorcycles_of_the_archive_differ_as_they_do();
    sessions_of_one_motorcycle_do_not_differ();
    the_terminal_has_80_columns_and_the_answer_first();
    rows_are_the_same_as_json_in_a_table_and_of_others();
    unnamed_tyres_are_two_or_one();
}

/// Without names of tyres the sides have two, unless somebody says otherwise: then more cancels.
fn unnamed_tyres_are_two_or_one() {
    let mut random = Random::new(4, "unnamed");
    let mut sessions = drawn(&mut random, [6, 6], 0.0);
    let half = |sessions: &[Session]| {
        let found = compare(sessions);
        let interval = found[0].difference.as_ref().expect("comparable").interval;
        interval[1] - interval[0]
    };
    sessions.iter_mut().for_each(|s| s.tyres = [None, None]);
    let two = half(&sessions);
    sessions.iter_mut().for_each(|s| s.tyres = [Some(String::new()), Some(String::new())]);
    let one = half(&sessions);
    assert!(one < 0.95 * two, "{one} {two}");
}

fn two_motorcycles_of_the_archive_differ_as_they_do() {
    let truths = truths();
    let rows = found("bike=archive_01", "bike=archive_02");
    assert!(rows.len() >= 22, "{}", rows.len());
    let mut wrong = Vec::new();
    for row in &rows {
        let of = |bike: &str| truths[&(bike.to_owned(), row.tyre.clone(), row.coefficient.clone())];
        let (a, b) = (of("archive_01"), of("archive_02"));
        let (truth, ends) = match (row.relative_low, row.relative_high) {
            (Some(low), Some(high)) => (b / a - 1.0, [low, high]),
            // of values below zero the sizes are compared
            _ => (
                if a < 0.0 && b < 0.0 { a - b } else { b - a },
                [row.ci95_low.expect("low"), row.ci95_high.expect("high")],
            ),
        };
        if !(ends[0]..=ends[1]).contains(&truth) {
            wrong.push(format!("{} {}: {truth:.3} not in {ends:.3?}", row.tyre, row.coefficient));
        }
        assert!((0.0..=1.0).contains(&row.probability_larger.expect("P")), "{row:?}");
        assert_eq!(row.cancelled_share, Some(0.0), "other motorcycles share nothing: {row:?}");
    }
    assert!(wrong.len() <= 2, "{wrong:#?}");
    let verdict = |tyre: &str, coefficient: &str| {
        let row = rows.iter().find(|r| r.tyre == tyre && r.coefficient == coefficient);
        row.map(|r| r.verdict.as_str())
    };
    assert_eq!(verdict("front", "effective_rolling_radius"), Some("larger"));
    assert_eq!(verdict("rear", "effective_rolling_radius"), Some("smaller"));
    assert_eq!(verdict("vehicle", "drag"), Some("smaller"));
    assert_eq!(verdict("front", "mf_d"), Some("no difference seen"));
}

/// Sessions of one motorcycle have the same tyres: few comparisons differ, and what they share cancels.
fn sessions_of_one_motorcycle_do_not_differ() {
    let (mut all, mut differ, mut friction) = (0, 0, Vec::new());
    for first in [1, 7] {
        for a in first..first + 6 {
            for b in [a + 1, a + 3].into_iter().filter(|b| *b < first + 6) {
                for row in found(&format!("archive_s{a:04}"), &format!("archive_s{b:04}")) {
                    all += 1;
                    differ += usize::from(row.verdict != "no difference seen");
                    if row.coefficient == "mf_d" {
                        friction.push(row.cancelled_share.expect("a share"));
                    }
                }
            }
        }
    }
    println!("{differ} of {all} differ; peak friction {friction:.2?}");
    assert!(all > 300 && differ * 100 <= 7 * all, "{differ} of {all}");
    friction.sort_by(f64::total_cmp);
    assert!(friction[friction.len() / 2] > 0.3, "{friction:?}");
}

fn the_terminal_has_80_columns_and_the_answer_first() {
    output();
    for sets in [["bike=archive_01", "bike=archive_02"], ["archive_s0001", "archive_s0004"]] {
        let done = roadbench(output(), &["compare", "out", sets[0], sets[1]]);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let text = String::from_utf8_lossy(&done.stdout);
        let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 80).collect();
        assert!(wide.is_empty(), "{wide:#?}");
        let at = |part: &str| text.find(part).unwrap_or_else(|| panic!("{part}: {text}"));
        assert!(at("peak friction") < at("Front tyre"), "{text}");
        assert!(at("B - A") < at("Curves at 1300 N"), "{text}");
        assert!(!text.contains("NaN") && !text.contains("-0.0 "), "{text}");
    }
}

fn rows_are_the_same_as_json_in_a_table_and_of_others() {
    let done = roadbench(
        output(),
        &[
            "compare",
            "out",
            "*s0001,*s0002",
            "bike=archive_01,2026-05-02..",
            "--json",
            "-o",
            "c.parquet",
        ],
    );
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let lines: Vec<ComparisonRow> = String::from_utf8_lossy(&done.stdout)
        .lines()
        .map(|line| serde_json::from_str(line).expect("a row"))
        .collect();
    let table: Vec<ComparisonRow> = read::file_rows(&output().join("c.parquet")).expect("a table");
    let key = |r: &ComparisonRow| (r.tyre.clone(), r.coefficient.clone(), r.verdict.clone());
    assert_eq!(
        lines.iter().map(key).collect::<Vec<_>>(),
        table.iter().map(key).collect::<Vec<_>>()
    );
    assert_eq!((table[0].n_sessions_a, table[0].n_sessions_b), (2, 4));
    // the difference turns round with the sides
    let back = found("bike=archive_01,2026-05-02..", "*s0001,*s0002");
    let of = |rows: &[ComparisonRow], c: &str| {
        let row = rows.iter().find(|r| r.coefficient == c).expect("a row");
        row.relative.expect("one sign").ln_1p()
    };
    assert!((of(&back, "drag") + of(&table, "drag")).abs() < 1e-9);
}
