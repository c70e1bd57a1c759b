//! The road: a plane with grade and bank, patches of other friction, and waves that make it uneven.
//!
//! Grade and bank tilt gravity against the road's plane, which is exact for a plane and leaves
//! out the curvature where the grade changes.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;

/// A stretch of other friction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// Along x, from, m.
    pub from: f64,
    /// Along x, to, m.
    pub to: f64,
    /// Friction there.
    pub friction: f64,
}

/// Grade from a point on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slope {
    /// Along x, from, m.
    pub from: f64,
    /// Rise over run in the direction of x.
    pub grade: f64,
}

/// A wave of the road's surface: `height cos(kx x + ky y + phase)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wave {
    /// Half from trough to crest, m.
    pub height: f64,
    /// Wave numbers along x and y, rad/m.
    pub number: [f64; 2],
    /// At the origin, rad.
    pub phase: f64,
}

/// The road under the wheels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Road {
    /// Friction relative to that of the tyre set's own road.
    pub friction: f64,
    /// Rise over run towards x, up to the first slope.
    pub grade: f64,
    /// Rise over run towards y.
    pub bank: f64,
    /// Changes of grade, in the order of `from`.
    pub slopes: Vec<Slope>,
    /// Patches; the last one that holds counts.
    pub patches: Vec<Patch>,
    /// Unevenness; none is a plane.
    pub waves: Vec<Wave>,
}

impl Default for Road {
    fn default() -> Self {
        Road {
            friction: 1.0,
            grade: 0.0,
            bank: 0.0,
            slopes: Vec::new(),
            patches: Vec::new(),
            waves: Vec::new(),
        }
    }
}

impl Road {
    /// Friction at a point.
    pub fn friction_at(&self, x: f64) -> f64 {
        let patch = self.patches.iter().rev().find(|p| (p.from..p.to).contains(&x));
        patch.map_or(self.friction, |p| p.friction)
    }

    /// Height of the surface above the plane at a point, m, and its slopes along x and y.
    #[inline]
    pub fn surface(&self, x: f64, y: f64) -> [f64; 3] {
        self.waves.iter().fold([0.0; 3], |[z, by_x, by_y], w| {
            let (sin, cos) = (w.number[0] * x + w.number[1] * y + w.phase).sin_cos();
            let steep = w.height * sin;
            [z + w.height * cos, by_x - steep * w.number[0], by_y - steep * w.number[1]]
        })
    }

    /// Gravity in road axes at a point.
    pub fn gravity_at(&self, x: f64, g: f64) -> Vector3<f64> {
        let slope = self.slopes.iter().rev().find(|s| x >= s.from);
        let grade = slope.map_or(self.grade, |s| s.grade);
        // up, seen from a plane whose z rises by grade and bank
        let up = Vector3::new(grade, self.bank, 1.0);
        up * (-g / up.norm())
    }

    /// Error in it, if there is one.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        let positive = |what: &str, x: f64| {
            let ok = (0.01..=3.0).contains(&x);
            if ok {
                Ok(())
            } else {
                Err(KeyError::Values(format!("[road]: {what} = {x} is not between 0.01 and 3")))
            }
        };
        positive("friction", self.friction)?;
        for p in &self.patches {
            positive("friction of a patch", p.friction)?;
        }
        let steep = self.slopes.iter().map(|s| s.grade).chain([self.grade, self.bank]);
        for grade in steep {
            if grade.is_nan() || grade.abs() > 0.5 {
                return Err(KeyError::Values(format!(
                    "[road]: a grade or bank of {grade} is beyond 0.5"
                )));
            }
        }
        Ok(())
    }
}
