//! The catalogue: classes of motorcycle, some models, and how each number is measured.

use std::sync::LazyLock;

use serde::Deserialize;

use crate::contract::key_error::KeyError;

const TEXT: &str = include_str!("../../../pipelines/bikes/catalogue.toml");

/// Usual value: mean and standard deviation over a class, and the source in words.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Usual {
    /// In the unit that the catalogue states.
    pub mean: f64,
    pub sd: f64,
    /// Where both are from.
    pub source: String,
}

impl Usual {}

/// A class of motorcycles or bicycles.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    /// Its name on the command line.
    pub name: String,
    /// Motorcycles of the class.
    pub description: String,
    /// Usual front tyre, as printed.
    pub front: String,
    /// Usual rear tyre, as printed.
    pub rear: String,
    /// Usual inflation pressures, front and rear, Pa above the air's.
    pub pressure: [f64; 2],
    /// With rider, kg.
    pub mass: Usual,
    /// Wheelbase, m.
    pub wheelbase: Usual,
    /// Share of the weight with rider on the front wheel.
    pub front_share: Usual,
    /// Height of the centre of mass with rider over the wheelbase.
    pub height_share: Usual,
    /// Caster angle, deg.
    pub caster: Usual,
    /// Trail, m.
    pub trail: Usual,
    /// Spin inertia of the front wheel with the class's usual tyre, kg m².
    pub inertia_front: Usual,
    /// Spin inertia of the rear wheel with the class's usual tyre, kg m².
    pub inertia_rear: Usual,
    /// Drag, kg/m.
    pub drag: Usual,
    /// Rolling resistance coefficient.
    pub rolling_resistance: Usual,
}

/// One model, by its data sheet.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Make and model.
    pub name: String,
    /// Name of its class.
    pub class: String,
    /// Front tyre, as printed.
    pub front: String,
    /// Rear tyre, as printed.
    pub rear: String,
    /// Ready to ride, without rider, kg.
    pub kerb_mass: f64,
    /// Wheelbase, m.
    pub wheelbase: f64,
    /// Caster angle, deg.
    pub caster: Option<f64>,
    /// Trail, m.
    pub trail: Option<f64>,
}

/// How well a data sheet's numbers hold for a motorcycle: standard deviations.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataSheet {
    /// Mass of a rider, kg.
    pub rider: Usual,
    /// Kerb mass, kg.
    pub kerb_mass: f64,
    /// Wheelbase, m.
    pub wheelbase: f64,
    /// Caster, deg.
    pub caster: f64,
    /// Trail, m.
    pub trail: f64,
    pub source: String,
}

/// How well what follows from a tyre's size is known: relative standard deviations.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FromSize {
    /// Of the rolling radius.
    pub radius_relative: f64,
    pub width_relative: f64,
    /// Of the vertical stiffness.
    pub stiffness_relative: f64,
    /// Of a weight that was said, kg.
    pub weight: f64,
    /// Of the rolling radius where no size was said.
    pub unknown_radius_relative: f64,
    /// Of the width where no size was said.
    pub unknown_width_relative: f64,
}

/// How a number is measured at home.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Its key, without the wheel.
    pub key: String,
    /// Standard deviation once measured, in the key's unit.
    pub measured: Option<f64>,
    /// The same over the number.
    pub measured_relative: Option<f64>,
    pub home: String,
    /// Costs of an error of this number.
    #[serde(default)]
    pub costs: Vec<Cost>,
}

/// Cost of a wrong number.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// The coefficient, with its tyre: `front mf_d`.
    pub of: String,
    /// Its relative change over that of the number, without sign.
    pub elasticity: f64,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Catalogue {
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub version: u32,
    #[serde(rename = "class")]
    pub classes: Vec<Class>,
    #[serde(rename = "model")]
    pub models: Vec<Model>,
    /// Of the models' numbers.
    pub data_sheet: DataSheet,
    pub tyre_size: FromSize,
    /// How numbers are measured.
    #[serde(rename = "number")]
    pub measures: Vec<Measure>,
}

