//! Sessions written as racing loggers and their programs write them.
//!
//! Units are the loggers' (km/h, g, bar, deg, %), names those of the shipped channel maps. The
//! `.ld` files are written by another's writer (the crate motec-i2).

use std::fmt::Write as _;
use std::io::Cursor;

use motec_i2::{ChannelMetadata, Datatype, Header, LDWriter, Sample};
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::ingest::maps as map;
use roadbench::internals::ingest::maps::{ChannelMap, Entry};
use roadbench::internals::ingest::motion::yaw::trace_angle;

/// Digits after the point in every text.
pub const DIGITS: usize = 5;

/// A map that comes with the program.
pub fn shipped(name: &str) -> &'static ChannelMap {
    map::file::shipped().iter().find(|m| m.name == name).expect(name)
}

/// A channel as a logger has it.
pub struct Logged {
    pub name: String,
    pub unit: &'static str,
    pub channel: Channel,
    pub values: Vec<f64>,
    /// Of one in the logger's unit, in SI.
    pub factor: f64,
}

/// What a logger writes for these channels.
fn unit(entry: &Entry) -> &'static str {
    use Channel::*;
    match entry.channel {
        VelocityX | VelocityY | WheelSpeedFront | WheelSpeedRear => "km/h",
        AccelerationX | AccelerationY => "g",
        Roll | Pitch | Yaw | SteerAngle | Latitude | Longitude => "deg",
        RollRate | PitchRate | YawRate => "deg/s",
        BrakePressureFront | BrakePressureRear => "bar",
        Throttle => "%",
        AirTemperature | TyreTemperatureFront | TyreTemperatureRear => "°C",
        Altitude => "m",
        _ => "",
    }
}

/// The session's channels that a map reads, in a logger's units.
pub fn logged(map: &ChannelMap, session: &Session) -> Vec<Logged> {
    let there = map.entries.iter().filter(|e| session.has(e.channel));
    there
        .map(|entry| {
            let unit = unit(entry);
            let to_si = entry.converted(if unit.is_empty() { "1" } else { unit }).expect(unit);
            let si = session.get(entry.channel).expect("there");
            let values = si.iter().map(|v| (v - to_si.offset) / to_si.factor).collect();
            let (name, factor) = (entry.from[0].clone(), to_si.factor.abs());
            Logged { name, unit, channel: entry.channel, values, factor }
        })
        .collect()
}

fn cell(x: f64, digits: usize, decimal: char) -> String {
    if !x.is_finite() {
        return String::new();
    }
    format!("{x:.digits$}").replace('.', &decimal.to_string())
}

/// MoTeC i2's CSV.
pub fn motec_csv(session: &Session) -> String {
    let channels = logged(shipped("motec_csv"), session);
    let quoted = |cells: Vec<String>| -> String {
        let cells: Vec<String> = cells.iter().map(|c| format!("\"{c}\"")).collect();
        cells.join(",") + "\r\n"
    };
    let mut text = format!(
        "\"Format\",\"MoTeC CSV File\",,,\"Workbook\",\"\"\r\n\"Venue\",\"Test\"\r\n\
         \"Vehicle\",\"archive_01\"\r\n\"Driver\",\"Somebody\"\r\n\"Log Date\",\"01/05/2026\"\r\n\
         \"Log Time\",\"10:00:00\"\r\n\"Sample Rate\",\"{:.3}\",\"Hz\"\r\n\r\n\r\n",
        session.rate
    );
    let row = |first: String, of: &dyn Fn(&Logged) -> String| {
        quoted(std::iter::once(first).chain(channels.iter().map(of)).collect())
    };
    text += &row("Time".into(), &|c| c.name.clone());
    text += &row("s".into(), &|c| c.unit.into());
    text += "\r\n\r\n";
    for i in 0..session.len {
        text += &row(format!("{:.3}", session.time(i)), &|c| cell(c.values[i], DIGITS, '.'));
    }
    text
}

/// AiM's CSV as a European computer writes it.
pub fn aim_csv(session: &Session) -> String {
    let channels = logged(shipped("aim_csv"), session);
    let mut text = format!(
        "\"Format\";\"AiM CSV File\"\n\"Session\";\"Test\"\n\"Vehicle\";\"archive_01\"\n\
         \"Racer\";\"Somebody\"\n\"Date\";\"Friday, May 1, 2026\"\n\"Time\";\"10:00 AM\"\n\
         \"Sample Rate\";\"{}\"\n\n\"Time\"",
        session.rate
    );
    for c in &channels {
        let _ = write!(text, ";\"{}\"", c.name);
    }
    text += "\n\"s\"";
    for c in &channels {
        let _ = write!(text, ";\"{}\"", c.unit);
    }
    text += "\n\n";
    for i in 0..session.len {
        text += &cell(session.time(i), 3, ',');
        for c in &channels {
            text.push(';');
            text += &cell(c.values[i], DIGITS, ',');
        }
        text.push('\n');
    }
    text
}

