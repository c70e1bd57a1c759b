//! What frames mean: messages and their signals, from DBC files.

use std::collections::HashMap;

use can_dbc::{
    AttributeValue, ByteOrder, Dbc, MessageId, MultiplexIndicator, SignalExtendedValueType,
    ValueType,
};

use super::bits;
use crate::contract::rejection::RejectionCode;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;

/// Messages by their identifiers.
#[derive(Debug, Default)]
pub(crate) struct Database {
    pub messages: Vec<Message>,
    by_id: HashMap<(u32, bool), usize>,
    /// Messages of J1939 by their parameter group: priority and addresses are not part of what they are.
    by_group: HashMap<u32, usize>,
    /// Extended ones of which their database does not say that, sent to all; `None` where several have the group.
    perhaps: HashMap<u32, Option<usize>>,
}

/// The message that an identifier stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MatchedMessage {
    /// Its place among the messages.
    pub message: usize,
    /// Who sent it, where it was found by its parameter group.
    pub source: Option<u8>,
    /// Whether the database says that its messages are found so.
    pub said: bool,
}

/// Parameter group number of an extended identifier; of a message to one address without that.
fn parameter_group(id: u32) -> u32 {
    let group = id >> 8 & 0x3_FFFF;
    if group >> 8 & 0xFF < 240 { group & 0x3_FF00 } else { group }
}

/// Kind of a message's identifier in a database.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Identifier {
    /// J1939: the parameter group counts.
    Group,
    /// It counts as it is.
    Whole,
    Unsaid,
}

/// By the attributes that Vector's tools and all that write for them use.
fn identifier(dbc: &Dbc, id: MessageId) -> Identifier {
    let is = |value: &AttributeValue, index: u64, name: &str| match value {
        AttributeValue::Uint(n) => *n == index,
        AttributeValue::Int(n) => u64::try_from(*n) == Ok(index),
        AttributeValue::String(text) => text == name,
        AttributeValue::Double(_) => false,
    };
    let format = dbc.message_attribute(id, "VFrameFormat");
    match format {
        Some(f) if is(f, 3, "J1939PG") => return Identifier::Group,
        Some(_) => return Identifier::Whole,
        None => {}
    }
    let default = dbc.attribute_default("VFrameFormat");
    let protocol = dbc.attribute_values_database.iter().find(|a| a.name == "ProtocolType");
    if default.is_some_and(|f| is(f, 3, "J1939PG"))
        || protocol.is_some_and(|p| is(&p.value, u64::MAX, "J1939"))
    {
        Identifier::Group
    } else {
        Identifier::Unsaid
    }
}

/// Message of one identifier.
#[derive(Debug)]
pub(crate) struct Message {
    pub name: String,
    pub signals: Vec<Signal>,
}

/// A number within a message.
#[derive(Debug)]
pub(crate) struct Signal {
    pub name: String,
    /// Its unit, if it has one.
    pub unit: Option<String>,
    start: usize,
    size: usize,
    big_endian: bool,
    kind: Number,
    factor: f64,
    offset: f64,
    switch: Option<Switch>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    Unsigned,
    Signed,
    Single,
    Double,
}

/// The signal is only there when another one has a value in one of the ranges.
#[derive(Debug)]
struct Switch {
    signal: usize,
    ranges: Vec<(u64, u64)>,
}

/// Switches that depend on switches go so deep.
const DEEPEST: usize = 8;

impl Signal {
    /// Whether it comes by turns with others.
    pub(crate) fn is_multiplexed(&self) -> bool {
        self.switch.is_some()
    }

    fn raw(&self, data: &[u8]) -> Option<u64> {
        bits::extract(data, self.start, self.size, self.big_endian)
    }
}

impl Message {
    /// A signal's physical value in a frame; `None` if the frame does not hold it.
    pub(crate) fn value(&self, signal: usize, data: &[u8]) -> Option<f64> {
        if !self.is_there(signal, data, 0) {
            return None;
        }
        let signal = self.signals.get(signal)?;
        let raw = signal.raw(data)?;
        let number = match signal.kind {
            Number::Unsigned => raw as f64,
            Number::Signed => bits::signed(raw, signal.size) as f64,
            Number::Single => f64::from(f32::from_bits(raw as u32)),
            Number::Double => f64::from_bits(raw),
        };
        Some(number * signal.factor + signal.offset)
    }

    fn is_there(&self, signal: usize, data: &[u8], depth: usize) -> bool {
        let Some(Switch { signal, ranges }) =
            self.signals.get(signal).and_then(|s| s.switch.as_ref())
        else {
            return true;
        };
        let value = self.signals.get(*signal).and_then(|s| s.raw(data));
        depth < DEEPEST
            && value.is_some_and(|v| ranges.iter().any(|(low, high)| (*low..=*high).contains(&v)))
            && self.is_there(*signal, data, depth + 1)
    }
}

