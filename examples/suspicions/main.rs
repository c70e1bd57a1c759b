//! The suspicions that Bartolozzi et al. (2024) voice and do not test, each as a controlled experiment
//! on the multibody motorcycle: with the property, without it, and with it put into the model.
//!
//! ```text
//! cargo run --release --no-default-features --example suspicions -- [nulls load twist camber friction satellite]
//! ```

mod camber;
mod common;
mod friction;
mod load;
mod nulls;
mod satellite;
mod twist;

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let all = wanted.is_empty();
    let studies: [(&str, fn()); 6] = [
        ("nulls", nulls::print),
        ("load", load::print),
        ("twist", twist::print),
        ("camber", camber::print),
        ("friction", friction::print),
        ("satellite", satellite::print),
    ];
    for (name, print) in studies {
        if all || wanted.iter().any(|w| w == name) {
            print();
            println!();
        }
    }
}
