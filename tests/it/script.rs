//! Stand-in stages for tests of the batch: a log here is a line that says what is to happen to it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant, SystemTime};

use roadbench::internals::batch::jobs::bikes::BikeFile;
use roadbench::internals::batch::jobs::run;
use roadbench::internals::batch::jobs::work::Output;
use roadbench::internals::batch::store::contents::Contents;
use roadbench::internals::batch::store::kind;
use roadbench::internals::batch::store::kind::Kind;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Accounts, Error, Maps, Settings, State, Watch, Work};
use roadbench::internals::contract::rejection::{RejectionCode, Stage};
use roadbench::internals::contract::session::Meta;
use roadbench::internals::ingest::Identified;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::pipeline::{Input, Outcome, Pipeline, Rejection};
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::registry;
use roadbench::internals::store::tables::registry::TableSpec;
use roadbench::internals::store::tables::rows::{
    Coefficient, Ident, PlotPoint, Provenance, SessionRow, Status,
};

pub const BIKE: &str = "mass = 260.0\nwheelbase = 1.45\ncg_to_front = 0.72\ncg_height = 0.62\n\
    caster_angle = 0.43\n[front]\nradius = 0.3\nwidth = 0.12\n[rear]\nradius = 0.31\nwidth = 0.18\n";

/// A log is `<session id>|<bike id>|<what happens>`; the id `*` is the file's name, as of logs that do not say theirs.
/// What is read by a channel map ends with ` map=<name>`.
#[derive(Default)]
pub struct Script {
    pub runs: AtomicUsize,
    pub identified: AtomicUsize,
    pub pause: Duration,
    pub signals: bool,
    /// Why no log is identified, as where the channel map is not given that they were read by.
    pub refuses: Option<RejectionCode>,
}

impl Work for Script {
    type Result = Outcome;

    fn kind(&self) -> &'static Kind {
        &kind::RUN
    }

    fn is_requested(&self, table: &TableSpec) -> bool {
        self.signals && table.is(&registry::SIGNALS)
    }

    fn identify(&self, log: &Location, _: &[ChannelMap]) -> Result<Identified, Rejection> {
        self.identified.fetch_add(1, Ordering::Relaxed);
        if let Some(code) = self.refuses {
            return Err(rejection_of(code, "as the test says".into()));
        }
        let text = std::fs::read_to_string(log.as_path().expect("a file"))
            .map_err(|e| rejection_of(RejectionCode::Unreadable, e.to_string()))?;
        let parts: Vec<&str> = text.trim_end().split('|').collect();
        let [session_id, bike_id, what] = parts[..] else {
            return Err(rejection_of(RejectionCode::UnknownFormat, "not a script".into()));
        };
        assert_ne!(what, "panic early", "as the script says");
        // `ok <value> <start time>`
        let words: Vec<&str> = what.split(' ').collect();
        let start_time = match words[..] {
            [_, _, start] if roadbench::internals::contract::instant::parse(start).is_some() => {
                Some(start.to_owned())
            }
            _ => None,
        };
        let meta = Meta {
            session_id: named(session_id, log),
            bike_id: bike_id.to_owned(),
            start_time,
            ..Meta::default()
        };
        let map = what.split(' ').find_map(|word| word.strip_prefix("map="));
        Ok(Identified { meta, map: map.map(str::to_owned) })
    }

    fn run(
        &self,
        input: &Input<'_>,
        bike: &BikeFile,
        _: &Pipeline,
    ) -> Result<Output<Outcome>, Rejection> {
        self.runs.fetch_add(1, Ordering::Relaxed);
        std::thread::sleep(self.pause);
        let text = String::from_utf8(input.log.read().expect("there")).expect("identified");
        let parts: Vec<&str> = text.trim_end().split('|').collect();
        match parts[2] {
            "panic" => panic!("as the script says"),
            "overflow" => {
                let numbers = [1, 2, 3];
                let at = input.log.to_string().len(); // always beyond
                return Err(rejection(&format!("{}", numbers[at])));
            }
            "reject" => return Err(rejection("row 7 of velocity_x is odd")),
            _ => {}
        }
        let mut outcome = outcome(&named(parts[0], &input.log), &bike.bike.bike_id, input);
        // `ok <value> <start time>`
        let words: Vec<&str> = parts[2].split(' ').collect();
        if let [how, value, start] = words[..] {
            let row = &mut outcome.coefficients[0];
            row.value = Some(value.parse().expect("number"));
            row.ident.start_time = Some(start.to_owned());
            outcome.session.ident.start_time = Some(start.to_owned());
            if how == "poor" {
                row.status = Status::PoorlyDetermined;
            }
        }
        run::output(outcome)
    }
}

