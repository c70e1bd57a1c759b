//! What `--help` shows at its end: each command as it is typed. A test parses every line.

/// The program's own.
pub(crate) const ROADBENCH: &str = "\
Examples:
  roadbench demo                            what it does, in a minute
  roadbench run fixtures/archive -o out     tables and a report of an archive
  roadbench inspect ride.parquet            what a log holds, what it can give

Exit codes: 0 all done; 1 some logs rejected, or stopped; 2 bad usage;
3 the output cannot be written, or is damaged.

`roadbench help COMMAND` says more of a command.";

/// Of `run`.
pub(crate) const RUN: &str = "\
Examples:
  roadbench run ride.parquet --bikes bikes -o out
  roadbench run /archive/sessions -o /archive/tables --log-format json
  roadbench run 's3://fleet/sessions/bike=b1*/**/*.parquet' --bikes bikes -o out
  roadbench run fixtures/archive -o out -q
  roadbench run fixtures/archive -o out --dry-run
  roadbench run fixtures/archive -o out --model causes   causes: of `diagnose`";

/// Of `diagnose`.
pub(crate) const DIAGNOSE: &str = "\
Examples:
  roadbench diagnose ride.parquet --bikes bikes -o out
  roadbench diagnose fixtures/archive -o out --advise --json";

/// Of `show`.
pub(crate) const SHOW: &str = "\
Examples:
  roadbench show out                            the list of sessions
  roadbench show out --session archive_s0001    what this one gave
  roadbench show out --session archive_s0001 --json";

/// Of `compare`.
pub(crate) const COMPARE: &str = "\
Examples:
  roadbench compare out ride_07 ride_08
  roadbench compare out tyre=sport_a tyre=sport_b
  roadbench compare out bike=b1,2026-05-01..2026-05-07 bike=b1,2026-06-01..
  roadbench compare out ride_07 others --json     one ride against the rest
  roadbench compare out_before out_after -o comparison.parquet";

/// Of `plan`.
pub(crate) const PLAN: &str = "\
Examples:
  roadbench plan paper
  roadbench plan my_scenario.toml --json";

/// Of `simulate`.
pub(crate) const SIMULATE: &str = "\
Examples:
  roadbench simulate archive -o archive
  roadbench simulate lane_change --front-tyre front.tir --compare -o lane";

/// Of `modes`.
pub(crate) const MODES: &str = "\
Example:
  roadbench modes sports_touring";

/// Of `replay`.
pub(crate) const REPLAY: &str = "\
Example:
  roadbench replay ride.parquet --motorcycle sports_touring --bikes bikes -o out";

/// Of `tyre`.
pub(crate) const TYRE: &str = "\
Examples:
  roadbench tyre sharp2004_front_120_70
  roadbench tyre front.tir --against mf62_front_120_70 -o bench";

/// Of `inspect`.
pub(crate) const INSPECT: &str = "\
Example:
  roadbench inspect ride.parquet --bikes bikes";

/// Of `bike`.
pub(crate) const BIKE: &str = "\
Examples:
  roadbench bike new                            asks
  roadbench bike new mine --class naked --front 120/70ZR17 --rear 180/55ZR17
  roadbench bike new mine --model MT-07 --scales 128,134 --lifted 0.35,146
  roadbench bike new mine --model MT-07 --weight 260 --set wheelbase=1.403
  roadbench bike new default --class naked      for bikes that have no file";

/// Of `map`.
pub(crate) const MAP: &str = "\
Examples:
  roadbench map ride.csv                           a draft, with reasons
  roadbench map ride.csv --bike bikes/mine.toml -o my_logger.toml
  roadbench map ride.csv --map my_logger.toml      what contradicts the ride
  roadbench map ride.csv --map my_logger.toml --mend -o mended.toml";

/// Of `convert`.
pub(crate) const CONVERT: &str = "\
Examples:
  roadbench convert ride.csv --map my_logger.toml --dry-run
  roadbench convert ride.csv --map my_logger.toml -o ride.parquet";

/// Of `report`.
pub(crate) const REPORT: &str = "\
Examples:
  roadbench report out
  roadbench report out --pages shared             script and style once
  roadbench report out --open archive_s0001       the page of one session
  roadbench report out --figures figures          every plot, for a paper
  roadbench report out --figures figures --figure-format png";

/// Of `forget`.
pub(crate) const FORGET: &str = "\
Examples:
  roadbench forget out --session archive_s0003      one session
  roadbench forget out --bike archive_02            all of a motorcycle
  roadbench forget out --missing --dry-run          what has no log any more

The logs stay where they are: a run over them computes them again.";

/// Of `verify`.
pub(crate) const VERIFY: &str = "\
Examples:
  roadbench verify out                   files, rows and logs
  roadbench verify out --no-logs         the output alone
  roadbench verify out --mend            removes what is damaged

Exit code 1 where a file is not what was written, missing or nobody's.";

/// Of `export`.
pub(crate) const EXPORT: &str = "\
Examples, with ROADBENCH_BIKES=bikes in the environment:
  roadbench export out --session ride_07 --format toml
  roadbench export out --session ride_07 --format tir --tyre front -o front.tir
  roadbench export out --session ride_07 --format fmu --tyre rear -o rear.fmu
  roadbench export out --session ride_07 --format csv -o tyres.csv
  roadbench export out --session ride_07 --format c -o tyres.h";

/// Of `schema`.
pub(crate) const SCHEMA: &str = "\
Examples:
  roadbench schema
  roadbench schema coefficients";

/// Of `demo`.
pub(crate) const DEMO: &str = "\
Examples:
  roadbench demo
  roadbench demo -o /tmp/demo --no-open";

/// Of `completions`.
pub(crate) const COMPLETIONS: &str = "\
Examples:
  roadbench completions bash > /etc/bash_completion.d/roadbench
  roadbench completions zsh > ~/.zfunc/_roadbench
  roadbench completions fish > ~/.config/fish/completions/roadbench.fish";

/// Of `man`.
pub(crate) const MAN: &str = "\
Example:
  roadbench man ~/.local/share/man/man1";
