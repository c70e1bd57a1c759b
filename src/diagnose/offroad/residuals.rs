//! Residuals that no tyre force can make go away.
//!
//! Five equations, and fewer unknown tyre forces: with both wheels on the ground three while driving (a
//! free front wheel rolls, what spins it up is known) and four while braking; in flight none. The
//! remainder is linear in the known side, `r = w . (b_1 - A_r f_r)`, with a covector `w` per sample:
//!
//! | channel | where | rows solved for the forces | row left over |
//! |---|---|---|---|
//! | `vertical` | driving | x, fork, swing arm | z |
//! | `pitch` | driving | x, fork, swing arm | pitch |
//! | `pitch_braking` | braking | x, z, fork, swing arm | pitch |
//! | `flight_vertical`, `flight_pitch` | both wheels off | none | z, pitch |
//! | `fork_free`, `swing_arm_free` | that wheel off | none | fork, swing arm |
//!
//! They are averaged over blocks of a tenth of a second: motion of the rider up to 5 Hz passes.
//! The contact is the ground's own ([`ground`]), not the chassis'.

use std::ops::Range;

use super::ground;
use crate::GRAVITY;
use crate::estimate::offroad::Estimate;
use crate::estimate::offroad::rider;
use crate::motorcycle::offroad::equations::Matrices;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Samples per second that the residuals are made from.
const RATE: f64 = 200.0;
/// Length of a block, s.
const BLOCK: f64 = 0.1;
/// Share of a block that must lie in the channel's kind of motion.
const SHARE: f64 = 0.5;

/// One kind of residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Channel {
    pub name: &'static str,
    /// Unit of the residual.
    pub unit: &'static str,
    /// Rows of the equations without which it is not there.
    rows: &'static [usize],
}

impl Channel {
    /// Whether a wheel is off the ground, so that no rider enters.
    pub(crate) fn off_the_ground(&self) -> bool {
        self.rows.len() == 1
    }
}

pub(crate) const CHANNELS: [Channel; 7] = [
    Channel { name: "vertical", unit: "N", rows: &[0, 1, 3, 4] },
    Channel { name: "pitch", unit: "N m", rows: &[0, 2, 3, 4] },
    Channel { name: "pitch_braking", unit: "N m", rows: &[0, 1, 2, 3, 4] },
    Channel { name: "flight_vertical", unit: "N", rows: &[1] },
    Channel { name: "flight_pitch", unit: "N m", rows: &[2] },
    Channel { name: "fork_free", unit: "N", rows: &[3] },
    Channel { name: "swing_arm_free", unit: "N m", rows: &[4] },
];

/// A block of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    /// Index into [`CHANNELS`].
    pub channel: usize,
    /// Middle, in samples of the log.
    pub at: usize,
    /// Jump, whoops or corner that it belongs to.
    pub cluster: usize,
    /// Manoeuvre of the block.
    pub kind: ManoeuvreKind,
    /// One over the number of its samples.
    share: f64,
}

/// A sample's part in a block.
#[derive(Debug, Clone, Copy)]
struct Part {
    block: usize,
    /// In the thinned series.
    sample: usize,
    w: [f64; 5],
    driving: bool,
}

/// The residuals of a ride, ready for any rider and any change of the bike.
#[derive(Debug, Clone)]
pub(crate) struct Residuals {
    /// Blocks, channel by channel, in time order.
    pub blocks: Vec<Block>,
    pub clusters: usize,
    /// The bike without a rider: residual of every block.
    pub bike: Vec<f64>,
    /// Hz of the thinned series.
    pub rate: f64,
    /// Accelerations of the chassis forward and down, thinned, m/s².
    pub acceleration: [Vec<f64>; 2],
    /// How far riders B and C hold on, thinned.
    pub hold: Vec<f64>,
    /// Row 3 of `A_r`, thinned.
    pub levers: Vec<[f64; 4]>,
    /// Samples of the log per thinned one.
    pub step: usize,
    parts: Vec<Part>,
}

