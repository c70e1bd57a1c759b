//! TYDEX files: what a tyre test bench measured, as text that every vendor writes.
//!
//! Source: TYDEX-Format, Description and Reference Manual, release 1.3 (Unrau and Zamow 1997).
//!
//! ```text
//! **HEADER                                                    columns of a line:
//! RELEASE   Release of the format         1.3                 1-10 name, 11-40 description, 41-80 value
//! **CONSTANTS
//! INFLPRES  Inflation pressure            bar       2.5       41-50 unit, 51-80 value
//! **MEASURCHANNELS
//! SLIPANGL  Slip angle                    deg       1  0  0   41-50 unit, then a, b, c in 51-60, 61-70, 71-80
//! **MEASURDATA                                                physical value = a (value + b) + c, in the unit
//!    -1.000    0.000  1301.22
//! **END
//! ```
//!
//! Angles and forces have the signs of roadbench: the W axes of the format are ISO 8855 in the contact, a positive
//! slip angle or inclination pulls to the right, a positive longitudinal slip drives.
//!
//! | file | what |
//! |---|---|
//! | [`channel`] | names of channels, and what each is in |
//! | [`mod@unit`] | units |
//! | [`line`](mod@line) | one line of a channel or a constant |
//! | [`rows`] | lines of measured values |
//! | [`read`](mod@read) | a file's points |
//! | [`write`](mod@write) | points as a file |

pub(crate) mod channel;
mod fault;
pub(crate) mod line;
pub(crate) mod read;
pub(crate) mod rows;
pub(crate) mod unit;
pub(crate) mod write;

use std::path::PathBuf;

/// Measurements at one point, SI units, ISO 8855, where the wheel plane meets the road.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Longitudinal slip, positive driving.
    pub slip_ratio: f64,
    /// Slip angle, rad.
    pub slip_angle: f64,
    /// Camber, rad.
    pub camber: f64,
    /// Load, N, positive.
    pub load: f64,
    /// Longitudinal force, N.
    pub force_x: Option<f64>,
    /// Lateral force, N.
    pub force_y: Option<f64>,
    /// Overturning moment, N m.
    pub moment_x: Option<f64>,
    /// Yaw moment, N m.
    pub moment_z: Option<f64>,
}

/// The points of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bench {
    /// Names and values of the head, as they are.
    pub head: Vec<(String, String)>,
    /// Assumptions and omissions of the reader, for people.
    pub remarks: Vec<String>,
    /// In the order of the file.
    pub points: Vec<Point>,
}

/// Why a file is not read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It cannot be read.
    #[error("cannot read bench data {path}: {source}")]
    Read { path: PathBuf, source: std::io::Error },
    /// A line is wrong.
    #[error("bench data {path}, line {line}: {message}")]
    Line {
        path: PathBuf,
        /// From 1.
        line: usize,
        /// Error, and what to do.
        message: String,
    },
    /// The file as a whole.
    #[error("bench data {path}: {message}")]
    File {
        path: PathBuf,
        /// Error, and what to do.
        message: String,
    },
}

/// Whether a file's name is that of a TYDEX file (`.tdx`, `.tydex`).
pub(crate) fn is_name(name: &str) -> bool {
    let extension = name.rsplit_once('.').map(|(_, e)| e.to_ascii_lowercase());
    matches!(extension.as_deref(), Some("tdx" | "tydex"))
}
