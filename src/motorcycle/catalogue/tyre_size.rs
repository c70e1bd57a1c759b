//! Tyre sizes as they are printed on the sidewall.
//!
//! | printed | as | section height |
//! |---|---|---|
//! | 120/70ZR17, 130/80-17, 110/90 B 19 | width (mm) / height (% of it), rim (inch) | by the second number |
//! | 3.50-18, 4.00H-18 | width (inch), rim (inch) | the width; 0.82 of it in the low series (4.10-18) |
//! | 37-622 | width (mm), bead seat (mm), ETRTO | the width |
//! | 700x38C, 29x2.2 | outer size by name, width (mm or inch) | the width |
//!
//! Sources: designations of the ETRTO standards manual (tyres of motorcycles and cycles); heights of inch and cycle
//! sizes are design values, those of a maker differ by some percent.

use crate::contract::key_error::KeyError;

/// Metres in an inch.
const INCH: f64 = 0.0254;
/// Height over width of inch sizes that are printed with tenths (2.60, 3.10, 3.60, 4.10, 4.60, 5.10).
const LOW_SERIES: f64 = 0.82;
/// Stiffness over pressure x sqrt(width x outer diameter): mean of the four published tyres with a pressure's size
/// (Sharp, Evangelou, Limebeer 2004: 130 and 141 kN/m; a vendor's MF 6.2 set: 176 and 175 kN/m) at 2.5 and 2.9 bar.
const STIFFNESS_FACTOR: f64 = 1.9;
/// Crown radius over width: a tread across the whole width is half a circle.
const CROWN: f64 = 0.5;
/// Forms that are read, for messages.
pub(crate) const FORMS: &str =
    "120/70ZR17, 130/80-17, 110/90 B 19, 3.50-18, 4.00H-18, 37-622, 700x38C or 29x2.2";

#[derive(Debug, Clone, PartialEq)]
pub struct TyreSize {
    /// As it was given.
    pub printed: String,
    /// Width of the section, m.
    pub width: f64,
    /// Diameter of the bead seat, m.
    pub rim: f64,
    /// Height of the section, m.
    pub height: f64,
}

impl TyreSize {
    /// Reads a size as printed; what follows it (load index, speed symbol, TL, M/C) is passed over.
    ///
    /// # Errors
    /// A sentence with the forms that are read.
    pub fn parse(printed: &str) -> Result<Self, KeyError> {
        let text = printed.trim().to_uppercase().replace('×', "X").replace(',', ".");
        let fail =
            || KeyError::Values(format!("`{}` is not a tyre size such as {FORMS}", printed.trim()));
        let (first, rest) = number(&text).ok_or_else(fail)?;
        let rest = rest.trim_start();
        let found = if let Some(rest) = rest.strip_prefix('/') {
            metric(first, rest)
        } else if let Some(rest) = rest.strip_prefix('X') {
            cycle(first, rest)
        } else {
            inch_or_etrto(&text, first, rest)
        };
        let [width, rim, height] = found.ok_or_else(fail)?;
        let size = TyreSize { printed: printed.trim().to_owned(), width, rim, height };
        let possible = (0.018..=0.36).contains(&width) && (0.2..=0.45).contains(&size.radius());
        if possible { Ok(size) } else { Err(fail()) }
    }

    /// Outer radius without load, m.
    pub fn radius(&self) -> f64 {
        0.5 * self.rim + self.height
    }

    /// Crown radius, m: of a round tread.
    pub fn crown(&self) -> f64 {
        CROWN * self.width
    }

    /// Vertical stiffness, N/m, at an inflation pressure (Pa, above the air's).
    pub fn vertical_stiffness(&self, pressure: f64) -> f64 {
        STIFFNESS_FACTOR * pressure * (self.width * 2.0 * self.radius()).sqrt()
    }
}

