//! Tyres of the population: the paper's, and published Magic Formula tyres of another form, varied.

use std::path::Path;

use super::draw::within;
use crate::simulate::error::Error;
use crate::simulate::motorcycle::Plant;
use crate::simulate::tyre_truth;
use crate::statistics::random::Random;
use crate::tyre::custom::Custom;
use crate::tyre::paper::Tyre;
use crate::tyre::tyre_model::{TyreModel, USUAL_SHARE};
use crate::tyre::{published, tir};

/// Whose formulas the tyres are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Make {
    Paper,
    /// A Magic Formula of another form.
    Published,
}

impl Make {
    /// Half of each.
    pub fn draw(random: &mut Random) -> Self {
        if random.between(0.0, 1.0) < 0.5 { Make::Paper } else { Make::Published }
    }
}

/// Sets of a front and a rear tyre.
const SETS: [[&str; 2]; 3] = [
    ["sharp2004_front_120_70", "sharp2004_rear_180_55"],
    ["sharp2004_front_120_70", "sharp2004_rear_160_70"],
    ["mf62_front_120_70", "mf62_rear_190_55"],
];

/// Shape and springs of a pair of tyres, front and rear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Carcasses {
    /// Width, m.
    pub width: [f64; 2],
    /// Crown radius, m.
    pub crown: [f64; 2],
    /// Share of the deflection by which they roll shorter.
    pub share: [f64; 2],
}

impl Carcasses {
    fn draw(random: &mut Random) -> Self {
        // a tread across the whole width is a half circle: 0.35 to 0.65 of the width
        let ratio = within(random, 0.5, 0.07, 2.0);
        // fits of published tyres: 0.25 to 0.38 (Pacejka 2012: about a third)
        let share = within(random, USUAL_SHARE, 0.07, 2.0);
        let width = [
            0.11 + 0.01 * random.between(0.0, 2.0).floor(),
            0.15 + 0.01 * random.between(0.0, 5.0).floor(),
        ];
        let ratio = [0; 2].map(|_| (ratio + 0.03 * random.normal()).clamp(0.35, 0.65));
        Carcasses {
            width,
            crown: [ratio[0] * width[0], ratio[1] * width[1]],
            share: [0; 2].map(|_| (share + 0.03 * random.normal()).clamp(0.15, 0.55)),
        }
    }
}

/// The formulas of a pair of tyres.
#[derive(Debug, Clone)]
pub(crate) enum Pair {
    /// The tyre of the paper, in the simulated motorcycle itself.
    Paper,
    /// On their own, varied from the sets of these names.
    Published([&'static str; 2], [Box<dyn TyreModel>; 2]),
}

impl Pair {
    /// Of the front one's set.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Pair::Paper => "the paper",
            Pair::Published([front, _], _) => front,
        }
    }

    /// One of them: `tyre` is the plant's, under a static load (N).
    pub(crate) fn tyre(
        &self,
        k: usize,
        tyre: &Tyre,
        load: f64,
        carcasses: &Carcasses,
    ) -> Box<dyn TyreModel> {
        match self {
            Pair::Published(_, pair) => pair[k].clone(),
            Pair::Paper => Box::new(Custom {
                deflection_share: carcasses.share[k],
                ..Custom::new(*tyre, load)
            }),
        }
    }
}

/// Draws tyres under static loads (N) and puts them, or the paper's tyres that are most like them, into
/// the plant.
///
/// # Errors
/// A published set does not load (a defect that a test would find).
pub(crate) fn draw(
    make: Make,
    plant: &mut Plant,
    load: [f64; 2],
    random: &mut Random,
) -> Result<(Pair, Carcasses), Error> {
    let carcasses = Carcasses::draw(random);
    // 100 to 250 kN/m (Sharp et al. 2004: 130 and 141; MF 6.2 sets: 176 and 201)
    let softer = random.between(100e3_f64.ln(), 210e3_f64.ln()).exp();
    let vertical = [softer, softer * random.between(1.0, 1.18)];
    // 110/70 to 120/70 and 150/60 to 190/55 on 17 inch rims
    let radius = [random.between(0.285, 0.300), random.between(0.300, 0.325)];
    let rolling = random.between(0.010, 0.022);
    plant.vehicle.deflection_share = carcasses.share[0];
    plant.crown = carcasses.crown;
    for (k, tyre) in plant.tyres.iter_mut().enumerate() {
        // 0.04 to 0.13 in published motorcycle tyres
        let ratio = random.between(0.045_f64.ln(), 0.125_f64.ln()).exp();
        let change = ratio / tyre.side_force_ratio;
        tyre.side_force_ratio = ratio;
        // k_alpha stays what it is
        tyre.stiffness.ct *= change;
        tyre.stiffness.c3 *= change;
        tyre.twisting_stiffness *= random.between(0.6, 1.4);
        tyre.rolling_radius = radius[k];
        tyre.rolling_resistance = rolling;
        // a third to 1.3 radii
        tyre.relaxation_length = radius[k] * random.between(0.35, 1.3);
        tyre.vertical_stiffness = vertical[k];
        tyre.overturning_stiffness = carcasses.crown[k] - load[k] / vertical[k];
    }
    if make == Make::Paper {
        return Ok((Pair::Paper, carcasses));
    }
    let set = SETS[(random.between(0.0, SETS.len() as f64) as usize).min(SETS.len() - 1)];
    let peak = random.between(0.95, 1.15);
    let mut tyre = |k: usize| vary(set[k], &plant.tyres[k], load[k], &carcasses, k, peak, random);
    let pair = [tyre(0)?, tyre(1)?];
    for k in 0..2 {
        plant.tyres[k] = tyre_truth::like(pair[k].as_ref(), load[k]);
    }
    Ok((Pair::Published(set, pair), carcasses))
}

