//! The report of a made-up run: two bikes, three sessions, one rejected input, and hostile
//! text wherever a log could put it.

use std::path::{Path, PathBuf};

use crate::page;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::coefficient::Coefficient as C;
use roadbench::internals::report::export::fitted::Fitted;
use roadbench::internals::report::export::reduced;
use roadbench::internals::report::export::tyre::{Characterised, Setting};
use roadbench::internals::report::plots::catalogue;
use roadbench::internals::report::{page_names, tables, terminal};
use roadbench::internals::store::tables::file;
use roadbench::internals::store::tables::rows::{
    Coefficient, Ident, Manoeuvre, PlotPoint, Provenance, Rejected, SessionRow, Status, WarningRow,
};

const HOSTILE: &str = "</script><b onmouseover=alert(1)>&\"'";

/// Deterministic noise in -1 … 1.
fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

fn ident(bike: &str, session: &str) -> Ident {
    Ident {
        session_id: session.into(),
        bike_id: bike.into(),
        start_time: Some("2024-05-03T10:11:12Z".into()),
    }
}

fn provenance() -> Provenance {
    Provenance {
        input_hash: "ab".repeat(32),
        pipeline_hash: "cd".repeat(32),
        version: "0.1".into(),
    }
}

fn session(ident: &Ident, note: &str) -> SessionRow {
    SessionRow {
        ident: ident.clone(),
        path: format!("logs/{note}.parquet"),
        duration: 751.0,
        rate: 100.0,
        n_samples: 75_100,
        distance: Some(14_203.0),
        channels: "velocity_x,velocity_y,acceleration_x,acceleration_y,roll,roll_rate,yaw_rate,\
                   steer_angle,wheel_speed_front,wheel_speed_rear,brake_pressure_front"
            .into(),
        n_manoeuvres: 40,
        n_used: 31,
        n_coefficients_ok: 19,
        n_warnings: 2,
        tyre_front: Some("Sportec 120/70 R17".into()),
        tyre_rear: Some(format!("Sportec 180/55 {note}")),
        site: Some("handling track".into()),
        rider_id: None,
        provenance: provenance(),
    }
}

fn coefficients(ident: &Ident, note: &str, turn: usize) -> Vec<Coefficient> {
    let mut rows = Vec::new();
    for tyre in ["front", "rear", "vehicle"] {
        let road = C::ALL.iter().filter(|c| c.is_onroad());
        for (i, c) in road.enumerate() {
            let vehicle = matches!(c, C::Drag | C::RollingResistance);
            if vehicle != (tyre == "vehicle") {
                continue;
            }
            let (value, unit, symbol) = match c {
                C::EffectiveRollingRadius => (0.2987, "m", "R_rol"),
                C::PeakSlip => (-0.142, "1", "s_max"),
                C::MfB => (14.2, "1", "b"),
                C::MfC => (1.41, "1", "c"),
                C::MfD => (1.18, "1", "d"),
                C::MfE1 => (-0.6, "1", "e_1"),
                C::MfE2 => (0.08, "1", "e_2"),
                C::SlipStiffnessLoad => (0.2, "1", "k_s,N"),
                C::SlipCamberC1 => (-0.0279, "1", "c_1"),
                C::SlipCamberC3 => (0.0113, "1/rad2", "c_3"),
                C::LateralFrictionCt => (-0.841, "1", "c_t"),
                C::CorneringStiffness0 => (12.53, "1/rad", "k_alpha0"),
                C::CamberStiffness0 => (1.19, "1/rad", "k_gamma0"),
                C::SideForceRatio => (0.095, "1", "C"),
                C::TwistingStiffness => (0.039, "m/rad", "k_t"),
                C::OverturningStiffness => (0.0583, "m", "k_x"),
                C::RelaxationLength => (0.2987, "m", "r_l"),
                C::PneumaticTrail0 => (0.021, "m", "t_p0"),
                C::Drag => (0.37, "kg/m", "c_drag"),
                _ => (0.0153, "1", "c_rol"),
            };
            let status = match c {
                C::SlipStiffnessLoad
                | C::SideForceRatio
                | C::TwistingStiffness
                | C::RelaxationLength => Status::Assumed,
                C::MfE1 if tyre == "rear" => Status::PoorlyDetermined,
                C::MfE2 => Status::NotAvailable,
                _ => Status::Ok,
            };
            let error = value * (0.01 + 0.01 * (i % 4) as f64);
            let error: f64 = if status == Status::PoorlyDetermined { value } else { error };
            let value = value + error * noise(31 * turn + i);
            let some = |x: f64| (status != Status::NotAvailable).then_some(x);
            rows.push(Coefficient {
                ident: ident.clone(),
                tyre: tyre.into(),
                coefficient: c.name().into(),
                symbol: symbol.into(),
                value: some(value),
                unit: unit.into(),
                std_error: some(error.abs()),
                ci95_low: some(value - 2.1 * error.abs()),
                ci95_high: some(value + 2.1 * error.abs()),
                dispersion: some(1.7 * error.abs()),
                n_manoeuvres: 6,
                n_samples: 900,
                residual_scale: some(0.04),
                outlier_fraction: some(0.02),
                r_squared: some(0.93),
                status,
                reason: match status {
                    Status::LowerBound => Some("the peak was not reached".into()),
                    Status::Ok => None,
                    Status::Assumed => Some("taken from the bike file".into()),
                    Status::PoorlyDetermined => Some(format!(
                        "the largest slip ridden is -0.06, short of the peak; brake harder with \
                         the rear wheel {note}"
                    )),
                    Status::NotAvailable => {
                        Some("needs braking and driving; this tyre was only braked".into())
                    }
                },
                reason_code: (status == Status::Assumed).then(|| "bike_file".into()),
                provenance: provenance(),
                ..Coefficient::default()
            });
        }
    }
    rows
}

