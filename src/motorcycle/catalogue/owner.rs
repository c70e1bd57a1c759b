//! What an owner knows of a motorcycle, and the numbers of a bike file that follow.

use std::collections::BTreeMap;

use super::classes::{Catalogue, Class, Model, Usual};
use super::home::{lifted_axle, swung_wheel, two_scales};
use super::numbers::{Number, Origin, ValueWithSd, twice};
use super::tyre_size::TyreSize;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::contract::key_error::KeyError;
use crate::contract::schema::{KeyTable, meant};

/// Share of the deflection by which a tyre rolls shorter, as the bike file's schema says.
const SHARE: f64 = 1.0 / 3.0;

/// Where a mass is from.
const SCALES: &str = "two scales";
const SAID: &str = "a weight given without weighing";

/// Knowledge of an owner; all of it may be missing but a class or a model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Owner {
    /// Name of a class.
    pub class: Option<String>,
    /// Make and model.
    pub model: Option<String>,
    /// Sizes as printed, front and rear.
    pub sizes: [Option<String>; 2],
    /// Weight of motorcycle and rider, kg.
    pub weight: Option<f64>,
    /// Loads of the wheels on two scales, rider seated, kg.
    pub scales: Option<[f64; 2]>,
    /// How far the rear axle was lifted, m, and the front wheel's load then, kg.
    pub lifted: Option<[f64; 2]>,
    /// Mass (kg), arm (m) and period (s) of each wheel that was swung.
    pub swung: [Option<[f64; 3]>; 2],
    /// Keys that were measured.
    pub measured: BTreeMap<String, Measured>,
    /// Keys whose value is a text.
    pub texts: BTreeMap<String, String>,
}

/// A number that was measured; without a standard deviation that of usual measurements at home is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// In the key's unit.
    pub value: f64,
    pub sd: Option<f64>,
}

/// Draft of a bike file: every number with its origin, from the owner's answers, the catalogue and the class.
#[derive(Debug, Clone)]
pub struct Portrait {
    pub class: &'static Class,
    /// Its model, where it is in the catalogue.
    pub model: Option<&'static Model>,
    /// Its tyres, front and rear.
    pub sizes: [TyreSize; 2],
    /// Whether the sizes were said, front and rear.
    pub sizes_said: [bool; 2],
    /// The numbers, in the order of the bike file.
    pub numbers: Vec<Number>,
    pub texts: BTreeMap<String, String>,
}

impl Owner {
    /// Takes `key=value`, `key=value+-sd` or `key=value±sd`.
    ///
    /// # Errors
    /// There is no such key, or no number; a sentence.
    pub fn set(&mut self, text: &str, schema: &KeyTable) -> Result<(), KeyError> {
        let split = text.split_once('=').map(|(k, v)| (k.trim(), v.trim()));
        let Some((path, value)) = split.filter(|(_, v)| !v.is_empty()) else {
            return Err(KeyError::Values(format!(
                "`{text}`: write key=value or key=value+-deviation"
            )));
        };
        let numeric = |kind: &str| kind == "number" || kind == "text";
        let Some(key) = schema.keys.iter().find(|k| k.path == path && numeric(&k.kind)) else {
            let near = meant(path, schema.keys.iter().map(|k| k.path.as_str()));
            return Err(KeyError::Values(format!("unknown key `{path}`{near}")));
        };
        if key.kind == "text" {
            self.texts.insert(path.to_owned(), value.trim_matches('"').to_owned());
            return Ok(());
        }
        let (number, sd) = match value.split_once("+-").or(value.split_once('±')) {
            Some((number, sd)) => (number.trim(), Some(sd.trim())),
            None => (value, None),
        };
        let parse = |text: &str| {
            let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
            number.ok_or_else(|| {
                let form = "write it with a point and without a unit, such as 0.62";
                KeyError::Values(format!("`{path}`: `{text}` is not a number; {form}"))
            })
        };
        let value = parse(number)?;
        let unit = key.unit.as_deref().unwrap_or("1");
        if let Some([low, high]) = key.range.filter(|[low, high]| !(*low..=*high).contains(&value))
        {
            return Err(KeyError::Values(format!(
                "`{path}` = {value} {unit} is not between {low} and {high} {unit}"
            )));
        }
        let sd = sd.map(parse).transpose()?;
        if sd.is_some_and(|sd| sd < 0.0) {
            return Err(KeyError::Values(format!(
                "`{path}`: a standard deviation is not negative"
            )));
        }
        self.measured.insert(path.to_owned(), Measured { value, sd });
        Ok(())
    }

