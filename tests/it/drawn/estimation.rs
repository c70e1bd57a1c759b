//! From a log to coefficients, the friction fit and the corner fit.

use super::svg::{Anchor, BLUE, DARK, GREEN, GREY, ORANGE, PALE_BLUE, PALE_ORANGE, Panel, Sheet};
use super::table::{Table, Tables};

/// The stretch of the ride that is drawn, s: five stops with the front brake.
const STRETCH: [f64; 2] = [205.0, 300.0];
const TIMES: [(f64, &str); 4] = [(220.0, "220"), (240.0, "240"), (260.0, "260"), (280.0, "280")];

/// Coordinates of a series of a plot of the session's page.
struct Series {
    x: Vec<f64>,
    y: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    weight: Vec<f64>,
    manoeuvre: Vec<f64>,
}

fn series(tables: &Tables, plot: &str, series: &str) -> Series {
    let table = tables.of_run("plots");
    let places = table.places(&[("plot", plot), ("series", series)]);
    let [x, y, low, high, weight, manoeuvre] =
        ["x", "y", "y_low", "y_high", "weight", "manoeuvre_id"].map(|name| table.at(name, &places));
    Series { x, y, low, high, weight, manoeuvre }
}

fn negated(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| -v).collect()
}

/// Every `step`-th value from a time on, to another.
fn stretch(time: &[f64], values: &[f64], [from, to]: [f64; 2], step: usize) -> [Vec<f64>; 2] {
    let places = (0..time.len()).filter(|i| time[*i] >= from && time[*i] <= to).step_by(step);
    let places: Vec<usize> = places.collect();
    [places.iter().map(|i| time[*i]).collect(), places.iter().map(|i| values[*i]).collect()]
}

fn time_panel(top: f64, height: f64, y: [f64; 2]) -> Panel {
    Panel { left: 70.0, top, width: 630.0, height, x: STRETCH, y }
}

/// From a log to coefficients with intervals, stage by stage.
pub fn flow(tables: &Tables) -> String {
    let mut sheet = Sheet::new(1330.0);
    logged(&mut sheet, tables);
    segmented(&mut sheet, tables);
    estimated(&mut sheet, tables);
    sheet.step(770.0, "4", "Fit", "robust curves through the samples of all manoeuvres of a kind");
    let friction =
        Panel { left: 70.0, top: 850.0, width: 280.0, height: 150.0, x: [0.0, 0.4], y: [0.0, 1.2] };
    fitted(&mut sheet, tables, friction, ["friction_x_front", "stops"], -1.0);
    let lateral = Panel { left: 420.0, x: [0.0, 0.8], y: [0.0, 0.9], ..friction };
    fitted(&mut sheet, tables, lateral, ["friction_y_front", "corners"], 1.0);
    tabled(&mut sheet, tables);
    sheet.finish(
        "From a log to tyre coefficients in five steps, with data of the ride archive_s0001",
    )
}

fn logged(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(
        10.0,
        "1",
        "Ingest and filter",
        "one clock, SI units, less noise, damaged channels rejected",
    );
    let panel = time_panel(90.0, 120.0, [0.0, 24.0]);
    panel.axes(sheet, &TIMES, &[(0.0, "0"), (10.0, "10"), (20.0, "20")], "time, s");
    let log = Table::read(&tables.ride);
    let time = log.numbers("time");
    let [t, pressure] = stretch(&time, &log.numbers("brake_pressure_front"), STRETCH, 10);
    let scaled: Vec<f64> = pressure.iter().map(|p| p / 2e5).collect();
    panel.band(sheet, &t, &vec![0.0; t.len()], &scaled, PALE_ORANGE);
    let [t, speed] = stretch(&time, &log.numbers("velocity_x"), STRETCH, 10);
    panel.curve(sheet, &t, &speed, BLUE, 2.5);
    sheet.text([80.0, 86.0], Anchor::Start, BLUE, "speed, m/s");
    sheet.text([210.0, 86.0], Anchor::Start, ORANGE, "front brake pressure (up to 2.4 MPa)");
}