fn manoeuvres(ident: &Ident, note: &str) -> Vec<Manoeuvre> {
    let kinds =
        ["coasting", "front_braking", "rear_braking", "combined_braking", "driving", "cornering"];
    (0..40)
        .map(|i| {
            let kind = kinds[i % kinds.len()];
            let used = i % 5 != 3;
            let left = i % 12 < 6;
            Manoeuvre {
                ident: ident.clone(),
                manoeuvre_id: i as i64,
                kind: kind.into(),
                start: 18.0 * i as f64 + 2.0,
                end: 18.0 * i as f64 + 13.0,
                direction: Some(match (kind, left) {
                    ("cornering", true) => "left".into(),
                    ("cornering", false) => "right".into(),
                    (_, true) => "outbound".into(),
                    (_, false) => "inbound".into(),
                }),
                quality: if used { 0.93 } else { 0.41 },
                used,
                reason: (!used).then(|| format!("too short: 1.1 s of 2 s {note}")),
                speed_start: Some(22.0),
                speed_end: Some(14.5),
                speed_mean: Some(18.0),
                acceleration_x_mean: Some(-0.7),
                acceleration_x_peak: Some(-1.9),
                acceleration_y_peak: Some(0.4),
                roll_peak: Some(if left { -0.6 } else { 0.6 }),
                slip_ratio_front_peak: Some(-0.03),
                slip_ratio_rear_peak: Some(-0.01),
                ..Manoeuvre::default()
            }
        })
        .collect()
}

