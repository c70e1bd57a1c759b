//! What changed on a motorcycle, on its page: events of coefficients and the comparison of rides in one list, and the numbers
//! over the rides. The rides are drawn, so that the truth is known: the rear tyre is another from the eighth ride on, and wind
//! blows on the fourth.

use std::path::Path;

use roadbench::internals::diagnose::reference::{Ride, changes};
use roadbench::internals::report;
use roadbench::internals::statistics::random::Random;
use roadbench::internals::store::tables::file;
use roadbench::internals::store::tables::rows::{
    ChangeRow, Circumstances, Coefficient, EffectTrace, EstimateRow, EventRow, FleetRow, Ident,
    PooledRow, SessionRow, Status,
};

const RIDES: usize = 12;
/// The first ride on another rear tyre.
const SWAP: usize = 7;
/// The ride in the wind.
const WINDY: usize = 3;
const HOSTILE: &str = "</svg><b onmouseover=alert(1)>";
/// Numbers of the comparison of rides: part, name, unit, usual value, standard error.
const NUMBERS: [(&str, &str, &str, f64, f64); 5] = [
    ("effect", "wind", "m/s", 0.4, 0.1),
    ("effect", "road_grade", "1", 0.001, 2e-4),
    ("nominal", "radius_rear", "m", 0.3, 1e-4),
    ("nominal", "mf_d_rear", "1", 1.1, 0.01),
    ("nominal", "drag", "kg/m", 0.3, 0.01),
];

fn ident(k: usize) -> Ident {
    Ident {
        session_id: if k == WINDY { HOSTILE.to_owned() } else { format!("s{k:02}") },
        bike_id: "a".into(),
        start_time: Some(format!("2026-05-{:02}T10:00:00Z", k + 1)),
    }
}

fn ride(k: usize) -> Ride {
    let mut random = Random::new(7, &format!("ride {k}"));
    let estimates = NUMBERS.map(|(part, parameter, unit, usual, std_error)| {
        let shift = match parameter {
            "wind" if k == WINDY => 30.0,
            "radius_rear" if k >= SWAP => 40.0,
            _ => 0.0,
        };
        EstimateRow {
            ident: ident(k),
            parameter: parameter.into(),
            part: part.into(),
            unit: unit.into(),
            value: usual + std_error * (random.normal() + shift),
            std_error,
        }
    });
    let trace = |name: &str| EffectTrace {
        ident: ident(k),
        effect: name.into(),
        parameter: name.into(),
        slope: 1.0,
    };
    Ride {
        ident: ident(k),
        circumstances: Circumstances::default(),
        estimates: estimates.to_vec(),
        traces: vec![trace("wind"), trace("road_grade")],
    }
}

/// Writes the tables of both commands into one output; the rows of `changes`.
fn generate(out: &Path) -> Vec<ChangeRow> {
    let write = |name: &str, write: &dyn Fn(&Path) -> Result<(), file::Error>| {
        write(&out.join(name).join("all.parquet")).expect(name);
    };
    let rides: Vec<Ride> = (0..RIDES).map(ride).collect();
    let estimates: Vec<EstimateRow> = rides.iter().flat_map(|r| r.estimates.clone()).collect();
    let found = changes(rides);
    let radius = |k: usize| if k >= SWAP { 0.304 } else { 0.3 };
    let session = |k: usize| SessionRow {
        ident: ident(k),
        duration: 600.0,
        tyre_rear: Some(if k >= SWAP { "soft" } else { "hard" }.into()),
        ..SessionRow::default()
    };
    let coefficient = |k: usize| Coefficient {
        ident: ident(k),
        tyre: "rear".into(),
        coefficient: "effective_rolling_radius".into(),
        unit: "m".into(),
        value: Some(radius(k)),
        std_error: Some(1e-4),
        status: Status::Ok,
        ..Coefficient::default()
    };
    let pooled = |k: usize| PooledRow {
        bike_id: "a".into(),
        session_id: ident(k).session_id,
        tyre: "rear".into(),
        coefficient: "effective_rolling_radius".into(),
        unit: "m".into(),
        status: Status::Ok,
        value: radius(k),
        std_error: 1e-4,
        ..PooledRow::default()
    };
    let fleet = FleetRow {
        bike_id: "a".into(),
        tyre: "rear".into(),
        coefficient: "effective_rolling_radius".into(),
        unit: "m".into(),
        n_sessions: RIDES as i64,
        ..FleetRow::default()
    };
    let event = EventRow {
        bike_id: "a".into(),
        kind: "tyre_swap".into(),
        tyre: "rear".into(),
        coefficients: "rear effective_rolling_radius".into(),
        first_session: ident(SWAP).session_id,
        last_session: ident(RIDES - 1).session_id,
        first_time: ident(SWAP).start_time,
        n_sessions: (RIDES - SWAP) as i64,
        size: Some(0.0133),
        evidence: 40.0,
        reason: "one axle has another level from here on: another tyre".into(),
        ..EventRow::default()
    };
    let all = || 0..RIDES;
    write("sessions", &|p| file::write(p, &all().map(session).collect::<Vec<_>>()));
    write("coefficients", &|p| file::write(p, &all().map(coefficient).collect::<Vec<_>>()));
    write("fleet_pooled", &|p| file::write(p, &all().map(pooled).collect::<Vec<_>>()));
    write("fleet", &|p| file::write(p, std::slice::from_ref(&fleet)));
    write("fleet_events", &|p| file::write(p, std::slice::from_ref(&event)));
    write("estimates", &|p| file::write(p, &estimates));
    write("changes", &|p| file::write(p, &found));
    found
}

