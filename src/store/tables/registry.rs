//! The output tables: one declaration each, from which follow where their files are, which of them
//! belong to a session, what a report is made from, and what `roadbench schema` and the book list.
//!
//! To add a table: its columns in `schemas/`, its row in [`rows`], a line here, and the stage that
//! fills it (`book/src/extending/table.md`).

use std::sync::OnceLock;

use serde::Serialize;

use super::rows;
use crate::contract::schema::{self, Table};

/// Contents of one file of a table, and where it is below the output folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// The sessions of a motorcycle and month: `<table>/bike=<bike_id>/<month>.parquet`; on request, one session.
    Session,
    /// One log that could not be used: `<table>/<log>-<hash of its path>.parquet`.
    Log,
    /// All sessions of the output: `<table>/<table>.parquet`.
    Fleet,
    /// One simulated session's truth: `truth/<kind>/bike=<bike_id>/<session>.parquet`.
    Truth,
    /// All that one command found: a single file.
    Single,
}

/// The command that writes a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// `roadbench run`.
    Run,
    /// `roadbench diagnose`.
    Diagnose,
    /// `roadbench simulate`.
    Simulate,
    /// `roadbench modes`.
    Modes,
    /// `roadbench replay`.
    Replay,
    /// `roadbench tyre`.
    Tyre,
    /// `roadbench compare`.
    Compare,
}

impl Command {
    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Command::Run => "run",
            Command::Diagnose => "diagnose",
            Command::Simulate => "simulate",
            Command::Modes => "modes",
            Command::Replay => "replay",
            Command::Tyre => "tyre",
            Command::Compare => "compare",
        }
    }
}

/// Whether a table is there once its command has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Always, if need be without rows.
    Always,
    /// Where the riding gives rows for it.
    WhereItApplies,
    /// Only if an option asks for it; no report is made from it.
    OnRequest,
}

#[derive(Debug)]
pub struct TableSpec {
    /// Name of the table, of its schema and of its folder.
    pub name: &'static str,
    /// Text of its schema file.
    pub schema: &'static str,
    /// Contents of one file.
    pub scope: Scope,
    /// Who writes it; `rejected` is written by `diagnose` too.
    pub command: Command,
    /// Whether it is there.
    pub presence: Presence,
    /// A row of default values, by which a test holds the row's fields against the schema; none for
    /// a table that is written by columns.
    pub example: Option<fn() -> serde_json::Value>,
    table: OnceLock<Table>,
}

impl TableSpec {
    /// Its columns, read from the schema once.
    ///
    /// # Panics
    /// If the schema file is wrong: a test reads them all.
    pub fn table(&self) -> &Table {
        self.table.get_or_init(|| {
            toml::from_str(self.schema)
                .unwrap_or_else(|e| panic!("the schema of {}: {e}", self.name))
        })
    }

    /// Whether it is the table of that name.
    pub fn is(&self, other: &TableSpec) -> bool {
        self.name == other.name
    }
}

/// A row of an output table.
pub trait Row: Serialize {
    /// The table that it is a row of.
    fn spec() -> &'static TableSpec;
}

/// `CONSTANT: "name" version, row type, scope, command, presence;` a table that is written by columns has
/// `-` for a row. The version is that of its file in `schemas/`.
macro_rules! tables {
    (@example -) => { None };
    (@example $row:ident) => {
        Some(|| serde_json::to_value(rows::$row::default()).unwrap_or_default())
    };
    (@row $constant:ident -) => {};
    (@row $constant:ident $row:ident) => {
        impl Row for rows::$row {
            fn spec() -> &'static TableSpec {
                &$constant
            }
        }
    };
    ($($constant:ident: $name:literal $version:ident, $row:tt, $scope:ident, $command:ident, $presence:ident;)*) => {
        $(
            #[doc = concat!("The table `", $name, "`.")]
            #[allow(unreachable_pub)] // not every one is used outside of the crate
            pub static $constant: TableSpec = TableSpec {
                name: $name,
                schema: include_str!(concat!(
                    "../../../schemas/", $name, ".", stringify!($version), ".toml"
                )),
                scope: Scope::$scope,
                command: Command::$command,
                presence: Presence::$presence,
                example: tables!(@example $row),
                table: OnceLock::new(),
            };
            tables!(@row $constant $row);
        )*

        /// Every output table, in the order of the data's way through the program.
        pub static ALL: &[&TableSpec] = &[$(&$constant),*];
    };
}