fn plots(ident: &Ident) -> Vec<PlotPoint> {
    let mut rows = Vec::new();
    let mut put = |plot: &str, series: &str, x: f64, y: f64, half: Option<f64>, weight, m| {
        rows.push(PlotPoint {
            session_id: ident.session_id.as_str().into(),
            bike_id: ident.bike_id.as_str().into(),
            plot: plot.to_owned().into(),
            series: series.to_owned().into(),
            x,
            y: Some(y),
            y_low: half.map(|h| y - h),
            y_high: half.map(|h| y + h),
            weight,
            manoeuvre_id: m,
            shade: weight.map(|_| 1300.0 + 400.0 * x),
            n: weight.map(|_| 3),
            ..PlotPoint::default()
        });
    };
    let magic = |s: f64| {
        let bs = 14.0 * s;
        1.18 * (1.41 * (bs + 0.6 * (bs - bs.atan())).atan()).sin()
    };
    type Curve<'a> = (&'a str, f64, f64, f64, &'a dyn Fn(f64) -> f64);
    let curves: [Curve; 13] = [
        ("friction_x_front", -0.25, 0.02, 0.06, &magic),
        ("friction_x_rear", -0.2, 0.18, 0.06, &magic),
        ("slip_angle_front", -0.75, 0.75, 0.004, &|g| -0.0279 * g + 0.0113 * g.powi(3)),
        ("slip_angle_rear", -0.75, 0.75, 0.004, &|g| -0.0107 * g - 0.02 * g.powi(3)),
        ("friction_y_front", -0.75, 0.75, 0.05, &|g| -0.84 * g.tan()),
        ("friction_y_rear", -0.75, 0.75, 0.05, &|g| -0.885 * g.tan()),
        ("friction_y_slip_front", -0.02, 0.02, 0.05, &|a| 20.0 * a),
        ("friction_y_slip_rear", -0.02, 0.02, 0.05, &|a| 20.0 * a),
        ("g_g", -8.0, 8.0, 3.0, &|_| 0.0),
        ("roll_over_lateral", -8.0, 8.0, 0.02, &|a| -(a / 9.81).atan()),
        ("residual_friction_x_front_over_speed", 5.0, 40.0, 0.02, &|_| 0.0),
        ("coast_down", 20.0, 900.0, 25.0, &|v2| 45.0 + 0.37 * v2),
        ("overturning", -0.75, 0.75, 0.004, &|roll| -0.058 * roll.tan()),
    ];
    for (k, (plot, from, to, sd, curve)) in curves.into_iter().enumerate() {
        for i in 0..600 {
            let n = 1000 * k + i;
            let x = from + (to - from) * (0.5 + 0.5 * noise(n));
            let gross = i % 37 == 0;
            let y = curve(x) + sd * (noise(n + 7) + noise(n + 91)) * if gross { 4.0 } else { 0.7 };
            let weight = if gross { 0.0 } else { 1.0 - 0.3 * noise(n + 5).abs() };
            put(plot, "data", x, y, None, Some(weight), Some((i % 40) as i64));
        }
        for i in 0..=80 {
            let t = i as f64 / 80.0;
            let x = from + (to - from) * t;
            put(plot, "fit", x, curve(x), Some(sd * (0.15 + (t - 0.5).powi(2))), None, None);
        }
    }
    for tyre in ["front", "rear"] {
        for i in 0..=60 {
            let g = -0.75 + 1.5 * f64::from(i) / 60.0;
            let k = 12.5 / (1.0 - 0.4 * g * g);
            put(&format!("stiffness_{tyre}"), "k_alpha", g, k, Some(0.4 + g * g), None, None);
            put(&format!("stiffness_{tyre}"), "k_gamma", g, 0.095 * k, Some(0.1), None, None);
        }
    }
    for i in 0..1500 {
        let t = f64::from(i) * 0.5;
        let wave = (t / 18.0 * std::f64::consts::TAU).sin();
        put("timeline", "velocity_x", t, 18.0 + 6.0 * wave, Some(0.3), None, None);
        put("timeline", "acceleration_x", t, -2.0 * wave, Some(0.6), None, None);
        put("timeline", "roll", t, 0.6 * wave * (t / 40.0).cos(), Some(0.02), None, None);
        put("timeline", "slip_ratio_front", t, -0.02 * wave.max(0.0), Some(0.004), None, None);
        put("timeline", "slip_ratio_rear", t, 0.03 * (-wave).max(0.0), Some(0.006), None, None);
    }
    rows
}

/// Writes an output folder as the batch does.
pub fn generate(out: &Path) {
    let sessions = [
        ("supersport", "2024-05-03_lap-1", "plain"),
        ("supersport", HOSTILE, HOSTILE),
        ("tourer", "../escape", "tour"),
    ];
    for (turn, (bike, name, note)) in sessions.into_iter().enumerate() {
        let ident = ident(bike, name);
        let path = |table: &str| -> PathBuf {
            out.join(table).join(format!("bike={bike}")).join(format!("s{turn}.parquet"))
        };
        let write = |name: &str, write: &dyn Fn(&Path) -> Result<(), file::Error>| {
            write(&path(name)).expect(name);
        };
        write("sessions", &|p| file::write(p, &[session(&ident, note)]));
        write("coefficients", &|p| file::write(p, &coefficients(&ident, note, turn)));
        write("manoeuvres", &|p| file::write(p, &manoeuvres(&ident, note)));
        write("plots", &|p| file::write(p, &plots(&ident)));
        let warning = WarningRow {
            ident: ident.clone(),
            stage: "ingest".into(),
            code: "gap".into(),
            channel: Some("velocity_x".into()),
            count: 3,
            time: Some(12.3),
            message: format!("3 gaps, the longest 0.4 s, left empty {note}"),
        };
        write("warnings", &|p| file::write(p, std::slice::from_ref(&warning)));
    }
    let rejected = Rejected {
        path: format!("logs/{HOSTILE}.csv"),
        session_id: None,
        bike_id: None,
        stage: "ingest".into(),
        code: "missing_column".into(),
        message: format!("column `velocity_x` is missing; the file has {HOSTILE}"),
        input_hash: None,
        version: "0.1".into(),
        limits: None,
    };
    let path = out.join("rejected").join("r.parquet");
    file::write(&path, &[rejected]).expect("rejected");
}

