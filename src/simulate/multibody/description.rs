//! The motorcycle file: bodies, geometry, suspension, tyres of the simulator's motorcycle.
//!
//! Keys, units, ranges and defaults are declared in `schemas/motorcycle.v1.toml`. Published
//! motorcycles are built in (`pipelines/motorcycles/`).

use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::contract::file_kind::FileKind;
use crate::contract::key_error::KeyError;
use crate::contract::schema::{KeyTable, Values};
use crate::simulate::effects::tyre_file;
use crate::simulate::multibody::bodies::Rigid;
use crate::store::objects::files::read_text;
use crate::tyre::published;
use crate::tyre::tyre_model::TyreModel;

/// Built-in motorcycles: name and text.
pub(crate) const BUILTIN: &[(&str, &str)] = &[
    ("sports_small", include_str!("../../../pipelines/motorcycles/sports_small.toml")),
    ("sports_touring", include_str!("../../../pipelines/motorcycles/sports_touring.toml")),
    ("sharp_1971", include_str!("../../../pipelines/motorcycles/sharp_1971.toml")),
    ("benchmark_bicycle", include_str!("../../../pipelines/motorcycles/benchmark_bicycle.toml")),
];

/// Errors of a motorcycle file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not there or cannot be read.
    #[error("cannot read motorcycle file {path}: {source}")]
    Read { path: PathBuf, source: std::io::Error },
    /// Neither a built-in motorcycle nor a file.
    #[error("no motorcycle `{name}`{meant}; give a file, or one of {known}")]
    Unknown {
        name: String,
        /// Name that may have been meant, as a part of the sentence.
        meant: String,
        known: String,
    },
    /// A key is missing, misspelt or out of range, or the machine cannot stand.
    #[error("motorcycle file {path}: {message}")]
    Key { path: PathBuf, message: String },
}

/// Whether the wheels have tyres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// Tyres with vertical springs, slip and lag.
    Tyre,
    /// Rigid wheels that roll without slip.
    Rolling,
}

/// A spring with one preload and a damper with two rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suspension {
    pub stiffness: f64,
    /// Force or moment at zero travel.
    pub preload: f64,
    /// Damping in compression.
    pub compression: f64,
    /// Damping in rebound.
    pub rebound: f64,
}

impl Suspension {
    /// Force or moment that extends the suspension, for a compression and its rate.
    pub fn force(&self, travel: f64, rate: f64) -> f64 {
        let damping = if rate > 0.0 { self.compression } else { self.rebound };
        self.preload + self.stiffness * travel + damping * rate
    }
}

/// A chain between an engine sprocket on the frame and the wheel's sprocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chain {
    /// Engine sprocket in the frame, m.
    pub engine: Vector3<f64>,
    /// Its pitch radius, m.
    pub engine_radius: f64,
    /// The wheel sprocket's pitch radius, m.
    pub wheel_radius: f64,
}

/// Motorcycle of rigid bodies, checked. SI. Points from the nominal rear contact, x forward, z up.
///
/// Shares no numbers with the other descriptions on purpose: wheelbase, centre of mass and inertias follow from its
/// bodies, so that this simulator judges the others.
#[derive(Debug, Clone)]
pub struct Motorcycle {
    /// The file's stem or the built-in name.
    pub id: String,
    pub name: String,
    /// Tyres or rigid rolling wheels.
    pub contact: Contact,
    /// Gravity, m/s².
    pub gravity: f64,
    /// Inclination of the steering axis, rad.
    pub caster_angle: f64,
    /// Main frame with all that is rigid on it; about the origin.
    pub frame: Rigid,
    /// Swing arm without wheel.
    pub swing_arm: Rigid,
    pub pivot: Vector3<f64>,
    /// Rear suspension; `None` is rigid.
    pub rear_suspension: Option<Suspension>,
    /// Handlebar and upper fork.
    pub steering: Rigid,
    /// A point on the steering axis.
    pub steering_axis: Vector3<f64>,
    /// Steering damper, N m s/rad.
    pub steering_damping: f64,
    /// Lower fork without wheel.
    pub fork: Rigid,
    /// Front suspension; `None` is rigid.
    pub front_suspension: Option<Suspension>,
    /// A point on the twist axis, stiffness and damping; `None` is a rigid frame.
    pub twist: Option<(Vector3<f64>, f64, f64)>,
    /// The rider's upper body and the height of its lean axis; `None` where it is rigid.
    pub rider: Option<(Rigid, f64)>,
    /// Wheels, front and rear, about their centres.
    pub wheels: [Rigid; 2],
    pub centres: [Vector3<f64>; 2],
    /// Tyres, front and rear; absent on rolling wheels.
    pub tyres: Option<[Box<dyn TyreModel>; 2]>,
    /// Brake torque per pressure, front and rear, N m/Pa.
    pub brake_gain: [f64; 2],
    /// Largest crank torque, N m.
    pub engine_torque: f64,
    /// Crank inertia, kg m².
    pub engine_inertia: f64,
    /// Overall ratios, first gear first.
    pub ratios: [f64; 6],
    /// The chain; `None` is a shaft in the swing arm.
    pub chain: Option<Chain>,
    /// kg/m³.
    pub air_density: f64,
    /// Drag area, lift area, m²; pitch volume, m³.
    pub aerodynamics: [f64; 3],
    pub aerodynamic_centre: Vector3<f64>,
}