/// A number at the start, and what follows.
fn number(text: &str) -> Option<(f64, &str)> {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// Passes over letters, blanks and dashes: construction and speed symbol.
fn after_letters(text: &str) -> &str {
    text.trim_start_matches(|c: char| c.is_ascii_uppercase() || c == '-' || c == ' ')
}

/// Rim diameter by its code, m: inches.
fn rim(code: f64) -> Option<f64> {
    (8.0..=23.0).contains(&code).then_some(code * INCH)
}

fn metric(width: f64, rest: &str) -> Option<[f64; 3]> {
    let (aspect, rest) = number(rest.trim_start())?;
    let (code, _) = number(after_letters(rest))?;
    let usual = (50.0..=360.0).contains(&width) && (30.0..=110.0).contains(&aspect);
    let width = 1e-3 * width;
    Some([width, rim(code).filter(|_| usual)?, 0.01 * aspect * width])
}

/// Sizes of bicycles by the name of their outer diameter.
fn cycle(name: f64, rest: &str) -> Option<[f64; 3]> {
    let (width, rest) = number(rest.trim_start())?;
    // millimetres of French sizes, else inches
    let millimetres = name > 100.0;
    let is = |known: f64| (name - known).abs() < 1e-9;
    let seat = match rest.trim_start().chars().next() {
        Some('B') if is(650.0) => 0.584,
        _ if is(700.0) || is(29.0) || is(28.0) => 0.622,
        _ if is(650.0) || is(27.5) => 0.584,
        _ if is(26.0) => 0.559,
        _ if is(24.0) => 0.507,
        _ if is(20.0) => 0.406,
        _ if is(16.0) => 0.305,
        _ => return None,
    };
    let width = width * if millimetres { 1e-3 } else { INCH };
    Some([width, seat, width])
}

fn inch_or_etrto(text: &str, first: f64, rest: &str) -> Option<[f64; 3]> {
    let (second, _) = number(after_letters(rest)).filter(|_| !rest.is_empty())?;
    if second >= 200.0 {
        let width = 1e-3 * first;
        return Some([width, 1e-3 * second, width]);
    }
    let inches = (2.0..=6.0).contains(&first) && text.chars().nth(1) == Some('.');
    let width = first * INCH;
    // 3.50 and 3.25 are as high as wide, 3.60 and 4.10 of the low series
    let quarters = (4.0 * first).fract().abs() < 1e-9;
    let aspect = if quarters { 1.0 } else { LOW_SERIES };
    Some([width, rim(second).filter(|_| inches)?, aspect * width])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Width, outer radius in mm.
    fn of(printed: &str) -> (i64, i64) {
        let size = TyreSize::parse(printed).unwrap_or_else(|e| panic!("{e}"));
        ((1e3 * size.width).round() as i64, (1e3 * size.radius()).round() as i64)
    }

    #[test]
    fn sizes_as_printed() {
        assert_eq!(of("120/70ZR17"), (120, 300));
        assert_eq!(of("180/55 ZR 17 M/C (73W) TL"), (180, 315));
        assert_eq!(of("130/80-17"), (130, 320));
        assert_eq!(of("110/90 B 19"), (110, 340));
        assert_eq!(of("90/90-21 54H"), (90, 348));
        assert_eq!(of("120/70 r 15"), (120, 275));
        assert_eq!(of("200/55 R16.5"), (200, 320));
        assert_eq!(of("3.50-18"), (89, 318));
        assert_eq!(of("4.00H-18"), (102, 330));
        assert_eq!(of("3.50 S 18"), (89, 318));
        assert_eq!(of("4.10-18"), (104, 314));
        assert_eq!(of("37-622"), (37, 348));
        assert_eq!(of("700x38C"), (38, 349));
        assert_eq!(of("29x2.2"), (56, 367));
        assert_eq!(of(" 27,5 x 2,25"), (57, 349));
        assert_eq!(of("650x47B"), (47, 339));
    }

    #[test]
    fn what_is_no_size_is_said_with_the_forms() {
        for text in [
            "",
            "round",
            "120",
            "120/70",
            "120/70ZR",
            "120/70ZR40",
            "12/70-17",
            "37-",
            "700x",
            "x",
            "5000-18",
            "3-18",
            "-",
            "120/70ZR17a".trim_end_matches("17a"),
            "ＺＲ17",
            "0x0",
            "1e9/1e9-17",
        ] {
            let e = TyreSize::parse(text).expect_err(text).to_string();
            assert!(e.contains("120/70ZR17") && e.contains("37-622"), "{e}");
        }
    }

    #[test]
    fn stiffness_is_of_the_published_order() {
        let of =
            |size, pressure| TyreSize::parse(size).expect("a size").vertical_stiffness(pressure);
        // Sharp, Evangelou, Limebeer 2004 and a vendor's MF 6.2 set: 130 to 176 kN/m
        assert!((100e3..180e3).contains(&of("120/70ZR17", 2.5e5)));
        assert!((130e3..230e3).contains(&of("180/55ZR17", 2.9e5)));
    }
}
