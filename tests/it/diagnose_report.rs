//! The report of made-up diagnoses: one of each verdict, with hostile text wherever a log could put
//! it.

use std::path::Path;

use roadbench::internals::contract::verdict::{UNEXPLAINED, Verdict};
use roadbench::internals::report;
use roadbench::internals::store::tables::file;
use roadbench::internals::store::tables::rows::{
    CauseRow, DiscrepancyRow, Ident, SimulatedSample, SimulationError,
};

const HOSTILE: &str = "</script><b onmouseover=alert(1)>&\"'";

fn ident(session: &str) -> Ident {
    Ident {
        session_id: session.into(),
        bike_id: "tourer".into(),
        start_time: Some("2026-05-03T10:11:12Z".into()),
    }
}

/// A candidate: name, verdict, size with half its interval, unit, score.
fn cause(effect: &str, verdict: &str, size: (f64, f64), unit: &str, score: f64) -> CauseRow {
    CauseRow {
        effect: effect.into(),
        verdict: verdict.into(),
        level: "session".into(),
        parameter: effect.into(),
        value: Some(size.0),
        unit: unit.into(),
        ci95_low: Some(size.0 - size.1),
        ci95_high: Some(size.0 + size.1),
        score,
        false_alarm_rate: if score > 1.0 { 0.0 } else { 0.6 },
        separate_by: Some("hard braking".into()),
        reason: "within what nulls of this ride show".into(),
        ..CauseRow::default()
    }
}

/// Candidates that nothing speaks for, and two that the ride does not show.
fn rest() -> Vec<CauseRow> {
    let mut rows = vec![
        cause("wind", "not_needed", (0.3, 0.8), "m/s", 0.72),
        cause("road_grade", "not_needed", (0.0004, 0.0009), "1", 0.61),
        cause("rider_lean", "not_needed", (0.01, 0.04), "m/rad", 0.5),
        cause("brake_fade", "not_needed", (-0.01, 0.03), "1", 0.33),
        cause("tyre_warm_up", "not_needed", (0.004, 0.02), "1", 0.3),
        cause("friction_load", "not_needed", (0.02, 0.11), "1", 0.2),
        cause("roll_zero", "not_needed", (0.0003, 0.002), "rad", 0.15),
        cause("radius_load", "not_needed", (0.0002, 0.002), "1/kN", 0.1),
        cause("wheel_inertia", "not_needed", (0.02, 0.3), "1", 0.07),
        cause("lift", "not_identifiable", (0.0, 1.0), "kg/m", 0.0),
        cause("relaxation_length", "not_identifiable", (0.0, 1.0), "m", 0.0),
    ];
    rows[9].separate_by = Some("corners above 30 m/s".into());
    rows[10].separate_by = Some("quick changes of lean".into());
    rows
}

fn misfit(
    channel: &str,
    kind: &str,
    unit: &str,
    rmse: (f64, Option<f64>, f64),
    with: Option<(&str, f64)>,
) -> DiscrepancyRow {
    DiscrepancyRow {
        channel: channel.into(),
        kind: kind.into(),
        unit: unit.into(),
        rmse_base: rmse.0,
        rmse_extended: rmse.1,
        bias: 0.3 * rmse.0,
        noise_floor: rmse.2,
        null_largest: 1.3 * rmse.2,
        structured: with.is_some(),
        covariate: with.map(|w| w.0.into()),
        correlation: with.map(|w| w.1),
        n: 200,
        ..DiscrepancyRow::default()
    }
}

