//! What the channels of a log are, by its motion.

use crate::contract::channel::Channel;

/// Of a channel that is the column for sure, but whose delay shows too badly to be put in force.
pub(crate) const UNTIMED: &str =
    "this log does not show its delay well enough; give its `delay` if you know it";

/// Of a brake pressure whose deceleration suits another unit than the log's: only its owner knows which is right.
pub(crate) const PRESSURE: &str =
    "the log says another unit than its deceleration suits: which one is it? put it in";

/// Start of the doubt about one of several channels of a kind.
pub(crate) const SEVERAL: &str = "there is more than one such channel";

/// The doubt of a channel whose unit the log gives, but nobody knows: it is not taken for a channel without one.
pub(super) fn unknown(unit: &str) -> String {
    format!(
        "the log gives `{unit}` as its unit, which roadbench does not know: put in `unit`, and `scale` where a number is \
         not one of that unit"
    )
}

/// Standard errors by which a channel must be earlier than the reference to be it: overwhelming evidence.
pub(crate) const FAR: f64 = 5.0;

/// Source of a column, and the reason.
#[derive(Debug, Clone)]
pub struct Verdict {
    pub channel: Channel,
    /// Place of the channel in the listing.
    pub source: usize,
    /// Its unit, as a map says it.
    pub unit: String,
    /// Added to the log's numbers, in its unit: minus what it says where it should say 0.
    pub offset: f64,
    /// Sign, 1 or -1.
    pub sign: f64,
    /// Another unit that the numbers suit as well: only the owner knows which it is.
    pub or_unit: Option<String>,
    /// Radius that turns a surface speed into spin, m: of the bike file, or a stand-in.
    pub radius: Option<f64>,
    /// How late it is after the earliest of all, s.
    pub delay: f64,
    /// Standard error of the delay, s; `None` where it could not be measured.
    pub delay_error: Option<f64>,
    /// The figures that decided.
    pub why: Vec<String>,
    /// Why it is not sure; a map has the entry commented out then.
    pub doubt: Option<String>,
    /// Whether the motion confirmed it; else it is by its name and unit.
    pub confirmed: bool,
}

/// Findings in a log.
#[derive(Debug, Clone, Default)]
pub struct Verdicts {
    /// In schema order; those of one column the best first.
    pub entries: Vec<Verdict>,
    /// Channels that feed no column (places in the listing), and why.
    pub left: Vec<(usize, String)>,
    /// Of these, those that never change: a name may be right all the same.
    pub constant: Vec<usize>,
    /// Source of the motion, and open questions.
    pub remarks: Vec<String>,
}

impl Verdict {
    /// By name and unit alone.
    pub fn new(channel: Channel, source: usize, unit: &str) -> Self {
        Verdict {
            channel,
            source,
            unit: unit.to_owned(),
            offset: 0.0,
            sign: 1.0,
            or_unit: None,
            radius: None,
            delay: 0.0,
            delay_error: None,
            why: Vec::new(),
            doubt: None,
            confirmed: false,
        }
    }

    pub fn because(mut self, why: impl Into<String>) -> Self {
        self.why.push(why.into());
        self
    }

    /// Whether only a choice among several such channels is open, which a map makes.
    pub fn is_one_of_several(&self) -> bool {
        self.doubt.as_deref().is_some_and(|d| d.starts_with(SEVERAL))
    }

    /// Whether only its delay is not sure.
    pub fn untimed(&self) -> bool {
        self.doubt.as_deref() == Some(UNTIMED)
    }

    /// Whether only the unit is not sure, as the log contradicts the motion.
    pub fn of_two_units(&self) -> bool {
        self.doubt.as_deref() == Some(PRESSURE)
    }

    /// Makes it a guess.
    pub fn doubted(mut self, doubt: impl Into<String>) -> Self {
        self.doubt.get_or_insert(doubt.into());
        self
    }
}

impl Verdicts {
    /// The entry of a column that is sure.
    pub fn sure(&self, channel: Channel) -> Option<&Verdict> {
        self.entries.iter().find(|e| e.channel == channel && e.doubt.is_none())
    }

    /// Why a channel feeds no column.
    pub fn left_out(&self, source: usize) -> Option<&str> {
        self.left.iter().find(|l| l.0 == source).map(|l| l.1.as_str())
    }
}
