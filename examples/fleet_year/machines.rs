//! The motorcycles: machines of the bundled archive's kind on tyres of a few models, so that what two machines have in
//! common is known.

use roadbench::internals::simulate::scenario::{Machine, Scenario};

/// The scenario that machines and tyres are drawn like.
const LIKE: &str = include_str!("../../fixtures/archive/scenario.toml");
/// Half-width of the uniform spread of rolling radii between tyre models, a share.
const RADIUS: f64 = 0.012;

/// Machines that differ in all but their tyres.
pub struct Fleet {
    /// Draws machines and rides.
    pub scenario: Scenario,
    /// Draws tyre models.
    tyres: Scenario,
}

impl Fleet {
    /// `name` is the start of the session ids.
    pub fn new(name: &str, seed: u64) -> Result<Fleet, String> {
        let table = || LIKE.parse::<toml::Table>().map_err(|e| e.to_string());
        let put = |table: &mut toml::Table, name: &str| {
            table.insert("name".into(), name.into());
            table.insert("seed".into(), (seed as i64).into());
        };
        let (mut machines, mut tyres) = (table()?, table()?);
        put(&mut machines, name);
        put(&mut tyres, "tyre");
        let spread = |table: &mut toml::Table, keep: &dyn Fn(&str) -> bool| {
            if let Some(spread) = table.get_mut("spread").and_then(toml::Value::as_table_mut) {
                spread.retain(|key, _| keep(key));
            }
        };
        let of_tyre = |key: &str| key.contains("front.") || key.contains("rear.");
        spread(&mut machines, &|key| !of_tyre(key));
        spread(&mut tyres, &|key| of_tyre(key) && !key.contains("radius"));
        if let Some(spread) = tyres.get_mut("spread").and_then(toml::Value::as_table_mut) {
            for end in ["front", "rear"] {
                spread.insert(format!("truth.{end}.radius_ratio"), RADIUS.into());
            }
        }
        let parse = |table: toml::Table| Scenario::parse(&table.to_string(), name);
        Ok(Fleet { scenario: parse(machines)?, tyres: parse(tyres)? })
    }

    /// A machine on tyres of these models, front and rear. Its bike file knows of the tyres what it would know of any.
    pub fn machine(&self, index: usize, models: [usize; 2]) -> Machine {
        let mut machine = self.scenario.machine(index);
        let plant = &mut machine.plant;
        plant.tyres = [0, 1].map(|k| self.tyres.machine(models[k]).plant.tyres[k]);
        let load = plant.vehicle.static_loads();
        plant.crown = [0, 1].map(|k| {
            let tyre = &plant.tyres[k];
            tyre.overturning_stiffness + load[k] / tyre.vertical_stiffness
        });
        machine.bike.front.model = Some(format!("model_{}", models[0]));
        machine.bike.rear.model = Some(format!("model_{}", models[1]));
        machine
    }
}