/// Residuals that are wrong by a factor where they are; `named` puts them right.
fn misfits(factor: f64, named: bool) -> Vec<DiscrepancyRow> {
    let after = |x: f64| named.then_some(x);
    let wrong = |name: &'static str, r: f64| (factor > 1.5).then_some((name, r));
    vec![
        misfit("force_x", "coasting", "m/s2", (0.021, after(0.021), 0.020), None),
        misfit("force_x", "front_braking", "m/s2", (0.13, after(0.12), 0.11), None),
        misfit(
            "slip_rear",
            "front_braking",
            "1",
            (0.67 * factor, after(0.71), 0.67),
            wrong("acceleration", -0.9),
        ),
        misfit(
            "lateral_front",
            "cornering",
            "rad",
            (0.0024 * factor, after(0.0026), 0.0024),
            wrong("front_pressure", 0.62),
        ),
        misfit("lateral_rear", "cornering", "rad", (0.0025, after(0.0026), 0.0026), None),
        misfit("roll", "cornering", "m/s2", (0.11, after(0.11), 0.1), None),
        misfit("kinematic_x", "driving", "m/s2", (0.2, after(0.2), 0.21), None),
    ]
}

/// Sines that the nominal model misses by `off` of their size.
fn replays(off: f64, named: bool) -> Vec<SimulatedSample> {
    let channels = [
        ("velocity_x", "m/s", 6.0, 20.0),
        ("velocity_y", "m/s", 0.4, 0.0),
        ("acceleration_x", "m/s2", 4.0, 0.0),
        ("acceleration_y", "m/s2", 6.0, 0.0),
        ("yaw_rate", "rad/s", 0.3, 0.0),
        ("roll", "rad", 0.6, 0.0),
        ("steer_angle", "rad", 0.05, 0.0),
        ("wheel_speed_front", "rad/s", 20.0, 66.0),
        ("wheel_speed_rear", "rad/s", 19.0, 64.0),
    ];
    let mut rows = Vec::new();
    for (manoeuvre, kind) in
        [(3, "front_braking"), (5, "cornering"), (8, "cornering"), (9, "cornering")]
    {
        for (c, (channel, unit, size, mean)) in channels.into_iter().enumerate() {
            for k in 0..70 {
                let t = k as f64 / 10.0;
                let phase = 0.9 * t + c as f64 + manoeuvre as f64;
                let noise = 0.02 * size * (12.9898 * (k + 71 * c) as f64).sin();
                let wrong = off * size * (t / 7.0) * (1.7 * t + c as f64).sin();
                let truth = mean + size * phase.sin();
                rows.push(SimulatedSample {
                    replay_id: manoeuvre,
                    kind: kind.into(),
                    channel: channel.into(),
                    unit: unit.into(),
                    time: 40.0 * manoeuvre as f64 + t,
                    measured: (k % 31 != 30).then_some(truth + noise),
                    base: Some(truth - wrong),
                    extended: named.then_some(truth - 0.15 * wrong),
                    ..SimulatedSample::default()
                });
            }
        }
    }
    rows
}

struct Ride {
    ident: Ident,
    causes: Vec<CauseRow>,
    discrepancies: Vec<DiscrepancyRow>,
    replays: Vec<SimulatedSample>,
    errors: Vec<SimulationError>,
}

/// Errors of the simulation: channel, kind, unit, before, after, the noise-only rms.
fn error(names: [&str; 3], before: f64, after: Option<f64>, floor: f64) -> SimulationError {
    let ratio = after.map(|a| a / before);
    SimulationError {
        channel: names[0].into(),
        kind: names[1].into(),
        unit: names[2].into(),
        rmse_base: before,
        rmse_extended: after,
        noise_floor: floor,
        crps_base: 0.6 * before,
        crps_extended: after.map(|a| 0.6 * a),
        ratio,
        ratio_ci95_low: ratio.map(|r| 0.9 * r),
        ratio_ci95_high: ratio.map(|r| 1.1 * r),
        n: 3,
        ..SimulationError::default()
    }
}