impl Residuals {
    /// The residuals of an estimate whose first rider tells driving from braking.
    pub(crate) fn new(e: &Estimate, segments: &[Segment], crossfade: f64) -> Self {
        let k = &e.kinematics;
        let machine = &e.machine;
        let step = (k.rate / RATE).round().max(1.0) as usize;
        let rate = k.rate / step as f64;
        let n = k.len() / step;
        let base = rider::Base {
            rate: k.rate,
            mu: &k.mu,
            mud: &k.mud,
            xdd: &k.xdd,
            zdd: &k.zdd,
            airborne: &e.contact.airborne,
        };
        let thin = |x: &[f64]| -> Vec<f64> { x.iter().copied().step_by(step).take(n).collect() };
        let hold = thin(&rider::hold(&base, crossfade));
        let (of_sample, clusters) = clusters(segments, k.rate, k.len());
        let there: Vec<bool> =
            CHANNELS.iter().map(|c| c.rows.iter().all(|&r| !k.lost[r])).collect();
        let mut levers = Vec::with_capacity(n);
        let mut known = Vec::with_capacity(n);
        let mut covectors: Vec<[Option<[f64; 5]>; 7]> = Vec::with_capacity(n);
        let mut driving = Vec::with_capacity(n);
        for j in 0..n {
            let i = j * step;
            let at = machine.equations.at(&k.motion(i));
            levers.push(at.ar);
            let state = State::of(e, i);
            let b = right(machine, e, &at, i, state == Some(State::Driving));
            driving.push(state == Some(State::Driving));
            let mut w = state.map_or([None; 7], |s| {
                s.covectors(&ground::columns(&machine.equations, k, &at, i), machine, e, i)
            });
            if !b.iter().all(|v| v.is_finite()) {
                w = [None; 7];
            }
            for (w, there) in w.iter_mut().zip(&there) {
                if !there {
                    *w = None;
                }
            }
            covectors.push(w);
            known.push(b);
        }
        let long = (BLOCK * rate).round().max(1.0) as usize;
        let samples = Samples { covectors: &covectors, driving: &driving, step };
        let (blocks, parts) = samples.blocks(long, segments, of_sample);
        let mut out = Residuals {
            blocks,
            clusters,
            bike: Vec::new(),
            rate,
            acceleration: [thin(&k.xdd), thin(&k.zdd)],
            hold,
            levers,
            step,
            parts,
        };
        out.bike = out.response(|j, _| known[j]);
        out
    }

    /// Change of every block when the known side changes by `db` (rows 1 to 5, N and N m) at each thinned
    /// sample; the second argument tells whether the sample drives.
    pub(crate) fn response(&self, db: impl Fn(usize, bool) -> [f64; 5]) -> Vec<f64> {
        let mut out = vec![0.0; self.blocks.len()];
        for part in &self.parts {
            let d = db(part.sample, part.driving);
            let w = &part.w;
            let sum = w[0] * d[0] + w[1] * d[1] + w[2] * d[2] + w[3] * d[3] + w[4] * d[4];
            out[part.block] += sum * self.blocks[part.block].share;
        }
        out
    }

    /// Standard deviation of every channel's blocks for errors of the known side of these standard
    /// deviations, N and N m, of a band of `high_cut` Hz.
    pub(crate) fn sensor_noise(&self, covariance: &[[f64; 5]; 5], high_cut: f64) -> [f64; 7] {
        // white below the cut; a block's mean passes half a band of one over its length
        let passed = (0.5 / BLOCK / high_cut).min(1.0);
        let (mut sums, mut counts) = ([0.0; 7], [0.0; 7]);
        for part in &self.parts {
            let w = &part.w;
            let variance: f64 =
                (0..5).map(|i| (0..5).map(|j| w[i] * covariance[i][j] * w[j]).sum::<f64>()).sum();
            let channel = self.blocks[part.block].channel;
            sums[channel] += variance;
            counts[channel] += 1.0;
        }
        std::array::from_fn(|c| (passed * sums[c] / f64::max(counts[c], 1.0)).sqrt())
    }
}

