//! Clocks: units, calendars, forms of dates and times of day.

use super::Expected::{Refused, Right, Warned};
use super::*;

/// 2026-10-25 10:00:00 UTC.
const START: f64 = 1_792_922_400.0;

/// `hh:mm:ss.sss`
fn of_day(s: f64) -> String {
    let ms = (s * 1e3).round() as u64 % 86_400_000;
    format!("{:02}:{:02}:{:02}.{:03}", ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
}

/// `hh:mm:ss.sss AM`
fn of_half_day(s: f64) -> String {
    let hour = (s / 3600.0) as u64 % 24;
    let half = if hour < 12 { "AM" } else { "PM" };
    let shown = (hour + 11) % 12 + 1;
    format!("{shown}{} {half}", &of_day(s)[2..])
}

fn with(what: &'static str, clock: &str, stamp: impl Fn(usize, &Row) -> String) -> Case {
    case(what, csv(clock, &usual(), stamp), Right)
}

#[test]
fn units() {
    hold(vec![
        with("seconds", "Time (s)", |_, r| format!("{:.2}", r.t)),
        with("seconds without a unit, late", "Time", |_, r| format!("{:.2}", 123_456.0 + r.t)),
        with("milliseconds", "Time (ms)", |_, r| format!("{:.0}", 1e3 * r.t)),
        with("milliseconds without a unit", "time", |_, r| format!("{:.0}", 77_000.0 + 1e3 * r.t)),
        with("microseconds by the name", "micros", |_, r| format!("{:.0}", 4e8 + 1e6 * r.t)),
        with("microseconds without a unit", "timestamp", |_, r| format!("{:.0}", 4e8 + 1e6 * r.t)),
        with("nanoseconds without a unit", "t", |_, r| format!("{:.0}", 5e11 + 1e9 * r.t)),
        with("a suffix", "time_ms", |_, r| format!("{:.0}", 1e3 * r.t)),
        with("minutes", "Minutes", |_, r| format!("{:.6}", r.t / 60.0)),
        with("minutes without a unit", "Elapsed", |_, r| format!("{:.6}", r.t / 60.0)),
        with("hours", "Time (h)", |_, r| format!("{:.8}", r.t / 3600.0)),
        with("hundredths of a second", "tick", |_, r| format!("{:.0}", 1e2 * r.t)),
        with("milliseconds that hold seconds", "Time (ms)", |_, r| format!("{:.2}", r.t)),
        with("seconds that hold milliseconds", "Time (s)", |_, r| format!("{:.0}", 1e3 * r.t)),
        case(
            "a clock of no unit",
            csv("Time", &usual(), |_, r| format!("{:.3}", 17.3 * r.t)),
            Refused("contradict the motion"),
        ),
        case("no clock", csv("Counter", &usual(), |i, _| format!("{i}")), Refused("[time]")),
    ]);
}

/// Counters that come to their end go on; names and forms that loggers have.
#[test]
fn counters_and_other_forms() {
    let wrapped = |what, clock: &str, start: f64, turn: f64, scale: f64| {
        let places = if scale > 1.0 { 0 } else { 1 };
        let stamp = |_: usize, r: &Row| {
            format!("{:.places$}", (scale * (start + r.t)).round_ties_even().rem_euclid(turn))
        };
        let part = |_: usize, r: &Row| format!("{:.places$}", (start + r.t).rem_euclid(turn));
        let text = match places {
            0 => csv(clock, &usual(), stamp),
            _ => csv(clock, &usual(), part),
        };
        case(what, text, Warned("time_wrapped"))
    };
    let second = |_: usize, r: &Row| format!("{:.1}", (45.0 + r.t) % 60.0);
    hold(vec![
        wrapped("16 bits of ms", "Time (ms)", 55.0, 65_536.0, 1e3),
        wrapped("32 bits of ms", "millis", 4_294_950.0, 4_294_967_296.0, 1e3),
        wrapped("32 bits of us", "micros", 4280.0, 4_294_967_296.0, 1e6),
        wrapped("the week of GPS", "TOW", 604_790.0, 604_800.0, 1.0),
        Case { expected: Warned("time_wrapped"), ..with("second of the minute", "Second", second) },
        with("seconds called ts", "ts", |_, r| format!("{:.3}", START + r.t)),
        with("iTOW", "iTOW", |_, r| format!("{:.0}", 208_785_000.0 + 1e3 * r.t)),
        with("datenum", "datenum", |_, r| format!("{:.10}", 740_279.416_493 + r.t / 86_400.0)),
        with("groups of digits", "Zeit (ms)", |_, r| {
            let ms = (1e3 * r.t).round() as u64;
            if ms < 1000 { ms.to_string() } else { format!("{}'{:03}", ms / 1000, ms % 1000) }
        }),
        with("digits of date and time", "time", |_, r| {
            format!("20261025{}", of_day(36_045.0 + r.t).replace(':', ""))
        }),
        with("digits of date and time in ms", "timestamp", |_, r| {
            format!("20261025{}", of_day(36_045.0 + r.t).replace([':', '.'], ""))
        }),
        with("a month in German", "Zeit", |_, r| {
            format!("25. Okt. 2026 {}", of_day(36_045.0 + r.t))
        }),
        with("a zone by its name", "time", |_, r| {
            format!("2026-10-25 {} CEST", of_day(36_045.0 + r.t))
        }),
        with("a. m.", "Hora", |_, r| format!("25/10/2026 {} a. m.", of_day(36_045.0 + r.t))),
        with("dots", "Ora", |_, r| of_day(36_045.0 + r.t).replace(':', ".")),
        Case {
            expected: Refused("run backwards"),
            ..with("backwards", "Time (s)", |_, r| format!("{:.2}", 60.0 - r.t))
        },
        Case {
            expected: Refused("too few digits"),
            ..with("as a spreadsheet writes it", "Timestamp (ms)", |_, _| "1.79284E+12".to_owned())
        },
    ]);
}

/// A speed in a scale that its name does not say moves no clock.
#[test]
fn scales_of_the_speed() {
    let with_speed = |what, name: &str, scale: f64| {
        let mut text = format!("Time (s),{name},Latitude (deg),Longitude (deg),Lean (deg)\n");
        for r in &usual() {
            let v = (scale * r.kmh()).round();
            let _ = writeln!(text, "{:.2},{v},{:.7},{:.7},{:.1}", r.t, r.lat, r.lon, r.lean);
        }
        case(what, text, Right)
    };
    hold(vec![
        with_speed("tenths of km/h without a word", "gps_speed", 10.0),
        with_speed("hundredths of km/h with one", "GPS Speed (0.01 km/h)", 100.0),
        with_speed("cm/s without a word", "gps_speed", 100.0 / 3.6),
    ]);
}

/// The start time is that of the part that is read.
#[test]
fn the_start_is_of_what_is_read() {
    let rows = ride(120, 0.5);
    let of = |clock: &str, stamp: &dyn Fn(&Row) -> String| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("ride.csv");
        std::fs::write(&path, csv(clock, &rows, |_, r| stamp(r))).expect("written");
        let (session, warnings, map) = read(&path).expect(clock);
        session.meta.start_time.unwrap_or_else(|| panic!("{clock}: no start, {warnings:?}\n{map}"))
    };
    let unix = |s: f64| format!("{:.1}", s);
    // not set before the first fix
    let before_fix =
        |r: &Row| if r.t < 8.0 { unix(315_964_800.0 + r.t) } else { unix(START + r.t) };
    assert_eq!(of("Time", &before_fix), "2026-10-25T10:00:08Z");
    // put right from the time of GPS to UTC
    let leap = |r: &Row| unix(START + r.t + if r.t < 8.0 { 18.0 } else { 0.0 });
    assert_eq!(of("Time", &leap), "2026-10-25T10:00:00Z");
    assert_eq!(
        of("Date,Time", &|r| format!("25/10/2026,{}", of_day(36_000.0 + r.t))),
        "2026-10-25T10:00:00Z"
    );
    let nmea = |r: &Row| format!("251026,{}", of_day(36_000.0 + r.t).replace(':', ""));
    assert_eq!(of("date,time", &nmea), "2026-10-25T10:00:00Z");
    let parts = |r: &Row| format!("2026,10,25,10,{},{:.1}", (r.t / 60.0).floor(), r.t % 60.0);
    assert_eq!(of("Year,Month,Day,Hour,Min,Sec", &parts), "2026-10-25T10:00:00Z");
}

