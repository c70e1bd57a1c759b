//! What a clock is called, in several languages, and which unit its name says.

use crate::ingest::maps::units;

/// Names of clocks in lower case without accents, the surest first, with the unit that the name itself says.
#[rustfmt::skip]
const NAMES: &[(&str, Option<&str>)] = &[
    ("timestamp", None), ("time stamp", None), ("time", None), ("t", None), ("elapsed time", None), ("elapsed", None),
    ("log time", None), ("session time", None), ("run time", None), ("system time", None), ("sample time", None),
    ("recording time", None), ("date time", None), ("datetime", None), ("date and time", None), ("local time", None),
    ("utc time", None), ("time utc", None), ("utc", None), ("gmt", None), ("gps time", None), ("utc timestamp", None),
    ("unix time", None), ("unixtime", None), ("unix timestamp", None), ("unix", None), ("epoch", None), ("epoch time", None),
    ("clock", None), ("date", None), ("datum", None), ("fecha", None), ("tick", None), ("ticks", None), ("interval", None),
    ("time ms", Some("ms")), ("timems", Some("ms")), ("millis", Some("ms")), ("milliseconds", Some("ms")), ("msec", Some("ms")),
    ("time us", Some("us")), ("timeus", Some("us")), ("micros", Some("us")), ("microseconds", Some("us")), ("usec", Some("us")),
    ("time ns", Some("ns")), ("nanos", Some("ns")), ("nanoseconds", Some("ns")), ("nsec", Some("ns")),
    ("itow", Some("ms")), ("i tow", Some("ms")), ("tow", None), ("gps tow", None), ("gps time of week", None), ("ts", None),
    ("gps ts", None), ("datenum", Some("day")), ("date num", Some("day")), ("second", Some("s")),
 ("time of week", None), ("time of day", None), ("logger time", None),
    ("seconds", Some("s")), ("sec", Some("s")), ("secs", Some("s")), ("seconds elapsed", Some("s")), ("time sec", Some("s")),
    ("time s", Some("s")), ("minutes", Some("min")), ("mins", Some("min")), ("time min", Some("min")),
    ("hours", Some("h")), ("time h", Some("h")), ("days", Some("day")), ("ms", Some("ms")), ("us", Some("us")), ("ns", Some("ns")),
    ("s", Some("s")), ("min", Some("min")), ("h", Some("h")),
    // German
    ("zeit", None), ("zeitstempel", None), ("uhrzeit", None), ("messzeit", None), ("laufzeit", None), ("datum uhrzeit", None),
    ("datum zeit", None), ("datum und uhrzeit", None), ("sekunden", Some("s")), ("sek", Some("s")), ("millisekunden", Some("ms")),
    ("mikrosekunden", Some("us")), ("minuten", Some("min")), ("stunden", Some("h")), ("tage", Some("day")),
    // French
    ("temps", None), ("temps ecoule", None), ("temps gps", None), ("temps utc", None), ("heure", None), ("horodatage", None), ("date heure", None), ("date et heure", None),
    ("secondes", Some("s")), ("millisecondes", Some("ms")), ("heures", Some("h")), ("jours", Some("day")),
    // Italian, Spanish, Portuguese
    ("tempo", None), ("ora", None), ("orario", None), ("data ora", None), ("tiempo", None), ("hora", None), ("marca de tiempo", None),
    ("fecha hora", None), ("fecha y hora", None), ("tempo decorrido", None), ("data hora", None), ("carimbo de tempo", None),
    ("secondi", Some("s")), ("segundos", Some("s")), ("millisecondi", Some("ms")), ("milisegundos", Some("ms")),
    ("minuti", Some("min")), ("minutos", Some("min")), ("ore", Some("h")), ("horas", Some("h")), ("giorni", Some("day")),
    // Dutch, the North
    ("tijd", None), ("tijdstempel", None), ("tijdstip", None), ("seconden", Some("s")), ("milliseconden", Some("ms")),
    ("uren", Some("h")), ("tid", None), ("tidpunkt", None), ("tidsstempel", None), ("tidsstampel", None), ("tidspunkt", None),
    ("sekunder", Some("s")), ("minutter", Some("min")), ("minuter", Some("min")), ("klokkeslett", None), ("aika", None),
    ("aikaleima", None), ("sekuntia", Some("s")),
    // the East
    ("czas", None), ("godzina", None), ("znacznik czasu", None), ("sekundy", Some("s")), ("milisekundy", Some("ms")),
    ("minuty", Some("min")), ("godziny", Some("h")), ("cas", None), ("ido", None), ("idobelyeg", None), ("zaman", None), ("sure", None),
    ("timp", None), ("vreme", None), ("vrijeme", None), ("время", None), ("час", None), ("время с", Some("s")), ("χρονος", None),
    ("时间", None), ("時間", None), ("時刻", None), ("시간", None),
];

