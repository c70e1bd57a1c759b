//! A TYDEX file as points: units, axes and missing values resolved.

use std::path::Path;

use super::channel::{Axes, Meaning};
use super::fault::Fault;
use super::line::{Entry, columns};
use super::rows::Rows;
use super::{Bench, Error, Point};
use crate::contract::schema::closest;

/// Sections of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    Header,
    Constants,
    Channels,
    Data,
    Else,
}

/// Names of sections that are passed over.
const OTHERS: [&str; 6] = [
    "COMMENTS",
    "MODELDEFINITION",
    "MODELPARAMETERS",
    "MODELCOEFFICIENTS",
    "MODELCHANNELS",
    "MODELOUTPUTS",
];

/// Reads a file.
///
/// # Errors
/// See [`Error`].
pub fn read(path: &Path) -> Result<Bench, Error> {
    let bytes =
        std::fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    parse(&bytes, path)
}

/// Reads a file's bytes; `path` is for messages. Bytes that are not UTF-8 are Latin-1.
///
/// # Errors
/// See [`Error`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Bench, Error> {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    };
    let mut reader = Reader::default();
    for (i, line) in text.lines().enumerate() {
        let at = i + 1;
        let fail = |message| Error::Line { path: path.to_owned(), line: at, message };
        reader.line(line, at).map_err(|e| fail(e.to_string()))?;
    }
    let fail = |message| Error::File { path: path.to_owned(), message };
    reader.end().map_err(|e| fail(e.to_string()))
}

/// State between lines.
#[derive(Debug, Default)]
struct Reader {
    section: Option<Section>,
    constants: Vec<Entry>,
    channels: Vec<Entry>,
    rows: Option<Rows>,
    bench: Bench,
    /// Points without a load, a slip or a camber.
    incomplete: usize,
    /// Points with a load that is not positive.
    unloaded: usize,
    without_radius: bool,
    assumed: Vec<&'static str>,
}

impl Reader {
    fn line(&mut self, line: &str, at: usize) -> Result<(), Fault> {
        let content = line.trim();
        if let Some(name) = content.strip_prefix("**") {
            return self.start(name.trim());
        }
        if content.is_empty() || content.starts_with('!') {
            return Ok(());
        }
        match self.section {
            None => Err(Fault::from("a TYDEX file begins with **HEADER; is this one?")),
            Some(Section::Header) => {
                let [name, value] = [columns(line, 0, 10), columns(line, 40, 200)];
                self.bench.head.push((name, value));
                Ok(())
            }
            Some(Section::Constants) => {
                // a text, such as a size, is a constant, too
                let entry = Entry::parse(line)?;
                if entry.meaning.is_some() {
                    self.constants.push(entry);
                }
                Ok(())
            }
            Some(Section::Channels) => {
                let entry = Entry::parse(line)?;
                if entry.meaning.is_some() && self.channels.iter().any(|c| c.name == entry.name) {
                    return Err(Fault::from(format!(
                        "channel `{}` is there twice; remove one",
                        entry.name
                    )));
                }
                self.channels.push(entry);
                Ok(())
            }
            Some(Section::Data) => {
                let Some(rows) = &mut self.rows else { return Ok(()) };
                if let Some(values) = rows.line(line, at)? {
                    self.point(&values);
                }
                Ok(())
            }
            Some(Section::Else) => Ok(()),
        }
    }

    fn start(&mut self, name: &str) -> Result<(), Fault> {
        if let Some(rows) = self.rows.take() {
            rows.end()?;
        }
        let name = name.split_whitespace().next().unwrap_or_default().to_ascii_uppercase();
        self.section = Some(match name.as_str() {
            // another measurement in the same file has channels of its own
            "HEADER" => {
                self.channels.clear();
                self.constants.clear();
                Section::Header
            }
            "CONSTANTS" => Section::Constants,
            "MEASURCHANNELS" => {
                self.channels.clear();
                Section::Channels
            }
            "MEASURDATA" => {
                self.check_channels()?;
                self.rows = Some(Rows::new(self.channels.len()));
                Section::Data
            }
            // a file of several measurements ends each of them: what follows is read
            "END" => Section::Else,
            other => {
                let known = ["HEADER", "CONSTANTS", "MEASURCHANNELS", "MEASURDATA", "END"];
                if !OTHERS.contains(&other)
                    && let Some(near) = closest(other, known.into_iter())
                {
                    return Err(Fault::from(format!(
                        "`**{other}` is no section; is `**{near}` meant?"
                    )));
                }
                Section::Else
            }
        });
        Ok(())
    }

    fn check_channels(&mut self) -> Result<(), Fault> {
        if self.channels.is_empty() {
            return Err(Fault::from(
                "**MEASURDATA without channels: **MEASURCHANNELS must stand before it",
            ));
        }
        let of_wheel = self.has(Meaning::ForceZ(Axes::C)) && self.has(Meaning::ForceY(Axes::C));
        let has_load = self.has(Meaning::ForceZ(Axes::W)) || self.has(Meaning::ForceZ(Axes::H));
        if !has_load && !of_wheel {
            let names: Vec<&str> = self.channels.iter().map(|c| c.name.as_str()).collect();
            return Err(Fault::from(format!(
                "no load: a channel or constant FZW or FZH, or both FZC and FYC, is needed; there are {}",
                names.join(", ")
            )));
        }
        for (meaning, name) in [
            (Meaning::SlipRatio, "no LONGSLIP: taken as 0"),
            (Meaning::SlipAngle, "no SLIPANGL: taken as 0"),
            (Meaning::Camber, "no INCLANGL: taken as 0"),
        ] {
            if !self.has(meaning) && !self.assumed.contains(&name) {
                self.assumed.push(name);
            }
        }
        Ok(())
    }

