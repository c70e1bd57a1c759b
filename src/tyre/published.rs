//! Published tyre sets (`pipelines/tyres/`), by name.

/// Name and property file of every set.
pub const SETS: &[(&str, &str)] = &[
    ("sharp2004_front_120_70", include_str!("../../pipelines/tyres/sharp2004_front_120_70.tir")),
    ("sharp2004_rear_180_55", include_str!("../../pipelines/tyres/sharp2004_rear_180_55.tir")),
    ("sharp2004_rear_160_70", include_str!("../../pipelines/tyres/sharp2004_rear_160_70.tir")),
    ("mf62_front_120_70", include_str!("../../pipelines/tyres/mf62_front_120_70.tir")),
    ("mf62_rear_190_55", include_str!("../../pipelines/tyres/mf62_rear_190_55.tir")),
    ("sharp1971_front", include_str!("../../pipelines/tyres/sharp1971_front.tir")),
    ("sharp1971_rear", include_str!("../../pipelines/tyres/sharp1971_rear.tir")),
];

/// The text of a set.
pub fn text(name: &str) -> Option<&'static str> {
    SETS.iter().find(|(n, _)| *n == name).map(|(_, t)| *t)
}
