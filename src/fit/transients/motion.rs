//! Slips, cambers, loads and forces of both axles while the lean changes, on the balance of the whole motorcycle.
//!
//! ```text
//! yaw    L_z' = x_f Fy_f cos D + x_r Fy_r - y_f Fx_f - y_r Fx_r + Mz      L_z = frame + I_r w_r sin phi + I_f w_f sin gamma_f
//! roll   L_x' - psi' L_y = sum(y_i Fz_i - z_i Fy_i)                      gusts move a_y, but not this
//! side   m a_y = Fy_f cos D + Fx_f sin D + Fy_r + gusts                   a_y of the centre of mass: a residual
//! load   Fz_f + Fz_r = m (g + z''),  z = height of the centre of mass over crowns and springs;  pitch with L_y' + psi' L_x
//! slip   w_i, u_i: the contact's velocity by the full omega x r to the place below the crown's centre, and by the fork's turn
//! ```
//!
//! Axes: x along the trace of the frame's plane on the road, y left, z up. Against Euler angles of roll, pitch and yaw
//! (in that order from the frame) the trace is turned by `chi = -tan(phi) sin(theta)`. Within the leaning plane: x, its
//! normal to the left, and up along the plane. Springs give way in a bend by `sag (1/cos phi - 1)`.
//!
//! Source: `design` of the method and its comparison with a simulator of another author: book, Estimation, section 11.

use super::columns::Columns;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::estimate::signals::Inputs;
use crate::tyre::dive::PITCH_GYRATION;
use crate::tyre::paper::trail_0;
use crate::tyre::tyre_model::load_lead;

/// Keys of the bike file: place of the accelerometer, m ahead of and above the centre of mass.
pub(crate) const UNIT_AHEAD: &str = "sensors.acceleration_x";
pub(crate) const UNIT_ABOVE: &str = "sensors.acceleration_z";

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident,)+) => {
        /// A number of motorcycle or sensors that the fit may move, by its place in [`Quantities`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Quantity { $($(#[$doc])* $name,)+ }

        impl Quantity {
            /// Every one.
            pub const ALL: &'static [Quantity] = &[$(Quantity::$name),+];
        }
    };
}

quantities! {
    /// Remaining zero of the roll, rad.
    RollZero,
    /// Pitch of the unit over what it says, rad: how it is mounted.
    UnitPitch,
    /// Mass, kg.
    Mass,
    /// Distance of the centre of mass from the front contact, m.
    CgToFront,
    /// Height of the centre of mass, m; sensors go with it.
    CgHeight,
    /// Distance between the contacts, m.
    Wheelbase,
    /// Caster angle, rad.
    CasterAngle,
    /// How far the accelerometer is above the centre of mass, m.
    UnitAbove,
    /// How far the accelerometer is behind the centre of mass, m.
    UnitBehind,
    /// How far the velocity's place is ahead of its stated one, m.
    VelocityAhead,
    /// How far the velocity's place is above its stated one, m.
    VelocityAbove,
    /// Radius of the front crown, m.
    FrontCrown,
    /// Radius of the rear crown, m.
    RearCrown,
    /// Handlebar angle over what the sensor says, less one.
    SteerGain,
    /// How far the handlebar turns ahead of the wheel per torque, rad/(N m).
    SteeringCompliance,
    /// Spin inertia of the front wheel, kg m².
    FrontSpin,
    /// Spin inertia of the rear wheel, kg m².
    RearSpin,
    /// Roll inertia, kg m².
    RollInertia,
    /// Yaw inertia, kg m².
    YawInertia,
    /// Product of inertia, kg m²: the sum of mass, place ahead and place above the centre of mass.
    ProductOfInertia,
    /// Twisting stiffness of the front tyre, m/rad.
    FrontTwist,
    /// Twisting stiffness of the rear tyre, m/rad.
    RearTwist,
    /// What the front's gains with the square of camber, 1/rad².
    FrontTwistGrowth,
    /// What the rear's gains.
    RearTwistGrowth,
    /// How far the springs give at rest, m.
    Sag,
    /// How far the front contact goes back per compression, over the tangent of the caster angle.
    Fork,
    /// How far the rear contact goes forward per compression.
    Swing,
    /// Remaining latency of the velocities, s.
    Latency,
    /// Delay of the lateral acceleration against the rates, s.
    LateralDelay,
    /// Delay of the handlebar angle against the rates, s.
    SteerDelay,
}

/// A value for every [`Quantity`].
#[derive(Debug, Clone)]
pub(crate) struct Quantities(Vec<f64>);

impl std::ops::Index<Quantity> for Quantities {
    type Output = f64;