fn named(session_id: &str, log: &Location) -> String {
    match session_id {
        "*" => log.file_stem().into_owned(),
        id => id.to_owned(),
    }
}

fn rejection(message: &str) -> Rejection {
    rejection_of(RejectionCode::TooShort, message.to_owned())
}

fn rejection_of(code: RejectionCode, message: String) -> Rejection {
    Rejection { stage: Stage::Ingest, code, message, limits: None }
}

fn outcome(session_id: &str, bike_id: &str, input: &Input<'_>) -> Outcome {
    let ident = Ident {
        session_id: session_id.to_owned(),
        bike_id: bike_id.to_owned(),
        start_time: Some("2026-05-01T10:00:00Z".to_owned()),
    };
    let provenance = Provenance {
        input_hash: input.input_hash.clone(),
        pipeline_hash: input.pipeline_hash.clone(),
        version: roadbench::VERSION.to_owned(),
    };
    let value = 0.3 + session_id.len() as f64 * 1e-3;
    Outcome {
        session: SessionRow {
            ident: ident.clone(),
            path: input.log.to_string(),
            duration: 60.0,
            rate: 100.0,
            n_samples: 6000,
            distance: None,
            channels: "velocity_x".into(),
            n_manoeuvres: 0,
            n_used: 0,
            n_coefficients_ok: 1,
            n_warnings: 0,
            tyre_front: None,
            tyre_rear: None,
            site: None,
            rider_id: None,
            provenance: provenance.clone(),
        },
        coefficients: vec![Coefficient {
            ident,
            tyre: "front".into(),
            coefficient: "effective_rolling_radius".into(),
            symbol: "R_rol".into(),
            value: Some(value),
            unit: "m".into(),
            std_error: Some(1e-3),
            ci95_low: Some(value - 2e-3),
            ci95_high: Some(value + 2e-3),
            dispersion: None,
            n_manoeuvres: 3,
            n_samples: 300,
            residual_scale: None,
            outlier_fraction: None,
            r_squared: None,
            status: Status::Ok,
            reason: None,
            provenance,
            ..Coefficient::default()
        }],
        plots: (0..200)
            .map(|i| PlotPoint {
                session_id: session_id.into(),
                bike_id: bike_id.into(),
                plot: "coast_down".into(),
                series: "data".into(),
                x: f64::from(i),
                y: Some(f64::from(i).sqrt()),
                y_low: None,
                y_high: None,
                weight: Some(1.0),
                manoeuvre_id: None,
                shade: None,
                n: None,
                ..PlotPoint::default()
            })
            .collect(),
        signals: input.signals.then(|| {
            roadbench::internals::store::tables::file::batch::<PlotPoint>(&[]).expect("empty batch")
        }),
        ..Outcome::default()
    }
}

/// Settings that own what they name.
pub struct Setup {
    pub inputs: Vec<PathBuf>,
    pub bikes: Option<PathBuf>,
    pub out: PathBuf,
    pub maps: Vec<PathBuf>,
    pub jobs: usize,
    pub force: bool,
    pub since: Option<SystemTime>,
}

impl Setup {
    /// Hands the settings on.
    pub fn with<T>(&self, then: impl FnOnce(&Settings<'_>) -> T) -> T {
        then(&Settings {
            inputs: &self.inputs.iter().map(Location::from).collect::<Vec<_>>(),
            bikes: self.bikes.as_ref().map(Location::from).as_ref(),
            out: &Location::from(&self.out),
            pipeline: &Pipeline::onroad(),
            maps: &Maps::read(&self.maps).expect("maps"),
            jobs: self.jobs,
            force: self.force,
            since: self.since,
        })
    }

    pub fn run(
        &self,
        work: &Script,
        watch: &impl Watch<Outcome>,
        stop: &AtomicBool,
    ) -> Result<Accounts, Error> {
        self.with(|settings| engine::run(settings, work, watch, stop)).map(|(accounts, _)| accounts)
    }

    /// What a run would do: log's name, what becomes of it, why.
    pub fn intend(&self) -> Vec<(String, State, String)> {
        let all = self.with(|settings| engine::dry_run(settings, &Script::default()));
        let all = all.expect("intended");
        let name =
            |log: &str| Path::new(log).file_stem().expect("name").to_string_lossy().into_owned();
        all.into_iter().map(|i| (name(&i.log), i.state, i.why)).collect()
    }
}

/// A folder with logs and two bikes.
pub struct Place {
    pub root: tempfile::TempDir,
}

impl Place {
    pub fn new(logs: &[(&str, &str)]) -> Self {
        let place = Place { root: tempfile::tempdir().expect("folder") };
        place.put("bikes/b1.toml", BIKE);
        place.put("bikes/b2.toml", BIKE);
        for (name, text) in logs {
            place.put(&format!("logs/{name}.csv"), text);
        }
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    pub fn put(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("parent")).expect("folder");
        std::fs::write(path, text).expect("file");
    }