#[test]
fn calendars() {
    hold(vec![
        with("Unix seconds", "Time", |_, r| format!("{:.3}", START + r.t)),
        with("Unix milliseconds", "timestamp", |_, r| format!("{:.0}", 1e3 * (START + r.t))),
        with("Unix milliseconds, `utc (ms)`", "utc (ms)", |_, r| {
            format!("{:.0}", 1e3 * (START + r.t))
        }),
        with("Unix milliseconds that say seconds", "Time (s)", |_, r| {
            format!("{:.0}", 1e3 * (START + r.t))
        }),
        with("Unix microseconds", "Timestamp", |_, r| format!("{:.0}", 1e6 * (START + r.t))),
        with("Unix nanoseconds", "time_ns", |_, r| format!("{:.0}", 1e9 * (START + r.t))),
        with("days of a spreadsheet", "Date", |_, r| {
            format!("{:.9}", 25_569.0 + (START + r.t) / 86_400.0)
        }),
        with("days of MATLAB", "datetime", |_, r| {
            format!("{:.9}", 719_529.0 + (START + r.t) / 86_400.0)
        }),
        with("ticks of .NET", "Timestamp", |_, r| {
            format!("{:.0}", 1e7 * (62_135_596_800.0 + START + r.t))
        }),
        with("digits of a receiver", "UTC", |_, r| of_day(36_045.0 + r.t).replace(':', "")),
    ]);
}

