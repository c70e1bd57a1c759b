//! Tyre files: `.toml` files of the paper's tyre with what its formulas leave out, and all that [`tir`] reads.
//!
//! ```text
//! nominal_load = 1250.0       # a `Custom`, to whose nominal load changes are relative
//! [tyre]
//! rolling_radius = 0.3        # and so on
//! [effects]                   # by name, each in its unit; none needs to be there
//! friction_load = 0.12        # friction falls by so much with the nominal load once more
//! ```
//!
//! `crown_over_front` beside `nominal_load` is the tyre's width over that of the front one, of which `radius_camber`
//! is said; 1 where it is not there.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::extended_tyre::ExtendedTyre;
use super::{Effect, ModelError};
use crate::contract::bike::Axle;
use crate::contract::file_kind::FileKind;
use crate::contract::key_error::KeyError;
use crate::contract::schema::{refuse_infinite, with_hint};
use crate::store::objects::files::read_text;
use crate::tyre::custom::Custom;
use crate::tyre::tir;
use crate::tyre::tir::Error;
use crate::tyre::tyre_model::TyreModel;

/// Table of the effects.
const EFFECTS: &str = "effects";
/// Key of the width over the front tyre's.
pub(crate) const CROWN: &str = "crown_over_front";

/// A published set by name, or a `.tir` or `.toml` file.
///
/// # Errors
/// See [`Error`].
pub fn load(name_or_path: &str) -> Result<Box<dyn TyreModel>, Error> {
    let path = Path::new(name_or_path);
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        return tir::load(name_or_path);
    }
    let text = read_text(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    parse(&text).map_err(|e| Error::Key { path: path.to_owned(), message: e.to_string() })
}

/// The tyre of a `.toml` file's text.
///
/// # Errors
/// Names the key.
pub fn parse(text: &str) -> Result<Box<dyn TyreModel>, KeyError> {
    FileKind::Tyre.expect(text)?;
    let mut table: toml::Table =
        text.parse().map_err(|e: toml::de::Error| KeyError::Values(e.to_string()))?;
    refuse_infinite(&table)?;
    let (effects, crown) = (table.remove(EFFECTS), table.remove(CROWN));
    if effects.is_none() && crown.is_none() {
        // the text itself: its messages have the line
        let custom: Custom = toml::from_str(text).map_err(|e| with_hint(&e.to_string()))?;
        return Ok(Box::new(custom));
    }
    let custom = Custom::deserialize(table).map_err(|e| with_hint(&e.to_string()))?;
    let error = effects.map_or(Ok(ModelError::default()), sizes)?;
    let crown = match crown {
        None => 1.0,
        Some(toml::Value::Float(ratio)) if (0.1..=10.0).contains(&ratio) => ratio,
        Some(other) => {
            return Err(KeyError::Values(format!(
                "{CROWN} = {other} must be a decimal number, 0.1 to 10"
            )));
        }
    };
    let Some(axle) = Axle::BOTH.into_iter().find(|axle| error.of_tyre(*axle) == error) else {
        return Err(KeyError::Values(
            "[effects]: a tyre has the side-force ratio of one end; remove the other".into(),
        ));
    };
    Ok(extended(custom, &error, axle, crown))
}

/// A tyre of one end with all that is its own: errors of its numbers are put into them.
pub fn extended(
    mut custom: Custom,
    error: &ModelError,
    axle: Axle,
    crown: f64,
) -> Box<dyn TyreModel> {
    let error = error.of_tyre(axle);
    error.put_into(&mut custom.tyre, axle);
    ExtendedTyre::boxed(custom, &error, crown)
}

