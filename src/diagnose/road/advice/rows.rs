//! Advice in the rows of `causes`.

use super::ranking::Advice;
use crate::contract::verdict::Verdict;
use crate::diagnose::cause::Identification;
use crate::diagnose::road::base::Base;
use crate::diagnose::road::null_calibration::{LARGEST_LIMIT, RoadCalibration};
use crate::store::tables::rows::CauseRow;

/// Puts the riding that simulations recommend in the place of the effect's general advice. `unseen`: also for
/// effects that the ride cannot identify.
pub(crate) fn amend(
    causes: &mut [CauseRow],
    identification: &Identification<Base>,
    calibration: &RoadCalibration,
    advice: &Advice,
    unseen: bool,
) {
    for row in causes {
        let Some(cause) = identification.causes.iter().find(|c| c.candidate.name == row.effect)
        else {
            continue;
        };
        let words = cause.candidate.separate_by;
        match cause.verdict {
            Verdict::Ambiguous => {
                let Some(change) = advice.best_separation(cause.candidate.name, &cause.equivalent)
                else {
                    continue;
                };
                let separate_by = match change.resolves() {
                    true => change.words(),
                    false => format!("{words}; {}, which is not enough", change.words()),
                };
                row.reason = row.reason.replace(words, &separate_by);
                row.separate_by = Some(separate_by);
            }
            Verdict::NotIdentifiable if unseen => {
                let place = advice.place(cause.candidate.name);
                let (Some(j), Some(change)) = (place, advice.best_detection(cause.candidate.name))
                else {
                    continue;
                };
                let limit = calibration.limit(j);
                let times = (change.separation[1] / change.separation[0]).powi(2);
                let lowered = calibration.with_information(j, times).limit(j);
                if lowered < LARGEST_LIMIT {
                    row.separate_by = Some(change.set.to_owned());
                    row.reason = format!(
                        "not identifiable in this ride below {limit:.1} typical sizes; {} would lower that \
                         to {lowered:.1}",
                        change.set
                    );
                }
            }
            _ => {}
        }
    }
}
