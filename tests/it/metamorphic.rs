//! Random nights against one run from scratch: whatever happens to logs, motorcycles' files and the output, and in whatever
//! order, the output is that of a run over what is there. `ROADBENCH_NIGHTS` says how many nights are compared,
//! `ROADBENCH_SEED` by which numbers.
//!
//! The exceptions that the book states (`nightly.md`) are no nights here: a session whose log is gone stays, so it is
//! forgotten; which of two equal logs stays depends on which was there, so copies sort behind their originals.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use roadbench::internals::batch::jobs::run;
use roadbench::internals::batch::store::folder::Store;
use roadbench::internals::batch::store::forget::{Selection, forget};
use roadbench::internals::batch::store::kind;
use roadbench::internals::batch::store::verify::mend;
use roadbench::internals::report::Pages;

use crate::kill::victim_of;
use crate::script::{BIKE, Place, Script, Setup, adds_up};

/// Nights of one place before the next begins.
const NIGHTS: usize = 12;

/// What a log says; sessions are identified by number.
#[derive(Debug, Clone, PartialEq)]
struct Log {
    id: usize,
    bike: usize,
    is_bad: bool,
    value: u32,
    /// Day of May; none where the log does not say.
    day: Option<u32>,
}

impl Log {
    fn text(&self) -> String {
        let Log { id, bike, is_bad, value, day } = self;
        let start = match day {
            Some(day) => format!("2026-05-{day:02}T10:00:00Z"),
            None => "unknown".to_owned(),
        };
        let how = if *is_bad { "reject" } else { "ok" };
        format!("s{id}|b{bike}|{how} 0.{value} {start}")
    }
}

struct World {
    place: Place,
    random: Pcg64,
    logs: BTreeMap<String, Log>,
    sessions: usize,
    done: Vec<String>,
}

impl World {
    fn new(seed: u64) -> Self {
        let random = Pcg64::seed_from_u64(seed);
        let place = Place::new(&[]);
        World { place, random, logs: BTreeMap::new(), sessions: 0, done: Vec::new() }
    }

    fn put(&mut self, name: String, log: Log) {
        self.place.put(&format!("logs/{name}.csv"), &log.text());
        self.logs.insert(name, log);
    }

    fn any(&mut self) -> Option<(String, Log)> {
        let names: Vec<&String> = self.logs.keys().collect();
        let name = (*names.choose(&mut self.random)?).clone();
        let log = self.logs[&name].clone();
        Some((name, log))
    }

    /// A log that no other one is a copy or a rival of.
    fn lonely(&mut self) -> Option<(String, Log)> {
        let (name, log) = self.any()?;
        let same = self.logs.values().filter(|l| l.id == log.id).count();
        (same == 1).then_some((name, log))
    }

    fn fresh(&mut self) -> Log {
        self.sessions += 1;
        Log {
            id: self.sessions,
            bike: self.random.random_range(1..=2),
            is_bad: self.random.random_range(0..6) == 0,
            value: self.random.random_range(300..340),
            day: Some(self.random.random_range(1..=28)),
        }
    }

    /// The session of a log that goes is given up: else it stays, by design.
    fn forget(&self, log: &Log) {
        let which = Selection { sessions: vec![format!("s{}", log.id)], ..Selection::default() };
        let _ = forget(&self.place.path("out").into(), &which, true); // it may not be there yet
    }