/// Words that make a time no clock: of a lap, to go, of a reaction.
#[rustfmt::skip]
const NOT: &[&str] = &[
    "lap", "laps", "best", "last", "sector", "split", "delta", "predictive", "predicted", "trigger", "injection", "dwell",
    "left", "remaining", "diff", "gap", "runden", "rundenzeit", "runde", "tour", "giro", "vuelta", "volta", "ronde",
    "reaction", "shift", "accuracy", "acc", "zone", "offset", "error", "valid", "fix", "temp", "temperature", "rate",
];

/// How well a column's name suits a clock, the smaller the better, and the unit that the name says without brackets.
///
/// What stands in brackets after the name is gone before: [`units::of_name`].
pub(crate) fn clock(name: &str) -> Option<(usize, Option<&'static str>)> {
    let plain = folded(units::of_name(name).0);
    if let Some(place) = NAMES.iter().position(|(n, _)| *n == plain) {
        return Some((place, NAMES[place].1));
    }
    // more words than the list has: `GPS UTC Time`, `time (since start)`
    let mut words = plain.split(' ');
    if words.clone().count() > 5 || words.clone().any(|w| NOT.contains(&w)) {
        return None;
    }
    let known = words.find_map(|word| {
        let sure = NAMES.iter().take_while(|n| n.0 != "milliseconds").chain(foreign());
        sure.filter(|n| n.0.len() > 1).find(|n| n.0 == word)
    });
    let unit = plain
        .rsplit(' ')
        .next()
        .and_then(|last| ["ms", "us", "ns", "s", "sec", "min"].into_iter().find(|u| *u == last));
    known.map(|k| (NAMES.len(), unit.or(k.1)))
}

/// Names of other languages that are one word and a time of any kind.
fn foreign() -> impl Iterator<Item = &'static (&'static str, Option<&'static str>)> {
    let start = NAMES.iter().position(|n| n.0 == "zeit").unwrap_or(NAMES.len());
    // in English these are temperatures
    NAMES[start..].iter().filter(|n| n.1.is_none() && n.0.len() > 3 && n.0 != "temps")
}

/// A name in lower case without accents; what is no letter is one blank, and so is the border before a capital.
pub(crate) fn folded(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    let mut last = ' ';
    for c in name.chars() {
        if !c.is_alphanumeric() {
            if !out.ends_with(' ') {
                out.push(' ');
            }
        } else {
            if c.is_uppercase() && last.is_lowercase() {
                out.push(' ');
            }
            c.to_lowercase().for_each(|c| fold(c, &mut out));
        }
        last = c;
    }
    out.trim().to_owned()
}

/// A letter without its accent.
fn fold(c: char, out: &mut String) {
    let plain = match c {
        'à' | 'á' | 'â' | 'ã' | 'ä' | 'å' | 'ą' | 'ă' => "a",
        'ç' | 'ć' | 'č' => "c",
        'ď' | 'đ' => "d",
        'è' | 'é' | 'ê' | 'ë' | 'ę' | 'ě' => "e",
        'ğ' => "g",
        'ì' | 'í' | 'î' | 'ï' | 'ı' => "i",
        'ł' => "l",
        'ñ' | 'ń' | 'ň' => "n",
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' | 'ø' | 'ő' => "o",
        'ř' => "r",
        'ś' | 'š' | 'ş' | 'ș' => "s",
        'ß' => "ss",
        'ť' | 'ț' => "t",
        'ù' | 'ú' | 'û' | 'ü' | 'ů' | 'ű' => "u",
        'ý' | 'ÿ' => "y",
        'ź' | 'ż' | 'ž' => "z",
        'æ' => "ae",
        'ό' => "ο",
        // the dot of a Turkish capital, and accents on their own
        '\u{300}'..='\u{36f}' => "",
        c => return out.push(c),
    };
    out.push_str(plain);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_of_many_countries() {
        for (name, unit) in [
            ("Time", None),
            ("Time (s)", None),
            ("timestamp", None),
            ("TimeStamp", None),
            ("utc (ms)", None),
            ("UTC Time", None),
            ("GPS UTC Time", None),
            ("Minutes", Some("min")),
            ("millis", Some("ms")),
            ("time_ms", Some("ms")),
            ("TimeMs", Some("ms")),
            ("Zeit [s]", None),
            ("Uhrzeit", None),
            ("Temps", None),
            ("Temps écoulé (s)", None),
            ("Tempo", None),
            ("Tiempo", None),
            ("Tijd", None),
            ("Czas", None),
            ("Čas", None),
            ("Sekunden", Some("s")),
            ("Время", None),
            ("t", None),
            ("iTOW", Some("ms")),
            ("ts", None),
            ("GPS TOW", None),
            ("datenum", Some("day")),
        ] {
            let found = clock(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(found.1, unit, "{name}");
        }
        for name in [
            "Lap Time",
            "best time",
            "Speed",
            "Trigger time",
            "T_air",
            "Time Accuracy",
            "Rundenzeit",
            "Temp",
            "Tyre temps",
            "Gear shift time",
            "Delta time",
            "acc_s",
            "g",
        ] {
            assert!(clock(name).is_none(), "{name}: {:?}", clock(name));
        }
        let rank = |name: &str| clock(name).expect(name).0;
        assert!(rank("Time") < rank("GPS UTC Time") && rank("timestamp") < rank("Seconds"));
    }
}
