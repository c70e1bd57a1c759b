//! The kinds of riding, and rides of them on the reduced-order motorcycle and on the multibody one.

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::diagnose::road::advice::sets::{SETS, leaning};
use roadbench::internals::segment::manoeuvre::Direction;
use roadbench::internals::simulate;
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::simulate::manoeuvre::Manoeuvre;
use roadbench::internals::simulate::plan::{Phase, Plan, PlanKind};
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::transients::Transients;
use roadbench::internals::simulate::{multibody_ride as multibody, sensors};
use roadbench::internals::statistics::random::Random;

/// A ride, s.
pub const RIDE: f64 = 480.0;
/// Lean of a body that hangs off or leans out, m of the centre of mass per rad: 45 mm at 26 degrees.
pub const HUNG: f64 = 0.1;
/// Rate of the logs, Hz.
const LOGGED: f64 = 100.0;

/// On what is ridden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum On {
    /// The motorcycle.
    One,
    /// The same with a pillion.
    Pillion,
    /// Another motorcycle, larger, with wheels of the same tyres.
    Other,
}

/// What a stretch of riding is.
#[derive(Debug, Clone, Copy)]
pub enum Riding {
    /// Sets of the advice, by their words.
    Sets(&'static [&'static str]),
    /// A plan.
    Plan(PlanKind),
}

/// One way to ride.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    /// On what.
    pub on: On,
    /// What.
    pub riding: Riding,
    /// Lean of the rider's body, m/rad.
    pub lean: f64,
}

/// Ways to ride that are compared; a share of the time each.
pub struct Kind {
    /// In the table.
    pub name: &'static str,
    /// The ways.
    pub ways: &'static [Way],
}

impl Riding {
    /// Corners to both sides, 14 to 28 m.
    pub const STEADY: Riding = Riding::Sets(&["6 right-hand corners", "6 left-hand corners"]);
}

const STEADY: Riding = Riding::STEADY;
const TIGHT: Riding = Riding::Sets(&["6 tight corners to both sides below 25 km/h"]);
const WIDE: Riding = Riding::Sets(&["6 wide corners to both sides at 70 to 100 km/h"]);
const QUICK: Riding = Riding::Sets(&["6 corners to both sides, leant into quickly"]);
const BRAKED: Riding = Riding::Sets(&["6 corners to both sides, braked into with the front brake"]);
const DRIVEN: Riding = Riding::Sets(&["6 corners to both sides on the throttle"]);

const fn usual(riding: Riding) -> Way {
    Way { on: On::One, riding, lean: 0.0 }
}

const UPRIGHT: Way = usual(STEADY);
const OFF: Way = Way { lean: HUNG, ..UPRIGHT };
const OUT: Way = Way { lean: -HUNG, ..UPRIGHT };

/// Every kind.
pub const KINDS: &[Kind] = &[
    Kind { name: "the paper's plan", ways: &[usual(Riding::Plan(PlanKind::Paper))] },
    Kind { name: "mixed riding", ways: &[usual(Riding::Plan(PlanKind::Naturalistic))] },
    Kind { name: "steady corners, 14 to 28 m", ways: &[UPRIGHT] },
    Kind { name: "wide corners, 70 to 100 km/h", ways: &[usual(WIDE)] },
    Kind { name: "tight corners, below 25 km/h", ways: &[usual(TIGHT)] },
    Kind { name: "corners leant into quickly", ways: &[usual(QUICK)] },
    Kind { name: "corners on the brake", ways: &[usual(BRAKED)] },
    Kind { name: "corners on the throttle", ways: &[usual(DRIVEN)] },
    Kind { name: "steady, hung off", ways: &[OFF] },
    Kind { name: "steady, leaning out", ways: &[OUT] },
    Kind { name: "steady and wide and tight", ways: &[UPRIGHT, usual(WIDE), usual(TIGHT)] },
    Kind {
        name: "steady, alone and with a pillion",
        ways: &[UPRIGHT, Way { on: On::Pillion, ..UPRIGHT }],
    },
    Kind { name: "steady, two motorcycles", ways: &[UPRIGHT, Way { on: On::Other, ..UPRIGHT }] },
    Kind { name: "steady, as usual and hung off", ways: &[UPRIGHT, OFF] },
    Kind { name: "steady, hung off and leaning out", ways: &[OFF, OUT] },
    Kind { name: "steady, hung off and leaning out, and quick", ways: &[OFF, OUT, usual(QUICK)] },
    Kind {
        name: "the same and tight and on the brake",
        ways: &[OFF, OUT, usual(QUICK), usual(TIGHT), usual(BRAKED)],
    },
];