fn segmented(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(275.0, "2", "Segment", "the ride is cut into manoeuvres of one kind");
    let kinds = [
        ("coasting", "coasting", GREEN),
        ("front_braking", "front braking", ORANGE),
        ("cornering", "cornering", BLUE),
        ("driving", "driving", GREY),
    ];
    let panel = time_panel(335.0, 40.0, [0.0, 1.0]);
    let mut left = 70.0;
    for (kind, label, colour) in kinds {
        for [start, end] in tables.manoeuvres(kind) {
            if end > STRETCH[0] && start < STRETCH[1] {
                let at = |t: f64| panel.at(t.clamp(STRETCH[0], STRETCH[1]), 0.0)[0];
                sheet.bar(at(start), at(end), panel.top, panel.height, colour);
            }
        }
        sheet.bar(left, left + 16.0, 388.0, 16.0, colour);
        sheet.text([left + 22.0, 404.0], Anchor::Start, DARK, label);
        left += 60.0 + 11.5 * label.len() as f64;
    }
}

fn estimated(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(440.0, "3", "Estimate", "slip, load and force of each tyre, sample by sample");
    let signals = tables.of_run("signals");
    let time = signals.numbers("time");
    // between manoeuvres there is nothing to draw
    let broken = |values: &[f64]| {
        let [t, v] = stretch(&time, values, STRETCH, 1);
        let gap = |i: usize| i > 0 && t[i] - t[i - 1] > 0.3;
        let v: Vec<f64> = (0..v.len()).map(|i| if gap(i) { f64::NAN } else { v[i] }).collect();
        [t, v]
    };
    let slip = time_panel(520.0, 80.0, [-0.42, 0.05]);
    slip.axes(sheet, &[], &[(0.0, "0"), (-0.4, "-0.4")], "");
    let [t, v] = broken(&signals.numbers("slip_ratio_front"));
    slip.curve(sheet, &t, &v, ORANGE, 2.5);
    sheet.text([80.0, 514.0], Anchor::Start, ORANGE, "slip ratio of the front wheel");
    let load = time_panel(640.0, 80.0, [0.3, 2.4]);
    load.axes(sheet, &[], &[(1.0, "1"), (2.0, "2")], "same time axis as in 1");
    let kilonewtons: Vec<f64> = signals.numbers("load_front").iter().map(|n| n / 1e3).collect();
    let [t, v] = broken(&kilonewtons);
    load.curve(sheet, &t, &v, BLUE, 2.5);
    sheet.text([80.0, 634.0], Anchor::Start, BLUE, "load of the front wheel, kN");
}

/// Samples and fitted curve of one plot, with its interval.
fn fitted(sheet: &mut Sheet, tables: &Tables, panel: Panel, [plot, of]: [&str; 2], sign: f64) {
    let x_ticks: &[(f64, &str)] = match sign < 0.0 {
        true => &[(0.0, "0"), (0.2, "0.2"), (0.4, "0.4")],
        false => &[(0.0, "0"), (0.4, "0.4"), (0.8, "0.8")],
    };
    let (x, y) = match sign < 0.0 {
        true => ("slip ratio of braking", "braking force / load"),
        false => ("camber, rad", "side force / load"),
    };
    panel.axes(sheet, x_ticks, &[(0.0, "0"), (0.5, "0.5")], x);
    let data = series(tables, plot, "data");
    let fit = series(tables, plot, "fit");
    let along = |s: &Series| negated(&s.x);
    let up = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| sign * v).collect() };
    let points: Vec<[f64; 2]> = panel.inside(&along(&data), &up(&data.y));
    let every: Vec<[f64; 2]> = points.into_iter().step_by(2).collect();
    panel.band(sheet, &along(&fit), &up(&fit.low), &up(&fit.high), PALE_BLUE);
    sheet.dots(&every, 2.5, GREY);
    panel.curve(sheet, &along(&fit), &up(&fit.y), BLUE, 3.0);
    sheet.text([panel.left + 6.0, panel.top - 6.0], Anchor::Start, DARK, &format!("{of}: {y}"));
}

