//! The coefficients of a motorcycle's tyres and of the motorcycle as a whole: name, symbol, unit,
//! words, needed channels and the riding that determines each, declared once.
//!
//! A fit gives a coefficient its value and its uncertainty. Everything else about it in tables, pages
//! and messages comes from [`Coefficient::spec`].

use std::fmt;
use std::ops::{Index, IndexMut};

use super::bike::Axle;
use super::channel::Channel;
use super::session::Session;

use Channel as C;

/// Part that a coefficient belongs to: the column `tyre` of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    Front,
    Rear,
    /// The motorcycle with its rider.
    Vehicle,
}

impl Part {
    /// In the order of the tables.
    pub const ALL: [Part; 3] = [Part::Front, Part::Rear, Part::Vehicle];

    /// As the column `tyre` has it.
    pub const fn name(self) -> &'static str {
        match self {
            Part::Front => "front",
            Part::Rear => "rear",
            Part::Vehicle => "vehicle",
        }
    }

    /// The part of a name of the column `tyre`.
    pub fn from_name(name: &str) -> Option<Part> {
        Part::ALL.into_iter().find(|part| part.name() == name)
    }

    /// The axle of a tyre; `None` of the vehicle.
    pub const fn axle(self) -> Option<Axle> {
        match self {
            Part::Front => Some(Axle::Front),
            Part::Rear => Some(Axle::Rear),
            Part::Vehicle => None,
        }
    }
}

