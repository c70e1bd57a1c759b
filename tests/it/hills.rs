//! Hilly roads: what an altitude is worth, a small version of the study `examples/hills`.

#[path = "../../examples/hills.rs"]
#[allow(dead_code)]
mod study;

use study::{Tallies, median, ridden};

#[test]
fn an_altitude_takes_the_slopes_out_of_drag_and_rolling_resistance() {
    let [blind, seen] = ridden(0.045, 6, 77);
    let error = |of: &Tallies, id: &str| {
        median(&of.get(id).unwrap_or_else(|| panic!("{id} of {:?}", of.keys())).errors)
    };
    for id in ["vehicle rolling_resistance", "vehicle drag"] {
        let [blind, seen] = [&blind, &seen].map(|of| error(of, id));
        println!("{id}: hills {blind:.3}, with altitude {seen:.3}");
        assert!(seen < 0.5 * blind, "{id}: {seen}, without altitude {blind}");
    }
    let (ok, inside) = seen.values().fold((0, 0), |(ok, n), t| (ok + t.ok, n + t.inside));
    assert!(ok >= 15 && inside as f64 >= 0.85 * ok as f64, "{inside} of {ok}");
}