/// `gain`: the errors with the causes, where one is identified.
fn errors(gain: Option<f64>) -> Vec<SimulationError> {
    let after = |before: f64| gain.map(|g| g * before);
    vec![
        error(["velocity_x", "front_braking", "m/s"], 0.8, after(0.8), 0.1),
        error(["steer_angle", "cornering", "rad"], 0.02, after(0.02), 0.001),
        error(["yaw_rate", "cornering", "rad/s"], 0.02, gain.map(|_| 0.02), 0.02),
    ]
}

fn named() -> Ride {
    let mut first = cause("latency", "named", (0.0196, 0.0083), "s", 5.7);
    (first.gain_heldout, first.gain_upper_bound) = (Some(149.0), Some(240.0));
    first.reason = "the velocity comes late: gains 151".into();
    let mut second = cause("steer_zero", "named", (-0.0121, 0.0032), "rad", 2.1);
    second.level = "bike".into();
    let causes = [vec![first, second], rest()].concat();
    Ride {
        ident: ident("named-1"),
        causes,
        discrepancies: misfits(5.0, true),
        replays: replays(0.4, true),
        errors: errors(Some(0.15)),
    }
}

fn ambiguous() -> Ride {
    let mut first = cause("road_bank", "ambiguous", (0.014, 0.004), "rad", 1.8);
    first.equivalent_to = Some("roll_zero, rider_lean".into());
    first.separate_by = Some("corners to both sides".into());
    (first.gain_heldout, first.gain_upper_bound) = (Some(44.0), Some(40.0));
    let causes = [vec![first], rest()].concat();
    Ride {
        ident: ident("ambiguous-1"),
        causes,
        discrepancies: misfits(2.0, true),
        replays: replays(0.2, true),
        errors: errors(Some(1.3)),
    }
}

fn null() -> Ride {
    Ride {
        ident: ident("null-1"),
        causes: rest(),
        discrepancies: misfits(1.0, false),
        replays: replays(0.03, false),
        errors: errors(None),
    }
}

/// Its texts are hostile too.
fn unexplained() -> Ride {
    let mut first = cause(UNEXPLAINED, Verdict::Unexplained.name(), (0.0, 0.0), "1", 1.7);
    (first.value, first.ci95_low, first.ci95_high, first.separate_by) = (None, None, None, None);
    first.reason = format!("lateral_front over speed {HOSTILE}");
    let mut odd = cause(HOSTILE, "not_needed", (1.0, 2.0), HOSTILE, 0.4);
    odd.level = HOSTILE.into();
    let mut discrepancies = misfits(3.0, false);
    discrepancies[2].covariate = Some(HOSTILE.into());
    discrepancies.push(misfit(HOSTILE, HOSTILE, HOSTILE, (1.0, None, 0.0), None));
    let mut replays = replays(0.3, false);
    for row in replays.iter_mut().filter(|r| r.replay_id == 3) {
        (row.kind, row.unit) = (HOSTILE.into(), HOSTILE.into());
    }
    Ride {
        ident: ident(HOSTILE),
        causes: [vec![first, odd], rest()].concat(),
        discrepancies,
        replays,
        errors: vec![error([HOSTILE; 3], 1.0, None, 0.5)],
    }
}

fn store(out: &Path, mut ride: Ride, replays: bool) {
    let file = roadbench::internals::store::tables::names::file_name(&ride.ident.session_id);
    let path = |name: &str| out.join(name).join(format!("bike=tourer/{file}.parquet"));
    for (k, row) in ride.causes.iter_mut().enumerate() {
        (row.ident, row.rank) = (ride.ident.clone(), k as i64 + 1);
    }
    ride.discrepancies.iter_mut().for_each(|r| r.ident = ride.ident.clone());
    ride.replays.iter_mut().for_each(|r| r.ident = ride.ident.clone());
    file::write(path("causes"), &ride.causes).expect("causes");
    file::write(path("discrepancies"), &ride.discrepancies).expect("discrepancies");
    if replays {
        file::write(path("replays"), &ride.replays).expect("replays");
        ride.errors.iter_mut().for_each(|r| r.ident = ride.ident.clone());
        file::write(path("simulation_errors"), &ride.errors).expect("simulation errors");
    }
}