impl Database {
    /// From the texts of DBC files; where several define an identifier the first counts.
    ///
    /// # Errors
    /// `bad_dbc`: one is not a DBC.
    pub(crate) fn read(aids: &Aids) -> Result<Self, Error> {
        let mut database = Database::default();
        for (i, text) in aids.dbc.iter().enumerate() {
            let name = aids.names.get(i).map_or("the channel map's DBC", String::as_str);
            let dbc = Dbc::try_from(text.as_str()).map_err(|e| {
                Error::new(
                    RejectionCode::BadDbc,
                    format!("{name} cannot be read as a CAN database: {e}"),
                )
            })?;
            database.add(&dbc);
        }
        Ok(database)
    }

    /// Which message an identifier stands for: just that one, or of extended ones the one of its parameter group.
    pub(crate) fn find(&self, id: u32, extended: bool) -> Option<MatchedMessage> {
        let exact = self.by_id.get(&(id, extended)).copied();
        if !extended {
            return exact.map(|message| MatchedMessage { message, source: None, said: true });
        }
        let group = parameter_group(id);
        let of_group = self.by_group.get(&group).copied();
        if let Some(message) = exact.filter(|m| of_group != Some(*m)) {
            return Some(MatchedMessage { message, source: None, said: true });
        }
        let source = Some(id as u8);
        if let Some(message) = of_group {
            return Some(MatchedMessage { message, source, said: true });
        }
        let message = self.perhaps.get(&group).copied().flatten()?;
        Some(MatchedMessage { message, source, said: false })
    }

    fn add(&mut self, dbc: &Dbc) {
        for message in &dbc.messages {
            let key = match message.id {
                MessageId::Standard(id) => (u32::from(id), false),
                MessageId::Extended(id) => (id & 0x1FFF_FFFF, true),
            };
            // a place for signals that belong to no message
            if message.name == "VECTOR__INDEPENDENT_SIG_MSG" || self.by_id.contains_key(&key) {
                continue;
            }
            let place = self.messages.len();
            self.by_id.insert(key, place);
            if key.1 {
                let group = parameter_group(key.0);
                match identifier(dbc, message.id) {
                    Identifier::Group => _ = self.by_group.entry(group).or_insert(place),
                    // what is sent to one address looks like any other extended identifier
                    Identifier::Unsaid if key.0 >> 16 & 0xFF >= 240 => {
                        let several = |known: &mut Option<usize>| *known = None;
                        self.perhaps.entry(group).and_modify(several).or_insert(Some(place));
                    }
                    Identifier::Unsaid | Identifier::Whole => {}
                }
            }
            let signals = message.signals.iter().map(|s| signal(dbc, message, s)).collect();
            self.messages.push(Message { name: message.name.clone(), signals });
        }
    }
}

fn signal(dbc: &Dbc, message: &can_dbc::Message, signal: &can_dbc::Signal) -> Signal {
    let kind = match dbc.extended_value_type_for_signal(message.id, &signal.name) {
        Some(SignalExtendedValueType::IEEEfloat32Bit) if signal.size == 32 => Number::Single,
        Some(SignalExtendedValueType::IEEEdouble64bit) if signal.size == 64 => Number::Double,
        _ if signal.value_type == ValueType::Signed => Number::Signed,
        _ => Number::Unsigned,
    };
    let unit = signal.unit.trim();
    Signal {
        name: signal.name.clone(),
        unit: (!unit.is_empty()).then(|| unit.to_owned()),
        // no frame has so many; more could not be counted on from
        start: usize::try_from(signal.start_bit).unwrap_or(usize::MAX).min(usize::MAX / 16),
        size: usize::try_from(signal.size).unwrap_or(0),
        big_endian: signal.byte_order == ByteOrder::BigEndian,
        kind,
        factor: signal.factor,
        offset: signal.offset,
        switch: switch(dbc, message, signal),
    }
}

