//! The fleet's page, the static figures and the Markdown summary of a made-up fleet: twelve
//! sessions of two bikes, one of which changed its tyre, with hostile texts in its names.

use std::path::Path;

use crate::page;
use roadbench::internals::report;
use roadbench::internals::report::static_figures::write::{self, Format};
use roadbench::internals::report::summary;
use roadbench::internals::store::tables::file;
use roadbench::internals::store::tables::rows::{
    Coefficient, EventRow, FleetRow, Ident, Manoeuvre, PlotPoint, PooledRow, Provenance, RatioRow,
    SessionRow, Status,
};

const HOSTILE: &str = "</script><b onmouseover=alert(1)>|@all";

fn provenance() -> Provenance {
    Provenance {
        input_hash: "ab".repeat(32),
        pipeline_hash: "cd".repeat(32),
        version: "0.1".into(),
    }
}

/// Bike, session, time, tyre on the rear, peak friction.
fn ridden(i: usize) -> (&'static str, String, String, &'static str, f64) {
    let bike = if i < 6 { "one" } else { HOSTILE };
    let name = if i == 7 { HOSTILE.to_owned() } else { format!("s{i:02}") };
    let swapped = i >= 9;
    let value = 1.0 + 0.01 * (i % 3) as f64 + if swapped { 0.3 } else { 0.0 };
    let time = format!("2026-05-{:02}T10:00:00Z", i + 1);
    (bike, name, time, if swapped { "soft" } else { "hard" }, value)
}

fn generate(out: &Path) {
    let write = |name: &str, file: &str, write: &dyn Fn(&Path) -> Result<(), file::Error>| {
        write(&out.join(name).join(file)).expect(name);
    };
    let mut pooled = Vec::new();
    for i in 0..12 {
        let (bike, name, time, tyre, value) = ridden(i);
        let ident =
            Ident { session_id: name.clone(), bike_id: bike.into(), start_time: Some(time) };
        let session = SessionRow {
            ident: ident.clone(),
            path: format!("logs/{name}.parquet"),
            duration: 600.0,
            rate: 100.0,
            n_samples: 60_000,
            distance: Some(9000.0),
            channels: "velocity_x".into(),
            n_manoeuvres: 1,
            n_used: 1,
            n_coefficients_ok: 1,
            n_warnings: 0,
            tyre_front: None,
            tyre_rear: Some(tyre.into()),
            site: None,
            rider_id: None,
            provenance: provenance(),
        };
        let coefficient = Coefficient {
            ident: ident.clone(),
            tyre: "rear".into(),
            coefficient: "mf_d".into(),
            symbol: "d".into(),
            value: Some(value),
            unit: "1".into(),
            std_error: Some(0.02),
            ci95_low: Some(value - 0.04),
            ci95_high: Some(value + 0.04),
            dispersion: Some(0.03),
            n_manoeuvres: 5,
            n_samples: 500,
            residual_scale: None,
            outlier_fraction: None,
            r_squared: None,
            status: Status::Ok,
            reason: None,
            provenance: provenance(),
            ..Coefficient::default()
        };
        pooled.push(PooledRow {
            bike_id: bike.into(),
            session_id: name,
            tyre: "rear".into(),
            coefficient: "mf_d".into(),
            unit: "1".into(),
            status: Status::Ok,
            value,
            std_error: 0.02,
            pooled: value - 0.003,
            pooled_std_error: 0.01,
            pooled_ci95_low: value - 0.02,
            pooled_ci95_high: value + 0.02,
            shrinkage: 0.37,
            ..PooledRow::default()
        });
        let point = |series: &'static str, x: f64, weight: Option<f64>| PlotPoint {
            session_id: ident.session_id.as_str().into(),
            bike_id: bike.into(),
            plot: "friction_x_rear".into(),
            series: series.into(),
            x,
            y: Some(10.0 * x),
            y_low: weight.is_none().then_some(10.0 * x - 0.1),
            y_high: weight.is_none().then_some(10.0 * x + 0.1),
            weight,
            manoeuvre_id: weight.map(|_| 0),
            shade: weight.map(|_| 1200.0 + 100.0 * x),
            n: weight.map(|_| 2),
            ..PlotPoint::default()
        };
        let at = |k: i32| 0.01 * f64::from(k);
        let mut points: Vec<PlotPoint> = (-9..9).map(|k| point("data", at(k), Some(0.9))).collect();
        points.extend((-9..9).map(|k| point("fit", at(k), None)));
        points.extend((0..9).map(|k| PlotPoint {
            plot: "timeline".into(),
            ..point("velocity_x", f64::from(k), None)
        }));
        let manoeuvre = Manoeuvre {
            ident: ident.clone(),
            manoeuvre_id: 0,
            kind: "rear_braking".into(),
            start: 1.0,
            end: 4.0,
            quality: 0.9,
            used: true,
            ..Manoeuvre::default()
        };
        let file = format!("bike={}/s{i}.parquet", i / 6);
        write("sessions", &file, &|p| file::write(p, std::slice::from_ref(&session)));
        write("coefficients", &file, &|p| file::write(p, std::slice::from_ref(&coefficient)));
        write("manoeuvres", &file, &|p| file::write(p, std::slice::from_ref(&manoeuvre)));
        write("plots", &file, &|p| file::write(p, &points));
    }
    let fleet: Vec<FleetRow> = ["one", HOSTILE]
        .into_iter()
        .map(|bike| FleetRow {
            bike_id: bike.into(),
            tyre: "rear".into(),
            coefficient: "mf_d".into(),
            unit: "1".into(),
            n_sessions: 6,
            median: Some(1.01),
            robust_sd: Some(0.015),
            between_sd_settled: Some(0.004),
            drift_settled_per_day: Some(0.0012),
            drift_ci95_low: Some(0.0004),
            drift_ci95_high: Some(0.002),
            n_events: i64::from(bike == HOSTILE),
            ..FleetRow::default()
        })
        .collect();
    let event = EventRow {
        bike_id: HOSTILE.into(),
        kind: "tyre_swap".into(),
        tyre: "rear".into(),
        coefficients: "rear mf_d".into(),
        first_session: "s09".into(),
        last_session: "s11".into(),
        first_time: Some("2026-05-10T10:00:00Z".into()),
        n_sessions: 3,
        size: Some(0.298),
        evidence: 14.2,
        false_alarm_rate: 0.01,
        false_discovery_rate: Some(0.001),
        reason: "only the rear tyre's coefficients moved, and stayed".into(),
    };
    write("fleet", "fleet.parquet", &|p| file::write(p, &fleet));
    write("fleet_pooled", "fleet_pooled.parquet", &|p| file::write(p, &pooled));
    write("fleet_events", "fleet_events.parquet", &|p| {
        file::write(p, std::slice::from_ref(&event))
    });
    let ratio = |bike: &str, ends: Option<(f64, f64)>| RatioRow {
        bike_id: bike.into(),
        tyre: "rear".into(),
        first_session: "s00".into(),
        last_session: "s05".into(),
        n_sessions: 6,
        side_force_ratio: Some(0.0431),
        ci95_low: ends.map(|e| e.0),
        ci95_high: ends.map(|e| e.1),
        cornering_stiffness_0: Some(12.4),
        status: if ends.is_some() { Status::Ok } else { Status::NotAvailable },
        reason: ends.is_none().then(|| format!("all sessions are alike {HOSTILE}")),
        ..RatioRow::default()
    };
    let ratios = [ratio("one", Some((0.0312, 0.0551))), ratio(HOSTILE, None)];
    write("fleet_ratios", "fleet_ratios.parquet", &|p| file::write(p, &ratios));
}

