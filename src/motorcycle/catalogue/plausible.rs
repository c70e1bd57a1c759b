//! Combinations of numbers that hardly any motorcycle has.

use super::classes::{Class, Usual};
use super::owner::Portrait;

/// So many standard deviations from what is usual of the class are worth a look: an estimate.
const FAR: f64 = 5.0;
/// A front tyre wider than this many rear ones is rather a swapped one; of bicycles some are 1.15 times as wide: an estimate.
const WIDER: f64 = 1.2;

impl Portrait {
    /// Doubts about numbers that are each possible, but hardly together; sentences.
    pub fn doubts(&self) -> Vec<String> {
        let value = |key: &str| self.numbers.iter().find(|n| n.key == key).map(|n| n.known.value);
        let mut out = Vec::new();
        if let Some(mass) = value("mass").filter(|mass| far(*mass, &self.class.mass)) {
            let usual = &self.class.mass;
            out.push(format!(
                "`mass` = {mass:.0} kg with rider, usual is {:.0} ± {:.0} kg of the class {}: check the weight and the class",
                usual.mean, usual.sd, self.class.name
            ));
        }
        if let Some((behind, length)) = value("cg_to_front").zip(value("wheelbase")) {
            let share = 1.0 - behind / length;
            out.extend(far(share, &self.class.front_share).then(|| {
                format!(
                    "{:.0} % of the weight is on the front wheel (`cg_to_front` = {behind:.3} m of `wheelbase` = {length:.3} m), \
                     usual is {}: check both, and that the front wheel is the first of two loads",
                    100.0 * share,
                    usual(self.class, &self.class.front_share)
                )
            }));
        }
        if let Some((height, length)) = value("cg_height").zip(value("wheelbase")) {
            let share = height / length;
            out.extend(far(share, &self.class.height_share).then(|| {
                format!(
                    "the centre of mass is {:.0} % of the wheelbase high (`cg_height` = {height:.3} m, `wheelbase` = {length:.3} m), \
                     usual is {}: check both",
                    100.0 * share,
                    usual(self.class, &self.class.height_share)
                )
            }));
        }
        let [front, rear] = &self.sizes;
        if front.width > WIDER * rear.width {
            out.push(format!(
                "the front tyre ({}) is wider than the rear one ({}): check that they are not swapped",
                front.printed, rear.printed
            ));
        }
        out
    }
}

fn far(share: f64, usual: &Usual) -> bool {
    (share - usual.mean).abs() > FAR * usual.sd
}

fn usual(class: &Class, share: &Usual) -> String {
    format!("{:.0} ± {:.0} % of the class {}", 100.0 * share.mean, 100.0 * share.sd, class.name)
}

#[cfg(test)]
mod tests {
    use super::super::{Catalogue, Owner};
    use crate::contract::bike::schema;

    /// A naked motorcycle with some keys set.
    fn naked(sizes: [&str; 2], keys: &[&str]) -> Owner {
        let sizes = sizes.map(|s| Some(s.to_owned()));
        let mut owner = Owner { class: Some("naked".into()), sizes, ..Owner::default() };
        for key in keys {
            owner.set(key, schema()).expect("a key");
        }
        owner
    }

    const SIZES: [&str; 2] = ["120/70ZR17", "180/55ZR17"];

    #[test]
    fn two_values_of_one_number_are_refused_with_both() {
        let scales = Some([100.0, 170.0]);
        let swung = [Some([5.1, 0.2, 1.3]), None];
        for (owner, parts) in [
            (Owner { weight: Some(200.0), scales, ..naked(SIZES, &[]) }, ["`mass`", "270", "200"]),
            (
                Owner { weight: Some(270.0), ..naked(SIZES, &["mass=300"]) },
                ["`mass`", "270", "300"],
            ),
            (Owner { scales, ..naked(SIZES, &["mass=300"]) }, ["`mass`", "270", "300"]),
            (
                Owner { scales, ..naked(SIZES, &["wheelbase=1.4", "cg_to_front=0.7"]) },
                ["`cg_to_front`", "0.8815", "0.7"],
            ),
            (
                Owner { swung, ..naked(SIZES, &["front.wheel_inertia=2.5"]) },
                ["`front.wheel_inertia`", "swung", "2.5"],
            ),
        ] {
            let e = owner.portrait(Catalogue::builtin()).expect_err("two values").to_string();
            assert!(parts.iter().all(|part| e.contains(part)), "{parts:?}: {e}");
        }
        // the same number twice, and a guess beside a measured one, are none
        let keys = ["mass=270+-1", "cg_height=0.6"];
        let owner = Owner { weight: Some(270.0), scales, ..naked(SIZES, &keys) };
        owner.portrait(Catalogue::builtin()).expect("one value each");
    }

    #[test]
    fn combinations_that_hardly_any_motorcycle_has_are_doubted() {
        let doubts =
            |owner: Owner| owner.portrait(Catalogue::builtin()).expect("possible").doubts();
        assert!(doubts(naked(SIZES, &[])).is_empty());
        for light in ["mass=60", "mass=700"] {
            let said = doubts(naked(SIZES, &[light]));
            assert!(said.len() == 1 && said[0].contains("of the class naked"), "{said:?}");
        }
        assert!(doubts(naked(SIZES, &["mass=180"])).is_empty(), "a small rider on a small bike");
        let swapped = doubts(naked([SIZES[1], SIZES[0]], &[]));
        assert!(swapped.len() == 1 && swapped[0].contains("swapped"), "{swapped:?}");
        let behind = doubts(naked(SIZES, &["cg_to_front=1.40"]));
        assert!(behind.len() == 1 && behind[0].starts_with("2 % of the weight"), "{behind:?}");
        let high = doubts(naked(SIZES, &["cg_height=1.1"]));
        assert!(high.len() == 1 && high[0].contains("`cg_height` = 1.100 m"), "{high:?}");
        for class in &Catalogue::builtin().classes {
            let usual = Owner { class: Some(class.name.clone()), ..Owner::default() };
            assert!(doubts(usual).is_empty(), "{}", class.name);
        }
    }
}
