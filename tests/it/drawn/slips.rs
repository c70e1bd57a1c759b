//! What slip ratio, slip angle and camber are, at moments of the ride.

use super::svg::{Anchor, BLUE, DARK, GREEN, GREY, ORANGE, PALE, Panel, Sheet};
use super::table::{Table, Tables};

/// Wheel speeds and slips of one stretch of the ride.
struct Stretch {
    time: Vec<f64>,
    speed: Vec<f64>,
    slip: Vec<f64>,
    angle: Vec<f64>,
    camber: Vec<f64>,
}

fn within(signals: &Table, [start, end]: [f64; 2]) -> Stretch {
    let time = signals.numbers("time");
    let places: Vec<usize> =
        (0..time.len()).filter(|i| time[*i] >= start && time[*i] <= end).collect();
    let [time, speed, slip, angle, camber] =
        ["time", "velocity_x", "slip_ratio_front", "slip_angle_front", "camber_front"]
            .map(|name| signals.at(name, &places));
    Stretch { time, speed, slip, angle, camber }
}

/// Slips and cambers: three sketches and the same quantities in a stop and in a corner.
pub fn slips_and_cambers(tables: &Tables) -> String {
    let mut sheet = Sheet::new(1220.0);
    let signals = tables.of_run("signals");
    let stop = within(&signals, tables.manoeuvres("front_braking")[0]);
    // the tightest corner shows camber best
    let corners = tables.manoeuvres("cornering");
    let corners = corners.into_iter().map(|span| within(&signals, span));
    let lean = |s: &Stretch| s.camber.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let corner = corners.max_by(|a, b| lean(a).total_cmp(&lean(b))).expect("a corner");

    sheet.step(10.0, "1", "Slip ratio", "from the side: the braked wheel turns too slowly");
    slip_ratio(&mut sheet, &stop);
    sheet.step(440.0, "2", "Camber", "from behind: the wheel leans by the camber angle");
    camber(&mut sheet, &corner);
    sheet.step(850.0, "3", "Slip angle", "from above: the wheel does not go where it points");
    slip_angle(&mut sheet, &corner);
    sheet.finish(
        "Slip ratio, camber and slip angle, with values of a stop and a corner of archive_s0001",
    )
}

fn seconds(s: &Stretch) -> Vec<f64> {
    s.time.iter().map(|t| t - s.time[0]).collect()
}

fn graph(top: f64, x: [f64; 2], y: [f64; 2]) -> Panel {
    Panel { left: 330.0, top, width: 370.0, height: 110.0, x, y }
}

const SECONDS: [(f64, &str); 2] = [(0.0, "0"), (1.0, "1")];

fn slip_ratio(sheet: &mut Sheet, stop: &Stretch) {
    // where the wheel is a fifth slower than the road
    let off = |i: &usize| (stop.slip[*i] + 0.2).abs();
    let i = (0..stop.slip.len()).min_by(|a, b| off(a).total_cmp(&off(b))).expect("a sample");
    let (v, s) = (stop.speed[i], stop.slip[i]);
    let hub = [120.0, 180.0];
    sheet.ring(hub, 72.0, DARK, 9.0);
    sheet.disc(hub, 6.0, DARK);
    sheet.line(&[[20.0, 257.0], [290.0, 257.0]], GREY, 2.5);
    let scale = 11.0;
    sheet.arrow(hub, [hub[0] + scale * v, hub[1]], BLUE);
    sheet.text([hub[0] + 34.0, hub[1] - 12.0], Anchor::Start, BLUE, "v");
    sheet.arrow([hub[0], 282.0], [hub[0] + scale * v * (1.0 + s), 282.0], ORANGE);
    sheet.text([hub[0] - 8.0, 289.0], Anchor::End, ORANGE, "R omega");
    let words = format!("s = R omega / v - 1 = {s:.2}");
    sheet.text([16.0, 330.0], Anchor::Start, DARK, &words);
    sheet.text(
        [16.0, 358.0],
        Anchor::Start,
        GREY,
        &format!("v {v:.1} m/s, R omega {:.1}", v * (1.0 + s)),
    );

    let end = seconds(stop).last().copied().unwrap_or(1.0);
    let speeds = graph(100.0, [0.0, end], [0.0, 24.0]);
    speeds.axes(sheet, &[], &[(0.0, "0"), (20.0, "20")], "");
    let wheel: Vec<f64> = stop.speed.iter().zip(&stop.slip).map(|(v, s)| v * (1.0 + s)).collect();
    speeds.curve(sheet, &seconds(stop), &stop.speed, BLUE, 3.0);
    speeds.curve(sheet, &seconds(stop), &wheel, ORANGE, 3.0);
    sheet.text([338.0, 94.0], Anchor::Start, DARK, "v and R omega in a stop, m/s");
    let slips = graph(250.0, [0.0, end], [-0.42, 0.02]);
    slips.axes(
        sheet,
        &SECONDS,
        &[(0.0, "0"), (-0.2, "-0.2"), (-0.4, "-0.4")],
        "time in the stop, s",
    );
    slips.curve(sheet, &seconds(stop), &stop.slip, ORANGE, 3.0);
    sheet.disc(slips.at(stop.time[i] - stop.time[0], s), 6.0, DARK);
    sheet.text([338.0, 244.0], Anchor::Start, DARK, "slip ratio s");
}