tables! {
    SESSIONS: "sessions" v1, SessionRow, Session, Run, Always;
    MANOEUVRES: "manoeuvres" v2, Manoeuvre, Session, Run, Always;
    FORCES: "forces" v1, ForceRow, Session, Run, WhereItApplies;
    COEFFICIENTS: "coefficients" v2, Coefficient, Session, Run, Always;
    OUTLYING_MANOEUVRES: "outlying_manoeuvres" v1, OutlyingManoeuvre, Session, Run, WhereItApplies;
    TYRE_PARAMETERS: "tyre_parameters" v1, TyreParameters, Session, Run, WhereItApplies;
    EVIDENCE: "evidence" v2, EvidenceRow, Session, Run, Always;
    WARNINGS: "warnings" v1, WarningRow, Session, Run, Always;
    REJECTED: "rejected" v1, Rejected, Log, Run, WhereItApplies;
    PLOTS: "plots" v1, PlotPoint, Session, Run, Always;
    LAPS: "laps" v1, LapRow, Session, Run, WhereItApplies;
    LAP_CORNERS: "lap_corners" v1, LapCornerRow, Session, Run, WhereItApplies;
    LAP_POINTS: "lap_points" v1, LapPointRow, Session, Run, WhereItApplies;
    LAP_COEFFICIENTS: "lap_coefficients" v1, LapCoefficientRow, Session, Run, WhereItApplies;
    LAP_TRENDS: "lap_trends" v1, LapTrendRow, Session, Run, WhereItApplies;
    SIGNALS: "signals" v2, -, Session, Run, OnRequest;
    FLEET: "fleet" v1, FleetRow, Fleet, Run, Always;
    FLEET_POOLED: "fleet_pooled" v1, PooledRow, Fleet, Run, Always;
    FLEET_EVENTS: "fleet_events" v1, EventRow, Fleet, Run, Always;
    FLEET_RATIOS: "fleet_ratios" v1, RatioRow, Fleet, Run, Always;
    TYRES: "tyres" v2, TyreRow, Fleet, Run, Always;
    BIKES: "bikes" v2, BikeRow, Fleet, Run, Always;
    DIAGNOSES: "diagnoses" v1, DiagnosisRow, Session, Diagnose, Always;
    DISCREPANCIES: "discrepancies" v1, DiscrepancyRow, Session, Diagnose, Always;
    CAUSES: "causes" v1, CauseRow, Session, Diagnose, Always;
    REPLAYS: "replays" v2, SimulatedSample, Session, Diagnose, WhereItApplies;
    SIMULATION_ERRORS: "simulation_errors" v1, SimulationError, Session, Diagnose, WhereItApplies;
    ESTIMATES: "estimates" v1, EstimateRow, Session, Diagnose, WhereItApplies;
    EFFECT_TRACES: "effect_traces" v1, EffectTrace, Session, Diagnose, WhereItApplies;
    CHANGES: "changes" v1, ChangeRow, Fleet, Diagnose, Always;
    TRUTH: "truth" v1, Truth, Truth, Simulate, WhereItApplies;
    TRUTH_SEGMENTS: "truth_segments" v1, TruthSegment, Truth, Simulate, Always;
    TRUTH_SIGNALS: "truth_signals" v1, TruthSignal, Truth, Simulate, WhereItApplies;
    TRUTH_OFFROAD: "truth_offroad" v1, TruthOffroad, Truth, Simulate, WhereItApplies;
    MODES: "modes" v1, ModeRow, Single, Modes, Always;
    PEAKS: "peaks" v1, PeakRow, Single, Simulate, OnRequest;
    REPLAY: "replay" v2, BrakingReplay, Single, Replay, Always;
    BENCH: "bench" v1, BenchRow, Single, Tyre, Always;
    COMPARISON: "comparison" v1, ComparisonRow, Single, Compare, OnRequest;
}

/// Other folders below an output folder: extended models (a TOML file per diagnosed session, and one of what they share) and
/// the report's pages.
pub(crate) const OTHER_FOLDERS: &[&str] = &["models", "report"];

/// Held while a batch writes: an output has it.
pub(crate) const LOCK: &str = ".roadbench.lock";
/// Folder of what an output keeps for itself.
pub(crate) const OWN: &str = ".roadbench";
/// Files beside the folders: what the last run did, the lock, and the bench values that a report was given.
pub(crate) const OTHER_FILES: &[&str] =
    &["run.json", LOCK, "bench.csv", "bench_front.tdx", "bench_rear.tdx"];

/// The folders below an output that `run` and `diagnose` write to.
pub(crate) fn folders() -> impl Iterator<Item = &'static str> {
    let below =
        |spec: &&&TableSpec| matches!(spec.scope, Scope::Session | Scope::Log | Scope::Fleet);
    ALL.iter().filter(below).map(|spec| spec.name).chain(OTHER_FOLDERS.iter().copied())
}

/// The tables of one session that a command writes.
pub fn of_session(command: Command) -> impl Iterator<Item = &'static TableSpec> {
    let own = move |spec: &&TableSpec| spec.scope == Scope::Session && spec.command == command;
    ALL.iter().copied().filter(own)
}

