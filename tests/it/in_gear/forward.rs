//! A compact forward model for the tests, another way than the estimator's: point mass on a lap, wheels and
//! slips integrated at 2 kHz under brake and engine torques and the forward Magic Formula, then sensors.

use roadbench::GRAVITY;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::fit::in_gear::parameters::*;
use roadbench::internals::statistics::random::Random;
use roadbench::internals::tyre::magic_formula::MagicFormula;

/// Overall ratios of the simulated motorcycle: not those that the estimator assumes.
const RATIOS: [f64; 6] = [11.3, 8.8, 7.3, 6.3, 5.6, 5.1];

/// How a session is logged and ridden.
#[derive(Clone, Copy)]
pub struct Style {
    /// Rate of the log, Hz.
    pub rate: f64,
    /// Noise of the sensors, 0 none and 1 usual.
    pub noise: f64,
    /// Sine of the slope, its amplitude over a lap.
    pub slope: f64,
    /// Head wind, m/s.
    pub wind: f64,
    /// Laps.
    pub laps: usize,
}

pub const USUAL: Style = Style { rate: 10.0, noise: 1.0, slope: 0.0, wind: 0.0, laps: 4 };

pub fn bike() -> Bike {
    let text = "mass = 275.0\nwheelbase = 1.44\ncg_to_front = 0.705\ncg_height = 0.63\n\
                caster_angle = 0.42\nfront.radius = 0.298\nfront.width = 0.12\n\
                rear.radius = 0.322\nrear.width = 0.19\n";
    Bike::parse(text, "test", std::path::Path::new("test.toml")).expect("bike")
}

/// A machine drawn around what the estimator believes.
pub fn truth(seed: u64) -> Theta {
    let mut r = Random::new(seed, "machine");
    let mut t = [0.0; COUNT];
    let mut set = |k: usize, mean: f64, sd: f64| t[k] = mean + sd * r.between(-1.7, 1.7);
    set(R_F, 0.298, 0.004);
    set(R_R, 0.322, 0.004);
    set(RHO_F, 0.06, 0.012);
    set(RHO_R, 0.095, 0.012);
    set(K_F, 23_f64.ln(), 0.3);
    set(K_R, 23_f64.ln(), 0.3);
    set(D_F, 1.32_f64.ln(), 0.08);
    set(D_R, 1.32_f64.ln(), 0.08);
    set(C_F, 1.55_f64.ln(), 0.06);
    set(C_R, 1.55_f64.ln(), 0.06);
    set(E_F, 0.0, 0.3);
    set(E_R, 0.0, 0.3);
    set(DRAG, 0.21, 0.025);
    set(SIT_UP, 1.25, 0.1);
    set(ROLLING, 0.015, 0.003);
    set(LOAD, 0.05, 0.03);
    set(LEAN_EXPONENT, 0.7, 0.2);
    set(LATERAL, 1.5, 0.06);
    set(GROWTH_F, 0.85, 0.4);
    set(GROWTH_R, 1.2, 0.4);
    set(SINK, 0.9, 0.4);
    set(ENGINE_0, 6.0, 3.0);
    set(ENGINE_1, 1.7, 0.4);
    set(ENGINE_INERTIA, 0.02, 0.004);
    set(BRAKE_F, 90_f64.ln(), 0.3);
    set(BRAKE_R, 30_f64.ln(), 0.3);
    set(LATENCY, 0.18, 0.06);
    set(ANTENNA, 0.9, 0.06);
    set(MASS, 275.0, 6.0);
    set(HEIGHT, 0.63, 0.02);
    set(ARM, 0.705, 0.01);
    set(LEAN_ZERO, 0.0, 0.012);
    set(TWIST, 1.0, 0.3);
    set(GAIN_F, 0.2, 0.08);
    set(GAIN_R, 0.2, 0.08);
    t[K_D] = t[K_R] + 0.1 * r.between(-1.0, 1.0);
    t
}