impl From<Axle> for Part {
    fn from(axle: Axle) -> Part {
        match axle {
            Axle::Front => Part::Front,
            Axle::Rear => Part::Rear,
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Where a coefficient's value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Fitted to the manoeuvres of an on-road session.
    OnRoad,
    /// From the tyre forces of an off-road session.
    OffRoad,
    /// From the joint fit to a ride in gear, only where the ordinary manoeuvres are missing.
    InGear,
    /// Fitted to how the lean changes, else taken from the bike file: how, as for [`Source::BikeFile`].
    ChangingLean(&'static str),
    /// Not estimated but taken from the bike file or a rule; how, as the column `reason` has it where
    /// nothing is known better.
    BikeFile(&'static str),
}

/// Requirements of a coefficient, for one part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Requirement {
    pub part: Part,
    /// Channels, all of which are needed besides the bike file's masses and lengths; none for what
    /// is taken from the bike file.
    pub channels: &'static [Channel],
    pub riding: Riding,
}

impl Requirement {
    /// The needed channels of which a session has no valid sample.
    pub fn missing(&self, session: &Session) -> Vec<Channel> {
        let valid = |c: Channel| session.get(c).is_some_and(|x| x.iter().any(|v| v.is_finite()));
        // what asks for the handlebar is too fine for a course
        let is_fine = self.channels.contains(&C::SteerAngle);
        let turns = !is_fine && TURNING.iter().any(|way| way.iter().all(|c| valid(*c)));
        // a sensor of the wheel's own does without the motion of the frame
        let is_slipping = self.channels.contains(&C::VelocityY);
        let has_slip_angle = match self.part {
            Part::Front => valid(C::SlipAngleFront),
            Part::Rear => valid(C::SlipAngleRear),
            Part::Vehicle => false,
        };
        let has_moment = match self.part {
            Part::Front => valid(C::WheelMomentXFront),
            Part::Rear => valid(C::WheelMomentXRear),
            Part::Vehicle => false,
        };
        let there = |c: Channel| match c {
            C::YawRate => valid(c) || turns,
            C::VelocityY | C::SteerAngle if is_slipping => valid(c) || has_slip_angle,
            C::SteerAngle if self.riding == BENDS => valid(c) || has_moment,
            C::Gear => shows_coasting(session),
            _ => valid(c),
        };
        self.channels.iter().copied().filter(|&c| !there(c)).collect()
    }
}

/// Whether the channels tell coasting in neutral from gentle drive and from engine braking: a gear that is both neutral and
/// engaged, or else a throttle that opens and closes beside both wheels' speeds and the acceleration.
///
/// METHOD: speed alone is the same in all three. A bicycle's GPS log, never coasting, gave a negative rolling resistance.
pub fn shows_coasting(session: &Session) -> bool {
    let both = |c: Channel, low: f64, high: f64| {
        session.get(c).is_some_and(|x| x.iter().any(|v| *v < low) && x.iter().any(|v| *v > high))
    };
    let valid = |c: &Channel| session.get(*c).is_some_and(|x| x.iter().any(|v| v.is_finite()));
    both(C::Gear, 0.5, 0.5)
        || both(C::Throttle, 0.02, 0.1)
            && [C::WheelSpeedFront, C::WheelSpeedRear, C::AccelerationX].iter().all(valid)
}

/// The riding that determines a coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Riding {
    /// As a noun phrase.
    pub manoeuvres: &'static str,
    /// As an instruction to the rider: the end of a `reason`.
    pub remedy: &'static str,
}

/// Everything that is known of a coefficient before any ride.
#[derive(Debug, Clone, Copy)]
pub struct Spec {
    pub name: &'static str,
    /// In the source paper.
    pub symbol: &'static str,
    /// SI; `1` for a ratio.
    pub unit: &'static str,
    /// The field's term: the column `term`, pages and messages.
    pub term: &'static str,
    /// The term in at most 19 letters, for sentences and narrow tables.
    pub short: &'static str,
    /// Where its value comes from.
    pub source: Source,
    /// Requirements, one entry for each part that has the coefficient.
    pub requirements: &'static [Requirement],
    /// Ends between which a motorcycle's or a bicycle's value lies; one beyond them is a fault of the log or its map.
    pub bounds: [f64; 2],
}

macro_rules! coefficients {
    ($($variant:ident: $name:literal, $symbol:literal, $unit:literal, $term:literal, $short:literal,
        $source:expr, $requirements:expr, $bounds:expr;)*) => {
        /// A coefficient of a tyre or of the vehicle.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Coefficient {
            $(#[doc = concat!("`", $name, "`: ", $term, ", ", $unit)] $variant),*
        }

        impl Coefficient {
            /// Every coefficient, in the order of tables and pages.
            pub const ALL: &'static [Coefficient] = &[$(Coefficient::$variant),*];
            /// How many there are.
            pub const COUNT: usize = Self::ALL.len();

            pub const fn spec(self) -> &'static Spec {
                match self {
                    $(Coefficient::$variant => &Spec {
                        name: $name,
                        symbol: $symbol,
                        unit: $unit,
                        term: $term,
                        short: $short,
                        source: $source,
                        requirements: $requirements,
                        bounds: $bounds,
                    },)*
                }
            }

            /// The coefficient of a name of the tables.
            pub fn from_name(name: &str) -> Option<Coefficient> {
                match name { $($name => Some(Coefficient::$variant),)* _ => None }
            }
        }
    };
}

// In the order of the data flow: coasting, braking and driving, corners; then what no ride gives, and
// what only off-road riding gives.
//
// variant: name, symbol, unit, term, short term, source, requirements, bounds
coefficients! {
    EffectiveRollingRadius: "effective_rolling_radius", "R_rol", "m",
        "effective rolling radius", "rolling radius",
        OnRoad, RADIUS, [0.1, 0.6];
    Drag: "drag", "c_drag", "kg/m",
        "drag area term, 0.5 rho C_d A", "aerodynamic drag",
        OnRoad, RESISTANCE, [0.0, 3.0];
    RollingResistance: "rolling_resistance", "c_rol", "1",
        "rolling resistance coefficient", "rolling resistance",
        OnRoad, RESISTANCE, [0.0, 0.1];
    PeakSlip: "peak_slip", "sigma_x_max", "1",
        "normalised slip sigma at peak friction", "peak slip sigma",
        OnRoad, FRICTION, [0.0, 1.0];
    MfB: "mf_b", "b", "1",
        "Magic Formula B, stiffness factor", "Magic Formula B",
        OnRoad, FRICTION, [0.0, 200.0];
    MfC: "mf_c", "c", "1",
        "Magic Formula C, shape factor", "Magic Formula C",
        OnRoad, FRICTION, [0.5, 3.0];
    MfD: "mf_d", "d", "1",
        "peak friction coefficient", "peak friction",
        OnRoad, FRICTION, [0.05, 2.0];
    MfE1: "mf_e1", "e1", "1",
        "Magic Formula E, curvature factor, symmetric part", "Magic Formula E1",
        OnRoad, CURVATURE, [-100.0, 1.0];
    MfE2: "mf_e2", "e2", "1",
        "Magic Formula E, curvature factor, braking/driving part", "Magic Formula E2",
        OnRoad, CURVATURE, [-100.0, 100.0];
    SlipStiffnessLoad: "slip_stiffness_load", "k_s,N", "1",
        "load sensitivity of slip stiffness", "load sensitivity",
        TAKEN, ASSUMED, [-2.0, 2.0];
    SlipCamberC1: "slip_camber_c1", "c1", "1",
        "slip angle over camber, linear", "slip/camber, linear",
        OnRoad, SLIP_ANGLE, [-1.0, 1.0];
    SlipCamberC3: "slip_camber_c3", "c3", "1/rad2",
        "slip angle over camber, cubic", "slip/camber, cubic",
        OnRoad, SLIP_ANGLE, [-10.0, 10.0];
    LateralFrictionCt: "lateral_friction_ct", "ct", "1",
        "side force over load, per tan(camber)", "side force by lean",
        OnRoad, LATERAL_FORCE, [-1.5, 0.0];
    CorneringStiffness0: "cornering_stiffness_0", "k_alpha0", "1/rad",
        "cornering stiffness coefficient", "cornering stiffness",
        OnRoad, SIDE_STIFFNESS, [0.0, 100.0];
    CamberStiffness0: "camber_stiffness_0", "k_gamma0", "1/rad",
        "camber stiffness coefficient", "camber stiffness",
        OnRoad, SIDE_STIFFNESS, [0.0, 10.0];
    SideForceRatio: "side_force_ratio", "C", "1",
        "camber-to-cornering stiffness ratio", "camber/cornering",
        ChangingLean(GIVEN), LEAN_CHANGES, [0.0, 1.0];
    TwistingStiffness: "twisting_stiffness", "k_t", "m/rad",
        "twisting torque coefficient", "twisting torque",
        TAKEN, ASSUMED, [-0.2, 0.2];
    OverturningStiffness: "overturning_stiffness", "k_x", "m",
        "crown radius", "crown radius",
        OnRoad, OVERTURNING, [0.0, 0.3];
    RelaxationLength: "relaxation_length", "r_l", "m",
        "relaxation length", "relaxation length",
        BikeFile("the wheel radius (eq. 1), not given: a rule, true within 0.3 to 2 times"), ASSUMED, [0.0, 3.0];
    PneumaticTrail0: "pneumatic_trail_0", "t_p0", "m",
        "pneumatic trail at small slip", "pneumatic trail",
        BikeFile("from the vertical stiffness (eq. 12): a rule, true within 0.3 to 2 times"), ASSUMED, [0.0, 0.2];
    EngagedFrictionBraking: "engaged_friction_braking", "B/N", "1",
        "friction engaged by braking", "friction braking",
        OffRoad, BRAKED_OFFROAD, [-3.0, 3.0];
    EngagedFrictionDriving: "engaged_friction_driving", "D/N", "1",
        "friction engaged by driving", "friction driving",
        OffRoad, DRIVEN_OFFROAD, [-3.0, 3.0];
    SlipStiffness: "slip_stiffness", "K_x", "1",
        "slip stiffness coefficient, b c d", "slip stiffness",
        InGear, RIDDEN_IN_GEAR, [0.0, 200.0];
    BrakeGain: "brake_gain", "k_b", "N m/Pa",
        "brake torque over pressure", "brake gain",
        InGear, BRAKED_IN_GEAR, [0.0, 0.01];
}

use Source::{BikeFile, ChangingLean, InGear, OffRoad, OnRoad};
const TAKEN: Source = BikeFile(GIVEN);

/// The reason of what the bike file gives.
pub(crate) const GIVEN: &str = "given in the bike file";
/// The true value over that of a rule (relaxation length, pneumatic trail): within these.
pub(crate) const RULE: [f64; 2] = [0.3, 2.0];

const fn needs(part: Part, channels: &'static [Channel], riding: Riding) -> Requirement {
    Requirement { part, channels, riding }
}

/// Channels that give the yaw rate where it was not measured.
const TURNING: [&[Channel]; 2] = [&[C::Yaw], &[C::Latitude, C::Longitude]];

const FRONT_WHEEL: &[Channel] = &[C::VelocityX, C::WheelSpeedFront];
const REAR_WHEEL: &[Channel] = &[C::VelocityX, C::WheelSpeedRear];
// both tyres' loads and forces are balanced together; the front's camber (31a) hardly depends on the handlebar
const LEANING: &[Channel] = &[C::VelocityX, C::YawRate, C::Roll];
// a crown is the small rest of a lean: it asks for the handlebar, too
const STEERED: &[Channel] = &[C::VelocityX, C::YawRate, C::Roll, C::SteerAngle];
const SLIPPING: &[Channel] = &[C::VelocityX, C::VelocityY, C::YawRate, C::Roll, C::SteerAngle];
// the other ten of the thirteen off-road channels can be replaced one at a time, these cannot
const PLANAR: &[Channel] = &[C::Pitch, C::ForkTravel, C::ShockTravel];

const COASTING: Riding = Riding {
    manoeuvres: "straight coasting, declutched or in neutral",
    remedy: "coast in neutral",
};
const FRONT_BRAKING: &str = "straight braking with the front brake alone, from gentle to hard";
const REAR_FORCES: &str =
    "straight braking with the rear brake alone, and hard acceleration in first gear";
const BENDS: Riding = Riding {
    manoeuvres: "steady corners at different lean, best to both sides",
    remedy: "ride steady corners of varied lean, without brake and throttle",
};
const OFFROAD: Riding = Riding {
    manoeuvres: "off-road: firm braking and drive on the ground, in several corners",
    remedy: "brake and drive firmly on the ground",
};
/// Riding that separates cornering and camber stiffness best: `simulate::manoeuvre::advised_passes`.
pub(crate) const SLALOM: &str =
    "ride four slalom passes at 16 m/s: two with cones 27 m apart, two with cones 11 m apart";
const SIDE_FORCES: Riding = Riding {
    manoeuvres: "slaloms and lane changes; steady corners at different lean, best to both sides",
    remedy: SLALOM,
};
const SLALOMS: Riding = Riding {
    manoeuvres: "slaloms, lane changes, or corners with their roll-in and roll-out; else it is taken from the bike file",
    remedy: SLALOM,
};
const BENCH: Riding = Riding {
    manoeuvres: "no riding manoeuvre: a tyre bench; until then it is taken from the bike file",
    remedy: "measure it on a tyre bench",
};

const RADIUS: &[Requirement] =
    &[needs(Part::Front, FRONT_WHEEL, COASTING), needs(Part::Rear, REAR_WHEEL, COASTING)];
// the gear, or what shows coasting as well: `shows_coasting`
const RESISTANCE: &[Requirement] = &[needs(
    Part::Vehicle,
    &[C::VelocityX, C::Gear],
    Riding {
        manoeuvres: "straight coasting in neutral from different speeds, in both directions",
        remedy: "coast in neutral at two speeds, in both directions",
    },
)];
const FRICTION: &[Requirement] = &[
    needs(
        Part::Front,
        FRONT_WHEEL,
        Riding {
            manoeuvres: FRONT_BRAKING,
            remedy: "brake with the front brake alone, progressively to the limit, in neutral",
        },
    ),
    needs(
        Part::Rear,
        REAR_WHEEL,
        Riding {
            manoeuvres: REAR_FORCES,
            remedy: "brake with the rear brake alone, progressively to the limit, in neutral",
        },
    ),
];
const CURVATURE: &[Requirement] = &[
    needs(
        Part::Front,
        FRONT_WHEEL,
        Riding {
            manoeuvres: FRONT_BRAKING,
            remedy: "brake with the front brake alone past the friction peak",
        },
    ),
    needs(
        Part::Rear,
        REAR_WHEEL,
        Riding {
            manoeuvres: REAR_FORCES,
            remedy: "brake the rear wheel alone past the friction peak and accelerate hard in \
                     first gear",
        },
    ),
];
const SLIP_ANGLE: &[Requirement] =
    &[needs(Part::Front, SLIPPING, BENDS), needs(Part::Rear, SLIPPING, BENDS)];
const SIDE_STIFFNESS: &[Requirement] =
    &[needs(Part::Front, SLIPPING, SIDE_FORCES), needs(Part::Rear, SLIPPING, SIDE_FORCES)];
const LATERAL_FORCE: &[Requirement] =
    &[needs(Part::Front, LEANING, BENDS), needs(Part::Rear, LEANING, BENDS)];
const OVERTURNING: &[Requirement] = &[
    needs(Part::Front, STEERED, BENDS),
    needs(Part::Rear, STEERED, BENDS),
    needs(
        Part::Vehicle,
        STEERED,
        Riding { remedy: "ride steady corners with more than 15 degrees of lean", ..BENDS },
    ),
];
const LEAN_CHANGES: &[Requirement] =
    &[needs(Part::Front, STEERED, SLALOMS), needs(Part::Rear, STEERED, SLALOMS)];
const ASSUMED: &[Requirement] = &[needs(Part::Front, &[], BENCH), needs(Part::Rear, &[], BENCH)];
const BRAKED_OFFROAD: &[Requirement] =
    &[needs(Part::Front, PLANAR, OFFROAD), needs(Part::Rear, PLANAR, OFFROAD)];
const DRIVEN_OFFROAD: &[Requirement] = &[needs(Part::Rear, PLANAR, OFFROAD)];
const LAPS: Riding = Riding {
    manoeuvres: "laps in gear with braking and drive of every strength",
    remedy: "brake and accelerate in a straight line, from gentle to hard, over several laps",
};
const BOTH_WHEELS: &[Channel] =
    &[C::VelocityX, C::WheelSpeedFront, C::WheelSpeedRear, C::Throttle, C::Roll];
const RIDDEN_IN_GEAR: &[Requirement] =
    &[needs(Part::Front, BOTH_WHEELS, LAPS), needs(Part::Rear, BOTH_WHEELS, LAPS)];
const BRAKED_IN_GEAR: &[Requirement] = &[
    needs(Part::Front, &[C::WheelSpeedFront, C::WheelSpeedRear, C::BrakePressureFront], LAPS),
    needs(Part::Rear, &[C::WheelSpeedFront, C::WheelSpeedRear, C::BrakePressureRear], LAPS),
];

impl Coefficient {
    pub const fn name(self) -> &'static str {
        self.spec().name
    }