/// Coefficients with their intervals, each over its true value.
fn tabled(sheet: &mut Sheet, tables: &Tables) {
    sheet.step(
        1075.0,
        "5",
        "Tables, report, tyre files",
        "each coefficient with its 95 % interval; | is the simulated truth",
    );
    let truth = Table::read(&tables.truth);
    let rows = [
        ("front", "mf_d", "peak friction, front", 1.0, 3),
        ("front", "cornering_stiffness_0", "cornering stiffness, front", 1.0, 1),
        ("rear", "overturning_stiffness", "crown radius, rear, mm", 1e3, 1),
        ("vehicle", "drag", "drag, kg/m", 1.0, 3),
    ];
    let panel = Panel {
        left: 300.0,
        top: 1140.0,
        width: 130.0,
        height: 160.0,
        x: [0.5, 1.5],
        y: [0.0, 4.0],
    };
    for (k, (tyre, name, label, unit, digits)) in rows.into_iter().enumerate() {
        let [value, low, high] = tables.coefficient(tyre, name).map(|v| unit * v);
        let row = truth.places(&[("tyre", tyre), ("coefficient", name)]);
        let true_value = unit * truth.at("value", &row)[0];
        let y = panel.at(0.5, 3.5 - k as f64)[1];
        let at = |v: f64| panel.at((v / value).clamp(0.4, 1.7), 0.0)[0];
        sheet.text([290.0, y + 7.0], Anchor::End, DARK, label);
        sheet.line(&[[at(low), y], [at(high), y]], BLUE, 5.0);
        sheet.disc([at(value), y], 6.0, BLUE);
        sheet.line(&[[at(true_value), y - 12.0], [at(true_value), y + 12.0]], DARK, 2.5);
        let words = format!("{value:.digits$} ({low:.digits$} to {high:.digits$})");
        sheet.text([465.0, y + 7.0], Anchor::Start, DARK, &words);
    }
}

/// The friction curve of the front tyre, the weights of its samples and the scatter between stops.
pub fn friction(tables: &Tables) -> String {
    let mut sheet = Sheet::new(1010.0);
    let data = series(tables, "friction_x_front", "data");
    let fit = series(tables, "friction_x_front", "fit");
    let [peak, low, high] = tables.coefficient("front", "mf_d");

    sheet.step(
        10.0,
        "1",
        "Samples and curve",
        "five stops with the front brake; curve (28), 95 % interval",
    );
    let panel = Panel {
        left: 70.0,
        top: 100.0,
        width: 620.0,
        height: 300.0,
        x: [0.0, 0.42],
        y: [0.0, 1.25],
    };
    let ticks = [(0.0, "0"), (0.1, "0.1"), (0.2, "0.2"), (0.3, "0.3"), (0.4, "0.4")];
    panel.axes(
        &mut sheet,
        &ticks,
        &[(0.0, "0"), (0.5, "0.5"), (1.0, "1")],
        "slip ratio of braking, -s",
    );
    sheet.text([80.0, 94.0], Anchor::Start, DARK, "braking force over load");
    let (x, y) = (negated(&data.x), negated(&data.y));
    let along = negated(&fit.x);
    panel.band(&mut sheet, &along, &negated(&fit.high), &negated(&fit.low), PALE_BLUE);
    sheet.dots(&panel.inside(&x, &y), 3.0, GREY);
    panel.curve(&mut sheet, &along, &negated(&fit.y), BLUE, 3.5);
    let bottom = |y: f64| panel.at(0.0, y)[1];
    sheet.dashed([panel.left, bottom(peak)], [690.0, bottom(peak)], ORANGE);
    let words = format!("peak friction d = {peak:.3} ({low:.3} to {high:.3})");
    sheet.text([685.0, bottom(peak) - 34.0], Anchor::End, ORANGE, &words);
    let at = panel.at(0.055, 0.45);
    sheet.text([at[0] + 14.0, at[1]], Anchor::Start, BLUE, "slope at zero: slip stiffness b c d");

    sheet.step(470.0, "2", "Weights", "a sample far from the curve counts less (Tukey's bisquare)");
    let residual: Vec<f64> =
        (0..x.len()).map(|i| y[i] - interpolated(&along, &negated(&fit.y), x[i])).collect();
    let panel = Panel {
        left: 70.0,
        top: 550.0,
        width: 620.0,
        height: 110.0,
        x: [-0.12, 0.12],
        y: [0.0, 1.1],
    };
    panel.axes(
        &mut sheet,
        &[(-0.1, "-0.1"), (-0.05, "-0.05"), (0.0, "0"), (0.05, "0.05"), (0.1, "0.1")],
        &[(0.0, "0"), (1.0, "1")],
        "distance from the curve",
    );
    sheet.text([80.0, 544.0], Anchor::Start, DARK, "weight");
    sheet.dots(&panel.inside(&residual, &data.weight), 3.5, ORANGE);

    sheet.step(735.0, "3", "Interval", "from the scatter between the stops, not between samples");
    stops(&mut sheet, &data.manoeuvre, &residual);
    sheet.finish(
        "The friction fit of the front tyre: samples and curve, weights, scatter between stops",
    )
}

