//! Points as a TYDEX file, in the W axes and SI units.

use std::fmt::Write as _;

use super::Point;

/// Name, description and unit of the channels, in the order of a line.
const CHANNELS: [(&str, &str, &str); 9] = [
    ("MEASNUMB", "Number of the point", "-"),
    ("LONGSLIP", "Longitudinal slip", "-"),
    ("SLIPANGL", "Slip angle", "rad"),
    ("INCLANGL", "Inclination angle", "rad"),
    ("FZW", "Vertical force", "N"),
    ("FX", "Longitudinal force", "N"),
    ("FYW", "Lateral force", "N"),
    ("MXW", "Overturning moment", "Nm"),
    ("MZW", "Aligning moment", "Nm"),
];
/// Significant digits of a value: its column of ten characters has a sign, a point and a blank, too.
pub(crate) const DIGITS: usize = 7;
/// Characters of a value with its sign and point.
const WIDTH: usize = 9;
/// Word for a value that was not measured.
const MISSING: &str = "NOTAVAIL";

/// Text before the points.
#[derive(Debug, Clone, Default)]
pub struct Head<'a> {
    /// Name, description and value of the head, beyond the release.
    pub header: Vec<(&'a str, &'a str, String)>,
    /// Lines for people.
    pub comments: Vec<String>,
    /// Name, description, unit and value.
    pub constants: Vec<(&'a str, &'a str, &'a str, f64)>,
}

/// The text of a file.
pub fn write(head: &Head<'_>, points: &[Point]) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let mut line = |text: &str| {
        let _ = writeln!(out, "{}", text.trim_end());
    };
    line("**HEADER");
    line(&format!("{:<10}{:<30}{}", "RELEASE", "Release of TYDEX-Format", "1.3"));
    for (name, description, value) in &head.header {
        line(&format!("{name:<10}{description:<30}{}", plain(value)));
    }
    line("**COMMENTS");
    for comment in &head.comments {
        // a comment does not begin a section
        line(&format!("! {}", plain(comment)));
    }
    line("**CONSTANTS");
    for (name, description, unit, value) in &head.constants {
        line(&format!("{name:<10}{description:<30}{unit:<10}{}", cell(Some(*value))));
    }
    line("**MEASURCHANNELS");
    for (name, description, unit) in CHANNELS {
        line(&format!("{name:<10}{description:<30}{unit:<10}{:<10}{:<10}{:<10}", "1", "0", "0"));
    }
    line("**MEASURDATA");
    for (i, p) in points.iter().enumerate() {
        let slips = [p.slip_ratio, p.slip_angle, p.camber, p.load].map(Some);
        let forces = [p.force_x, p.force_y, p.moment_x, p.moment_z];
        let cells: String =
            slips.into_iter().chain(forces).map(|x| format!("{:>10}", cell(x))).collect();
        line(&format!("{:>10}{cells}", i + 1));
    }
    line("**END");
    out
}

/// A value in its column: [`DIGITS`] digits, or as many as fit.
fn cell(value: Option<f64>) -> String {
    let Some(x) = value.filter(|x| x.is_finite()) else { return MISSING.to_owned() };
    let x = if x == 0.0 { 0.0 } else { x };
    let size = x.abs().max(1e-12).log10().floor();
    let decimals = (DIGITS as f64 - 1.0 - size).clamp(0.0, DIGITS as f64 - 1.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.chars().count() <= WIDTH { text } else { format!("{x:.2E}") }
}

/// A log's text cannot begin a line of its own.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
