//! Motocross: a bike over jumps, whoops and corners, its true tyre forces beside what thirteen
//! sensors saw of it.
//!
//! ```text
//! scenario -> ground + machine + rider -> pilot -> session (session.v1) and truth
//! ```

pub(crate) mod ground;
pub(crate) mod machine;
pub(crate) mod passive;
pub(crate) mod pilot;
pub(crate) mod rider;
pub(crate) mod scenario;

use super::{Label, sensors};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::{Meta, Session};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::random::Random;
use crate::store::tables::rows;
use machine::{ForwardModel, Response, State};
use pilot::Decision;
use scenario::{Motocross, Vibration};

/// Steps of the integration per second at least.
const STEPS: f64 = 3000.0;
/// Time between two decisions of the rider, s.
const DECISIONS: f64 = 0.01;
/// A flight of both wheels shorter than this is a bump, s.
pub(crate) const SHORTEST_FLIGHT: f64 = 0.15;

/// True signals of a session, at the log's rate.
#[derive(Debug, Clone, Default)]
pub struct Truth {
    /// `[N_f, N_r, B_f, B_r, D_r]` along the chassis, N.
    pub forces: [Vec<f64>; 5],
    /// The rider on the bike, `[L_x, L_z, A_x, A_z]`, ground axes, N.
    pub rider: [Vec<f64>; 4],
    /// Whether the wheel is off the ground: front, rear.
    pub off: [Vec<bool>; 2],
    pub slip: [Vec<f64>; 2],
    /// `[x_s'', z_s'', mu'', z_f'', alpha_r'']`.
    pub qdd: [Vec<f64>; 5],
    /// Distance along the track, m.
    pub x: Vec<f64>,
}

#[derive(Debug, Clone)]
pub struct MotocrossRide {
    pub session: Session,
    pub truth: Truth,
    /// Flights, whoops and corners.
    pub labels: Vec<Label>,
    /// Why the ride ended early, if it did.
    pub fall: Option<String>,
}

/// Rides session `number` of a scenario.
pub fn ride(scenario: &Motocross, number: usize) -> MotocrossRide {
    let plant = scenario.forward_model(number);
    let samples = (scenario.duration * scenario.rate).round() as usize;
    let sub = (STEPS / scenario.rate).ceil().max(1.0) as usize;
    let dt = 1.0 / (scenario.rate * sub as f64);
    let every = (DECISIONS * scenario.rate * sub as f64).round().max(1.0) as usize;
    let mut log = Log::new(&plant, samples);
    let mut state = plant.start(plant.ground.speed(0.0).min(8.0));
    let (mut decision, mut airborne, mut in_air) = (Decision::default(), false, 0);
    let mut fall = None;
    let mut ticks = 0;
    'ride: for i in 0..samples {
        for step in 0..sub {
            let first = plant.respond(&state, &decision.levers, airborne, decision.commanded);
            // a rider feels flight after some 60 ms
            let both = first.tyres.iter().all(|t| t.normal <= 0.0);
            in_air = if both { in_air + 1 } else { 0 };
            airborne = in_air as f64 * dt > 0.06;
            if step == 0 {
                log.push(&plant, &state, &first);
            }
            if ticks % every == 0 {
                decision = pilot::decide(&plant, &state, &first, airborne);
            }
            ticks += 1;
            let commanded = decision.commanded;
            state = plant.step(&state, &first, &decision.levers, airborne, commanded, dt);
            let [_, _, mu, ..] = state.q();
            if !(mu.abs() < 1.3 && state.qd()[0] > 1.0) {
                let time = i as f64 / scenario.rate;
                fall = Some(format!(
                    "fell at {time:.2} s and {:.0} m: pitch {:.0} deg, {:.1} m/s",
                    state.q()[0],
                    mu.to_degrees(),
                    state.qd()[0]
                ));
                break 'ride;
            }
        }
    }
    let id = format!("{}_s{:04}", scenario.name, number + 1);
    let meta = Meta {
        session_id: id,
        bike_id: scenario.bike.bike_id.clone(),
        start_time: Some(format!("2026-04-{:02}T10:00:00Z", number % 28 + 1)),
        site: Some("simulated".to_owned()),
        rider_id: Some("rider_1".to_owned()),
        ..Meta::default()
    };
    let (mut session, truth) = log.finish(meta, scenario.rate);
    let labels = labels(&plant, &truth, scenario.rate);
    shake(&mut session, &scenario.vibration, scenario.seed);
    for &channel in &scenario.drop {
        session.remove(channel);
    }
    sensors::measure(&mut session, &scenario.sensors, scenario.seed);
    MotocrossRide { session, truth, labels, fall }
}

