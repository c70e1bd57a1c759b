//! The intervals of exported look-up tables, against the tables of the session: `plots`, `coefficients` and the truth of
//! the bundled archive.

use std::collections::BTreeMap;
use std::path::Path;

use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{Coefficient, PlotPoint, TyreParameters};

use crate::export::{BIKES, SESSION, ridden, roadbench};

/// A row of the exported file by the names of its columns; empty cells are left out.
type Line = BTreeMap<String, f64>;

/// The rows of one tyre's table.
fn rows(text: &str, tyre: &str, table: &str) -> Vec<Line> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let cells = lines.map(|line| line.split(',').collect::<Vec<_>>());
    let own: Vec<Vec<&str>> = cells.filter(|c| (c[0], c[1]) == (tyre, table)).collect();
    assert!(!own.is_empty(), "{tyre} {table}");
    own.into_iter()
        .map(|cells| {
            assert_eq!(cells.len(), names.len(), "{cells:?}");
            let known = names.iter().zip(cells).skip(2).filter(|(_, cell)| !cell.is_empty());
            known.map(|(n, cell)| ((*n).to_owned(), cell.parse().expect("a number"))).collect()
        })
        .collect()
}

/// How far the interval of a quantity reaches below and above it.
fn reach(line: &Line, quantity: &str, unit: &str) -> Option<[f64; 2]> {
    let value = line[&format!("{quantity}_{unit}")];
    let low = *line.get(&format!("{quantity}_ci95_low_{unit}"))?;
    Some([value - low, line[&format!("{quantity}_ci95_high_{unit}")] - value])
}

/// A curve of the table `plots`, with how far its band reaches below and above it.
struct Band(Vec<[f64; 3]>);

impl Band {
    fn of(points: &[PlotPoint], plot: &str, series: &str) -> Self {
        let own = points.iter().filter(|p| p.plot == plot && p.series == series);
        let known = own.filter_map(|p| {
            let y = p.y?;
            Some([p.x, y - p.y_low?, p.y_high? - y])
        });
        Band(known.collect())
    }

    /// Between its points.
    fn at(&self, x: f64) -> [f64; 2] {
        let above = self.0.iter().position(|p| p[0] >= x).unwrap_or(self.0.len() - 1).max(1);
        let (a, b) = (self.0[above - 1], self.0[above]);
        let share = (x - a[0]) / (b[0] - a[0]);
        [1, 2].map(|k| a[k] + share * (b[k] - a[k]))
    }
}

fn near(found: [f64; 2], wanted: [f64; 2], tolerance: f64, what: &str) {
    for (f, w) in found.into_iter().zip(wanted) {
        assert!((f - w).abs() <= tolerance, "{what}: {found:?} is not {wanted:?}");
    }
}

