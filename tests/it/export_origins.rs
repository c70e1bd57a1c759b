//! Exports say of every number where it is from: fitted, assumed, or a stand-in.

use std::path::Path;

use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::coefficient::Coefficient as C;
use roadbench::internals::report::export::fitted::Fitted;
use roadbench::internals::report::export::reduced;
use roadbench::internals::report::export::tyre::{Characterised, Setting};
use roadbench::internals::store::tables::rows::Status;

use crate::export::{BIKES, SESSION, here, ridden, roadbench};

/// What the ride did not determine is said in every file that has the number, or forces made of it.
#[test]
fn every_file_says_of_each_number_whether_the_ride_gave_it() {
    let (_folder, out) = ridden();
    let fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    let base = ["export", &out, "--session", SESSION, "--bikes", BIKES, "--tyre", "front"];
    let export = |format: &str| roadbench(&[&base[..], &["--format", format]].concat());
    let poor = fitted.row(Axle::Front, C::MfB).expect("a row");
    assert_eq!(poor.status, Status::PoorlyDetermined, "the test needs one");
    for (format, start) in [
        ("c", "    .{} = "),
        ("csv", "# front: {} "),
        ("tydex", "! front: {} "),
        ("simulator", "# front: {} "),
    ] {
        let text = export(format);
        for (name, says) in [
            ("mf_b", "fitted but POORLY DETERMINED, 95 % "),
            ("mf_d", "fitted, 95 % "),
            ("relaxation_length", "assumed: rule, 95 % "),
            ("side_force_ratio", "assumed: bike file, 95 % "),
            ("slip_stiffness_load", "assumed: usual value, 95 % "),
            ("vertical_stiffness", "assumed: "),
        ] {
            let start = start.replace("{}", name);
            let line = text.lines().find(|l| l.starts_with(&start)).expect(name);
            assert!(line.contains(says), "{format}: {line}");
        }
        assert!(text.contains("front: cornering_stiffness_0 8.873 1/rad (fitted, 95 % "), "{text}");
    }
    assert!(export("simulator").contains("# front: ridden, each by itself: slip ratio -0.41"));
}

/// Of a half that was not ridden nothing is extrapolated: there is no estimated tyre.
#[test]
fn a_file_of_half_a_tyre_extrapolates_no_other_half() {
    let (_folder, out) = ridden();
    let mut fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    for c in &mut fitted.coefficients {
        if c.tyre == "front" && ["mf_b", "mf_c", "mf_d", "mf_e1"].contains(&c.coefficient.as_str())
        {
            c.value = None;
            c.status = Status::NotAvailable;
        }
    }
    let bike = Bike::read(&here(BIKES).join("archive_01.toml")).expect("bike");
    let setting = Setting { bike: Some(&bike), ..Setting::default() };
    let tyre = Characterised::new(&fitted, Axle::Front, &setting).expect("half a tyre");
    let (text, _) = reduced::write(&fitted, &tyre, &setting).expect("a file");
    for key in ["KPUMIN", "KPUMAX", "LONGITUDINAL_STIFFNESS", "PDY1"] {
        let line = text.lines().find(|l| l.starts_with(key)).expect(key);
        assert!(line.contains("placeholder"), "{line}");
    }
    let line = text.lines().find(|l| l.starts_with("ALPMAX")).expect("a range");
    assert!(line.contains("extrapolated beyond as the estimated tyre is"), "{line}");
}
