//! Positions in a delimited text, however they are written.
//!
//! A column that is called like a latitude or a longitude holds degrees, with or without a letter of its hemisphere
//! (`40.0 N`, `W105.0`), degrees, minutes and seconds (`47°00'12.5"N`), degrees and minutes in one number as NMEA writes
//! them (`4700.123`), or degrees in another scale. The letter may stand in a column of its own or in the name. One cell
//! may hold both (`47.0, 8.0`, `POINT(8.0 47.0)`). What cannot be decided is left out of a draft, with the reason: a
//! mirrored position is worse than none.

use std::f64::consts::{FRAC_PI_2, PI};

use super::coordinate::{Axis, Coordinate, Form, O, apart, half, letter, pair, well_known};
use super::notation::{SEMICIRCLE, form_of_name, is_half, tokens};
use crate::contract::channel::Channel;
use crate::ingest::formats::listing::SourceChannel;
use crate::ingest::maps::propose::{columns_called, is_called};
use crate::ingest::maps::units;

/// Code of the warning about a position whose notation is not sure.
pub(super) const CODE: &str = "position_notation";

/// Names of columns that hold both coordinates, beginnings of their words.
const BOTH: [&str; 14] = [
    "position", "pos", "coord", "location", "latlon", "latlng", "latitude", "lat", "gps", "geom",
    "wkt", "point", "koord", "coorden",
];

/// Observations of the positions in a text.
#[derive(Debug, Clone, Default)]
pub(crate) struct Positions {
    /// By place in a row; after those the parts of cells that hold both.
    pub coordinates: Vec<Option<Coordinate>>,
    /// Places of the letters' columns, and of the coordinates that they belong to.
    pub letters: Vec<(usize, usize)>,
    /// Places of columns that hold a position which cannot be read, and why, with the way out.
    pub left_out: Vec<(usize, String)>,
    /// Places of columns whose notation was guessed, and what was guessed.
    pub guessed: Vec<(usize, String)>,
}

impl Positions {
    /// Looks at the names and the first rows.
    pub(super) fn look(names: &[String], rows: &[Vec<String>], decimal: char) -> Self {
        let mut seen = Positions { coordinates: vec![None; names.len()], ..Self::default() };
        let at = |channel: Channel| -> Vec<usize> {
            let is = |i: &usize| {
                let letters = letters_of(rows, *i).is_some() || is_half(&tokens(&names[*i]));
                is_called(&names[*i], channel) && !letters
            };
            (0..names.len()).filter(is).collect()
        };
        let places = [at(Channel::Latitude), at(Channel::Longitude)];
        for (axis, places) in [Axis::North, Axis::East].into_iter().zip(&places) {
            for &place in places.iter().filter(|p| !is_pair(names, rows, **p, decimal)) {
                seen.coordinates[place] = Some(Coordinate::of_name(&names[place], place, axis));
            }
        }
        seen.pair_letters(names, rows);
        let both = places[0].iter().zip(&places[1]);
        for (&north, &east) in both.filter(|(a, b)| a != b) {
            seen.form(names, rows, [north, east], decimal);
        }
        seen.turned(names, rows, decimal);
        seen.pairs(names, rows, decimal);
        for &(place, _) in &seen.left_out {
            seen.coordinates[place] = None;
        }
        seen
    }