fn page(out: &Path, name: &str) -> String {
    std::fs::read_to_string(out.join("report").join(name)).expect(name)
}

/// Text as a page has it: escaped, with the minus sign of print.
fn shown(sentence: &str) -> String {
    let escaped = sentence.replace('\'', "&#x27;").replace('/', "&#x2f;");
    escaped.replace(" -", " \u{2212}").replace("(-", "(\u{2212}")
}

#[test]
fn both_ways_stand_in_one_list_in_order_of_date() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    let rows = generate(out);
    report::write(out).expect("report");
    let is_change = |r: &&ChangeRow| ["named", "changed", "ambiguous"].contains(&&*r.verdict);
    let found: Vec<&ChangeRow> = rows.iter().filter(is_change).collect();
    let [wind, radius] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(
        (wind.cause.as_deref(), radius.cause.as_deref()),
        (Some("wind"), Some("radius_rear"))
    );
    let html = page(out, "bike_a.html");
    // the list has the wind first, and one entry for the tyre with what both ways say
    let list = html.split_once("<ul class=\"findings\">").expect("a list").1;
    let list = list.split_once("</ul>").expect("its end").0;
    let entries: Vec<&str> = list.split("<li>").skip(1).collect();
    let [first, second] = &entries[..] else { panic!("{list}") };
    assert!(first.contains(&shown(&wind.sentence)), "{first}");
    assert!(first.contains("comparison of rides") && !first.contains(">coefficients<"), "{first}");
    assert!(second.contains(&shown(&radius.sentence)), "{second}");
    let event = "the rear rolling radius differs by 1.330 % (1.265 to 1.395) from the 7 rides before, as if another rear tyre \
                 was fitted";
    assert!(second.contains(event), "{second}");
    // the cause comes first, from the way that knows it; numbers are evidence, which is folded
    for (entry, cause) in [(first, "wind"), (second, "rear tyre changed")] {
        assert!(entry.contains(&format!(": <b>{cause}</b>")), "{entry}");
        assert!(entry.contains("<details class=\"evidence\"><summary>"), "{entry}");
    }
    assert!(
        second.contains("comparison of rides") && second.contains(">coefficients<"),
        "{second}"
    );
    assert!(second.contains("since s07 (2026-05-08"), "{second}");
    // what only the coefficients' way says: the tyre that the log names
    assert!(second.contains("Since s07 (2026-05-08, rear tyre soft)."), "{second}");
    // one sentence on every page
    for name in ["index.html", "fleet.html"] {
        let other = page(out, name);
        assert!(other.contains(&shown(&radius.sentence)) && other.contains(event), "{name}");
        assert!(other.contains("href=\"bike_a.html\""), "{name}");
    }
    assert!(!html.contains("<b onmouseover"), "a log's text became markup");
}

#[test]
fn numbers_that_moved_are_drawn_and_the_others_folded() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    report::write(folder.path()).expect("report");
    let html = page(folder.path(), "bike_a.html");
    let figures: Vec<&str> = html.split("<figure class=\"timeline\">").skip(1).collect();
    let drawn = |key: &str| {
        let code = format!("<code>{key}</code>");
        figures.iter().find(|f| f.contains(&code)).copied()
    };
    let wind = drawn("wind").expect("the wind");
    assert_eq!(wind.matches("<circle class=\"hit\"").count(), RIDES);
    let odd = |figure: &str| {
        let path = figure.split_once("class=\"rides odd\" d=\"").expect("rides").1;
        path.split('"').next().expect("a path").matches('M').count()
    };
    assert_eq!(odd(wind), 1);
    assert!(wind.contains("text-anchor=\"start\">wind</text>"), "{wind}");
    // the coefficient and the number of the nominal model, each with the rides on the new tyre
    for key in ["rear effective_rolling_radius", "radius_rear"] {
        let figure = drawn(key).expect(key);
        assert_eq!(odd(figure), RIDES - SWAP, "{key}");
        assert!(figure.contains("Rear rolling radius, mm"), "{key}");
    }
    // the numbers without a shift are folded, each with its strip; numbers of the nominal model come first
    let (before, rest) = html.split_once("<h3>What did not move</h3>").expect("a list");
    let folded = rest.split_once("</details>").expect("its end").0;
    let keys: Vec<&str> = folded
        .split("<code>")
        .skip(1)
        .filter_map(|part| Some(part.split_once("</code>")?.0))
        .collect();
    assert_eq!(keys, ["drag", "mf_d_rear", "road_grade"]);
    assert!(folded.contains("3 numbers of the comparison of rides"), "{folded}");
    assert_eq!(folded.matches("<svg").count(), keys.len());
    let is_before = |key: &&str| before.contains(&format!("<code>{key}</code>"));
    assert!(!keys.iter().any(is_before), "{before}");
    // the fold is closed when the page opens
    assert!(before.ends_with("<details class=\"fold more\"><summary>"), "{before}");
}

/// A motorcycle that is only diagnosed has the page, too.
#[test]
fn the_comparison_alone_has_a_page() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    for table in ["sessions", "coefficients", "fleet", "fleet_pooled", "fleet_events"] {
        std::fs::remove_dir_all(out.join(table)).expect(table);
    }
    // by this an output of `diagnose` is known
    std::fs::create_dir_all(out.join("discrepancies")).expect("a folder");
    report::write(out).expect("report");
    let html = page(out, "bike_a.html");
    assert!(html.contains("<code>radius_rear</code>") && !html.contains("id=\"coefficients\""));
    assert!(page(out, "index.html").contains("<a href=\"bike_a.html\">a</a>"));
}