/// The ways whose estimates are verified.
pub const VERIFIED: [Way; 2] = [OFF, OUT];
/// The same without the posture.
pub const CONTROL: [Way; 2] = [UPRIGHT, UPRIGHT];

fn phases(riding: Riding, random: &mut Random) -> Vec<Phase> {
    match riding {
        Riding::Plan(kind) => {
            let transients = Transients::default();
            let plan = match kind {
                PlanKind::Paper => Plan { kind, coasts: 8, brakings: 5, laps: 9, transients },
                PlanKind::Naturalistic => {
                    Plan { kind, coasts: 8, brakings: 7, laps: 8, transients }
                }
            };
            plan.phases(random)
        }
        Riding::Sets(words) => {
            let of = |w: &&str| SETS.iter().find(|s| s.words == *w).expect("a set of these words");
            let once: Vec<Phase> = words.iter().flat_map(|w| (of(w).phases)()).collect();
            let mut all = vec![Phase::Stand { duration: 3.0 }];
            (0..6).for_each(|_| all.extend(once.iter().copied()));
            all
        }
    }
}

/// The machine that something is ridden on, of the one that a scenario has; bike files are true.
pub fn machine(one: &Machine, on: On) -> Machine {
    let mut m = one.clone();
    let p = &mut m.plant.vehicle;
    match on {
        On::One => {}
        On::Pillion => {
            p.mass += 75.0;
            p.cg_to_front += 0.07;
            p.cg_height += 0.03;
            p.roll_inertia += 8.0;
            p.yaw_inertia += 6.0;
        }
        On::Other => {
            p.mass += 60.0;
            p.wheelbase += 0.1;
            p.cg_to_front += 0.02;
            p.cg_height -= 0.04;
            p.roll_inertia += 4.0;
            p.yaw_inertia += 8.0;
            p.wheel_inertia = p.wheel_inertia.map(|i| 1.2 * i);
        }
    }
    let keys = [
        ("mass", p.mass),
        ("wheelbase", p.wheelbase),
        ("cg_to_front", p.cg_to_front),
        ("cg_height", p.cg_height),
        ("yaw_inertia", p.yaw_inertia),
        ("front.wheel_inertia", p.wheel_inertia[0]),
        ("rear.wheel_inertia", p.wheel_inertia[1]),
    ];
    m.bike = keys.iter().fold(m.bike, |bike, (key, value)| bike.with(key, *value));
    m
}

/// One ride of `number` on the reduced-order motorcycle, as its logger wrote it, no longer than [`RIDE`].
pub fn ride(scenario: &Scenario, machine: &Machine, way: &Way, number: usize) -> Session {
    let id = format!("side_force_{number:04}");
    let purpose = |what: &str| Random::new(scenario.seed, &format!("{id} {what}"));
    let mut plant = machine.plant.clone();
    plant.model_error = ModelError { rider_lean: way.lean, ..ModelError::default() };
    let height = machine.plant.vehicle.cg_height;
    let phases = leaning(phases(way.riding, &mut purpose("plan")), way.lean, height);
    let meta =
        Meta { session_id: id.clone(), bike_id: machine.bike.bike_id.clone(), ..Meta::default() };
    let (calm, drawn) = (scenario.disturbance, purpose("ride"));
    let mut session =
        simulate::simulate_phases(&plant, &phases, calm, drawn, LOGGED, RIDE, meta).session;
    plant.model_error.measure(&mut session);
    sensors::measure(&mut session, &scenario.sensors, scenario.seed);
    sensors::clamp_physical(&mut session);
    session
}

/// The same of steady corners on the multibody motorcycle, and its bike file.
pub fn multibody_ride(
    scenario: &Scenario,
    machine: &Machine,
    lean: f64,
    number: usize,
) -> Result<(Session, Bike), String> {
    let mut tour = multibody::tour(scenario, machine, number)?;
    tour.model = tour.model.with(&ModelError { rider_lean: lean, ..ModelError::default() });
    tour.name = format!("side_force_{number:04}");
    tour.manoeuvres = (0..30)
        .map(|k| {
            let radius = [14.0, 20.0, 28.0][k % 3];
            let speed = f64::sqrt(radius * [4.0, 5.5, 6.2, 3.2, 4.8, 5.8][k % 6]);
            let direction = [Direction::Left, Direction::Right][k / 3 % 2];
            Manoeuvre::Corner { direction, radius, speed, turn: std::f64::consts::PI }
        })
        .collect();
    let ridden = multibody::ridden(&tour, number)?;
    match ridden.fall {
        Some(fall) => Err(fall.to_string()),
        None => Ok((ridden.session, tour.bike)),
    }
}
