//! The KIRO electric race motorcycle's logger: lines of several kinds in one text file.
//!
//! Every line ends with the logger's milliseconds. Three kinds carry what a tyre needs:
//!
//! ```text
//! $GPGGA,hhmmss.sss,ddmm.mmmm,N,dddmm.mmmm,W,$GPVTG,course,T,,M,knots,N,km/h,K,ms   1 Hz
//! 15,rpm,_,_,_,ms                                                                   5 Hz
//! susp front,rear,ms                                                               10 Hz
//! ```
//!
//! Each kind keeps its own clock. The columns are `gps_speed` (km/h), `gps_course`,
//! `gps_latitude`, `gps_longitude` (deg), `motor_speed` (rpm), `suspension_front`,
//! `suspension_rear` (uncalibrated counts); a channel map takes it from there.

use std::sync::Arc;

use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::ingest::formats::format::{Head, LogFormat};
use crate::ingest::ident;
use crate::ingest::maps::{ChannelMap, Maps, shipped_map};
use crate::ingest::raw::Column;
use crate::ingest::raw::{Identified, Raw};
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

pub(super) const FORMAT: LogFormat = LogFormat {
    name: "kiro",
    description: "The KIRO electric race motorcycle's text",
    channel_names: "column",
    extensions: &["txt"],
    maps: &[shipped_map!("kiro")],
    own_clock: true,
    sniff,
    identify,
    read,
    map,
    decoder: None,
};

const GPS: [&str; 4] = ["gps_speed", "gps_course", "gps_latitude", "gps_longitude"];
const MOTOR: [&str; 1] = ["motor_speed"];
const SUSPENSION: [&str; 2] = ["suspension_front", "suspension_rear"];

/// A line of one of the kinds at a line's beginning, and nothing but text.
fn sniff(head: &Head<'_>) -> bool {
    if head.bytes.contains(&0) {
        return false;
    }
    let text = String::from_utf8_lossy(head.bytes);
    let known = |l: &&str| {
        (l.starts_with("$GPGGA,") && l.contains("$GPVTG,"))
            || l.strip_prefix("susp ").is_some_and(|r| r.split(',').count() == 3)
    };
    text.lines().filter(known).take(3).count() == 3
}

fn choose<'a>(log: &Location, maps: Maps<'a>) -> Result<&'a ChannelMap, Error> {
    maps.of_format("kiro").into_iter().next().ok_or_else(|| {
        let message = format!(
            "{} is a KIRO log, and none of the channel maps given has format = \"kiro\"",
            log
        );
        Error::new(RejectionCode::NoChannelMap, message)
    })
}

fn identify(log: &Location, maps: Maps<'_>) -> Result<Identified, Error> {
    let map = choose(log, maps)?;
    let meta = ident::or(ident::from_path(log), map.meta.clone());
    Ok(Identified { meta, map: Some(map.name.clone()) })
}

fn map(log: &Location, maps: Maps<'_>) -> Result<Option<ChannelMap>, Error> {
    choose(log, maps).map(|map| Some(map.clone()))
}

fn read(log: &Location, maps: Maps<'_>) -> Result<Raw, Error> {
    let map = choose(log, maps)?;
    let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    let (columns, broken) = decode(&String::from_utf8_lossy(&bytes));
    let mut raw = Raw {
        meta: identify(log, maps)?.meta,
        tracks: map.apply(columns)?,
        warnings: Vec::new(),
        euler_yaw: map.euler_yaw,
        wheel_scale_sd: map.wheel_scale_sd(),
        imu: map.imu,
        map: Some(map.name.clone()),
        ..Raw::default()
    };
    if broken > 0 {
        let message = format!("{broken} lines of a known kind are incomplete; taken as missing");
        raw.warnings.push(warning("bad_line", None, broken, None, message));
    }
    Ok(raw)
}

/// One kind of line: its stamps and its columns.
struct LineColumns<const N: usize> {
    time: Vec<f64>,
    values: [Vec<f64>; N],
}

impl<const N: usize> LineColumns<N> {
    fn new() -> Self {
        LineColumns { time: Vec::new(), values: [const { Vec::new() }; N] }
    }

    fn push(&mut self, ms: f64, row: [f64; N]) {
        self.time.push(ms * 1e-3);
        self.values.iter_mut().zip(row).for_each(|(column, x)| column.push(x));
    }

    fn columns(self, names: [&str; N]) -> impl Iterator<Item = Column> {
        let time = Arc::new(self.time);
        let names = names.map(str::to_owned);
        self.values.into_iter().zip(names).map(move |(values, name)| Column {
            name,
            time: Arc::clone(&time),
            values,
        })
    }
}