    /// The unit of a column once it is read, where it is not as before.
    pub(super) fn unit(&self, place: usize) -> Option<&'static str> {
        self.coordinates.get(place)?.as_ref().filter(|c| c.degrees).map(|_| "deg")
    }

    /// Whether a column has no numbers of its own that can be read: letters of a coordinate, two coordinates, or a
    /// position that is left out.
    pub(super) fn is_none(&self, place: usize) -> bool {
        let parts = self.coordinates.iter().flatten().any(|c| c.is_part() && c.cell == place);
        parts
            || self.letters.iter().any(|l| l.0 == place)
            || self.left_out.iter().any(|l| l.0 == place)
    }

    /// Text about a column.
    pub(super) fn said(&self, place: usize) -> impl Iterator<Item = &str> {
        let of = move |l: &&(usize, String)| l.0 == place;
        self.left_out.iter().chain(&self.guessed).filter(of).map(|l| l.1.as_str())
    }

    /// The coordinates that cells with both hold, as channels in a group of the column's name.
    pub(super) fn parts_of(&self, names: &[String]) -> Vec<SourceChannel> {
        let parts = self.coordinates.iter().enumerate().filter_map(|(place, c)| {
            let c = c.as_ref().filter(|c| c.is_part())?;
            Some(SourceChannel {
                group: names[c.cell].clone(),
                name: (if c.axis == Axis::North { "latitude" } else { "longitude" }).to_owned(),
                unit: Some("deg".to_owned()),
                place: [place, 0, 0],
                ..SourceChannel::default()
            })
        });
        parts.collect()
    }

    /// Gives columns of letters to their coordinates: a column of its own beside, or one that is called so.
    fn pair_letters(&mut self, names: &[String], rows: &[Vec<String>]) {
        for (axis, other) in [(Axis::North, ["n", "s"]), (Axis::East, ["e", "w"])] {
            let of_axis = |c: &Coordinate| c.axis == axis;
            let places: Vec<usize> = (0..names.len())
                .filter(|i| self.coordinates[*i].as_ref().is_some_and(of_axis))
                .collect();
            let own = if axis == Axis::North { Channel::Latitude } else { Channel::Longitude };
            for place in 0..names.len() {
                let words = tokens(&names[place]);
                let called = other.iter().all(|l| words.iter().any(|w| w == l))
                    || words.iter().any(|w| *w == other.concat())
                    || (is_half(&words) && is_called(&names[place], own));
                let beside = places.iter().any(|p| p.abs_diff(place) == 1);
                let taken = self.coordinates[place].is_some()
                    || CALLED.iter().any(|c| *c != own && is_called(&names[place], *c));
                let fits = match letters_of(rows, place) {
                    Some(letters) => {
                        letters.iter().all(|l| half(*l, axis, O::East).is_some())
                            && (called || beside || is_called(&names[place], own))
                    }
                    // still empty where the receiver has no fix
                    None => {
                        called && rows.iter().all(|r| r.get(place).is_none_or(String::is_empty))
                    }
                };
                if taken || !fits {
                    continue;
                }
                let before = place.checked_sub(1).filter(|p| places.contains(p));
                let Some(number) = before.or(places.first().copied().filter(|_| places.len() == 1))
                else {
                    for &p in &places {
                        self.left_out.push((
                            p,
                            format!(
                                "column `{}` holds letters of a hemisphere, which may belong to {} \
                             columns; put it directly after the column it belongs to",
                                names[place],
                                places.len()
                            ),
                        ));
                    }
                    continue;
                };
                let has = |letter: &str| words.iter().any(|w| w == letter);
                let o = match (has("w") || has("ow"), has("e") || has("eo")) {
                    (true, _) => O::East,
                    (_, true) => O::West,
                    _ => O::Unknown,
                };
                if letters_of(rows, place).is_some_and(|l| l.contains(&'O')) && o == O::Unknown {
                    self.left_out.push((number, letter_o(&names[place])));
                }
                if let Some(c) = &mut self.coordinates[number] {
                    (c.letters, c.o, c.degrees, c.turned) = (Some(place), o, true, false);
                }
                self.letters.push((place, number));
            }
        }
    }

    /// Notation of the numbers of a latitude and its longitude: by their names, or by their size.
    fn form(&mut self, names: &[String], rows: &[Vec<String>], places: [usize; 2], decimal: char) {
        let said = places.map(|p| form_of_name(&names[p]));
        if said.iter().any(Option::is_some) {
            let either = said[0].or(said[1]);
            for (place, own) in places.into_iter().zip(said) {
                if let (Some(c), Some(form)) = (&mut self.coordinates[place], own.or(either)) {
                    (c.form, c.degrees) = (form, true);
                }
            }
            return;
        }
        if places.iter().any(|p| units::of_name(&names[*p]).1.is_some_and(is_angle)) {
            return;
        }
        let mut numbers = [Vec::new(), Vec::new()];
        let (mut letters, mut o, mut parts) = ([false; 2], false, [false; 2]);
        for (k, &place) in places.iter().enumerate() {
            let Some(coordinate) = &self.coordinates[place] else { return };
            letters[k] = coordinate.letters.is_some();
            for cell in rows.iter().filter_map(|r| r.get(place)) {
                let Some(read) = apart(cell, decimal) else { continue };
                letters[k] |= read.letter.is_some();
                o |= read.letter == Some('O');
                match read.numbers[..] {
                    [x] if x != 0.0 => numbers[k].push(x.abs()),
                    [_, _, ..] => parts[k] = true,
                    _ => {}
                }
            }
        }
        for (k, &place) in places.iter().enumerate() {
            if let Some(c) = &mut self.coordinates[place] {
                c.degrees |= letters[k] || parts[k];
                if o && c.letters.is_none() && c.axis == Axis::East {
                    self.left_out.push((place, letter_o(&names[place])));
                }
            }
        }
        let beyond = |k: usize, limit: f64| {
            2 * numbers[k].iter().filter(|x| **x > limit).count() > numbers[k].len()
        };
        if !(beyond(0, 90.0) || beyond(1, 180.0)) {
            let within = |k: usize, limit: f64| numbers[k].iter().all(|x| *x <= limit);
            let (far, contract) =
                (numbers.iter().flatten().any(|x| *x > 0.05), Channel::Latitude.name());
            // the sea off Guinea, or radians
            if far && within(0, FRAC_PI_2) && within(1, PI) && names[places[0]] != contract {
                self.guessed.push((places[0], format!(
                    "columns `{}` and `{}` are taken for degrees; if they are radians, write `(rad)` after the names",
                    names[places[0]], names[places[1]]
                )));
            }
            return;
        }
        let most = |k: usize| numbers[k].iter().fold(0.0_f64, |m, x| m.max(*x));
        let all = |test: &dyn Fn(f64) -> bool| numbers.iter().flatten().all(|x| test(*x));
        let packed = most(0) <= 9000.0 && most(1) <= 18_000.0 && all(&|x| x % 100.0 < 60.0);
        let whole = all(&|x| x.fract() == 0.0);
        let columns = format!("columns `{}` and `{}`", names[places[0]], names[places[1]]);
        let mut take = |form: Form| {
            for place in places {
                if let Some(c) = &mut self.coordinates[place] {
                    (c.form, c.degrees) = (form, true);
                }
            }
        };
        if packed && letters.iter().any(|l| *l) {
            take(Form::Minutes);
        } else if whole && (most(0) > 9e7 || most(1) > 1.8e8) && most(0) <= 9e8 && most(1) <= 1.8e9
        {
            let garmin = names[places[0]].to_lowercase().starts_with("position_lat");
            let (form, what) = match garmin {
                true => (Form::Scaled(SEMICIRCLE), "semicircles"),
                false => (Form::Scaled(1e-7), "degrees times 10 000 000"),
            };
            take(form);
            self.guessed.push((places[0], format!(
                "{columns} hold whole numbers beyond any angle: they are taken for {what}; if they are not, write \
                 `(semicircles)` or `(1e-7 deg)` after the names"
            )));
        } else {
            let what = if whole && !packed {
                "whole numbers beyond any angle: degrees in another scale? Write it after the names, `(1e-6 deg)`, \
                 `(1e-7 deg)` or `(semicircles)`, or give `scale` in the map"
            } else if packed {
                "numbers beyond any angle: degrees and minutes in one number, or minutes? Write `(ddmm.mmmm)` or `(min)` \
                 after the names"
            } else {
                "numbers that are no angle on a globe: write them in degrees, or give `scale` in the map"
            };
            self.left_out.extend(places.map(|p| (p, format!("{columns} hold {what}"))));
        }
    }

    /// Names that say south or west: positive is there, unless everything is negative already.
    fn turned(&mut self, names: &[String], rows: &[Vec<String>], decimal: char) {
        for (place, c) in self.coordinates.iter_mut().enumerate() {
            let Some(c) = c.as_mut().filter(|c| c.turned) else { continue };
            let cells = rows.iter().filter_map(|r| apart(r.get(place)?, decimal));
            let numbers: Vec<f64> = cells.map(|a| a.numbers[0]).filter(|x| *x != 0.0).collect();
            if !numbers.is_empty() && numbers.iter().all(|x| *x < 0.0) {
                let [half, other] = match c.axis {
                    Axis::North => ["south", "north"],
                    Axis::East => ["west", "east"],
                };
                self.left_out.push((place, format!(
                    "column `{}` says {half} and holds negative numbers: are they {half} or {other}? Take the letter out \
                     of its name if negative is {half}",
                    names[place]
                )));
            }
        }
    }

    /// Columns that hold both coordinates.
    fn pairs(&mut self, names: &[String], rows: &[Vec<String>], decimal: char) {
        for place in 0..names.len() {
            if self.coordinates[place].is_some() || !is_pair(names, rows, place, decimal) {
                continue;
            }
            for (part, axis) in [Axis::North, Axis::East].into_iter().enumerate() {
                let plain = Coordinate::of_name("", place, axis);
                self.coordinates.push(Some(Coordinate {
                    part: Some(part),
                    degrees: true,
                    ..plain
                }));
            }
            let text = rows.iter().filter_map(|r| r.get(place)).find(|c| !c.is_empty());
            if text.is_some_and(|t| well_known(t).is_none()) {
                self.guessed.push((place, format!(
                    "column `{}` holds two numbers: they are taken for latitude and longitude, in this order",
                    names[place]
                )));
            }
        }
    }
}

