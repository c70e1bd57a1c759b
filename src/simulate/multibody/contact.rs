//! Where and how a wheel touches the road.
//!
//! The carcass is a torus: crown radius `rho` round a circle of radius `R - rho`. Its lowest
//! point carries the load, over a unilateral vertical spring and damper.
//!
//! ```text
//! crown centre C = wheel centre + (R - rho) d,  d = unit vector in the wheel plane, downwards
//! deflection     = rho - height of C            contact = C's foot on the road
//! rolling radius = (R - rho) + rho cos(gamma) - share * deflection
//! s = (R_e omega - v_x)/|v_x|     alpha = atan(v_y/|v_x|)     (velocity of the unspun contact)
//! ```
//!
//! On an uneven road (`Road::waves`) the surface's height below C is added to the deflection, and the load acts along
//! the surface's normal. The waves are long against the contact.

use nalgebra::Vector3;

use super::link;
use super::road::Road;
use super::state::Wheel;
use crate::simulate::effects::ModelError;
use crate::simulate::multibody::bodies::tree::Link;
use crate::tyre::paper::Input;
use crate::tyre::tyre_model::{Carcass, Reference, TyreModel};

/// Slips are formed with at least this speed, m/s: no division by a standstill.
const SLIP_SPEED: f64 = 0.5;
/// No lag is shorter than this, s: the tyre's lag vanishes with its load, the integrator's step
/// does not.
const SHORTEST_LAG: f64 = 1e-3;

/// The wheel's geometry on a level road, before any force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Geometry {
    /// Wheel plane's trace on the road, unit vector.
    pub along: Vector3<f64>,
    /// Horizontal, to the left of it.
    pub across: Vector3<f64>,
    /// In the wheel plane, downwards.
    pub down: Vector3<f64>,
    /// Cosine and sine of the camber.
    pub camber: (f64, f64),
}

/// Road, time and direction of a wheel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub road: &'a Road,
    /// Effects beyond the description of the motorcycle.
    pub error: &'a ModelError,
    /// Share of the road's friction that is lost.
    pub lost_grip: f64,
    /// Since the ride began, s.
    pub time: f64,
    /// Cosine of the heading; zero where no effect depends on it.
    pub along: f64,
}

impl Geometry {
    /// From the wheel's axle direction (to the left).
    pub(crate) fn new(axle: &Vector3<f64>) -> Self {
        let cos = (axle.x * axle.x + axle.y * axle.y).sqrt();
        let along = Vector3::new(axle.y / cos, -axle.x / cos, 0.0);
        let across = Vector3::new(-along.y, along.x, 0.0);
        // -(z - (z.y) y), normalised
        let down = Vector3::new(axle.z * axle.x, axle.z * axle.y, axle.z * axle.z - 1.0) / cos;
        Geometry { along, across, down, camber: (cos, axle.z) }
    }

    /// With the trace turned by an angle, rad, positive to the left.
    fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let along = self.along * cos + self.across * sin;
        Geometry { along, across: Vector3::new(-along.y, along.x, 0.0), ..*self }
    }
}

/// How a carcass stands on the road.
struct Pressed {
    contact: Vector3<f64>,
    /// Negative in the air.
    deflection: f64,
    load: f64,
    /// Of the spring alone, N, not negative.
    pressing: f64,
    /// Of the surface; its z is one.
    normal: Vector3<f64>,
    /// From the wheel plane to the carcass's lowest point, to the left.
    offset: f64,
}

impl Pressed {
    fn new(
        carcass: &Carcass,
        carrier: &Link,
        centre: &Vector3<f64>,
        geometry: &Geometry,
        road: &Road,
    ) -> Self {
        let (cos, sin) = geometry.camber;
        let crown = centre + geometry.down * (carcass.radius - carcass.crown);
        let [height, by_x, by_y] = road.surface(crown.x, crown.y);
        let deflection = carcass.crown - crown.z + height;
        let velocity = carrier.velocity_at(&crown);
        let sinking = by_x * velocity.x + by_y * velocity.y - velocity.z;
        let load = if deflection > 0.0 {
            (carcass.stiffness * deflection + carcass.damping * sinking).max(0.0)
        } else {
            0.0
        };
        let pressed = deflection.max(0.0);
        Pressed {
            contact: Vector3::new(crown.x, crown.y, 0.0),
            deflection,
            load,
            pressing: carcass.stiffness * pressed,
            normal: Vector3::new(-by_x, -by_y, 1.0),
            offset: (pressed - carcass.crown) * sin / cos,
        }
    }
}

