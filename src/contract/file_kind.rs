//! Which kind of file a TOML file is, by the keys that no other kind has: for messages on a file of the wrong kind.

use toml::{Table, Value};

use super::key_error::KeyError;

/// A kind of TOML file that the program reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// Known properties of a motorcycle, for the estimates.
    Bike,
    /// A motorcycle as the simulator takes it.
    Motorcycle,
    /// Which channel of a log is which.
    ChannelMap,
    Scenario,
    /// Settings of the stages.
    Pipeline,
    /// Extended model of a diagnosis.
    Model,
    Tyre,
    /// Coefficients with intervals.
    Coefficients,
}

impl FileKind {
    pub const ALL: [FileKind; 8] = [
        FileKind::Bike,
        FileKind::Motorcycle,
        FileKind::ChannelMap,
        FileKind::Scenario,
        FileKind::Pipeline,
        FileKind::Model,
        FileKind::Tyre,
        FileKind::Coefficients,
    ];

    /// Name, with its article.
    pub fn name(self) -> &'static str {
        match self {
            FileKind::Bike => "a bike file",
            FileKind::Motorcycle => "a motorcycle file of the simulator",
            FileKind::ChannelMap => "a channel map",
            FileKind::Scenario => "a scenario",
            FileKind::Pipeline => "a pipeline",
            FileKind::Model => "a model of `diagnose`",
            FileKind::Tyre => "a tyre file",
            FileKind::Coefficients => "a file of coefficients",
        }
    }

    /// Where it belongs, and how one comes by it.
    fn place(self) -> &'static str {
        match self {
            FileKind::Bike => {
                "bike files are for `run --bikes`; `roadbench bike new` writes them, `roadbench schema bike` has their keys"
            }
            FileKind::Motorcycle => {
                "motorcycle files are for `modes`, `replay` and scenarios; `roadbench schema motorcycle` has their keys"
            }
            FileKind::ChannelMap => {
                "channel maps are for `--map`; `roadbench map LOG` drafts them, `roadbench schema channel_map` has their keys"
            }
            FileKind::Scenario => "scenarios are for `simulate` and `plan`",
            FileKind::Pipeline => {
                "pipelines are for `--pipeline`; `roadbench schema pipeline` has their keys"
            }
            FileKind::Model => "models are for `--model`; `roadbench diagnose` writes them",
            FileKind::Tyre => {
                "tyre files are for `tyre`, `--front-tyre` and `--rear-tyre`; `roadbench export --format simulator` writes them"
            }
            FileKind::Coefficients => {
                "coefficients with intervals are what `roadbench export --format toml` writes, for people"
            }
        }
    }

    /// Whether a table has the keys by which the kind is known.
    fn is(self, table: &Table) -> bool {
        let has = |key: &str| table.contains_key(key);
        let is_table = |key: &str| table.get(key).is_some_and(Value::is_table);
        match self {
            FileKind::Bike => {
                let keys = ["mass", "wheelbase", "cg_to_front", "cg_height"];
                keys.iter().filter(|key| has(key)).count() >= 2
            }
            FileKind::Motorcycle => is_table("frame") && is_table("steering"),
            FileKind::ChannelMap => has("format") && (is_table("channel") || is_table("meta")),
            FileKind::Scenario => {
                let laps = table.get("laps").is_some_and(Value::is_integer);
                has("plans") || has("manoeuvres") || has("lap") || laps
            }
            FileKind::Pipeline => {
                let stages =
                    ["ingest", "filter", "segment", "estimate", "fit", "in_gear", "offroad"];
                stages.iter().any(|stage| is_table(stage))
            }
            FileKind::Model => has("session_id") && has("bike_id"),
            FileKind::Tyre => has("nominal_load") && is_table("tyre"),
            FileKind::Coefficients => {
                let of_session = |t: &Table| t.contains_key("pipeline_hash");
                table.get("session").and_then(Value::as_table).is_some_and(of_session)
            }
        }
    }

    /// The kind of a file's text, where it is one of them beyond doubt.
    pub fn of(text: &str) -> Option<Self> {
        let table: Table = text.parse().ok()?;
        let mut kinds = Self::ALL.into_iter().filter(|kind| kind.is(&table));
        kinds.next().filter(|_| kinds.next().is_none())
    }

    /// Message where a text of this kind is wanted and one of another is given.
    ///
    /// # Errors
    /// That sentence.
    pub fn expect(self, text: &str) -> Result<(), KeyError> {
        match Self::of(text) {
            Some(kind) if kind != self => Err(KeyError::WrongFile {
                found: kind.name(),
                wanted: self.name(),
                places: format!("{}; {}", kind.place(), self.place()),
            }),
            _ => Ok(()),
        }
    }
}