    /// All numbers, each as well known as it is.
    ///
    /// # Errors
    /// All that is missing or wrong, in one message.
    pub fn portrait(&self, catalogue: &'static Catalogue) -> Result<Portrait, KeyError> {
        let mut wrong = Vec::new();
        let model = self.model.as_deref().and_then(|name| catalogue.model(name));
        let class = match (&self.class, model) {
            (Some(name), _) => catalogue.class(name).map_err(|e| wrong.push(e.to_string())).ok(),
            (None, Some(model)) => catalogue.class(&model.class).ok(),
            (None, None) => {
                let names: Vec<&str> = catalogue.classes.iter().map(|c| c.name.as_str()).collect();
                let unknown =
                    self.model.as_ref().map(|m| format!("`{m}` is not in the catalogue: "));
                wrong.push(format!(
                    "{}give its class, one of {}",
                    unknown.unwrap_or_default(),
                    names.join(", ")
                ));
                None
            }
        };
        let usual = class.map(|class| match model {
            Some(model) => [&model.front, &model.rear],
            None => [&class.front, &class.rear],
        });
        let mut sizes: [Option<TyreSize>; 2] = [None, None];
        for (k, axle) in Axle::BOTH.into_iter().enumerate() {
            let printed = self.sizes[k].as_ref().or(usual.map(|u| u[k]));
            sizes[k] = printed.and_then(|printed| {
                let parsed = TyreSize::parse(printed);
                parsed.map_err(|e| wrong.push(format!("{} tyre: {e}", axle.name()))).ok()
            });
        }
        if let Some(weight) = self.weight.filter(|w| !(60.0..=800.0).contains(w)) {
            wrong.push(format!("a weight with rider of {weight} kg is not between 60 and 800 kg"));
        }
        if self.lifted.is_some() && self.scales.is_none() {
            wrong.push("a lifted axle needs the scales on level ground, too".to_owned());
        }
        let (Some(class), [Some(front), Some(rear)], true) = (class, sizes, wrong.is_empty())
        else {
            return Err(wrong.join("; ").into());
        };
        let sizes_said = [0, 1].map(|k| self.sizes[k].is_some() || model.is_some());
        let sizes = [front, rear];
        let (numbers, twice) = (Vec::new(), Vec::new());
        let mut draft = Draft { owner: self, catalogue, class, model, numbers, twice };
        draft.whole(&sizes)?;
        draft.wheels(&sizes, sizes_said)?;
        draft.resistance();
        draft.others();
        let Draft { numbers, twice, .. } = draft;
        if !twice.is_empty() {
            return Err(twice.join("; ").into());
        }
        Ok(Portrait { class, model, sizes, sizes_said, numbers, texts: self.texts.clone() })
    }
}

/// Numbers on their way into a bike file.
struct Draft<'a> {
    owner: &'a Owner,
    catalogue: &'static Catalogue,
    class: &'static Class,
    model: Option<&'static Model>,
    numbers: Vec<Number>,
    /// Text about numbers with two values.
    twice: Vec<String>,
}

