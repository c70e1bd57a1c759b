//! What the checks found, and what comes of it.

use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest::checks::switches::{Effect, Switches};
use crate::ingest::error::Error;

pub(crate) struct Finding {
    /// One of [`CHECKS`](crate::ingest::CHECKS).
    pub code: RejectionCode,
    pub channel: Channel,
    /// Number of 0.2 s means with it.
    pub count: usize,
    /// Observation, and what to do; what comes of it is added to it.
    pub message: String,
}

/// Findings, as far as the session survives them.
pub(crate) struct Findings<'a> {
    switches: &'a Switches,
    /// Whether findings are only said.
    only_said: bool,
    /// Warnings, in the order of the checks.
    pub warnings: Vec<Warning>,
    /// Channels to leave out.
    pub left_out: Vec<Channel>,
    /// Channels that stay and that others contradict.
    pub contradicted: Vec<(Channel, String)>,
}

impl<'a> Findings<'a> {
    pub(crate) fn new(switches: &'a Switches, only_said: bool) -> Self {
        let (warnings, left_out, contradicted) = (Vec::new(), Vec::new(), Vec::new());
        Findings { switches, only_said, warnings, left_out, contradicted }
    }

    /// Whether something is wrong with a channel already.
    pub(crate) fn concern(&self, channel: Channel) -> bool {
        self.warnings.iter().any(|w| w.channel == Some(channel))
            || self.contradicted.iter().any(|c| c.0 == channel)
    }

    /// Does with a finding what its switch says.
    ///
    /// # Errors
    /// The finding, where it refuses the log.
    pub(crate) fn push(&mut self, finding: Finding) -> Result<(), Error> {
        let effect = self.switches.effect(finding.code);
        self.put(finding, effect)
    }

    /// The same of a finding that may well be right: a warning at most, and nothing is determined by the channels that
    /// contradict each other, unless the pipeline lets them pass.
    pub(crate) fn push_contradiction(
        &mut self,
        finding: Finding,
        channels: &[Channel],
    ) -> Result<(), Error> {
        let effect = self.switches.effect(finding.code);
        if effect != Effect::Off && self.switches.given(finding.code) != Some(Effect::Warn) {
            let said = || format!("{} ({})", finding.message, finding.code);
            self.contradicted.extend(channels.iter().map(|c| (*c, said())));
        }
        self.put(finding, effect.min(Effect::Warn))
    }

    fn put(&mut self, finding: Finding, effect: Effect) -> Result<(), Error> {
        let Finding { code, channel, count, mut message } = finding;
        let effect = if self.only_said { effect.min(Effect::Warn) } else { effect };
        match effect {
            Effect::Off => return Ok(()),
            Effect::Warn => {}
            Effect::LeaveOut => {
                message += &format!("; {channel} is left out");
                self.left_out.push(channel);
            }
            Effect::Reject => {
                message += &format!(
                    "; if the channels are right, `ingest.check.{code} = \"warn\"` in the pipeline \
                     lets the log pass"
                );
                return Err(Error { code, message });
            }
        }
        let channel = Some(channel);
        self.warnings.push(Warning {
            stage: "ingest",
            code: code.as_str(),
            channel,
            count,
            time: None,
            message,
        });
        Ok(())
    }
}