#[test]
fn the_fleet_has_a_page_with_boxes_events_and_links() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    report::write(folder.path()).expect("report");
    let page = folder.path().join("report/fleet.html");
    let html = std::fs::read_to_string(&page).expect("page");
    assert!(html.contains("2 bikes over all their sessions") && html.contains("1 tyre swap."));
    assert!(!html.contains("<b onmouseover"), "a log's text became markup");
    // 29.8 % over 14.2 standard deviations: 4.1 % to each side
    assert!(html.contains("<a href=\"s09.html\">since s09 (2026-05-10, rear tyre soft)</a>"));
    assert!(html.contains(
        "the rear peak friction differs by 29.8 % (25.7 to 33.9) from the 3 rides before, as if another rear tyre was fitted"
    ));
    // one box for the bike that kept its tyre, one for each tyre of the other
    assert_eq!(html.matches("<svg class=\"boxes\"").count(), 3);
    assert!(html.contains("<td>hard</td>") && html.contains("<td>soft</td>"));
    // the drift's interval leaves out zero: per 100 days
    assert!(html.contains("<strong>0.120 (0.040 to 0.200)</strong>"), "drift");
    // a side force ratio with its interval, or the reason why there is none
    let text = html.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("id=\"ratios\"") && text.contains("0.043</td>"), "the ratio");
    assert!(text.contains("0.031 to 0.055</td>") && text.contains("</span> determined</span>"));
    assert!(text.contains("</span> not available: all sessions are alike &lt;"), "the reason");
    let data = page::data(&html);
    let charts = data["charts"].as_array().expect("charts");
    assert_eq!(charts.len(), 2, "the event's coefficient, and the main one of the other bike");
    assert_eq!(charts[0]["spans"][0]["label"], "tyre swap");
    assert_eq!(charts[0]["clouds"][0]["h"][0], "s06.html");
    assert_eq!(charts[0]["time"], true);
    let index = std::fs::read_to_string(folder.path().join("report/index.html")).expect("index");
    assert!(index.contains("<a href=\"fleet.html\">The fleet over time</a>: 1 event."));

    // once the tables are gone the page goes too
    std::fs::remove_dir_all(folder.path().join("fleet")).expect("removed");
    report::update(folder.path()).expect("again");
    assert!(!page.exists());
}

