//! Values of a tyre bench beside the estimates: `bench.csv` in the output folder, and points of TYDEX files
//! ([`super::bench_points`]).
//!
//! ```csv
//! bike_id,tyre,coefficient,camber,value,std_error
//! mt07,front,cornering_stiffness_0,0,12.4,0.3
//! ,rear,camber_stiffness_0,0.35,1.1,
//! ```
//! `tyre`, `coefficient` and `value` are needed, in SI units as in the table `coefficients`. No
//! bike means every bike; `camber` (rad) is for stiffnesses measured leaning.

use std::path::Path;

use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Part};
use crate::report::as_read;
use crate::report::charts::chart::{Chart, Cloud};
use crate::report::error::Error;
use crate::report::plots::fits::{K_ALPHA, K_GAMMA, STIFFNESS};
use crate::report::session::bench_points::BenchPoints;
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::objects::files::read_text;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::read;
use crate::tyre::tydex::Point;

/// File name in the output folder.
pub(crate) const FILE: &str = "bench.csv";

/// Measurements of a bench.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct BenchValues {
    values: Vec<Value>,
    /// Points of the front and the rear tyre.
    points: BenchPoints,
    /// The files' bytes, for telling whether a page is made of just these.
    pub text: String,
}

#[derive(Debug, Clone, PartialEq)]
struct Value {
    bike: String,
    tyre: String,
    coefficient: String,
    camber: f64,
    value: f64,
    std_error: Option<f64>,
}

/// The bench values of an output; none where there is no such file.
///
/// # Errors
/// The file cannot be read, or a row is wrong: which, and what to do.
pub(crate) fn read(out: &Path) -> Result<BenchValues, Error> {
    let path = out.join(FILE);
    let mut bench = BenchValues::default();
    if path.is_file() {
        let fail =
            |message: String| -> Error { read::Error { path: path.clone(), message }.into() };
        let text = read_text(&path).map_err(|e| fail(e.to_string()))?;
        bench = parse(&text).map_err(|e| fail(e.to_string()))?;
    }
    bench.points = BenchPoints::read(out)?;
    bench.text += &bench.points.text;
    Ok(bench)
}

/// Reads the text of such a file.
///
/// # Errors
/// The row and what is wrong with it.
pub(crate) fn parse(text: &str) -> Result<BenchValues, Mismatch> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let names = reader.headers().map_err(|e| Mismatch::from(e.to_string()))?.clone();
    let known = ["bike_id", "tyre", "coefficient", "camber", "value", "std_error"];
    if let Some(odd) = names.iter().find(|n| !known.contains(n)) {
        return Err(Mismatch::from(format!(
            "column `{odd}` is unknown; known are {}",
            known.join(", ")
        )));
    }
    let place = |name: &str| names.iter().position(|n| n == name);
    for name in ["tyre", "coefficient", "value"] {
        if place(name).is_none() {
            return Err(Mismatch::from(format!("it has no column `{name}`")));
        }
    }
    let mut values = Vec::new();
    for (i, record) in reader.records().enumerate() {
        let line = i + 2;
        let record = record.map_err(|e| Mismatch::from(format!("line {line}: {e}")))?;
        let cell = |name: &str| place(name).and_then(|p| record.get(p)).unwrap_or_default();
        let number = |name: &str| -> Result<Option<f64>, Mismatch> {
            match cell(name) {
                "" => Ok(None),
                text => text
                    .parse()
                    .map(Some)
                    .ok()
                    .filter(|v: &Option<f64>| v.is_some_and(f64::is_finite))
                    .ok_or_else(|| {
                        Mismatch::from(format!(
                            "line {line}, column `{name}`: `{text}` is not a number"
                        ))
                    }),
            }
        };
        let (tyre, coefficient) = (cell("tyre"), cell("coefficient"));
        if Part::from_name(tyre).is_none() {
            return Err(Mismatch::from(format!(
                "line {line}, column `tyre`: `{tyre}` is not front, rear or vehicle"
            )));
        }
        if C::from_name(coefficient).is_none() {
            let names = C::ALL.iter().map(|c| c.name());
            let near = crate::contract::schema::closest(coefficient, names);
            let hint = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            return Err(Mismatch::from(format!(
                "line {line}, column `coefficient`: `{coefficient}` is unknown{hint}"
            )));
        }
        let value =
            number("value")?.ok_or_else(|| Mismatch::from(format!("line {line}: no value")))?;
        values.push(Value {
            bike: cell("bike_id").to_owned(),
            tyre: tyre.to_owned(),
            coefficient: coefficient.to_owned(),
            camber: number("camber")?.unwrap_or(0.0),
            value,
            std_error: number("std_error")?,
        });
    }
    Ok(BenchValues { values, points: BenchPoints::default(), text: text.to_owned() })
}

