//! A fitted tyre as a simulation unit of FMI 3.0: sources in C, for model exchange and co-simulation.
//!
//! The unit has no binaries: who imports it compiles it, so that one file serves every system. Its sources are the C
//! header of [`super::header`] and the interface in `fmu.c`. Every number of the tyre is a parameter that can be tuned.

use std::io::Write;

use flate2::Compression;
use flate2::write::DeflateEncoder;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use rawzip::time::UtcDateTime;
use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::ends::Ends;
use super::file::one_line;
use super::fitted::Fitted;
use super::numbers;
use super::origins;
use super::tyre::Characterised;
use super::{csv, header};

use crate::report::export::error::Error;

/// `fmu.c`, whose value references are those of [`VARIABLES`].
const SOURCE: &str = include_str!("fmu.c");
/// Name of the library that an importer makes.
const IDENTIFIER: &str = "roadbench_tyre";
/// First value reference of a number of the tyre.
const FIRST_NUMBER: usize = 100;
/// Value references of the rate of the lagged slip angle, and of the first output.
const RATE: usize = 8;
const FIRST_OUTPUT: usize = 9;

/// Causality, name, unit and description of a variable of real numbers, in the order of their value references.
const VARIABLES: [(&str, &str, &str, &str); 15] = [
    ("independent", "time", "s", "Time"),
    ("input", "slip_ratio", "", "Slip ratio, positive driving"),
    ("input", "slip_angle", "rad", "Kinematic slip angle, positive: pulls to the right"),
    ("input", "camber", "rad", "Camber; negative in a left-hand corner"),
    ("input", "load", "N", "Wheel load"),
    ("input", "friction", "", "Friction of the road; at the start that of the ride"),
    ("input", "wheel_speed", "rad/s", "Speed of the wheel"),
    ("local", "lagged_slip_angle", "rad", "Slip angle that acts, after the relaxation length"),
    ("local", "der(lagged_slip_angle)", "rad/s", "Its rate"),
    ("output", "force_x", "N", "Longitudinal force, forwards; rolling resistance comes on top"),
    ("output", "force_y", "N", "Lateral force, to the left"),
    ("output", "moment_x", "N.m", "Overturning moment"),
    ("output", "moment_z", "N.m", "Aligning moment"),
    ("output", "rolling_force", "N", "Rolling resistance, a force along x"),
    (
        "output",
        "effective_radius",
        "m",
        "Effective rolling radius under this load and camber, at this speed",
    ),
];
/// The output that is true or false.
const RIDDEN: (&str, &str) = ("ridden", "Whether a ride was like this; false: extrapolated");

/// Of every file in it, so that the same tyre is the same bytes: the first day that an archive knows.
const DATE: UtcDateTime = match UtcDateTime::from_components(1980, 1, 1, 0, 0, 0, 0) {
    Some(date) => date,
    None => panic!("a date"),
};

/// Units by their exponents of SI's base units.
const UNITS: [(&str, &[(&str, &str)]); 11] = [
    ("s", &[("s", "1")]),
    ("rad", &[("rad", "1")]),
    ("rad/s", &[("rad", "1"), ("s", "-1")]),
    ("m", &[("m", "1")]),
    ("m/rad", &[("m", "1"), ("rad", "-1")]),
    ("N", &[("kg", "1"), ("m", "1"), ("s", "-2")]),
    ("N.m", &[("kg", "1"), ("m", "2"), ("s", "-2")]),
    ("N/m", &[("kg", "1"), ("s", "-2")]),
    ("s/m", &[("s", "1"), ("m", "-1")]),
    ("1/kN", &[("kg", "-1"), ("m", "-1"), ("s", "2"), ("factor", "0.001")]),
    ("1/rad2", &[("rad", "-2")]),
];

