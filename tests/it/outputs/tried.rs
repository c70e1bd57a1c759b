//! The options that write, and how each is tried.

/// A file that an option names, or that a command puts into a folder by a name of its own.
pub struct OfFile {
    pub option: &'static str,
    /// The command; `AT` is the path that is tried.
    pub line: &'static str,
    /// Where that path is, in the folder of the case.
    pub at: &'static str,
    /// One of the files that the command reads, and how it is said otherwise.
    pub input: Option<&'static str>,
    /// What is written has this in it.
    pub holds: &'static str,
}

pub const FILES: &[OfFile] = &[
    OfFile {
        option: "run --metrics",
        line: "run log.parquet --bikes bikes --out new --metrics AT",
        at: "it.prom",
        input: Some("log.parquet"),
        holds: "roadbench_sessions",
    },
    OfFile {
        option: "run --markdown",
        line: "run log.parquet --bikes bikes --out new --markdown AT",
        at: "it.md",
        input: Some("bikes/archive_01.toml"),
        holds: "# Tyre coefficients",
    },
    OfFile {
        option: "report --markdown",
        line: "report out --bench bench.csv --markdown AT",
        at: "it.md",
        input: Some("bench.csv"),
        holds: "# Tyre coefficients",
    },
    OfFile {
        option: "convert --out",
        line: "convert log.parquet --out AT",
        at: "it.parquet",
        input: Some("log.parquet"),
        holds: "PAR1",
    },
    OfFile {
        option: "compare --out",
        line: "compare out archive_s0001 others --out AT",
        at: "it.parquet",
        input: None,
        holds: "PAR1",
    },
    OfFile {
        option: "compare --page",
        line: "compare out archive_s0001 others --page AT",
        at: "it.html",
        input: None,
        holds: "archive_s0001 against others",
    },
    OfFile {
        option: "export --out",
        line: "export out --session archive_s0001 --format toml --bikes bikes --out AT",
        at: "it.toml",
        input: Some("bikes/archive_01.toml"),
        holds: "archive_s0001",
    },
    OfFile {
        option: "map --out",
        line: "map superbike.csv --out AT",
        at: "it.toml",
        input: Some("superbike.csv"),
        holds: "name =",
    },
    OfFile {
        option: "bike new --out",
        line: "bike new mine --class naked --weight 250 --force --out garage",
        at: "garage/mine.toml",
        input: None,
        holds: "wheelbase",
    },
    OfFile {
        option: "man DIR",
        line: "man pages",
        at: "pages/roadbench-run.1",
        input: None,
        holds: ".TH",
    },
    OfFile {
        option: "modes --out",
        line: "modes sports_small --out drawn",
        at: "drawn/modes.svg",
        input: None,
        holds: "<svg",
    },
    OfFile {
        option: "tyre --out",
        line: "tyre sharp2004_front_120_70 --out drawn",
        at: "drawn/bench.parquet",
        input: None,
        holds: "PAR1",
    },
    OfFile {
        option: "replay --out",
        line: "replay log.parquet --motorcycle sports_touring --bikes bikes --out drawn",
        at: "drawn/replay.parquet",
        input: Some("log.parquet"),
        holds: "PAR1",
    },
];

/// A folder that an option names.
pub struct OfFolder {
    pub option: &'static str,
    pub line: &'static str,
    /// What is in it then; none where the command takes too long for a test of it.
    pub holds: Option<&'static str>,
    /// Where somebody keeps sessions in the folder, if that matters.
    pub sessions: Option<&'static str>,
}

pub const FOLDERS: &[OfFolder] = &[
    OfFolder {
        option: "run --out",
        line: "run log.parquet --bikes bikes --out AT",
        holds: Some("report/index.html"),
        sessions: Some("sessions"),
    },
    OfFolder {
        option: "run --figures",
        line: "run log.parquet --bikes bikes --out new --figures AT",
        holds: Some("archive_s0001/timeline.svg"),
        sessions: None,
    },
    OfFolder {
        option: "diagnose --out",
        line: "diagnose log.parquet --bikes bikes --out AT",
        holds: None,
        sessions: Some("sessions"),
    },
    OfFolder {
        option: "simulate --out",
        line: "simulate short.toml --out AT",
        holds: Some("truth"),
        sessions: Some("sessions"),
    },
    OfFolder {
        option: "demo --out",
        line: "demo --no-open --out AT",
        holds: None,
        sessions: Some("archive/sessions"),
    },
    OfFolder {
        option: "report --figures",
        line: "report out --figures AT",
        holds: Some("archive_s0001/timeline.svg"),
        sessions: None,
    },
    OfFolder { option: "man DIR", line: "man AT", holds: Some("roadbench.1"), sessions: None },
    OfFolder {
        option: "bike new --out",
        line: "bike new mine --class naked --weight 250 --out AT",
        holds: Some("mine.toml"),
        sessions: None,
    },
    OfFolder {
        option: "modes --out",
        line: "modes sports_small --out AT",
        holds: Some("modes.parquet"),
        sessions: None,
    },
    OfFolder {
        option: "tyre --out",
        line: "tyre sharp2004_front_120_70 --out AT",
        holds: Some("bench.svg"),
        sessions: None,
    },
    OfFolder {
        option: "replay --out",
        line: "replay log.parquet --motorcycle sports_touring --bikes bikes --out AT",
        holds: Some("replay.parquet"),
        sessions: None,
    },
];
