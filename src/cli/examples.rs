//! What `--help` shows at its end: each command as it is typed. A test parses every line.

/// The program's own.
pub(crate) const ROADBENCH: &str = "\
Examples:
  roadbench demo                                          what it does, in a minute
  roadbench run fixtures/archive --out out                an archive in, tables and a report out
  roadbench inspect ride.parquet --bikes bikes            what a log holds, what it can give
Exit codes: 0 all done; 1 some logs rejected, or stopped; 2 bad usage; 3 the output cannot be written.";

/// Of `run`.
pub(crate) const RUN: &str = "\
Examples:
  roadbench run ride.parquet --bikes bikes --out out
  roadbench run /archive/sessions --out /archive/tables --log-format json
  roadbench run 's3://fleet/archive/sessions/bike=b1*/**/*.parquet' --bikes bikes --out tables
  roadbench run fixtures/archive --out out --dry-run
  roadbench run fixtures/archive --out out --model causes      causes: the output of `diagnose`";

/// Of `diagnose`.
pub(crate) const DIAGNOSE: &str = "\
Examples:
  roadbench diagnose ride.parquet --bikes bikes --out out
  roadbench diagnose fixtures/archive --out out --advise --json";

/// Of `plan`.
pub(crate) const PLAN: &str = "\
Examples:
  roadbench plan paper
  roadbench plan my_scenario.toml --json";

/// Of `simulate`.
pub(crate) const SIMULATE: &str = "\
Examples:
  roadbench simulate archive --out archive
  roadbench simulate lane_change --front-tyre sharp2004_front_120_70 --compare --out lane";

/// Of `modes`.
pub(crate) const MODES: &str = "\
Example:
  roadbench modes sports_touring";

/// Of `replay`.
pub(crate) const REPLAY: &str = "\
Example:
  roadbench replay ride.parquet --motorcycle sports_touring --bikes bikes --out replayed";

/// Of `tyre`.
pub(crate) const TYRE: &str = "\
Examples:
  roadbench tyre sharp2004_front_120_70
  roadbench tyre front.tir --against mf62_front_120_70 --out bench";

/// Of `inspect`.
pub(crate) const INSPECT: &str = "\
Example:
  roadbench inspect ride.parquet --bikes bikes";

/// Of `bike`.
pub(crate) const BIKE: &str = "\
Examples:
  roadbench bike new                                      asks
  roadbench bike new mine --class naked --front 120/70ZR17 --rear 180/55ZR17 --weight 260
  roadbench bike new mine --model MT-07 --scales 128,134 --lifted 0.35,146 --set wheelbase=1.403
  roadbench bike new default --class naked                for bikes that have no file";

/// Of `map`.
pub(crate) const MAP: &str = "\
Examples:
  roadbench map ride.csv                                  the draft of a channel map, with reasons
  roadbench map ride.csv --bike bikes/mine.toml --out my_logger.toml
  roadbench map ride.csv --map my_logger.toml             what in this map contradicts the ride
  roadbench map ride.csv --map my_logger.toml --mend --out mended.toml";

/// Of `convert`.
pub(crate) const CONVERT: &str = "\
Examples:
  roadbench convert ride.csv --map my_logger.toml --dry-run
  roadbench convert ride.csv --map my_logger.toml --out ride.parquet";

/// Of `report`.
pub(crate) const REPORT: &str = "\
Examples:
  roadbench report out
  roadbench report out --pages shared                     script and style once beside the pages
  roadbench report out --open archive_s0001               the page of one session, in the browser
  roadbench report out --figures figures                  every plot, for a paper
  roadbench report out --figures figures --figure-format png";

/// Of `forget`.
pub(crate) const FORGET: &str = "\
Examples:
  roadbench forget out --session archive_s0003            one session
  roadbench forget out --bike archive_02                  all of a motorcycle
  roadbench forget out --missing --dry-run                what has no log any more

The logs stay where they are: a run over them computes them again.";

/// Of `verify`.
pub(crate) const VERIFY: &str = "\
Examples:
  roadbench verify out                   files, rows and logs
  roadbench verify out --no-logs         the output alone
  roadbench verify out --mend            removes what is damaged; the next run computes it again

Exit code 1 where a file is not what was written, missing or nobody's.";

/// Of `export`.
pub(crate) const EXPORT: &str = "\
Examples:
  roadbench export out --session archive_s0001 --format tir --tyre front --bikes bikes --out front.tir
  roadbench export out --session archive_s0001 --format toml
  roadbench export out --session archive_s0001 --format csv --bikes bikes --out tyres.csv
  roadbench export out --session archive_s0001 --format c --bikes bikes --out tyres.h
  roadbench export out --session archive_s0001 --format fmu --tyre rear --bikes bikes --out rear.fmu";

/// Of `schema`.
pub(crate) const SCHEMA: &str = "\
Examples:
  roadbench schema
  roadbench schema coefficients";

/// Of `demo`.
pub(crate) const DEMO: &str = "\
Examples:
  roadbench demo
  roadbench demo --out /tmp/demo --no-open";

/// Of `completions`.
pub(crate) const COMPLETIONS: &str = "\
Examples:
  roadbench completions bash > ~/.local/share/bash-completion/completions/roadbench
  roadbench completions zsh > ~/.zfunc/_roadbench
  roadbench completions fish > ~/.config/fish/completions/roadbench.fish";

/// Of `man`.
pub(crate) const MAN: &str = "\
Example:
  roadbench man ~/.local/share/man/man1";
