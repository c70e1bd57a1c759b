//! The side force ratio of a tyre from sessions whose riding differs.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use roadbench::internals::contract::fleet_event::{Affected, EventKind};
use roadbench::internals::contract::reason::ReasonCode;
use roadbench::internals::contract::status::Status;
use roadbench::internals::fleet::events::{Event, Moved};
use roadbench::internals::fleet::history::History;
use roadbench::internals::fleet::ratio::{Ratio, ratios};
use roadbench::internals::fleet::scan::Shape;
use roadbench::internals::statistics::order::median;

/// Sessions in the plane of `-ct` and `c1`.
struct Points {
    x: Vec<f64>,
    x_error: Vec<f64>,
    y: Vec<f64>,
    y_error: Vec<f64>,
}

impl Points {
    fn history(self) -> History {
        let n = self.x.len();
        let key = |name: &str| ("rear".to_owned(), name.to_owned());
        History {
            sessions: (0..n).map(|i| format!("s{i:02}")).collect(),
            days: vec![None; n],
            keys: ["effective_rolling_radius", "lateral_friction_ct", "slip_camber_c1"]
                .map(key)
                .to_vec(),
            values: vec![vec![0.3; n], self.x.iter().map(|x| -x).collect(), self.y],
            errors: vec![vec![1e-4; n], self.x_error, self.y_error],
            ..History::default()
        }
    }

    /// The ratio of the only tyre.
    fn ratio(self) -> Option<Ratio> {
        ratios(&self.history(), &[]).pop()
    }
}

/// Sessions of a tyre with `C` 0.11 and `k_alpha0` 13, their true `ct` spread by `variety`.
fn points(seed: u64, n: usize, variety: f64) -> Points {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut draw = |sd: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut random);
        sd * z
    };
    let mut p = Points { x: vec![], x_error: vec![], y: vec![], y_error: vec![] };
    for i in 0..n {
        let (sx, sy) = ([0.004, 0.01, 0.02][i % 3], [0.003, 0.005, 0.008][i % 3]);
        let x = 0.85 + draw(variety);
        p.x.push(x + draw(sx));
        p.y.push(-0.11 + x / 13.0 + draw(sy) + draw(0.002));
        p.x_error.push(sx);
        p.y_error.push(sy);
    }
    p
}

/// Of 100 fleets each: the interval contains the true value as often as it says, and more riders narrow it.
#[test]
fn the_interval_holds_the_truth() {
    let mut widths = Vec::new();
    for (n, variety) in [(12, 0.12), (50, 0.05), (50, 0.12)] {
        let (mut held, mut width, mut off) = (0, Vec::new(), Vec::new());
        for seed in 0..100 {
            let found = points(seed, n, variety).ratio().expect("a line");
            held += usize::from(found.low <= 0.11 && 0.11 <= found.high);
            width.push(found.high - found.low);
            off.push(found.value - 0.11);
        }
        let off = median(&mut off).expect("some");
        let width = median(&mut width).expect("some");
        assert!(held >= 90, "{n} {variety}: {held} of 100");
        assert!(off.abs() < 0.05 * width, "{n} {variety}: {off} of {width}");
        widths.push(width);
    }
    assert!(widths[2] < 0.7 * widths[0] && widths[2] < 0.7 * widths[1], "{widths:?}");
}

#[test]
fn the_same_riding_every_time_says_nothing() {
    for seed in 0..30 {
        let found = points(seed, 40, 0.0).ratio().expect("looked at");
        assert_ne!(found.status(), Status::Ok, "{seed}: {found:?}");
    }
    let none = (0..30).filter_map(|seed| points(seed, 40, 0.0).ratio());
    assert!(none.filter(|r| r.status() == Status::NotAvailable).count() >= 26);
    assert_eq!(points(1, 5, 0.1).ratio(), None, "too few");
}

/// Sessions that are too alike have no value; sessions that differ enough, but are few, have a wide interval.
#[test]
fn the_reason_is_that_of_the_numbers() {
    let (mut alike, mut wide) = (0, 0);
    for seed in 0..30 {
        for (n, variety) in [(40, 0.0), (6, 0.03), (8, 0.06), (50, 0.12)] {
            let Some(found) = points(seed, n, variety).ratio() else { continue };
            let reason = found.reason();
            assert_eq!(reason.is_none(), found.status() == Status::Ok, "{found:?}");
            let Some((code, text)) = reason else { continue };
            alike += usize::from(code == ReasonCode::AlikeSessions);
            wide += usize::from(code == ReasonCode::WideInterval);
            // who has a value has sessions that are not too alike
            assert_eq!(code == ReasonCode::WideInterval, found.value.is_finite(), "{found:?}");
            assert_eq!(text.contains("between"), found.value.is_finite(), "{text}");
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }
    assert!(alike > 20 && wide > 5, "{alike} {wide}");
}

/// One rear tyre until session 20, another from there on, with `C` 0.11 and 0.16: two lines. A session
/// that is off by a lot is left out.
#[test]
fn each_tyre_for_itself() {
    let mut p = points(3, 40, 0.1);
    p.y.iter_mut().skip(20).for_each(|y| *y -= 0.05);
    p.y[5] += 0.2;
    let history = p.history();
    let moved = Moved { coefficient: 0, size: 0.01, score: 30.0 };
    let swap = Event {
        kind: EventKind::TyreSwap,
        affected: Affected::Rear,
        shape: Shape::Stretch(20, 40),
        n: 40,
        moved: vec![moved],
        score: 30.0,
        chance: 0.0,
        discovery: 0.0,
        reason: String::new(),
    };
    let found = ratios(&history, std::slice::from_ref(&swap));
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].sessions.len(), found[0].n), (20, 19));
    for (ratio, truth) in found.iter().zip([0.11, 0.16]) {
        assert!(ratio.low < truth && truth < ratio.high, "{ratio:?}");
        assert_eq!(ratio.status(), Status::Ok, "{ratio:?}");
    }
    assert_eq!(ratios(&history, &[]).len(), 1);
}
