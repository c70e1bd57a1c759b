//! The report of a large archive: short pages however many bikes and sessions there are, and pages of
//! sessions that are written when somebody asks for one.

use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use roadbench::internals::report::{self, Pages};
use roadbench::internals::store::tables::file;
use roadbench::internals::store::tables::rows::{
    Coefficient, EventRow, FleetRow, Ident, PooledRow, Provenance, SessionRow, Status,
};

const HOSTILE: &str = "</script><b onmouseover=alert(1)>'\"";
const BIKES: usize = 200;
/// Of each bike.
const SESSIONS: usize = 6;

fn name(bike: usize, session: usize) -> String {
    match (bike, session) {
        (0, 0) => HOSTILE.to_owned(),
        _ => format!("ride_{bike:03}_{session}"),
    }
}

fn coefficients() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of = ["mf_b", "mf_c", "mf_d", "cornering_stiffness_0", "camber_stiffness_0", "mf_e1"];
    ["front", "rear"].into_iter().flat_map(move |tyre| of.map(|c| (tyre, c)))
}

/// Writes the tables of an archive, one file per bike.
fn generate(out: &Path) {
    let write = |name: &str, file: &str, write: &dyn Fn(&Path) -> Result<(), file::Error>| {
        write(&out.join(name).join(file)).expect(name);
    };
    let (mut fleet, mut pooled, mut events) = (Vec::new(), Vec::new(), Vec::new());
    for b in 0..BIKES {
        let bike = format!("bike_{b:03}");
        let (mut sessions, mut rows) = (Vec::new(), Vec::new());
        for s in 0..SESSIONS {
            let ident = Ident {
                session_id: name(b, s),
                bike_id: bike.clone(),
                start_time: Some(format!("2026-05-{:02}T10:00:00Z", s + 1)),
            };
            let provenance = Provenance { version: "0.1".into(), ..Provenance::default() };
            sessions.push(SessionRow {
                ident: ident.clone(),
                duration: 600.0 + b as f64,
                distance: Some(9000.0),
                provenance: provenance.clone(),
                ..SessionRow::default()
            });
            for (tyre, coefficient) in coefficients() {
                let value = 1.0 + 0.001 * (b * 7 % 13) as f64 + if b == 77 { 0.5 } else { 0.0 };
                rows.push(Coefficient {
                    ident: ident.clone(),
                    tyre: tyre.into(),
                    coefficient: coefficient.into(),
                    value: Some(value),
                    unit: "1".into(),
                    std_error: Some(0.02),
                    ci95_low: Some(value - 0.04),
                    ci95_high: Some(value + 0.04),
                    status: Status::Ok,
                    provenance: provenance.clone(),
                    ..Coefficient::default()
                });
                pooled.push(PooledRow {
                    bike_id: bike.clone(),
                    session_id: name(b, s),
                    tyre: tyre.into(),
                    coefficient: coefficient.into(),
                    status: Status::Ok,
                    value,
                    std_error: 0.02,
                    pooled: value,
                    ..PooledRow::default()
                });
            }
        }
        for (tyre, coefficient) in coefficients() {
            fleet.push(FleetRow {
                bike_id: bike.clone(),
                tyre: tyre.into(),
                coefficient: coefficient.into(),
                n_sessions: SESSIONS as i64,
                median: Some(1.0 + 0.001 * (b * 7 % 13) as f64 + if b == 77 { 0.5 } else { 0.0 }),
                ..FleetRow::default()
            });
        }
        if b % 3 == 0 {
            events.push(EventRow {
                bike_id: bike.clone(),
                kind: "tyre_swap".into(),
                tyre: "rear".into(),
                coefficients: "rear mf_d".into(),
                first_session: name(b, 2),
                last_session: name(b, 4),
                n_sessions: 3,
                evidence: 9.0,
                ..EventRow::default()
            });
        }
        let file = format!("bike={bike}/all.parquet");
        write("sessions", &file, &|p| file::write(p, &sessions));
        write("coefficients", &file, &|p| file::write(p, &rows));
    }
    write("fleet", "fleet.parquet", &|p| file::write(p, &fleet));
    write("fleet_pooled", "fleet_pooled.parquet", &|p| file::write(p, &pooled));
    write("fleet_events", "fleet_events.parquet", &|p| file::write(p, &events));
}

fn page(out: &Path, name: &str) -> String {
    fs::read_to_string(out.join("report").join(name)).expect(name)
}

/// Elements of a page: `<` and a letter, outside of scripts and styles.
fn elements(html: &str) -> usize {
    let mut rest = html;
    let mut count = 0;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        count += usize::from(rest.starts_with(|c: char| c.is_ascii_alphabetic()));
        for raw in ["script", "style"] {
            if rest.starts_with(raw) {
                rest = &rest[rest.find(&format!("</{raw}>")).expect("closed")..];
            }
        }
    }
    count
}