/// RaceChrono's CSV v3: what comes from the GPS stands in every tenth row only.
pub fn racechrono_v3(session: &Session) -> String {
    let channels = logged(shipped("racechrono_v3"), session);
    let mut text = "This file is created using RaceChrono Pro v9.1.3 ( http://racechrono.com/ ).\n\
        Format,3\nSession title,\"Test\"\nTrack name,\"Test\"\nDriver name,Somebody\n\n\
        timestamp,fragment_id,lap_number,elapsed_time"
        .to_owned();
    let split = |c: &Logged| {
        let (device, name) = c.name.split_once('/').expect("device/name");
        (device.to_owned(), name.to_owned())
    };
    for c in &channels {
        let _ = write!(text, ",{}", split(c).1);
    }
    text += "\nunix time,,,s";
    for c in &channels {
        let _ = write!(text, ",{}", c.unit.replace("°C", ".C"));
    }
    text += "\n,,,";
    for c in &channels {
        let number = if split(c).0 == "gps" { 100 } else { 300 };
        let _ = write!(text, ",{number}: {}", split(c).0);
    }
    text.push('\n');
    let start = 1_777_629_600.0;
    for i in 0..session.len {
        let t = session.time(i);
        let _ = write!(text, "{:.3},0,1,{t:.3}", start + t);
        for c in &channels {
            text.push(',');
            if !c.name.starts_with("gps/") || i % 10 == 0 {
                text += &cell(c.values[i], DIGITS, '.');
            }
        }
        text.push('\n');
    }
    text
}

/// What an XSens unit on the session's motorcycle measures, with MT Manager's text around it.
pub fn xsens(session: &Session) -> String {
    let mut text = "// General information: \n//  MT Manager version: 2022.2.0 \n\
        // Device information: \n//  DeviceId: 07780001\n// Coordinate system: ENU\n\
        PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tRoll\tPitch\tYaw\t\
        Vel_X\tVel_Y\tVel_Z\n"
        .to_owned();
    let of = |c: Channel, i: usize| session.get(c).map_or(0.0, |v| v[i]);
    for i in 0..session.len {
        use Channel::*;
        let [roll, pitch, trace] = [Roll, Pitch, Yaw].map(|c| of(c, i));
        let turn = trace_angle(roll, pitch);
        let yaw = trace - turn;
        // from the trace's frame to that of the Euler yaw, and to the ground
        let turned = |x: f64, y: f64, by: f64| {
            let (sin, cos) = by.sin_cos();
            (x * cos - y * sin, y * cos + x * sin)
        };
        let (ax, ay) = turned(of(AccelerationX, i), of(AccelerationY, i), turn);
        let (east, north) = turned(of(VelocityX, i), of(VelocityY, i), trace);
        let ((sr, cr), (sp, cp)) = (roll.sin_cos(), pitch.sin_cos());
        let g = 9.80665;
        let (forward, up) = (ax * cp - g * sp, ax * sp + g * cp);
        let acc = [forward, ay * cr + up * sr, up * cr - ay * sr];
        let [p, q, r] = [RollRate, PitchRate, YawRate].map(|c| of(c, i));
        let gyr = [p - r * sp, q * cr + r * sr * cp, r * cr * cp - q * sr];
        let ticks = (4_294_960_000_u64 + i as u64 * (1e4 / session.rate) as u64) % (1 << 32);
        let _ = write!(text, "{:05}\t{ticks}", (65_000 + i) % 65_536);
        for x in acc.iter().chain(&gyr).chain(&[roll, pitch, yaw].map(f64::to_degrees)) {
            let _ = write!(text, "\t{x:.7}");
        }
        let _ = writeln!(text, "\t{east:.7}\t{north:.7}\t0.0000000");
    }
    text
}