/// Tags that must be closed are, in their order; a plain reading, enough to see a broken page.
fn assert_balanced(html: &str) {
    const VOID: [&str; 6] = ["meta", "link", "br", "img", "col", "input"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        if rest.starts_with('!') {
            let end = if rest.starts_with("!--") { "-->" } else { ">" };
            rest = &rest[rest.find(end).expect("comment closed") + end.len()..];
            continue;
        }
        let closing = rest.starts_with('/');
        let name: String = rest
            .trim_start_matches('/')
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric())
            .collect();
        assert!(
            !name.is_empty(),
            "a bare `<` before {:?}",
            rest.chars().take(40).collect::<String>()
        );
        let end = rest.find('>').expect("tag closed");
        let empty = rest[..end].ends_with('/') || VOID.contains(&name.as_str());
        rest = &rest[end + 1..];
        if closing {
            assert_eq!(open.pop().as_deref(), Some(name.as_str()), "closes what is open");
        } else if name == "script" || name == "style" {
            let close = format!("</{name}>");
            rest = &rest[rest.find(&close).expect("raw text closed") + close.len()..];
        } else if !empty {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

/// Nothing on the page is fetched: every address is a file beside it or a part of it.
fn assert_offline(html: &str) {
    for attribute in ["src=\"", "href=\""] {
        for part in html.split(attribute).skip(1) {
            let address = part.split('"').next().unwrap_or_default();
            let local = address.starts_with('#')
                || (address.ends_with(".html") && !address.contains([':', '/']));
            assert!(local, "{attribute}{address}");
        }
    }
    assert!(!html.contains("@import") && !html.contains("url("), "style fetches something");
}

#[test]
fn a_run_becomes_pages_that_hold_all_they_need() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    roadbench::internals::report::write(out).expect("report");
    let report = out.join("report");
    let mut pages: Vec<PathBuf> =
        std::fs::read_dir(&report).expect("report").map(|e| e.expect("entry").path()).collect();
    pages.retain(|path| path.extension().is_some_and(|e| e == "html"));
    pages.sort();
    assert_eq!(pages.len(), 4, "{pages:?}");
    for path in &pages {
        let html = std::fs::read_to_string(path).expect("page");
        assert_balanced(&html);
        assert_offline(&html);
        assert!(!html.contains("<b onmouseover"), "{} runs a log's text", path.display());
        assert_eq!(html.matches("<script").count(), html.matches("</script>").count());
    }
    let index = std::fs::read_to_string(report.join("index.html")).expect("index");
    assert!(index.contains("3 of 4 logs processed; 1 rejected; 3 warnings."));
    assert!(index.contains("missing_column") && index.contains("&lt;b onmouseover"));
    assert!(index.contains("2024-05-03_lap-1.html"));

    let html = std::fs::read_to_string(report.join("2024-05-03_lap-1.html")).expect("page");
    // 18 of each tyre and 2 of the vehicle, as generated
    assert!(html.contains(
        "27 of 38 coefficients determined; 8 assumed; 1 poorly determined; 2 not available."
    ));
    for plot in &catalogue::FITS {
        assert!(html.contains(plot.title), "{}", plot.title);
    }
    let data = page::data(&html);
    let charts = data["charts"].as_array().expect("charts");
    assert_eq!(charts.len(), catalogue::FITS.len() + 3);
    assert!(catalogue::FITS.iter().all(|p| charts.iter().any(|c| c["name"] == p.name)));
    assert_eq!(data["panels"].as_array().map(Vec::len), Some(4));
    assert_eq!(data["segments"].as_array().map(Vec::len), Some(40));
    assert_eq!(data["charts"][0]["clouds"][0]["x"]["d"].as_array().map(Vec::len), Some(600));

    // the same tables, the same bytes
    let before: Vec<Vec<u8>> = pages.iter().map(|p| std::fs::read(p).expect("page")).collect();
    std::fs::write(report.join("gone.html"), &before[0]).expect("a page of an earlier run");
    std::fs::write(report.join("notes.html"), "mine").expect("a page of the user's own");
    roadbench::internals::report::write(out).expect("report again");
    let after: Vec<Vec<u8>> = pages.iter().map(|p| std::fs::read(p).expect("page")).collect();
    assert!(before == after);
    assert!(!report.join("gone.html").exists(), "a page whose session is gone stays");
    assert!(report.join("notes.html").exists(), "a file that is not ours went");
}

#[test]
fn hostile_ids_stay_in_the_folder() {
    let names =
        page_names::sessions([("tourer", "../escape"), ("supersport", HOSTILE)].into_iter());
    assert!(names.iter().all(|n| !n.contains(['/', '<', '"', '&', '\''])), "{names:?}");
}

#[test]
fn a_folder_without_tables_says_what_to_name() {
    let folder = tempfile::tempdir().expect("folder");
    let message =
        roadbench::internals::report::write(folder.path()).expect_err("no tables").to_string();
    assert!(message.contains("--out"), "{message}");
    assert!(!folder.path().join("report").exists());
}

/// Key and number of every line of a property file.
fn keys(file: &str) -> std::collections::BTreeMap<&str, f64> {
    file.lines()
        .filter_map(|l| l.split('$').next())
        .filter_map(|l| l.split_once('='))
        .filter_map(|(k, v)| Some((k.trim(), v.trim().parse().ok()?)))
        .collect()
}

/// The Magic Formula 6.2 of Pacejka (2012), 4.3.2, as a reader of the file evaluates it:
/// written here from the book, not from the exporter. Pure longitudinal force (4.E9-4.E18).
fn longitudinal(k: &std::collections::BTreeMap<&str, f64>, slip: f64, load: f64) -> f64 {
    let dfz = (load - k["FNOMIN"]) / k["FNOMIN"];
    let x = slip + k["PHX1"] + k["PHX2"] * dfz;
    let c = k["PCX1"];
    let d = (k["PDX1"] + k["PDX2"] * dfz) * load;
    let e = (k["PEX1"] + k["PEX2"] * dfz + k["PEX3"] * dfz * dfz) * (1.0 - k["PEX4"] * x.signum());
    let stiffness = load * (k["PKX1"] + k["PKX2"] * dfz) * (k["PKX3"] * dfz).exp();
    let b = stiffness / (c * d);
    let bx = b * x;
    d * (c * (bx - e * (bx - bx.atan())).atan()).sin() + load * (k["PVX1"] + k["PVX2"] * dfz)
}

/// Pure lateral force, 4.E19-4.E30.
fn lateral(k: &std::collections::BTreeMap<&str, f64>, alpha: f64, camber: f64, load: f64) -> f64 {
    let fz0 = k["FNOMIN"];
    let dfz = (load - fz0) / fz0;
    let g2 = camber * camber;
    let stiffness =
        k["PKY1"] * fz0 * (k["PKY4"] * (load / ((k["PKY2"] + k["PKY5"] * g2) * fz0)).atan()).sin()
            / (1.0 + k["PKY3"] * g2);
    let camber_stiffness = load * (k["PKY6"] + k["PKY7"] * dfz);
    let sv = load * camber * (k["PVY3"] + k["PVY4"] * dfz);
    let sh = (k["PHY1"] + k["PHY2"] * dfz) + (camber_stiffness * camber - sv) / stiffness;
    let c = k["PCY1"];
    let d = load * (k["PDY1"] + k["PDY2"] * dfz) / (1.0 + k["PDY3"] * g2);
    let b = stiffness / (c * d);
    let x = b * (alpha + sh);
    d * (c * (x - k["PEY1"] * (x - x.atan())).atan()).sin() + sv
}

#[test]
fn a_property_file_gives_the_fitted_tyre_back() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let mut fitted =
        Fitted::read(folder.path(), "2024-05-03_lap-1", None).expect("the session is there");
    let e2 = 0.08;
    for c in &mut fitted.coefficients {
        if c.coefficient == "mf_e2" {
            c.value = Some(e2);
        }
    }
    let get = |c: C| fitted.value(Axle::Front, c).unwrap_or_else(|_| panic!("{}", c.name())).0;
    let (b, c, d, e1) = (get(C::MfB), get(C::MfC), get(C::MfD), get(C::MfE1));
    let gain = get(C::SlipStiffnessLoad);
    let file = property_file(&fitted, &Setting::default());
    let k = keys(&file);
    for slip in [-0.3, -0.1, -0.02, 0.05, 0.2] {
        for load in [900.0, 1500.0, 2600.0] {
            // eq. 28 of the paper, with what slip stiffness gains with load
            let bs = b * slip * (1.0 + gain * (load / 1500.0 - 1.0));
            let mu = d * (c * (bs - (e1 + e2 * f64::signum(slip)) * (bs - bs.atan())).atan()).sin();
            let there = longitudinal(&k, slip, load) / load;
            assert!((there - mu).abs() < 1e-5, "slip {slip}, load {load}: {there} against {mu}");
        }
    }
    let (k_alpha, k_gamma) = (get(C::CorneringStiffness0), get(C::CamberStiffness0));
    for load in [1000.0, 1500.0, 3000.0] {
        let h = 1e-5;
        let by_slip = lateral(&k, h, 0.0, load) / load / h;
        let by_camber = lateral(&k, 0.0, h, load) / load / h;
        // eq. 22b: Fy = -k_alpha Fz alpha - k_gamma Fz gamma
        assert!((by_slip / -k_alpha - 1.0).abs() < 0.01, "load {load}: {by_slip}");
        assert!((by_camber / -k_gamma - 1.0).abs() < 0.001, "load {load}: {by_camber}");
    }
    // and the simulator's own reader takes it for what it is
    let tyre =
        roadbench::internals::tyre::tir::parse(&file, "export.tir".as_ref()).expect("a tyre");
    let at = |slip_ratio: f64, slip_angle: f64, camber: f64| {
        let load = 1500.0;
        let out = tyre.forces(&roadbench::internals::tyre::paper::Input {
            slip_ratio,
            slip_angle,
            camber,
            load,
            friction: 1.0,
        });
        [out.force_x / load, out.force_y / load, out.moment_x / load, out.moment_z / load]
    };
    let bs = -0.1 * b;
    let mu = d * (c * (bs - (e1 - e2) * (bs - bs.atan())).atan()).sin();
    assert!((at(-0.1, 0.0, 0.0)[0] - mu).abs() < 1e-5);
    let h = 1e-5;
    assert!((at(0.0, h, 0.0)[1] / h / -k_alpha - 1.0).abs() < 0.01);
    assert!((at(0.0, 0.0, h)[1] / h / -k_gamma - 1.0).abs() < 0.001);
    assert!((at(0.0, 0.0, h)[2] / h / -get(C::OverturningStiffness) - 1.0).abs() < 1e-3);
    assert!((at(0.0, 0.0, h)[3] / h / -get(C::TwistingStiffness) - 1.0).abs() < 1e-3);
    // sigma = K / c_y, Pacejka (2012) 7.2
    let length = k_alpha * k["FNOMIN"] / k["LATERAL_STIFFNESS"];
    assert!((length / get(C::RelaxationLength) - 1.0).abs() < 1e-5);
    assert!(file.contains("assumed: bike file") && file.contains("placeholder"), "{file}");
    assert!(file.contains("$ fitted, 95 %"), "{file}");
}

