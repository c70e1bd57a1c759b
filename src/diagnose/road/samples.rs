//! A session's manoeuvres at 10 Hz: smoothed signals and their derivatives, block by block.

use std::ops::Range;

use super::around::Around;
use super::dive::{NOISY, beyond, usual_pitch};
use super::replay::bridged;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::effects::ride::{Brakes, acting_pressure, along_strip, brake_history};
use crate::statistics::smooth::{gradient, mean_twice, smooth};

/// Samples per second.
pub(crate) const RATE: f64 = 10.0;
/// Samples of a block: residuals are their means.
pub(crate) const BLOCK: usize = 3;
/// Left out at the start of every manoeuvre, s: what came before still acts.
const TRIM: f64 = 0.2;
/// Slip ratio from which a wheel is on its way to lock or spin.
const DEEP: f64 = 0.15;
/// Time left out around it, s.
const AROUND: f64 = 0.2;
/// Least speed, m/s: below it slips are too inaccurate.
const SLOWEST: f64 = 4.0;

macro_rules! samples {
    (one: { $($(#[$doc:meta])* $column:ident,)* } two: { $($pair:ident,)* }) => {
        /// Signals of the residuals, sample by sample, SI, ISO 8855; missing channels are NaN.
        #[derive(Debug, Clone, Default)]
        #[allow(missing_docs)] // a signal and, with `d`, its derivative by time
        pub struct Samples {
            /// Samples of a block.
            pub block: usize,
            $($(#[$doc])* pub $column: Vec<f64>,)*
            $(pub $pair: [Vec<f64>; 2],)*
            /// Heat in the brakes.
            pub brakes: Vec<Brakes>,
            /// One per manoeuvre: its kind and its samples, whole blocks.
            pub manoeuvres: Vec<(ManoeuvreKind, Range<usize>)>,
        }

        impl Samples {
            /// The same columns with other rows: `rows` makes a column of a column.
            fn with_rows(
                &self,
                rows: impl Fn(&Vec<f64>) -> Vec<f64>,
                brakes: Vec<Brakes>,
                manoeuvres: Vec<(ManoeuvreKind, Range<usize>)>,
            ) -> Samples {
                Samples {
                    block: self.block,
                    $($column: rows(&self.$column),)*
                    $($pair: self.$pair.each_ref().map(&rows),)*
                    brakes,
                    manoeuvres,
                }
            }
        }
    };
}

samples! {
    one: {
        time,
        v,
        vd,
        /// With little of the sensor's noise, as `vdd`: what a delay is multiplied by. More noise in it than in the velocity
        /// would make every delay small.
        vd_quiet,
        vdd,
        vy,
        vyd,
        vyd_quiet,
        vydd,
        ax,
        ay,
        roll,
        rolld,
        rolldd,
        yaw_rate,
        yaw_rated,
        steer,
        /// Where along the strip, for what depends on heading: cosine of the heading against the
        /// session's first straight, NaN without heading.
        along,
        /// Grade of the road, uphill positive; 0 where nothing shows it.
        grade,
        /// Pitch beyond the usual one, rad ([`dive`](super::dive)).
        dive,
        dived,
        divedd,
    }
    two: {
        omega,
        omegad,
        pressure,
    }
}

impl Samples {
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    pub fn blocks(&self) -> usize {
        self.len() / self.block
    }

    /// Time from a sample of a manoeuvre to the next, s.
    pub fn step(&self) -> f64 {
        (BLOCK / self.block) as f64 / RATE
    }

    /// The means of every block as a sample. Residuals of them are block means of residuals but for what bends within
    /// a block: near enough for slopes, at a third of the work.
    pub fn means(&self) -> Samples {
        let n = self.block as f64;
        let of = |x: &Vec<f64>| -> Vec<f64> {
            x.chunks_exact(self.block).map(|block| block.iter().sum::<f64>() / n).collect()
        };
        let block = |i: usize| i / self.block;
        let ranges = self.manoeuvres.iter();
        let manoeuvres = ranges.map(|(kind, r)| (*kind, block(r.start)..block(r.end))).collect();
        // heat that begins anew within a block has no mean
        let brakes = self.brakes.chunks_exact(self.block).map(|b| b[self.block / 2]).collect();
        Samples { block: 1, ..self.with_rows(of, brakes, manoeuvres) }
    }

    /// The samples of the used manoeuvres of an unfiltered session.
    pub fn gather(session: &Session, segments: &[Segment]) -> Self {
        Self::take(session, &picks(session, segments))
    }

    /// Picked samples of a session.
    pub fn take(session: &Session, picks: &[(ManoeuvreKind, Vec<usize>)]) -> Self {
        let rate = session.rate;
        let around = Around::of(session, picks);
        let near = &around.session;
        let n = near.len;
        let missing = || vec![f64::NAN; n];
        let smoothed = |c: Channel| near.get(c).map_or_else(missing, |x| smooth(x, rate));
        let column = |c: Channel| {
            let x = smoothed(c);
            let d = gradient(&x, rate);
            (x, d)
        };
        let (v, vd) = column(Channel::VelocityX);
        let (vy, vyd) = column(Channel::VelocityY);
        let (roll, rolld) = column(Channel::Roll);
        let rolldd = gradient(&smooth(&rolld, rate), rate);
        let quiet = |d: &[f64]| mean_twice(&bridged(d.to_vec()), rate, NOISY);
        let [vd_quiet, vyd_quiet] = [&vd, &vyd].map(|d| quiet(d));
        let [vdd, vydd] = [&vd_quiet, &vyd_quiet].map(|d| gradient(d, rate));
        let (yaw_rate, yaw_rated) = column(Channel::YawRate);
        let (front, front_rate) = column(Channel::WheelSpeedFront);
        let (rear, rear_rate) = column(Channel::WheelSpeedRear);
        let [ax, ay] = [Channel::AccelerationX, Channel::AccelerationY].map(smoothed);
        let steer = smoothed(Channel::SteerAngle);
        let pressure = [Channel::BrakePressureFront, Channel::BrakePressureRear]
            .map(|c| acting_pressure(&smoothed(c), rate));
        let grade = near.get(Channel::Grade).map_or_else(|| vec![0.0; n], <[f64]>::to_vec);
        // what depends on the whole ride
        let brakes = around.only(brake_history(session), Brakes::default());
        let along = around.only(along_strip(session).into_iter(), f64::NAN);
        let usual = usual_pitch(session);
        let dive =
            usual.map_or_else(|| vec![0.0; n], |usual| beyond(&smoothed(Channel::Pitch), usual));
        let dived = gradient(&mean_twice(&dive, rate, NOISY), rate);
        let divedd = gradient(&dived, rate);
        let all = Samples {
            block: BLOCK,
            time: Vec::new(), // of the picked ones, below
            v,
            vd,
            vd_quiet,
            vdd,
            vy,
            vyd,
            vyd_quiet,
            vydd,
            ax,
            ay,
            roll,
            rolld,
            rolldd,
            yaw_rate,
            yaw_rated,
            steer,
            along,
            grade,
            dive,
            dived,
            divedd,
            omega: [front, rear],
            omegad: [front_rate, rear_rate],
            pressure,
            brakes,
            manoeuvres: Vec::new(),
        };
        let picked = || picks.iter().flat_map(|(_, chosen)| chosen.iter().copied());
        let rows: Vec<usize> = picked().map(|i| around.position(i)).collect();
        let mut manoeuvres = Vec::with_capacity(picks.len());
        let mut start = 0;
        for (kind, chosen) in picks {
            manoeuvres.push((*kind, start..start + chosen.len()));
            start += chosen.len();
        }
        let of = |x: &Vec<f64>| match x.is_empty() {
            true => Vec::new(),
            false => rows.iter().map(|&i| x[i]).collect(),
        };
        let brakes = rows.iter().map(|&i| all.brakes[i]).collect();
        let time = picked().map(|i| i as f64 / rate).collect();
        Samples { time, ..all.with_rows(of, brakes, manoeuvres) }
    }
}

/// Which samples of a session are looked at: per manoeuvre, whole blocks of them.
pub fn picks(session: &Session, segments: &[Segment]) -> Vec<(ManoeuvreKind, Vec<usize>)> {
    let rate = session.rate;
    let smoothed = |c: Channel| session.get(c).map(|x| smooth(x, rate));
    let (Some(v), Some(ax)) = (smoothed(Channel::VelocityX), smoothed(Channel::AccelerationX))
    else {
        return Vec::new();
    };
    let vd = gradient(&v, rate);
    let deep = deep(session, &v);
    let step = (rate / RATE).round().max(1.0) as usize;
    let usable = |i: &usize| v[*i] > SLOWEST && (ax[*i] + vd[*i]).is_finite() && !deep[*i];
    segments
        .iter()
        .filter(|s| s.used && s.kind.is_on_road())
        .map(|segment| {
            let from = segment.start + (TRIM * rate) as usize;
            let mut chosen: Vec<usize> =
                (from..segment.end.min(session.len)).step_by(step).filter(usable).collect();
            chosen.truncate(chosen.len() / BLOCK * BLOCK);
            (segment.kind, chosen)
        })
        .filter(|(_, chosen)| !chosen.is_empty())
        .collect()
}

/// Where a wheel is about to lock or to spin, and shortly before and after: slip changes within the
/// smoother's window, and no block mean is what it was.
fn deep(session: &Session, v: &[f64]) -> Vec<bool> {
    let mut deep = vec![false; session.len];
    let reach = (AROUND * session.rate) as usize;
    for channel in [Channel::WheelSpeedFront, Channel::WheelSpeedRear] {
        let Some(omega) = session.get(channel) else { continue };
        let ratio = |i: usize| omega[i] / v[i];
        let mut rolling: Vec<f64> = (0..session.len)
            .filter(|&i| v[i] > SLOWEST)
            .map(ratio)
            .filter(|r| r.is_finite())
            .collect();
        if rolling.is_empty() {
            continue;
        }
        let middle = rolling.len() / 2;
        let usual = *rolling.select_nth_unstable_by(middle, f64::total_cmp).1;
        for i in 0..session.len {
            if v[i] > SLOWEST && (ratio(i) / usual - 1.0).abs() > DEEP {
                deep[i.saturating_sub(reach)..(i + reach + 1).min(session.len)].fill(true);
            }
        }
    }
    deep
}