/// Forces of the road on wheel `i` (0 front), put onto the links, and the rates of its lags.
pub(crate) fn roll(
    tyre: &dyn TyreModel,
    links: &mut [Link],
    i: usize,
    spin: f64,
    lag: &[f64; 3],
    around: &Surroundings<'_>,
) -> (Wheel, [f64; 3]) {
    let Surroundings { road, error, lost_grip, time, along } = *around;
    let carrier = &links[link::CARRIERS[i]];
    let centre = links[link::WHEELS[i]].position;
    let mut geometry = Geometry::new(&carrier.rotation.column(1).into_owned());
    let camber = geometry.camber.1.atan2(geometry.camber.0);
    let Pressed { contact, deflection, load, pressing, normal, offset } =
        Pressed::new(&tyre.carcass(), carrier, &centre, &geometry, road);

    let v = carrier.velocity_at(&contact);
    let least = |vx: f64| vx.abs().max(SLIP_SPEED);
    let relaxation = tyre.relaxation(load, least(v.dot(&geometry.along)));
    let input = Input {
        slip_ratio: lag[0],
        slip_angle: lag[1],
        camber: if relaxation.camber.is_some() { lag[2] } else { camber },
        load,
        friction: road.friction_at(contact.x) * (1.0 - lost_grip) * error.grip(1.0, time, along),
    };
    let out = tyre.forces(&input);
    let compliance = error.compliance(0.0);
    if i == 0 && compliance != 0.0 {
        geometry = geometry.turned(-compliance * out.force_y);
    }
    let (vx, vy) = (v.dot(&geometry.along), v.dot(&geometry.across));
    let speed = least(vx);
    let rolling_radius = tyre.rolling_radius(pressing, 1.0 - geometry.camber.0, vx);
    let kinematic = [(rolling_radius * spin - vx) / speed, vy.atan2(speed)];
    let rate = |length: f64| (speed / length.max(1e-6)).min(1.0 / SHORTEST_LAG);
    let rates = [
        rate(relaxation.longitudinal) * (kinematic[0] - lag[0]),
        rate(relaxation.lateral) * (kinematic[1] - lag[1]),
        relaxation.camber.map_or(0.0, |length| rate(length) * (camber - lag[2])),
    ];

    let (at, moment_x, moment_z) = match tyre.reference() {
        Reference::Carcass => {
            let (mx, mz) = (out.moment_x + offset * load, out.moment_z - offset * out.force_x);
            (contact, mx, mz)
        }
        Reference::WheelPlane => (contact - geometry.across * offset, out.moment_x, out.moment_z),
    };
    let force = geometry.along * out.force_x + geometry.across * out.force_y + normal * load;
    let moment = geometry.along * out.moment_x + Vector3::new(0.0, 0.0, out.moment_z);
    // slow wheels are held back in proportion: no chatter at rest
    let resist = tyre.rolling_resistance(&input, vx) * (spin / 0.5).clamp(-1.0, 1.0);
    let wheel = &mut links[link::WHEELS[i]];
    wheel.push(&force, &at);
    wheel.twist(&(moment - geometry.across * resist));
    let found = Wheel {
        contact: [contact.x, contact.y],
        heading: geometry.along.y.atan2(geometry.along.x),
        camber,
        deflection,
        load,
        rolling_radius,
        velocity: [vx, vy],
        kinematic,
        slip: [lag[0], lag[1]],
        force: [out.force_x, out.force_y],
        moment_x,
        moment_z,
    };
    (found, rates)
}