/// Columns of letters `N`, `E` and the like that are none of a hemisphere: a gear in neutral.
const CALLED: [Channel; 4] = [Channel::Gear, Channel::Yaw, Channel::Latitude, Channel::Longitude];

fn is_angle(unit: &str) -> bool {
    units::dimension(unit) == Some("angle")
}

/// Whether the cells of a column hold both coordinates.
fn is_pair(names: &[String], rows: &[Vec<String>], place: usize, decimal: char) -> bool {
    let words = tokens(&names[place]);
    let of = |channel: Channel| is_called(&names[place], channel);
    let other = |c: &Channel| !matches!(c, Channel::Latitude | Channel::Longitude);
    let one = of(Channel::Latitude) != of(Channel::Longitude)
        || columns_called(&names[place]).iter().any(other);
    let named = !one && words.iter().any(|w| BOTH.iter().any(|b| w.starts_with(b)));
    let filled = rows.iter().filter_map(|r| r.get(place)).filter(|c| !c.is_empty());
    let pairs = filled.clone().filter(|c| {
        let wkt = well_known(c).is_some();
        (wkt || named) && pair(c, decimal).is_some_and(|[n, e]| n.abs() <= 90.0 && e.abs() <= 180.0)
    });
    let count = filled.count();
    count > 0 && 2 * pairs.count() > count
}