/// The declaration of every key.
pub(crate) fn schema() -> KeyTable {
    KeyTable::embedded("motorcycle")
}

impl Motorcycle {
    /// A built-in motorcycle by name, or a motorcycle file.
    ///
    /// # Errors
    /// See [`Error`]; the message names the key.
    pub fn load(name_or_path: &str) -> Result<Self, Error> {
        if let Some((name, text)) = BUILTIN.iter().find(|(n, _)| *n == name_or_path) {
            return Self::parse(text, name, Path::new(name));
        }
        let path = Path::new(name_or_path);
        if !path.exists() && path.extension().is_none() {
            let known: Vec<&str> = BUILTIN.iter().map(|(n, _)| *n).collect();
            return Err(Error::Unknown {
                name: name_or_path.into(),
                meant: crate::contract::schema::meant(name_or_path, known.iter().copied()),
                known: known.join(", "),
            });
        }
        let text =
            read_text(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::parse(&text, &stem, path)
    }

    /// Checks the text of a motorcycle file; tyre files are looked for beside `path`.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn parse(text: &str, id: &str, path: &Path) -> Result<Self, Error> {
        let fail = |message: String| Error::Key { path: path.to_owned(), message };
        let wrong = |e: KeyError| fail(e.to_string());
        let table: toml::Table =
            text.parse().map_err(|e: toml::de::Error| fail(format!("not valid TOML: {e}")))?;
        FileKind::Motorcycle.expect(text).map_err(wrong)?;
        let values = schema().check(&table).map_err(wrong)?;
        let motorcycle = assemble(&values, id, path).map_err(wrong)?;
        motorcycle.check().map_err(wrong)?;
        Ok(motorcycle)
    }

    /// The same motorcycle on other tyres.
    pub fn with_tyres(&self, front: Box<dyn TyreModel>, rear: Box<dyn TyreModel>) -> Self {
        Motorcycle { tyres: Some([front, rear]), contact: Contact::Tyre, ..self.clone() }
    }

    /// All rigid bodies with the points that their inertias are about.
    fn bodies(&self) -> [(&Rigid, Vector3<f64>); 6] {
        let zero = Vector3::zeros();
        [
            (&self.frame, zero),
            (&self.swing_arm, zero),
            (&self.steering, zero),
            (&self.fork, zero),
            (&self.wheels[0], self.centres[0]),
            (&self.wheels[1], self.centres[1]),
        ]
    }

    /// Mass of everything, kg.
    pub fn mass(&self) -> f64 {
        let rider = self.rider.as_ref().map_or(0.0, |(r, _)| r.mass);
        self.bodies().iter().map(|(b, _)| b.mass).sum::<f64>() + rider
    }

    /// Centre of mass of everything, upright.
    pub fn centre(&self) -> Vector3<f64> {
        let mut sum: Vector3<f64> =
            self.bodies().iter().map(|(b, at)| (b.centre + at) * b.mass).sum();
        if let Some((rider, _)) = &self.rider {
            sum += rider.centre * rider.mass;
        }
        sum / self.mass()
    }

    /// Wheelbase, m.
    pub fn wheelbase(&self) -> f64 {
        self.centres[0].x - self.centres[1].x
    }

    /// Trail on the road, m: how far the front contact lies behind the steering axis.
    pub fn trail(&self) -> f64 {
        let ground = self.steering_axis.x + self.steering_axis.z * self.caster_angle.tan();
        ground - self.centres[0].x
    }

    /// Static loads, front and rear, N.
    pub fn static_loads(&self) -> [f64; 2] {
        let weight = self.mass() * self.gravity;
        let front = weight * (self.centre().x - self.centres[1].x) / self.wheelbase();
        [front, weight - front]
    }

    /// Inertia of everything about its centre of mass, upright, kg m².
    pub fn inertia(&self) -> Matrix3<f64> {
        let centre = self.centre();
        let mut bodies = self.bodies().to_vec();
        if let Some((rider, _)) = &self.rider {
            bodies.push((rider, Vector3::zeros()));
        }
        bodies
            .iter()
            .map(|(b, at)| {
                let own = crate::simulate::multibody::bodies::spatial::skew(&b.centre);
                let about_centre = b.about_origin + own * own * b.mass;
                let arm =
                    crate::simulate::multibody::bodies::spatial::skew(&(b.centre + at - centre));
                about_centre - arm * arm * b.mass
            })
            .sum()
    }