#[test]
fn the_bike_file_fills_the_static_load() {
    let text = "mass = 260.0\nwheelbase = 1.4\ncg_to_front = 0.7\ncg_height = 0.6\n\
                caster_angle = 0.42\n[front]\nradius = 0.3\nwidth = 0.12\n\
                [rear]\nradius = 0.32\nwidth = 0.18\n";
    let bike = match Bike::parse(text, "supersport", Path::new("supersport.toml")) {
        Ok(bike) => bike,
        Err(e) => panic!("the test's bike file: {e}"),
    };
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let fitted = Fitted::read(folder.path(), "2024-05-03_lap-1", None).expect("session");
    let setting = Setting { bike: Some(&bike), ..Setting::default() };
    let file = property_file(&fitted, &setting);
    // half of 260 kg on each wheel: 260 * 9.80665 / 2 = 1274.8645 N
    assert!((keys(&file)["FNOMIN"] - 1274.8645).abs() < 1e-3, "{file}");
    assert!(file.contains("WIDTH                = 0.12 "), "{file}");
}

#[test]
fn toml_export_reads_back_with_intervals_and_hostile_texts() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let fitted = Fitted::read(folder.path(), HOSTILE, None).expect("session");
    let text = fitted.to_toml(None, &[]).expect("toml");
    let table: toml::Table = text.parse().expect("valid TOML");
    assert_eq!(table["session"]["session_id"].as_str(), Some(HOSTILE));
    let entry = &table["front"]["cornering_stiffness_0"];
    let (row_value, row) = fitted.value(Axle::Front, C::CorneringStiffness0).expect("value");
    assert_eq!(entry["value"].as_float(), Some(row_value));
    assert_eq!(entry["ci95_high"].as_float(), row.ci95_high);
    assert_eq!(entry["status"].as_str(), Some("ok"));
    assert!(table["front"]["mf_e2"].get("value").is_none());
    assert!(table["front"]["mf_e2"]["reason"].as_str().is_some());
    assert_eq!(table["vehicle"]["drag"]["unit"].as_str(), Some("kg/m"));
    let one: toml::Table = fitted.to_toml(Some("rear"), &[]).expect("rear").parse().expect("TOML");
    assert!(one.contains_key("rear") && !one.contains_key("front"));
}

