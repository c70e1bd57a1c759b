//! The parts of a session around the samples in use: smoothing the rest would be wasted work.

use std::ops::Range;

use crate::contract::session::Session;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Reach of a smoothed signal's second derivative, s; no other filter reaches further.
const REACH_S: f64 = 1.0;
/// Least reach of logs with a low rate, samples.
const MIN_REACH_SAMPLES: usize = 16;

/// Parts of a session, in order, with a missing sample between two of them.
pub(super) struct Around {
    /// The channels of the parts, one after the other.
    pub session: Session,
    parts: Vec<Range<usize>>,
    /// First sample of each part in `session`.
    starts: Vec<usize>,
}

impl Around {
    /// The parts of `session` around `picks`, samples of it by manoeuvre.
    pub(super) fn of(session: &Session, picks: &[(ManoeuvreKind, Vec<usize>)]) -> Self {
        let reach = ((REACH_S * session.rate) as usize).max(MIN_REACH_SAMPLES);
        let mut wanted: Vec<Range<usize>> = picks
            .iter()
            .filter_map(|(_, own)| Some((*own.iter().min()?, *own.iter().max()?)))
            .map(|(first, last)| first.saturating_sub(reach)..(last + reach + 1).min(session.len))
            .collect();
        wanted.sort_by_key(|r| r.start);
        let mut parts: Vec<Range<usize>> = Vec::with_capacity(wanted.len());
        for part in wanted {
            match parts.last_mut() {
                Some(last) if part.start <= last.end => last.end = last.end.max(part.end),
                _ => parts.push(part),
            }
        }
        let mut len = 0;
        let starts = parts.iter().map(|part| {
            let start = len;
            len += part.len() + 1;
            start
        });
        let starts: Vec<usize> = starts.collect();
        let mut near = Session::new(session.meta.clone(), session.rate, len);
        for (channel, x) in session.channels().filter_map(|c| session.get(c).map(|x| (c, x))) {
            let mut own = Vec::with_capacity(len);
            for part in &parts {
                own.extend_from_slice(&x[part.clone()]);
                own.push(f64::NAN);
            }
            near.set(channel, own);
        }
        Around { session: near, parts, starts }
    }

    /// Values of the samples within the parts, with `between` after each part.
    pub(super) fn only<T: Copy>(&self, all: impl Iterator<Item = T>, between: T) -> Vec<T> {
        let mut all = all.enumerate();
        let mut out = Vec::with_capacity(self.session.len);
        for part in &self.parts {
            let own = all.by_ref().skip_while(|(i, _)| *i < part.start).take(part.len());
            out.extend(own.map(|(_, value)| value));
            out.push(between);
        }
        out
    }

    /// Place of a picked sample of the session within the parts.
    pub(super) fn position(&self, sample: usize) -> usize {
        let part = self.parts.partition_point(|part| part.end <= sample);
        self.starts[part] + sample - self.parts[part].start
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::channel::Channel;
    use crate::contract::session::Meta;

    #[test]
    fn parts_that_meet_are_one_and_every_pick_keeps_its_sample() {
        let mut session = Session::new(Meta::default(), 100.0, 2000);
        session.set(Channel::Roll, (0..2000).map(f64::from).collect());
        let kind = ManoeuvreKind::Cornering;
        let picks = [(kind, vec![1500, 1510]), (kind, vec![50, 60]), (kind, vec![200, 400])];
        let around = Around::of(&session, &picks);
        assert_eq!(around.parts, [0..501, 1400..1611]);
        let roll = around.session.get(Channel::Roll).expect("a channel");
        for &i in picks.iter().flat_map(|(_, own)| own) {
            assert_eq!(roll[around.position(i)], i as f64);
        }
        assert_eq!(
            around.only((0..2000).map(f64::from), 0.0)[500..505],
            [500.0, 0.0, 1400.0, 1401.0, 1402.0]
        );
        assert!(roll[501].is_nan() && roll.len() == 501 + 211 + 2);
    }

    #[test]
    fn nothing_looked_at_is_nothing() {
        let session = Session::new(Meta::default(), 100.0, 2000);
        assert_eq!(Around::of(&session, &[]).session.len, 0);
    }
}
