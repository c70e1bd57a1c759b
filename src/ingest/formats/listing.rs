//! The contents of a log: its channels and its own metadata.

use std::collections::HashMap;

use crate::contract::rejection::RejectionCode;
use crate::contract::schema;
use crate::contract::session::{Markers, Meta};
use crate::contract::warning::Warning;
use crate::ingest::error::Error;
use crate::ingest::raw::Column;

/// Contents of a log.
#[derive(Debug, Clone, Default)]
pub struct Listing {
    /// Its channels, those of one group one after the other.
    pub channels: Vec<SourceChannel>,
    /// Session metadata, as far as the log has it.
    pub meta: Meta,
    /// Further metadata (vehicle, logger, comment, ...), for people.
    pub facts: Vec<(String, String)>,
    /// Damage and doubts that were found.
    pub warnings: Vec<Warning>,
    /// The channel that holds the stamps of the others, in formats that bring no clock of their own.
    pub clock: Option<ListedClock>,
    /// TOML that a channel map for such a log needs besides its channels: the layout of a text,
    /// say. Empty for most formats.
    pub layout: String,
}

/// A channel that holds the stamps of the others.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ListedClock {
    /// Its place among the channels.
    pub channel: usize,
    /// Its unit, for `time.unit` of a map; `None` of stamps that are texts.
    pub unit: Option<String>,
    /// Whether it tells the day.
    pub epoch: bool,
    /// Reason of the decision, where the log does not say it.
    pub why: Option<String>,
}

/// A channel as the log lists it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SourceChannel {
    /// Group of the channel in its log (a group, topic or message); empty if the format has none.
    pub group: String,
    /// Its name within the group.
    pub name: String,
    /// Its unit, as it is written there; `None` where the log gives none.
    pub unit: Option<String>,
    /// Samples, where that is known without decoding.
    pub samples: Option<u64>,
    /// Rate, Hz, where the log gives it.
    pub rate: Option<f64>,
    /// Where the format finds it again: its own business.
    pub place: [usize; 3],
    /// Which of the channels of this group and name it is, from 1; 0 where it is the only one.
    pub twin: usize,
}

/// Decoded channels.
#[derive(Debug, Default)]
pub struct Decoded {
    /// As asked for. Channels that were logged together share their clock.
    pub columns: Vec<Column>,
    /// Warnings beyond [`Listing::warnings`].
    pub warnings: Vec<Warning>,
    /// The logger's own laps, s on the clock of the columns' stamps; empty for most formats.
    pub markers: Markers,
}

impl SourceChannel {
    /// Group and name, and of several that are called so which it is: `Speed #2`.
    pub fn full(&self) -> String {
        let name = match self.group.is_empty() {
            true => self.name.clone(),
            false => format!("{}/{}", self.group, self.name),
        };
        match self.twin {
            0 => name,
            twin => format!("{name} #{twin}"),
        }
    }

    /// Whether a map means this channel by `text`: its name, or group and name with `/` or `.`
    /// between; of twins with the number after it, too.
    pub(crate) fn is_called(&self, text: &str) -> bool {
        let with_group = || {
            let rest = text.strip_prefix(self.group.as_str())?.strip_prefix(['/', '.'])?;
            Some(rest == self.name)
        };
        let by_number = || text == self.full() || text == format!("{} #{}", self.name, self.twin);
        let exact = text == self.name || (self.twin > 0 && by_number());
        exact || (!self.group.is_empty() && with_group() == Some(true))
    }
}

/// Numbers the channels that are called alike, so that each has a name of its own.
pub(crate) fn number_twins(channels: &mut [SourceChannel]) {
    let mut seen: HashMap<(&str, &str), Vec<usize>> = HashMap::new();
    for (place, c) in channels.iter().enumerate() {
        seen.entry((c.group.as_str(), c.name.as_str())).or_default().push(place);
    }
    let twins: Vec<Vec<usize>> = seen.into_values().filter(|places| places.len() > 1).collect();
    for (number, place) in twins.iter().flat_map(|places| (1..).zip(places)) {
        channels[*place].twin = number;
    }
}

impl Listing {
    /// The one channel that is called so.
    ///
    /// # Errors
    /// `missing_column`, `ambiguous_column`: a sentence about the name.
    pub fn find(&self, name: &str) -> Result<&SourceChannel, Error> {
        if let Some(exact) = self.channels.iter().find(|c| c.full() == name) {
            return Ok(exact);
        }
        let mut called = self.channels.iter().filter(|c| c.is_called(name));
        let Some(first) = called.next() else {
            return Err(Error::new(RejectionCode::MissingColumn, self.unknown(name)));
        };
        let others: Vec<String> = called.map(SourceChannel::full).collect();
        if others.is_empty() {
            return Ok(first);
        }
        let message = format!(
            "`{name}` is in the log several times: {}, {}; say which",
            first.full(),
            others.join(", ")
        );
        Err(Error::new(RejectionCode::AmbiguousColumn, message))
    }

    fn unknown(&self, name: &str) -> String {
        let full: Vec<String> = self.channels.iter().map(SourceChannel::full).collect();
        let names = self.channels.iter().map(|c| c.name.as_str());
        let near = schema::nearest(name, names.chain(full.iter().map(String::as_str)));
        let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        format!("`{name}` is not in the log{near}")
    }

    /// The first 300 characters of the channels' names, for messages.
    pub(crate) fn names(&self) -> String {
        let names: Vec<String> = self.channels.iter().map(SourceChannel::full).collect();
        names.join(", ").chars().take(300).collect()
    }
}
