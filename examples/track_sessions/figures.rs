//! The study's tables.

use std::collections::BTreeMap;
use std::fmt::{self, Display};

use roadbench::internals::simulate::loggers::Profile;
use roadbench::internals::store::tables::rows::{Coefficient, Status};

use super::case::{Asked, KINDS, PROFILES, Read, Segmented};
use super::channels::{Judged, Planted, check, planted, score};

/// One session of one logger.
pub struct Session {
    pub number: usize,
    pub profile: Profile,
    /// s.
    pub length: f64,
    pub read: Read,
    pub asked: Vec<Asked>,
    /// Manoeuvres by the map as drafted, and without pressures.
    pub with: Option<Segmented>,
    pub without: Option<Segmented>,
}

/// Channels of the maps.
#[derive(Default)]
struct Mapped {
    logs: usize,
    expected: usize,
    right: usize,
    wrong: usize,
    missing: usize,
    late: Vec<f64>,
    refused: usize,
}

/// One coefficient of one logger.
#[derive(Default)]
struct Found {
    sessions: usize,
    /// With an interval and `ok`, poorly determined, a lower bound.
    ok: usize,
    poorly: usize,
    bounds: usize,
    /// Relative errors: in the log's scale, and in metres where that differs.
    error: Vec<f64>,
    absolute: Vec<f64>,
    inside: usize,
    inside_absolute: usize,
    /// Half the interval in the log's scale over the truth; of a bound, the bound over the truth.
    width: Vec<f64>,
}

/// Errors planted into right maps.
#[derive(Default)]
struct Faults {
    maps: usize,
    found: usize,
    named: usize,
    mended: usize,
    others: usize,
}