    /// Something happens to the logs, to a bike or to the output.
    fn event(&mut self) {
        let kind = self.random.random_range(0..13);
        let any = if kind < 2 { None } else { self.any() };
        let (what, about) = match (kind, any) {
            (0 | 1, _) | (_, None) => {
                let folder = ["", "early/", "zz/"][self.random.random_range(0..3)];
                let name = format!("{folder}l{}", self.sessions);
                let log = self.fresh();
                self.put(name.clone(), log);
                ("a log comes", name)
            }
            (2, Some((name, mut log))) => {
                log.value = self.random.random_range(300..340);
                self.put(name.clone(), log);
                ("a log is written again", name)
            }
            (3, Some((name, mut log))) => {
                log.is_bad = !log.is_bad;
                self.put(name.clone(), log);
                ("a log goes bad, or is made good", name)
            }
            (4, Some((name, log))) => {
                // an aborted ride, or another one, of the same id
                let mut other = log;
                other.is_bad = self.random.random();
                other.day = Some(self.random.random_range(1..=28));
                other.value = 399;
                let folder = ["early", "zz"][self.random.random_range(0..2)];
                let name = format!("{folder}/{}", name.replace('/', "_"));
                if self.logs.contains_key(&name) {
                    self.forget(&other); // another ride in place of one stays archived
                }
                self.put(name.clone(), other);
                ("a rival comes", name)
            }
            (5, Some(_)) => match self.lonely() {
                None => return,
                Some((name, log)) => {
                    let to = format!("r{}", self.random.random_range(0..1_000_000));
                    let (from, at) = (format!("logs/{name}.csv"), format!("logs/{to}.csv"));
                    std::fs::rename(self.place.path(&from), self.place.path(&at)).expect("renamed");
                    self.logs.remove(&name);
                    self.logs.insert(to, log);
                    ("a log is renamed", name)
                }
            },
            (6, Some(_)) => match self.lonely() {
                None => return,
                Some((name, log)) => {
                    let path = self.place.path(&format!("logs/{name}.csv"));
                    std::fs::remove_file(path).expect("removed");
                    self.logs.remove(&name);
                    self.forget(&log);
                    ("a log and its session go", name)
                }
            },
            (7, Some((name, log))) => {
                // sorts behind the original, and is another file of the same bytes
                let copy = format!("zzz/{}", name.replace('/', "_"));
                self.put(copy, log);
                ("a log is copied", name)
            }
            (8, Some(_)) => match (self.lonely(), self.lonely()) {
                (Some((a, log_a)), Some((b, log_b))) if a != b => {
                    self.put(a.clone(), log_b);
                    self.put(b, log_a);
                    ("two logs change names", a)
                }
                _ => return,
            },
            (9, Some(_)) => {
                let mass = 260 + self.random.random_range(0..3);
                self.place.put("bikes/b1.toml", &BIKE.replace("260.0", &format!("{mass}.0")));
                ("a bike file changes", mass.to_string())
            }
            (10 | 11, Some(_)) => match self.damage() {
                Some(file) => ("damage", file),
                None => return,
            },
            _ => {
                let mut child = victim_of(&self.place);
                std::thread::sleep(Duration::from_millis(self.random.random_range(0..60)));
                let _ = child.kill();
                let _ = child.wait();
                ("a run is killed", String::new())
            }
        };
        self.done.push(format!("{what}: {about}"));
    }

    /// Something happens to a file of the output.
    fn damage(&mut self) -> Option<String> {
        if !self.place.path("out").is_dir() {
            return None;
        }
        let files = self.place.files("out");
        let names: Vec<&String> = files.keys().filter(|n| *n != "run.json").collect();
        let name = (*names.choose(&mut self.random)?).clone();
        let path = self.place.path("out").join(&name);
        let mut bytes = files[&name].clone();
        match self.random.random_range(0..3) {
            0 => std::fs::remove_file(path).expect("removed"),
            1 => {
                bytes.truncate(bytes.len() / 2);
                std::fs::write(path, bytes).expect("cut");
            }
            _ => {
                let at = self.random.random_range(0..bytes.len().max(1));
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << self.random.random_range(0..8);
                }
                std::fs::write(path, bytes).expect("turned");
            }
        }
        if self.random.random() {
            mend(&self.place.path("out").into(), false).expect("mended");
        }
        Some(name)
    }

    /// A night into a folder, with all that belongs to it.
    fn night(&self, out: &str) {
        let setup = Setup { out: self.place.path(out), ..self.place.setup() };
        let accounts = setup.run(&Script::default(), &(), &AtomicBool::new(false)).expect("a run");
        adds_up(&accounts);
        assert_eq!(accounts.damage, None, "{:#?}", self.done);
        let store = Store::open(&kind::RUN, &self.place.path(out).into()).expect("opened");
        if store.is_behind() {
            run::finish(&store, Pages::Auto, |_| Ok(())).expect("fleet and report");
        }
    }
}

#[test]
fn nights_in_any_order_give_what_one_run_gives() {
    let number = |name: &str, usual: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let (nights, seed) = (number("ROADBENCH_NIGHTS", 24), number("ROADBENCH_SEED", 1));
    let mut compared = 0;
    for round in 0.. {
        let mut world = World::new(seed * 1000 + round);
        for _ in 0..NIGHTS {
            for _ in 0..world.random.random_range(1..=3) {
                world.event();
            }
            if world.logs.is_empty() {
                continue;
            }
            world.done.push("night".to_owned());
            world.night("out");
            let fresh = format!("fresh{compared}");
            world.night(&fresh);
            let (now, scratch) = (world.place.files("out"), world.place.files(&fresh));
            let names = now.keys().chain(scratch.keys());
            let other: Vec<&String> =
                names.filter(|name| now.get(*name) != scratch.get(*name)).collect();
            assert!(other.is_empty(), "round {round}: {other:#?}\nafter {:#?}", world.done);
            std::fs::remove_dir_all(world.place.path(&fresh)).expect("removed");
            compared += 1;
            if compared == nights {
                println!("{compared} nights compared, no difference");
                return;
            }
        }
    }
}