/// A published set with its coefficients varied, of the size and springs of a tyre and with a braking
/// friction of about `peak`.
fn vary(
    name: &str,
    size: &Tyre,
    load: f64,
    carcasses: &Carcasses,
    k: usize,
    peak: f64,
    random: &mut Random,
) -> Result<Box<dyn TyreModel>, Error> {
    let path = Path::new(name);
    let text = published::text(name).ok_or_else(|| Error::Ride(format!("no tyre `{name}`")))?;
    let keys = tir::keys(text, path).map_err(|e| Error::Ride(e.to_string()))?;
    let deflection = load / size.vertical_stiffness;
    let radius = size.rolling_radius + carcasses.share[k] * deflection;
    let grip = peak * random.between(0.97, 1.03) / keys.or("PDX1", 1.0);
    let crown = carcasses.crown[k];
    let mut changed: Vec<(&str, f64)> = vec![
        ("UNLOADED_RADIUS", radius),
        ("CROWN_RADIUS", crown),
        ("EFFECTIVE_RADIUS_SHARE", carcasses.share[k]),
        ("VERTICAL_STIFFNESS", size.vertical_stiffness),
        // a tyre is made for about the load that it carries
        ("FNOMIN", load * random.between(0.9, 1.4)),
        ("PDX2", random.between(-0.15, 0.0)),
        ("PEX1", keys.or("PEX1", 0.0) + random.between(-0.4, 0.2)),
        ("QSY1", size.rolling_resistance),
    ];
    // relative changes: friction, slip, cornering and camber stiffness, the load of the largest one, lags
    for (key, factor) in [
        ("PDX1", grip),
        ("PDY1", grip),
        ("PKX1", random.between(0.75, 1.2)),
        ("PKY1", random.between(0.85, 1.2)),
        ("PKY2", random.between(0.9, 1.15)),
        ("PKY6", random.between(0.75, 1.5)),
        ("QDZ1", random.between(0.7, 1.3)),
        ("QDZ8", random.between(0.7, 1.3)),
        ("LAG_C0", random.between(0.6, 1.4)),
        ("LATERAL_STIFFNESS", random.between(0.7, 1.6)),
    ] {
        if let Ok(x) = keys.number(key) {
            changed.push((key, x * factor));
        }
    }
    if keys.number("FITTYP") == Ok(62.0) {
        // it pulls to no side, and its overturning moment is that of its crown
        let loaded = (crown - deflection) / radius;
        changed.extend(["LHX", "LVX", "LHY", "LVY", "LVMX", "LRES"].map(|key| (key, 0.0)));
        changed.extend([1, 3, 4, 5, 6, 7, 8, 9, 10, 11].map(|i| (OVERTURNING[i - 1], 0.0)));
        changed.extend([("QSX2", loaded), ("SSZ3", loaded)]);
        changed.extend(["SSZ1", "SSZ2", "SSZ4"].map(|key| (key, 0.0)));
    }
    let more: String = changed.iter().map(|(key, x)| format!("{key} = {x:?}\n")).collect();
    tir::parse(&format!("{text}\n[COEFFICIENTS]\n{more}"), path)
        .map_err(|e| Error::Ride(e.to_string()))
}

const OVERTURNING: [&str; 11] =
    ["QSX1", "QSX2", "QSX3", "QSX4", "QSX5", "QSX6", "QSX7", "QSX8", "QSX9", "QSX10", "QSX11"];