    /// Whether this can stand and be ridden.
    fn check(&self) -> Result<(), KeyError> {
        if self.mass() <= 0.0 || self.frame.mass <= 0.0 {
            return Err(KeyError::Values("`frame.mass` must be positive".into()));
        }
        let radii = self.centres[0].z + self.centres[1].z;
        if self.wheelbase() < radii {
            return Err(KeyError::Values(format!(
                "the wheelbase, `front.wheel.x` - `rear.wheel.x` = {:.3} m, is shorter than the \
                 wheels' radii together ({radii:.3} m)",
                self.wheelbase()
            )));
        }
        let trail = self.trail();
        if trail <= 0.0 {
            return Err(KeyError::Values(format!(
                "the trail is {trail:.3} m: the front contact lies ahead of the steering axis; \
                 check `caster_angle`, `steering.axis_x` and `front.wheel.x`"
            )));
        }
        let x = self.centre().x;
        if x <= self.centres[1].x || x >= self.centres[0].x {
            return Err(KeyError::Values(format!(
                "the centre of mass lies {x:.3} m ahead of the rear contact, outside the wheelbase \
                 of {:.3} m: a wheel would lift; check `frame.x`",
                self.wheelbase()
            )));
        }
        if self.centre().z <= 0.0 {
            return Err(KeyError::Values(
                "the centre of mass lies below the road; check `frame.z`".into(),
            ));
        }
        for (name, body) in [
            ("frame", &self.frame),
            ("swing_arm", &self.swing_arm),
            ("steering", &self.steering),
            ("fork", &self.fork),
        ] {
            let arm = crate::simulate::multibody::bodies::spatial::skew(&body.centre);
            let own = body.about_origin + arm * arm * body.mass;
            let eigenvalues = own.symmetric_eigenvalues();
            if eigenvalues.min() < -1e-9 {
                return Err(KeyError::Values(format!(
                    "`{name}.ixz` is too large for the inertias beside it"
                )));
            }
        }
        if self.contact == Contact::Tyre && self.tyres.is_none() {
            return Err("missing key `front.tyre` or `rear.tyre` (a published set's name or a \
                        file), or `contact = \"rolling\"`"
                .into());
        }
        if let Some(tyres) = &self.tyres {
            for (end, tyre, centre) in
                [("front", &tyres[0], self.centres[0]), ("rear", &tyres[1], self.centres[1])]
            {
                let radius = tyre.carcass().radius;
                if (radius - centre.z).abs() > 0.08 {
                    return Err(KeyError::Values(format!(
                        "`{end}.wheel.z` = {:.3} m does not fit its tyre's radius {radius:.3} m",
                        centre.z
                    )));
                }
            }
        }
        Ok(())
    }
}

/// The numbers of a file by dotted key.
struct Keys<'a>(&'a Values);

impl Keys<'_> {
    fn get(&self, key: &str) -> f64 {
        self.opt(key).unwrap_or(f64::NAN)
    }

    fn opt(&self, key: &str) -> Option<f64> {
        self.0.number.get(key).copied()
    }

    fn point(&self, x: &str, z: &str) -> Vector3<f64> {
        Vector3::new(self.get(x), 0.0, self.get(z))
    }

    fn rigid(&self, name: &str) -> Rigid {
        let key = |leaf: &str| self.get(&format!("{name}.{leaf}"));
        let own = Matrix3::new(
            key("ixx"),
            0.0,
            key("ixz"),
            0.0,
            key("iyy"),
            0.0,
            key("ixz"),
            0.0,
            key("izz"),
        );
        // turned back: z leans towards -x, which is a negative turn about y
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), -key("tilt")).into_inner();
        let about_centre = turn * own * turn.transpose();
        Rigid::new(key("mass"), Vector3::new(key("x"), 0.0, key("z")), about_centre)
    }

    fn wheel(&self, end: &str) -> Rigid {
        let (spin, across) = (
            self.get(&format!("{end}.wheel.spin_inertia")),
            self.get(&format!("{end}.wheel.diametral_inertia")),
        );
        let own = Matrix3::from_diagonal(&Vector3::new(across, spin, across));
        Rigid::new(self.get(&format!("{end}.wheel.mass")), Vector3::zeros(), own)
    }

    /// Tyre of one end, from beside the file or published; `None` where the file names none.
    fn tyre(&self, end: &str, path: &Path) -> Result<Option<Box<dyn TyreModel>>, KeyError> {
        let Some(name) = self.0.text.get(&format!("{end}.tyre")) else { return Ok(None) };
        let beside = path.parent().unwrap_or(Path::new("")).join(name);
        let tyre = if published::text(name).is_none() && beside.exists() {
            tyre_file::load(&beside.to_string_lossy())
        } else {
            tyre_file::load(name)
        };
        tyre.map(Some).map_err(|e| KeyError::Values(format!("`{end}.tyre`: {e}")))
    }

    fn chain(&self) -> Result<Option<Chain>, KeyError> {
        match (
            self.opt("chain.engine_x"),
            self.opt("chain.engine_z"),
            self.opt("chain.engine_radius"),
            self.opt("chain.wheel_radius"),
        ) {
            (None, None, None, None) => Ok(None),
            (Some(x), Some(z), Some(engine_radius), Some(wheel_radius)) => {
                Ok(Some(Chain { engine: Vector3::new(x, 0.0, z), engine_radius, wheel_radius }))
            }
            _ => Err(KeyError::Values(
                "`chain` needs all of engine_x, engine_z, engine_radius, wheel_radius".into(),
            )),
        }
    }

    /// Spring and damper; without a preload in the file the one that carries the static load.
    fn suspension(&self, name: &str, static_preload: f64) -> Option<Suspension> {
        self.opt(&format!("{name}.stiffness")).map(|stiffness| Suspension {
            stiffness,
            preload: self.opt(&format!("{name}.preload")).unwrap_or(static_preload),
            compression: self.get(&format!("{name}.compression")),
            rebound: self.get(&format!("{name}.rebound")),
        })
    }
}