    /// Requirements for a part; `None` where the part has no such coefficient.
    pub fn requirement(self, part: Part) -> Option<&'static Requirement> {
        self.spec().requirements.iter().find(|r| r.part == part)
    }

    /// Why a value is none that a tyre or a motorcycle can have; `None` of one within [`Spec::bounds`], and of none.
    pub fn impossible(self, value: f64) -> Option<String> {
        let [low, high] = self.spec().bounds;
        // the lower end is a sign more often than not: zero itself is none either
        let beyond = value <= low || value >= high;
        beyond.then(|| {
            let (sign, words) = match self {
                // the words are those of the slip ratio
                Coefficient::PeakSlip => ("σ = ", "σ = κ/(1 − κ) at peak friction"),
                _ => ("", self.spec().term),
            };
            let value = shown(value);
            format!("{sign}{value} is impossible, {words} lies between {low} and {high}")
        })
    }

    /// Whether every on-road session has a row of it, estimated or assumed.
    pub fn is_onroad(self) -> bool {
        matches!(self.spec().source, OnRoad | ChangingLean(_) | BikeFile(_))
    }
}

/// Three significant digits.
fn shown(value: f64) -> String {
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0);
    format!("{value:.*}", decimals as usize)
}

impl fmt::Display for Coefficient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A coefficient of a part: what one row of the table `coefficients` is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id {
    pub part: Part,
    pub coefficient: Coefficient,
}