#[test]
fn export_says_what_is_missing() {
    let folder = tempfile::tempdir().expect("folder");
    generate(folder.path());
    let message =
        Fitted::read(folder.path(), "2024-05-03_lap-2", None).expect_err("no session").to_string();
    assert!(message.contains("did you mean `2024-05-03_lap-1`"), "{message}");
    let mut fitted = Fitted::read(folder.path(), "../escape", Some("tourer")).expect("session");
    for c in fitted.coefficients.iter_mut().filter(|c| c.coefficient == "mf_b") {
        c.value = None;
        c.status = Status::NotAvailable;
        c.reason = Some("no braking".into());
    }
    // half of a tyre is written as such, nothing of one is not
    let rear = |fitted: &Fitted| Characterised::new(fitted, Axle::Rear, &Setting::default());
    let half = rear(&fitted).expect("the lateral half");
    let (file, _) = reduced::write(&fitted, &half, &Setting::default()).expect("a file");
    assert!(file.contains("USE_MODE             = 12.0") && !file.contains("PCX1"), "{file}");
    assert!(half.missing_half().is_some_and(|m| m.contains("longitudinal")));
    for c in fitted.coefficients.iter_mut().filter(|c| c.coefficient == "slip_camber_c1") {
        c.value = None;
    }
    let message = rear(&fitted).expect_err("mf_b is missing").to_string();
    assert!(message.contains("`mf_b`") && message.contains("no braking"), "{message}");
}

