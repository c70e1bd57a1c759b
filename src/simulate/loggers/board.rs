//! Where loggers' signals come from, and their columns.

use nalgebra::Vector3;

use crate::simulate::ride::Sample;
use crate::simulate::track::ridden::{TrackRide, position};
use crate::statistics::random::{Coloured, Random};

/// A foreign log and what is true of it.
#[derive(Debug, Clone)]
pub struct Foreign {
    /// Name of the file, without folders.
    pub file: String,
    pub text: String,
    /// Delays, nominal radii and the like, as TOML.
    pub truth: String,
}

/// One column of a log.
pub(super) struct Column {
    pub(super) name: &'static str,
    /// By sample of the ride, in the logger's unit.
    pub(super) values: Vec<f64>,
    /// Later than the truth, s.
    pub(super) delay: f64,
    /// White noise, standard deviation.
    pub(super) white: f64,
    /// Step of the digital value; zero has none.
    pub(super) quantum: f64,
    /// Digits after the point.
    pub(super) digits: usize,
    /// An angle is brought back between 0 and this.
    pub(super) circle: Option<f64>,
    /// A step between samples is a step.
    pub(super) held: bool,
}

impl Column {
    pub(super) fn new(name: &'static str, values: Vec<f64>) -> Self {
        Column {
            name,
            values,
            delay: 0.0,
            white: 0.0,
            quantum: 0.0,
            digits: 3,
            circle: None,
            held: false,
        }
    }

    pub(super) fn digits(self, digits: usize) -> Self {
        Column { digits, ..self }
    }

    pub(super) fn step(self, quantum: f64, digits: usize) -> Self {
        Column { quantum, digits, ..self }
    }

    pub(super) fn noisy(self, white: f64) -> Self {
        Column { white, ..self }
    }

    pub(super) fn late(self, delay: f64) -> Self {
        Column { delay, ..self }
    }

    pub(super) fn on_circle(self, circle: f64) -> Self {
        Column { circle: Some(circle), ..self }
    }

    pub(super) fn held(self) -> Self {
        Column { held: true, ..self }
    }

    /// Logged values at a time, s.
    fn at(&self, time: f64, rate: f64, random: &mut Random) -> f64 {
        let last = self.values.len() - 1;
        let place = ((time - self.delay) * rate).clamp(0.0, last as f64);
        let (i, part) = (place as usize, place.fract());
        let next = self.values[(i + 1).min(last)];
        let part = if self.held { 0.0 } else { part };
        let mut x = self.values[i] + part * (next - self.values[i]);
        if self.white > 0.0 {
            x += self.white * random.normal();
        }
        if self.quantum > 0.0 {
            x = (x / self.quantum).round() * self.quantum;
        }
        match self.circle {
            Some(circle) => x.rem_euclid(circle),
            None => x,
        }
    }
}

/// Where the loggers' signals come from.
pub(super) struct Board<'a> {
    pub(super) ridden: &'a TrackRide,
    pub(super) random: Random,
    /// Nominal circumferences that turn wheel spin into speed, m.
    pub(super) circumference: [f64; 2],
}

/// A satellite receiver's view, by sample.
pub(super) struct Satellite {
    /// Speed, m/s.
    pub(super) speed: Vec<f64>,
    /// Clockwise from north, without jumps, degrees.
    pub(super) course: Vec<f64>,
    /// Latitude, degrees.
    pub(super) latitude: Vec<f64>,
    /// Longitude, degrees.
    pub(super) longitude: Vec<f64>,
    /// Altitude, m.
    pub(super) altitude: Vec<f64>,
}

impl<'a> Board<'a> {
    pub(super) fn new(ridden: &'a TrackRide, mut random: Random) -> Self {
        let tyres = ridden.entry.model.motorcycle.tyres.as_ref();
        // the size on the tyre's side, a per cent about its radius, as a whole number of millimetres
        let circumference = [0, 1].map(|k| {
            let radius = tyres.map_or(0.3, |t| t[k].carcass().radius);
            let nominal = std::f64::consts::TAU * radius * (1.0 + 0.01 * random.normal());
            (1000.0 * nominal).round() / 1000.0
        });
        Board { ridden, random, circumference }
    }