impl Id {
    /// Those that an on-road session has rows of, in the order of the tables.
    pub fn onroad() -> impl Iterator<Item = Id> {
        Part::ALL.into_iter().flat_map(|part| {
            let own = move |c: &&Coefficient| c.is_onroad() && c.requirement(part).is_some();
            Coefficient::ALL.iter().filter(own).map(move |&coefficient| Id { part, coefficient })
        })
    }

    /// The coefficient of a row's columns `tyre` and `coefficient`.
    pub fn from_names(tyre: &str, coefficient: &str) -> Option<Id> {
        let (part, coefficient) = (Part::from_name(tyre)?, Coefficient::from_name(coefficient)?);
        coefficient.requirement(part).map(|_| Id { part, coefficient })
    }

    /// Requirements.
    ///
    /// # Panics
    /// Where the part has no such coefficient: our own mistake.
    pub fn requirement(self) -> &'static Requirement {
        let Some(found) = self.coefficient.requirement(self.part) else {
            panic!("no coefficient `{}` of the {}", self.coefficient, self.part)
        };
        found
    }
}

impl<P: Into<Part>> From<(P, Coefficient)> for Id {
    fn from((part, coefficient): (P, Coefficient)) -> Id {
        Id { part: part.into(), coefficient }
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.part, self.coefficient)
    }
}