/// On what it depends whether a signal is there.
fn switch(dbc: &Dbc, message: &can_dbc::Message, signal: &can_dbc::Signal) -> Option<Switch> {
    let place = |name: &str| message.signals.iter().position(|s| s.name == name);
    let told = dbc
        .extended_multiplex
        .iter()
        .find(|e| e.message_id == message.id && e.signal_name == signal.name);
    if let Some(told) = told {
        let ranges = told.mappings.iter().map(|m| (m.min_value, m.max_value)).collect();
        return Some(Switch { signal: place(&told.multiplexor_signal_name)?, ranges });
    }
    let value = match signal.multiplexer_indicator {
        MultiplexIndicator::MultiplexedSignal(value)
        | MultiplexIndicator::MultiplexorAndMultiplexedSignal(value) => value,
        MultiplexIndicator::Multiplexor | MultiplexIndicator::Plain => return None,
    };
    let is_switch =
        |s: &can_dbc::Signal| matches!(s.multiplexer_indicator, MultiplexIndicator::Multiplexor);
    let at = message.signals.iter().position(is_switch)?;
    Some(Switch { signal: at, ranges: vec![(value, value)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DBC: &str = "VERSION \"\"\nNS_ :\nBS_:\nBU_: A\nBO_ 256 Plain: 8 A\n \
        SG_ low : 0|12@1+ (0.5,10) [0|0] \"km/h\" A\n \
        SG_ high : 23|12@0- (1,0) [0|0] \"\" A\n SG_ single : 32|32@1- (1,0) [0|0] \"m\" A\n\
        BO_ 2147484160 Switched: 4 A\n SG_ mode M : 0|8@1+ (1,0) [0|0] \"\" A\n \
        SG_ a m0 : 8|8@1+ (1,0) [0|0] \"\" A\n SG_ b m1 : 8|8@1- (1,0) [0|0] \"\" A\n\
        SIG_VALTYPE_ 256 single : 1;\n";

    fn database(text: &str) -> Result<Database, Error> {
        Database::read(&Aids { dbc: vec![text.to_owned()], names: Vec::new() })
    }

    #[test]
    fn signals_of_every_kind() {
        let database = database(DBC).expect("a database");
        let plain = &database.messages[database.find(256, false).expect("standard").message];
        let mut data = vec![0x34, 0x02, 0xFF, 0xE0];
        data.extend(1.5_f32.to_le_bytes());
        assert_eq!(plain.value(0, &data), Some(f64::from(0x234) * 0.5 + 10.0));
        assert_eq!(plain.value(1, &data), Some(-2.0));
        assert_eq!(plain.value(2, &data), Some(1.5));
        assert_eq!(plain.value(2, &data[..6]), None, "the frame is too short");
        assert_eq!(plain.signals[0].unit.as_deref(), Some("km/h"));
        assert_eq!(plain.signals[1].unit, None);
        assert_eq!(database.find(256, true), None);
        let switched = &database.messages[database.find(512, true).expect("extended").message];
        assert_eq!(switched.value(1, &[0, 7, 0, 0]), Some(7.0));
        assert_eq!(switched.value(1, &[1, 7, 0, 0]), None);
        assert_eq!(switched.value(2, &[1, 0xFF, 0, 0]), Some(-1.0));
    }

    #[test]
    fn switches_with_ranges() {
        let text = format!("{DBC}SG_MUL_VAL_ 2147484160 a mode 3-5, 9-9;\n");
        let database = database(&text).expect("a database");
        let switched = &database.messages[database.find(512, true).expect("extended").message];
        let there = |mode: u8| switched.value(1, &[mode, 7, 0, 0]).is_some();
        assert_eq!([0, 3, 4, 5, 6, 9].map(there), [false, true, true, true, false, true]);
    }

    #[test]
    fn signals_beyond_every_frame_are_in_none() {
        for start in ["9223372036854775807", "18446744073709551615"] {
            let odd = DBC.replace("0|12@1+", &format!("{start}|12@1+"));
            let odd = odd.replace("23|12@0-", &format!("{start}|12@0-"));
            let database = database(&odd).expect("a database");
            let plain = &database.messages[database.find(256, false).expect("standard").message];
            assert_eq!([0, 1].map(|signal| plain.value(signal, &[7; 8])), [None, None]);
        }
    }

    /// 0x18FEF121 with another source and priority, 0x18EA to another address, and ids that are none of a database.
    #[test]
    fn groups_of_j1939_are_found_whoever_sent_them() {
        let message = |id: u32, name: &str| {
            format!("BO_ {} {name}: 8 A\n SG_ x : 0|8@1+ (1,0) [0|0] \"\" A\n", id | 0x8000_0000)
        };
        let text = |attributes: &str| {
            let two = [message(0x18FE_F121, "CCVS"), message(0x18EA_FF00, "RQST")].concat();
            database(&format!("VERSION \"\"\nNS_ :\nBS_:\nBU_: A\n{two}{attributes}"))
                .expect("a database")
        };
        let enumerated = "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n\
            BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\n";
        let of = |database: &Database, id| {
            database.find(id, true).map(|f| (f.message, f.source, f.said))
        };
        let said = text(enumerated);
        assert_eq!(of(&said, 0x18FE_F121), Some((0, Some(0x21), true)));
        assert_eq!(of(&said, 0x0CFE_F103), Some((0, Some(3), true)));
        assert_eq!(of(&said, 0x18EA_2105), Some((1, Some(5), true)));
        assert_eq!(of(&said, 0x18FE_F221), None, "another group");
        assert_eq!(of(&said, 0x19FE_F121), None, "the data page is part of it");
        assert_eq!(said.find(0xF121, false), None);
        let unsaid = text("");
        assert_eq!(of(&unsaid, 0x18FE_F121), Some((0, None, true)));
        assert_eq!(of(&unsaid, 0x0CFE_F103), Some((0, Some(3), false)));
        assert_eq!(of(&unsaid, 0x18EA_2105), None);
        // extended, but none of J1939
        let whole = text(&format!(
            "{enumerated}BA_ \"VFrameFormat\" BO_ {} 1;\n",
            0x18FE_F121_u32 | 0x8000_0000
        ));
        assert_eq!(of(&whole, 0x18FE_F121), Some((0, None, true)));
        assert_eq!(of(&whole, 0x0CFE_F103), None);
    }

    #[test]
    fn what_is_no_database_is_named() {
        assert_eq!(database("name,unit\n1,2\n").expect_err("no DBC").code.as_str(), "bad_dbc");
    }
}
