//! How a cause is found: ride, residual, fault-free simulations, cause, gain.

use super::svg::{Anchor, BLUE, DARK, GREEN, GREY, ORANGE, PALE, PALE_BLUE, Panel, Sheet};
use super::table::Tables;

/// Speed of one stop: measured, and simulated without and with the causes.
struct Stop {
    time: Vec<f64>,
    measured: Vec<f64>,
    nominal: Vec<f64>,
    extended: Vec<f64>,
}

fn first_stop(tables: &Tables) -> Stop {
    let table = tables.of_diagnose("replays");
    let places = table.places(&[("kind", "front_braking"), ("channel", "velocity_x")]);
    let all = table.numbers("replay_id");
    let first = places.first().map_or(f64::NAN, |i| all[*i]);
    let places: Vec<usize> = places.into_iter().filter(|i| all[*i] == first).collect();
    let [time, measured, nominal, extended] =
        ["time", "measured", "base", "extended"].map(|name| table.at(name, &places));
    let start = time.first().copied().unwrap_or_default();
    let time = time.into_iter().map(|t| t - start).collect();
    Stop { time, measured, nominal, extended }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// From a ride to a cause, in five steps.
pub fn diagnosis(tables: &Tables) -> String {
    let mut sheet = Sheet::new(1600.0);
    let stop = first_stop(tables);
    ride(&mut sheet, &stop);
    residual(&mut sheet, &stop);
    calibration(&mut sheet, tables);
    causes(&mut sheet, tables);
    gain(&mut sheet, tables);
    sheet.finish("How a cause is found: ride, residual, fault-free simulations, cause, gain")
}

fn span(stop: &Stop) -> [f64; 2] {
    [0.0, stop.time.last().copied().unwrap_or(1.0)]
}

const SECONDS: [(f64, &str); 3] = [(0.0, "0"), (0.5, "0.5"), (1.0, "1")];

fn ride(sheet: &mut Sheet, stop: &Stop) {
    sheet.step(10.0, "1", "Ride", "the nominal model, fitted to the ride, simulates it again");
    let panel = Panel {
        left: 90.0,
        top: 100.0,
        width: 600.0,
        height: 130.0,
        x: span(stop),
        y: [12.0, 21.0],
    };
    panel.axes(sheet, &SECONDS, &[(15.0, "15"), (20.0, "20")], "time in a stop, s");
    panel.curve(sheet, &stop.time, &stop.nominal, ORANGE, 3.0);
    sheet.dots(&panel.points(&stop.time, &stop.measured), 4.5, DARK);
    sheet.text([100.0, 94.0], Anchor::Start, DARK, "measured speed, m/s");
    sheet.text([340.0, 94.0], Anchor::Start, ORANGE, "simulated");
}

fn residual(sheet: &mut Sheet, stop: &Stop) {
    sheet.step(295.0, "2", "Residual", "what the simulation does not explain");
    let panel = Panel {
        left: 90.0,
        top: 385.0,
        width: 600.0,
        height: 130.0,
        x: span(stop),
        y: [-0.1, 0.3],
    };
    panel.axes(sheet, &SECONDS, &[(0.0, "0"), (0.1, "0.1"), (0.2, "0.2")], "time in the stop, s");
    panel.curve(sheet, &stop.time, &difference(&stop.measured, &stop.nominal), ORANGE, 3.0);
    panel.curve(sheet, &stop.time, &difference(&stop.measured, &stop.extended), GREEN, 3.0);
    sheet.text([100.0, 379.0], Anchor::Start, ORANGE, "measured - simulated, m/s");
    sheet.text([420.0, 379.0], Anchor::Start, GREEN, "with the causes of 4");
}

fn calibration(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(
        580.0,
        "3",
        "Fault-free simulations",
        "the same ride, simulated 24 times without a fault",
    );
    let table = tables.of_diagnose("discrepancies");
    let (channel, kind) = (table.texts("channel"), table.texts("kind"));
    let structured = table.texts("structured");
    let [ride, mean, largest] =
        ["rmse_base", "noise_floor", "null_largest"].map(|name| table.numbers(name));
    let mut places: Vec<usize> = (0..ride.len()).collect();
    places.sort_by(|a, b| (ride[*b] / largest[*b]).total_cmp(&(ride[*a] / largest[*a])));
    let shown = [&places[..3], &places[places.len() / 2..places.len() / 2 + 2]].concat();
    let panel = Panel {
        left: 330.0,
        top: 665.0,
        width: 360.0,
        height: 170.0,
        x: [0.0, 3.5],
        y: [0.0, 5.0],
    };
    panel.axes(
        sheet,
        &[(0.0, "0"), (1.0, "1"), (2.0, "2"), (3.0, "3")],
        &[],
        "misfit over the mean of fault-free ones",
    );
    for (row, i) in shown.into_iter().enumerate() {
        let y = panel.at(0.0, 4.5 - row as f64)[1];
        let at = |v: f64| panel.at(v, 0.0)[0];
        let words = format!("{}, {}", channel[i].replace('_', " "), kind[i].replace('_', " "));
        sheet.text([320.0, y + 7.0], Anchor::End, DARK, &words);
        sheet.bar(at(0.0), at(largest[i] / mean[i]), y - 11.0, 22.0, PALE_BLUE);
        sheet.disc(
            [at(ride[i] / mean[i]), y],
            8.0,
            if structured[i] == "true" { ORANGE } else { BLUE },
        );
    }
    sheet.bar(330.0, 350.0, 643.0, 16.0, PALE_BLUE);
    sheet.text([358.0, 659.0], Anchor::Start, GREY, "largest of 24");
    sheet.disc([530.0, 651.0], 8.0, ORANGE);
    sheet.text([545.0, 659.0], Anchor::Start, GREY, "this ride");
}

fn causes(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(910.0, "4", "Cause", "30 candidates are scored; those that stand out are fitted");
    let table = tables.of_diagnose("causes");
    let (effect, verdict, score) =
        (table.texts("effect"), table.texts("verdict"), table.numbers("score"));
    let panel = Panel {
        left: 230.0,
        top: 985.0,
        width: 460.0,
        height: 200.0,
        x: [0.0, 4.5],
        y: [0.0, 6.0],
    };
    let ticks = [(0.0, "0"), (1.0, "1"), (1.75, "1.75"), (3.0, "3"), (4.0, "4")];
    panel.axes(sheet, &ticks, &[], "score");
    for (row, i) in (0..6).enumerate() {
        let y = panel.at(0.0, 5.5 - row as f64)[1];
        let colour = if verdict[i] == "named" { ORANGE } else { PALE };
        sheet.text([222.0, y + 7.0], Anchor::End, DARK, &effect[i]);
        sheet.bar(panel.left, panel.at(score[i], 0.0)[0], y - 11.0, 22.0, colour);
    }
    let at = |v: f64| panel.at(v, 0.0)[0];
    sheet.dashed([at(1.0), 985.0], [at(1.0), 1185.0], GREY);
    sheet.dashed([at(1.75), 985.0], [at(1.75), 1185.0], DARK);
    sheet.text([at(1.75) + 12.0, 1090.0], Anchor::Start, DARK, "a cause needs 1.75");
    sheet.text([at(1.75) + 12.0, 1118.0], Anchor::Start, GREY, "95 % of fault-free");
    sheet.text([at(1.75) + 12.0, 1144.0], Anchor::Start, GREY, "simulations: below 1");
    let late = table.places(&[("effect", "latency")]);
    let [value, low, high] =
        ["value", "ci95_low", "ci95_high"].map(|name| 1e3 * table.at(name, &late)[0]);
    let words =
        format!("latency: {value:.1} ms, 95 % interval {low:.1} to {high:.1} ms (true: 20 ms)");
    sheet.text([42.0, 1262.0], Anchor::Start, ORANGE, &words);
}

fn gain(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(1300.0, "5", "Gain", "stops left out of the fit are simulated: the error must fall");
    let table = tables.of_diagnose("simulation_errors");
    let rows = [
        ("velocity_x", "front_braking", "speed, front braking"),
        ("velocity_x", "rear_braking", "speed, rear braking"),
        ("steer_angle", "front_braking", "steering, front braking"),
        ("roll", "cornering", "roll, cornering"),
    ];
    let panel = Panel {
        left: 290.0,
        top: 1385.0,
        width: 400.0,
        height: 150.0,
        x: [0.0, 1.3],
        y: [0.0, 4.0],
    };
    panel.axes(
        sheet,
        &[(0.0, "0"), (0.5, "0.5"), (1.0, "1")],
        &[],
        "error over that of the nominal model",
    );
    for (row, (channel, kind, label)) in rows.into_iter().enumerate() {
        let place = table.places(&[("channel", channel), ("kind", kind)]);
        let [nominal, extended, noise] =
            ["rmse_base", "rmse_extended", "noise_floor"].map(|name| table.at(name, &place)[0]);
        let y = panel.at(0.0, 3.5 - row as f64)[1];
        let at = |v: f64| panel.at(v / nominal, 0.0)[0];
        sheet.text([280.0, y + 7.0], Anchor::End, DARK, label);
        sheet.line(&[[at(noise), y - 13.0], [at(noise), y + 13.0]], GREY, 3.0);
        if (at(nominal) - at(extended)).abs() > 25.0 {
            sheet.arrow([at(nominal), y], [at(extended), y], GREEN);
        } else {
            sheet.disc([at(extended), y], 6.0, GREEN);
        }
        sheet.disc([at(nominal), y], 8.0, ORANGE);
    }
    sheet.disc([300.0, 1372.0], 8.0, ORANGE);
    sheet.text([314.0, 1379.0], Anchor::Start, GREY, "nominal");
    sheet.arrow([415.0, 1372.0], [445.0, 1372.0], GREEN);
    sheet.text([452.0, 1379.0], Anchor::Start, GREY, "extended");
    sheet.line(&[[572.0, 1360.0], [572.0, 1384.0]], GREY, 3.0);
    sheet.text([582.0, 1379.0], Anchor::Start, GREY, "noise only");
}