fn generate(out: &Path) {
    for ride in [named(), ambiguous(), null(), unexplained()] {
        store(out, ride, true);
    }
    report::write(out).expect("report");
}

fn read(out: &Path, page: &str) -> String {
    let path = out.join("report").join(page);
    // as a reader sees it: lines and entities do not matter
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[track_caller]
fn says(page: &str, words: &[&str]) {
    for word in words {
        assert!(page.contains(word), "the page lacks: {word}");
    }
}

#[test]
fn the_report_tells_each_verdict_of_a_diagnosis() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let page = read(folder.path(), "diagnosis_named-1.html");
    says(
        &page,
        &[
            "Does the model reproduce this ride, and if not, why?",
            "No, and it is known why.",
            "2 causes are identified:",
            "the velocity comes late",
            "19.6 ms",
            "−0.693°",
            "found over all rides of the bike",
            "acceleration (−0.90)",
            "2 x log-likelihood gain <strong>149</strong>; with every candidate free by 240",
            "Speed while front braking: 0.80 → 0.12 m&#x2f;s (noise only 0.10)",
            "Steering angle while cornering: 1.146 → 0.172° (noise only 0.057)",
            "the one with the largest gain, of 3 of at least 2 s",
            "what is beyond noise; left:",
            "62 % of that",
            "corners above 30 m&#x2f;s",
            "No other candidate explains the ride nearly as well",
            "with the causes",
        ],
    );
    // the largest gains are drawn, then the signal that shows the most wrong residual
    assert!(page.contains("Speed · front braking") && page.contains("Steering angle · cornering"));
    assert!(page.contains("Rear wheel speed · front braking"));
    let page = read(folder.path(), "diagnosis_ambiguous-1.html");
    says(
        &page,
        &[
            "this ride cannot distinguish between several causes",
            "It is one of these:",
            "<strong>the road is banked</strong>",
            "or the roll sensor does not read zero upright",
            "<h3>corners to both sides</h3>",
            "as much as every candidate together",
            "improves with the identified causes by too little to be seen, or not at all",
            "It gets worse in the speed while front braking: 0.80 → 1.04 m&#x2f;s",
        ],
    );
    let page = read(folder.path(), "diagnosis_null-1.html");
    says(
        &page,
        &[
            "Yes, as far as this ride can show.",
            "Nothing is wrong that this ride could show.",
            "The largest score of any candidate is 0.7",
            "No cause is identified, so there is no improvement to show.",
            "Residuals of the model",
        ],
    );
    assert!(!page.contains("with the causes<") && !page.contains("id=\"unexplained\""));
}

#[test]
fn the_report_escapes_what_a_diagnosis_quotes() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let names: Vec<String> = std::fs::read_dir(folder.path().join("report"))
        .expect("report")
        .flatten()
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    let own = names.iter().find(|n| n.starts_with("diagnosis__")).expect("the hostile one's page");
    let page = read(folder.path(), own);
    says(
        &page,
        &[
            "No, and it is not known why.",
            "Something is wrong that no candidate explains: lateral_front over speed &lt;&#x2f;script&gt;",
        ],
    );
    for name in names.iter().filter(|n| n.ends_with(".html")) {
        let page = read(folder.path(), name);
        assert!(!page.contains("<b onmouseover"), "{name}");
        assert!(!page.contains("http://") && !page.contains("src="), "{name} works offline");
    }
}

#[test]
fn a_report_of_diagnoses_alone_has_an_index() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let index = read(folder.path(), "index.html");
    says(
        &index,
        &[
            "Diagnoses of 4 riding sessions",
            "href=\"diagnosis_named-1.html\"",
            "the velocity comes late <span class=\"size\">19.6 ms</span>",
            "or the roll sensor does not read zero upright",
            "no cause that this ride could show",
            ">unexplained<",
        ],
    );
    assert!(!index.contains("Tyre coefficients from"));
    assert!(!index.contains("id=\"sessions\""));
}