impl BenchValues {
    fn of<'a>(
        &'a self,
        bike: &'a str,
        tyre: &'a str,
        coefficient: &'a str,
    ) -> impl Iterator<Item = &'a Value> {
        self.values.iter().filter(move |v| {
            (v.bike.is_empty() || v.bike == bike) && v.tyre == tyre && v.coefficient == coefficient
        })
    }

    /// Bench value beside an estimate: its value, and how far the estimate is from it.
    pub(crate) fn beside(
        &self,
        bike: &str,
        tyre: &str,
        coefficient: &str,
        estimate: Option<f64>,
    ) -> Option<String> {
        let found = self.of(bike, tyre, coefficient).find(|v| v.camber == 0.0)?;
        let (value, std_error) = as_read::number(coefficient, found.value, found.std_error);
        let digits = number_format::decimals_of(value, std_error);
        let error = std_error.map(|e| format!(" ± {}", fixed(e, digits)));
        let off = estimate.filter(|_| value != 0.0).map(|e| {
            let off = 100.0 * (e / value - 1.0);
            format!(": {}{} % from it", if off > 0.0 { "+" } else { "" }, fixed(off, 1))
        });
        let text = format!(
            "bench {}{}{}",
            fixed(value, digits),
            error.unwrap_or_default(),
            off.unwrap_or_default()
        );
        Some(typeset(&text))
    }

    /// Points of a tyre bench of one tyre.
    pub(crate) fn points(&self, axle: Axle) -> &[Point] {
        self.points.of(axle)
    }

    /// Puts the bench's stiffnesses into the charts of stiffness over camber, and its points into those of friction.
    pub(crate) fn draw(&self, bike: &str, charts: &mut [Chart]) {
        self.points.draw(charts);
        for (axle, plot) in Axle::BOTH.into_iter().zip(&STIFFNESS) {
            let cloud = self.stiffness(bike, axle);
            let chart = charts.iter_mut().find(|c| c.name == plot.name);
            if let Some(chart) = chart.filter(|_| !cloud.x.is_empty()) {
                chart.clouds.push(cloud);
            }
        }
    }

    /// Measured stiffnesses over camber, in degrees, with their 95 % intervals.
    fn stiffness(&self, bike: &str, axle: Axle) -> Cloud {
        let mut cloud = Cloud {
            name: "bench".into(),
            label: "tyre bench".into(),
            r: Some(4.0),
            ..Cloud::default()
        };
        for (coefficient, label) in
            [(C::CorneringStiffness0, K_ALPHA.label), (C::CamberStiffness0, K_GAMMA.label)]
        {
            for v in self.of(bike, axle.name(), coefficient.name()) {
                cloud.x.push(v.camber.abs().to_degrees());
                cloud.y.push(v.value);
                cloud.w.push(1.0);
                cloud.m.push(None);
                cloud.lo.push(v.std_error.map(|e| v.value - 1.96 * e));
                cloud.hi.push(v.std_error.map(|e| v.value + 1.96 * e));
                cloud.t.push(format!("bench, {label}"));
            }
        }
        cloud
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bench_stands_beside_the_estimate() {
        let text = "tyre,coefficient,value,std_error,camber,bike_id\n\
                    front,cornering_stiffness_0,12.5,0.25,,\n\
                    front,cornering_stiffness_0,13.5,,0.5,a\n";
        let bench = parse(text).expect("bench");
        let beside = |bike| bench.beside(bike, "front", "cornering_stiffness_0", Some(12.0));
        assert_eq!(beside("a").as_deref(), Some("bench 12.50 ± 0.25: −4.0 % from it"));
        assert_eq!(bench.beside("a", "rear", "cornering_stiffness_0", None), None);
        let mut charts = [Chart { name: "stiffness_front".into(), ..Chart::default() }];
        bench.draw("b", &mut charts);
        assert_eq!(charts[0].clouds[0].x, [0.0]);
        bench.draw("a", &mut charts);
        assert_eq!(charts[0].clouds[1].x.len(), 2);
    }

    #[test]
    fn a_wrong_row_is_named() {
        let wrong = |row: &str| {
            parse(&format!("tyre,coefficient,value\n{row}\n")).expect_err(row).to_string()
        };
        assert!(wrong("middle,mf_d,1").starts_with("line 2, column `tyre`: `middle`"));
        assert!(wrong("rear,mf_dd,1").ends_with("did you mean `mf_d`?"));
        assert!(wrong("rear,mf_d,wide").contains("`wide` is not a number"));
        assert!(
            parse("tyre,value\n").expect_err("no column").to_string().contains("`coefficient`")
        );
    }
}