/// Figures of all sessions, by logger.
#[derive(Default)]
pub struct Figures {
    mapped: BTreeMap<usize, Mapped>,
    found: BTreeMap<(usize, usize), (&'static str, Found)>,
    segmented: BTreeMap<(usize, bool), Segmented>,
    faults: BTreeMap<(usize, &'static str), Faults>,
    length: f64,
    notes: Vec<String>,
}

fn median(x: &[f64]) -> f64 {
    let mut x = x.to_vec();
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Figures {
    pub fn add(&mut self, session: &Session, verbose: bool) {
        let Session { profile, read, .. } = session;
        let name = profile.name();
        let place = PROFILES.iter().position(|p| p == profile).unwrap_or(0);
        let who = format!("{name} {}", session.number);
        self.length += session.length / PROFILES.len() as f64;
        self.add_map(session.number, *profile, &read.judged, read.circumference);
        let refused = usize::from(read.outcome.is_err());
        self.mapped.entry(place).or_default().refused += refused;
        if let Err(why) = &read.outcome {
            self.notes.push(format!("{who}: refused: {why}"));
        }
        if verbose && let Ok(outcome) = &read.outcome {
            for w in &outcome.warnings {
                self.notes.push(format!("{who}: warning: {}: {}", w.code, w.message));
            }
        }
        for (k, asked) in session.asked.iter().enumerate() {
            let (_, found) =
                self.found.entry((place, k)).or_insert((asked.words, Found::default()));
            found.sessions += 1;
            let rows = read.outcome.as_ref().map_or(&[][..], |o| &o.coefficients);
            let own = |c: &&Coefficient| {
                c.tyre == asked.id.part.name() && c.coefficient == asked.id.coefficient.name()
            };
            let Some(row) = rows.iter().find(own) else { continue };
            if verbose {
                let numbers = [row.value, row.ci95_low, row.ci95_high];
                let [value, low, high] =
                    numbers.map(|x| x.map_or("-".into(), |x| format!("{x:.5}")));
                self.notes.push(format!(
                    "{who}: {} {} {value} [{low}, {high}] of {:.5} ({:.5}) {}",
                    asked.words,
                    row.status.name(),
                    asked.in_scale,
                    asked.truth,
                    row.reason.as_deref().unwrap_or("")
                ));
            }
            let axle = asked.id.part.axle().map_or(0, |a| a as usize);
            if let Some(why) = found.take(row, asked, read.scale_sd[axle]) {
                self.notes.push(format!("{who}: {} {why}", asked.words));
            }
        }
        for (pressed, segmented) in [(true, &session.with), (false, &session.without)] {
            if let Some(segmented) = segmented {
                self.segmented.entry((place, pressed)).or_default().add(segmented);
            }
        }
    }

    /// The channels of one map, and errors planted into the right one.
    pub fn add_map(
        &mut self,
        number: usize,
        profile: Profile,
        judged: &Judged,
        circumference: [f64; 2],
    ) {
        let name = profile.name();
        let place = PROFILES.iter().position(|p| *p == profile).unwrap_or(0);
        let who = format!("{name} {number}");
        let score = score(judged, name);
        let mapped = self.mapped.entry(place).or_default();
        mapped.logs += 1;
        mapped.expected += score.expected;
        mapped.right += score.right;
        mapped.wrong += score.wrong.len();
        mapped.missing += score.missing.len();
        mapped.late.extend(&score.late);
        self.notes.extend(score.wrong.iter().map(|w| format!("{who}: wrong: {w}")));
        self.notes.extend(score.missing.iter().map(|w| format!("{who}: missing: {w}")));
        for p in [None].into_iter().chain(planted(name).into_iter().map(Some)) {
            let kind = match p {
                None => "nothing",
                Some(Planted::Sign(_)) => "sign",
                Some(Planted::Unit(..)) => "unit",
                Some(Planted::Swapped(..)) => "swapped channels",
                Some(Planted::Delay(_)) => "delay of 0.2 s",
            };
            let c = check(judged, name, circumference, p);
            let faults = self.faults.entry((place, kind)).or_default();
            faults.maps += 1;
            faults.found += usize::from(c.found);
            faults.named += usize::from(c.named);
            faults.mended += usize::from(c.mended);
            faults.others += c.false_alarms;
            let good = p.is_none() || (c.found && c.named && c.mended);
            if !good || c.false_alarms > 0 {
                self.notes.push(format!("{who}: planted {p:?}: {c:?}"));
            }
        }
    }
}

impl Found {
    /// Takes a row; says what is wrong with its interval.
    fn take(&mut self, row: &Coefficient, asked: &Asked, scale_sd: f64) -> Option<String> {
        match (row.status, row.value, row.ci95_low, row.ci95_high) {
            (Status::LowerBound, _, Some(low), _) if asked.bound => {
                self.bounds += 1;
                let held = low <= asked.in_scale;
                self.inside += usize::from(held);
                self.inside_absolute += usize::from(held);
                self.width.push(low / asked.in_scale.abs());
                (!held).then(|| format!("bound {low:.4} beyond {:.4}", asked.in_scale))
            }
            (Status::Ok | Status::PoorlyDetermined, Some(value), Some(low), Some(high)) => {
                let ok = row.status == Status::Ok;
                self.ok += usize::from(ok);
                self.poorly += usize::from(!ok);
                self.error.push((value / asked.in_scale - 1.0).abs());
                self.absolute.push((value / asked.truth - 1.0).abs());
                // in the log's own scale without the uncertainty of that
                let shared =
                    if asked.words.contains("radius") { 1.96 * scale_sd * value } else { 0.0 };
                let own = |end: f64| ((end - value).powi(2) - shared * shared).max(0.0).sqrt();
                let [below, above] = [own(low), own(high)];
                self.width.push(0.5 * (below + above) / asked.in_scale.abs());
                let held = (value - below..=value + above).contains(&asked.in_scale);
                self.inside += usize::from(held);
                self.inside_absolute += usize::from((low..=high).contains(&asked.truth));
                let status = row.status.name();
                (!held).then(|| {
                    format!(
                        "{status} {value:.4} [{low:.4}, {high:.4}] does not hold {:.4}",
                        asked.in_scale
                    )
                })
            }
            _ => None,
        }
    }
}

/// A share in per cent of two digits; a dash of nothing.
fn percent(x: f64) -> String {
    let x = 100.0 * x;
    match x {
        _ if !x.is_finite() => "-".into(),
        _ if x.abs() < 9.95 => format!("{x:.2} %"),
        _ => format!("{x:.0} %"),
    }
}

/// What the prototype in `design/in-gear.md` reaches at 10 Hz with pressures, rms.
fn floor(words: &str) -> &'static str {
    match words {
        "front rolling radius" => "0.1 %",
        "rear rolling radius" => "0.2 %",
        "front slip stiffness" => "11 %",
        "rear slip stiffness" => "9 %",
        "front overturning stiffness" => "1.4 mm",
        "rear overturning stiffness" => "2.5 mm",
        "drag" => "6 %",
        _ => "-",
    }
}

impl Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |place: &usize| PROFILES[*place].name();
        writeln!(f, "{:.0} s of riding\n", self.length)?;
        writeln!(
            f,
            "| logger | logs | refused | channels | right | wrong in force | missing | delay error, rms |\n|---|---|---|---|---|---|---|---|"
        )?;
        for (place, m) in &self.mapped {
            let rms = (m.late.iter().map(|x| x * x).sum::<f64>() / m.late.len() as f64).sqrt();
            let late = if rms.is_finite() { format!("{:.0} ms", 1e3 * rms) } else { "-".into() };
            let right = percent(m.right as f64 / m.expected as f64);
            writeln!(
                f,
                "| {} | {} | {} | {} | {} ({right}) | {} | {} | {late} |",
                name(place),
                m.logs,
                m.refused,
                m.expected,
                m.right,
                m.wrong,
                m.missing,
            )?;
        }
        writeln!(
            f,
            "\n| logger | coefficient | `ok` | poorly determined | lower bound | median error | half interval or bound over truth | interval or bound holds | in metres: error, holds | prototype, rms |\n|---|---|---|---|---|---|---|---|---|---|"
        )?;
        for ((place, _), (words, c)) in &self.found {
            let given = c.ok + c.poorly + c.bounds;
            if given == 0 {
                continue;
            }
            let metres = match words.contains("radius") {
                true => format!("{}, {}", percent(median(&c.absolute)), c.inside_absolute),
                false => String::new(),
            };
            writeln!(
                f,
                "| {} | {words} | {} | {} | {} | {} | {} | {} of {given} | {metres} | {} |",
                name(place),
                c.ok,
                c.poorly,
                c.bounds,
                percent(median(&c.error)),
                percent(median(&c.width)),
                c.inside,
                floor(words)
            )?;
        }
        let kinds: Vec<String> = KINDS.iter().map(|k| k.name().replace('_', " ")).collect();
        writeln!(
            f,
            "\n| logger | pressures mapped | F1: {} | F1: any braking | engine braking | of it rear braking | and used |\n|---|---|{}---|---|---|---|",
            kinds.join(" | F1: "),
            "---|".repeat(KINDS.len())
        )?;
        for ((place, pressed), s) in &self.segmented {
            let f1 = (0..KINDS.len())
                .map(|k| s.f1(k).map_or("-".into(), |x| format!("{x:.2}")))
                .collect::<Vec<String>>();
            let own = match (pressed, place) {
                (true, 0 | 1) => "yes",
                (true, _) => "has none",
                _ => "no",
            };
            writeln!(
                f,
                "| {} | {own} | {} | {:.2} | {:.0} s | {} | {} |",
                name(place),
                f1.join(" | "),
                s.f1_braking(),
                s.engine,
                percent(s.as_rear / s.engine),
                percent(s.as_rear_used / s.engine)
            )?;
        }
        writeln!(
            f,
            "\n| logger | planted | maps | found | named | mended | other findings |\n|---|---|---|---|---|---|---|"
        )?;
        for ((place, kind), c) in &self.faults {
            writeln!(
                f,
                "| {} | {kind} | {} | {} | {} | {} | {} |",
                name(place),
                c.maps,
                c.found,
                c.named,
                c.mended,
                c.others
            )?;
        }
        writeln!(f)?;
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))
    }
}
