//! Fixes that a phone gives more than once.
//!
//! Android's fused provider hands each second's fix over in two to four calls some milliseconds apart: the same one again,
//! or first one with the new speed at the old place and a worse accuracy. On a clock of such stamps nearly every sample
//! would be missing. Of each burst the most accurate is kept, of equals the first.

use crate::ingest::formats::streams::{Stream, Streams};

/// A step is within a burst where it is shorter than this share of the long ones.
const SHORT: f64 = 0.25;
/// The step that counts as long, as a share of all of them in order.
const LONG: f64 = 0.9;
/// The column by which fixes are chosen, the smaller the better.
const ACCURACY: [&str; 2] = ["horizontalAccuracy", "Horizontal Accuracy"];

/// Keeps one fix of each burst, with a warning.
pub(super) fn keep_best(stream: &mut Stream, streams: &mut Streams) {
    let mut steps: Vec<f64> =
        stream.time.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let place = (LONG * steps.len() as f64) as usize;
    let Some(long) = steps.get(place.min(steps.len().saturating_sub(1))) else { return };
    let most = SHORT * long;
    let accuracy: Vec<f64> = ACCURACY
        .iter()
        .find_map(|name| stream.get(name))
        .map_or_else(|| vec![0.0; stream.time.len()], <[f64]>::to_vec);
    // a negative accuracy is none
    let worth = |i: usize| if accuracy[i] >= 0.0 { accuracy[i] } else { f64::INFINITY };
    let mut kept: Vec<usize> = Vec::with_capacity(stream.time.len());
    let mut begun = f64::NEG_INFINITY;
    for (i, time) in stream.time.iter().enumerate() {
        let within = time - begun >= 0.0 && time - begun < most;
        match kept.last_mut() {
            Some(last) if within => {
                if worth(i) < worth(*last) {
                    *last = i;
                }
            }
            _ => {
                begun = *time;
                kept.push(i);
            }
        }
    }
    let lost = stream.time.len() - kept.len();
    let message = format!(
        "`{}`: {lost} fixes came within {:.2} s of another: the phone gave them more than once; the most accurate of each is kept",
        stream.group, most
    );
    streams.warn("time_duplicated", lost, message);
    if lost > 0 {
        let chosen = |from: &[f64]| kept.iter().map(|i| from[*i]).collect::<Vec<f64>>();
        stream.time = chosen(&stream.time);
        stream.lines.iter_mut().for_each(|line| line.values = chosen(&line.values));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(time: &[f64], accuracy: &[f64]) -> Stream {
        let mut stream = Stream::new("Location");
        for (i, (time, accuracy)) in time.iter().zip(accuracy).enumerate() {
            stream.begin(*time);
            stream.set("horizontalAccuracy", Some("m"), *accuracy);
            stream.set("speed", Some("m/s"), i as f64);
        }
        stream
    }

    #[test]
    fn the_best_of_each_burst_is_kept() {
        let time = [0.0, 0.001, 1.0, 1.09, 1.1, 2.0, 3.0, 3.002, 4.0, 5.0, 6.0, 7.0, 8.0];
        let accuracy = [5.0, 5.0, 7.9, 5.7, 5.7, 5.0, -1.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0];
        let (mut stream, mut streams) = (stream(&time, &accuracy), Streams::default());
        keep_best(&mut stream, &mut streams);
        assert_eq!(
            stream.get("speed"),
            Some(&[0.0, 3.0, 5.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0][..])
        );
        assert_eq!((streams.warnings[0].code, streams.warnings[0].count), ("time_duplicated", 4));
    }

    #[test]
    fn a_fast_receiver_keeps_every_fix() {
        let time: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
        let (mut stream, mut streams) = (stream(&time, &[3.0; 50]), Streams::default());
        keep_best(&mut stream, &mut streams);
        assert_eq!((stream.time.len(), streams.warnings.len()), (50, 0));
        let (mut none, mut streams) = (Stream::new("Location"), Streams::default());
        keep_best(&mut none, &mut streams);
        assert!(streams.warnings.is_empty());
    }
}
