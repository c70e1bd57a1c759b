//! Zero-phase filtering by forward and inverse FFT, block by block.
//!
//! ```text
//! (1)  h(t) = 2 f sinc(2 f t) cos(2 pi b f t) / (1 - (4 b f t)^2)
//! (2)  H(|g| < (1-b) f) = 1,  H(f) = 1/2,  H(|g| > (1+b) f) = 0, a raised cosine between
//! ```
//!
//! The kernel is (1), sampled, tapered to a finite length and scaled to a gain of one at 0 Hz.
//! Its smooth transition band makes it short: past two periods of the cut a step rings by less
//! than 0.3 %. Sampling folds (2) about half the rate, where the folded halves add up to one
//! when the cut comes near it: the filter fades into none, without a special case.
//!
//! A run is extended by reflection, transformed in blocks of one length that fits the cache
//! (overlap-save: exact, whatever the blocks), multiplied by the kernel's spectrum, which is
//! real because the kernel is symmetric, and transformed back. Plans, spectra and scratch are
//! kept per thread.
//!
//! Source: the raised-cosine filter as in Proakis, Digital Communications, section 9.2;
//! overlap-save as in Oppenheim and Schafer, Discrete-Time Signal Processing, section 8.7.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::rc::Rc;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// Half width of the transition band per high cut, `b` of (1).
const HIGH_ROLL_OFF: f64 = 0.4;
/// Half length of the kernel in periods of the high cut; (1) has fallen to 6e-5 there.
const HIGH_PERIODS: f64 = 10.0;
/// The slow mean may fade from 0 Hz on.
const LOW_ROLL_OFF: f64 = 1.0;
/// Half length of the slow mean's kernel in periods of the low cut.
const LOW_PERIODS: f64 = 3.0;
/// Shortest block: smaller ones spend their time on calls, larger ones on the cache.
const SHORTEST_BLOCK: usize = 1024;

/// Removes what is above `cut` Hz from samples at `rate` Hz, in place, without delay.
///
/// The run is extended by point reflection at its ends, `2 x[0] - x[k]`: a level, a trend or a
/// step at the end goes on, so that nothing rings into the data; the end sample itself stays
/// as it is. Samples must be finite. A cut at or above half the rate does nothing.
pub fn high_cut(x: &mut [f64], rate: f64, cut: f64) {
    if x.len() < 2 || cut >= 0.5 * rate {
        return;
    }
    let shape = Shape::new(cut / rate, HIGH_ROLL_OFF, HIGH_PERIODS);
    WORKER.with_borrow_mut(|worker| {
        worker.convolve(x, shape, point_reflection, |x, y| x.copy_from_slice(y));
    });
}

/// Subtracts what is below `cut` Hz from samples at `rate` Hz, in place, without delay.
///
/// The run is extended by mirroring at its ends, so that the slow mean there is the mean of
/// what is near. A run shorter than a period of the cut loses its mean. Samples must be finite.
pub(crate) fn remove_slow(x: &mut [f64], rate: f64, cut: f64) {
    if (x.len() as f64) * cut < rate {
        let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
        x.iter_mut().for_each(|v| *v -= mean);
        return;
    }
    let shape = Shape::new(cut / rate, LOW_ROLL_OFF, LOW_PERIODS);
    WORKER.with_borrow_mut(|worker| {
        worker.convolve(x, shape, mirror, |x, slow| {
            x.iter_mut().zip(slow).for_each(|(v, s)| *v -= s);
        });
    });
}

/// `x` continued beyond its ends by point reflection, as often as need be.
fn point_reflection(x: &[f64], i: isize) -> f64 {
    let last = x.len() - 1;
    let period = 2 * last as isize;
    let (turns, r) = (i.div_euclid(period), i.rem_euclid(period) as usize);
    let within = if r <= last { x[r] } else { 2.0 * x[last] - x[2 * last - r] };
    within + 2.0 * turns as f64 * (x[last] - x[0])
}