/// A `.ld` file by the crate motec-i2: the first channels in whole numbers, the others in f32.
pub fn motec_ld(session: &Session) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let header = Header {
        channel_meta_ptr: 0x3448,
        channel_data_ptr: 0,
        event_ptr: 0,
        device_serial: 12007,
        device_type: "ADL".into(),
        device_version: 420,
        num_channels: 0,
        date_string: "01/05/2026".into(),
        time_string: "10:00:00".into(),
        driver: "Somebody".into(),
        vehicleid: "archive_01".into(),
        venue: "Test".into(),
        session: "2".into(),
        short_comment: "written by motec-i2".into(),
    };
    let mut writer = LDWriter::new(&mut file, header);
    for (k, c) in logged(shipped("motec_ld"), session).into_iter().enumerate() {
        let whole = k < 4;
        let channel = ChannelMetadata {
            prev_addr: 0,
            next_addr: 0,
            data_addr: 0,
            data_count: 0,
            datatype: if whole { Datatype::I32 } else { Datatype::F32 },
            sample_rate: session.rate as u16,
            offset: 0,
            mul: 1,
            scale: 1,
            dec_places: if whole { DIGITS as i16 } else { 0 },
            name: c.name.clone(),
            short_name: String::new(),
            unit: c.unit.replace("°C", "C"),
        };
        let scaled = |v: &f64| match whole {
            true => Sample::I32((v * 10_f64.powi(DIGITS as i32)).round() as i32),
            false => Sample::F32(*v as f32),
        };
        writer = writer.with_channel(channel, c.values.iter().map(scaled).collect());
    }
    writer.write().expect("in memory");
    file.into_inner()
}

/// A `.CTRK` file by the specification of ctrk-exporter.
pub fn ctrk(session: &Session) -> Vec<u8> {
    let mut out = b"HEAD".to_vec();
    out.resize(0x34, 0);
    out.extend([0x1f, 0, 0, 0, 0x11]);
    out.extend(b"RECORDLINE.P1.LAT(\xa1\xf2\xaf\xe5\x95\xf9\x47\x40");
    let mut record = |kind: u16, ms: u64, payload: &[u8]| {
        let (s, ms) = (ms / 1000, (ms % 1000) as u16);
        out.extend(kind.to_le_bytes());
        out.extend((14 + payload.len() as u16).to_le_bytes());
        out.extend(ms.to_le_bytes());
        out.extend([(s % 60) as u8, (s / 60 % 60) as u8, 12, 2, 29, 7]);
        out.extend(2025_u16.to_le_bytes());
        out.extend(payload);
    };
    let of = |c: Channel, i: usize| session.get(c).map_or(0.0, |v| v[i]);
    let raw = |x: f64| (x.round().clamp(0.0, 65535.0) as u16).to_be_bytes();
    for i in 0..session.len {
        use Channel::*;
        let ms = (session.time(i) * 1e3).round() as u64;
        let mut frame = |id: u16, data: &[u8]| {
            let mut payload = id.to_le_bytes().to_vec();
            payload.extend([0, 0, data.len() as u8]);
            payload.extend(data);
            record(1, ms, &payload);
        };
        let [front, rear] = [WheelSpeedFront, WheelSpeedRear].map(|c| raw(of(c, i) * 0.30 * 64.0));
        frame(0x0264, &[front, rear].concat());
        if i % 2 == 0 {
            let pressures =
                [BrakePressureFront, BrakePressureRear].map(|c| raw(of(c, i) / 1e5 * 32.0));
            frame(0x0260, &[pressures[0], pressures[1], [0; 2], [0; 2]].concat());
            frame(0x0209, &[0x64, 0, 0, 0, of(Gear, i) as u8, 0]);
        }
        let throttle = raw(of(Throttle, i) * 84.96 * 8.192);
        frame(0x0215, &[throttle, throttle, [0; 2], [0; 2]].concat());
        frame(
            0x0250,
            &[raw((of(AccelerationX, i) / 9.80665 + 7.0) * 1e3), raw(7e3), [0; 2], [0; 2]].concat(),
        );
        // the satellite's speed comes 0.2 s late
        if ms % 1000 == 200 {
            let (s, then) = (ms / 1000, i - (0.2 * session.rate).round() as usize);
            let body = format!(
                "GPRMC,12{:02}{:02}.200,A,4757.0410,N,00012.5240,E,{:.3},334.60,290725,,,A",
                s / 60 % 60,
                s % 60,
                of(VelocityX, then) * 3600.0 / 1852.0
            );
            let sum = body.bytes().fold(0, |a, b| a ^ b);
            record(2, ms, format!("${body}*{sum:02X}\r\n\0").as_bytes());
        }
    }
    out.extend(br#"{"Attribute":[{"Key":"CircuitName","Value":"Test"},{"Key":"User","Value":"Somebody"}]}"#);
    out
}
