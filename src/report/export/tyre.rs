//! The characterised tyre: the fitted coefficients put into the model, with what the bike file adds.

use super::adjusted::Adjusted;
use super::effects::{self, Named};
use super::fitted::Fitted;
use super::ranges::Ranges;
use crate::contract::bike::{Axle, Bike, WheelData};
use crate::contract::coefficient::{Coefficient as C, Part};
use crate::report::export::error::Error;
use crate::simulate::effects::ModelError;
use crate::simulate::effects::extended_tyre::ExtendedTyre;
use crate::statistics::number_format::short;
use crate::tyre::custom::Custom;
use crate::tyre::paper::{Input, Output, Tyre};
use crate::tyre::tyre_model::TyreModel;

/// One tyre of one session, ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Characterised {
    pub axle: Axle,
    /// The tyre without what its formulas leave out, its nominal load that at rest; what the ride did not give is a
    /// stand-in, see the flags.
    pub tyre: Custom,
    /// Effects that its formulas leave out.
    pub error: ModelError,
    /// Its width over the front tyre's.
    pub crown: f64,
    /// Identified causes of the session, this tyre's and others.
    pub named: Vec<Named>,
    /// Friction of the braked samples over that under the load at rest: that of the friction over load.
    pub braked_friction: f64,
    /// Nominal load of a file, N.
    nominal: f64,
    whole: Box<dyn TyreModel>,
    /// The same without a friction circle.
    free: Box<dyn TyreModel>,
    /// Whether the ride gave the longitudinal friction.
    pub longitudinal: bool,
    /// Whether the ride gave the lateral stiffnesses.
    pub lateral: bool,
    /// Whether there was a bike file.
    pub with_bike: bool,
    /// Where the relaxation length of the slip ratio is from, and the share of the deflection by which it rolls shorter.
    pub lag_from: &'static str,
    /// See [`Characterised::lag_from`].
    pub share_from: &'static str,
    /// Where the vertical stiffness is from, and the rolling resistance if no ride gives it.
    pub vertical_from: &'static str,
    /// See [`Characterised::vertical_from`].
    pub rolling_from: &'static str,
    /// Adjustment of the slip over camber; nothing where the lateral stiffnesses were not ridden.
    pub adjusted: Option<Adjusted>,
    pub ranges: Ranges,
    /// Loads that were ridden, N.
    pub loads: [f64; 2],
    /// Loads under which the longitudinal friction was ridden, N; `None` without a bike file.
    pub braked_loads: Option<[f64; 2]>,
}

/// Settings of an export.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// The bike file, for dimensions and static load.
    pub bike: Option<&'a Bike>,
    /// Nominal load of a file, N, instead of the bike's static load.
    pub load: Option<f64>,
    /// Road friction of the ride.
    pub friction: f64,
    /// Identified causes of the session.
    pub named: &'a [Named],
}

impl Default for Setting<'_> {
    fn default() -> Self {
        Setting { bike: None, load: None, friction: 1.0, named: &[] }
    }
}

/// Load where neither a bike file nor the user says one, N.
pub(crate) const LOAD: f64 = 1500.0;

impl Setting<'_> {
    /// Nominal load, N: what was asked for, else the static one, else [`LOAD`].
    pub fn nominal(&self, axle: Axle) -> f64 {
        match (self.load, self.bike) {
            (Some(load), _) => load,
            (None, Some(bike)) => bike.static_load(axle),
            (None, None) => LOAD,
        }
    }

    /// Where a number is from that the ride does not give: that of a key of the bike file.
    pub(crate) fn origin(&self, key: &str) -> &'static str {
        match self.bike.map(|bike| bike.priors_of_missing().contains_key(key)) {
            None => "placeholder: give the bike file with --bikes",
            Some(true) => "assumed: usual value",
            Some(false) => "assumed: bike file",
        }
    }

    /// The same of a key of a wheel.
    pub(crate) fn origin_at(&self, axle: Axle, key: &str) -> &'static str {
        self.origin(&format!("{}.{key}", axle.name()))
    }

    /// Load at rest, N, at which the coefficients hold: the bike's; without a bike file the nominal one.
    pub fn at_rest(&self, axle: Axle) -> f64 {
        self.bike.map_or(self.nominal(axle), |bike| bike.static_load(axle))
    }
}

/// Coefficients of the longitudinal friction.
const LONGITUDINAL: [C; 4] = [C::MfB, C::MfC, C::MfD, C::MfE1];
/// Coefficients of the lateral stiffnesses.
const LATERAL: [C; 5] = [
    C::LateralFrictionCt,
    C::SlipCamberC1,
    C::SlipCamberC3,
    C::CorneringStiffness0,
    C::SideForceRatio,
];