/// The sample in the middle of a corner.
fn middle(corner: &Stretch) -> usize {
    corner.time.len() / 2
}

fn camber(sheet: &mut Sheet, corner: &Stretch) {
    let i = middle(corner);
    let gamma = corner.camber[i];
    let foot = [190.0, 710.0];
    let along = |length: f64, side: f64| {
        let (sin, cos) = gamma.sin_cos();
        [foot[0] + length * sin + side * cos, foot[1] - length * cos + side * sin]
    };
    sheet.line(&[[30.0, 712.0], [300.0, 712.0]], GREY, 2.5);
    sheet.dashed(foot, [foot[0], 530.0], GREY);
    let rim: Vec<[f64; 2]> = (0..=40)
        .map(|k| {
            let turn = std::f64::consts::TAU * f64::from(k) / 40.0;
            along(75.0 + 75.0 * turn.cos(), 16.0 * turn.sin())
        })
        .collect();
    sheet.area(&rim, DARK);
    sheet.arrow(along(0.0, 0.0), along(180.0, 0.0), GREEN);
    let arc: Vec<[f64; 2]> = (0..=20)
        .map(|k| {
            let turn = gamma * f64::from(k) / 20.0;
            [foot[0] + 168.0 * turn.sin(), foot[1] - 168.0 * turn.cos()]
        })
        .collect();
    sheet.line(&arc, GREEN, 3.0);
    sheet.text([foot[0] + 12.0, 550.0], Anchor::Start, GREEN, "gamma");
    let words = format!("gamma = {:.1}°", gamma.to_degrees());
    sheet.text([16.0, 750.0], Anchor::Start, DARK, &words);
    sheet.text([16.0, 778.0], Anchor::Start, GREY, "left-hand corner: negative");

    let end = seconds(corner).last().copied().unwrap_or(1.0);
    let panel = Panel { height: 220.0, ..graph(530.0, [0.0, end], [-45.0, 5.0]) };
    let ticks = [(0.0, "0"), (2.0, "2"), (4.0, "4"), (6.0, "6")];
    panel.axes(
        sheet,
        &ticks,
        &[(0.0, "0"), (-20.0, "-20"), (-40.0, "-40")],
        "time in the corner, s",
    );
    let degrees: Vec<f64> = corner.camber.iter().map(|c| c.to_degrees()).collect();
    panel.curve(sheet, &seconds(corner), &degrees, GREEN, 3.0);
    sheet.disc(panel.at(corner.time[i] - corner.time[0], degrees[i]), 6.0, DARK);
    sheet.text([338.0, 524.0], Anchor::Start, DARK, "camber, front wheel, degrees");
}

fn slip_angle(sheet: &mut Sheet, corner: &Stretch) {
    let known: Vec<f64> = corner.angle.iter().copied().filter(|a| a.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    // far too small to be seen at its own size
    let shown = 0.35 * mean.signum();
    let centre = [150.0, 1060.0];
    let turned = |angle: f64, length: f64, side: f64| {
        let (sin, cos) = angle.sin_cos();
        [centre[0] - length * sin + side * cos, centre[1] - length * cos - side * sin]
    };
    let outline: Vec<[f64; 2]> = (0..=40)
        .map(|k| {
            let turn = std::f64::consts::TAU * f64::from(k) / 40.0;
            turned(0.0, 66.0 * turn.cos(), 17.0 * turn.sin())
        })
        .collect();
    sheet.area(&outline, PALE);
    sheet.line(&outline, DARK, 3.0);
    sheet.dashed(centre, turned(0.0, 140.0, 0.0), DARK);
    sheet.arrow(centre, turned(shown, 135.0, 0.0), BLUE);
    let side = if shown < 0.0 { Anchor::Start } else { Anchor::End };
    let tip = turned(shown, 120.0, 0.0);
    sheet.text([tip[0] - 14.0 * shown.signum(), tip[1]], side, BLUE, "path");
    sheet.text(
        [centre[0] - 12.0 * -shown.signum(), 925.0],
        if shown < 0.0 { Anchor::End } else { Anchor::Start },
        DARK,
        "wheel",
    );
    let words = format!("alpha = {:.2}° on average", mean.to_degrees());
    sheet.text([16.0, 1170.0], Anchor::Start, DARK, &words);
    sheet.text([16.0, 1198.0], Anchor::Start, GREY, "drawn far larger");

    let end = seconds(corner).last().copied().unwrap_or(1.0);
    let panel = Panel { height: 220.0, ..graph(940.0, [0.0, end], [-1.0, 1.0]) };
    let ticks = [(0.0, "0"), (2.0, "2"), (4.0, "4"), (6.0, "6")];
    panel.axes(sheet, &ticks, &[(0.0, "0"), (-1.0, "-1"), (1.0, "1")], "time in the corner, s");
    let degrees: Vec<f64> = corner.angle.iter().map(|c| c.to_degrees()).collect();
    panel.curve(sheet, &seconds(corner), &degrees, BLUE, 3.0);
    sheet.text([338.0, 934.0], Anchor::Start, DARK, "slip angle, front wheel, degrees");
}
