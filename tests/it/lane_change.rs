//! The paper's study as a user does it, and its tables in the book: characterise one motorcycle, ride the lane change
//! on another. `ROADBENCH_BLESS=1 cargo nextest run -E 'test(/^lane_change/)'` writes the table anew.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::PeakRow;

/// Noisy rides of the scenario.
const RIDES: [&str; 3] = ["s0001", "s0002", "s0003"];

/// Row of the book, channel of `lane_change --compare`, the paper's error (table 5 and section 4.2), %.
const ROWS: [(&str, &str, Option<f64>); 14] = [
    ("steering torque", "steer_torque", Some(11.8)),
    ("steering angle", "steer_angle", Some(-2.8)),
    ("rear slip ratio, braking", "slip_ratio_rear_braking", Some(-6.3)),
    ("rear slip ratio, driving", "slip_ratio_rear_driving", Some(-3.0)),
    ("front slip ratio, braking", "slip_ratio_front_braking", Some(12.6)),
    ("front slip angle, corner entry", "slip_angle_front_entry", Some(-33.6)),
    ("front yaw moment", "moment_z_front", Some(8.8)),
    ("rear yaw moment", "moment_z_rear", Some(34.0)),
    ("front slip angle", "slip_angle_front", None),
    ("rear slip angle", "slip_angle_rear", None),
    ("front lateral force", "force_y_front", None),
    ("rear lateral force", "force_y_rear", None),
    ("front overturning moment", "moment_x_front", None),
    ("rear overturning moment", "moment_x_rear", None),
];

/// A folder in which the study is done.
struct Study(tempfile::TempDir);

impl Study {
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn roadbench(&self, arguments: &[&str]) {
        let mut command = Command::cargo_bin("roadbench").expect("built");
        command.current_dir(self.0.path()).args(arguments).assert().success();
    }

    /// Errors of the peaks, %, in the order of [`ROWS`], on the tyres of one session of a run.
    fn errors(&self, results: &str, bikes: &str, session: &str) -> Vec<f64> {
        let session = format!("characterise_sports_small_{session}");
        let tyres = ["front", "rear"].map(|end| format!("{results}_{session}_{end}.toml"));
        for (end, out) in ["front", "rear"].into_iter().zip(&tyres) {
            let of = ["export", results, "--session", &session, "--format", "simulator"];
            let as_ridden = ["--tyre", end, "--friction", "0.75", "--bikes", bikes, "--out", out];
            self.roadbench(&[&of[..], &as_ridden].concat());
        }
        let lane = format!("lane_{results}_{session}");
        let on = ["--front-tyre", &tyres[0], "--rear-tyre", &tyres[1], "--compare", "--out", &lane];
        self.roadbench(&[&["simulate", "lane_change"][..], &on].concat());
        let peaks = self.path(&lane).join("compare/peaks.parquet");
        let peaks: Vec<PeakRow> = read::file_rows(&peaks).expect("peaks");
        let error = |channel: &str| {
            let row = peaks.iter().find(|p| p.channel == channel);
            100.0 * row.unwrap_or_else(|| panic!("no {channel}")).error
        };
        ROWS.iter().map(|(_, channel, _)| error(channel)).collect()
    }
}

/// The scenario without any sensor's noise, zero or mounting angle.
fn perfect(scenario: &str) -> String {
    let is = |line: &str, key: &str| line.trim_start().starts_with(key);
    let quiet = |line: &str| match line {
        _ if is(line, "sessions") => "sessions = 1".to_owned(),
        _ if is(line, "mounting") => "mounting = [0.0, 0.0, 0.0]".to_owned(),
        _ if ["accelerometer", "gyro"].iter().any(|key| is(line, key)) => {
            let sensor = line.split(' ').next().unwrap_or_default();
            format!("{sensor} = {{ white = 0.0, bias = 0.0 }}")
        }
        _ if is(line, "satellite") => {
            "satellite = { white = 0.0, slow = 0.0, slow_time = 2.0 }".to_owned()
        }
        _ => match ["white", "bias", "quantum"].iter().find(|key| is(line, key)) {
            Some(key) => format!("{key} = 0.0"),
            None => line.to_owned(),
        },
    };
    scenario.lines().map(quiet).collect::<Vec<_>>().join("\n")
}

/// The median of three with its sign, of a size about the middle one.
fn median(mut of: [f64; 3]) -> f64 {
    of.sort_by(f64::total_cmp);
    of[1]
}

/// The table between its marks, with numbers in it, of the page and as computed.
fn numbers(text: &str) -> Vec<f64> {
    let parts = text.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
    parts.filter_map(|part| part.parse().ok()).collect()
}