/// Rows of the lists of a page, unpacked.
fn lists(html: &str) -> Vec<serde_json::Value> {
    html.split("<script type=\"application/octet-stream\">")
        .skip(1)
        .map(|rest| {
            let packed = rest.split("</script>").next().expect("closed");
            let bytes = base64::engine::general_purpose::STANDARD.decode(packed).expect("base64");
            serde_json::from_reader(flate2::read::ZlibDecoder::new(&bytes[..])).expect("JSON")
        })
        .collect()
}

fn session_pages(out: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(out.join("report")).expect("report");
    let own = ["index.html", "fleet.html", "tyres.html"];
    entries
        .map(|e| e.expect("entry").path())
        .filter(|p| p.extension().is_some_and(|e| e == "html"))
        .filter(|p| !p.file_name().is_some_and(|n| own.iter().any(|o| n == *o)))
        .filter(|p| !p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("bike_")))
        .collect()
}

#[test]
fn two_hundred_bikes_and_their_sessions_make_short_pages() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    report::write(out).expect("report");
    assert!(session_pages(out).is_empty(), "pages that nobody asked for");
    let index = page(out, "index.html");
    let most = |html: &str, most: usize, what: &str| {
        let found = elements(html);
        assert!(found < most, "{what}: {found} elements");
    };
    most(&index, 2000, "run");
    most(&page(out, "fleet.html"), 5000, "fleet");
    most(&page(out, "bike_bike_007.html"), 1500, "bike");
    for html in [&index, &page(out, "bike_bike_000.html")] {
        assert!(!html.contains("<b onmouseover"), "a log's text became markup");
        assert!(html.contains("roadbench report OUT --open=SESSION"), "the command");
    }
    // every bike and every session can be found, the first rows without a script
    let [bikes, sessions] = lists(&index).try_into().expect("bikes and sessions");
    assert_eq!(bikes.as_array().map(Vec::len), Some(BIKES));
    assert_eq!(sessions.as_array().map(Vec::len), Some(BIKES * SESSIONS));
    assert_eq!(sessions[0][0]["text"], HOSTILE);
    assert_eq!(
        (&sessions[1][0]["href"], &sessions[1][0]["there"]),
        (&"ride_000_1.html".into(), &false.into())
    );
    assert_eq!(index.matches("<th scope=\"row\"").count(), 20 + 50);
    // changes first, and of the bikes without one the one that is far off
    let place = |bike: &str| {
        let all = bikes.as_array().expect("rows");
        all.iter().position(|row| row[0]["text"] == bike).expect(bike)
    };
    assert!(place("bike_003") < place("bike_077") && place("bike_077") < place("bike_001"));
    let first = bikes[0][0]["text"].as_str().expect("a bike");
    assert!(index.contains(&format!("<a href=\"bike_{first}.html\">{first}</a>")), "{first}");
    // the same tables, the same bytes
    report::write(out).expect("report again");
    assert_eq!(page(out, "index.html"), index);
}

#[test]
fn a_page_that_is_asked_for_is_written_alone_and_linked() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    report::write(out).expect("report");
    let index = page(out, "index.html");
    let made = report::open(out, "ride_003_2", None, Pages::Auto).expect("page");
    assert_eq!(made, out.join("report/ride_003_2.html"));
    assert!(page(out, "ride_003_2.html").contains("12 of 12 coefficients determined"));
    report::open(out, HOSTILE, Some("bike_000"), Pages::Auto).expect("a hostile name");
    assert_eq!(session_pages(out).len(), 2);
    // the run's page is as it was, and looks up which pages there are
    assert_eq!(page(out, "index.html"), index);
    assert!(index.contains("<script src=\"assets/pages.js\">"));
    let written = page(out, "assets/pages.js");
    assert!(
        written.contains("\"ride_003_2.html\"") && !written.contains("ride_003_3"),
        "{written}"
    );
    // asked for again it stays, and it stays over the next report, which links to it
    let at = out.join("report/ride_003_2.html");
    fs::write(&at, page(out, "ride_003_2.html") + "<!-- before -->").expect("page");
    crate::report_pages::relist(out);
    report::open(out, "ride_003_2", None, Pages::Auto).expect("page");
    report::write(out).expect("report");
    assert!(page(out, "ride_003_2.html").ends_with("<!-- before -->"));
    assert_eq!(session_pages(out).len(), 2);
    let bike = page(out, "bike_bike_003.html");
    assert!(bike.contains("<a href=\"ride_003_2.html\">") && !bike.contains("ride_003_3.html"));
    let unknown = report::open(out, "ride_003_22", None, Pages::Auto).expect_err("no session");
    assert!(unknown.to_string().contains("did you mean `ride_003_2`"), "{unknown}");
    // without pages the list goes, with all of them too
    report::build(out, Pages::None, true).expect("none");
    assert!(session_pages(out).is_empty() && !out.join("report/assets").exists());
    assert!(!page(out, "index.html").contains("class=\"demand"));
}

#[test]
fn a_page_can_be_asked_for_before_there_is_a_report() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let made = report::open(folder.path(), "ride_199_5", None, Pages::SelfContained).expect("page");
    let html = fs::read_to_string(made).expect("page");
    assert!(html.contains("<h1>ride_199_5</h1>") && !html.contains("assets/"));
    assert!(!folder.path().join("report/assets").exists());
}