impl Characterised {
    /// The tyre of a session. Without a bike file, and where half of the tyre was not ridden,
    /// stand-ins take the place of what is missing.
    ///
    /// # Errors
    /// A sentence that names what the ride did not give, where neither half was ridden or the
    /// rolling radius is missing.
    pub fn new(fitted: &Fitted, axle: Axle, setting: &Setting<'_>) -> Result<Self, Error> {
        let part = Part::from(axle);
        let value = |part: Part, c: C| fitted.row(part, c).and_then(|c| c.value);
        let (radius, _) = fitted.value(part, C::EffectiveRollingRadius)?;
        let missing = |half: &[C]| half.iter().copied().find(|c| value(part, *c).is_none());
        let (no_x, no_y) = (missing(&LONGITUDINAL), missing(&LATERAL));
        if let (Some(x), Some(_)) = (no_x, no_y) {
            fitted.value(part, x)?;
        }
        let plain = stand_in_wheel(radius);
        let wheel = setting.bike.map_or(&plain, |bike| bike.wheel(axle));
        let rolling = value(Part::Vehicle, C::RollingResistance)
            .unwrap_or_else(|| setting.bike.map_or(0.015, |bike| bike.rolling_resistance));
        let get = |c: C| value(part, c).or_else(|| stand_in(c, radius, wheel));
        let load = setting.nominal(axle);
        let rest = setting.at_rest(axle);
        let mut tyre = Custom::characterised(get, wheel, rest, rolling, setting.friction).map_err(
            |source| Error::Tyre { session: fitted.session.ident.session_id.clone(), source },
        )?;
        let ranges = fitted.ridden(axle).clone();
        let upright = value(part, C::CorneringStiffness0).filter(|_| no_y.is_none());
        let adjusted = upright.map(|upright| {
            let leant = ranges.stiffness_over_camber.last().copied();
            Adjusted::adjust(&mut tyre.tyre, upright, leant, &ranges)
        });
        let error = effects::added(setting.named, axle);
        // of another side-force ratio the slips over camber stay those that were measured
        let measured = tyre.tyre.stiffness;
        error.put_into(&mut tyre.tyre, axle);
        tyre.tyre.stiffness = measured;
        let braked_friction = setting.bike.map_or(1.0, |bike| {
            let extra = |friction: f64| Ranges::braked_extra_load(bike, axle, friction);
            ranges.mean_by_square(|friction| error.relative_friction(1.0, extra(friction)))
        });
        tyre.tyre.friction.d /= braked_friction;
        if no_y.is_none() {
            tyre.tyre.lateral_peak = ridden_side(&tyre.tyre, &ranges);
        }
        let mut free = tyre;
        free.tyre.lateral_peak = f64::INFINITY;
        let braked_loads = setting.bike.map(|bike| ranges.braked_loads(bike, axle));
        let crown = setting.bike.map_or(1.0, |bike| bike.wheel(axle).width / bike.front.width);
        let loads = match setting.bike {
            Some(bike) => ranges.load(bike, axle),
            None => [0.5 * load, 2.0 * load],
        };
        Ok(Characterised {
            axle,
            tyre,
            error,
            crown,
            named: setting.named.to_vec(),
            braked_friction,
            nominal: load,
            whole: ExtendedTyre::boxed(tyre, &error, crown),
            free: ExtendedTyre::boxed(free, &error, crown),
            longitudinal: no_x.is_none(),
            lateral: no_y.is_none(),
            with_bike: setting.bike.is_some(),
            lag_from: setting.origin_at(axle, "longitudinal_relaxation"),
            share_from: setting.origin_at(axle, "deflection_share"),
            vertical_from: setting.origin_at(axle, "vertical_stiffness"),
            rolling_from: setting.origin("aerodynamics.rolling_resistance"),
            adjusted,
            ranges,
            // a load that lifts the wheel off divides by nothing in anybody's file
            loads: [loads[0].max(0.05 * load), loads[1].max(load)],
            braked_loads,
        })
    }

    /// Why the tyre is not whole, where a half of it was not ridden.
    pub fn missing_half(&self) -> Option<String> {
        let half = match (self.longitudinal, self.lateral) {
            (true, true) => return None,
            (false, _) => "longitudinal friction (brake to the limit)",
            (_, false) => "lateral stiffnesses (steady corners)",
        };
        Some(format!(
            "the ride did not give the {} tyre's {half}: --format tir, csv and toml write what there is",
            self.axle.name()
        ))
    }