impl Catalogue {
    /// The one that comes with the program.
    ///
    /// # Panics
    /// Never: a test loads it.
    pub fn builtin() -> &'static Self {
        static ALL: LazyLock<Catalogue> = LazyLock::new(|| {
            toml::from_str(TEXT).unwrap_or_else(|e| panic!("pipelines/bikes/catalogue.toml: {e}"))
        });
        &ALL
    }

    /// The class of that name.
    ///
    /// # Errors
    /// There is none; a sentence that lists them.
    pub fn class(&self, name: &str) -> Result<&Class, KeyError> {
        let same = |c: &&Class| plain(&c.name) == plain(name);
        self.classes.iter().find(same).ok_or_else(|| {
            let names: Vec<&str> = self.classes.iter().map(|c| c.name.as_str()).collect();
            format!("there is no class `{name}`; there are {}", names.join(", ")).into()
        })
    }

    /// The model of that name: case, blanks and dashes do not matter, nor the make where the rest is unique.
    pub fn model(&self, name: &str) -> Option<&Model> {
        let wanted = plain(name);
        let exact = self.models.iter().find(|m| plain(&m.name) == wanted);
        exact.or_else(|| {
            let mut all = self
                .models
                .iter()
                .filter(|m| wanted.len() >= 3 && plain(&m.name).ends_with(&wanted));
            let first = all.next()?;
            all.next().is_none().then_some(first)
        })
    }

    /// How a key is measured at home, the wheel's part of it aside.
    pub fn measure(&self, key: &str) -> Option<&Measure> {
        let leaf = key.strip_prefix("front.").or(key.strip_prefix("rear.")).unwrap_or(key);
        self.measures.iter().find(|m| m.key == leaf)
    }
}

impl Measure {
    /// Standard deviation of a number of this size that was measured at home.
    pub fn sd(&self, value: f64) -> f64 {
        self.measured.or(self.measured_relative.map(|share| share * value.abs())).unwrap_or(0.0)
    }
}

/// Letters and digits alone, lower case.
fn plain(text: &str) -> String {
    text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motorcycle::catalogue::TyreSize;

    #[test]
    fn every_class_is_whole_and_every_model_has_one() {
        let all = Catalogue::builtin();
        let names: Vec<&str> = all.classes.iter().map(|c| c.name.as_str()).collect();
        let wanted = ["sports", "naked", "touring", "off-road", "scooter", "bicycle", "e-bike"];
        assert_eq!(names, wanted);
        for c in &all.classes {
            for size in [&c.front, &c.rear] {
                TyreSize::parse(size).unwrap_or_else(|e| panic!("{}: {e}", c.name));
            }
            for u in [
                &c.mass,
                &c.wheelbase,
                &c.front_share,
                &c.height_share,
                &c.caster,
                &c.trail,
                &c.inertia_front,
                &c.inertia_rear,
                &c.drag,
                &c.rolling_resistance,
            ] {
                // a guess is never exact, and never so wide that nothing is meant by it
                assert!(u.sd > 0.01 * u.mean && u.sd < 0.6 * u.mean, "{}: {u:?}", c.name);
                assert!(!u.source.is_empty());
            }
        }
        for m in &all.models {
            let class = all.class(&m.class).unwrap_or_else(|e| panic!("{}: {e}", m.name));
            assert!((m.wheelbase - class.wheelbase.mean).abs() < 2.5 * class.wheelbase.sd, "{m:?}");
            let mass = m.kerb_mass + all.data_sheet.rider.mean;
            assert!((mass - class.mass.mean).abs() < 3.0 * class.mass.sd, "{m:?}");
            for size in [&m.front, &m.rear] {
                TyreSize::parse(size).unwrap_or_else(|e| panic!("{}: {e}", m.name));
            }
        }
    }

    #[test]
    fn models_are_found_as_people_write_them() {
        let all = Catalogue::builtin();
        for text in ["Yamaha MT-07", "yamaha mt07", "MT 07", "mt-07"] {
            assert_eq!(all.model(text).map(|m| m.name.as_str()), Some("Yamaha MT-07"), "{text}");
        }
        assert!(all.model("Yamaha").is_none() && all.model("07").is_none());
        assert!(all.class("Off Road").is_ok() && all.class("ebike").is_ok());
        let e = all.class("cruiser").expect_err("none").to_string();
        assert!(e.contains("touring") && e.contains("scooter"), "{e}");
    }
}