    fn index(&self, quantity: Quantity) -> &f64 {
        &self.0[quantity as usize]
    }
}

impl std::ops::IndexMut<Quantity> for Quantities {
    fn index_mut(&mut self, quantity: Quantity) -> &mut f64 {
        &mut self.0[quantity as usize]
    }
}

/// Yaw inertia over mass where the bike file has none: radius of gyration over the wheelbase, and its share of
/// uncertainty. With both wheels at the ends: 0.30 of the independent simulator, 0.24 of frames with rider alone.
///
/// The bike file's default ([`Bike::yaw_inertia`]) is that of frames alone, 0.235, as in what is simulated. Here it is a start
/// with an uncertainty that has both ends within about one standard deviation; changing lean moves it.
pub(crate) const YAW_GYRATION: [f64; 2] = [0.27, 0.13];
/// Product of inertia over mass, m²: riders sit high behind, engine and front wheel are low in front.
pub(crate) const PRODUCT: [f64; 2] = [-0.005, 0.007];
/// Roll inertia over mass, m², and its share of uncertainty: 0.08 to 0.11 of simulated and published motorcycles with
/// rider. A start that changing lean moves, so not the 0.085 that the simulated `Vehicle` has.
pub(crate) const ROLL_GYRATION: [f64; 2] = [0.095, 0.2];
/// Crown radius over tyre width, front and rear, where the ride gave none.
const CROWN: [f64; 2] = [0.42, 0.45];
/// How far springs give at rest, m.
const SAG: f64 = 0.045;
/// See [`Quantity::Fork`] and [`Quantity::Swing`].
const COMPRESSION: [f64; 2] = [0.2, -0.2];

/// Forces of the tyres from the motion, and what that starts from.
///
/// Apart from the simulator's numbers: its inertias, crowns and springs are quantities that this fit moves, each with
/// its own uncertainty, and everything else is read from the estimate's inputs.
#[derive(Debug, Clone)]
pub(crate) struct InverseDynamics<'a> {
    inputs: &'a Inputs,
    /// Trail, m.
    trail: f64,
    /// Loads at rest, N.
    pub standing: [f64; 2],
    /// Pneumatic trails at rest, m.
    pub pneumatic_trail: [f64; 2],
    /// What the fit starts from.
    pub start: Quantities,
}

impl<'a> InverseDynamics<'a> {
    /// `crown` is the front crown's radius where the ride gave it, m.
    pub(crate) fn new(inputs: &'a Inputs, crown: Option<f64>) -> Self {
        let bike = &inputs.bike;
        let mut start = Quantities(vec![0.0; Quantity::ALL.len()]);
        let crowns = match crown {
            Some(front) => [front, front * bike.rear.width / bike.front.width],
            None => [CROWN[0] * bike.front.width, CROWN[1] * bike.rear.width],
        };
        let yaw = bike.value("yaw_inertia");
        let usual = bike.mass * (YAW_GYRATION[0] * bike.wheelbase).powi(2);
        for (quantity, value) in [
            (Quantity::Mass, bike.mass),
            (Quantity::CgToFront, bike.cg_to_front),
            (Quantity::CgHeight, bike.cg_height),
            (Quantity::Wheelbase, bike.wheelbase),
            (Quantity::CasterAngle, bike.caster_angle),
            (Quantity::FrontCrown, crowns[0]),
            (Quantity::RearCrown, crowns[1]),
            (Quantity::FrontSpin, bike.wheel_inertia(Axle::Front)),
            (Quantity::RearSpin, bike.wheel_inertia(Axle::Rear)),
            (Quantity::RollInertia, ROLL_GYRATION[0] * bike.mass),
            (Quantity::YawInertia, yaw.unwrap_or(usual)),
            (Quantity::ProductOfInertia, PRODUCT[0] * bike.mass),
            (Quantity::FrontTwist, bike.front.twisting_stiffness),
            (Quantity::RearTwist, bike.rear.twisting_stiffness),
            (Quantity::Sag, SAG),
            (Quantity::Fork, COMPRESSION[0]),
            (Quantity::Swing, COMPRESSION[1]),
            (Quantity::UnitAbove, bike.value(UNIT_ABOVE).unwrap_or(0.0)),
            (Quantity::UnitBehind, -bike.value(UNIT_AHEAD).unwrap_or(0.0)),
        ] {
            start[quantity] = value;
        }
        let standing = Axle::BOTH.map(|axle| bike.static_load(axle));
        let pneumatic_trail = Axle::BOTH.map(|axle| {
            let k = axle as usize;
            let stiffness = bike.wheel(axle).vertical_stiffness;
            inputs.trail_ratio * trail_0(inputs.radius[k], stiffness, standing[k])
        });
        InverseDynamics {
            inputs,
            trail: bike.normal_trail() / bike.caster_angle.cos(),
            standing,
            pneumatic_trail,
            start,
        }
    }
}