/// The reduced property file of the front tyre.
fn property_file(fitted: &Fitted, setting: &Setting<'_>) -> String {
    let tyre = Characterised::new(fitted, Axle::Front, setting).expect("a tyre");
    reduced::write(fitted, &tyre, setting).expect("tir").0
}

/// Keeps a generated folder to look at: `ROADBENCH_REPORT_DEMO=<folder> cargo test demo -- --ignored`.
#[test]
#[ignore = "writes a folder to look at"]
fn demo() {
    let out = std::env::var("ROADBENCH_REPORT_DEMO").expect("ROADBENCH_REPORT_DEMO");
    generate(Path::new(&out));
    roadbench::internals::report::write(Path::new(&out)).expect("report");
    let sessions = tables::sessions(Path::new(&out)).expect("sessions");
    let coefficients = tables::coefficients(Path::new(&out)).expect("coefficients");
    let rejected = tables::rejected(Path::new(&out)).expect("rejected");
    let own = |c: &&Coefficient| c.ident.key() == sessions[1].ident.key();
    let own: Vec<Coefficient> = coefficients.iter().filter(own).cloned().collect();
    println!("{}", terminal::summary(&sessions[1], &own, &[], 100));
    let summary = terminal::batch_summary(&sessions, &coefficients, &rejected, &[], 0, (12.3, 100));
    println!("{summary}");
}