/// `x` continued beyond its ends by mirroring, as often as need be.
fn mirror(x: &[f64], i: isize) -> f64 {
    let last = x.len() - 1;
    let r = i.rem_euclid(2 * last as isize) as usize;
    if r <= last { x[r] } else { x[2 * last - r] }
}

/// Parameters of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shape {
    /// Cut per sampling rate.
    cut: f64,
    /// `b` of (1).
    roll_off: f64,
    /// Samples either side of the centre.
    half: usize,
}

impl Shape {
    fn new(cut: f64, roll_off: f64, periods: f64) -> Self {
        Shape { cut, roll_off, half: (periods / cut).ceil() as usize }
    }

    /// Weights 0..=half of the symmetric kernel; the whole adds up to one.
    fn kernel(self) -> Vec<f64> {
        let half = self.half as f64;
        let mut h: Vec<f64> = (0..=self.half)
            .map(|k| {
                let k = k as f64;
                // the outer half fades, or its end would ring
                let taper = 0.5 + 0.5 * (PI * (2.0 * k / half - 1.0).max(0.0)).cos();
                taper * raised_cosine(2.0 * self.cut * k, self.roll_off)
            })
            .collect();
        let sum = 2.0 * h.iter().sum::<f64>() - h[0];
        h.iter_mut().for_each(|v| *v /= sum);
        h
    }
}

/// (1) at `u = 2 f t`, per its value at 0.
fn raised_cosine(u: f64, roll_off: f64) -> f64 {
    let sinc = |u: f64| if u == 0.0 { 1.0 } else { (PI * u).sin() / (PI * u) };
    let v = 2.0 * roll_off * u;
    if (1.0 - v.abs()).abs() < 1e-9 {
        return PI / 4.0 * sinc(u);
    }
    sinc(u) * (0.5 * PI * v).cos() / (1.0 - v * v)
}

/// A kernel's transform for blocks of one length.
struct Blocks {
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Real, as the kernel is symmetric; 1/length of the unscaled inverse is in it.
    gain: Vec<f64>,
}

/// Plans, spectra and scratch of one thread.
struct Worker {
    planner: RealFftPlanner<f64>,
    blocks: BTreeMap<(u64, usize, usize), Rc<Blocks>>,
    padded: Vec<f64>,
    filtered: Vec<f64>,
    block: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

thread_local! {
    static WORKER: RefCell<Worker> = RefCell::new(Worker {
        planner: RealFftPlanner::new(),
        blocks: BTreeMap::new(),
        padded: Vec::new(),
        filtered: Vec::new(),
        block: Vec::new(),
        spectrum: Vec::new(),
        scratch: Vec::new(),
    });
}

impl Worker {
    /// Convolves `x`, continued by `beyond`, with the kernel, and hands both to `put`.
    fn convolve(
        &mut self,
        x: &mut [f64],
        shape: Shape,
        beyond: fn(&[f64], isize) -> f64,
        put: fn(&mut [f64], &[f64]),
    ) {
        let (n, half) = (x.len(), shape.half);
        self.padded.clear();
        self.padded.extend((-(half as isize)..0).map(|i| beyond(x, i)));
        self.padded.extend_from_slice(x);
        self.padded.extend((n..n + half).map(|i| beyond(x, i as isize)));

        let whole = (n + 2 * half).next_power_of_two();
        let length = whole.min((16 * half).next_power_of_two().max(SHORTEST_BLOCK));
        let blocks = self.blocks(shape, length);
        self.block.resize(length, 0.0);
        self.filtered.clear();
        let step = length - 2 * half;
        for start in (0..n).step_by(step) {
            let part = &self.padded[start..self.padded.len().min(start + length)];
            self.block[..part.len()].copy_from_slice(part);
            self.block[part.len()..].fill(0.0);
            self.through(&blocks);
            let wanted = step.min(n - start);
            self.filtered.extend_from_slice(&self.block[half..half + wanted]);
        }
        put(x, &self.filtered);
    }