/// A number for every coefficient of every part, in the coefficient's unit; NaN where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Values([[f64; Coefficient::COUNT]; Part::ALL.len()]);

impl Default for Values {
    fn default() -> Self {
        Values([[f64::NAN; Coefficient::COUNT]; Part::ALL.len()])
    }
}

impl Values {
    /// `self - other`, coefficient by coefficient.
    #[must_use]
    pub fn minus(&self, other: &Values) -> Values {
        let mut out = self.clone();
        for (row, subtracted) in out.0.iter_mut().zip(&other.0) {
            for (x, y) in row.iter_mut().zip(subtracted) {
                *x -= y;
            }
        }
        out
    }
}

impl<I: Into<Id>> Index<I> for Values {
    type Output = f64;

    fn index(&self, id: I) -> &f64 {
        let id = id.into();
        &self.0[id.part as usize][id.coefficient as usize]
    }
}

impl<I: Into<Id>> IndexMut<I> for Values {
    fn index_mut(&mut self, id: I) -> &mut f64 {
        let id = id.into();
        &mut self.0[id.part as usize][id.coefficient as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    /// The contract's list, word for word and in its order.
    const TYRE: &str = "effective_rolling_radius peak_slip mf_b mf_c mf_d mf_e1 mf_e2 \
        slip_stiffness_load slip_camber_c1 slip_camber_c3 lateral_friction_ct cornering_stiffness_0 \
        camber_stiffness_0 side_force_ratio twisting_stiffness overturning_stiffness \
        relaxation_length pneumatic_trail_0";
    const VEHICLE: &str = "drag rolling_resistance overturning_stiffness";

    #[test]
    fn the_rows_of_an_onroad_session_are_those_of_the_contract() {
        for (part, names) in [(Part::Front, TYRE), (Part::Rear, TYRE), (Part::Vehicle, VEHICLE)] {
            let own = Id::onroad().filter(|id| id.part == part).map(|id| id.coefficient.name());
            let want: Vec<&str> = names.split_whitespace().collect();
            assert_eq!(own.collect::<Vec<_>>(), want, "{part}");
        }
        assert_eq!(Id::onroad().count(), 39);
    }

    #[test]
    fn only_what_is_taken_from_the_bike_file_needs_no_channel() {
        for c in Coefficient::ALL {
            let taken = matches!(c.spec().source, BikeFile(_));
            for r in c.spec().requirements {
                assert_eq!(r.channels.is_empty(), taken, "{c}");
                assert_eq!(r.riding == BENCH, taken, "{c}");
            }
        }
    }

    #[test]
    fn names_find_their_coefficient() {
        for id in Id::onroad() {
            assert_eq!(Id::from_names(id.part.name(), id.coefficient.name()), Some(id));
        }
        assert_eq!(Id::from_names("front", "drag"), None);
        assert_eq!(Id::from_names("front", "drago"), None);
        assert_eq!(Part::from_name("side"), None);
    }

    /// A number per stiffness misleads where the unit is a length: the term says what it is.
    #[test]
    fn terms_are_those_of_the_field_and_short_ones_fit_a_column() {
        let term = |c: Coefficient| c.spec().term;
        assert_eq!(term(Coefficient::OverturningStiffness), "crown radius");
        assert_eq!(term(Coefficient::MfD), "peak friction coefficient");
        let mut seen = std::collections::BTreeSet::new();
        for c in Coefficient::ALL {
            let spec = c.spec();
            assert!(spec.short.chars().count() <= 19, "{}", spec.short);
            assert!(seen.insert(spec.term) && seen.insert(spec.name), "{} twice", spec.term);
        }
    }

    #[test]
    fn an_empty_channel_is_missing() {
        let mut session = Session::new(Meta::default(), 10.0, 2);
        session.set(C::VelocityX, vec![1.0, 2.0]);
        session.set(C::WheelSpeedFront, vec![f64::NAN; 2]);
        let missing = |c: Coefficient| {
            c.requirement(Part::Front).map(|r| r.missing(&session)).unwrap_or_default()
        };
        assert_eq!(missing(Coefficient::EffectiveRollingRadius), [C::WheelSpeedFront]);
        assert_eq!(missing(Coefficient::TwistingStiffness), []);
    }

    #[test]
    fn a_value_is_read_where_it_was_written() {
        let mut values = Values::default();
        for (i, id) in Id::onroad().enumerate() {
            values[id] = i as f64;
        }
        for (i, id) in Id::onroad().enumerate() {
            assert_eq!(values[id], i as f64, "{id}");
        }
        assert_eq!(values[(Axle::Rear, Coefficient::EffectiveRollingRadius)], 18.0);
        let difference = values.minus(&values);
        assert_eq!(difference[(Part::Vehicle, Coefficient::Drag)], 0.0);
    }
}
