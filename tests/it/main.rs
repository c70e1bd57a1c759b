#[test]
fn x() {}

mod fit;