/// Channels of the log, in the order that [`Log`] fills them.
const CHANNELS: [Channel; 13] = [
    Channel::VelocityX,
    Channel::Pitch,
    Channel::ChassisAccelerationZ,
    Channel::HeadAccelerationZ,
    Channel::TailAccelerationZ,
    Channel::ForkTravel,
    Channel::ForkTopAcceleration,
    Channel::ForkBottomAcceleration,
    Channel::ShockTravel,
    Channel::ShockTopAcceleration,
    Channel::ShockBottomAcceleration,
    Channel::WheelSpeedFront,
    Channel::WheelSpeedRear,
];

/// Upper end of the shock in the chassis frame (z down), m, and its direction: up, a little ahead.
const SHOCK_TOP: [f64; 2] = [-0.12, -0.12];
const SHOCK_UP: [f64; 2] = [0.2, -0.979_795_897_113_271_2];

struct Log {
    columns: Vec<Vec<f64>>,
    truth: Truth,
    shock_up: [f64; 2],
}

impl Log {
    fn new(_plant: &ForwardModel, samples: usize) -> Self {
        let column = || Vec::with_capacity(samples);
        Log {
            columns: CHANNELS.iter().map(|_| column()).collect(),
            truth: Truth::default(),
            shock_up: SHOCK_UP,
        }
    }

    fn push(&mut self, plant: &ForwardModel, s: &State, r: &Response) {
        let (q, qd, qdd) = (s.q(), s.qd(), r.qdd);
        let (mu, mud, mudd) = (q[2], qd[2], qdd[2]);
        let (sin, cos) = mu.sin_cos();
        let sensors = &plant.machine.sensors;
        // specific force in chassis axes at a chassis point
        let felt = |p: [f64; 2]| {
            let (x, z) = (cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]);
            let ax = qdd[0] + mudd * z - mud * mud * x;
            let az = qdd[1] - mudd * x - mud * mud * z - GRAVITY;
            [cos * ax - sin * az, sin * ax + cos * az]
        };
        let (sin_eps, cos_eps) = plant.machine.equations.caster();
        let extended = plant.machine.equations.front_axle(0.0);
        let along_fork = [-sin_eps, -cos_eps];
        let top = [0, 1].map(|k| extended[k] + sensors.fork_top * along_fork[k]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let fork_top = dot(felt(top), along_fork);
        let fork_bottom = fork_top + qdd[3] + mud * mud * (sensors.fork_top - q[3]);
        let travel = plant.machine.linkage.travel(q[4]);
        let [_, slope, bend] = plant.machine.linkage.at(travel);
        let speed = qd[4] / slope;
        let acceleration = (qdd[4] - bend * speed * speed) / slope;
        let shock_top = dot(felt(SHOCK_TOP), self.shock_up);
        let shock_bottom = shock_top + acceleration + mud * mud * (sensors.shock - travel);
        let imu_z = cos * sensors.imu[1] - sin * sensors.imu[0];
        let wheels = s.wheels();
        let values = [
            qd[0] + mud * imu_z,
            -mu,
            -felt(sensors.imu)[1],
            -felt(sensors.head)[1],
            -felt(sensors.tail)[1],
            q[3],
            fork_top,
            fork_bottom,
            travel,
            shock_top,
            shock_bottom,
            wheels[0],
            wheels[1],
        ];
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(value);
        }
        let truth = &mut self.truth;
        for (column, value) in truth.forces.iter_mut().zip(r.along_chassis(mu)) {
            column.push(value);
        }
        for (column, value) in truth.rider.iter_mut().zip(r.rider) {
            column.push(value);
        }
        for (column, value) in truth.qdd.iter_mut().zip(qdd) {
            column.push(value);
        }
        for k in 0..2 {
            truth.off[k].push(r.tyres[k].normal <= 0.0);
            truth.slip[k].push(r.tyres[k].slip);
        }
        truth.x.push(q[0]);
    }

    fn finish(self, meta: Meta, rate: f64) -> (Session, Truth) {
        let mut session = Session::new(meta, rate, self.truth.x.len());
        for (channel, column) in CHANNELS.into_iter().zip(self.columns) {
            session.set(channel, column);
        }
        (session, self.truth)
    }
}