/// Mean distance from the curve of each stop.
fn stops(sheet: &mut Sheet, manoeuvre: &[f64], residual: &[f64]) {
    let mut ids: Vec<i64> = manoeuvre.iter().map(|m| *m as i64).collect();
    ids.sort_unstable();
    ids.dedup();
    let panel = Panel {
        left: 70.0,
        top: 815.0,
        width: 620.0,
        height: 120.0,
        x: [0.5, ids.len() as f64 + 0.5],
        y: [-0.09, 0.09],
    };
    let labels: Vec<String> = (1..=ids.len()).map(|k| format!("stop {k}")).collect();
    let ticks: Vec<(f64, &str)> =
        labels.iter().enumerate().map(|(k, label)| (k as f64 + 1.0, label.as_str())).collect();
    panel.axes(sheet, &ticks, &[(-0.05, "-0.05"), (0.0, "0"), (0.05, "0.05")], "");
    sheet.text([80.0, 809.0], Anchor::Start, DARK, "distance from the curve; large dots: mean");
    for (k, id) in ids.iter().enumerate() {
        let own: Vec<f64> = manoeuvre
            .iter()
            .zip(residual)
            .filter(|(m, r)| **m as i64 == *id && r.is_finite())
            .map(|(_, r)| *r)
            .collect();
        let n = own.len();
        let place = |i: usize| k as f64 + 1.0 + 0.5 * (i as f64 / n as f64 - 0.5);
        let x: Vec<f64> = (0..n).map(place).collect();
        sheet.dots(&panel.inside(&x, &own), 2.5, GREY);
        let mean = own.iter().sum::<f64>() / n as f64;
        sheet.disc(panel.at(k as f64 + 1.0, mean), 8.0, BLUE);
    }
}

/// A curve's value between its points; NaN outside.
fn interpolated(x: &[f64], y: &[f64], at: f64) -> f64 {
    let within = |k: &usize| (x[*k] - at) * (x[k + 1] - at) <= 0.0;
    (0..x.len() - 1).find(within).map_or(f64::NAN, |k| {
        let share = (at - x[k]) / (x[k + 1] - x[k]);
        y[k] + share * (y[k + 1] - y[k])
    })
}