    pub(super) fn samples(&self) -> &'a [Sample] {
        &self.ridden.ride.samples
    }

    pub(super) fn rate(&self) -> f64 {
        self.ridden.ride.session.rate
    }

    pub(super) fn column(&self, of: impl Fn(&Sample) -> f64) -> Vec<f64> {
        self.samples().iter().map(of).collect()
    }

    /// Speed of a wheel by its nominal circumference, m/s.
    pub(super) fn wheel_speed(&self, k: usize) -> Vec<f64> {
        let joint =
            [crate::simulate::multibody::joint::FRONT, crate::simulate::multibody::joint::REAR][k];
        let radius = self.circumference[k] / std::f64::consts::TAU;
        self.column(|s| s.rates[joint] * radius)
    }

    /// Engine speed, rev/min.
    pub(super) fn revolutions(&self) -> Vec<f64> {
        self.ridden.hands.iter().map(|h| h.revolutions).collect()
    }

    /// A slowly wandering error, by sample.
    pub(super) fn wander(&mut self, sd: f64, time: f64) -> Vec<f64> {
        let mut noise = Coloured::new(sd, time, 1.0 / self.rate(), &mut self.random);
        (0..self.samples().len()).map(|_| noise.next(&mut self.random)).collect()
    }

    /// Signals of a receiver whose antenna is at a point of the frame (m, from the rear contact), with errors of
    /// speed (m/s) and place (m).
    pub(super) fn satellite(
        &mut self,
        antenna: [f64; 3],
        speed_sd: f64,
        place_sd: f64,
    ) -> Satellite {
        let wander = [0; 3].map(|_| self.wander(place_sd, 60.0));
        let slow = self.wander(speed_sd, 2.0);
        let centre = self.ridden.entry.model.motorcycle.centre();
        let at = Vector3::from(antenna);
        let circuit = &self.ridden.entry.circuit;
        let n = self.samples().len();
        let empty = || Vec::with_capacity(n);
        let mut out = Satellite {
            speed: empty(),
            course: empty(),
            latitude: empty(),
            longitude: empty(),
            altitude: empty(),
        };
        let mut last = 0.0;
        for (i, s) in self.samples().iter().enumerate() {
            let m = &s.motion;
            let v = m.velocity + m.rotation * m.spin.cross(&(at - centre));
            let turned = m.rotation * at;
            let [latitude, longitude] = position([
                s.position[0] + turned.x + wander[0][i],
                s.position[1] + turned.y + wander[1][i],
            ]);
            let direct = 90.0 - v.y.atan2(v.x).to_degrees();
            last += (direct - last + 180.0).rem_euclid(360.0) - 180.0;
            out.speed.push(v.x.hypot(v.y) + slow[i]);
            out.course.push(last);
            out.latitude.push(latitude);
            out.longitude.push(longitude);
            let along = self.ridden.hands[i].along;
            let height = circuit.value(&circuit.altitude, along);
            out.altitude.push(48.0 + height + turned.z + 2.0 * wander[2][i]);
        }
        out
    }

    /// The rows of the columns at a rate (Hz), cells joined by `separator`; `head` makes the first cells of a row
    /// of its time, s.
    pub(super) fn rows(
        &mut self,
        columns: &[Column],
        rate: f64,
        separator: &str,
        head: impl Fn(f64) -> String,
    ) -> String {
        use std::fmt::Write as _;
        let length = self.samples().len() as f64 / self.rate();
        let own = self.rate();
        let mut text = String::new();
        for k in 0..(length * rate) as usize {
            let time = k as f64 / rate;
            text.push_str(&head(time));
            for column in columns {
                let x = column.at(time, own, &mut self.random);
                // no cell says minus nothing
                let x = if x.abs() < 0.5 * 10_f64.powi(-(column.digits as i32)) { 0.0 } else { x };
                let _ = write!(text, "{separator}{x:.*}", column.digits);
            }
            text.push('\n');
        }
        text
    }

    /// Delays of the columns that are late, and the nominal circumferences, as TOML.
    pub(super) fn truth(&self, columns: &[Column], more: &str) -> String {
        let mut text = format!(
            "# what is true of this log\ncircumference = [{:?}, {:?}] # m, front and rear\n{more}[delay] # s\n",
            self.circumference[0], self.circumference[1]
        );
        for c in columns.iter().filter(|c| c.delay > 0.0) {
            text.push_str(&format!("{:?} = {}\n", c.name, c.delay));
        }
        text
    }
}