#[test]
fn a_report_of_a_diagnosis_does_not_need_replays() {
    let folder = tempfile::tempdir().expect("folder");
    store(folder.path(), named(), false);
    report::write(folder.path()).expect("report");
    let page = read(folder.path(), "diagnosis_named-1.html");
    says(
        &page,
        &[
            "2 causes are identified",
            "Residuals over the whole ride",
            "rear slip for its force",
            "Structured",
        ],
    );
    assert!(!page.contains("uPlot.iife") && !page.contains("data-chart=\""));
    // and the pages of diagnoses that are gone go
    std::fs::remove_dir_all(folder.path().join("causes")).expect("removed");
    std::fs::remove_dir_all(folder.path().join("discrepancies")).expect("removed");
    std::fs::create_dir_all(folder.path().join("rejected")).expect("made");
    report::write(folder.path()).expect("report");
    assert!(!folder.path().join("report/diagnosis_named-1.html").exists());
    let empty = tempfile::tempdir().expect("folder");
    assert!(matches!(report::write(empty.path()), Err(report::Error::NotAnOutput { .. })));
}

/// Keeps a generated folder to look at: `ROADBENCH_REPORT_DEMO=<folder>`.
#[test]
#[ignore = "writes a folder to look at"]
fn diagnosis_report_demo() {
    let out = std::env::var("ROADBENCH_REPORT_DEMO").expect("ROADBENCH_REPORT_DEMO");
    generate(Path::new(&out));
}

#[test]
fn a_ride_that_can_show_nothing_is_not_called_right() {
    use roadbench::internals::report::diagnosis::outcome::{Outcome, outcome};
    assert_eq!(outcome(&rest()), Outcome::Null);
    assert_eq!(outcome(&rest()[9..]), Outcome::Blind);
    assert_eq!(outcome(&[]), Outcome::Unjudged);
}

/// The page said that nothing was wrong, and beneath that a score that no fault-free simulation reached.
#[test]
fn a_score_of_a_cause_that_is_refused_is_not_called_right_and_says_why() {
    use roadbench::internals::report::diagnosis::outcome::{Outcome, outcome};
    let mut causes = rest();
    let why = "beyond what fault-free simulations show, but the joint fit gains too little";
    let late = cause("latency", "not_needed", (0.0202, 0.01), "s", 2.3);
    causes.push(CauseRow { reason: why.into(), ..late.clone() });
    // not enough for a cause
    let quiet = CauseRow { score: 1.3, ..late };
    assert_eq!(outcome(&[rest(), vec![quiet]].concat()), Outcome::Null);
    assert_eq!(outcome(&causes), Outcome::Refused);
    let build = roadbench::internals::report::diagnosis::page::build;
    let page = build(&ident("refused"), &causes, &[], &[]);
    assert!(!page.answer.starts_with("Yes") && !page.verdict.contains("Nothing is wrong"));
    let said = format!("latency: the velocity comes late, 20.2 ms, score 2.3; {why}.");
    assert_eq!(page.remarks, [said]);
    let summary = roadbench::internals::diagnose::summary::session;
    let text = summary(&ident("refused"), &causes, &[], &[], [2.3, 1.75]);
    assert!(text.ends_with(page.remarks[0].trim_end_matches('.')), "{text}");
}

#[test]
fn what_no_candidate_explains_is_not_listed_as_a_candidate() {
    let ride = unexplained();
    let page =
        roadbench::internals::report::diagnosis::page::build(&ride.ident, &ride.causes, &[], &[]);
    let listed: Vec<&str> =
        page.candidates.iter().chain(&page.more).map(|c| c.name.as_str()).collect();
    assert!(listed.len() > 5 && !listed.contains(&UNEXPLAINED), "{listed:?}");
}
