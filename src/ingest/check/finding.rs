//! What the checks found, and what comes of it.

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::error::Error;
use crate::ingest::switches::{Effect, Switches};

/// Something wrong.
pub(super) struct Finding {
    /// One of [`CHECKS`](crate::ingest::CHECKS).
    pub code: &'static str,
    pub channel: Channel,
    /// How many 0.2 s means it was seen in.
    pub count: usize,
    /// What was seen and what to do; what comes of it is added to it.
    pub message: String,
}

/// Findings, as far as the session survives them.
pub(super) struct Findings<'a> {
    switches: &'a Switches,
    /// Warnings, in the order of the checks.
    pub warnings: Vec<Warning>,
    /// Channels to leave out.
    pub left_out: Vec<Channel>,
}

impl<'a> Findings<'a> {
    pub(super) fn new(switches: &'a Switches) -> Self {
        Findings { switches, warnings: Vec::new(), left_out: Vec::new() }
    }

    /// Does with a finding what its switch says.
    ///
    /// # Errors
    /// The finding, where it refuses the log.
    pub(super) fn push(&mut self, finding: Finding) -> Result<(), Error> {
        let effect = self.switches.effect(finding.code);
        self.put(finding, effect)
    }

    /// The same of a finding that is no reason to refuse a log: a warning at most.
    pub(super) fn push_mild(&mut self, finding: Finding) -> Result<(), Error> {
        let effect = self.switches.effect(finding.code).min(Effect::Warn);
        self.put(finding, effect)
    }

    fn put(&mut self, finding: Finding, effect: Effect) -> Result<(), Error> {
        let Finding { code, channel, count, mut message } = finding;
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
        self.warnings.push(Warning { stage: "ingest", code, channel, count, time: None, message });
        Ok(())
    }
}