#[test]
fn every_plot_becomes_a_figure() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let to = folder.path().join("figures");
    let count = write::figures(folder.path(), &to, Format::Svg, None).expect("figures");
    let files: Vec<_> = walkdir::WalkDir::new(&to)
        .into_iter()
        .map(|e| e.expect("entry"))
        .filter(|e| e.file_type().is_file() && !e.file_name().as_encoded_bytes().starts_with(b"."))
        .collect();
    assert_eq!(files.len(), count);
    // a fit and a time line of twelve sessions; two histories and one comparison of the fleet
    assert_eq!(count, 12 * 2 + 2 + 1);
    assert!(to.join("s00/friction_x_rear.svg").exists() && to.join("s00/timeline.svg").exists());
    assert!(to.join("fleet/rear_mf_d.svg").exists());
    for file in files {
        let svg = std::fs::read_to_string(file.path()).expect("figure");
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("<b onmouseover") && !svg.contains("<script"));
    }
    // the figures of a session that is gone go, and nothing of anybody else
    let (gone, mine) = (to.join("s99/timeline.svg"), to.join("s00/mine.svg"));
    let mut there = std::fs::read_dir(&to).expect("folder").map(|e| e.expect("entry").path());
    let list = there.find(|p| p.is_file()).expect("the list of figures");
    let listed = std::fs::read_to_string(&list).expect("list");
    assert_eq!(listed.lines().count(), count);
    std::fs::write(&list, listed + "s99/timeline.svg\n").expect("list");
    for file in [&gone, &mine] {
        std::fs::create_dir_all(file.parent().expect("folder")).expect("folder");
        std::fs::write(file, "a figure").expect("figure");
    }
    write::figures(folder.path(), &to, Format::Svg, None).expect("figures");
    assert!(!to.join("s99").exists() && mine.exists() && to.join("s00/timeline.svg").exists());
}

/// Width, height and RGBA of a PNG file.
fn decoded(file: &Path) -> (u32, u32, Vec<u8>) {
    let bytes = std::fs::File::open(file).expect("a PNG");
    let mut reader = png::Decoder::new(std::io::BufReader::new(bytes)).read_info().expect("head");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let frame = reader.next_frame(&mut pixels).expect("pixels");
    assert_eq!(frame.color_type, png::ColorType::Rgba);
    (frame.width, frame.height, pixels)
}

#[test]
fn figures_are_pixels_where_that_is_asked_for() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let both = folder.path().join("both");
    let one = write::figures(folder.path(), &both, Format::Both, Some("s03"));
    assert_eq!(one.expect("figures of one session"), 2);
    for name in ["friction_x_rear", "timeline"] {
        let svg = std::fs::read_to_string(both.join(format!("s03/{name}.svg"))).expect("figure");
        let size = |what: &str| -> f64 {
            let rest = svg.split_once(&format!(" {what}=\"")).expect(what).1;
            rest.split('"').next().and_then(|n| n.parse().ok()).expect(what)
        };
        let (width, height, pixels) = decoded(&both.join(format!("s03/{name}.png")));
        let wanted = [3.0 * size("width"), 3.0 * size("height")].map(|n| n.ceil() as u32);
        assert_eq!([width, height], wanted, "{name}");
        assert!(width >= 1800, "{name}: {width}");
        let drawn = pixels.chunks_exact(4).filter(|p| p[..3] != [255; 3]).count();
        assert!(drawn > 10_000, "{name}: {drawn} pixels that are not white");
        assert!(pixels.chunks_exact(4).all(|p| p[3] == 255), "{name}: nothing shines through");
    }
    let pixels = folder.path().join("pixels");
    write::figures(folder.path(), &pixels, Format::Png, Some("s03")).expect("figures");
    assert!(pixels.join("s03/timeline.png").exists() && !pixels.join("s03/timeline.svg").exists());
}

#[test]
fn the_summary_is_markdown_without_the_logs_markup() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let text = summary::markdown(folder.path()).expect("summary");
    assert!(text.starts_with("# Tyre coefficients from 12 riding sessions\n"), "{text}");
    assert!(text.contains("| peak friction coefficient | 1.01"), "{text}");
    assert!(text.contains("| tyre swap, rear | s09 | 3 | +29.8 % |"), "{text}");
    assert!(text.contains("&lt;/script&gt;&lt;b onmouseover=alert(1)&gt;\\|&#64;all"), "{text}");
    // every line of a table has the cells of its head
    for table in text.split("\n\n").filter(|part| part.starts_with("| ")) {
        let cells = |line: &str| line.replace("\\|", "").matches('|').count();
        let first = cells(table.lines().next().expect("head"));
        assert!(table.lines().all(|line| cells(line) == first), "{table}");
    }
}