/// Corners of a lap: lean (rad, signed), speed (m/s); between them straights.
const LAP: [(f64, f64); 8] = [
    (0.75, 21.0),
    (-0.70, 31.0),
    (0.82, 17.0),
    (0.5, 38.0),
    (-0.78, 24.0),
    (0.72, 28.0),
    (-0.6, 19.0),
    (0.66, 34.0),
];

#[derive(Clone, Copy)]
struct Command {
    phase: f64,
    deceleration: f64,
    throttle: f64,
    rear: bool,
    hesitate: f64,
}

/// Rides and logs.
pub fn session(seed: u64, truth: &Theta, style: Style) -> Session {
    let mut r = Random::new(seed, "ride");
    let bike = bike();
    let inertia = [0.45, 0.60];
    let (dt, every) = (5e-4, (1.0 / (style.rate * 5e-4)).round() as usize);
    let fast = |wheel: usize, driven: bool| {
        let c = curve(truth, wheel, driven);
        (
            c,
            MagicFormula {
                b: c.stiffness / (c.shape * c.peak),
                c: c.shape,
                d: c.peak,
                e1: c.curvature,
                e2: 0.0,
            },
        )
    };
    let curves = [fast(0, false), fast(1, false), fast(1, true)];
    let (m, l) = (truth[MASS], bike.wheelbase);
    let weight = m * GRAVITY;
    let static_f = weight * (l - truth[ARM]) / l;
    let load_0 = [static_f, weight - static_f];
    let (mut v, mut lean, mut ax_late, mut time) = (30.0_f64, 0.0_f64, 0.0, 0.0_f64);
    let mut omega = [v / truth[R_F], v / truth[R_R]];
    let (mut pressure, mut throttle) = ([0.0_f64; 2], 0.0_f64);
    let (mut gear, mut shifted) = (4_usize, -1.0_f64);
    let mut logged: Vec<[f64; 9]> = Vec::new();
    let (mut corner, mut lap, mut count) = (0, 0, 0_usize);
    let command = |r: &mut Random| Command {
        phase: 0.0,
        deceleration: r.between(5.5, 9.0),
        throttle: r.between(0.7, 1.0),
        rear: r.between(0.0, 1.0) < 0.45,
        hesitate: r.between(0.3, 1.8),
    };
    let mut ride = command(&mut r);
    let mut straight = r.between(3.5, 7.0);
    while lap < style.laps {
        let (target_lean, target_speed) = LAP[corner];
        // phases: 0 drive, 1 roll off, 2 brake, 3 corner
        ride.phase += dt;
        let braking = ride.phase > straight + ride.hesitate;
        let arrived = v < target_speed + 0.5;
        let state = if ride.phase < straight {
            0
        } else if !braking {
            1
        } else if !arrived && lean.abs() < 0.9 * target_lean.abs() {
            2
        } else {
            3
        };
        let (mut want_f, mut want_r, mut want_throttle) = (0.0, 0.0, 0.0);
        let mut want_lean = 0.0;
        match state {
            0 => want_throttle = ride.throttle * (ride.phase / 1.2).min(1.0),
            1 => {}
            2 => {
                let left = ((v - target_speed) / 4.0).clamp(0.15, 1.0);
                let torque = m * ride.deceleration * left * truth[R_F];
                want_f = 0.3 + 0.9 * torque / truth[BRAKE_F].exp();
                want_r = if ride.rear { 0.3 + 0.06 * torque / truth[BRAKE_R].exp() } else { 0.0 };
                if left < 1.0 {
                    want_lean = target_lean * (1.0 - left);
                } // trail braking
            }
            _ => {
                want_lean = target_lean;
                want_throttle = 0.12;
                if (lean - target_lean).abs() < 0.03 && ride.phase > straight + ride.hesitate + 1.0
                {
                    corner += 1;
                    if corner == LAP.len() {
                        corner = 0;
                        lap += 1;
                    }
                    ride = command(&mut r);
                    straight = r.between(3.0, 6.5);
                }
            }
        }
        let follow = |x: &mut f64, want: f64, tau: f64| *x += dt / tau * (want - *x);
        follow(&mut pressure[0], want_f, 0.12);
        follow(&mut pressure[1], want_r, 0.15);
        if want_throttle == 0.0 {
            follow(&mut throttle, 0.0, 0.05);
        } else {
            follow(&mut throttle, want_throttle, 0.25);
        }
        let lean_rate = ((want_lean - lean) * 2.0).clamp(-0.9, 0.9);
        lean += dt * lean_rate;
        let (cos, tan) = (lean.cos(), lean.tan());
        // engine and gear
        let turns =
            |gear: usize, w: f64| RATIOS[gear - 1] * w * 60.0 / std::f64::consts::TAU / 1000.0;
        if time > shifted + 0.5 {
            if turns(gear, omega[1]) > 12.0 && gear < 6 {
                gear += 1;
                shifted = time;
            } else if turns(gear, omega[1]) < 6.0 && gear > 1 {
                gear -= 1;
                shifted = time;
            }
        }
        let ratio = RATIOS[gear - 1];
        let transfer = m * ax_late * truth[HEIGHT] * cos / l;
        let load = [(static_f - transfer).max(30.0), (weight - static_f + transfer).max(30.0)];
        let radius = [0, 1].map(|k| {
            truth[R_F + k] * (1.0 + 1e-6 * truth[GROWTH_F + k] * v * v)
                - truth[RHO_F + k] * (1.0 - cos)
                - 1e-6 * truth[SINK] * (load[k] - load_0[k])
        });
        let arm = [0, 1].map(|k| 0.985 * truth[R_F + k] - truth[RHO_F + k] * (1.0 - cos));
        // moments about the line of the contacts: weight, centrifugal force, spinning wheels
        let crown = 0.5 * (truth[RHO_F] + truth[RHO_R]);
        let above = truth[HEIGHT] - crown;
        let spinning = (inertia[0] / truth[R_F] + inertia[1] / truth[R_R]) / m;
        let bend = GRAVITY * above * lean.sin() / (crown + (above + spinning) * cos) / (v * v);
        let contact = [v, v / (1.0 + 0.5 * (l * bend).powi(2))];
        let force: [f64; 2] = [0, 1].map(|k| {
            let s = (omega[k] * radius[k] / contact[k] - 1.0).clamp(-0.9, 0.9);
            let (c, _) = if k == 0 {
                curves[0]
            } else if s > 0.0 {
                curves[2]
            } else {
                curves[1]
            };
            let w = c.left(tan);
            let (stiffness, peak) = (w.powf(c.exponent) * c.stiffness, w * c.peak);
            let f = MagicFormula {
                b: stiffness / (c.shape * peak),
                c: c.shape,
                d: peak,
                e1: c.curvature,
                e2: 0.0,
            };
            let share = (load[k] / load_0[k]).powf(truth[LOAD]);
            let stiffer = 1.0 + truth[GAIN_F + k] * (load[k] / load_0[k] - 1.0);
            f.value(s * stiffer * share) * load[k] / share
        });
        let brake = [0, 1].map(|k| truth[BRAKE_F + k].exp() * (pressure[k] - 0.3).max(0.0));
        let drag_torque = truth[ENGINE_0] + truth[ENGINE_1] * turns(gear, omega[1]);
        let cut = time < shifted + 0.12;
        let drive = if throttle > 0.02 && !cut { 115.0 * throttle } else { 0.0 };
        let engine = (drive - drag_torque * (1.0 - (throttle / 0.05).min(1.0))) * ratio;
        // tyre force turns the wheel with the loaded arm, as in the estimator's equations of brakes
        let twist = [0, 1].map(|k| {
            truth[TWIST]
                * bike.wheel(Axle::BOTH[k]).twisting_stiffness
                * load[k]
                * lean
                * lean.sin()
        });
        omega[0] += dt * (-brake[0] - twist[0] - force[0] * arm[0]) / inertia[0];
        omega[0] = omega[0].max(0.5);
        let spin = inertia[1] + truth[ENGINE_INERTIA] * ratio * ratio;
        omega[1] += dt * (engine - brake[1] - twist[1] - force[1] * arm[1]) / spin;
        omega[1] = omega[1].max(0.5);
        let posture = if throttle < 0.03 || lean.abs() > 0.349 { truth[SIT_UP] } else { 1.0 };
        let slope = style.slope * (corner as f64 * 0.785).sin();
        let drag = truth[DRAG] * posture * (v + style.wind) * (v + style.wind).abs();
        let ax = (force[0] + force[1] - drag - truth[ROLLING] * weight - weight * slope) / m;
        ax_late += dt / 0.075 * (ax - ax_late);
        v = (v + dt * ax).max(5.0);
        time += dt;
        if count % every == 0 {
            let antenna = v * (1.0 - (truth[ANTENNA] - truth[RHO_F]) * bend * lean.sin());
            logged.push([
                antenna,
                omega[0],
                omega[1],
                lean,
                pressure[0],
                pressure[1],
                throttle,
                gear as f64,
                time,
            ]);
        }
        count += 1;
    }
    log(&logged, truth, style, &mut r)
}