/// All columns, and how many lines of a known kind could not be read.
fn decode(text: &str) -> (Vec<Column>, usize) {
    let (mut gps, mut motor, mut suspension) =
        (LineColumns::new(), LineColumns::new(), LineColumns::new());
    let mut broken = 0;
    for line in text.lines() {
        let line = line.trim_end();
        let done = if line.starts_with("$GPGGA") {
            gps_line(line).map(|(ms, row)| gps.push(ms, row))
        } else if let Some(rest) = line.strip_prefix("15,") {
            motor_line(rest).map(|(ms, row)| motor.push(ms, row))
        } else if let Some(rest) = line.strip_prefix("susp ") {
            suspension_line(rest).map(|(ms, row)| suspension.push(ms, row))
        } else {
            continue;
        };
        broken += usize::from(done.is_none());
    }
    let columns =
        gps.columns(GPS).chain(motor.columns(MOTOR)).chain(suspension.columns(SUSPENSION));
    (columns.collect(), broken)
}

/// A GPS line, two sentences in one; without a fix its numbers are missing. Where the logger
/// broke off the first sentence, the position is missing and the second one still stands.
fn gps_line(line: &str) -> Option<(f64, [f64; 4])> {
    let (position, motion) = line.split_once("$GPVTG,")?;
    let cells: Vec<&str> = motion.split(',').collect();
    let [course, "T", _, "M", _, "N", kmh, "K", ms] = cells[..] else { return None };
    let ms: f64 = ms.parse().ok()?;
    let number = |text: &str| text.parse().unwrap_or(f64::NAN);
    let motion = [number(kmh), number(course)];
    let cells: Vec<&str> = position.trim_end_matches(',').split(',').collect();
    match cells[..] {
        [_, _, latitude, ns, longitude, ew] => {
            let latitude = degrees(latitude, 2, ns == "S");
            let longitude = degrees(longitude, 3, ew == "W");
            Some((ms, [motion[0], motion[1], latitude, longitude]))
        }
        // nothing after the time of day: no fix
        [_, _] if position.ends_with(",,,,,") => Some((ms, [f64::NAN; 4])),
        _ => Some((ms, [motion[0], motion[1], f64::NAN, f64::NAN])),
    }
}

/// `ddmm.mmmm` or `dddmm.mmmm` in degrees; NaN if digits are missing, which the logger's lost
/// bytes do.
fn degrees(text: &str, digits: usize, negative: bool) -> f64 {
    let whole = text.get(..digits).and_then(|t| t.parse::<u16>().ok());
    let minutes = text.get(digits..).filter(|t| t.len() == 7).and_then(|t| t.parse::<f64>().ok());
    let (Some(whole), Some(minutes)) = (whole, minutes) else { return f64::NAN };
    let angle = f64::from(whole) + minutes / 60.0;
    if negative { -angle } else { angle }
}

/// `rpm,_,_,_,ms`; the speed is a signed 16-bit number, logged signed or unsigned.
fn motor_line(rest: &str) -> Option<(f64, [f64; 1])> {
    let cells: Vec<&str> = rest.split(',').collect();
    let [rpm, _, _, _, ms] = cells[..] else { return None };
    let rpm: i32 = rpm.parse().ok()?;
    let rpm = if (0x8000..0x1_0000).contains(&rpm) { rpm - 0x1_0000 } else { rpm };
    Some((ms.parse().ok()?, [f64::from(rpm)]))
}

fn suspension_line(rest: &str) -> Option<(f64, [f64; 2])> {
    let cells: Vec<&str> = rest.split(',').collect();
    let [front, rear, ms] = cells[..] else { return None };
    Some((ms.parse().ok()?, [front.parse().ok()?, rear.parse().ok()?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: &str = "susp 1066,1014,33897 \n\
        $GPGGA,163625.000,3916.0521,N,00911.3152,W,$GPVTG,140.50,T,,M,14.38,N,26.65,K,397451\n\
        $GPGGA,102308.000,3916.0,$GPVTG,99.29,T,,M,24.09,N,44.65,K,307347\n\
        $GPGGA,235942.800,,,,,$GPVTG,0.00,T,,M,0.00,N,0.00,K,2741\n\n\
        15,1550,0,274,4512,75499\n15,65526,0,0,0,75700\n11,1,2,3,4,75702\n";

    #[test]
    fn lines_become_columns_on_their_own_clocks() {
        let (columns, broken) = decode(LOG);
        assert_eq!(broken, 0);
        let of = |name: &str| columns.iter().find(|c| c.name == name).expect("there");
        assert_eq!(*of("gps_speed").time, [397.451, 307.347, 2.741]);
        assert_eq!(of("gps_speed").values[..2], [26.65, 44.65]);
        assert!(of("gps_speed").values[2].is_nan(), "no fix, no speed");
        assert!(of("gps_latitude").values[1].is_nan(), "broken off");
        assert!((of("gps_latitude").values[0] - (39.0 + 16.0521 / 60.0)).abs() < 1e-12);
        assert!((of("gps_longitude").values[0] + (9.0 + 11.3152 / 60.0)).abs() < 1e-12);
        assert_eq!(of("motor_speed").values, [1550.0, -10.0]);
        assert_eq!(of("suspension_rear").values, [1014.0]);
    }
}