fn letter_o(name: &str) -> String {
    format!(
        "column `{name}` holds the letter `O`, which is east in some languages and west in others; write `E` or `W`"
    )
}

/// The different capitals that a column's cells hold, if they hold nothing but single letters or words of the sky.
fn letters_of(rows: &[Vec<String>], place: usize) -> Option<Vec<char>> {
    let mut letters = Vec::new();
    for cell in rows.iter().filter_map(|r| r.get(place)).filter(|c| !c.is_empty()) {
        let letter = letter(cell)?;
        if !letters.contains(&letter) {
            letters.push(letter);
        }
    }
    (!letters.is_empty()).then_some(letters)
}

#[cfg(test)]
mod tests {
    use ::csv::ByteRecord;

    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    /// Reads one row of a text whose rows are all like it; `None` where a column is left out or is no coordinate.
    fn read(header: &[&str], row: &[&str], decimal: char) -> Vec<Option<f64>> {
        let names = names(header);
        let cells: Vec<String> = row.iter().map(|c| (*c).to_owned()).collect();
        let seen = Positions::look(&names, &[cells.clone(), cells], decimal);
        let record = ByteRecord::from(row.to_vec());
        let one = |c: &Option<Coordinate>| c.as_ref()?.read(&record, decimal).ok()?;
        seen.coordinates.iter().map(one).collect()
    }