/// Sensors: noise, delay, steps.
fn log(rows: &[[f64; 9]], truth: &Theta, style: Style, r: &mut Random) -> Session {
    let n = rows.len();
    let mut out = Session::new(Meta::default(), style.rate, n);
    let at = |k: usize, i: f64| -> f64 {
        let i = i.clamp(0.0, (n - 1) as f64);
        let j = (i.floor() as usize).min(n.saturating_sub(2));
        rows[j][k] + (i - j as f64) * (rows[j + 1][k] - rows[j][k])
    };
    let noise = style.noise;
    let step = |x: f64, q: f64| if noise > 0.0 { (x / q).round() * q } else { x };
    let mut gnss = roadbench::internals::statistics::random::Coloured::new(
        0.05 * noise,
        1.0,
        1.0 / style.rate,
        r,
    );
    let velocity = (0..n)
        .map(|i| {
            at(0, i as f64 - truth[LATENCY] * style.rate) + gnss.next(r) + 0.03 * noise * r.normal()
        })
        .collect();
    out.set(Channel::VelocityX, velocity);
    for (k, channel) in [Channel::WheelSpeedFront, Channel::WheelSpeedRear].into_iter().enumerate()
    {
        let w = (0..n)
            .map(|i| step(rows[i][1 + k] * (1.0 + 0.0003 * noise * r.normal()), 0.005 / 0.3))
            .collect();
        out.set(channel, w);
    }
    let mut wander = roadbench::internals::statistics::random::Coloured::new(
        0.008 * noise,
        3.0,
        1.0 / style.rate,
        r,
    );
    let roll = (0..n)
        .map(|i| rows[i][3] + truth[LEAN_ZERO] + wander.next(r) + 0.004 * noise * r.normal())
        .collect();
    out.set(Channel::Roll, roll);
    for (k, channel) in
        [Channel::BrakePressureFront, Channel::BrakePressureRear].into_iter().enumerate()
    {
        let p = (0..n)
            .map(|i| 1e5 * step(rows[i][4 + k] + 0.05 * noise * r.normal(), 0.1 * noise.max(1e-9)))
            .collect();
        out.set(channel, p);
    }
    out.set(Channel::Throttle, (0..n).map(|i| step(rows[i][6], 0.005)).collect());
    out.set(Channel::Gear, rows.iter().map(|row| row[7]).collect());
    out
}