#[test]
fn dates_and_times_of_day() {
    let iso = |s: f64, zone: &str| format!("2026-10-25T{}{zone}", of_day(s));
    hold(vec![
        with("over midnight", "Time", |_, r| of_day(86_385.0 + r.t)),
        with("over noon on a clock of twelve hours", "Time", |_, r| of_half_day(43_185.0 + r.t)),
        with("over one o'clock on one without AM", "Time", |_, r| {
            of_half_day(46_785.0 + r.t).replace(" PM", "")
        }),
        with("minutes and seconds over the hour", "Time", |_, r| {
            of_day(3585.0 + r.t)[3..].to_owned()
        }),
        with("hours of one digit", "time", |_, r| {
            of_day(35_999.0 + r.t).trim_start_matches('0').to_owned()
        }),
        with("milliseconds behind a colon", "time", |_, r| {
            of_day(36_000.0 + r.t).replace('.', ":")
        }),
        with("ISO 8601", "Time", |_, r| iso(36_000.0 + r.t, "Z")),
        with("with a zone", "Time", |_, r| iso(36_000.0 + r.t, "+02:00")),
        with("with a blank", "DateTime", |_, r| iso(36_000.0 + r.t, "").replace('T', " ")),
        with("day.month.year", "Datum Uhrzeit", |_, r| {
            format!("25.10.2026 {}", of_day(36_000.0 + r.t))
        }),
        with("day/month/year", "Time", |_, r| format!("25/10/2026 {}", of_day(36_000.0 + r.t))),
        with("month/day/year", "Time", |_, r| {
            format!("10/25/2026 {}", of_half_day(43_185.0 + r.t))
        }),
        with("which is the day, over midnight", "Time", |_, r| {
            let day = if r.t < 15.0 { "10/11/2026" } else { "11/11/2026" };
            format!("{day} {}", of_day(86_385.0 + r.t))
        }),
        with("with the month's name", "Time", |_, r| {
            format!("25-Oct-2026 {}", of_day(36_000.0 + r.t))
        }),
        with("a span of pandas", "Time", |_, r| format!("0 days {}", of_day(r.t))),
        Case {
            expected: Warned("bad_cell"),
            ..with("date and time apart", "Date,Time", |_, r| {
                format!("25.10.2026,{}", of_day(86_385.0 + r.t))
            })
        },
        with("a lap's time in front", "Lap Time,Time (s)", |i, r| {
            format!("{:.2},{:.2}", 0.5 * (i % 20) as f64, r.t)
        }),
        case(
            "dates among numbers",
            csv(
                "Time",
                &usual(),
                |i, r| if i % 2 == 0 { format!("{:.2}", r.t) } else { of_day(r.t) },
            ),
            Refused(""),
        ),
    ]);
}

