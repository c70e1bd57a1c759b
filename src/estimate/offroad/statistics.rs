//! What a segment's forces come to: peak, mean and spread of each, flights and landings, load
//! transfer, and how much of the load each tyre's grip was worth.

use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::reason::{Reason, ReasonCode};
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::store::tables::rows::{Coefficient, ForceRow, Ident, Provenance, Status};

use super::Estimate;
use super::solve::TyreForces;
use crate::statistics::interval::t95;
use crate::statistics::order::{median, median_and_spread};

/// A longitudinal force smaller than this engages no friction worth the name, N.
const ENGAGED: f64 = 100.0;
/// A load smaller than this is too uncertain to divide by, N.
const LEAST_LOAD: f64 = 150.0;
/// Shortest time of engaged friction that counts in a segment, s.
const LEAST_TIME: f64 = 0.1;
/// How long a landing lasts, s.
const LANDING: f64 = 0.35;

/// Summary figures of one segment beyond those of every segment.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Figures {
    /// Time with both wheels off, s.
    pub flight_time: Option<f64>,
    /// Largest loads of front and rear until `LANDING` after the second wheel's touch-down, N; none where
    /// samples are missing there, because the peak is what a saturated accelerometer hides.
    pub landing: [Option<f64>; 2],
    /// Front's share of the load less that at rest.
    pub load_transfer: Option<f64>,
}

/// A friction of one tyre: name of the force row, tyre, force and load.
struct Friction {
    name: &'static str,
    axle: Axle,
    coefficient: C,
    force: usize,
    load: usize,
}

/// `B_f/N_f`, `B_r/N_r`, `D_r/N_r`.
const FRICTIONS: [Friction; 3] = [
    Friction {
        name: "friction_brake_front",
        axle: Axle::Front,
        coefficient: C::EngagedFrictionBraking,
        force: 2,
        load: 0,
    },
    Friction {
        name: "friction_brake_rear",
        axle: Axle::Rear,
        coefficient: C::EngagedFrictionBraking,
        force: 3,
        load: 1,
    },
    Friction {
        name: "friction_drive_rear",
        axle: Axle::Rear,
        coefficient: C::EngagedFrictionDriving,
        force: 4,
        load: 1,
    },
];

/// The tyre forces by the names of the table `forces`.
const TYRES: [&str; 5] = ["load_front", "load_rear", "brake_front", "brake_rear", "drive_rear"];
/// The rider's, up and forward positive.
const RIDER: [&str; 4] = ["rider_peg_x", "rider_peg_z", "rider_bar_x", "rider_bar_z"];

impl Estimate {
    /// Front's share of the load at rest on level ground, rider on the pegs.
    fn share_at_rest(&self) -> f64 {
        let p = &self.machine.equations.p;
        let [m_1, m_2, m_3, m_4] = p.m;
        let rider = self.machine.rider.mass;
        let arm = m_2 * (p.l_r - p.l_s) + m_3 * p.b + m_4 * p.w + rider * (p.b + p.peg[0]);
        arm / (p.w * (m_1 + m_2 + m_3 + m_4 + rider))
    }

    /// Flight, landing and load transfer of a segment, by the first rider of the settings.
    pub fn figures(&self, segment: &Segment) -> Figures {
        let rate = self.kinematics.rate;
        let (start, end) = (segment.start, segment.end);
        let tyres = &self.riders[0].tyres;
        let flying = self.contact.airborne[start..end].iter().filter(|a| **a).count();
        // until both wheels have been down for a while, and whole
        let down = [&self.contact.front.off, &self.contact.rear.off]
            .map(|off| off[end..].iter().position(|off| !off).map(|d| end + d));
        let landing = [&tyres.n_f, &tyres.n_r].map(|load| {
            let (ManoeuvreKind::Airborne, [Some(front), Some(rear)]) = (segment.kind, down) else {
                return None;
            };
            let window = load.get(end..front.max(rear) + (LANDING * rate) as usize)?;
            let known = window.iter().all(|v| v.is_finite());
            known.then(|| window.iter().copied().fold(0.0, f64::max))
        });
        let (mut front, mut both) = (0.0, 0.0);
        for i in start..end {
            let (f, r) = (tyres.n_f[i], tyres.n_r[i]);
            if (f + r).is_finite() && !self.contact.airborne[i] {
                front += f;
                both += f + r;
            }
        }
        Figures {
            flight_time: (flying > 0).then(|| flying as f64 / rate),
            landing,
            load_transfer: (both > 0.0 && segment.kind != ManoeuvreKind::Airborne)
                .then(|| front / both - self.share_at_rest()),
        }
    }