/// The corner fits of the front tyre: lateral friction, slip angle, and the stiffness from both.
pub fn corner(tables: &Tables) -> String {
    let mut sheet = Sheet::new(1020.0);
    let whole =
        Panel { left: 80.0, top: 0.0, width: 610.0, height: 170.0, x: [0.0, 0.8], y: [0.0, 0.9] };
    let ticks = [(0.0, "0"), (0.2, "0.2"), (0.4, "0.4"), (0.6, "0.6"), (0.8, "0.8")];

    sheet.step(
        10.0,
        "1",
        "Side force over camber (38)",
        "36 steady corners; a fit without any slip angle",
    );
    let panel = Panel { top: 100.0, ..whole };
    panel.axes(
        &mut sheet,
        &ticks,
        &[(0.0, "0"), (0.4, "0.4"), (0.8, "0.8")],
        "camber, rad (left-hand corner: -camber)",
    );
    sheet.text([90.0, 94.0], Anchor::Start, DARK, "side force over load");
    let [ct, low, high] = tables.coefficient("front", "lateral_friction_ct");
    curve_with_samples(&mut sheet, tables, panel, "friction_y_front", 1.0);
    let words = format!("ct = {ct:.3} ({low:.3} to {high:.3})");
    sheet.text([680.0, 255.0], Anchor::End, BLUE, &words);

    sheet.step(350.0, "2", "Slip angle over camber (37)", "a few mrad, less than its noise");
    let panel = Panel { top: 440.0, y: [-22.0, 22.0], ..whole };
    panel.axes(&mut sheet, &ticks, &[(-20.0, "-20"), (0.0, "0"), (20.0, "20")], "camber, rad");
    sheet.text([90.0, 434.0], Anchor::Start, DARK, "slip angle, mrad");
    curve_with_samples(&mut sheet, tables, panel, "slip_angle_front", 1e3);

    sheet.step(
        690.0,
        "3",
        "Cornering stiffness from both (39)",
        "side force = -stiffness x load x (slip angle + C camber)",
    );
    let panel = Panel { top: 780.0, y: [0.0, 20.0], ..whole };
    panel.axes(
        &mut sheet,
        &ticks,
        &[(0.0, "0"), (5.0, "5"), (10.0, "10"), (15.0, "15")],
        "camber, rad",
    );
    sheet.text([90.0, 774.0], Anchor::Start, DARK, "cornering stiffness over load, 1/rad");
    let stiffness = series(tables, "stiffness_front", "k_alpha");
    panel.band(&mut sheet, &stiffness.x, &stiffness.low, &stiffness.high, PALE_BLUE);
    panel.curve(&mut sheet, &stiffness.x, &stiffness.y, BLUE, 3.5);
    let [k, low, high] = tables.coefficient("front", "cornering_stiffness_0");
    let words = format!("upright: {k:.1} ({low:.1} to {high:.1})");
    sheet.text([100.0, panel.at(0.0, 17.2)[1]], Anchor::Start, BLUE, &words);
    let [ratio, low, high] = tables.coefficient("front", "side_force_ratio");
    let words = format!("C = {ratio:.3} ({low:.3} to {high:.3}), from the bike file");
    sheet.text([680.0, panel.at(0.0, 1.5)[1]], Anchor::End, GREY, &words);
    sheet.finish("The corner fit of the front tyre: side force, slip angle and cornering stiffness over camber")
}

/// Samples, fitted curve and interval over the camber's size.
fn curve_with_samples(sheet: &mut Sheet, tables: &Tables, panel: Panel, plot: &str, unit: f64) {
    let scaled = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| unit * v).collect() };
    let data = series(tables, plot, "data");
    let fit = series(tables, plot, "fit");
    let along = negated(&fit.x);
    panel.band(sheet, &along, &scaled(&fit.low), &scaled(&fit.high), PALE_BLUE);
    sheet.dots(&panel.inside(&negated(&data.x), &scaled(&data.y)), 2.5, GREY);
    panel.curve(sheet, &along, &scaled(&fit.y), BLUE, 3.5);
}