#[test]
fn whole_seconds_of_a_fast_log() {
    let at = |what, step: f64, seconds: f64| {
        let rows = ride((seconds / step) as usize, step);
        let text = csv("Time (s)", &rows, |_, r| format!("{:.0}", (r.t + 1e-6).floor()));
        Case { what, file: "ride.csv", bytes: text.into(), rows, expected: Right }
    };
    hold(vec![at("30 Hz", 1.0 / 30.0, 40.0), at("10 Hz", 0.1, 40.0)]);
}

/// A map that says a wrong unit.
#[test]
fn a_maps_wrong_unit_is_refused_with_the_right_one() {
    let map = |unit: &str| {
        let text = format!(
            "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 'Time'\nunit = '{unit}'\n[channel.velocity_x]\n\
             from = 'GPS Speed (km/h)'\n[channel.latitude]\nfrom = 'Latitude (deg)'\n[channel.longitude]\n\
             from = 'Longitude (deg)'\n"
        );
        ChannelMap::parse(&text, "m.toml").expect("a map")
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ride.csv");
    let stamps: [(&str, f64, f64, &str); 5] = [
        ("s", START, 1e3, "unit = \"ms\""),
        ("s", START, 1e6, "unit = \"us\""),
        ("ms", 0.0, 1.0, "implausible_clock"),
        ("s", 0.0, 1e3, "no logger"),
        ("s", 0.0, 60.0, "contradicts the motion"),
    ];
    for (unit, start, times, words) in stamps {
        let text = csv("Time", &usual(), |_, r| format!("{:.3}", times * (start + r.t)));
        std::fs::write(&path, text).expect("written");
        let error = ingest::read(&path, &[map(unit)]).expect_err("a wrong unit");
        let said = format!("{error} ({})", error.code);
        assert!(
            error.code.as_str() == "implausible_clock" && said.contains(words),
            "{unit}, {times}: {said}"
        );
    }
    let text = csv("Time", &usual(), |_, r| format!("{:.3}", START + r.t));
    std::fs::write(&path, text).expect("written");
    assert!(ingest::read(&path, &[map("s")]).is_ok());
}

/// Stamps with a date give the start time.
#[test]
fn a_drafted_clock_knows_the_day() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ride.csv");
    type Form = fn(&Row) -> String;
    let forms: [(&str, Form); 3] = [
        ("timestamp", |r| format!("{:.0}", 1e3 * (START + r.t))),
        ("Date", |r| format!("{:.9}", 25_569.0 + (START + r.t) / 86_400.0)),
        ("Time", |r| format!("25.10.2026 {}", of_day(36_000.0 + r.t))),
    ];
    for (clock, form) in forms {
        std::fs::write(&path, csv(clock, &usual(), |_, r| form(r))).expect("written");
        let (session, _, map) = read(&path).expect("read");
        let start = session.meta.start_time.unwrap_or_default();
        assert!(start.starts_with("2026-10-25T10:00:00"), "{clock}: {start}\n{map}");
    }
}