    /// Rows of the table `forces`: every segment, rider and force.
    pub fn force_rows(&self, segments: &[Segment], ident: &Ident) -> Vec<ForceRow> {
        let mut out = Vec::new();
        for (number, segment) in segments.iter().enumerate() {
            for ridden in &self.riders {
                let row = |force: &str, unit: &str| ForceRow {
                    ident: ident.clone(),
                    manoeuvre_id: number as i64,
                    kind: segment.kind.name().to_owned(),
                    rider: ridden.rider.name().to_owned(),
                    force: force.to_owned(),
                    unit: unit.to_owned(),
                    ..ForceRow::default()
                };
                let (start, end) = (segment.start, segment.end);
                for (name, x) in TYRES.into_iter().zip(ridden.tyres.columns()) {
                    out.push(row(name, "N").of(x[start..end].iter().copied()));
                }
                let f = &ridden.forces;
                for (k, (name, x)) in
                    RIDER.into_iter().zip([&f.lx, &f.lz, &f.ax, &f.az]).enumerate()
                {
                    let up = if k % 2 == 1 { -1.0 } else { 1.0 };
                    out.push(row(name, "N").of(x[start..end].iter().map(|v| up * v)));
                }
                for friction in &FRICTIONS {
                    if let Some(engaged) =
                        engaged(&ridden.tyres, segment, friction, self.kinematics.rate)
                    {
                        out.push(row(friction.name, "1").friction(&engaged));
                    }
                }
            }
        }
        out
    }

    /// Engaged friction of each tyre over the session: the median of the used segments, their
    /// robust spread, and the interval of that median, with what the rider model leaves open: the
    /// change of the median when half of his arms' force goes to his feet counts as one standard
    /// deviation.
    pub fn coefficients(
        &self,
        segments: &[Segment],
        ident: &Ident,
        provenance: &Provenance,
    ) -> Vec<Coefficient> {
        let all = |tyres: &TyreForces, friction: &Friction| -> Vec<Engaged> {
            let used = segments.iter().filter(|s| s.used);
            used.filter_map(|s| engaged(tyres, s, friction, self.kinematics.rate)).collect()
        };
        FRICTIONS
            .iter()
            .map(|friction| {
                let found = all(&self.riders[0].tyres, friction);
                let other = all(&self.half_at_pegs, friction);
                let force = self.riders[0].tyres.columns()[friction.force];
                let possible = force.iter().any(|v| v.is_finite());
                coefficient(friction, possible, &found, &other, ident, provenance)
            })
            .collect()
    }
}

/// Friction that one tyre used in one segment.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Engaged {
    /// Sum of the force over sum of the load.
    mean: f64,
    /// Robust standard deviation of the ratio between samples.
    dispersion: f64,
    /// 99th percentile of the ratio.
    peak: f64,
    samples: usize,
}

fn engaged(
    tyres: &TyreForces,
    segment: &Segment,
    friction: &Friction,
    rate: f64,
) -> Option<Engaged> {
    let columns = tyres.columns();
    let (force, load) = (columns[friction.force], columns[friction.load]);
    let (mut sum, mut weight, mut ratios) = (0.0, 0.0, Vec::new());
    for i in segment.start..segment.end {
        if force[i] > ENGAGED && load[i] > LEAST_LOAD {
            sum += force[i];
            weight += load[i];
            ratios.push(force[i] / load[i]);
        }
    }
    if (ratios.len() as f64) < LEAST_TIME * rate {
        return None;
    }
    ratios.sort_by(f64::total_cmp);
    let peak = ratios[(ratios.len() - 1) * 99 / 100];
    let (_, dispersion) = median_and_spread(&mut ratios)?;
    Some(Engaged { mean: sum / weight, dispersion, peak, samples: ratios.len() })
}