/// The bytes of the unit of one tyre, a zip archive.
///
/// # Errors
/// A sentence that names the half of the tyre that was not ridden: the unit evaluates whole tyres.
pub(crate) fn write(fitted: &Fitted, tyre: &Characterised) -> Result<Vec<u8>, Error> {
    let header = header::write(fitted, std::slice::from_ref(tyre))?;
    // of the tyre and the interface alone: the same unit of the same session, on any day
    let token = blake3::hash([header.as_bytes(), SOURCE.as_bytes()].concat().as_slice()).to_hex();
    let token = &token[..32];
    let source = SOURCE.replace("@@TYRE@@", tyre.axle.name()).replace("@@TOKEN@@", token);
    let axle = tyre.axle;
    let at_rest = (tyre.error.friction_load != 0.0).then_some((axle, tyre.tyre.tyre.friction.d));
    let coefficients = fitted.to_toml(Some(axle.name()), at_rest.as_slice())?;
    let files: [(&str, Vec<u8>); 6] = [
        ("modelDescription.xml", description(fitted, tyre, token).map_err(failed)?),
        ("sources/buildDescription.xml", build().map_err(failed)?),
        ("sources/roadbench_tyre.c", source.into_bytes()),
        ("sources/roadbench_tyre.h", header.into_bytes()),
        ("documentation/coefficients.toml", coefficients.into_bytes()),
        ("documentation/tables.csv", csv::write(fitted, std::slice::from_ref(tyre)).into_bytes()),
    ];
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for (name, content) in files {
        let file = archive
            .new_file(name)
            .last_modified(DATE)
            .compression_method(CompressionMethod::DEFLATE);
        let (mut entry, config) = file.start().map_err(failed)?;
        let mut writer = config.wrap(DeflateEncoder::new(&mut entry, Compression::default()));
        writer.write_all(&content).map_err(failed)?;
        let (deflate, end) = writer.finish().map_err(failed)?;
        deflate.finish().map_err(failed)?;
        entry.finish(end).map_err(failed)?;
    }
    archive.finish().map_err(failed)?;
    Ok(bytes)
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Packing(format!("cannot write the simulation unit: {error}"))
}

type Xml = Writer<Vec<u8>>;

fn document() -> std::io::Result<Xml> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    Ok(xml)
}

fn build() -> std::io::Result<Vec<u8>> {
    let mut xml = document()?;
    xml.create_element("fmiBuildDescription")
        .with_attribute(("fmiVersion", "3.0"))
        .write_inner_content(|xml| {
            let configuration = xml.create_element("BuildConfiguration");
            configuration.with_attribute(("modelIdentifier", IDENTIFIER)).write_inner_content(
                |xml| {
                    let set =
                        xml.create_element("SourceFileSet").with_attribute(("language", "C99"));
                    set.write_inner_content(|xml| {
                        xml.create_element("SourceFile")
                            .with_attribute(("name", "roadbench_tyre.c"))
                            .write_empty()?;
                        Ok(())
                    })?;
                    Ok(())
                },
            )?;
            Ok(())
        })?;
    Ok(xml.into_inner())
}

fn description(fitted: &Fitted, tyre: &Characterised, token: &str) -> std::io::Result<Vec<u8>> {
    let ident = &fitted.session.ident;
    let whose =
        format!("{} tyre of {}, session {}", tyre.axle.name(), ident.bike_id, ident.session_id);
    let adjusted = [tyre.adjustment().join(" "), tyre.share_line()];
    let axes = ["SI units; axes of ISO 8855: x forward, y left, z up".to_owned()];
    let what = [&axes[..], &adjusted[..], tyre.effects(&[]).as_slice()].concat();
    let generator = format!("roadbench {}", crate::VERSION);
    let mut xml = document()?;
    let root = xml.create_element("fmiModelDescription").with_attributes([
        ("fmiVersion", "3.0"),
        ("modelName", one_line(&whose).as_str()),
        ("instantiationToken", token),
        ("description", one_line(&what.join("; ")).as_str()),
        ("generationTool", generator.as_str()),
        ("variableNamingConvention", "structured"),
    ]);
    root.write_inner_content(|xml| {
        let state = [("canGetAndSetFMUState", "true"), ("canSerializeFMUState", "true")];
        let interface = |xml: &mut Xml, name: &str, more: &[(&str, &str)]| {
            let element = xml.create_element(name).with_attribute(("modelIdentifier", IDENTIFIER));
            element
                .with_attributes(state)
                .with_attributes(more.iter().copied())
                .write_empty()
                .map(drop)
        };
        interface(xml, "ModelExchange", &[])?;
        interface(xml, "CoSimulation", &[("canHandleVariableCommunicationStepSize", "true")])?;
        xml.create_element("UnitDefinitions").write_inner_content(units)?;
        xml.create_element("DefaultExperiment")
            .with_attributes([("startTime", "0"), ("stopTime", "1")])
            .write_empty()?;
        xml.create_element("ModelVariables")
            .write_inner_content(|xml| variables(xml, fitted, tyre))?;
        xml.create_element("ModelStructure").write_inner_content(structure)?;
        Ok(())
    })?;
    Ok(xml.into_inner())
}