#[test]
fn intervals_of_a_look_up_table_are_those_of_the_charts_and_of_the_coefficients() {
    let (_folder, out) = ridden();
    let export = ["export", &out, "--session", SESSION, "--format", "csv", "--bikes", BIKES];
    let text = roadbench(&export);
    let at = Path::new(&out);
    let points: Vec<PlotPoint> = read::rows(at).expect("plots");
    let tyres: Vec<TyreParameters> = read::rows(at).expect("tyre_parameters");
    let coefficients: Vec<Coefficient> = read::rows(at).expect("coefficients");
    for tyre in ["front", "rear"] {
        let row = tyres.iter().find(|t| t.tyre == tyre).expect("a row");
        let [friction, cornering, leaning] =
            [("friction_x", "fit"), ("stiffness", "k_alpha"), ("stiffness", "k_gamma")]
                .map(|(plot, series)| Band::of(&points, &format!("{plot}_{tyre}"), series));
        let mut along = 0;
        for line in rows(&text, tyre, "longitudinal") {
            let Some(found) = reach(&line, "Fx", "N") else { continue };
            let load = line["load_N"];
            let stiffer = 1.0 + row.slip_stiffness_load * (load / row.load_at_rest - 1.0);
            // slip ratios have six decimals in the file
            let wanted = friction.at(line["slip_ratio_1"] * stiffer).map(|size| size * load);
            near(found, wanted, 3e-5 * load, &format!("{tyre} {line:?}"));
            assert!(!line.contains_key("Fy_ci95_low_N") && !line.contains_key("Mx_ci95_low_Nm"));
            // under no load that a braked wheel has the change with load would be all of it
            assert!(load > 0.5 * row.load_at_rest, "{tyre} {line:?}");
            // the table's loads of braking are those of the file, for the explorer's page
            let [low, high] =
                [row.braked_load_low, row.braked_load_high].map(|l| l.expect("braked"));
            assert!(low <= row.load_at_rest && row.load_at_rest <= high, "{tyre}: {low} to {high}");
            assert!(low / 1.15 - 0.01 <= load && load <= 1.15 * high + 0.01, "{tyre} {line:?}");
            along += 1;
        }
        assert!(along > 60, "{tyre}: {along} longitudinal intervals");
        let named = |name: &str| {
            let own = |c: &&Coefficient| c.tyre == tyre && c.coefficient == name;
            coefficients.iter().find(own).expect("a row")
        };
        let off = |c: &Coefficient| -> [f64; 2] {
            let value = c.value.expect("a value");
            [value - c.ci95_low.expect("low"), c.ci95_high.expect("high") - value]
        };
        let crown = named("overturning_stiffness");
        let (mut across, mut limited) = (0, 0);
        for line in rows(&text, tyre, "lateral") {
            let [angle, camber, load] =
                ["slip_angle_rad", "camber_rad", "load_N"].map(|name| line[name]);
            if let Some(found) = reach(&line, "Mx", "Nm") {
                let lever = load * camber.tan();
                // the moment is minus the crown radius times the lever
                let [low, high] = off(crown).map(|size| size * lever.abs());
                let wanted = if lever > 0.0 { [high, low] } else { [low, high] };
                near(found, wanted, 3e-6 * load + 2e-5, &format!("{tyre} {line:?}"));
            }
            let Some(found) = reach(&line, "Fy", "N") else { continue };
            let sides = |x: f64, [below, above]: [f64; 2]| match x > 0.0 {
                true => [x * above, x * below],
                false => [-x * below, -x * above],
            };
            let a = sides(angle, cornering.at(camber.abs()));
            let g = sides(camber, leaning.at(camber.abs()));
            let sum = |k: usize| match angle * camber < 0.0 {
                true => a[k].hypot(g[k]),
                false => a[k] + g[k],
            };
            let wanted = [sum(0) * load, sum(1) * load];
            across += 1;
            // a band ends at the friction circle
            if found[0] < wanted[0] - 1e-3 * load || found[1] < wanted[1] - 1e-3 * load {
                limited += 1;
                continue;
            }
            near(found, wanted, 5e-5 * load, &format!("{tyre} {line:?}"));
        }
        assert!(across > 300 && 2 * limited < across, "{tyre}: {limited} of {across}");
        // upright, the stiffness and its interval are the coefficient's
        let stiffness = named("cornering_stiffness_0");
        let upright = rows(&text, tyre, "lateral").into_iter().filter(|line| {
            line["camber_rad"].abs() < 1e-9 && (0.001..0.02).contains(&line["slip_angle_rad"])
        });
        let mut checked = 0;
        for line in upright {
            let Some([below, above]) = reach(&line, "Fy", "N") else { continue };
            let per = line["slip_angle_rad"] * line["load_N"];
            let [low, high] = off(stiffness);
            // force is minus stiffness times angle
            near([below / per, above / per], [high, low], 0.01 * low, &format!("{tyre} {line:?}"));
            checked += 1;
        }
        assert!(checked > 0, "{tyre}");
        for line in rows(&text, tyre, "combined") {
            assert!(line.keys().all(|name| !name.contains("ci95")), "{line:?}");
        }
    }
}