    /// `block` to its spectrum, times the gain, and back.
    fn through(&mut self, blocks: &Blocks) {
        let Worker { block, spectrum, scratch, .. } = self;
        spectrum.resize(blocks.gain.len(), Complex::default());
        scratch.resize(
            blocks.forward.get_scratch_len().max(blocks.inverse.get_scratch_len()),
            Complex::default(),
        );
        // both can only fail on lengths, which are the plan's own, or on an imaginary part at
        // 0 Hz or half the rate, which a forward transform leaves zero
        let _ = blocks.forward.process_with_scratch(block, spectrum, scratch);
        spectrum.iter_mut().zip(&blocks.gain).for_each(|(s, g)| *s *= *g);
        let _ = blocks.inverse.process_with_scratch(spectrum, block, scratch);
    }

    fn blocks(&mut self, shape: Shape, length: usize) -> Rc<Blocks> {
        let key = (shape.cut.to_bits(), shape.half, length);
        if let Some(blocks) = self.blocks.get(&key) {
            return Rc::clone(blocks);
        }
        let forward = self.planner.plan_fft_forward(length);
        let inverse = self.planner.plan_fft_inverse(length);
        // centred on sample 0, the left half wraps round to the end
        let mut block = vec![0.0; length];
        for (k, h) in shape.kernel().into_iter().enumerate() {
            block[k] = h;
            block[(length - k) % length] = h;
        }
        let mut spectrum = forward.make_output_vec();
        let _ = forward.process(&mut block, &mut spectrum);
        let gain = spectrum.iter().map(|s| s.re / length as f64).collect();
        let blocks = Rc::new(Blocks { forward, inverse, gain });
        self.blocks.insert(key, Rc::clone(&blocks));
        blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Amplitude and phase of a sine of frequency `f` in the middle of `x`, at 100 Hz.
    fn sine_in(x: &[f64], f: f64) -> (f64, f64) {
        let middle = x.len() / 4..3 * x.len() / 4; // whole periods for whole frequencies
        let sum: Complex<f64> =
            middle.clone().map(|i| Complex::from_polar(x[i], -TAU * f * i as f64 / 100.0)).sum();
        let mean = sum * 2.0 / middle.len() as f64;
        (mean.norm(), mean.arg())
    }

    #[test]
    fn sines_pass_or_not_and_keep_their_phase() {
        // (2) at 20 Hz: full to 12 Hz, none from 28 Hz, (1 + cos(pi (f - 12)/16))/2 between
        for n in [1600, 40_000] {
            for (f, gain) in
                [(1.0, 1.0), (5.0, 1.0), (10.0, 1.0), (18.0, 0.691_341_7), (25.0, 0.084_265_2)]
            {
                let mut x: Vec<f64> =
                    (0..n).map(|i| (TAU * f * f64::from(i) / 100.0 + 0.3).cos()).collect();
                high_cut(&mut x, 100.0, 20.0);
                let (amplitude, phase) = sine_in(&x, f);
                assert!((amplitude - gain).abs() < 5e-4, "{f} Hz: {amplitude}");
                assert!((phase - 0.3).abs() < 1e-3, "{f} Hz: {phase}");
            }
            let mut x: Vec<f64> =
                (0..n).map(|i| (TAU * 40.0 * f64::from(i) / 100.0).cos()).collect();
            high_cut(&mut x, 100.0, 20.0);
            assert!(sine_in(&x, 40.0).0 < 2e-4);
        }
    }

    /// Input and numpy's result: the run continued by scipy 1.17.1 `odd_ext` to 2000 samples
    /// either side, its trend removed, one FFT of the whole, times (2) exactly, and back.
    #[test]
    fn agrees_with_one_long_transform_in_numpy() {
        let x = [
            -0.45, -0.746154, -0.888462, -0.876923, -0.711538, -0.392308, 0.080769, -0.292308,
            -0.511538, -0.576923, -0.488462, -0.246154, 0.15, -0.3, -0.596154, -0.738462,
            -0.726923, -0.561538, -0.242308, 0.230769, -0.142308, -0.361538, -0.426923, -0.338462,
            -0.096154, 0.3, -0.15, -0.446154, -0.588462, -0.576923, -0.411538, 1.907692, 2.380769,
            2.007692, 1.788462, 1.723077, 1.811538, 2.053846, 2.45, 2.0,
        ];
        let numpy = [
            -0.45,
            -0.74519957,
            -0.92481765,
            -0.89065478,
            -0.63594887,
            -0.30809335,
            -0.13606363,
            -0.23335115,
            -0.47020661,
            -0.58447931,
            -0.44430027,
            -0.18384061,
            -0.06382895,
            -0.21558487,
            -0.5320837,
            -0.77550697,
            -0.7639332,
            -0.49543721,
            -0.15372329,
            0.01796854,
            -0.08374231,
            -0.32085414,
            -0.43847355,
            -0.30591885,
            -0.03315568,
            0.12595928,
            -0.02443678,
            -0.44122576,
            -0.78400199,
            -0.6041793,
            0.25105147,
            1.39040033,
            2.15580541,
            2.22676427,
            1.8934479,
            1.69045269,
            1.83785917,
            2.10884808,
            2.17899559,
            2.0,
        ];
        let mut y = x;
        high_cut(&mut y, 100.0, 20.0);
        for (a, b) in y.iter().zip(numpy) {
            // numpy's kernel does not end
            assert!((a - b).abs() < 3e-4, "{a} {b}");
        }
    }

    #[test]
    fn a_step_near_the_end_does_not_ring_into_the_data() {
        for from_end in [1, 2, 5, 20, 200] {
            let n = 3000;
            let mut x: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i >= n - from_end))).collect();
            high_cut(&mut x, 100.0, 20.0);
            // two periods of 20 Hz are 10 samples
            let worst = x[..n - from_end - 10].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(worst < 0.01, "{from_end} from the end: {worst}");
        }
    }

    #[test]
    fn levels_and_trends_go_through_untouched_to_the_ends() {
        for n in [30, 500, 5000] {
            let line = |i: usize| 7.0 - 0.02 * i as f64;
            let mut x: Vec<f64> = (0..n).map(line).collect();
            high_cut(&mut x, 100.0, 20.0);
            assert!(x.iter().enumerate().all(|(i, v)| (v - line(i)).abs() < 1e-9), "{n}");
        }
    }

    #[test]
    fn a_low_cut_takes_the_mean_and_leaves_the_motion() {
        for n in [200_usize, 20_000] {
            let motion = |i: usize| (TAU * 1.0 * i as f64 / 100.0).sin();
            let mut x: Vec<f64> = (0..n).map(|i| 3.0 + motion(i)).collect();
            remove_slow(&mut x, 100.0, 0.05);
            let worst = |from: usize, to: usize| {
                (from..to).map(|i| (x[i] - motion(i)).abs()).fold(0.0, f64::max)
            };
            // mirrored, the sine has a mean of its own at the very end
            assert!(worst(0, n) < 0.04, "{n}: {}", worst(0, n));
            assert!(n < 4000 || worst(1000, n - 1000) < 3e-3, "{n}: {}", worst(1000, n - 1000));
        }
    }

    #[test]
    fn plans_are_made_once() {
        for n in [5000, 6000, 7000] {
            high_cut(&mut vec![1.0; n], 100.0, 19.5);
        }
        let shape = Shape::new(0.195, HIGH_ROLL_OFF, HIGH_PERIODS);
        let plans = WORKER.with_borrow(|w| {
            w.blocks.keys().filter(|k| k.0 == shape.cut.to_bits() && k.1 == shape.half).count()
        });
        assert_eq!(plans, 1);
    }

    /// `cargo test -- --ignored --nocapture`: 120 000 samples, 12 channels.
    #[test]
    #[ignore = "a measurement"]
    fn time_of_twelve_channels() {
        let x: Vec<f64> = (0..120_000).map(|i| (f64::from(i) * 0.01).sin()).collect();
        let mut channels = vec![x; 12];
        for pass in 0..3 {
            let start = std::time::Instant::now();
            channels.iter_mut().for_each(|x| high_cut(x, 100.0, 20.0));
            println!("pass {pass}: {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
        }
    }
}