fn units(xml: &mut Xml) -> std::io::Result<()> {
    for (name, base) in UNITS {
        xml.create_element("Unit").with_attribute(("name", name)).write_inner_content(|xml| {
            xml.create_element("BaseUnit").with_attributes(base.iter().copied()).write_empty()?;
            Ok(())
        })?;
    }
    Ok(())
}

fn variables(xml: &mut Xml, fitted: &Fitted, tyre: &Characterised) -> std::io::Result<()> {
    let own = &tyre.tyre;
    for (reference, (causality, name, unit, text)) in VARIABLES.into_iter().enumerate() {
        let start = match (causality, name) {
            ("input", "load") => Some(own.nominal_load),
            ("input", "friction") => Some(own.tyre.reference_friction),
            ("input", _) | ("local", "lagged_slip_angle") => Some(0.0),
            _ => None,
        };
        let more: &[(&str, &str)] = match reference {
            RATE => &[("derivative", "7"), ("initial", "calculated")],
            _ if name == "lagged_slip_angle" => &[("initial", "exact")],
            _ => &[],
        };
        real(xml, reference, [name, causality, "continuous", unit, text], start, more)?;
    }
    let (name, text) = RIDDEN;
    let reference = VARIABLES.len().to_string();
    xml.create_element("Boolean")
        .with_attributes([("name", name), ("valueReference", &reference), ("description", text)])
        .with_attributes([("causality", "output"), ("variability", "discrete")])
        .write_empty()?;
    let ends = Ends::of(tyre);
    for (place, number) in numbers::ALL.iter().enumerate() {
        let value = (number.value)(tyre, &ends);
        let from = origins::of(fitted, tyre, number.name);
        let from = from.map_or(String::new(), |from| format!("; {}", one_line(&from)));
        let meaning = format!("{}{from}", number.meaning);
        let texts = [number.name, "parameter", "tunable", number.unit, meaning.as_str()];
        real(xml, FIRST_NUMBER + place, texts, Some(value), &[])?;
    }
    Ok(())
}

/// A variable of real numbers: name, causality, variability, unit and description.
fn real(
    xml: &mut Xml,
    reference: usize,
    [name, causality, variability, unit, text]: [&str; 5],
    start: Option<f64>,
    more: &[(&str, &str)],
) -> std::io::Result<()> {
    let reference = reference.to_string();
    let mut element = xml
        .create_element("Float64")
        .with_attributes([("name", name), ("valueReference", &reference), ("description", text)])
        .with_attributes([("causality", causality), ("variability", variability)])
        .with_attributes(more.iter().copied());
    if !unit.is_empty() {
        element = element.with_attribute(("unit", unit));
    }
    if let Some(start) = start {
        // the shortest digits that read back to the same number
        element = element.with_attribute(("start", format!("{start:?}").as_str()));
    }
    element.write_empty().map(drop)
}

fn structure(xml: &mut Xml) -> std::io::Result<()> {
    let mut unknown = |kind: &str, reference: usize| {
        let reference = reference.to_string();
        xml.create_element(kind)
            .with_attribute(("valueReference", reference.as_str()))
            .write_empty()
            .map(drop)
    };
    let outputs = FIRST_OUTPUT..=VARIABLES.len();
    for reference in outputs.clone() {
        unknown("Output", reference)?;
    }
    unknown("ContinuousStateDerivative", RATE)?;
    for reference in std::iter::once(RATE).chain(outputs) {
        unknown("InitialUnknown", reference)?;
    }
    Ok(())
}
