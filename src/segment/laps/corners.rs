//! The corners of a track, from the lateral acceleration of its fastest lap.

/// Lateral acceleration of a corner, m/s².
const TURNING: f64 = 3.0;
/// It must be reached in it, m/s².
const TURNED: f64 = 4.5;
/// Two to the same side with less between them are one, m.
const BETWEEN: f64 = 25.0;
/// Shortest corner, m.
const SHORTEST: f64 = 25.0;

/// A corner, by stations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// Whether it goes to the left.
    pub left: bool,
    /// First station.
    pub start: usize,
    /// Slowest station.
    pub apex: usize,
    /// Last station.
    pub end: usize,
}

/// In the order of the lap. `across` is positive to the left (m/s²), `step` between stations (m).
pub(crate) fn corners(across: &[f64], speed: &[f64], step: f64) -> Vec<Corner> {
    let mut out: Vec<Corner> = Vec::new();
    for i in (0..across.len()).filter(|&i| across[i].abs() > TURNING) {
        let left = across[i] > 0.0;
        match out.last_mut() {
            Some(c) if c.left == left && (i - c.end) as f64 * step < BETWEEN => c.end = i,
            _ => out.push(Corner { left, start: i, apex: i, end: i }),
        }
    }
    out.retain(|c| {
        (c.end - c.start) as f64 * step > SHORTEST
            && across[c.start..=c.end].iter().any(|a| a.abs() > TURNED)
    });
    for c in &mut out {
        let slowest = (c.start..=c.end).min_by(|&a, &b| speed[a].total_cmp(&speed[b]));
        c.apex = slowest.unwrap_or(c.start);
    }
    out
}

/// Where the section of each corner begins: halfway on the straight before it. The last value is the
/// lap's end.
pub(crate) fn sections(corners: &[Corner], stations: usize) -> Vec<usize> {
    let between = corners.windows(2).map(|c| (c[0].end + c[1].start) / 2);
    std::iter::once(0).chain(between).chain([stations.saturating_sub(1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hairpin_with_two_apexes_is_one_corner_and_a_kink_is_none() {
        let mut across = vec![0.0; 200];
        across[20..30].fill(8.0);
        across[33..40].fill(7.0); // 15 m of less lean
        across[60..80].fill(-9.0);
        across[100..110].fill(3.5); // never more
        across[120..123].fill(9.0); // 10 m
        let speed: Vec<f64> = (0..200).map(|i| 30.0 - (i % 50) as f64 * 0.1).collect();
        let found = corners(&across, &speed, 5.0);
        let ends: Vec<_> = found.iter().map(|c| (c.left, c.start, c.end)).collect();
        assert_eq!(ends, [(true, 20, 39), (false, 60, 79)]);
        assert_eq!(found[0].apex, 39);
        assert_eq!(sections(&found, 200), [0, 49, 199]);
    }
}