/// The tables over all sessions that `run` makes.
pub fn of_fleet() -> impl Iterator<Item = &'static TableSpec> {
    let own = |spec: &&TableSpec| spec.scope == Scope::Fleet && spec.command == Command::Run;
    ALL.iter().copied().filter(own)
}

/// The folders that reports and fleet statistics are made from.
pub(crate) fn read_by_reports() -> impl Iterator<Item = &'static str> {
    let read = |spec: &&&TableSpec| {
        matches!(spec.scope, Scope::Session | Scope::Log | Scope::Fleet)
            && spec.presence != Presence::OnRequest
    };
    ALL.iter().filter(read).map(|spec| spec.name).chain(["models"])
}

/// The output table of that name, with or without its version or an earlier one (`causes`, `causes.v1`).
pub fn find(name: &str) -> Option<&'static TableSpec> {
    let version = name.rsplit_once(".v").and_then(|(name, v)| Some((name, v.parse().ok()?)));
    let (name, version) = version.unwrap_or((name, 1_u32));
    let spec = ALL.iter().copied().find(|spec| spec.name == name)?;
    (1..=spec.table().version).contains(&version).then_some(spec)
}

/// The text of a schema file, by name with or without its version (`session`, `causes.v1`).
pub fn schema_text(name: &str) -> Option<&'static str> {
    schema::text(name).or_else(|| find(name).map(|spec| spec.schema))
}

/// Name and text of every schema file: what users write, then the output tables.
pub fn schema_files() -> impl Iterator<Item = (&'static str, &'static str)> {
    schema::INPUTS.iter().copied().chain(ALL.iter().map(|spec| (spec.name, spec.schema)))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// The folder `schemas/` holds what is declared, and nothing else.
    #[test]
    fn every_schema_file_is_declared_once() {
        let version = |text: &str| {
            let table: toml::Table = text.parse().expect("TOML");
            table["version"].as_integer().expect("a number")
        };
        let declared: BTreeSet<String> =
            schema_files().map(|(name, text)| format!("{name}.v{}.toml", version(text))).collect();
        assert_eq!(declared.len(), schema_files().count(), "two have one name");
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
        let there: BTreeSet<String> = std::fs::read_dir(folder)
            .expect("schemas")
            .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        assert_eq!(declared, there);
        for spec in ALL {
            assert_eq!(spec.table().name, spec.name);
        }
    }

    /// A row has its schema's columns and no others, and lacks none that the schema requires. A column
    /// that may be null need not be: schemas are a promise to readers.
    #[test]
    fn every_row_has_the_columns_of_its_schema() {
        for spec in ALL {
            let Some(example) = spec.example else { continue };
            let row = example();
            let fields = row.as_object().expect("a struct");
            for column in &spec.table().columns {
                let value = fields
                    .get(&column.name)
                    .unwrap_or_else(|| panic!("{}: no field {}", spec.name, column.name));
                assert!(!value.is_null() || column.nullable, "{}.{}", spec.name, column.name);
            }
            assert_eq!(fields.len(), spec.table().columns.len(), "{}: {fields:?}", spec.name);
        }
    }

    /// A former name is none of another column: a file of the earlier version has one meaning. Where rows have a unit of
    /// their own the schema says in which column.
    #[test]
    fn former_names_and_columns_of_units_are_clear() {
        let mut renamed = 0;
        for spec in ALL {
            let table = spec.table();
            let formers: Vec<&str> =
                table.columns.iter().filter_map(|c| c.former.as_deref()).collect();
            let distinct: BTreeSet<&str> = formers.iter().copied().collect();
            assert_eq!(formers.len(), distinct.len(), "{}", spec.name);
            assert!(formers.iter().all(|f| table.column(f).is_none()), "{}", spec.name);
            assert!(formers.is_empty() || table.version > 1, "{}", spec.name);
            renamed += formers.len();
            for column in table.columns.iter().filter(|c| c.unit_column.is_some()) {
                let of = column.unit_column.as_deref().and_then(|of| table.column(of));
                assert!(of.is_some_and(|c| c.kind == "utf8"), "{}.{}", spec.name, column.name);
                assert!(column.unit.is_none(), "{}.{}", spec.name, column.name);
            }
        }
        assert!(renamed > 5, "{renamed}");
        let found = ["bikes", "bikes.v1", "bikes.v2"].map(|name| find(name).map(|s| s.name));
        assert_eq!(found, [Some("bikes"); 3]);
        assert!(find("bikes.v3").is_none() && find("bikes.v0").is_none());
    }

    #[test]
    fn only_tables_written_by_columns_have_no_row() {
        let without: Vec<&str> =
            ALL.iter().filter(|s| s.example.is_none()).map(|s| s.name).collect();
        assert_eq!(without, ["signals"]);
    }
}