    pub fn setup(&self) -> Setup {
        Setup {
            inputs: vec![self.path("logs")],
            bikes: Some(self.path("bikes")),
            out: self.path("out"),
            maps: Vec::new(),
            jobs: 2,
            force: false,
            since: None,
        }
    }

    pub fn run_with(
        &self,
        work: &Script,
        change: impl FnOnce(&mut Setup),
    ) -> Result<Accounts, Error> {
        let mut setup = self.setup();
        change(&mut setup);
        setup.run(work, &(), &AtomicBool::new(false))
    }

    pub fn run(&self) -> Accounts {
        self.run_with(&Script::default(), |_| {}).expect("run")
    }

    /// As [`Place::files`], without the fleet's tables: these are the command's, and a batch after a killed one makes them first.
    pub fn tables(&self, out: &str) -> BTreeMap<String, Vec<u8>> {
        let all = self.files(out).into_iter().filter(|(name, _)| !is_of_fleet(name));
        all.map(|(name, bytes)| match name.ends_with("checksums.json") {
            true => (name, without_fleet(&bytes)),
            false => (name, bytes),
        })
        .collect()
    }

    /// Every file below the output, but for locks and marks, with its bytes.
    pub fn files(&self, out: &str) -> BTreeMap<String, Vec<u8>> {
        let root = self.path(out);
        walkdir::WalkDir::new(&root)
            .into_iter()
            .map(|e| e.expect("entry"))
            .filter(|e| {
                e.file_type().is_file() && !e.file_name().to_string_lossy().ends_with(".lock")
            })
            .filter(|e| {
                !["behind", "switched", "output.json"].iter().any(|mark| e.file_name() == *mark)
            })
            .map(|e| {
                let name = e.path().strip_prefix(&root).expect("below").to_string_lossy();
                (name.replace('\\', "/"), std::fs::read(e.path()).expect("bytes"))
            })
            .collect()
    }

    /// Bike and session of everything that is there.
    pub fn sessions(&self) -> Vec<String> {
        let there = Contents::read(&kind::RUN, &self.path("out").into()).expect("read");
        assert!(there.staged().next().is_none(), "something waits still");
        there.sessions().map(|s| format!("{}/{}", s.bike_id, s.session_id)).collect()
    }

    pub fn names(&self) -> Vec<String> {
        self.tables("out").into_keys().collect()
    }
}

fn is_of_fleet(name: &str) -> bool {
    let folder = name.split('/').next().unwrap_or_default();
    registry::of_fleet().any(|spec| spec.name == folder)
}

fn without_fleet(checksums: &[u8]) -> Vec<u8> {
    let mut list: BTreeMap<String, String> = serde_json::from_slice(checksums).expect("a list");
    list.retain(|name, _| !is_of_fleet(name));
    serde_json::to_vec_pretty(&list).expect("text")
}

pub fn codes(run: &Accounts) -> Vec<&str> {
    run.rejected.iter().map(|r| r.code.as_str()).collect()
}

pub fn adds_up(run: &Accounts) {
    assert_eq!(run.inputs, run.done + run.unchanged + run.rejected.len() + run.left);
}

/// Kills a process after some time; how long it lived where it had ended by then.
pub fn killed_after(mut child: Child, after: Duration) -> Option<Duration> {
    let start = Instant::now();
    while start.elapsed() < after {
        if child.try_wait().expect("child").is_some() {
            return Some(start.elapsed());
        }
        std::thread::sleep(Duration::from_millis(1).min(after));
    }
    child.kill().expect("SIGKILL");
    child.wait().expect("gone");
    None
}
