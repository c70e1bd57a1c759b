//! Which channels of the simulator's foreign logs are mapped correctly by their motion, and which errors that are
//! planted into right maps are found, named and mended.
//!
//! ```sh
//! roadbench simulate track --out rides         # or a scenario with more sessions
//! cargo run --release --example channels -- rides
//! ```

mod truth;

use std::path::{Path, PathBuf};

use truth::{Planted, check, judged, planted, score};

fn main() {
    let folders: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    if folders.is_empty() {
        eprintln!("which folders of `roadbench simulate track`?");
        std::process::exit(2);
    }
    println!("| logger | logs | channels | right | wrong in force | missing | delay error, rms |");
    println!("|---|---|---|---|---|---|---|");
    let mut notes = Vec::new();
    let mut second = Vec::new();
    for profile in ["superbike", "factory", "phone", "satellite"] {
        let logs = logs(&folders, profile);
        let (mut right, mut all, mut wrong, mut missing) = (0, 0, 0, 0);
        let mut late: Vec<f64> = Vec::new();
        let mut rows: Vec<(&str, [usize; 5])> = Vec::new();
        let mut alarms = 0;
        for log in &logs {
            let circumference = circumference(log, profile);
            let judged = judged(log);
            let s = score(&judged, profile);
            right += s.right;
            all += s.expected;
            wrong += s.wrong.len();
            missing += s.missing.len();
            late.extend(&s.late);
            let file = log.file_name().unwrap_or_default().to_string_lossy();
            notes.extend(s.wrong.iter().map(|w| format!("{file}: wrong: {w}")));
            notes.extend(s.missing.iter().map(|w| format!("{file}: missing: {w}")));
            alarms += check(&judged, profile, circumference, None).false_alarms;
            for p in planted(profile) {
                let kind = match p {
                    Planted::Sign(_) => "sign",
                    Planted::Unit(..) => "unit",
                    Planted::Swapped(..) => "swapped",
                    Planted::Delay(_) => "delay of 0.2 s",
                };
                let c = check(&judged, profile, circumference, Some(p));
                if !(c.found && c.named && c.mended && c.false_alarms == 0) {
                    notes.push(format!("{file}: {p:?}: {c:?}"));
                }
                let at = rows.iter().position(|r| r.0 == kind).unwrap_or_else(|| {
                    rows.push((kind, [0; 5]));
                    rows.len() - 1
                });
                let add = [
                    1,
                    usize::from(c.found),
                    usize::from(c.named),
                    usize::from(c.mended),
                    c.false_alarms,
                ];
                rows[at].1.iter_mut().zip(add).for_each(|(a, b)| *a += b);
            }
        }
        let rms = (late.iter().map(|x| x * x).sum::<f64>() / late.len().max(1) as f64).sqrt();
        let share = 100.0 * right as f64 / all.max(1) as f64;
        println!(
            "| {profile} | {} | {all} | {right} ({share:.1} %) | {wrong} | {missing} | {} |",
            logs.len(),
            if late.is_empty() { "-".into() } else { format!("{rms:.3} s") }
        );
        for (kind, [n, found, named, mended, others]) in rows {
            second.push(format!(
                "| {profile} | {kind} | {n} | {found} | {named} | {mended} | {others} |"
            ));
        }
        second.push(format!("| {profile} | nothing | {} | - | - | - | {alarms} |", logs.len()));
    }
    println!("\n| logger | planted | maps | found | named | mended | other findings |");
    println!("|---|---|---|---|---|---|---|");
    second.iter().for_each(|row| println!("{row}"));
    println!();
    notes.iter().for_each(|note| println!("{note}"));
}

/// The logs of a profile below some folders.
fn logs(folders: &[PathBuf], profile: &str) -> Vec<PathBuf> {
    let below = |folder: &PathBuf| {
        walkdir::WalkDir::new(folder.join("loggers").join(profile)).sort_by_file_name()
    };
    let files = folders.iter().flat_map(|f| below(f).into_iter().flatten());
    files.map(|e| e.into_path()).filter(|p| p.is_file()).collect()
}

/// The nominal circumferences of a log, m.
fn circumference(log: &Path, profile: &str) -> [f64; 2] {
    let name = log.file_name().unwrap_or_default().to_string_lossy();
    let root = log.ancestors().find(|p| p.ends_with(Path::new("loggers").join(profile)));
    let root = root.and_then(|p| p.ancestors().nth(2)).unwrap_or(Path::new("."));
    let path = root.join("truth/loggers").join(format!("{name}.toml"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let truth: toml::Table = text.parse().expect("TOML");
    [0, 1].map(|k| truth["circumference"][k].as_float().expect("a number"))
}