/// The effects of a table.
fn sizes(table: toml::Value) -> Result<ModelError, KeyError> {
    let fail = |e: String| KeyError::Values(format!("[{EFFECTS}]: {e}"));
    let sizes = BTreeMap::<String, f64>::deserialize(table)
        .map_err(|e| fail(format!("{}; write name = size", e.message())))?;
    let mut error = ModelError::default();
    for (name, size) in sizes {
        let effect = Effect::named(&name).map_err(|e| fail(e.to_string()))?;
        if effect.tyres.is_empty() {
            let enters = effect.enters;
            return Err(fail(format!("`{name}` is no tyre's ({enters}); remove it")));
        }
        effect.check_size(size).map_err(|e| fail(format!("{name}: {e}")))?;
        (effect.set)(&mut error, size);
    }
    Ok(error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::effects::ALL;
    use crate::simulate::scenario::Scenario;
    use crate::tyre::paper::Input;

    fn custom() -> Custom {
        let plant = Scenario::builtin("perfect").expect("scenario").nominal_plant();
        Custom::new(plant.tyres[1], 1250.0)
    }

    fn file(more: &str) -> String {
        // keys of the head come before the first table
        let (head, effects) = more.split_once('|').unwrap_or(("", more));
        format!("{head}\n{}{effects}", toml::to_string(&custom()).expect("text"))
    }

    #[test]
    fn a_file_with_every_effect_of_a_tyre_is_that_tyre() {
        let input =
            |load| Input { slip_ratio: -0.02, slip_angle: 0.01, camber: -0.3, load, friction: 1.0 };
        let plain = parse(&file("")).expect("tyre");
        let all = |t: &dyn TyreModel| {
            let at = |load: f64| {
                let o = t.forces(&input(load));
                let radius = t.rolling_radius(load, 0.05, 30.0);
                let rolling = t.rolling_resistance(&input(load), 30.0);
                let lag = t.relaxation(load, 30.0).lateral;
                [o.force_x, o.force_y, o.moment_x, o.moment_z, radius, rolling, lag]
            };
            [at(600.0), at(2000.0)]
        };
        for effect in ALL.iter().filter(|e| !e.tyres.is_empty()) {
            let size = effect.typical;
            let text = format!("crown_over_front = 1.5|\n[effects]\n{} = {size:?}\n", effect.name);
            let read = parse(&file(&text)).expect("tyre");
            let mut error = ModelError::default();
            (effect.set)(&mut error, size);
            let wanted = extended(custom(), &error, effect.tyres[0], 1.5);
            assert_eq!(all(read.as_ref()), all(wanted.as_ref()), "{}", effect.name);
            assert_ne!(all(read.as_ref()), all(plain.as_ref()), "{}", effect.name);
        }
        // the rear tyre's crown is that much larger
        let text = "crown_over_front = 1.5|\n[effects]\nradius_camber = 0.02\n";
        let smaller = plain.rolling_radius(1250.0, 0.1, 20.0)
            - parse(&file(text)).expect("tyre").rolling_radius(1250.0, 0.1, 20.0);
        assert!((smaller - 0.02 * 1.5 * 0.1).abs() < 1e-15, "{smaller}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let refused = |more: &str| parse(&file(more)).expect_err("refused").to_string();
        for (more, says) in [
            ("\n[effects]\nfriction_laod = 0.1", "did you mean `friction_load`?"),
            (
                "\n[effects]\nfriction_load = 12.0",
                "friction_load: 12 1 is not between -0.3 and 0.6",
            ),
            ("\n[effects]\nfriction_load = \"a\"", "write name = size"),
            ("\n[effects]\nwind = 1.0", "`wind` is no tyre's"),
            (
                "\n[effects]\nside_force_ratio_front = 0.01\nside_force_ratio_rear = 0.01",
                "of one end",
            ),
            ("effects = 3|", "[effects]"),
            ("crown_over_front = 0.0|", "crown_over_front = 0"),
            ("nominal_laod = 3.0\n[effects]|", "nominal_laod"),
            ("nominal_laod = 3.0|", "nominal_laod"),
        ] {
            let message = refused(more);
            assert!(message.contains(says), "{more}: {message}");
        }
    }
}