impl Draft<'_> {
    /// Puts a number in, or what was measured instead.
    fn put(&mut self, key: &str, known: ValueWithSd, origin: Origin, source: &str) -> ValueWithSd {
        let mut number =
            Number { key: key.to_owned(), known, origin, source: source.trim().to_owned() };
        if let Some(&Measured { value, sd }) = self.owner.measured.get(key) {
            if !origin.is_guess() {
                self.twice.extend(twice(key, [(known.value, source), (value, "set as a key")]));
            }
            let usual = self.catalogue.measure(key).map_or(0.0, |m| m.sd(value));
            number.known = ValueWithSd { value, sd: sd.unwrap_or(usual) };
            number.origin = Origin::Measured;
            number.source = match (sd, usual > 0.0) {
                (Some(_), _) => "uncertainty given by the user".to_owned(),
                (None, true) => "uncertainty usual of such a measurement".to_owned(),
                (None, false) => "taken as exact".to_owned(),
            };
        }
        let known = number.known;
        self.numbers.push(number);
        known
    }

    fn guess(&mut self, key: &str, usual: &Usual, factor: f64) -> ValueWithSd {
        let known = ValueWithSd { value: factor * usual.mean, sd: factor * usual.sd };
        self.put(key, known, Origin::Class, &usual.source)
    }

    /// A number of the data sheet, where the model is known and has it.
    fn sheet(
        &mut self,
        key: &str,
        value: Option<f64>,
        sd: f64,
        usual: &Usual,
        unit: f64,
    ) -> ValueWithSd {
        let Some(value) = value else { return self.guess(key, usual, unit) };
        let known = ValueWithSd { value: unit * value, sd: unit * sd };
        let source = &self.catalogue.data_sheet.source;
        self.put(key, known, Origin::DataSheet, source)
    }

    /// Masses and lengths.
    fn whole(&mut self, sizes: &[TyreSize; 2]) -> Result<(), KeyError> {
        let (class, sheet, model) = (self.class, &self.catalogue.data_sheet, self.model);
        let length = self.owner.measured.get("wheelbase").map(|m| m.value);
        let length = length.or(model.map(|m| m.wheelbase)).unwrap_or(class.wheelbase.mean);
        let length_sd = if model.is_some() { sheet.wheelbase } else { class.wheelbase.sd };
        let wheelbase_sd = self.catalogue.measure("wheelbase").map_or(length_sd, |m| m.sd(length));
        let measured = self.owner.measured.contains_key("wheelbase");
        let known =
            ValueWithSd { value: length, sd: if measured { wheelbase_sd } else { length_sd } };
        let weighed = self.owner.scales.map(|loads| two_scales(loads, known)).transpose()?;
        if let (Some([mass, _]), Some(weight)) = (weighed, self.owner.weight) {
            self.twice.extend(twice("mass", [(mass.value, SCALES), (weight, SAID)]));
        }
        let mass = match (weighed, self.owner.weight, model) {
            (Some([mass, _]), ..) => self.put("mass", mass, Origin::Measured, SCALES),
            (None, Some(value), _) => {
                let sd = self.catalogue.tyre_size.weight;
                self.put("mass", ValueWithSd { value, sd }, Origin::Said, SAID)
            }
            (None, None, Some(model)) => {
                let value = model.kerb_mass + sheet.rider.mean;
                let sd = sheet.kerb_mass.hypot(sheet.rider.sd);
                let source = format!("{}, with {}", sheet.source, sheet.rider.source);
                self.put("mass", ValueWithSd { value, sd }, Origin::DataSheet, &source)
            }
            (None, None, None) => self.guess("mass", &class.mass, 1.0),
        };
        let wheelbase = self.sheet(
            "wheelbase",
            model.map(|m| m.wheelbase),
            sheet.wheelbase,
            &class.wheelbase,
            1.0,
        );
        match weighed {
            Some([_, arm]) => {
                self.put("cg_to_front", arm, Origin::Measured, "two scales and the wheelbase")
            }
            None => {
                let rear = 1.0 - class.front_share.mean;
                let known = ValueWithSd {
                    value: wheelbase.value * rear,
                    sd: wheelbase.value * class.front_share.sd,
                };
                let source = format!(
                    "{:.0} ± {:.0} % of the weight in front: {}",
                    100.0 * class.front_share.mean,
                    100.0 * class.front_share.sd,
                    class.front_share.source
                );
                self.put("cg_to_front", known, Origin::Class, &source)
            }
        };
        match self.owner.lifted.zip(self.owner.scales) {
            Some(([lift, after], [before, _])) => {
                let value = 0.5 * (sizes[0].radius() + sizes[1].radius());
                let radius =
                    ValueWithSd { value, sd: self.catalogue.tyre_size.radius_relative * value };
                let height = lifted_axle(lift, [before, after], mass, wheelbase, radius)?;
                self.put("cg_height", height, Origin::Measured, "a lifted axle")
            }
            None => self.guess("cg_height", &class.height_share, wheelbase.value),
        };
        let caster = model.and_then(|m| m.caster);
        self.sheet("caster_angle", caster, sheet.caster, &class.caster, 1f64.to_radians());
        self.sheet("trail", model.and_then(|m| m.trail), sheet.trail, &class.trail, 1.0);
        Ok(())
    }

    fn value(&self, key: &str) -> f64 {
        self.numbers.iter().find(|n| n.key == key).map_or(f64::NAN, |n| n.known.value)
    }

    /// Quantities that follow from the tyres' sizes, and the wheels.
    fn wheels(&mut self, sizes: &[TyreSize; 2], said: [bool; 2]) -> Result<(), KeyError> {
        let of = &self.catalogue.tyre_size;
        let behind = self.value("cg_to_front") / self.value("wheelbase");
        let weight = self.value("mass") * GRAVITY;
        let load = [(1.0 - behind) * weight, behind * weight];
        for (k, axle) in Axle::BOTH.into_iter().enumerate() {
            let size = &sizes[k];
            let key = |leaf: &str| format!("{}.{leaf}", axle.name());
            let origin = if said[k] { Origin::TyreSize } else { Origin::Class };
            let from = match said[k] {
                true => size.printed.clone(),
                false => format!("{}, usual of the class", size.printed),
            };
            let either = |known: f64, unknown: f64| if said[k] { known } else { unknown };
            let stiffness = size.vertical_stiffness(self.class.pressure[k]);
            let relative = of.stiffness_relative;
            let radius = size.radius() - SHARE * load[k] / stiffness;
            let sd = either(of.radius_relative, of.unknown_radius_relative) * radius;
            let source =
                format!("{from}: {:.4} m without load, less a third of the sinking", size.radius());
            self.put(&key("radius"), ValueWithSd { value: radius, sd }, origin, &source);
            let sd = either(of.width_relative, of.unknown_width_relative) * size.width;
            let source = format!("{from}; crown radius about {:.0} mm", 1e3 * size.crown());
            self.put(&key("width"), ValueWithSd { value: size.width, sd }, origin, &source);
            let class = [&self.class.inertia_front, &self.class.inertia_rear][k];
            match self.owner.swung[k] {
                Some([mass, arm, period]) => {
                    let known = swung_wheel(mass, arm, period)?;
                    self.put(&key("wheel_inertia"), known, Origin::Measured, "a swung wheel");
                }
                None => {
                    // mass goes with the radius, inertia with its cube
                    let usual = TyreSize::parse([&self.class.front, &self.class.rear][k])?;
                    let factor = (size.radius() / usual.radius()).powi(3);
                    self.guess(&key("wheel_inertia"), class, factor);
                }
            }
            let known = ValueWithSd { value: stiffness, sd: relative * stiffness };
            let source = format!(
                "{from} at {:.1} bar: 1.9 x pressure x sqrt(width x diameter), as published tyres; they differ by a quarter",
                1e-5 * self.class.pressure[k]
            );
            self.put(&key("vertical_stiffness"), known, origin, &source);
        }
        Ok(())
    }

    fn resistance(&mut self) {
        let class = self.class;
        self.guess("aerodynamics.drag", &class.drag, 1.0);
        self.guess("aerodynamics.rolling_resistance", &class.rolling_resistance, 1.0);
    }

    /// Keys that the wizard does not ask for and that were given.
    fn others(&mut self) {
        let owner = self.owner;
        for key in owner.measured.keys() {
            if !self.numbers.iter().any(|n| n.key == *key) {
                let nothing = ValueWithSd { value: f64::NAN, sd: 0.0 };
                self.put(key, nothing, Origin::Measured, "");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::bike::schema;

    fn naked() -> Owner {
        let sizes = ["120/70ZR17", "180/55ZR17"].map(|s| Some(s.to_owned()));
        Owner { class: Some("naked".into()), sizes, weight: Some(260.0), ..Owner::default() }
    }

    fn of(owner: &Owner, key: &str) -> Number {
        let portrait = owner.portrait(Catalogue::builtin()).unwrap_or_else(|e| panic!("{e}"));
        portrait.numbers.into_iter().find(|n| n.key == key).expect(key)
    }

    #[test]
    fn what_is_measured_replaces_the_guess_and_what_follows_from_it() {
        let mut owner = naked();
        let guess = of(&owner, "cg_to_front");
        assert!(guess.origin == Origin::Class && guess.known.sd > 0.02, "{guess:?}");
        owner.set("wheelbase=1.50", schema()).expect("a key");
        let with = of(&owner, "cg_to_front");
        assert!((with.known.value / guess.known.value - 1.50 / 1.435).abs() < 1e-9);
        owner.set("cg_height = 0.6 +- 0.02", schema()).expect("a key");
        assert_eq!(of(&owner, "cg_height").known, ValueWithSd { value: 0.6, sd: 0.02 });
        owner.scales = Some([125.0, 135.0]);
        let weighed = of(&owner, "cg_to_front");
        assert!(weighed.origin == Origin::Measured && weighed.known.sd < 0.01, "{weighed:?}");
        assert_eq!(of(&owner, "mass").known.value, 260.0);
    }

    #[test]
    fn all_that_is_wrong_is_in_one_message() {
        let mut owner = naked();
        owner.class = Some("cruiser".into());
        owner.sizes[1] = Some("wide".into());
        owner.weight = Some(6.0);
        owner.lifted = Some([0.3, 140.0]);
        let e = owner.portrait(Catalogue::builtin()).expect_err("four things").to_string();
        for part in ["cruiser", "rear tyre", "6 kg", "scales"] {
            assert!(e.contains(part), "{part}: {e}");
        }
        let e =
            Owner::default().portrait(Catalogue::builtin()).expect_err("nothing known").to_string();
        assert!(e.contains("class") && e.contains("naked"), "{e}");
    }

    #[test]
    fn keys_are_checked_as_they_are_set() {
        let mut owner = naked();
        for (text, part) in [
            ("cg_heigth=0.6", "did you mean `cg_height`"),
            ("cg_height=high", "is not a number"),
            ("cg_height=60", "not between"),
            ("cg_height", "key=value"),
            ("mass=250+--1", "not negative"),
            ("mass=inf", "is not a number"),
        ] {
            let e = owner.set(text, schema()).expect_err(text).to_string();
            assert!(e.contains(part), "{text}: {e}");
        }
        assert!(owner.measured.is_empty());
    }

    #[test]
    fn a_model_knows_its_data_sheet() {
        let owner = Owner { model: Some("mt-07".into()), ..Owner::default() };
        let wheelbase = of(&owner, "wheelbase");
        assert!(wheelbase.origin == Origin::DataSheet && wheelbase.known.value == 1.40);
        let class = of(&naked(), "wheelbase");
        assert!(wheelbase.known.sd < 0.5 * class.known.sd);
        // its weight is not its owner's
        assert!(of(&owner, "mass").known.sd > 10.0);
    }
}
