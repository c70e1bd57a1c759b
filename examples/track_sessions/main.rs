//! Track sessions from the file that a logger wrote to coefficients, with nothing edited by hand on the way.
//!
//! ```text
//! cargo run --release --example track_sessions -- --sessions 20
//! cargo run --release --example track_sessions -- --sessions 2 --seed 5 --verbose
//! cargo run --release --example track_sessions -- --seed 5 --profile satellite --channels   # the maps alone
//! ```
//!
//! Every session has a machine, a circuit, a rider, slopes, wind and an uneven road of its own. Each of the four
//! simulated loggers writes what it sees; `roadbench map` drafts the map, `run` reads the log by it with the bike
//! file, and the results are compared with the truth.

mod case;
#[path = "../channels/truth.rs"]
#[allow(dead_code)]
mod channels;
mod figures;

use std::path::Path;

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::loggers::Profile;
use roadbench::internals::simulate::track;

use case::{Drafted, PROFILES, asked, drafted, read, segmented, varied};
use figures::{Figures, Session};

#[derive(Parser)]
struct Arguments {
    /// Sessions of each logger.
    #[arg(long, default_value_t = 20)]
    sessions: usize,
    /// Seed of machines, circuits, riders and loggers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Steepest slope of the lap, drawn between these, rise over run; the built-in track's if not given.
    #[arg(long, num_args = 2, value_names = ["LEAST", "MOST"])]
    grade: Option<Vec<f64>>,
    /// Width over which the corners of the line are smoothed, m: with three times the built-in track's 9 m they are
    /// braked into and driven out of up to the apex.
    #[arg(long)]
    smoothing: Option<f64>,
    /// Read without the altitude.
    #[arg(long)]
    level: bool,
    /// A line per session and coefficient, and the drafted maps' faults.
    #[arg(long)]
    verbose: bool,
    /// One logger alone; may be given again for others.
    #[arg(long)]
    profile: Vec<String>,
    /// Judge the channels and no more: quick.
    #[arg(long)]
    channels: bool,
    /// Folder to keep the drafted maps in.
    #[arg(long)]
    maps: Option<std::path::PathBuf>,
}

fn main() {
    let arguments = Arguments::parse();
    let mut track = varied(arguments.seed);
    if let Some([least, most]) = arguments.grade.as_deref() {
        track.grade = [*least, *most];
    }
    track.smoothing = arguments.smoothing.unwrap_or(track.smoothing);
    let wanted = |p: &Profile| {
        arguments.profile.is_empty() || arguments.profile.iter().any(|name| name == p.name())
    };
    let profiles: Vec<Profile> = PROFILES.into_iter().filter(wanted).collect();
    let mut pipeline = Pipeline::onroad();
    pipeline.estimate.grade = !arguments.level;
    let work = tempfile::tempdir().expect("a folder for the logs");
    if arguments.channels {
        println!("{}", of_channels(&arguments, &profiles, work.path()));
        return;
    }
    let all: Vec<Result<Vec<Session>, String>> = (1..=arguments.sessions)
        .into_par_iter()
        .map(|number| {
            let ridden = track::ride(&track, number)?;
            let length = ridden.ride.session.duration();
            let sessions = profiles.iter().map(|&profile| {
                let read = read(profile, &ridden, track.seed, work.path(), &pipeline);
                keep(&arguments, number, profile, &read.judged.draft);
                let asked = asked(&ridden, read.circumference);
                let of = |o: &_| segmented(&ridden, o, read.earlier);
                let with = read.outcome.as_ref().ok().map(of);
                let without = read.without.as_ref().and_then(|o| o.as_ref().ok()).map(of);
                Session { number, profile, length, read, asked, with, without }
            });
            let sessions = sessions.collect();
            eprintln!("session {number}: {length:.0} s");
            Ok(sessions)
        })
        .collect();
    let mut figures = Figures::default();
    for sessions in all {
        match sessions {
            Ok(sessions) => sessions.iter().for_each(|s| figures.add(s, arguments.verbose)),
            Err(why) => println!("not ridden: {why}"),
        }
    }
    println!("{figures}");
}

/// The maps alone.
fn of_channels(arguments: &Arguments, profiles: &[Profile], folder: &Path) -> Figures {
    let track = varied(arguments.seed);
    let judge = |number: usize| -> Result<Vec<Drafted>, String> {
        let ridden = track::ride(&track, number)?;
        let of = |p: &Profile| {
            let map = drafted(*p, &ridden, track.seed, folder);
            keep(arguments, number, *p, &map.judged.draft);
            map
        };
        Ok(profiles.iter().map(of).collect())
    };
    let all: Vec<Result<Vec<Drafted>, String>> =
        (1..=arguments.sessions).into_par_iter().map(judge).collect();
    let mut figures = Figures::default();
    for (i, maps) in all.into_iter().enumerate() {
        match maps {
            Ok(maps) => maps.iter().zip(profiles).for_each(|(map, profile)| {
                figures.add_map(i + 1, *profile, &map.judged, map.circumference);
            }),
            Err(why) => println!("not ridden: {why}"),
        }
    }
    figures
}

fn keep(arguments: &Arguments, number: usize, profile: Profile, draft: &str) {
    if let Some(folder) = &arguments.maps {
        let path = folder.join(format!("{number:02}_{}.toml", profile.name()));
        std::fs::create_dir_all(folder).expect("made");
        std::fs::write(path, draft).expect("written");
    }
}