    #[test]
    fn positions_are_read_however_they_are_written() {
        let pair = ["Latitude", "Longitude"];
        let cases: [(&[&str], &[&str], [f64; 2]); 17] = [
            (&pair, &["40.0 N", "105.5 W"], [40.0, -105.5]),
            (&pair, &["40.0N", "105.5W"], [40.0, -105.5]),
            (&pair, &["S33.4", "W70.6"], [-33.4, -70.6]),
            (&pair, &["-33.4 S", "-70.6"], [-33.4, -70.6]),
            (&pair, &["47°30'36.0\"N", "8°15'00.0\"W"], [47.51, -8.25]),
            (&pair, &["4730.6N", "00815.0E"], [47.51, 8.25]),
            (&pair, &["47 30.6", "8 15.0"], [47.51, 8.25]),
            (&["Lat (ddmm.mmmm)", "Lon (dddmm.mmmm)"], &["4730.6", "00815.0"], [47.51, 8.25]),
            (&["lat", "lon"], &["475100000", "82500000"], [47.51, 8.25]),
            (&["LatitudeE6", "LongitudeE6"], &["47510000", "-8250000"], [47.51, -8.25]),
            (&["lat_e7", "lon_e7"], &["475100000", "82500000"], [47.51, 8.25]),
            (
                &["Latitude (1e-7 deg)", "Longitude (1e-7 deg)"],
                &["475100000", "82500000"],
                [47.51, 8.25],
            ),
            (&["Latitude (min)", "Longitude (min)"], &["2850.6", "495"], [47.51, 8.25]),
            (&["Latitude (N)", "Longitude (W)"], &["47.51", "8.25"], [47.51, -8.25]),
            (&["Latitude (N)", "Longitude (E)"], &["47.51", "-8.25"], [47.51, -8.25]),
            (&["Latitude", "Longitude West"], &["47.51", "8.25"], [47.51, -8.25]),
            (&["Latitude", "Longitude (W-)"], &["47.51", "-8.25"], [47.51, -8.25]),
        ];
        for (header, row, wanted) in cases {
            let found = read(header, row, '.');
            for (x, wanted) in found.iter().zip(wanted) {
                let x = x.unwrap_or(f64::NAN);
                assert!((x - wanted).abs() < 1e-9, "{header:?} {row:?}: {found:?}");
            }
        }
        let found = read(
            &["position_lat (semicircles)", "position_long (semicircles)"],
            &["560731841", "95443717"],
            '.',
        );
        assert!((found[0].expect("read") - 47.0).abs() < 1e-6, "{found:?}");
        assert!((found[1].expect("read") - 8.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn letters_may_have_columns_of_their_own() {
        let header = ["t", "Latitude", "Longitude", "Gear", "N/S", "E/W"];
        let found = read(&header, &["0", "33.4", "70.6", "N", "S", "W"], '.');
        assert_eq!(found[1..3], [Some(-33.4), Some(-70.6)]);
        let found =
            read(&["lat", "lat_ref", "lon", "lon_ref"], &["4730.6", "N", "00815.0", "W"], '.');
        assert!((found[2].expect("read") + 8.25).abs() < 1e-9, "{found:?}");
        // no letter, no half
        let found = read(&header, &["0", "33.4", "70.6", "N", "", ""], '.');
        assert_eq!(found[1..3], [None, None]);
        // a gear in neutral after the latitude is no hemisphere
        let found = read(&["Latitude", "Gear", "Longitude"], &["33.4", "N", "70.6"], '.');
        assert_eq!(found, [Some(33.4), None, Some(70.6)]);
    }

    #[test]
    fn what_cannot_be_decided_is_left_out_with_the_reason() {
        for (header, row, words) in [
            (["Latitude", "Longitude (W)"], ["40.0", "-105.0"], "west or east"),
            (["Latitude", "Longitude"], ["40.0 N", "10.0 O"], "`O`"),
            (["Latitude", "Longitude"], ["4700.5", "00800.5"], "(ddmm.mmmm)"),
            (["lat", "lon"], ["47000000", "8000000"], "(1e-6 deg)"),
        ] {
            let rows = [row.map(str::to_owned).to_vec()];
            let seen = Positions::look(&names(&header), &rows, '.');
            assert!(seen.left_out.iter().any(|l| l.1.contains(words)), "{row:?}: {seen:?}");
            assert!(seen.left_out.iter().all(|l| seen.coordinates[l.0].is_none()));
        }
    }

    #[test]
    fn one_cell_may_hold_both() {
        for (name, cell) in [
            ("Position", "47.5,8.25"),
            ("GPS (lat, lon)", "47.5 8.25"),
            ("geom", "POINT(8.25 47.5)"),
            ("x", "SRID=4326;POINT Z (8.25 47.5 400)"),
            ("Coordinates", "N47.5, E8.25"),
        ] {
            let found = read(&["t", name], &["0", cell], '.');
            assert_eq!(found[2..], [Some(47.5), Some(8.25)], "{name}: {cell}");
        }
        assert_eq!(read(&["t", "tyres"], &["0", "2.5,2.9"], '.').len(), 2);
    }

    #[test]
    fn plain_degrees_stay_as_they_are() {
        let names = names(&["Latitude", "Longitude"]);
        let seen = Positions::look(&names, &[vec!["47.5".into(), "-8.25".into()]], '.');
        assert!(seen.unit(0).is_none() && seen.left_out.is_empty() && seen.guessed.is_empty());
        assert_eq!(read(&["lat", "lon"], &["47,5", "-8,25"], ','), [Some(47.5), Some(-8.25)]);
        assert_eq!(
            read(&["lat (rad)", "lon (rad)"], &["0.8", "-0.1"], '.'),
            [Some(0.8), Some(-0.1)]
        );
    }
}