const MARKS: [&str; 2] = [
    "<!-- written by tests/it/lane_change.rs: ROADBENCH_BLESS=1 cargo nextest run -E 'test(/^lane_change/)' -->\n",
    "<!-- end -->\n",
];

/// Characterised on noisy rides, the other motorcycle's lane change is nearer to its own than the paper's in every row,
/// and the book's table says what comes out.
#[test]
fn every_row_is_nearer_than_the_papers_and_the_books_table_is_of_now() {
    let study = Study(tempfile::tempdir().expect("a folder"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    study.roadbench(&["simulate", "characterise", "--out", "ride"]);
    study.roadbench(&["run", "ride", "--out", "results"]);
    let extended = RIDES.map(|s| study.errors("results", "ride/bikes", s));

    // the paper's own form: slip stiffness per load whatever the load, no lag of the slip
    let bike = std::fs::read_to_string(study.path("ride/bikes/sports_small.toml")).expect("bike");
    std::fs::create_dir(study.path("paper")).expect("folder");
    let mut base = bike;
    for end in ["front", "rear"] {
        let head = format!("[{end}]\n");
        let own = format!("{head}slip_stiffness_load = 0.0\nlongitudinal_relaxation = 0.0\n");
        base = base.replace(&head, &own);
    }
    std::fs::write(study.path("paper/sports_small.toml"), base).expect("bike");
    study.roadbench(&["run", "ride", "--bikes", "paper", "--out", "base"]);
    let base = RIDES.map(|s| study.errors("base", "paper", s));

    let scenario = std::fs::read_to_string(root.join("pipelines/scenarios/characterise.toml"));
    std::fs::write(study.path("perfect.toml"), perfect(&scenario.expect("scenario")))
        .expect("written");
    study.roadbench(&["simulate", "perfect.toml", "--out", "perfect"]);
    study.roadbench(&["run", "perfect", "--out", "perfect_results"]);
    let perfect = study.errors("perfect_results", "perfect/bikes", "s0001");

    let mut table =
        "| signal | base tyre | extended tyre, median (each ride) | without noise | paper |\n\
                     |---|---:|---:|---:|---:|\n"
            .to_owned();
    let mut slips = Vec::new();
    for (r, (row, channel, paper)) in ROWS.iter().enumerate() {
        let each = extended.each_ref().map(|e| e[r]);
        let found = median(each);
        if let Some(paper) = paper {
            assert!(found.abs() < paper.abs(), "{row}: {found:.1} % ({each:.1?}), paper {paper} %");
            assert!(perfect[r].abs() < paper.abs(), "{row}: {:.1} % without noise", perfect[r]);
        }
        if channel.starts_with("slip_ratio") {
            slips.push(found.abs());
        }
        let own: Vec<String> = each.iter().map(|e| format!("{e:.1}")).collect();
        // of side forces and overturning moments the paper says no number, of slip angles nothing
        let words = if channel.starts_with("slip") { "-" } else { "\"strong agreement\"" };
        let paper = paper.map_or(words.to_owned(), |p| format!("{p} %"));
        let before = median(base.each_ref().map(|e| e[r]));
        table += &format!(
            "| {row} | {before:.1} % | {found:.1} % ({}) | {:.1} % | {paper} |\n",
            own.join(", "),
            perfect[r]
        );
    }
    is_of_now(&root.join("book/src/simulator.md"), &table);
    let [least, most] =
        [f64::min, f64::max].map(|f| slips.iter().copied().reduce(f).expect("rows"));
    let said = format!("its slip ratios within {least:.0} to {most:.0} % at the peak");
    let page = std::fs::read_to_string(root.join("book/src/validation.md")).expect("page");
    let flat = page.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains(&said), "book/src/validation.md does not say \"{said}\"");
}

/// Compares the table of a page with the computed one, or writes it. Other processors round elsewhere: half a point.
fn is_of_now(page: &Path, table: &str) {
    let text = std::fs::read_to_string(page).expect("page");
    let (before, rest) = text.split_once(MARKS[0]).expect("the table's mark");
    let (found, after) = rest.split_once(MARKS[1]).expect("the table's end");
    if std::env::var_os("ROADBENCH_BLESS").is_some() {
        let text = [before, MARKS[0], "\n", table, "\n", MARKS[1], after].concat();
        return std::fs::write(page, text).expect("written");
    }
    let (said, now) = (numbers(found), numbers(table));
    let same = said.len() == now.len() && said.iter().zip(&now).all(|(a, b)| (a - b).abs() < 0.5);
    assert!(same, "{} is stale; of now:\n{table}", page.display());
}