/// Standard error of a median per standard deviation over the root of the count: sqrt(pi / 2).
const MEDIAN: f64 = 1.2533;
/// Widest half interval over the value that is called determined.
const WIDEST: f64 = 0.5;
/// Fewest segments of a reliable interval.
const MIN_SEGMENTS: usize = 4;

fn coefficient(
    friction: &Friction,
    possible: bool,
    found: &[Engaged],
    other: &[Engaged],
    ident: &Ident,
    provenance: &Provenance,
) -> Coefficient {
    let mut means: Vec<f64> = found.iter().map(|e| e.mean).collect();
    let n = means.len();
    let (value, spread) = median_and_spread(&mut means).unzip();
    let spread = spread.filter(|_| n > 1);
    let mut others: Vec<f64> = other.iter().map(|e| e.mean).collect();
    let model = value.zip(median(&mut others)).map_or(0.0, |(value, other)| other - value);
    let sampled = spread.map(|s| MEDIAN * s / (n as f64).sqrt());
    let std_error = sampled.map(|s| s.hypot(model));
    let half = sampled.map(|s| (t95((n - 1) as f64) * s).hypot(1.96 * model));
    let (status, reason) = match n {
        0 if !possible => (
            Status::NotAvailable,
            Some(Reason::new(
                ReasonCode::MissingChannel,
                "the channels do not determine the force, see the warnings",
            )),
        ),
        0 => (
            Status::NotAvailable,
            Some(Reason::new(
                ReasonCode::NoManoeuvre,
                format!(
                    "no segment has {LEAST_TIME} s with more than {ENGAGED:.0} N along the chassis and \
                 {LEAST_LOAD:.0} N of load"
                ),
            )),
        ),
        n if n < MIN_SEGMENTS => (
            Status::PoorlyDetermined,
            Some(Reason::new(
                ReasonCode::FewManoeuvres,
                format!("{n} segments only, of {MIN_SEGMENTS} or more"),
            )),
        ),
        _ if value.zip(half).is_some_and(|(v, h)| h > WIDEST * v.abs()) => {
            let rider = model.abs() > sampled.unwrap_or(0.0);
            let (code, why) = if rider {
                (
                    ReasonCode::UnknownShares,
                    "it depends on how the rider shares his pull between bar and pegs",
                )
            } else {
                (ReasonCode::SegmentsDiffer, "the segments differ too much")
            };
            (
                Status::PoorlyDetermined,
                Some(Reason::new(code, format!("interval wider than half the value: {why}"))),
            )
        }
        _ => (Status::Ok, None),
    };
    let spec = friction.coefficient.spec();
    let mut row = Coefficient {
        ident: ident.clone(),
        tyre: friction.axle.name().to_owned(),
        coefficient: spec.name.to_owned(),
        term: Some(spec.term.to_owned()),
        symbol: spec.symbol.to_owned(),
        value,
        unit: spec.unit.to_owned(),
        std_error,
        ci95_low: value.zip(half).map(|(v, h)| v - h),
        ci95_high: value.zip(half).map(|(v, h)| v + h),
        dispersion: spread,
        n_manoeuvres: n as i64,
        n_samples: found.iter().map(|e| e.samples as i64).sum(),
        residual_scale: None,
        outlier_fraction: None,
        r_squared: None,
        status,
        provenance: provenance.clone(),
        ..Coefficient::default()
    };
    row.explain(reason);
    row
}

impl ForceRow {
    fn of(mut self, x: impl Iterator<Item = f64>) -> Self {
        let (mut n, mut sum, mut squares, mut peak) = (0_i64, 0.0, 0.0, 0.0_f64);
        for v in x.filter(|v| v.is_finite()) {
            n += 1;
            sum += v;
            squares += v * v;
            if v.abs() > peak.abs() {
                peak = v;
            }
        }
        self.n_samples = n;
        if n > 0 {
            let count = n as f64;
            let mean: f64 = sum / count;
            self.mean = Some(mean);
            self.rms = Some((squares / count).sqrt());
            self.dispersion = Some((squares / count - mean * mean).max(0.0).sqrt());
            self.peak = Some(peak);
        }
        self
    }

    fn friction(mut self, e: &Engaged) -> Self {
        self.n_samples = e.samples as i64;
        self.mean = Some(e.mean);
        self.dispersion = Some(e.dispersion);
        self.peak = Some(e.peak);
        self
    }
}
