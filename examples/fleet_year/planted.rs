//! What happens to the motorcycles in the year: the truth for the search for events.

use roadbench::internals::simulate::scenario::Machine;

use super::machines::Fleet;
use super::rides::State;

/// Motorcycles.
pub const BIKES: usize = 50;
/// Tyre models.
pub const MODELS: usize = 8;
/// Rides that a motorcycle's levels are taken from, as it is and in any other state.
const RIDES: [usize; 2] = [10, 8];
/// A centre of mass so much farther back in a wrong file, m; a motorcycle so much heavier in one, kg.
const WRONG_CG: f64 = 0.05;
const WRONG_MASS: f64 = 25.0;
/// Lean and forward acceleration as the bad batch of sensors reads them, over what they are.
const BAD: [f64; 2] = [1.03, 1.02];
/// The day from which the bad batch is in use.
const BATCH: f64 = 150.0;

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Tyres of another model, front and rear.
    Swap([bool; 2]),
    /// Tyres that wear all year.
    Wear,
    /// A wrong bike file.
    File,
    /// Sensors of a bad batch.
    Sensors,
}

impl Kind {
    /// In tables.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Swap([true, false]) => "front tyre swapped",
            Kind::Swap([false, true]) => "rear tyre swapped",
            Kind::Swap(_) => "both tyres swapped",
            Kind::Wear => "tyres that wear all year",
            Kind::File => "wrong bike file",
            Kind::Sensors => "sensors of a bad batch",
        }
    }
}

/// One thing that happens to one motorcycle.
#[derive(Debug, Clone)]
pub struct Planted {
    /// The motorcycle.
    pub bike: usize,
    /// What.
    pub kind: Kind,
    /// From which day on.
    pub from: f64,
    /// To which day.
    pub to: f64,
    /// State of the motorcycle from then on; none of what no rides show.
    pub state: Option<String>,
}

/// Tyre models of a motorcycle at the start.
pub fn models(bike: usize) -> [usize; 2] {
    [bike % MODELS; 2]
}

/// All that happens, motorcycle by motorcycle: eight have nothing, fifteen wear, sixteen swaps, six a wrong file, five
/// bad sensors.
pub fn planted() -> Vec<Planted> {
    let mut out = Vec::new();
    let mut put = |bike, kind, from: f64, to: f64, state: Option<&str>| {
        out.push(Planted { bike, kind, from, to, state: state.map(str::to_owned) });
    };
    const YEAR: f64 = 365.0;
    for bike in 8..23 {
        put(bike, Kind::Wear, 0.0, YEAR, None);
    }
    for bike in 23..39 {
        let day = 40.0 + (bike * 97 % 260) as f64;
        if bike >= 35 {
            put(bike, Kind::Swap([true, false]), 110.0, YEAR, Some("front"));
            put(
                bike,
                Kind::Swap([false, true]),
                200.0 + 10.0 * (bike - 35) as f64,
                YEAR,
                Some("both"),
            );
            continue;
        }
        let (ends, state) = match bike % 3 {
            0 => ([true, false], "front"),
            1 => ([false, true], "rear"),
            _ => ([true, true], "both"),
        };
        put(bike, Kind::Swap(ends), day, YEAR, Some(state));
    }
    for bike in 39..45 {
        let from = 60.0 + 35.0 * (bike - 39) as f64;
        // three owners notice
        let to = if bike % 2 == 0 { from + 60.0 } else { YEAR };
        put(bike, Kind::File, from, to, Some("file"));
    }
    for bike in 45..BIKES {
        put(bike, Kind::Sensors, BATCH, YEAR, Some("sensors"));
    }
    out
}

/// The state that a motorcycle is in before anything happens.
pub const USUAL: &str = "usual";

/// All states that rides are made of.
pub fn states(fleet: &Fleet) -> Vec<State> {
    let usual = |bike: usize| State {
        bike,
        name: USUAL.to_owned(),
        machine: fleet.machine(bike, models(bike)),
        file: fleet.machine(bike, models(bike)).bike,
        gains: [1.0; 2],
        first: 0,
        rides: RIDES[0],
    };
    let mut out: Vec<State> = (0..BIKES).map(usual).collect();
    for event in planted() {
        let (Some(name), bike) = (event.state, event.bike) else { continue };
        let mut state = State { name, rides: RIDES[1], ..usual(bike) };
        match event.kind {
            Kind::Wear => {}
            Kind::Swap(_) => {
                let [mut front, mut rear] = models(bike);
                if matches!(state.name.as_str(), "front" | "both") {
                    front = (front + 3) % MODELS;
                }
                if matches!(state.name.as_str(), "rear" | "both") {
                    rear = (rear + 3) % MODELS;
                }
                let Machine { bike: file, plant } = fleet.machine(bike, [front, rear]);
                state.file = file.clone();
                state.machine = Machine { bike: file, plant };
            }
            Kind::File => {
                let file = &state.file;
                state.file = match bike % 2 {
                    0 => file.with("cg_to_front", file.cg_to_front + WRONG_CG),
                    _ => file.with("mass", file.mass + WRONG_MASS),
                };
            }
            Kind::Sensors => state.gains = BAD,
        }
        out.push(state);
    }
    out
}