    /// Nominal load of a file, N; the coefficients hold at that of [`Characterised::tyre`].
    pub fn load(&self) -> f64 {
        self.nominal
    }

    /// The note of a number that an effect changes.
    pub fn noted(&self, note: &str, effect: &str) -> String {
        effects::noted(note, &self.named, self.axle, effect)
    }

    /// Lines of a file about the effects; `left_out` are those that its form has no place for.
    pub fn effects(&self, left_out: &[&str]) -> Vec<String> {
        effects::lines(&self.named, &[self.axle], left_out)
    }

    /// Lines of a file about the slip over camber; nothing where it is not adjusted.
    pub(crate) fn adjustment(&self) -> Vec<String> {
        self.adjusted.map_or(Vec::new(), |adjusted| adjusted.lines(self.axle.name()))
    }

    /// Lines of a file about the share of the deflection by which the tyre rolls shorter.
    pub(crate) fn share_line(&self) -> String {
        let (axle, share) = (self.axle.name(), short(self.tyre.deflection_share));
        format!("{axle}: deflection_share {share} ({})", self.share_from)
    }

    /// Whether friction depends on load, and the note of it.
    pub fn friction_note(&self, note: &str) -> String {
        if self.error.friction_load == 0.0 {
            return note.to_owned();
        }
        let note = format!("{note}, under the braked loads {:.4} of it", self.braked_friction);
        self.noted(&note, "friction_load")
    }

    /// The whole tyre, as a simulator has it.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub fn whole(&self) -> &dyn TyreModel {
        self.whole.as_ref()
    }

    /// Forces and moments of the whole tyre.
    pub fn forces(&self, input: &Input) -> Output {
        self.whole.forces(input)
    }

    /// The same without the friction circle: what a property file is shaped to, which has a peak of its own.
    pub fn free_forces(&self, input: &Input) -> Output {
        self.free.forces(input)
    }

    /// Wanted response of a property file: the tyre's, and of the side force alone the one without the friction circle.
    pub fn wanted(&self, input: &Input) -> Output {
        if input.slip_ratio == 0.0 { self.free_forces(input) } else { self.forces(input) }
    }

    /// An input at the friction of the ride.
    pub fn input(&self, slip_ratio: f64, slip_angle: f64, camber: f64, load: f64) -> Input {
        let friction = self.tyre.tyre.reference_friction;
        Input { slip_ratio, slip_angle, camber, load, friction }
    }

    /// The side force over the load that was ridden, or that the ranges' camber gives.
    pub fn ridden_side(&self) -> f64 {
        ridden_side(&self.tyre.tyre, &self.ranges)
    }
}

/// The same of a tyre that is in the making.
fn ridden_side(tyre: &Tyre, ranges: &Ranges) -> f64 {
    let camber = Ranges::both_ways(ranges.camber).unwrap_or(0.5);
    (tyre.stiffness.ct * camber.tan()).abs()
}

/// Lines of a file of some tyres about the effects; `left_out` are those that its form has no place for.
pub(crate) fn effects_of(tyres: &[Characterised], left_out: &[&str]) -> Vec<String> {
    let axles: Vec<Axle> = tyres.iter().map(|c| c.axle).collect();
    tyres.first().map_or(Vec::new(), |c| effects::lines(&c.named, &axles, left_out))
}

/// The usual value of a coefficient that a ride does not give.
fn stand_in(coefficient: C, radius: f64, wheel: &WheelData) -> Option<f64> {
    Some(match coefficient {
        C::MfB => 12.0,
        C::MfC => 1.6,
        C::MfD => 1.0,
        C::MfE1 => 0.1,
        C::LateralFrictionCt => -1.0,
        C::SlipCamberC1 | C::SlipCamberC3 => 0.0,
        C::SideForceRatio => wheel.side_force_ratio,
        C::TwistingStiffness => wheel.twisting_stiffness,
        C::OverturningStiffness => 0.5 * wheel.width,
        C::RelaxationLength => wheel.relaxation_length.unwrap_or(radius),
        _ => return None,
    })
}

fn stand_in_wheel(radius: f64) -> WheelData {
    WheelData {
        radius,
        width: 0.15,
        model: None,
        wheel_inertia: None,
        side_force_ratio: 0.09,
        twisting_stiffness: 0.0,
        vertical_stiffness: 150e3,
        deflection_share: None,
        longitudinal_relaxation: None,
        slip_stiffness_load: None,
        relaxation_length: None,
        camber_force_decay: 1.0,
        camber_moment_decay: 1.0,
    }
}