/// Thinned samples with the residual of each.
struct Samples<'a> {
    covectors: &'a [[Option<[f64; 5]>; 7]],
    driving: &'a [bool],
    /// Samples of the log per thinned one.
    step: usize,
}

impl Samples<'_> {
    /// The blocks of `long` samples that lie in a channel's kind of motion, and their samples.
    fn blocks(
        &self,
        long: usize,
        segments: &[Segment],
        cluster_of: impl Fn(usize) -> usize,
    ) -> (Vec<Block>, Vec<Part>) {
        let n = self.covectors.len();
        let (mut blocks, mut parts): (Vec<Block>, Vec<Part>) = (Vec::new(), Vec::new());
        for channel in 0..CHANNELS.len() {
            for start in (0..n.saturating_sub(long - 1)).step_by(long) {
                let inside: Vec<(usize, [f64; 5])> = (start..start + long)
                    .filter_map(|j| self.covectors[j][channel].map(|w| (j, w)))
                    .collect();
                if (inside.len() as f64) < SHARE * long as f64 {
                    continue;
                }
                let at = (start + long / 2) * self.step;
                let kind = segments
                    .iter()
                    .find(|s| (s.start..s.end).contains(&at))
                    .map_or(ManoeuvreKind::Other, |s| s.kind);
                let block = blocks.len();
                let share = 1.0 / inside.len() as f64;
                blocks.push(Block { channel, at, cluster: cluster_of(at), kind, share });
                parts.extend(inside.into_iter().map(|(sample, w)| Part {
                    block,
                    sample,
                    w,
                    driving: self.driving[sample],
                }));
            }
        }
        (blocks, parts)
    }
}

/// `b_1` without a rider, with air and, while driving, the chain's share of the wheel's spin.
fn right(
    machine: &PlanarMotorcycle,
    e: &Estimate,
    at: &Matrices,
    i: usize,
    driving: bool,
) -> [f64; 5] {
    let k = &e.kinematics;
    let mut b = at.known(
        &[k.xdd[i], k.zdd[i], k.mudd[i], k.zdd_f[i], k.add_r[i]],
        [k.f_sf[i], k.t_sr[i]],
        GRAVITY,
    );
    let speed = k.xd[i];
    if speed.is_finite() {
        b[0] += machine.drag * speed * speed.abs();
    }
    if driving {
        let p = &machine.equations.p;
        let kappa = machine.chain.kappa(&machine.equations, k.a_r[i]);
        b[4] += kappa * p.i[0] * (k.mudd[i] - k.add_r[i] + k.mu1dd[i]);
        // what spins the free front wheel up
        let rolling = p.i[3] * (k.mudd[i] + k.mu4dd[i]) / p.r_f;
        let columns = ground::columns(&machine.equations, k, at, i);
        for (b, row) in b.iter_mut().zip(&columns) {
            *b -= row[2] * rolling;
        }
    }
    b
}

/// Around a take-off or landing no residual is taken, s.
const EDGE: f64 = 0.03;

/// How a sample moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Driving,
    Braking,
    Off { front: bool, rear: bool },
}

impl State {
    fn of(e: &Estimate, i: usize) -> Option<State> {
        let [front, rear] = [e.contact.front.fade[i], e.contact.rear.fade[i]];
        // a take-off or landing is not known to the sample
        let by = (EDGE * e.kinematics.rate) as usize;
        let same = |off: &[bool]| {
            let other = [i.saturating_sub(by), (i + by).min(off.len() - 1)];
            other.iter().all(|&j| off[j] == off[i])
        };
        if !(same(&e.contact.front.off) && same(&e.contact.rear.off)) {
            return None;
        }
        match (front >= 1.0, rear >= 1.0) {
            (false, false) if front > 0.0 || rear > 0.0 => None,
            (false, false) => {
                let tyres = &e.riders.first()?.tyres;
                match (tyres.d_r[i] > 0.0, tyres.b_f[i] + tyres.b_r[i] > 0.0) {
                    (true, _) => Some(State::Driving),
                    (_, true) => Some(State::Braking),
                    _ => None,
                }
            }
            (front, rear) => Some(State::Off { front, rear }),
        }
    }