fn assemble(values: &Values, id: &str, path: &Path) -> Result<Motorcycle, KeyError> {
    let keys = Keys(values);
    let contact = match values.text.get("contact").map(String::as_str) {
        None | Some("tyre") => Contact::Tyre,
        Some("rolling") => Contact::Rolling,
        Some(other) => {
            return Err(KeyError::Values(format!(
                "`contact` = \"{other}\" is neither tyre nor rolling"
            )));
        }
    };
    let tyres = match (keys.tyre("front", path)?, keys.tyre("rear", path)?) {
        (Some(front), Some(rear)) => Some([front, rear]),
        _ => None,
    };
    let chain = keys.chain()?;
    let centres =
        [keys.point("front.wheel.x", "front.wheel.z"), keys.point("rear.wheel.x", "rear.wheel.z")];
    let frame = keys.rigid("frame");
    let rider = keys.rigid("rider");
    let mut motorcycle = Motorcycle {
        id: id.to_owned(),
        name: values.text.get("name").cloned().unwrap_or_else(|| id.to_owned()),
        contact,
        gravity: keys.get("gravity"),
        caster_angle: keys.get("caster_angle"),
        aerodynamic_centre: match (keys.opt("aerodynamics.x"), keys.opt("aerodynamics.z")) {
            (Some(x), Some(z)) => Vector3::new(x, 0.0, z),
            _ => frame.centre,
        },
        frame,
        swing_arm: keys.rigid("swing_arm"),
        pivot: keys.point("swing_arm.pivot_x", "swing_arm.pivot_z"),
        rear_suspension: None,
        steering: keys.rigid("steering"),
        steering_axis: keys.point("steering.axis_x", "steering.axis_z"),
        steering_damping: keys.get("steering.damping"),
        fork: keys.rigid("fork"),
        front_suspension: None,
        twist: keys.opt("frame_twist.stiffness").map(|stiffness| {
            (
                keys.point("frame_twist.x", "frame_twist.z"),
                stiffness,
                keys.get("frame_twist.damping"),
            )
        }),
        rider: (rider.mass > 0.0).then_some((rider, keys.get("rider.axis_z"))),
        wheels: [keys.wheel("front"), keys.wheel("rear")],
        centres,
        tyres,
        brake_gain: [keys.get("brakes.gain_front"), keys.get("brakes.gain_rear")],
        engine_torque: keys.get("engine.torque"),
        engine_inertia: keys.get("engine.inertia"),
        ratios: std::array::from_fn(|i| keys.get(&format!("engine.ratio_{}", i + 1))),
        chain,
        air_density: keys.get("aerodynamics.air_density"),
        aerodynamics: ["drag_area", "lift_area", "pitch_volume"]
            .map(|k| keys.get(&format!("aerodynamics.{k}"))),
    };
    // the preloads that carry the static loads at zero travel
    let g = motorcycle.gravity;
    let [front, rear] = motorcycle.static_loads();
    let m = &motorcycle;
    let swing = (rear - m.wheels[1].mass * g) * (m.pivot.x - centres[1].x)
        - m.swing_arm.mass * g * (m.pivot.x - m.swing_arm.centre.x);
    let fork = (front - (m.wheels[0].mass + m.fork.mass) * g) * m.caster_angle.cos();
    motorcycle.rear_suspension = keys.suspension("swing_arm", swing);
    motorcycle.front_suspension = keys.suspension("fork", fork);
    Ok(motorcycle)
}