/// Signals of all samples; pairs are front and rear.
#[derive(Debug, Clone, Default)]
pub(crate) struct Motion {
    /// Side forces without the moment of the pneumatic trails, N.
    pub force: [Vec<f64>; 2],
    /// What a yaw moment of the tyres adds to them, 1/m.
    pub per_moment: [Vec<f64>; 2],
    /// Loads, N.
    pub load: [Vec<f64>; 2],
    /// Cambers, rad.
    pub camber: [Vec<f64>; 2],
    /// Where the front wheel points, rad; none of the rear one.
    pub steer: Vec<f64>,
    /// Lateral velocity of the contact over that of the centre of mass, m/s.
    pub aside: [Vec<f64>; 2],
    /// Forward velocity of the contact, m/s.
    pub along: [Vec<f64>; 2],
    /// Integral of the lateral acceleration, m/s.
    pub integral: Vec<f64>,
    /// Measured lateral velocity of the centre of mass, m/s.
    pub drift: Vec<f64>,
    /// Measured lateral acceleration of the centre of mass over that of the tyres' forces, m/s².
    pub pushed: Vec<f64>,
}

impl Motion {
    fn all(&self) -> [&Vec<f64>; 16] {
        let Motion {
            force,
            per_moment,
            load,
            camber,
            steer,
            aside,
            along,
            integral,
            drift,
            pushed,
        } = self;
        [
            &force[0],
            &force[1],
            &per_moment[0],
            &per_moment[1],
            &load[0],
            &load[1],
            &camber[0],
            &camber[1],
            steer,
            &aside[0],
            &aside[1],
            &along[0],
            &along[1],
            integral,
            drift,
            pushed,
        ]
    }

    fn all_mut(&mut self) -> [&mut Vec<f64>; 16] {
        let Motion {
            force,
            per_moment,
            load,
            camber,
            steer,
            aside,
            along,
            integral,
            drift,
            pushed,
        } = self;
        let [f0, f1] = force;
        let [m0, m1] = per_moment;
        let [l0, l1] = load;
        let [c0, c1] = camber;
        let [w0, w1] = aside;
        let [u0, u1] = along;
        [f0, f1, m0, m1, l0, l1, c0, c1, steer, w0, w1, u0, u1, integral, drift, pushed]
    }

    /// Adds `scale` times the other's.
    pub(crate) fn add(&mut self, other: &Motion, scale: f64) {
        for (own, other) in self.all_mut().into_iter().zip(other.all()) {
            own.iter_mut().zip(other).for_each(|(a, b)| *a += scale * b);
        }
    }

    /// Multiplies every signal.
    pub(crate) fn scale(&mut self, by: f64) {
        self.all_mut().into_iter().for_each(|x| x.iter_mut().for_each(|x| *x *= by));
    }
}