/// Puts the engine onto the accelerometers.
fn shake(session: &mut Session, vibration: &Vibration, seed: u64) {
    if vibration.amplitude <= 0.0 {
        return;
    }
    let mut random = Random::new(seed, &format!("engine {}", session.meta.session_id));
    let (rate, n) = (session.rate, session.len);
    let [low, high] = vibration.frequency;
    let mut phase = Vec::with_capacity(n);
    let (mut angle, mut frequency) = (0.0, 0.5 * (low + high));
    let step = (high - low) * (1.0 / rate).sqrt();
    for _ in 0..n {
        frequency = (frequency + step * random.normal()).clamp(low, high);
        angle += std::f64::consts::TAU * frequency / rate;
        phase.push(angle);
    }
    for channel in CHANNELS {
        let part = match channel.name() {
            name if name.contains("bottom") => 0.3,
            name if name.contains("acceleration") => 1.0,
            _ => continue,
        };
        let (shift, share) =
            (random.between(0.0, std::f64::consts::TAU), part * random.between(0.5, 1.0));
        if let Some(x) = session.get_mut(channel) {
            for (x, phase) in x.iter_mut().zip(&phase) {
                *x += vibration.amplitude * share * (phase + shift).sin();
            }
        }
    }
}

/// Flights of both wheels, whoops and corners in time order; the rest is `other`.
fn labels(plant: &ForwardModel, truth: &Truth, rate: f64) -> Vec<Label> {
    let n = truth.x.len();
    let mut kinds: Vec<ManoeuvreKind> =
        truth.x.iter().map(|&x| plant.ground.part(x).kind()).collect();
    let mut i = 0;
    while i < n {
        let flying = |i: usize| truth.off[0][i] && truth.off[1][i];
        if !flying(i) {
            i += 1;
            continue;
        }
        let end = (i..n).find(|&j| !flying(j)).unwrap_or(n);
        if (end - i) as f64 >= SHORTEST_FLIGHT * rate && kinds[i] != ManoeuvreKind::Whoops {
            kinds[i..end].fill(ManoeuvreKind::Airborne);
        }
        i = end;
    }
    let mut out: Vec<Label> = Vec::new();
    for (i, kind) in kinds.into_iter().enumerate() {
        let end = (i + 1) as f64 / rate;
        match out.last_mut() {
            Some(last) if last.0 == kind => last.2 = end,
            _ => out.push((kind, i as f64 / rate, end, None)),
        }
    }
    out
}

/// Rows of the table `truth_offroad`, in ISO axes.
pub(crate) fn truth_rows(ridden: &MotocrossRide, truth_rate: f64) -> Vec<rows::TruthOffroad> {
    let session = &ridden.session;
    let t = &ridden.truth;
    let every = (session.rate / truth_rate).round().max(1.0) as usize;
    (0..t.x.len())
        .step_by(every)
        .map(|i| rows::TruthOffroad {
            session_id: session.meta.session_id.clone(),
            bike_id: session.meta.bike_id.clone(),
            time: session.time(i),
            distance: t.x[i],
            load_front: t.forces[0][i],
            load_rear: t.forces[1][i],
            force_x_front: -t.forces[2][i],
            force_x_rear: t.forces[4][i] - t.forces[3][i],
            contact_front: !t.off[0][i],
            contact_rear: !t.off[1][i],
            slip_ratio_front: t.slip[0][i],
            slip_ratio_rear: t.slip[1][i],
            rider_peg_x: t.rider[0][i],
            rider_peg_z: -t.rider[1][i],
            rider_bar_x: t.rider[2][i],
            rider_bar_z: -t.rider[3][i],
        })
        .collect()
}
