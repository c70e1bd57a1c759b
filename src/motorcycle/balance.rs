//! The balance of forces on a motorcycle, and what is usual of every one.
//!
//! Checks, segments, estimates, fits, diagnosis and exports of rides on the road use these formulas. The reduced
//! simulator solves the same balance for loads that depend on the tyres' forces (its tests compare), and the multibody
//! simulator does without them: it is the independent judge. Off the road, loads come from inverse dynamics.
//!
//! The in-gear fit takes the loads of the acceleration alone, without drag (its own header says so). What the contacts do
//! is in [`kinematics`](crate::tyre::kinematics).
//!
//! Signs: forces along the road positive forward, loads positive, a pitching moment positive where it loads the
//! rear wheel. Pairs are front and rear.
//!
//! Source: Bartolozzi et al. (2024), equations 25a and 25b.

use crate::GRAVITY;
use crate::contract::bike::Bike;

/// Slip stiffness per load of a road tyre, within a third: of the supersport tyres of the paper's reference 26.
pub(crate) const USUAL_SLIP_STIFFNESS: f64 = 19.0;
/// Usual torque of the brakes per line pressure, front and rear, N m/Pa.
pub(crate) const USUAL_BRAKE_GAIN: [f64; 2] = [2.4e-4, 1.6e-4];
/// Friction of the best road tyre on the best road.
pub(crate) const LARGEST_FRICTION: f64 = 1.3;

/// Lengths that the loads follow from, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lengths {
    cg_to_front: f64,
    /// One over the wheelbase.
    per_wheelbase: f64,
}

impl Lengths {
    /// From the centre of mass to the front contact, and between the contacts.
    #[inline]
    pub(crate) fn new(cg_to_front: f64, wheelbase: f64) -> Self {
        Lengths { cg_to_front, per_wheelbase: 1.0 / wheelbase }
    }

    /// Those of a bike file.
    #[inline]
    pub(crate) fn of(bike: &Bike) -> Self {
        Self::new(bike.cg_to_front, bike.wheelbase)
    }

    /// Loads (N) under a weight (N), eq. 25a: `ahead` is how far the centre of mass has moved forward over the points
    /// where the loads act (m), `pitching` the moment that moves load to the rear wheel (N m).
    #[inline(always)]
    pub(crate) fn loads(self, weight: f64, ahead: f64, pitching: f64) -> [f64; 2] {
        let rear = (weight * (self.cg_to_front - ahead) + pitching) * self.per_wheelbase;
        [weight - rear, rear]
    }
}

/// Moment (N m) that moves load to the rear wheel, eq. 25b: of the forces along the road (N) below the height of the
/// centre of mass (m), and of what turns ever faster: wheels and frame (N m). The lean's cosine tells how much of both
/// is upright.
#[inline(always)]
pub(crate) fn pitching(along: f64, height: f64, turning: f64, cos_lean: f64) -> f64 {
    (along * height + turning) * cos_lean
}

/// Front load as a share of the weight without forces along the road, and what it loses per force forward (as a share
/// of the weight).
pub(crate) fn front_load_line(bike: &Bike) -> (f64, f64) {
    let lengths = Lengths::of(bike);
    let [at_rest, _] = lengths.loads(1.0, 0.0, 0.0);
    let [driven, _] = lengths.loads(1.0, 0.0, pitching(1.0, bike.cg_height, 0.0, 1.0));
    (at_rest, at_rest - driven)
}

/// Largest deceleration by the rear wheel alone, brake and engine together, m/s²: its load falls as it brakes. Upright;
/// leaning it is less.
pub(crate) fn rear_braking_limit(bike: &Bike, friction: f64) -> f64 {
    let (at_rest, loss) = front_load_line(bike);
    friction * GRAVITY * (1.0 - at_rest) / (1.0 + friction * loss)
}

/// Force of the tyres per mass, m/s², forward positive: the acceleration and what resists it.
pub(crate) fn tyre_force_per_mass(bike: &Bike, speed: f64, acceleration: f64) -> f64 {
    acceleration + bike.drag * speed * speed / bike.mass + GRAVITY * bike.rolling_resistance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_as_by_hand() {
        // 2000 N, centre of mass 0.7 m behind the front contact and 0.6 m high, 1.4 m wheelbase
        let lengths = Lengths::new(0.7, 1.4);
        let near =
            |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9;
        assert!(near(lengths.loads(2000.0, 0.0, 0.0), [1000.0, 1000.0]));
        // braking with half the weight moves 1000 N * 0.6 m / 1.4 m to the front
        let [front, rear] = lengths.loads(2000.0, 0.0, pitching(-1000.0, 0.6, 0.0, 1.0));
        assert!((front - 1428.571).abs() < 1e-3 && (rear - 571.429).abs() < 1e-3);
        // 7 cm ahead is a twentieth of the weight more in front
        assert!(near(lengths.loads(2000.0, 0.07, 0.0), [1100.0, 900.0]));
    }

    #[test]
    fn the_rear_brake_lifts_itself_off() {
        let text = "mass = 200.0\nwheelbase = 1.4\ncg_to_front = 0.7\ncg_height = 0.6\n\
                    caster_angle = 0.42\nfront.radius = 0.3\nfront.width = 0.12\nrear.radius = 0.3\n\
                    rear.width = 0.18\n";
        let bike = Bike::parse(text, "b", std::path::Path::new("b.toml")).expect("a bike");
        let limit = rear_braking_limit(&bike, 1.0);
        // the force is the load: rear share = (0.7 - 0.6 d) / 1.4 = d
        assert!((limit / GRAVITY - 0.35).abs() < 1e-12, "{limit}");
        let (at_rest, loss) = front_load_line(&bike);
        let [front, _] =
            Lengths::of(&bike).loads(1.0, 0.0, pitching(-limit / GRAVITY, 0.6, 0.0, 1.0));
        assert!((at_rest + loss * limit / GRAVITY - front).abs() < 1e-12);
    }
}
