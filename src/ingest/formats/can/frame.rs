//! A CAN frame, and what is known of a log once all its frames were read.

/// One frame with data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame<'a> {
    /// s, since the log's start or since 1970.
    pub time: f64,
    /// Which bus, as the log numbers them.
    pub bus: u16,
    /// Identifier, without flags.
    pub id: u32,
    /// Whether it has 29 bits.
    pub extended: bool,
    /// At most 8 bytes, with CAN FD 64.
    pub data: &'a [u8],
}

/// Counts that are known once all frames came by.
#[derive(Debug, Default)]
pub(super) struct Scan {
    /// When the log was begun, RFC 3339.
    pub start: Option<String>,
    /// Frames that could not be read.
    pub bad: usize,
    /// Where the first of them is.
    pub first_bad: String,
    /// Whether the log ends within something.
    pub cut: bool,
}

impl Scan {
    /// One more that could not be read.
    pub(super) fn bad(&mut self, place: impl FnOnce() -> String) {
        if self.bad == 0 {
            self.first_bad = place();
        }
        self.bad += 1;
    }
}