type V = [f64; 3];

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl InverseDynamics<'_> {
    /// The motion of all samples with some quantities.
    pub(crate) fn motion(&self, c: &Columns, q: &Quantities) -> Motion {
        let mut out = Motion::default();
        for i in 0..c.len() {
            let values = self.sample(c, i, q);
            for (column, value) in out.all_mut().into_iter().zip(values) {
                column.push(value);
            }
        }
        out
    }

    /// One sample, in the order of [`Motion::all`].
    fn sample(&self, c: &Columns, i: usize, q: &Quantities) -> [f64; 16] {
        use Quantity as Q;
        let (inputs, bike) = (self.inputs, &self.inputs.bike);
        let phi = c.roll[0][i] - q[Q::RollZero];
        let [rolling, rolling_rate] = [c.roll[1][i], c.roll[2][i]];
        let theta = c.pitch[0][i] + q[Q::UnitPitch];
        let (sin_theta, cos_theta) = theta.sin_cos();
        let tan_phi = phi.tan();
        let s = cos_theta * phi.sin(); // sine of the lean of the frame's plane
        let co = (1.0 - s * s).sqrt();
        // angular velocity, in axes along the trace
        let chi = -tan_phi * sin_theta;
        let level = [rolling * cos_theta, c.pitch[1][i], c.yaw[0][i] - rolling * sin_theta];
        let (sin_chi, cos_chi) = chi.sin_cos();
        let omega = [
            cos_chi * level[0] + sin_chi * level[1],
            -sin_chi * level[0] + cos_chi * level[1],
            level[2],
        ];
        // from the leaning plane to the axes along the trace
        let upright = |v: V| [v[0], co * v[1] - s * v[2], s * v[1] + co * v[2]];

        // handlebar, as far as the wheel follows it, and the steering axis
        let [angle, rate] = [c.steer[0][i], c.steer[1][i]];
        let spin = [0, 1].map(|k| {
            let omega = c.spin[k][i];
            if omega.is_finite() { omega } else { c.speed[i] / inputs.radius[k] }
        });
        let twist = q[Q::SteeringCompliance] * q[Q::FrontSpin] * spin[0] * rolling;
        let delta = angle * (1.0 + q[Q::SteerGain]) + q[Q::SteerDelay] * rate - twist;
        let turning = rate * (1.0 + q[Q::SteerGain]);
        let caster = q[Q::CasterAngle] - (c.pitch[0][i] - c.level) / phi.cos();
        let (sin_eps, cos_eps) = caster.sin_cos();
        let (sin_delta, cos_delta) = delta.sin_cos();
        let axis = [-sin_eps, 0.0, cos_eps];

        // contacts below the crowns' centres, from the centre of mass
        let crown = [q[Q::FrontCrown], q[Q::RearCrown]];
        let compression = q[Q::Sag] * (1.0 / co - 1.0);
        let height = q[Q::CgHeight] - compression;
        let sinking = q[Q::Sag] * s / (co * co) * rolling;
        let centre = [-self.trail, 0.0, crown[0]]; // of the front crown, from where the axis meets the road
        let along = axis[0] * centre[0] + axis[2] * centre[2];
        let turned = [
            centre[0] * cos_delta + axis[0] * along * (1.0 - cos_delta) + self.trail,
            (cos_eps * centre[0] + sin_eps * centre[2]) * sin_delta,
            centre[2] * cos_delta + axis[2] * along * (1.0 - cos_delta),
        ];
        let front = [turned[0], turned[1] - crown[0] * s, turned[2] - crown[0] * co];
        let rear = [-q[Q::Wheelbase], -crown[1] * s, crown[1] * (1.0 - co)];
        let back = -q[Q::Fork] * bike.caster_angle.tan() * compression;
        let from_centre =
            |v: V, shift: f64| upright([v[0] + q[Q::CgToFront] + shift, v[1], v[2] - height]);
        let place = [from_centre(front, back), from_centre(rear, q[Q::Swing] * compression)];
        let fork = upright(cross(axis, [front[0] - self.trail, front[1], front[2]]));
        let at = place.map(|r| cross(omega, r)[1] - s * sinking);
        let aside = [at[0] + turning * fork[1], at[1]];
        // the velocity's place
        let ahead = bike.velocity_sensor_x + q[Q::VelocityAhead];
        let above = bike.velocity_sensor_z + q[Q::VelocityAbove];
        let speed = c.speed[i] - above * (omega[1] * co + omega[2] * s);
        let forward = place.map(|r| speed - omega[2] * r[1]);
        let drift = c.drift[0][i] + q[Q::Latency] * c.drift[1][i] - ahead * omega[2]
            + above * co * omega[0];

        // how the front wheel stands
        let normal = [-cos_eps * sin_delta, cos_delta, -sin_eps * sin_delta];
        let points = upright(normal);
        let steer = (-points[0]).atan2(points[1]);
        let camber = [points[2].asin(), s.asin()];
        let camber_cos = camber[0].cos();

        // rates of what the momentum is made of
        let yawing = c.yaw[1][i] - rolling_rate * sin_theta - rolling * cos_theta * c.pitch[1][i];
        let pitching = c.pitch[2][i];
        let (s_rate, co_rate) = (co * rolling, -s * rolling);
        let across = omega[1] * co + omega[2] * s;
        let upward = -omega[1] * s + omega[2] * co;
        let across_rate = pitching * co + omega[1] * co_rate + yawing * s + omega[2] * s_rate;
        let upward_rate = -pitching * s - omega[1] * s_rate + yawing * co + omega[2] * co_rate;
        let camber_rate = (s_rate * normal[1] + co_rate * normal[2]
            - s * sin_delta * turning
            - co * sin_eps * cos_delta * turning)
            / camber_cos;
        let spin_rate = [0, 1].map(|k| {
            let rate = c.spin_rate[k][i];
            if rate.is_finite() { rate } else { c.acceleration[i] / inputs.radius[k] }
        });
        let mass = q[Q::Mass];
        let inertia = [q[Q::FrontSpin], q[Q::RearSpin]];
        let [product, about_y] = [q[Q::ProductOfInertia], PITCH_GYRATION[0] * mass];
        let yaw_moment = about_y * (across_rate * s + across * s_rate)
            + q[Q::YawInertia] * (upward_rate * co + upward * co_rate)
            - product * (rolling_rate * co + rolling * co_rate)
            + inertia[1] * (spin[1] * s_rate + spin_rate[1] * s)
            + inertia[0] * (spin[0] * camber_cos * camber_rate + spin_rate[0] * points[2]);
        let roll_momentum =
            q[Q::RollInertia] * omega[0] - product * upward + inertia[0] * spin[0] * points[0];
        let roll_momentum_rate = q[Q::RollInertia] * rolling_rate
            - product * upward_rate
            - inertia[0] * spin[0] * cos_eps * cos_delta * turning;
        let pitch_momentum = about_y * across * co
            - (q[Q::YawInertia] * upward - product * omega[0]) * s
            + inertia[1] * spin[1] * co
            + inertia[0] * spin[0] * points[1];
        let trace_rate = c.yaw[0][i]
            - (1.0 + tan_phi * tan_phi) * rolling * sin_theta
            - tan_phi * cos_theta * c.pitch[1][i];
        let pitch_moment = inertia[0]
            * (spin_rate[0] * camber_cos - spin[0] * points[2] * camber_rate)
            + inertia[1] * (spin_rate[1] * co + spin[1] * co_rate)
            + c.yaw[0][i] * roll_momentum;

        // loads
        let mean_crown = 0.5 * (crown[0] + crown[1]);
        let above_ground = (height - mean_crown) * co + mean_crown;
        let rising = -(height - mean_crown) * (s * rolling_rate + co * rolling * rolling);
        let weight = mass * (GRAVITY + rising);
        let total = mass * c.acceleration[i] + inputs.drag * speed * speed;
        let lead = load_lead(inputs.rolling, 0.5 * (inputs.radius[0] + inputs.radius[1]));
        let arm = [q[Q::CgToFront] + lead, q[Q::CgToFront] - q[Q::Wheelbase] + lead];
        let front_load =
            (-above_ground * total - pitch_moment - arm[1] * weight) / (arm[0] - arm[1]);
        let load = [front_load, weight - front_load];

        // side forces
        let lateral = c.lateral[0][i]
            + q[Q::LateralDelay] * c.lateral[1][i]
            + q[Q::UnitBehind] * yawing
            + q[Q::UnitAbove] * (rolling_rate * co - s * rolling * rolling);
        let resisting = -inputs.rolling * load[0];
        let twisting =
            [(q[Q::FrontTwist], q[Q::FrontTwistGrowth]), (q[Q::RearTwist], q[Q::RearTwistGrowth])];
        let twist: f64 = (0..2)
            .map(|k| {
                let (stiffness, growth) = twisting[k];
                -stiffness * load[k] * camber[k] * (1.0 + growth * camber[k] * camber[k])
            })
            .sum();
        let (sin_d, cos_d) = steer.sin_cos();
        // gusts push the centre of mass, but turn the motorcycle about it hardly at all: what the tyres do shows in the
        // roll
        let arms = place.map(|r| -r[2]);
        let rolling_moment = roll_momentum_rate
            - trace_rate * pitch_momentum
            - place[0][1] * load[0]
            - place[1][1] * load[1]
            - arms[0] * resisting * sin_d;
        let driving = total - resisting * cos_d;
        let moment = yaw_moment - twist - place[0][0] * resisting * sin_d
            + place[0][1] * resisting * cos_d
            + place[1][1] * driving;
        let a = place[0][0] * cos_d + (place[0][1] - place[1][1]) * sin_d;
        let leaning = arms[0] * cos_d;
        let determinant = leaning * place[1][0] - arms[1] * a;
        let force = [
            (rolling_moment * place[1][0] - arms[1] * moment) / determinant,
            (leaning * moment - a * rolling_moment) / determinant,
        ];
        let per_moment = [arms[1] / determinant, -leaning / determinant];
        let total_side = force[0] * cos_d + force[1] + resisting * sin_d;
        let integral = c.integral[i]
            + q[Q::UnitPitch] * c.integral_per_pitch[i]
            + q[Q::UnitBehind] * omega[2]
            + q[Q::UnitAbove] * rolling * co
            + q[Q::LateralDelay] * c.lateral[0][i];
        let [f0, f1] = force;
        let [w0, w1] = aside;
        let [u0, u1] = forward;
        [
            f0,
            f1,
            per_moment[0],
            per_moment[1],
            load[0],
            load[1],
            camber[0],
            camber[1],
            steer,
            w0,
            w1,
            u0,
            u1,
            integral,
            drift,
            lateral - total_side / mass,
        ]
    }
}
