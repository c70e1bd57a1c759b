//! Very many damaged logs of every format, read by workers with 1 GB each: no batch is lost, no log takes longer than it may,
//! every one is accounted for. `ROADBENCH_MUTANTS` says how many of each format (10,000 take hours).

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use rand::RngExt;
use rand_pcg::Pcg64;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::Rejected;

use crate::damage::{FOREIGN, RACING, damage, map_files, ride, whole};

/// Logs of one batch.
const TOGETHER: usize = 500;
/// Largest mutant, bytes.
const LARGEST: usize = 4 << 20;

/// Damage of kinds that random bits rarely make: lengths that lie, bombs, nesting, numbers that are none.
fn mutate(bytes: &mut Vec<u8>, kind: usize, random: &mut Pcg64) {
    let n = bytes.len().max(16);
    bytes.resize(n, 0);
    match kind % 8 {
        0 | 1 => {
            let lies = [
                0,
                1,
                255,
                1 << 16,
                (1 << 31) - 1,
                u64::from(u32::MAX),
                1 << 40,
                u64::MAX,
                n as u64 + 1,
            ];
            for _ in 0..=random.random_range(0..4) {
                let lie = lies[random.random_range(0..lies.len())];
                let (bytes_of, wide) = match random.random_range(0..4) {
                    0 => (lie.to_le_bytes(), 8),
                    1 => (lie.to_be_bytes(), 8),
                    2 => (lie.to_le_bytes(), 4),
                    _ => ((lie << 32).to_be_bytes(), 4),
                };
                // headers lie more often than data
                let within = if random.random() { n.min(2000) } else { n };
                let at = random.random_range(0..within - 8) & !3;
                bytes[at..at + wide].copy_from_slice(&bytes_of[..wide]);
            }
        }
        2 => {
            // a block again and again
            let from = random.random_range(0..n / 2);
            let block = bytes[from..(from + 4000).min(n)].to_vec();
            let times = (LARGEST / block.len()).min(random.random_range(1..1000));
            bytes.splice(from..from, block.repeat(times));
        }
        3 => {
            let deep = ["[", "{\"a\":", "<a>", "\"", "("][random.random_range(0..5)];
            let at = random.random_range(0..n);
            bytes.splice(at..at, deep.repeat(random.random_range(1..50_000)).into_bytes());
        }
        4 | 5 => {
            // digits become others, some words of numbers
            for _ in 0..random.random_range(1..40) {
                let at = random.random_range(0..n);
                let Some(digit) = (at..n).find(|i| bytes[*i].is_ascii_digit()) else { break };
                let odd: &[u8] = match random.random_range(0..6) {
                    0 => b"99999999999999999999",
                    1 => b"-",
                    2 => b"1e308",
                    3 => b"nan",
                    4 => b"inf",
                    _ => b"\n",
                };
                bytes.splice(digit..=digit, odd.iter().copied());
                if bytes.len() < n {
                    break;
                }
            }
        }
        6 => {
            // no ends of lines, or nothing else
            let odd = if random.random() { b' ' } else { b'\n' };
            bytes
                .iter_mut()
                .filter(|b| **b == b'\n' || (odd == b'\n' && **b == b','))
                .for_each(|b| *b = odd);
        }
        _ => {
            for k in 0..3 {
                damage(bytes, random.random_range(0..10) + k, random);
                if bytes.len() < 16 {
                    break;
                }
            }
        }
    }
    bytes.truncate(LARGEST);
}

#[test]
#[ignore = "minutes to hours; ROADBENCH_MUTANTS says how many of each format"]
fn mutants_cost_themselves_only() {
    let each = std::env::var("ROADBENCH_MUTANTS").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    let seed = std::env::var("ROADBENCH_SEED").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let folder = tempfile::tempdir().expect("folder");
    let ride = ride();
    let sample = |name: &str| {
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats").join(name))
            .expect("bundled")
    };
    let mut formats: Vec<(String, String, Vec<u8>)> = Vec::new();
    for format in ["parquet", "csv", "txt"].into_iter().chain(RACING) {
        let extension = match format {
            "motec" | "aim" | "racechrono" => "csv",
            "xsens" => "txt",
            other => other,
        };
        formats.push((format.into(), extension.into(), whole(&ride, folder.path(), "", format)));
    }
    for (extension, name) in FOREIGN {
        formats.push((format!("other_{extension}"), extension.into(), sample(name)));
    }
    let maps = map_files();
    let mut codes: BTreeMap<String, usize> = BTreeMap::new();
    let (mut inputs, mut done, began) = (0, 0, Instant::now());
    for (number, (format, extension, bytes)) in formats.iter().enumerate() {
        let mut random = Pcg64::new(seed, number as u128);
        let mut own: BTreeMap<String, usize> = BTreeMap::new();
        let start = Instant::now();
        for first in (0..each).step_by(TOGETHER) {
            let place = tempfile::tempdir().expect("folder");
            let logs = place.path().join("logs/sessions/bike=archive_01");
            std::fs::create_dir_all(&logs).expect("folder");
            let n = TOGETHER.min(each - first);
            for k in first..first + n {
                let mut bytes = bytes.clone();
                mutate(&mut bytes, k, &mut random);
                std::fs::write(logs.join(format!("{format}_{k:05}.{extension}")), bytes)
                    .expect("log");
            }
            let bikes = place.path().join("logs/bikes");
            std::fs::create_dir_all(&bikes).expect("folder");
            let bike = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("fixtures/archive/bikes/archive_01.toml");
            std::fs::copy(&bike, bikes.join("archive_01.toml")).expect("bike");
            std::fs::copy(bike, bikes.join("b1.toml")).expect("bike"); // as the Parquet log says
            let out = place.path().join("out");
            let said = Command::new(env!("CARGO_BIN_EXE_roadbench"))
                .arg("run")
                .arg(place.path().join("logs"))
                .arg("--out")
                .arg(&out)
                .args(maps.iter().flat_map(|map| [Path::new("--map"), map]))
                .args(["--memory-limit", "1", "--time-limit", "30", "--pages", "none"])
                .output()
                .expect("started");
            let words = String::from_utf8_lossy(&said.stderr);
            assert!(
                matches!(said.status.code(), Some(0 | 1)),
                "{format}: {:?}\n{words}",
                said.status
            );
            let text = std::fs::read_to_string(out.join("run.json")).expect("run.json");
            let run: serde_json::Value = serde_json::from_str(&text).expect("json");
            let of = |key: &str| run[key].as_u64().expect(key) as usize;
            assert_eq!(
                (of("inputs"), of("computed") + of("rejected")),
                (n, n),
                "{format} from {first}"
            );
            let rejected: Vec<Rejected> = read::rows(&out).expect("rejected");
            assert_eq!(rejected.len(), of("rejected"));
            for row in rejected {
                assert!(!row.message.is_empty());
                if ["crashed", "too_slow", "internal_error"].contains(&row.code.as_str()) {
                    println!("{}: {} {}", row.path, row.code, row.message);
                }
                *own.entry(row.code).or_default() += 1;
            }
            inputs += n;
            done += of("computed");
        }
        println!("{format}: {own:?}, {:.0} s", start.elapsed().as_secs_f64());
        for (code, n) in own {
            *codes.entry(code).or_default() += n;
        }
    }
    println!("seed {seed}: {inputs} mutants, {done} through, {codes:?}, {:?}", began.elapsed());
}