    fn has(&self, meaning: Meaning) -> bool {
        self.channels.iter().chain(&self.constants).any(|e| e.meaning == Some(meaning))
    }

    /// A quantity of a point: measured, else constant.
    fn get(&self, values: &[Option<f64>], meaning: Meaning) -> Option<f64> {
        let is_it = |e: &&Entry| e.meaning == Some(meaning);
        match self.channels.iter().position(|e| e.meaning == Some(meaning)) {
            Some(i) => values.get(i).copied().flatten().map(|x| self.channels[i].physical(x)),
            None => self.constants.iter().find(is_it).and_then(Entry::constant),
        }
    }

    fn point(&mut self, values: &[Option<f64>]) {
        let get = |meaning: Meaning| self.get(values, meaning);
        // what is nowhere in the file is nought, what is missing in a line is not known
        let slip = |meaning: Meaning| if self.has(meaning) { get(meaning) } else { Some(0.0) };
        let (Some(slip_ratio), Some(slip_angle), Some(camber)) =
            (slip(Meaning::SlipRatio), slip(Meaning::SlipAngle), slip(Meaning::Camber))
        else {
            self.incomplete += 1;
            return;
        };
        let (sin, cos) = camber.sin_cos();
        let leaning = (get(Meaning::ForceY(Axes::C)), get(Meaning::ForceZ(Axes::C)));
        let upright = |of: fn(Axes) -> Meaning| get(of(Axes::W)).or_else(|| get(of(Axes::H)));
        let force_y = upright(Meaning::ForceY).or_else(|| {
            let (y, z) = (leaning.0?, leaning.1?);
            Some(y * cos - z * sin)
        });
        let load = upright(Meaning::ForceZ).or_else(|| {
            let (y, z) = (leaning.0?, leaning.1?);
            Some(y * sin + z * cos)
        });
        let Some(load) = load else {
            self.incomplete += 1;
            return;
        };
        if load <= 0.0 {
            self.unloaded += 1;
            return;
        }
        let force_x = get(Meaning::ForceX);
        // moments about the wheel centre are brought to the contact, which is a radius below it in the wheel plane
        let radius = get(Meaning::LoadedRadius);
        let leaning = (get(Meaning::MomentX(Axes::C)), get(Meaning::MomentZ(Axes::C)));
        let arm_x = radius.zip(force_y).map(|(r, y)| -r * (sin * load + cos * y));
        let arm_z = radius.zip(force_x).map(|(r, x)| r * sin * x);
        // x is the same axis in C and H; z leans with the wheel, and with it a part of the moment about the spin axis,
        // which is the rolling resistance: without it, yaw moments in C are none of a tyre model's
        let at_centre = [
            get(Meaning::MomentX(Axes::H)).or(leaning.0),
            get(Meaning::MomentZ(Axes::H)).or(leaning.1.filter(|_| camber.abs() < 1e-3)),
        ];
        let in_contact = [Meaning::MomentX, Meaning::MomentZ].map(|of| get(of(Axes::W)));
        let [moment_x, moment_z] =
            [0, 1].map(|i| in_contact[i].or_else(|| Some(at_centre[i]? + [arm_x, arm_z][i]?)));
        let lost =
            [moment_x, moment_z].iter().zip(at_centre).any(|(m, c)| m.is_none() && c.is_some());
        self.without_radius |= lost && radius.is_none();
        self.bench.points.push(Point {
            slip_ratio,
            slip_angle,
            camber,
            load,
            force_x,
            force_y,
            moment_x,
            moment_z,
        });
    }

    fn end(mut self) -> Result<Bench, Fault> {
        if let Some(rows) = self.rows.take() {
            rows.end()?;
        }
        let n = self.bench.points.len();
        if self.unloaded > n {
            return Err(Fault::from(format!(
                "{} of {} loads are not positive: the format has z up, and the road pushes the tyre up; turn the sign \
                 of the channel with its factor a = -1 (and that of the others that point the other way)",
                self.unloaded,
                n + self.unloaded
            )));
        }
        if n == 0 {
            return Err(match self.section {
                None => "it is empty".into(),
                _ if self.incomplete > 0 => {
                    format!("none of {} points has a load, slips and a camber", self.incomplete)
                        .into()
                }
                _ => "no points: **MEASURCHANNELS and **MEASURDATA are needed".into(),
            });
        }
        let remarks = &mut self.bench.remarks;
        remarks.extend(self.assumed.iter().map(|s| (*s).to_owned()));
        if self.incomplete > 0 {
            remarks.push(format!(
                "{} points without a load, a slip or a camber left out",
                self.incomplete
            ));
        }
        if self.unloaded > 0 {
            remarks.push(format!("{} points without a positive load left out", self.unloaded));
        }
        if self.without_radius {
            remarks.push(
                "moments about the wheel centre left out: no DSTGRWHC to bring them to the contact"
                    .into(),
            );
        }
        Ok(self.bench)
    }
}
