#[test]
fn x() {}

mod batch;
