//! What a diagnosis gives, on the road and off it.

use super::levels::Member;
use super::offroad::OffroadDiagnosis;
use super::road::{Estimated, RoadDiagnosis};
use super::summary;
use super::tuning::{OffroadTuning, RoadTuning};
use crate::simulate::effects::extended_model::ExtendedModel;
use crate::store::tables::rows::{
    CauseRow, Circumstances, DiscrepancyRow, EffectTrace, EstimateRow, Ident, SimulatedSample,
    SimulationError,
};

/// Everything that one session gives to tables, files and terminal.
#[derive(Debug, Clone, Default)]
pub struct Diagnosis {
    /// Session, bike and start.
    pub ident: Ident,
    /// Where, by whom and on what tyres it was ridden.
    pub circumstances: Circumstances,
    /// Rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// Rows of `discrepancies`.
    pub discrepancies: Vec<DiscrepancyRow>,
    /// Rows of `replays`; off-road, where nothing is simulated again, there are none.
    pub replays: Vec<SimulatedSample>,
    /// Rows of `simulation_errors`; none off-road.
    pub simulation_errors: Vec<SimulationError>,
    /// Rows of `estimates`; none off-road.
    pub estimates: Vec<EstimateRow>,
    /// Rows of `effect_traces`; none off-road.
    pub effect_traces: Vec<EffectTrace>,
    /// The extended model; off-road there is no file of it.
    pub model: Option<ExtendedModel>,
    /// Whether the sizes in `causes` are pooled over sessions with their own errors: those under a model
    /// that is known to be wrong are pooled with twice that.
    pub poolable: bool,
    /// Samples on the session's common clock.
    pub n_samples: i64,
    /// The verdict for a terminal: lines without colour, the last one not ended.
    pub summary: String,
}

impl Diagnosis {
    /// The session as one that is pooled over ([`Pooling::add`](super::levels::Pooling::add)).
    pub fn member(&self) -> Member {
        Member {
            ident: self.ident.clone(),
            site: self.circumstances.site.clone(),
            sound: self.poolable,
        }
    }
}

impl From<RoadDiagnosis> for Diagnosis {
    fn from(d: RoadDiagnosis) -> Self {
        Diagnosis {
            summary: summary::session(
                &d.ident,
                &d.causes,
                &d.discrepancies,
                &d.simulation_errors,
                [d.identification.alarm, RoadTuning::default().alarm],
            ),
            poolable: d.is_poolable(),
            n_samples: d.n_samples,
            ident: d.ident,
            circumstances: d.circumstances,
            causes: d.causes,
            discrepancies: d.discrepancies,
            replays: d.replays,
            simulation_errors: d.simulation_errors,
            estimates: d.estimates,
            effect_traces: d.effect_traces,
            model: Some(d.model),
        }
    }
}

/// Nothing is said of causes, nor a summary: that is left to the comparison with the motorcycle's other rides.
impl From<Estimated> for Diagnosis {
    fn from(d: Estimated) -> Self {
        Diagnosis {
            ident: d.ident,
            circumstances: d.circumstances,
            n_samples: d.n_samples,
            estimates: d.estimates,
            effect_traces: d.effect_traces,
            ..Diagnosis::default()
        }
    }
}

impl From<OffroadDiagnosis> for Diagnosis {
    fn from(d: OffroadDiagnosis) -> Self {
        Diagnosis {
            summary: summary::session(
                &d.ident,
                &d.causes,
                &d.discrepancies,
                &[],
                [d.identification.alarm, OffroadTuning::default().alarm],
            ),
            poolable: false,
            n_samples: d.n_samples,
            ident: d.ident,
            circumstances: Circumstances::default(),
            causes: d.causes,
            discrepancies: d.discrepancies,
            replays: Vec::new(),
            simulation_errors: Vec::new(),
            estimates: Vec::new(),
            effect_traces: Vec::new(),
            model: None,
        }
    }
}