    fn covectors(
        self,
        columns: &[[f64; 4]; 5],
        machine: &PlanarMotorcycle,
        e: &Estimate,
        i: usize,
    ) -> [Option<[f64; 5]>; 7] {
        let mut out = [None; 7];
        let unit = |row: usize| -> [f64; 5] { std::array::from_fn(|k| f64::from(k == row)) };
        match self {
            State::Driving => {
                let p = &machine.equations.p;
                let kappa = machine.chain.kappa(&machine.equations, e.kinematics.a_r[i]);
                let mut a: [[f64; 3]; 5] =
                    std::array::from_fn(|r| [columns[r][0], columns[r][1], columns[r][3]]);
                a[4][2] += kappa * p.r_r;
                out[0] = left_over(&a, [0, 3, 4], 1);
                out[1] = left_over(&a, [0, 3, 4], 2);
            }
            State::Braking => out[2] = left_over(columns, [0, 1, 3, 4], 2),
            State::Off { front, rear } => {
                if front && rear {
                    out[3] = Some(unit(1));
                    out[4] = Some(unit(2));
                }
                out[5] = front.then(|| unit(3));
                out[6] = rear.then(|| unit(4));
            }
        }
        out
    }
}

/// The covector of row `target` when the forces come from `rows`.
fn left_over<const N: usize>(
    a: &[[f64; N]; 5],
    rows: [usize; N],
    target: usize,
) -> Option<[f64; 5]> {
    let matrix = nalgebra::SMatrix::<f64, N, N>::from_fn(|i, j| a[rows[j]][i]);
    let right = nalgebra::SVector::<f64, N>::from(a[target]);
    let inverse = matrix.try_inverse()?;
    let share = inverse * right;
    let mut w = [0.0; 5];
    w[target] = 1.0;
    for (&row, share) in rows.iter().zip(share.iter()) {
        w[row] -= share;
    }
    // near a posture in which the rows say the same, their noise is all there is
    w.iter().all(|v| v.abs() < 10.0).then_some(w)
}

/// Longest stretch without an event that is one cluster, s.
const STRETCH: f64 = 6.0;
/// Events of one kind nearer than this are one, s.
const TOGETHER: f64 = 1.0;

/// The clusters: around every jump, whoops and corner up to half way to the next; long stretches
/// between them are cut.
fn clusters(segments: &[Segment], rate: f64, n: usize) -> (impl Fn(usize) -> usize, usize) {
    let mut events: Vec<(ManoeuvreKind, Range<usize>)> = Vec::new();
    for s in segments {
        if !matches!(
            s.kind,
            ManoeuvreKind::Airborne | ManoeuvreKind::Whoops | ManoeuvreKind::Cornering
        ) {
            continue;
        }
        match events.last_mut() {
            Some((kind, last))
                if *kind == s.kind
                    && s.start.saturating_sub(last.end) as f64 <= TOGETHER * rate =>
            {
                last.end = s.end;
            }
            _ => events.push((s.kind, s.start..s.end)),
        }
    }
    let mut borders = vec![0];
    borders.extend(events.windows(2).map(|w| (w[0].1.end + w[1].1.start) / 2));
    borders.push(n);
    let longest = (STRETCH * rate) as usize;
    let mut starts = Vec::new();
    for pair in borders.windows(2) {
        let pieces = ((pair[1] - pair[0]) / longest.max(1)).max(1);
        let length = (pair[1] - pair[0]).div_ceil(pieces).max(1);
        starts.extend((0..pieces).map(|p| pair[0] + p * length));
    }
    let count = starts.len();
    (move |i: usize| starts.partition_point(|s| *s <= i).saturating_sub(1), count)
}
